# SPDX-License-Identifier: Apache-2.0
"""The sections that are not curves: what they hold, and how each payload is read."""

from __future__ import annotations

import datetime
import uuid
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from .curves import clamp, require_count, require_rising, require_temperatures, to_float32
from .file import Matrix, Payload, Vector, require

SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
QUANTITIES = ("bias", "scale_ppm")
GYROS = SENSORS[:3]
ACCELS = SENSORS[3:]

MAX_UNCERTAINTY_POINTS = 1024

# The bound as float32 has it: a file that holds the limit itself must pass in every arithmetic.
MAX_MISALIGNMENT = to_float32(0.2)


@dataclass(frozen=True)
class SensorInfo:
    min_temp_c: float
    max_temp_c: float
    model_name: str

    def contains(self, temp_c: float) -> bool:
        return self.min_temp_c <= temp_c <= self.max_temp_c

    def nearest(self, temp_c: float) -> float:
        return clamp(temp_c, self.min_temp_c, self.max_temp_c)


@dataclass(frozen=True)
class UncertaintyTable:
    temps_c: Vector
    ci95: Vector
    pi95: Vector | None
    one_run: bool


WAYS = {1: "up", 2: "down"}
HYSTERESIS_SOURCES = ("none", "type", "fleet")
MAX_ONE_WAY_RANGES = 64


@dataclass(frozen=True)
class OneWay:
    """Temperatures visited one way only: (low, high, way), and half the gap that the bands hold there."""

    ranges: tuple[tuple[float, float, str], ...]
    half_gap: float
    source: str


@dataclass(frozen=True)
class ErrorBound:
    bound: float
    span: float


@dataclass(frozen=True)
class Term:
    name: str
    sensors: tuple[str, ...]
    lab_only: bool
    parameters: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Couplings:
    """Standard uncertainties of the matrices, None where unknown, and (value, uncertainty) of the even-order terms."""

    misalignment: Matrix | None
    g_sensitivity: Matrix | None
    even_order: dict[str, tuple[float, float]]
    readings_only: frozenset[str]


REFERENCE_KINDS = ("chamber_probe", "fixture_squareness", "level", "gravity", "supply", "rate")


@dataclass(frozen=True)
class Waiver:
    identifier: uuid.UUID
    signed_unix_s: float
    public_key: bytes
    signature: bytes
    signer: str
    reason: str


@dataclass(frozen=True)
class Reference:
    kind: str
    name: str
    certificate: str
    standard_uncertainty: float
    correction: float | None
    issued_unix_s: float
    due_unix_s: float
    record: uuid.UUID
    waiver: Waiver | None

    def waiver_text(self) -> bytes:
        """What the signature of the waiver is over, after docs/records.md."""
        def utc(unix_s: float) -> str:
            return datetime.datetime.fromtimestamp(int(unix_s), datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")

        assert self.waiver is not None
        lines = ("soak-waiver-1", f"waiver {self.waiver.identifier}", f"reference {self.record}", f"kind {self.kind}",
                 f"name {self.name}", f"certificate {self.certificate}", f"due {utc(self.due_unix_s)}",
                 f"reason {self.waiver.reason}", f"signer {self.waiver.signer}", f"signed {utc(self.waiver.signed_unix_s)}")
        return "".join(line + "\n" for line in lines).encode()


def interpolate(xs: Vector, ys: Vector, x: float) -> float:
    """Linear between the points, held beyond them."""
    if x <= xs[0]:
        return ys[0]
    if x >= xs[-1]:
        return ys[-1]
    right = bisect_right(xs, x)
    left = right - 1
    return ys[left] + (ys[right] - ys[left]) * (x - xs[left]) / (xs[right] - xs[left])


def _read_half_widths(payload: Payload, count: int) -> Vector:
    values = payload.floats(count)
    require(min(values) >= 0, "a half-width is negative")
    return values


def read_matrix(payload: Payload) -> Matrix:
    return tuple(payload.floats(3) for _ in range(3))


def read_sensor(payload: Payload, name_size: int) -> SensorInfo:
    """The payload from its third field on."""
    payload.integers("H")
    min_temp_c, max_temp_c = payload.floats(2)
    require_temperatures((min_temp_c, max_temp_c))
    require(min_temp_c <= max_temp_c, "the valid range is empty")
    return SensorInfo(min_temp_c, max_temp_c, payload.text(name_size))


def read_uncertainty(payload: Payload) -> UncertaintyTable:
    """The payload behind sensor and quantity."""
    count, flags = payload.integers("HI")
    require_count(count, MAX_UNCERTAINTY_POINTS, "uncertainty points")
    temps_c = payload.floats(count)
    require_temperatures(temps_c)
    require_rising(temps_c)
    ci95 = _read_half_widths(payload, count)
    return UncertaintyTable(temps_c, ci95, _read_half_widths(payload, count) if flags & 1 else None, bool(flags & 2))


def read_one_way(payload: Payload) -> OneWay:
    """The payload behind the sensor."""
    source, count = payload.integers("BH")
    require_count(count, MAX_ONE_WAY_RANGES, "one-way ranges")
    require(source < len(HYSTERESIS_SOURCES), "unknown source of hysteresis")
    (half_gap,) = payload.floats(1)
    require(half_gap >= 0 if source else half_gap == 0, "half a gap that does not belong to its source")
    ranges = []
    for _ in range(count):
        low, high = payload.floats(2)
        (way,) = payload.integers("I")
        require_temperatures((low, high))
        require(low <= high and (not ranges or ranges[-1][1] <= low), "one-way ranges do not rise")
        require(way in WAYS, "unknown way")
        ranges.append((low, high, WAYS[way]))
    return OneWay(tuple(ranges), half_gap, HYSTERESIS_SOURCES[source])


def read_error_bound(payload: Payload) -> ErrorBound:
    """The payload behind sensor and quantity."""
    payload.integers("H")
    bound, span = payload.floats(2)
    require(bound >= 0 and span >= 0, "an error bound or its span is negative")
    return ErrorBound(bound, span)


def read_table_bound(payload: Payload) -> float:
    """The payload behind sensor and quantity."""
    payload.integers("H")
    (bound,) = payload.floats(1)
    require(bound >= 0, "a table's bound is negative")
    return bound


def read_misalignment(payload: Payload) -> Matrix:
    matrix = read_matrix(payload)
    require(all(matrix[i][i] == 0 for i in range(3)), "the misalignment's diagonal is not zero")
    require(all(abs(value) <= MAX_MISALIGNMENT for row in matrix for value in row), "a misalignment is too large")
    return matrix


@dataclass(frozen=True)
class GyroMisalignment:
    matrix: Matrix
    uncertainty: Matrix | None
    readings_only: bool


def read_gyro_misalignment(payload: Payload) -> GyroMisalignment:
    (flags,) = payload.integers("I")
    matrix = read_misalignment(payload)
    uncertainty = _read_uncertainty_matrix(payload) if flags & 1 else None
    require(uncertainty is None or all(uncertainty[i][i] == 0 for i in range(3)), "a diagonal has an uncertainty")
    return GyroMisalignment(matrix, uncertainty, bool(flags & 2))


def read_term(payload: Payload, minor_version: int) -> Term:
    flags, mask, name_size, count = payload.integers("BBBB")
    require(name_size >= 1, "a term's name is empty")
    sensors = tuple(name for bit, name in enumerate(SENSORS) if mask >> bit & 1)
    values = payload.floats(count)
    name = payload.text(name_size)
    names = [payload.text(*payload.integers("B")) for _ in values]
    lab_only = bool(flags & 1)
    if name == "thermal_hysteresis" and not lab_only:
        if minor_version < 7:
            lab_only = True
        else:
            _check_memory(names, values)
    return Term(name, sensors, lab_only, tuple(zip(names, values)))


def _check_memory(names: Sequence[str], values: Sequence[float]) -> None:
    """A width, and the mean as the last parameters, in pairs with rising temperatures."""
    require("width_c" in names and values[names.index("width_c")] > 0, "a memory has no width")
    first = names.index("mean_1_c") if "mean_1_c" in names else len(names)
    pairs = (len(names) - first) // 2
    expected = [part for k in range(1, pairs + 1) for part in (f"mean_{k}_c", f"mean_{k}")]
    require(list(names[first:]) == expected, "the mean of a memory is not in pairs at the end")
    temps_c = values[first::2]
    require(all(a < b for a, b in zip(temps_c, temps_c[1:])), "the temperatures of a mean do not rise")


def _read_uncertainty_matrix(payload: Payload) -> Matrix:
    matrix = read_matrix(payload)
    require(all(value >= 0 for row in matrix for value in row), "a coupling's uncertainty is negative")
    return matrix


def read_couplings(payload: Payload) -> Couplings:
    """Blocks in the order of their numbers, those whose bit is set."""
    (flags,) = payload.integers("I")
    present = [bool(flags >> block & 1) for block in range(5)]
    misalignment = _read_uncertainty_matrix(payload) if present[0] else None
    g_sensitivity = _read_uncertainty_matrix(payload) if present[1] else None
    require(misalignment is None or all(misalignment[i][i] == 0 for i in range(3)), "a diagonal has an uncertainty")
    even_order = {}
    for sensor, there in zip(ACCELS, present[2:]):
        if there:
            value, uncertainty = payload.floats(2)
            require(uncertainty >= 0, "an even-order term's uncertainty is negative")
            even_order[sensor] = (value, uncertainty)
    names = ("misalignment", "g_sensitivity", *ACCELS)
    readings_only = frozenset(name for block, name in enumerate(names) if present[block] and flags >> (8 + block) & 1)
    return Couplings(misalignment, g_sensitivity, even_order, readings_only)


def _read_waiver_head(payload: Payload) -> tuple[uuid.UUID, float, bytes, bytes]:
    return uuid.UUID(bytes=payload.take(16)), payload.floats(1, "d")[0], payload.take(32), payload.take(64)


def read_reference(payload: Payload) -> Reference:
    kind, flags, name_size, certificate_size = payload.integers("BBBB")
    require(kind < len(REFERENCE_KINDS), "unknown kind of reference")
    require(name_size >= 1 and certificate_size >= 1, "a reference without name or certificate")
    uncertainty, correction, issued, due = payload.floats(4, "d")
    require(uncertainty >= 0 and due > issued, "a reference's numbers are impossible")
    record = uuid.UUID(bytes=payload.take(16))
    head = None
    if flags & 2:
        head = _read_waiver_head(payload)
        signer_size, reason_size, _zero = payload.integers("BBH")
        require(signer_size >= 1 and reason_size >= 1, "a waiver without signer or reason")
    name, certificate = payload.text(name_size), payload.text(certificate_size)
    waiver = Waiver(*head, payload.text(signer_size), payload.text(reason_size)) if head else None
    return Reference(REFERENCE_KINDS[kind], name, certificate, uncertainty, correction if flags & 1 else None, issued,
                     due, record, waiver)
