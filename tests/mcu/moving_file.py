#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""moving_file.py IN OUT: a calibration file with effects that soak_apply_moving and soak_apply_history correct (docs/blob-format.md,
0x0022)."""
import struct
import sys

TERM = 0x0022
GYROS, ACCELS = 0b000111, 0b111000
# Sizes as they occur: docs/gap-terms.md has the names.
TERMS = [("temperature_rate", GYROS | ACCELS, {"per_kps": 0.25, "per_kps_per_c": 0.004, "reference_c": 25.0}),
         ("sensor_lag", GYROS | ACCELS, {"factor": 1.0, "tau_s": 75.0}),
         ("cross_axis", 0b001000, {"x": 0.0, "y": 3e-6, "z": -5e-6, "reference_c": 25.0}),
         ("cross_axis", 0b100000, {"x": 2e-6, "y": 7e-6, "z": 0.0, "reference_c": 25.0}),
         ("thermal_hysteresis", GYROS, {"amplitude": 0.003, "amplitude_per_c": 2e-5, "width_c": 12.0, "reference_c": 25.0,
                                        "mean_1_c": -20.0, "mean_1": -0.001, "mean_2_c": 60.0, "mean_2": 0.0015})]


def crc32c(content):
    """RFC 3720: reflected polynomial 0x82F63B78."""
    value = 0xFFFFFFFF
    for byte in content:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
    return value ^ 0xFFFFFFFF


def section(name, sensors, parameters):
    payload = struct.pack("<BBBB", 0, sensors, len(name), len(parameters))
    payload += struct.pack(f"<{len(parameters)}f", *parameters.values()) + name.encode()
    payload += b"".join(bytes([len(key)]) + key.encode() for key in parameters)
    payload += bytes(-len(payload) % 4)
    return struct.pack("<HBBI", TERM, 1, 0, len(payload)) + payload


def main():
    with open(sys.argv[1], "rb") as source:
        content = bytearray(source.read()[:-4])
    for term in TERMS:
        content += section(*term)
    count, = struct.unpack_from("<I", content, 20)
    struct.pack_into("<H", content, 10, 7)
    struct.pack_into("<I", content, 12, len(content) + 4)
    struct.pack_into("<I", content, 20, count + len(TERMS))
    with open(sys.argv[2], "wb") as target:
        target.write(content + struct.pack("<I", crc32c(content)))


if __name__ == "__main__":
    main()
