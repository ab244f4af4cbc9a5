# SPDX-License-Identifier: Apache-2.0
"""Reader of Soak calibration files (version 1), written from docs/blob-format.md alone.

It shares no code with the writer or the runtime, so an agreement between them is evidence for the specification.
Everything is computed in double precision from the float32 numbers of the file, at the temperature rounded to float32.
"""

from __future__ import annotations

import datetime
import enum
import math
import struct
import uuid
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
QUANTITIES = ("bias", "scale_ppm")
GYROS = SENSORS[:3]
ACCELS = SENSORS[3:]

MAGIC = b"\x89SOAK\r\n\x1a"
MAJOR_VERSION = 1
LAYOUT_VERSION = 1
HEADER_SIZE = 24
SECTION_HEAD_SIZE = 8
CRC_SIZE = 4

MAX_FILE_SIZE = 1_048_576
MAX_SECTIONS = 256
MAX_RULES = 64
MAX_PIECES = 1024
MAX_TABLE_POINTS = 4096
MAX_UNCERTAINTY_POINTS = 1024
MAX_RUN_HASHES = 4096
MAX_TERMS = 32
MAX_REFERENCES = 64

MIN_TEMP_C = -273.15
MAX_TEMP_C = 1000.0
MAX_RULE_CENTRE_C = 10_000.0
MAX_SCALE_PPM = 500_000.0

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]
CurveKey = tuple[str, str]


def to_float32(value: float) -> float:
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


# The bound as float32 has it: a file that holds the limit itself must pass in every arithmetic.
MAX_MISALIGNMENT = to_float32(0.2)


class BlobError(Exception):
    """The file must not be used; the message says why."""


class SectionType(enum.IntEnum):
    """Section types that this reader looks into: those of version 1.0, and references of 1.2."""

    PROVENANCE = 0x0001
    REFERENCE = 0x0002
    SENSOR = 0x0010
    FIS = 0x0011
    SPLINE = 0x0012
    TABLE = 0x0013
    UNCERTAINTY = 0x0014
    MISALIGNMENT = 0x0020
    G_SENSITIVITY = 0x0021
    TERM = 0x0022
    ERROR_BOUND = 0x0030


KNOWN_TYPES = frozenset(SectionType)


class SensorFlag(enum.Flag):
    """What the caller of Calibration.apply has to know about one sensor's output."""

    NONE = 0
    ABSENT = enum.auto()
    NO_TEMPERATURE = enum.auto()
    OUT_OF_RANGE = enum.auto()
    SCALE_UNKNOWN = enum.auto()
    SCALE_IMPLAUSIBLE = enum.auto()
    NOT_FINITE = enum.auto()  # the raw value, a curve or the corrected value


LEFT_OUT = SensorFlag.NO_TEMPERATURE | SensorFlag.SCALE_IMPLAUSIBLE | SensorFlag.NOT_FINITE
UNCORRECTED = SensorFlag.ABSENT | LEFT_OUT


def require(condition: bool, message: str) -> None:
    if not condition:
        raise BlobError(message)


def clamp(value: float, low: float, high: float) -> float:
    return max(low, min(high, value))


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


def _require_count(count: int, limit: int, what: str) -> None:
    require(1 <= count <= limit, f"the number of {what} must be 1 to {limit}")


def _require_temperatures(values: Sequence[float]) -> None:
    require(all(MIN_TEMP_C <= value <= MAX_TEMP_C for value in values), "a temperature is impossible")


def _require_rising(values: Sequence[float]) -> None:
    require(all(left < right for left, right in zip(values, values[1:])), "temperatures do not rise")


@dataclass(frozen=True)
class Curve:
    """A curve centre + half_range * shape(T), held outside [low, high]."""

    low: float
    high: float
    centre: float
    half_range: float

    def __post_init__(self) -> None:
        require(self.low <= self.high, "a curve's domain is empty")
        require(self.half_range > 0, "a curve's half range is not positive")

    def shape(self, temp_c: float) -> float:
        raise NotImplementedError

    def value(self, temp_c: float) -> float:
        return self.centre + self.half_range * self.shape(clamp(temp_c, self.low, self.high))


@dataclass(frozen=True)
class Rule:
    centre: float
    centre_rest: float
    width: float
    steepness: float
    consequent: float
    gain: float

    def distance(self, temp_c: float) -> float:
        return (temp_c - self.centre) - self.centre_rest

    def normalised(self, temp_c: float) -> float:
        return self.distance(temp_c) / self.width

    def output(self, temp_c: float) -> float:
        return self.consequent + self.gain * self.distance(temp_c)


def bell(rule: Rule, temp_c: float) -> float:
    try:
        return 1.0 / (1.0 + abs(rule.normalised(temp_c)) ** (2.0 * rule.steepness))
    except OverflowError:
        return 0.0


def gaussian(rule: Rule, temp_c: float) -> float:
    return math.exp(-rule.normalised(temp_c) ** 2 / 2.0)


MEMBERSHIPS: tuple[Callable[[Rule, float], float], ...] = (bell, gaussian)


@dataclass(frozen=True)
class FisCurve(Curve):
    membership: Callable[[Rule, float], float]
    rules: tuple[Rule, ...]

    def shape(self, temp_c: float) -> float:
        strengths = [self.membership(rule, temp_c) for rule in self.rules]
        total = sum(strengths)
        if total == 0.0:
            return min(self.rules, key=lambda rule: abs(rule.normalised(temp_c))).output(temp_c)
        return sum(mu * rule.output(temp_c) for mu, rule in zip(strengths, self.rules)) / total


@dataclass(frozen=True)
class SplineCurve(Curve):
    knots: Vector
    pieces: Matrix

    def shape(self, temp_c: float) -> float:
        index = min(bisect_right(self.knots, temp_c), len(self.pieces)) - 1
        left, right = self.knots[index], self.knots[index + 1]
        s = (2.0 * temp_c - left - right) / (right - left)
        q0, q1, q2, q3 = self.pieces[index]
        return q0 + s * (q1 + s * (q2 + s * q3))


@dataclass(frozen=True)
class TableCurve(Curve):
    step: float
    values: Vector

    def shape(self, temp_c: float) -> float:
        if len(self.values) == 1:
            return self.values[0]
        steps = (temp_c - self.low) / self.step
        index = min(int(steps), len(self.values) - 2)
        left, right = self.values[index:index + 2]
        return left + (right - left) * (temp_c - self.low - index * self.step) / self.step


def _read_rule(payload: Payload, is_bell: bool, order: int) -> Rule:
    centre, centre_rest, width, steepness, consequent, gain = payload.floats(6)
    require(max(abs(centre), abs(centre_rest)) <= MAX_RULE_CENTRE_C, "a rule's centre is too far off")
    require(width > 0, "a rule's width is not positive")
    require(steepness > 0 or not is_bell, "a bell's slope is not positive")
    require(gain == 0 or order == 1, "a consequent of order 0 has a slope")
    return Rule(centre, centre_rest, width, steepness, consequent, gain)


def _read_fis(payload: Payload) -> Curve:
    membership, order, count, _zero = payload.integers("BBHH")
    require(membership < len(MEMBERSHIPS), "unknown membership function")
    require(order <= 1, "unknown order of consequents")
    _require_count(count, MAX_RULES, "rules")
    low, high, centre, half_range = payload.floats(4)
    shape = MEMBERSHIPS[membership]
    rules = tuple(_read_rule(payload, shape is bell, order) for _ in range(count))
    return FisCurve(low, high, centre, half_range, shape, rules)


def _read_spline(payload: Payload) -> Curve:
    (count,) = payload.integers("H")
    _require_count(count, MAX_PIECES, "spline pieces")
    centre, half_range = payload.floats(2)
    knots = payload.floats(count + 1)
    _require_temperatures(knots)
    _require_rising(knots)
    pieces = tuple(payload.floats(4) for _ in range(count))
    return SplineCurve(knots[0], knots[-1], centre, half_range, knots, pieces)


def _read_table(payload: Payload) -> Curve:
    (count,) = payload.integers("H")
    _require_count(count, MAX_TABLE_POINTS, "table points")
    centre, half_range, first, step = payload.floats(4)
    require(step > 0, "a table's step is not positive")
    _require_temperatures((first,))
    require(to_float32((count - 1) * step) <= to_float32(MAX_TEMP_C - first), "a table ends beyond 1000 °C")
    return TableCurve(first, first + (count - 1) * step, centre, half_range, step, payload.floats(count))


CURVE_READERS: dict[int, Callable[[Payload], Curve]] = {
    SectionType.FIS: _read_fis,
    SectionType.SPLINE: _read_spline,
    SectionType.TABLE: _read_table,
}


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


def _read_matrix(payload: Payload) -> Matrix:
    return tuple(payload.floats(3) for _ in range(3))


def with_diagonal(rows: Sequence[Vector], diagonal: Sequence[float]) -> Matrix:
    return tuple((*row[:i], diagonal[i], *row[i + 1:]) for i, row in enumerate(rows))


def solve(matrix: Matrix, right_side: Sequence[float]) -> list[float]:
    """Gaussian elimination; needs no pivots because the matrix is strictly diagonally dominant."""
    rows = [[*row, value] for row, value in zip(matrix, right_side)]
    size = len(rows)
    for pivot in range(size):
        for row in rows[pivot + 1:]:
            factor = row[pivot] / rows[pivot][pivot]
            for column in range(pivot, size + 1):
                row[column] -= factor * rows[pivot][column]
    solution = [0.0] * size
    for index in reversed(range(size)):
        known = sum(rows[index][column] * solution[column] for column in range(index + 1, size))
        solution[index] = (rows[index][size] - known) / rows[index][index]
    return solution


class Calibration:
    """What one calibration file says about one inertial unit."""

    epoch: int
    model_version: int
    created_unix_s: float
    gravity: float
    simulated: bool
    gravity_assumed: bool
    run_hashes: tuple[bytes, ...]
    serial: str
    unit_type: str

    def __init__(self) -> None:
        self.sensor_info: dict[str, SensorInfo] = {}
        self.curves: dict[CurveKey, Curve] = {}
        self.uncertainties: dict[CurveKey, UncertaintyTable] = {}
        self.error_bounds: dict[CurveKey, ErrorBound] = {}
        self.misalignment: Matrix | None = None
        self.g_sensitivity: Matrix | None = None
        self.terms: list[Term] = []
        self.references: list[Reference] = []

    @classmethod
    def load(cls, data: bytes) -> Calibration:
        """Read a whole file; raise BlobError if the specification forbids its use."""
        calibration = cls()
        sections = list(read_sections(data))
        require(bool(sections) and sections[0].known and sections[0].kind == SectionType.PROVENANCE,
                "the first section is not the provenance")
        calibration._read_provenance(Payload(sections[0].payload))
        for section in sections[1:]:
            calibration._read_section(section)
        calibration._check_complete()
        return calibration

    @property
    def sensors(self) -> list[str]:
        """The sensors that the file has curves for, in the order of their numbers."""
        return [name for name in SENSORS if name in self.sensor_info]

    def bias(self, sensor: str, temp_c: float) -> tuple[float, bool]:
        """Bias in rad/s or m/s² and whether the temperature is in range; NaN if it is not finite."""
        value, in_range = self._evaluate(sensor, "bias", temp_c)
        return (math.nan if value is None else value), in_range

    def scale_ppm(self, sensor: str, temp_c: float) -> tuple[float | None, bool]:
        """Scale factor error, None where unknown, and whether the temperature is in range."""
        return self._evaluate(sensor, "scale_ppm", temp_c)

    def uncertainty(self, sensor: str, quantity: str, temp_c: float) -> tuple[float | None, float | None, bool]:
        """Half-widths ci95 and pi95, None where unknown, and whether the temperature is in range."""
        temp_c = to_float32(temp_c)
        info = self.sensor_info[sensor]
        table = self.uncertainties.get((sensor, quantity))
        if table is None or not math.isfinite(temp_c):
            return None, None, info.contains(temp_c)
        nearest = info.nearest(temp_c)
        ci95 = interpolate(table.temps_c, table.ci95, nearest)
        pi95 = None if table.pi95 is None else interpolate(table.temps_c, table.pi95, nearest)
        return ci95, pi95, info.contains(temp_c)

    def apply(self, temp_c: float, raw6: Sequence[float]) -> tuple[list[float], list[SensorFlag]]:
        """Correct one sample, gyros (rad/s) then accelerometers (m/s²); one flag value for each of the six."""
        raw = dict(zip(SENSORS, raw6, strict=True))
        flags = {sensor: self._flags(sensor, temp_c, raw[sensor]) for sensor in SENSORS}
        out = dict(raw)

        def take(sensor: str, value: float) -> None:
            if flags[sensor] & UNCORRECTED:
                return
            if math.isfinite(value):
                out[sensor] = value
            else:
                flags[sensor] |= SensorFlag.NOT_FINITE

        for sensor, value in zip(ACCELS, self._specific_force(temp_c, raw, flags)):
            take(sensor, value)
        force = [0.0 if flags[sensor] & LEFT_OUT else out[sensor] for sensor in ACCELS]
        for sensor in GYROS:
            if not flags[sensor] & UNCORRECTED:
                take(sensor, self._rate(sensor, temp_c, raw[sensor], force))
        return list(out.values()), list(flags.values())

    def _evaluate(self, sensor: str, quantity: str, temp_c: float) -> tuple[float | None, bool]:
        temp_c = to_float32(temp_c)
        info = self.sensor_info[sensor]
        curve = self.curves.get((sensor, quantity))
        if curve is None or not math.isfinite(temp_c):
            return None, info.contains(temp_c)
        return curve.value(info.nearest(temp_c)), info.contains(temp_c)

    def _flags(self, sensor: str, temp_c: float, raw: float) -> SensorFlag:
        flags = SensorFlag.NONE if math.isfinite(raw) else SensorFlag.NOT_FINITE
        if not math.isfinite(to_float32(temp_c)):
            flags |= SensorFlag.NO_TEMPERATURE
        if sensor not in self.sensor_info:
            return flags | SensorFlag.ABSENT
        if flags & SensorFlag.NO_TEMPERATURE:
            return flags
        scale, in_range = self.scale_ppm(sensor, temp_c)
        if not math.isfinite(self.bias(sensor, temp_c)[0]) or not math.isfinite(scale or 0.0):
            flags |= SensorFlag.NOT_FINITE
        if not in_range:
            flags |= SensorFlag.OUT_OF_RANGE
        if scale is None:
            flags |= SensorFlag.SCALE_UNKNOWN
        elif abs(scale) > MAX_SCALE_PPM:
            flags |= SensorFlag.SCALE_IMPLAUSIBLE
        return flags

    def _gain(self, sensor: str, temp_c: float) -> float:
        return 1.0 + (self.scale_ppm(sensor, temp_c)[0] or 0.0) * 1e-6

    def _unbiased(self, sensor: str, temp_c: float, raw: float) -> float:
        return raw - self.bias(sensor, temp_c)[0]

    def _specific_force(self, temp_c: float, raw: dict[str, float], flags: dict[str, SensorFlag]) -> list[float]:
        """Of the corrected accelerometers; raw of those that are not in the file, 0 of those left out."""
        corrected = [not flags[name] & UNCORRECTED for name in ACCELS]
        known = [not flags[name] & LEFT_OUT for name in ACCELS]
        unbiased = [self._unbiased(name, temp_c, raw[name]) if good else raw[name] if there else 0.0
                    for name, good, there in zip(ACCELS, corrected, known)]
        gains = [self._gain(name, temp_c) if good else 1.0 for name, good in zip(ACCELS, corrected)]
        if self.misalignment is None:
            return [value / gain for value, gain in zip(unbiased, gains)]
        cross = [tuple(value if good and there else 0.0 for value, there in zip(row, known))
                 for row, good in zip(self.misalignment, corrected)]
        return solve(with_diagonal(cross, gains), unbiased)

    def _rate(self, sensor: str, temp_c: float, raw: float, force: list[float]) -> float:
        rate = self._unbiased(sensor, temp_c, raw)
        if self.g_sensitivity is not None:
            row = self.g_sensitivity[GYROS.index(sensor)]
            rate -= sum(per_force * component for per_force, component in zip(row, force))
        return rate / self._gain(sensor, temp_c)

    def _read_section(self, section: Section) -> None:
        require(section.kind != 0, "section type 0 is not allowed")
        if not section.known:
            require(not section.critical, f"unknown critical section 0x{section.kind:04x} version {section.version}")
            return
        payload = Payload(section.payload)
        if section.kind in CURVE_READERS:
            self._read_curve(payload, CURVE_READERS[section.kind])
        elif section.kind == SectionType.SENSOR:
            self._read_sensor(payload)
        elif section.kind == SectionType.UNCERTAINTY:
            self._read_uncertainty(payload)
        elif section.kind == SectionType.MISALIGNMENT:
            self._read_misalignment(payload)
        elif section.kind == SectionType.G_SENSITIVITY:
            self._read_g_sensitivity(payload)
        elif section.kind == SectionType.TERM:
            self._read_term(payload)
        elif section.kind == SectionType.ERROR_BOUND:
            self._read_error_bound(payload)
        elif section.kind == SectionType.REFERENCE:
            self._read_reference(payload)
        else:
            raise BlobError("a second provenance section")
        payload.finish()

    def _read_provenance(self, payload: Payload) -> None:
        self.epoch, self.model_version = payload.integers("ii")
        self.created_unix_s, self.gravity = payload.floats(2, "d")
        flags, hash_count, serial_size, type_size = payload.integers("IHBB")
        require(hash_count <= MAX_RUN_HASHES, "too many run hashes")
        require(serial_size >= 1, "the serial number is empty")
        self.simulated = bool(flags & 1)
        self.gravity_assumed = bool(flags & 2)
        self.run_hashes = tuple(payload.take(32) for _ in range(hash_count))
        self.serial = payload.text(serial_size)
        self.unit_type = payload.text(type_size)
        payload.finish()

    def _read_sensor(self, payload: Payload) -> None:
        number, name_size, _zero = payload.integers("BBH")
        require(number < len(SENSORS), "unknown sensor")
        sensor = SENSORS[number]
        require(sensor not in self.sensor_info, f"two sections for {sensor}")
        min_temp_c, max_temp_c = payload.floats(2)
        _require_temperatures((min_temp_c, max_temp_c))
        require(min_temp_c <= max_temp_c, "the valid range is empty")
        self.sensor_info[sensor] = SensorInfo(min_temp_c, max_temp_c, payload.text(name_size))

    def _known_sensor(self, number: int) -> str:
        require(number < len(SENSORS) and SENSORS[number] in self.sensor_info,
                f"sensor {number} is named before its own section")
        return SENSORS[number]

    def _read_key(self, payload: Payload) -> CurveKey:
        sensor, quantity = payload.integers("BB")
        require(quantity < len(QUANTITIES), "unknown quantity")
        return self._known_sensor(sensor), QUANTITIES[quantity]

    def _read_curve(self, payload: Payload, read: Callable[[Payload], Curve]) -> None:
        key = self._read_key(payload)
        require(key not in self.curves, f"two curves for {key}")
        self.curves[key] = read(payload)

    def _read_uncertainty(self, payload: Payload) -> None:
        key = self._read_key(payload)
        require(key not in self.uncertainties, f"two uncertainty tables for {key}")
        count, flags = payload.integers("HI")
        _require_count(count, MAX_UNCERTAINTY_POINTS, "uncertainty points")
        temps_c = payload.floats(count)
        _require_temperatures(temps_c)
        _require_rising(temps_c)
        ci95 = _read_half_widths(payload, count)
        pi95 = _read_half_widths(payload, count) if flags & 1 else None
        self.uncertainties[key] = UncertaintyTable(temps_c, ci95, pi95)

    def _read_misalignment(self, payload: Payload) -> None:
        require(self.misalignment is None, "two misalignment sections")
        matrix = _read_matrix(payload)
        require(all(matrix[i][i] == 0 for i in range(3)), "the misalignment's diagonal is not zero")
        require(all(abs(value) <= MAX_MISALIGNMENT for row in matrix for value in row), "a misalignment is too large")
        self.misalignment = matrix

    def _read_g_sensitivity(self, payload: Payload) -> None:
        require(self.g_sensitivity is None, "two g-sensitivity sections")
        self.g_sensitivity = _read_matrix(payload)

    def _read_term(self, payload: Payload) -> None:
        require(len(self.terms) < MAX_TERMS, "too many accepted terms")
        flags, mask, name_size, count = payload.integers("BBBB")
        require(name_size >= 1, "a term's name is empty")
        sensors = tuple(name for bit, name in enumerate(SENSORS) if mask >> bit & 1)
        values = payload.floats(count)
        name = payload.text(name_size)
        names = [payload.text(*payload.integers("B")) for _ in values]
        self.terms.append(Term(name, sensors, bool(flags & 1), tuple(zip(names, values))))

    def _read_error_bound(self, payload: Payload) -> None:
        key = self._read_key(payload)
        require(key not in self.error_bounds, f"two error bounds for {key}")
        payload.integers("H")
        bound, span = payload.floats(2)
        require(bound >= 0 and span >= 0, "an error bound or its span is negative")
        self.error_bounds[key] = ErrorBound(bound, span)

    def _read_reference(self, payload: Payload) -> None:
        require(len(self.references) < MAX_REFERENCES, "too many references")
        kind, flags, name_size, certificate_size = payload.integers("BBBB")
        require(kind < len(REFERENCE_KINDS), "unknown kind of reference")
        require(name_size >= 1 and certificate_size >= 1, "a reference without name or certificate")
        uncertainty, correction, issued, due = payload.floats(4, "d")
        require(uncertainty >= 0 and due > issued, "a reference's numbers are impossible")
        record = uuid.UUID(bytes=payload.take(16))
        head = None
        if flags & 2:
            head = (uuid.UUID(bytes=payload.take(16)), payload.floats(1, "d")[0], payload.take(32), payload.take(64))
            signer_size, reason_size, _zero = payload.integers("BBH")
            require(signer_size >= 1 and reason_size >= 1, "a waiver without signer or reason")
        name, certificate = payload.text(name_size), payload.text(certificate_size)
        waiver = Waiver(*head, payload.text(signer_size), payload.text(reason_size)) if head else None
        self.references.append(Reference(REFERENCE_KINDS[kind], name, certificate, uncertainty,
                                         correction if flags & 1 else None, issued, due, record, waiver))

    def _check_complete(self) -> None:
        require(bool(self.sensor_info), "the file has no sensor")
        for sensor in self.sensors:
            require((sensor, "bias") in self.curves, f"{sensor} has no bias curve")
        for key in self.uncertainties:
            require(key in self.curves, f"an uncertainty without a curve: {key}")
