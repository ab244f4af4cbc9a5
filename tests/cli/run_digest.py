# SPDX-License-Identifier: Apache-2.0
"""Digests of the catalog, written from docs/file-formats.md alone: of a run's rows, seals of tables, the chain of events."""
import hashlib
import sqlite3
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


def soak_seal(seal, table, *values):
    """The function by which the catalog's triggers keep the seals of tables."""
    row = hashlib.sha256(b"".join(map(value_bytes, (table, *values)))).digest()
    return bytes(a ^ b for a, b in zip(bytes.fromhex(seal), row)).hex()


def open_catalog(path):
    """A connection that may write where it has dropped the triggers that forbid it; the seals stay right."""
    catalog = sqlite3.connect(path)
    catalog.create_function("soak_seal", -1, soak_seal, deterministic=True)
    return catalog


def seal_of(catalog, table):
    """Number of rows and seal of a table as it is."""
    seal, count = "00" * 32, 0
    for row in catalog.execute(f"SELECT * FROM {table}"):
        seal, count = soak_seal(seal, table, *row), count + 1
    return count, seal


def chain_of(catalog):
    """The chain value of each event, in order."""
    chain, found = "", []
    columns = "ordinal, event_id, utc_s, kind, subject, text, user"
    for row in catalog.execute(f"SELECT {columns} FROM event ORDER BY ordinal"):
        chain = hashlib.sha256(b"".join(map(value_bytes, (chain, *row)))).hexdigest()
        found.append(chain)
    return found
