# SPDX-License-Identifier: Apache-2.0
"""The plan of the benchmark: cells, each a kind of campaign and how many of it, and the seed of every campaign."""
import dataclasses
import itertools

DESIGNS = {"identical": {}, "mixed": {"kind": "mixed"}, "three": {"kind": "three"}, "missing_logs": {"kind": "missing_logs"},
           "drift x 3": {"drift_factor": 3.0}, "strength varies": {"amplitude_spread": 0.3}, "dropped visit": {"dropped_visit": True},
           "wrong position": {"wrong_position": True}, "whole degrees": {"thermometer_step_c": 1.0}, "one": {"kind": "one"}}
STRESS = ("drift x 3", "strength varies", "dropped visit", "wrong position", "whole degrees")
PAIR_DESIGNS = ("identical", "mixed", "three")
# Nameable effects that can be seen within a run.
EFFECTS = ("thermal_hysteresis", "temperature_rate", "sensor_lag", "warmup_transient", "g_sensitivity", "earth_rate", "cross_axis",
           "fixture_tilt", "scale_nonlinearity", "vibration_rectification", "supply_sensitivity")
# Those that only what "missing logs" leaves out could tell: there the right answer is no name, or that of none.
NEED_LOGS = ("sensor_lag", "vibration_rectification", "supply_sensitivity")
# The other names. Their magnitudes are counted in other ways (hal/sim/README.md), so no oracle stands beside them.
OTHERS = ("narrow_bump", "aging_drift", "noise_vs_temperature", "quantization", "saturation")
UNKNOWN = ("reposition_creep", "position_memory", "daily_wave", "telegraph_noise", "bias_step", "moisture", "gradient_rate")
# What the library calls them where it has a mechanism of that kind: a right name.
KIN = {"position_memory": "position_memory", "reposition_creep": "position_memory", "moisture": "moisture",
       "gradient_rate": "temperature_gradient"}
UNKNOWN_MAGNITUDES = (0.6, 1.2, 2.4)
# Beyond it more than the Earth turns would have to be hidden.
LARGEST_EARTH_RATE = 0.6
# Of the shapes that the oracle is told where nothing is hidden.
NULL_MAGNITUDE = 0.3


@dataclasses.dataclass(frozen=True)
class Cell:
    """Campaigns of one kind. `table`: null, named, unlogged, other, pair, unknown or one."""
    table: str
    design: str
    effects: tuple
    magnitude: float  # 0 where nothing is hidden
    count: int

    def name(self):
        parts = [self.table, self.design, "+".join(self.effects), f"{self.magnitude:g}" if self.effects else ""]
        return "/".join(part for part in parts if part)

    def hidden(self, seed):
        return [{"effect": effect, "magnitude": self.magnitude, "seed": seed} for effect in self.effects]

    def candidates(self, seed):
        """What the oracle is told of: every effect as it would look here. None where there is no oracle."""
        if self.table not in ("null", "named", "pair"):
            return []
        return [{"effect": effect, "magnitude": self.magnitude or NULL_MAGNITUDE, "seed": seed} for effect in EFFECTS]


@dataclasses.dataclass(frozen=True)
class Counts:
    """How much of everything: campaigns per cell, and magnitudes."""
    nulls: int
    seeds: int
    stress_seeds: int
    pair_seeds: int
    unknown_seeds: int
    magnitudes: tuple
    pair_magnitude: float


def cells(counts):
    found = [Cell("null", design, (), 0.0, counts.nulls) for design in DESIGNS if design != "one"]
    for design, effect, magnitude in itertools.product(DESIGNS, EFFECTS, counts.magnitudes):
        if design != "one" and (effect != "earth_rate" or magnitude <= LARGEST_EARTH_RATE):
            seeds = counts.stress_seeds if design in STRESS else counts.seeds
            table = "unlogged" if design == "missing_logs" and effect in NEED_LOGS else "named"
            found.append(Cell(table, design, (effect,), magnitude, seeds))
    for design, pair in itertools.product(PAIR_DESIGNS, itertools.combinations(EFFECTS, 2)):
        found.append(Cell("pair", design, pair, counts.pair_magnitude, counts.pair_seeds))
    found += [Cell("unknown", "identical", (effect,), magnitude, counts.unknown_seeds)
              for effect, magnitude in itertools.product(UNKNOWN, UNKNOWN_MAGNITUDES)]
    found += [Cell("other", "identical", (effect,), magnitude, counts.seeds)
              for effect, magnitude in itertools.product(OTHERS, counts.magnitudes)]
    found.append(Cell("one", "one", (), 0.0, counts.seeds))
    found += [Cell("one", "one", (effect,), max(counts.magnitudes), counts.seeds) for effect in EFFECTS
              if effect not in ("fixture_tilt", "earth_rate")]  # a tilt needs runs to differ between
    return [cell for cell in found if cell.count > 0]


def plan(counts, first):
    """(cell, seed) of every campaign, no seed twice. In proportion: wherever it stops, all cells are equally far."""
    numbered = [(number / cell.count, cell) for cell in cells(counts) for number in range(cell.count)]
    seeded = [(done, cell, first + index) for index, (done, cell) in enumerate(numbered)]
    return [(cell, seed) for done, cell, seed in sorted(seeded, key=lambda entry: entry[0])]
