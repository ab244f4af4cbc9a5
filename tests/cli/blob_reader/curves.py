# SPDX-License-Identifier: Apache-2.0
"""The three kinds of curve (0x0011 to 0x0013), in double precision from the float32 numbers of the file."""

from __future__ import annotations

import math
import struct
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .file import Matrix, Payload, SectionType, Vector, require

MAX_RULES = 64
MAX_PIECES = 1024
MAX_TABLE_POINTS = 4096

MIN_TEMP_C = -273.15
MAX_TEMP_C = 1000.0
MAX_RULE_CENTRE_C = 10_000.0


def to_float32(value: float) -> float:
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


def clamp(value: float, low: float, high: float) -> float:
    return max(low, min(high, value))


def require_count(count: int, limit: int, what: str) -> None:
    require(1 <= count <= limit, f"the number of {what} must be 1 to {limit}")


def require_temperatures(values: Sequence[float]) -> None:
    require(all(MIN_TEMP_C <= value <= MAX_TEMP_C for value in values), "a temperature is impossible")


def require_rising(values: Sequence[float]) -> None:
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

    def holds(self, temp_c: float) -> bool:
        """Whether the curve is not just held at this temperature (a float32 number)."""
        return self.low <= temp_c <= self.high

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

    def holds(self, temp_c: float) -> bool:
        offset = to_float32(temp_c - self.low)
        return 0.0 <= offset <= to_float32((len(self.values) - 1) * self.step)

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
    require_count(count, MAX_RULES, "rules")
    low, high, centre, half_range = payload.floats(4)
    shape = MEMBERSHIPS[membership]
    rules = tuple(_read_rule(payload, shape is bell, order) for _ in range(count))
    return FisCurve(low, high, centre, half_range, shape, rules)


def _read_spline(payload: Payload) -> Curve:
    (count,) = payload.integers("H")
    require_count(count, MAX_PIECES, "spline pieces")
    centre, half_range = payload.floats(2)
    knots = payload.floats(count + 1)
    require_temperatures(knots)
    require_rising(knots)
    pieces = tuple(payload.floats(4) for _ in range(count))
    return SplineCurve(knots[0], knots[-1], centre, half_range, knots, pieces)


def _read_table(payload: Payload) -> Curve:
    (count,) = payload.integers("H")
    require_count(count, MAX_TABLE_POINTS, "table points")
    centre, half_range, first, step = payload.floats(4)
    require(step > 0, "a table's step is not positive")
    require_temperatures((first,))
    require(to_float32((count - 1) * step) <= to_float32(MAX_TEMP_C - first), "a table ends beyond 1000 °C")
    return TableCurve(first, first + (count - 1) * step, centre, half_range, step, payload.floats(count))


CURVE_READERS: dict[int, Callable[[Payload], Curve]] = {
    SectionType.FIS: _read_fis,
    SectionType.SPLINE: _read_spline,
    SectionType.TABLE: _read_table,
}
