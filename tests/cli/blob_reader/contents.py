# SPDX-License-Identifier: Apache-2.0
"""A whole file, section by section."""

from __future__ import annotations

from collections.abc import Callable

from . import records
from .curves import CURVE_READERS, Curve, TableCurve
from .file import BlobError, Matrix, Payload, Section, SectionType, read_sections, require
from .records import QUANTITIES, SENSORS

MAX_RUN_HASHES = 4096
MAX_TERMS = 32
MAX_REFERENCES = 160

CurveKey = tuple[str, str]


class Contents:
    """What the sections of one calibration file say."""

    epoch: int
    model_version: int
    created_unix_s: float
    gravity: float
    simulated: bool
    unreleased: bool
    gravity_assumed: bool
    run_hashes: tuple[bytes, ...]
    serial: str
    unit_type: str

    def __init__(self, data: bytes) -> None:
        """Read a whole file; raise BlobError if the specification forbids its use."""
        self.sensor_info: dict[str, records.SensorInfo] = {}
        self.curves: dict[CurveKey, Curve] = {}
        self.uncertainties: dict[CurveKey, records.UncertaintyTable] = {}
        self.one_way: dict[str, records.OneWay] = {}
        self.error_bounds: dict[CurveKey, records.ErrorBound] = {}
        self.table_bounds: dict[CurveKey, float] = {}
        self.misalignment: Matrix | None = None
        self.g_sensitivity: Matrix | None = None
        self.gyro_misalignment: records.GyroMisalignment | None = None
        self.couplings: records.Couplings | None = None
        self._thermometers: int | None = None
        self.terms: list[records.Term] = []
        self.references: list[records.Reference] = []
        sections = list(read_sections(data))
        self._minor_version = int.from_bytes(data[10:12], "little")
        require(bool(sections) and sections[0].known and sections[0].kind == SectionType.PROVENANCE,
                "the first section is not the provenance")
        self._read_provenance(Payload(sections[0].payload))
        for section in sections[1:]:
            self._read_section(section)
        self._check_complete()

    @property
    def sensors(self) -> list[str]:
        """The sensors that the file has curves for, in the order of their numbers."""
        return [name for name in SENSORS if name in self.sensor_info]

    @property
    def own_thermometers(self) -> list[str]:
        """The sensors of the file whose temperatures are of thermometers of their own."""
        return [name for name in self.sensors if (self._thermometers or 0) >> SENSORS.index(name) & 1]

    def _read_section(self, section: Section) -> None:
        require(section.kind != 0, "section type 0 is not allowed")
        if not section.known:
            require(not section.critical, f"unknown critical section 0x{section.kind:04x} version {section.version}")
            return
        payload = Payload(section.payload)
        if section.kind in CURVE_READERS:
            self._read_curve(payload, CURVE_READERS[section.kind])
        else:
            self._readers()[section.kind](payload)
        payload.finish()

    def _readers(self) -> dict[int, Callable[[Payload], None]]:
        return {SectionType.PROVENANCE: self._refuse_second_provenance,
                SectionType.REFERENCE: self._read_reference,
                SectionType.SENSOR: self._read_sensor,
                SectionType.UNCERTAINTY: self._read_uncertainty,
                SectionType.ONE_WAY: self._read_one_way,
                SectionType.MISALIGNMENT: self._read_misalignment,
                SectionType.G_SENSITIVITY: self._read_g_sensitivity,
                SectionType.TERM: self._read_term,
                SectionType.COUPLINGS: self._read_couplings,
                SectionType.THERMOMETERS: self._read_thermometers,
                SectionType.GYRO_MISALIGNMENT: self._read_gyro_misalignment,
                SectionType.ERROR_BOUND: self._read_error_bound,
                SectionType.TABLE_BOUND: self._read_table_bound}

    def _read_provenance(self, payload: Payload) -> None:
        self.epoch, self.model_version = payload.integers("ii")
        self.created_unix_s, self.gravity = payload.floats(2, "d")
        flags, hash_count, serial_size, type_size = payload.integers("IHBB")
        require(hash_count <= MAX_RUN_HASHES, "too many run hashes")
        require(serial_size >= 1, "the serial number is empty")
        self.simulated = bool(flags & 1)
        self.gravity_assumed = bool(flags & 2)
        self.unreleased = bool(flags & 4)
        self.run_hashes = tuple(payload.take(32) for _ in range(hash_count))
        self.serial = payload.text(serial_size)
        self.unit_type = payload.text(type_size)
        payload.finish()

    def _refuse_second_provenance(self, _payload: Payload) -> None:
        raise BlobError("a second provenance section")

    def _read_reference(self, payload: Payload) -> None:
        require(len(self.references) < MAX_REFERENCES, "too many references")
        self.references.append(records.read_reference(payload))

    def _read_sensor(self, payload: Payload) -> None:
        number, name_size = payload.integers("BB")
        require(number < len(SENSORS), "unknown sensor")
        sensor = SENSORS[number]
        require(sensor not in self.sensor_info, f"two sections for {sensor}")
        self.sensor_info[sensor] = records.read_sensor(payload, name_size)

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
        self.uncertainties[key] = records.read_uncertainty(payload)

    def _read_one_way(self, payload: Payload) -> None:
        sensor = self._known_sensor(*payload.integers("B"))
        require(sensor not in self.one_way, f"two sections of one-way temperatures for {sensor}")
        self.one_way[sensor] = records.read_one_way(payload)

    def _read_misalignment(self, payload: Payload) -> None:
        require(self.misalignment is None, "two misalignment sections")
        self.misalignment = records.read_misalignment(payload)

    def _read_g_sensitivity(self, payload: Payload) -> None:
        require(self.g_sensitivity is None, "two g-sensitivity sections")
        self.g_sensitivity = records.read_matrix(payload)

    def _read_term(self, payload: Payload) -> None:
        require(len(self.terms) < MAX_TERMS, "too many accepted terms")
        self.terms.append(records.read_term(payload, self._minor_version))

    def _read_couplings(self, payload: Payload) -> None:
        require(self.couplings is None, "two sections of couplings")
        self.couplings = records.read_couplings(payload)
        require(self.couplings.misalignment is None or self.misalignment is not None, "an uncertainty of no misalignment")
        require(self.couplings.g_sensitivity is None or self.g_sensitivity is not None,
                "an uncertainty of no g-sensitivity")

    def _read_thermometers(self, payload: Payload) -> None:
        require(self._thermometers is None, "two sections of thermometers")
        (self._thermometers,) = payload.integers("I")

    def _read_gyro_misalignment(self, payload: Payload) -> None:
        require(self.gyro_misalignment is None, "two sections of the gyros' misalignment")
        self.gyro_misalignment = records.read_gyro_misalignment(payload)

    def _read_error_bound(self, payload: Payload) -> None:
        key = self._read_key(payload)
        require(key not in self.error_bounds, f"two error bounds for {key}")
        self.error_bounds[key] = records.read_error_bound(payload)

    def _read_table_bound(self, payload: Payload) -> None:
        key = self._read_key(payload)
        require(key not in self.table_bounds, f"two table bounds for {key}")
        require(isinstance(self.curves.get(key), TableCurve), f"the bound of a table before it, or of none: {key}")
        self.table_bounds[key] = records.read_table_bound(payload)

    def _check_complete(self) -> None:
        require(bool(self.sensor_info), "the file has no sensor")
        for sensor in self.sensors:
            require((sensor, "bias") in self.curves, f"{sensor} has no bias curve")
        for key in self.uncertainties:
            require(key in self.curves, f"an uncertainty without a curve: {key}")
