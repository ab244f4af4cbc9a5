# SPDX-License-Identifier: Apache-2.0
"""What a file means (section 5 of docs/blob-format.md): curves at a temperature, and corrected samples."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence

from .contents import Contents
from .curves import to_float32
from .file import Matrix, Vector
from .records import ACCELS, GYROS, SENSORS, interpolate

MAX_SCALE_PPM = 500_000.0


class SensorFlag(enum.Flag):
    """What the caller of Calibration.apply has to know about one sensor's output."""

    NONE = 0
    ABSENT = enum.auto()
    NO_TEMPERATURE = enum.auto()
    OUT_OF_RANGE = enum.auto()
    SCALE_UNKNOWN = enum.auto()
    SCALE_IMPLAUSIBLE = enum.auto()
    NOT_FINITE = enum.auto()  # the raw value, a curve or the corrected value
    SCALE_HELD = enum.auto()  # in the valid range, but the scale factor was not measured at the temperature


LEFT_OUT = SensorFlag.NO_TEMPERATURE | SensorFlag.SCALE_IMPLAUSIBLE | SensorFlag.NOT_FINITE
UNCORRECTED = SensorFlag.ABSENT | LEFT_OUT


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


class Calibration(Contents):
    """What one calibration file says about one inertial unit."""

    @classmethod
    def load(cls, data: bytes) -> Calibration:
        """Read a whole file; raise BlobError if the specification forbids its use."""
        return cls(data)

    def bias(self, sensor: str, temp_c: float) -> tuple[float, bool]:
        """Bias in rad/s or m/s² and whether the temperature is in range; NaN if it is not finite."""
        value, in_range = self._evaluate(sensor, "bias", temp_c)
        return (math.nan if value is None else value), in_range

    def scale_ppm(self, sensor: str, temp_c: float) -> tuple[float | None, bool]:
        """Scale factor error, None where unknown, and whether the temperature is in range."""
        return self._evaluate(sensor, "scale_ppm", temp_c)

    def scale_measured(self, sensor: str, temp_c: float) -> bool:
        """Whether the scale factor was measured at the temperature, held in the valid range."""
        curve = self.curves.get((sensor, "scale_ppm"))
        return curve is not None and curve.holds(self.sensor_info[sensor].nearest(to_float32(temp_c)))

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

    def apply(self, temp_c: float, raw6: Sequence[float],
              own_temps_c: dict[str, float] | None = None) -> tuple[list[float], list[SensorFlag]]:
        """Correct one sample, gyros (rad/s) then accelerometers (m/s²); one flag value for each of the six.

        own_temps_c: of the sensors with thermometers of their own; unknown where it has none.
        """
        raw = dict(zip(SENSORS, raw6, strict=True))
        own = self.own_thermometers
        temps = {sensor: (own_temps_c or {}).get(sensor, math.nan) if sensor in own else temp_c for sensor in SENSORS}
        flags = {sensor: self._flags(sensor, temps[sensor], raw[sensor]) for sensor in SENSORS}
        out = dict(raw)

        def take(sensor: str, value: float) -> None:
            if flags[sensor] & UNCORRECTED:
                return
            if math.isfinite(value):
                out[sensor] = value
            else:
                flags[sensor] |= SensorFlag.NOT_FINITE

        for sensor, value in zip(ACCELS, self._specific_force(temps, raw, flags)):
            take(sensor, value)
        force = [0.0 if flags[sensor] & LEFT_OUT else out[sensor] for sensor in ACCELS]
        for sensor, value in zip(GYROS, self._rates(temps, raw, flags, force)):
            take(sensor, value)
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
        if in_range and scale is not None and not self.scale_measured(sensor, temp_c):
            flags |= SensorFlag.SCALE_HELD
        return flags

    def _gain(self, sensor: str, temp_c: float) -> float:
        return 1.0 + (self.scale_ppm(sensor, temp_c)[0] or 0.0) * 1e-6

    def _unbiased(self, sensor: str, temp_c: float, raw: float) -> float:
        return raw - self.bias(sensor, temp_c)[0]

    def _specific_force(self, temps: dict[str, float], raw: dict[str, float], flags: dict[str, SensorFlag]) -> list[float]:
        """Of the corrected accelerometers; raw of those that are not in the file, 0 of those left out."""
        return self._triad(ACCELS, self.misalignment, temps, raw, flags, [0.0, 0.0, 0.0])

    def _rates(self, temps: dict[str, float], raw: dict[str, float], flags: dict[str, SensorFlag],
               force: list[float]) -> list[float]:
        pulls = [0.0, 0.0, 0.0]
        if self.g_sensitivity is not None:
            pulls = [sum(per_force * component for per_force, component in zip(row, force)) for row in self.g_sensitivity]
        matrix = self.gyro_misalignment.matrix if self.gyro_misalignment is not None else None
        return self._triad(GYROS, matrix, temps, raw, flags, pulls)

    def _triad(self, names: Sequence[str], misalignment: Matrix | None, temps: dict[str, float], raw: dict[str, float],
               flags: dict[str, SensorFlag], pulls: list[float]) -> list[float]:
        """Solve K x = raw - b - pull; raw of sensors that are not in the file, 0 of those left out."""
        corrected = [not flags[name] & UNCORRECTED for name in names]
        known = [not flags[name] & LEFT_OUT for name in names]
        unbiased = [self._unbiased(name, temps[name], raw[name]) - pull if good else raw[name] if there else 0.0
                    for name, good, there, pull in zip(names, corrected, known, pulls)]
        gains = [self._gain(name, temps[name]) if good else 1.0 for name, good in zip(names, corrected)]
        if misalignment is None:
            return [value / gain for value, gain in zip(unbiased, gains)]
        cross = [tuple(value if good and there else 0.0 for value, there in zip(row, known))
                 for row, good in zip(misalignment, corrected)]
        return solve(with_diagonal(cross, gains), unbiased)
