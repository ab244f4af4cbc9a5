# SPDX-License-Identifier: Apache-2.0
"""The digest of a run's rows in the catalog, written from docs/file-formats.md alone."""
import hashlib
import struct

RUN = ("run_id unit campaign label procedure purpose epoch created_utc_s clock_rate simulated sealed file_name file_sha256 content_sha256 "
       "latitude_deg height_m azimuth_deg gravity_mps2 row_count duration_s cut_short continues").split()
KEYS = {"run": [], "segment": ["visit", "position", "attempt"], "block": ["visit", "position", "attempt", "ordinal"],
        "finding": ["visit", "position", "attempt", "ordinal"]}


def value_bytes(value):
    if value is None:
        return b"n" + bytes(8)
    if isinstance(value, int):
        return b"i" + struct.pack("<q", value)
    if isinstance(value, float):
        return b"f" + struct.pack("<d", value)
    text = value.encode()
    return b"t" + struct.pack("<Q", len(text)) + text


def run_digest(catalog, run_id, unit):
    digest = hashlib.sha256()
    for table, key in KEYS.items():
        columns = RUN if table == "run" else [row[1] for row in catalog.execute(f"PRAGMA table_info({table})")]
        order = " ORDER BY " + ", ".join(key) if key else ""
        digest.update(table.encode())
        for row in catalog.execute(f"SELECT {', '.join(columns)} FROM {table} WHERE run_id = ? AND unit = ?{order}", (run_id, unit)):
            digest.update(b"".join(map(value_bytes, row)) + b"r" + bytes(8))
    return digest.hexdigest()
