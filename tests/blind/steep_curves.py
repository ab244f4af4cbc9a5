# SPDX-License-Identifier: Apache-2.0
"""Units whose thermal curves are steep but have no narrow bump, and units that have one: a generator that shares nothing
with hal/sim or calib. Each campaign is a CSV as `soak import` reads it; what is true stays here.

    kind      curve of each sensor, over a parabola and a wide tanh
    smooth    nothing else
    tanh      a step tanh((T - c)/w) with w of 5 to 10 K: 10 to 90 % in 11 to 22 K
    kinks     one to three kinks, no two nearer than 8 K
    spline    a cubic spline through random values at six to nine random knots, no two nearer than 8 K, and nothing else
    loose     the same with knots anywhere: some lie within a kelvin or two of each other, and make narrow bumps

Six runs of 21 plateaus from -30 to 70 degC, all on the way up and every fourth on the way down, or of six, both ways; six
positions of two minutes at each, in another order in each run.
Noise as the blind benchmark has it by default: 0.004 deg/s and 0.002 m/s2 for a one-minute block, half of that for each
stay in a position and each visit, five times that for each power-on.
"""
import dataclasses
import pathlib

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

KINDS = ("tanh", "kinks", "spline")
SENSORS = ("gx_dps", "gy_dps", "gz_dps", "ax_mps2", "ay_mps2", "az_mps2")
POSITIONS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
GRAVITY_MPS2 = 9.80665
BLOCK = np.array([0.004] * 3 + [0.002] * 3)  # noise of a one-minute block
PLATEAUS_C = np.arange(-30.0, 70.1, 5.0)
COARSE_C = np.arange(-30.0, 70.1, 20.0)
STEP_S, SOAK_S, STAY_S, TURN_S = 10.0, 900.0, 120.0, 10.0
RAMP_KPMIN, UNIT_LAG_S = 2.0, 240.0


@dataclasses.dataclass(frozen=True)
class Bump:
    """A Gaussian resonance. `height`: in noises of a one-minute block."""
    height: float
    fwhm_c: float
    centre_c: float
    sensors: tuple  # indices into SENSORS


def random_places(random, count, low, high, apart):
    """Rising, no two nearer than `apart`."""
    free = np.sort(random.uniform(0.0, high - low - apart * (count - 1), count))
    return low + free + apart * np.arange(count)


def make_curve(random, kind):
    """Function of the temperature, in units of 1 deg/s."""
    def wide(c):
        x = (c - 20.0) / 50.0
        return line[0] + line[1] * x + line[2] * x * x + line[3] * np.tanh((c - middle_c) / width_c)

    line, middle_c, width_c = random.normal(0.0, (0.1, 0.1, 0.05, 0.15)), random.uniform(0.0, 40.0), random.uniform(25.0, 45.0)
    sign = random.choice((-1.0, 1.0))
    if kind == "smooth":
        return wide
    if kind == "tanh":
        height, centre_c, steep_c = sign * random.uniform(0.1, 0.4), random.uniform(-20.0, 60.0), random.uniform(5.0, 10.0)
        return lambda c: wide(c) + height * np.tanh((c - centre_c) / steep_c)
    if kind == "kinks":
        places_c = random_places(random, random.integers(1, 4), -25.0, 65.0, 8.0)
        slopes = random.choice((-1.0, 1.0), len(places_c)) * random.uniform(0.002, 0.012, len(places_c))
        return lambda c: wide(c) + sum(slope * np.maximum(0.0, c - place) for slope, place in zip(slopes, places_c))
    knots_c = random_places(random, random.integers(6, 10), -34.0, 74.0, 8.0 if kind == "spline" else 0.0)
    values = random.normal(0.0, 0.15, len(knots_c))
    knots_c[0], knots_c[-1] = -34.0, 74.0
    return CubicSpline(knots_c, values, bc_type="natural")


def make_curves(seed, kind, bump=None):
    """Bias of all sensors at temperatures, in their units: a function that gives one column per sensor."""
    random = np.random.default_rng((seed, 1))
    curves = [make_curve(random, kind) for _ in SENSORS]
    scale = BLOCK / BLOCK[0]

    def bias(temp_c):
        columns = np.stack([curve(temp_c) for curve in curves], axis=1) * scale
        if bump:
            shape = np.exp(-4.0 * np.log(2.0) * ((temp_c - bump.centre_c) / bump.fwhm_c) ** 2)
            for s in bump.sensors:
                columns[:, s] += bump.height * BLOCK[s] * shape
        return columns
    return bias


def course(random, order, plateaus_c):
    """One run, a row each 10 s: set point, sweep, visit, position (-1: the fixture turns), whether it rests at the plateau."""
    set_c, sweep, visit, position, rests = [], [], [], [], []

    def rows(seconds, values, here, rest):
        count = round(seconds / STEP_S)
        set_c.extend(np.broadcast_to(values, count) if np.ndim(values) == 0 else values)
        for column, value in ((sweep, way), (visit, number), (position, here), (rests, rest)):
            column.extend([value] * count)

    plateaus = list(plateaus_c) + list(plateaus_c[-5::-4] if len(plateaus_c) > 12 else plateaus_c[-2::-1])
    for number, plateau_c in enumerate(plateaus):
        way = "up" if number < len(plateaus_c) else "down"
        if number:
            ramp_s = 60.0 * abs(plateau_c - plateaus[number - 1]) / RAMP_KPMIN
            count = round(ramp_s / STEP_S)
            rows(ramp_s, np.linspace(plateaus[number - 1], plateau_c, count), order[0], False)
            rows(SOAK_S, plateau_c, order[0], False)
        for here in order:
            rows(STAY_S, plateau_c, here, True)
            rows(TURN_S, plateau_c, -1, False)
    offsets_c = random.uniform(-0.2, 0.2, len(plateaus))
    visit = np.array(visit)
    return np.array(set_c) + offsets_c[visit], np.array(sweep), visit, np.array(position), np.array(rests), np.array(plateaus)[visit]


def make_run(random, bias, turn, plateaus_c):
    """Columns of one run."""
    order = np.roll(np.arange(6), turn) if turn % 2 == 0 else np.roll(np.arange(6)[::-1], turn)
    air_c, sweep, visit, position, rests, plateau_c = course(random, order, plateaus_c)
    stays = 1.0 - np.exp(-STEP_S / UNIT_LAG_S)
    temp_c, _ = lfilter([stays], [1.0, stays - 1.0], air_c, zi=[(1.0 - stays) * air_c[0]])
    count = len(temp_c)
    stay = np.cumsum(np.concatenate(([0], np.diff(position) != 0)))
    up = np.array(list(POSITIONS.values()) + [(0, 0, 0)])[position]
    readings = bias(temp_c) + 5.0 * BLOCK * random.normal(size=6)
    readings += 0.5 * BLOCK * random.normal(size=(visit.max() + 1, 6))[visit]
    readings += 0.5 * BLOCK * random.normal(size=(stay.max() + 1, 6))[stay]
    readings += np.sqrt(60.0 / STEP_S) * BLOCK * random.normal(size=(count, 6))
    readings[:, 3:] += GRAVITY_MPS2 * up * (1.001 + 1e-5 * (temp_c[:, None] - 20.0))
    seconds = STEP_S * np.arange(count)
    # Between the stays a row each minute will do.
    keep = rests | (position < 0) | (np.arange(count) % 6 == 0)
    return [(seconds[i], "soak" if rests[i] or position[i] < 0 else "ramp", sweep[i], plateau_c[i],
             list(POSITIONS)[position[i]] if position[i] >= 0 else "", temp_c[i] + 0.01 * random.normal(), air_c[i], *readings[i])
            for i in np.flatnonzero(keep)]


def write_campaign(path, seed, kind, bump=None, runs=6, plateaus_c=PLATEAUS_C):
    """The CSV of one unit."""
    random = np.random.default_rng((seed, 2))
    bias = make_curves(seed, kind, bump)
    with open(pathlib.Path(path), "w", encoding="utf-8") as file:
        file.write("run,utc_s,t_s,phase,sweep,plateau_c,position,temp_c,chamber_c," + ",".join(SENSORS) + "\n")
        for number in range(runs):
            start_s = 1.8e9 + 2e5 * number
            for t_s, *row in make_run(random, bias, number, plateaus_c):
                file.write("R%02d,%.0f,%.0f,%s,%s,%g,%s,%.4f,%.3f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n"
                           % (number + 1, start_s + t_s, t_s, *row))
