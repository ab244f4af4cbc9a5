# SPDX-License-Identifier: Apache-2.0
"""The file as a whole (sections 1 to 3 of docs/blob-format.md): check, sections, and what a payload is read with."""

from __future__ import annotations

import enum
import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]

MAGIC = b"\x89SOAK\r\n\x1a"
MAJOR_VERSION = 1
LAYOUT_VERSION = 1
HEADER_SIZE = 24
SECTION_HEAD_SIZE = 8
CRC_SIZE = 4

MAX_FILE_SIZE = 1_048_576
MAX_SECTIONS = 256


class BlobError(Exception):
    """The file must not be used; the message says why."""


def require(condition: bool, message: str) -> None:
    if not condition:
        raise BlobError(message)


class SectionType(enum.IntEnum):
    """Section types that this reader looks into: all but signatures, which need a key."""

    PROVENANCE = 0x0001
    REFERENCE = 0x0002
    SENSOR = 0x0010
    FIS = 0x0011
    SPLINE = 0x0012
    TABLE = 0x0013
    UNCERTAINTY = 0x0014
    ONE_WAY = 0x0015
    MISALIGNMENT = 0x0020
    G_SENSITIVITY = 0x0021
    TERM = 0x0022
    COUPLINGS = 0x0023
    THERMOMETERS = 0x0024
    GYRO_MISALIGNMENT = 0x0025
    ERROR_BOUND = 0x0030
    TABLE_BOUND = 0x0031


KNOWN_TYPES = frozenset(SectionType)


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


_CRC_TABLE = _crc_table()


def crc32c(data: bytes) -> int:
    crc = 0xFFFFFFFF
    for byte in data:
        crc = (crc >> 8) ^ _CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


class Payload:
    """A section's payload, read from front to back."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def take(self, size: int) -> bytes:
        end = self._at + size
        require(end <= len(self._data), "a section is too short for its counts")
        piece = self._data[self._at:end]
        self._at = end
        return piece

    def integers(self, layout: str) -> tuple[int, ...]:
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)))

    def floats(self, count: int, kind: str = "f") -> Vector:
        layout = f"<{count}{kind}"
        values = struct.unpack(layout, self.take(struct.calcsize(layout)))
        require(all(map(math.isfinite, values)), "a number is not finite")
        return values

    def text(self, size: int) -> str:
        return self.take(size).decode("utf-8", errors="replace")

    def finish(self) -> None:
        require(len(self._data) - self._at < 4, "a section is too long for its counts")


@dataclass(frozen=True)
class Section:
    kind: int
    version: int
    critical: bool
    payload: bytes

    @property
    def known(self) -> bool:
        return self.version == LAYOUT_VERSION and self.kind in KNOWN_TYPES


def _check_envelope(data: bytes) -> None:
    require(data.startswith(MAGIC), "not a Soak calibration file")
    require(len(data) >= HEADER_SIZE + CRC_SIZE, "the file is shorter than its header")
    require(len(data) <= MAX_FILE_SIZE, "the file is too large")
    (stored_crc,) = struct.unpack_from("<I", data, len(data) - CRC_SIZE)
    require(crc32c(data[:-CRC_SIZE]) == stored_crc, "the CRC does not match: the file is damaged")
    major, _minor, size = struct.unpack_from("<HHI", data, 8)
    require(size == len(data), "the file is truncated or has bytes added")
    require(major == MAJOR_VERSION, f"major version {major} is not supported")


def read_sections(data: bytes) -> Iterator[Section]:
    """Check the file as a whole and yield its sections, known or not."""
    _check_envelope(data)
    position, count = struct.unpack_from("<II", data, 16)
    end = len(data) - CRC_SIZE
    require(HEADER_SIZE <= position <= end and position % 4 == 0, "the header size is impossible")
    require(count <= MAX_SECTIONS, "too many sections")
    for _ in range(count):
        require(position + SECTION_HEAD_SIZE <= end, "fewer sections than the header says")
        kind, version, flags, length = struct.unpack_from("<HBBI", data, position)
        position += SECTION_HEAD_SIZE
        require(length % 4 == 0, "a payload length is not a multiple of 4")
        require(length <= end - position, "a section reaches beyond the file")
        yield Section(kind, version, bool(flags & 1), data[position:position + length])
        position += length
    require(position == end, "bytes that no section owns")
