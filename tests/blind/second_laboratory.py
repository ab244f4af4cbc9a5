# SPDX-License-Identifier: Apache-2.0
"""A second laboratory: made-up calibration campaigns of a MEMS inertial unit, written from the CSV format and the
definition of magnitude alone. It shares no code, no basis and no reading of sources with hal/sim or calib.

Thermal world: a set point that ramps from room temperature to -30 degC, up to 70 and down again; chamber air that
follows it with a lag and wanders a little; the case behind the air, the board behind the case, both heated by the unit
itself from power-on. The thermometer and the sensors sit on the board, so a visit settles from below when heating, from
above when cooling. While the chamber ramps and the unit waits, the fixture holds its last position (phase `ramp`); then
six positions of three minutes follow (phase `soak`), with turns of 10 to 15 s in which `position` is empty.

Noise, in units of the white noise of a one-minute block (0.004 deg/s, 0.002 m/s2): a block is twelve samples 5 s apart,
so a sample has sqrt(12) times that. Power-on offsets of 5 units. Slow noise, drawn for each sensor and run and running
on through the ramps: `gauss_markov` (6 min, 1 h and 10 h, a third of the variance each; size = sigma of the sum),
`flicker` (1/f from 1 min to 30 h; size = sigma of the sum), `random_walk` (size = sigma of the growth over an hour).

Size of an effect: RMS of its block means that a refitted base cannot absorb, over the affected sensors and in the same
units. The base has a free level per plateau, one offset per run, for accelerometers also a free scale per plateau and
constant misalignments. Free levels absorb any narrow bump, so for that one the base has a quintic in temperature in
their place. Plateaus that are not settled differ within themselves in temperature: `size_beyond_slopes` in the truth is
what is left if each plateau had a free slope as well, as coarse plateaus all but give it. Ageing runs with the clock
and within the runs: only that part counts. The scale that reaches the size is the time constant for sensor_lag, the
amplitude for all others; for earth_rate that means a planet that turns faster or slower than ours (without a size:
ours). With nothing hidden the gyros see no Earth rate: the laboratory has taken it out.
"""
from __future__ import annotations

import argparse
import json
import sys
import zlib
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

SENSORS = ("gx", "gy", "gz", "ax", "ay", "az")
BLOCK_SIGMA = np.array([0.004] * 3 + [0.002] * 3)
POSITIONS = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
# A roll-and-pitch fixture: body axes to fixture axes (x ahead, y left, z up) in each of the positions.
ATTITUDES = Rotation.from_rotvec(np.pi / 2 * np.array(
    [[0, -1, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 0], [2, 0, 0]], dtype=float))
# Heading of the horizontal axis that docs/csv-format.md names, from that of the fixture, as the attitudes above have it.
AZIMUTHS_DEG = dict(zip(POSITIONS, (270, 270, 90, 270, 0, 0)))
GRAVITY_MPS2 = 9.80665
EARTH_DPS = 15.041067 / 3600
SAMPLE_S = 5
BLOCK_SAMPLES = 12
STAY_SAMPLES = 3 * BLOCK_SAMPLES
POWER_ON_BLOCKS = 5.0
SLOW_TAUS_S = {"gauss_markov": (360.0, 3600.0, 36000.0), "flicker": tuple(np.geomspace(60.0, 108000.0, 14))}
SLOW_KINDS = (*SLOW_TAUS_S, "random_walk")
LONGEST_LAG_S = 1800.0
RAMP, TURN, STAY = range(3)
HEADER = ("t_s", "run", "phase", "sweep", "plateau_c", "position", "chamber_c", "temp_c", "gx_dps", "gy_dps", "gz_dps",
          "ax_mps2", "ay_mps2", "az_mps2", "t_since_power_s", "utc_s")
ROW = "%d,%s,%s,%s,%g,%s,%.2f,%.4f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%d,%d"


class OutOfReach(ValueError):
    """This design cannot show the effect in this size."""


@dataclass(frozen=True)
class Design:
    spacing_k: float = 10.0
    dwell_min: float = 20.0
    positions: str = "fixed"  # or `permuted`: another order in each run
    ramps: str = "one"  # or `two`: two rates in alternating runs
    down: str = "all"  # or `half`: every second plateau on the way down
    slow_kind: str = "gauss_markov"
    slow: float = 0.0
    placement: float = 0.0  # scatter of each turn of the fixture, blocks
    visit: float = 0.0  # scatter of each visit of a plateau, blocks
    thermometer_lag_s: float = 0.0
    runs: int = 6


@dataclass
class Campaign:
    design: Design
    log: SimpleNamespace
    effect: np.ndarray  # what is hidden, in blocks
    readings: np.ndarray
    truth: dict

    @cached_property
    def csv(self) -> str:
        return csv_text(self.log, self.readings)


def stream(seed: int, purpose: str) -> np.random.Generator:
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


# Schedule and thermal world

def visits_c(design: Design) -> np.ndarray:
    up = np.arange(-30.0, 70.0 + design.spacing_k / 2, design.spacing_k)
    return np.concatenate([up, up[-2::-1] if design.down == "all" else up[-3::-2]])


def sections(rng, design: Design, order, ramp_kps: float, room_c: float) -> np.ndarray:
    """Samples, set point at begin and end, kind, position at begin and end, visit, sweep."""
    rows, set_c, held = [], room_c, order[-1]
    waits = round(design.dwell_min * 60 / SAMPLE_S)
    for visit, plateau_c in enumerate(visits_c(design)):
        sweep = np.sign(plateau_c - set_c)
        samples = int(np.ceil(abs(plateau_c - set_c) / ramp_kps / SAMPLE_S))
        rows.append((samples, set_c, plateau_c, RAMP, held, held, visit, sweep))
        rows.append((waits, plateau_c, plateau_c, RAMP, held, held, visit, sweep))
        for position in order:
            rows.append((rng.integers(2, 4), plateau_c, plateau_c, TURN, held, position, visit, sweep))
            rows.append((STAY_SAMPLES, plateau_c, plateau_c, STAY, position, position, visit, sweep))
            held = position
        set_c = plateau_c
    return np.array(rows)


def run_log(rows: np.ndarray, run: int) -> dict[str, np.ndarray]:
    """Everything of one run that follows from the schedule, one entry per sample."""
    lengths = rows[:, 0].astype(int)
    section = np.repeat(np.arange(len(rows)), lengths)
    within = np.arange(len(section)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    _, begin_c, end_c, kind, left, held, visit, sweep = rows[section].T
    left, held = left.astype(int), held.astype(int)
    turn_s = lengths[section] * SAMPLE_S
    turn = (ATTITUDES[left].inv() * ATTITUDES[held]).as_rotvec()
    done = (within + 0.5) / lengths[section]
    from_fixture = (ATTITUDES[left] * Rotation.from_rotvec(turn * done[:, None])).inv()
    time_s = np.arange(len(section)) * SAMPLE_S
    last_turn_s = np.maximum.accumulate(np.where(kind == TURN, time_s, -1e9))
    return dict(run=np.full(len(section), run), t_s=time_s, kind=kind, position=held, visit=visit, sweep=sweep,
                plateau_c=end_c, set_c=begin_c + (end_c - begin_c) * (within + 1) / lengths[section],
                stay=section, since_turn_s=time_s - last_turn_s,
                force_mps2=from_fixture.apply([0, 0, GRAVITY_MPS2]), rate_dps=np.degrees(turn) / turn_s[:, None],
                ahead=from_fixture.apply([1, 0, 0]), aside=from_fixture.apply([0, 1, 0]))


def node(driving: np.ndarray, tau_s: float, start) -> np.ndarray:
    """A first-order node that follows what drives it; `start` is its value before the first sample."""
    if tau_s <= 0:
        return driving
    keep = np.exp(-SAMPLE_S / tau_s)
    state = keep * np.broadcast_to(start, driving.shape[1:])[None]
    return lfilter([1 - keep], [1, -keep], driving, axis=0, zi=state)[0]


def gauss_markov(rng, samples: int, tau_s: float, width: int = 6) -> np.ndarray:
    """Unit variance from the first sample on."""
    keep = np.exp(-SAMPLE_S / tau_s)
    driving = rng.standard_normal((samples, width))
    driving[1:] *= np.sqrt(1 - keep**2)
    return lfilter([1.0], [1.0, -keep], driving, axis=0)


def heat(rng, run: dict, body: SimpleNamespace, design: Design, room_c: float) -> None:
    """Air, board and thermometer of one run. The unit has been on for `boot_s` when the recording begins."""
    samples = len(run["t_s"])
    boot_s = int(rng.integers(60, 300))
    wander_k = 0.08 * gauss_markov(rng, samples, 900.0, 1)[:, 0]
    run["air_c"] = node(run["set_c"], body.air_s, room_c) + wander_k
    warmed = 1 - np.exp(-boot_s / body.case_s)
    case_c = node(run["air_c"] + body.case_rise_k, body.case_s, room_c + body.case_rise_k * warmed)
    warmed = 1 - np.exp(-boot_s / body.board_s)
    run["unit_c"] = node(case_c + body.board_rise_k, body.board_s, case_c[0] + body.board_rise_k * warmed)
    run["unit_kpmin"] = np.gradient(run["unit_c"]) * 60 / SAMPLE_S
    reads_c = node(run["unit_c"], design.thermometer_lag_s, run["unit_c"][0])
    run["temp_c"] = reads_c + 0.01 * rng.standard_normal(samples)
    run["powered_s"] = run["t_s"] + boot_s


def campaign_log(seed: int, design: Design) -> SimpleNamespace:
    rng = stream(seed, "schedule")
    body = SimpleNamespace(air_s=rng.uniform(90, 200), case_s=rng.uniform(280, 480), board_s=rng.uniform(60, 150),
                           case_rise_k=rng.uniform(2, 5), board_rise_k=rng.uniform(0.5, 2))
    ramp_kps = rng.uniform(1.0, 1.8) / 60
    order, utc_s, runs = rng.permutation(6), int(1.77e9) + int(rng.integers(0, 30 * 86400)), []
    rates_kps = [ramp_kps, ramp_kps * (2.2 if design.ramps == "two" else 1.0)]
    for number in range(design.runs):
        if design.positions == "permuted":
            order = rng.permutation(6)
        room_c = rng.normal(23.0, 1.0)
        run = run_log(sections(rng, design, order, rates_kps[number % 2], room_c), number)
        heat(rng, run, body, design, room_c)
        run["utc_s"] = utc_s + run["t_s"]
        utc_s = int(run["utc_s"][-1]) + int(rng.integers(2 * 3600, 8 * 3600))
        runs.append(run)
    log = SimpleNamespace(**{name: np.concatenate([run[name] for run in runs]) for name in runs[0]})
    ends = np.cumsum([len(run["t_s"]) for run in runs])
    log.slices = [slice(end - len(run["t_s"]), end) for end, run in zip(ends, runs)]
    log.in_blocks = np.flatnonzero(log.kind == STAY)
    log.world = dict(vars(body), ramp_kpmin=[60 * rate for rate in rates_kps])
    return log


def per_run(log, function, values: np.ndarray) -> np.ndarray:
    return np.concatenate([function(values[part]) for part in log.slices])


# Unit

def bias_curve(rng, amplitude: float):
    """Parabola and wide tanh, or a spline through random values at knots at least 15 K apart."""
    if rng.random() < 0.5:
        line, square, step = amplitude * rng.normal(0, [1.0, 0.5, 1.0])
        centre_c, width_k = rng.uniform(-10, 50), rng.uniform(20, 35)
        return lambda temp_c: (line * (temp_c - 20) / 50 + square * ((temp_c - 20) / 50) ** 2
                               + step * np.tanh((temp_c - centre_c) / width_k))
    knots = int(rng.integers(5, 8))
    gaps_k = 15 + (130 - 15 * (knots - 1)) * rng.dirichlet(np.ones(knots - 1))
    knots_c = -45 + np.concatenate([[0], np.cumsum(gaps_k)])
    return CubicSpline(knots_c, amplitude * rng.normal(0, 0.7, knots), bc_type="natural")


def make_unit(seed: int) -> SimpleNamespace:
    rng = stream(seed, "unit")
    amplitudes = rng.uniform(0.5, 1.5, 6) * [0.2, 0.2, 0.2, 0.08, 0.08, 0.08]
    skew = [rng.normal(0, 1e-3, (3, 3)) * (1 - np.eye(3)) for _ in range(2)]
    return SimpleNamespace(curves=[bias_curve(rng, amplitude) for amplitude in amplitudes],
                           scale=rng.normal(0, [[4e-4], [3e-4], [2e-4]], (3, 3)), skew=skew)


def respond(unit, element_c: np.ndarray, force_mps2: np.ndarray, rate_dps: np.ndarray) -> np.ndarray:
    """Readings of the six sensors without noise, whose elements are at `element_c`."""
    out = np.column_stack([curve(element_c) for curve in unit.curves])
    x = (element_c - 20) / 50
    scale = np.column_stack([np.ones_like(x), x, x**2]) @ unit.scale
    out[:, :3] += rate_dps + rate_dps @ unit.skew[0].T
    out[:, 3:] += force_mps2 * (1 + scale) + force_mps2 @ unit.skew[1].T
    return out


# Noise, in blocks

def slow_noise(rng, samples: int, kind: str, size: float) -> np.ndarray:
    if kind == "random_walk":
        return size * np.sqrt(SAMPLE_S / 3600) * np.cumsum(rng.standard_normal((samples, 6)), axis=0)
    taus_s = SLOW_TAUS_S[kind]
    return size / np.sqrt(len(taus_s)) * sum(gauss_markov(rng, samples, tau_s) for tau_s in taus_s)


def noise(seed: int, design: Design, log) -> np.ndarray:
    white, slow, rest = stream(seed, "white"), stream(seed, "slow"), stream(seed, "scatter")
    out = np.sqrt(BLOCK_SAMPLES) * white.standard_normal((len(log.t_s), 6))
    for part in log.slices:
        samples = part.stop - part.start
        out[part] += POWER_ON_BLOCKS * rest.standard_normal(6)
        out[part] += design.visit * rest.standard_normal((int(log.visit[part][-1]) + 1, 6))[log.visit[part].astype(int)]
        out[part] += design.placement * rest.standard_normal((log.stay[part][-1] + 1, 6))[log.stay[part]]
        if design.slow > 0:
            out[part] += slow_noise(slow, samples, design.slow_kind, design.slow)
    return out


# Size: what a refitted base leaves of an effect

def block_means(log, values: np.ndarray) -> np.ndarray:
    """Values per sample to means of one-minute blocks of the stays."""
    taken = values[log.in_blocks]
    return taken.reshape(-1, BLOCK_SAMPLES, *taken.shape[1:]).mean(axis=1)


def bases(log, stiff: bool = False, slopes: bool = False) -> list[np.ndarray]:
    """An orthonormal basis of what the base absorbs, for each sensor; with `slopes` also a free slope per plateau."""
    first = log.in_blocks[::BLOCK_SAMPLES]
    levels = (log.plateau_c[first][:, None] == np.unique(log.plateau_c)).astype(float)
    runs = (log.run[first][:, None] == np.arange(1, len(log.slices))).astype(float)
    block_c = block_means(log, log.unit_c)
    curve = np.vander((block_c - 20) / 50, 6) if stiff else levels
    if slopes:
        curve = np.hstack([levels, levels * (block_c - log.plateau_c[first])[:, None]])
    force = np.round(log.force_mps2[first] / GRAVITY_MPS2)
    found = [np.linalg.qr(np.hstack([curve, runs]))[0]] * 3
    for axis in range(3):
        others = np.delete(force, axis, axis=1)
        found.append(np.linalg.qr(np.hstack([curve, runs, levels * force[:, [axis]], others]))[0])
    return found


def sizes_left(found: list[np.ndarray], blocks: np.ndarray) -> np.ndarray:
    left = [column - base @ (base.T @ column) for base, column in zip(found, blocks.T)]
    return np.sqrt(np.mean(np.square(left), axis=1))


def size_of(sizes: np.ndarray, affected: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(sizes[affected]))))


# Effects: raw shape in blocks, one column per sensor, and its parameters

def weights(rng, most: int, among=range(6)) -> np.ndarray:
    """Random sensors, at most so many, with random signs and strengths."""
    chosen = rng.choice(list(among), size=rng.integers(1, most + 1), replace=False)
    out = np.zeros(6)
    out[chosen] = rng.choice([-1, 1], len(chosen)) * rng.uniform(0.5, 1.5, len(chosen))
    return out


def spread(shape: np.ndarray, strength: np.ndarray, **parameters) -> tuple[np.ndarray, dict]:
    """One shape in time, which each sensor feels as strongly as its weight says."""
    return np.outer(shape, strength), dict(parameters, weights=strength.tolist())


def play(temp_c: np.ndarray, half_width_k: np.ndarray) -> np.ndarray:
    """Play operators, one column per half width, at rest in the middle at first. Exact between turning points."""
    turns = 1 + np.flatnonzero(np.diff(np.sign(np.diff(temp_c))) != 0)
    state, parts, begin = np.full(len(half_width_k), temp_c[0]), [], 0
    for end in [*(turns + 1), len(temp_c)]:
        piece = temp_c[begin:end, None]
        rising = piece[-1, 0] >= (temp_c[begin - 1] if begin else piece[0, 0])
        out = np.maximum(state, piece - half_width_k) if rising else np.minimum(state, piece + half_width_k)
        parts.append(out)
        state, begin = out[-1], end
    return np.concatenate(parts)


def thermal_hysteresis(log, rng):
    half_width_k = np.sort(np.exp(rng.uniform(np.log(2), np.log(20), 4)))
    mass = rng.dirichlet(np.full(4, 2.0))
    shape = per_run(log, lambda temp_c: play(temp_c, half_width_k) @ mass - temp_c, log.unit_c)
    return spread(shape, weights(rng, 3), half_width_k=half_width_k.tolist(), mass=mass.tolist())


def temperature_rate(log, rng):
    return spread(log.unit_kpmin, weights(rng, 3))


def warmup_transient(log, rng):
    tau_s, share = [rng.uniform(600, 2400), rng.uniform(5400, 14400)], rng.uniform(0.3, 0.7)
    shape = share * np.exp(-log.powered_s / tau_s[0]) + (1 - share) * np.exp(-log.powered_s / tau_s[1])
    return spread(shape, weights(rng, 4), tau_s=tau_s, share=share)


def g_sensitivity(log, rng):
    matrix = rng.normal(0, 1, (3, 3))
    return np.hstack([log.force_mps2 @ matrix.T, np.zeros_like(log.force_mps2)]), dict(matrix=matrix.tolist())


def earth_rate(log, rng):
    latitude_deg, heading_deg = rng.choice([-1, 1]) * rng.uniform(25, 65), rng.uniform(0, 360)
    latitude, heading = np.radians([latitude_deg, heading_deg])
    north = np.cos(heading) * log.ahead + np.sin(heading) * log.aside
    rate_dps = EARTH_DPS * (np.cos(latitude) * north + np.sin(latitude) * log.force_mps2 / GRAVITY_MPS2)
    return (np.hstack([rate_dps / BLOCK_SIGMA[:3], np.zeros_like(rate_dps)]),
            dict(latitude_deg=latitude_deg, heading_deg=heading_deg))


def cross_axis(log, rng):
    matrix = rng.normal(0, 1, (3, 3)) * (1 - np.eye(3))
    shape = (log.force_mps2 @ matrix.T) * (log.unit_c[:, None] - 20) / 50
    return np.hstack([np.zeros_like(shape), shape]), dict(matrix=matrix.tolist())


def fixture_tilt(log, rng):
    rotation = rng.normal(0, 1, (len(log.slices), 3))
    shape = np.cross(log.force_mps2, rotation[log.run])
    return np.hstack([np.zeros_like(shape), shape]), dict(rotation=rotation.tolist())


def scale_nonlinearity(log, rng):
    strength = weights(rng, 3, range(3, 6))
    return np.hstack([np.zeros_like(log.force_mps2), log.force_mps2**2]) * strength, dict(weights=strength.tolist())


def aging_drift(log, rng):
    tau_h = rng.uniform(20, 100)
    age_h = (log.utc_s - log.utc_s[0]) / 3600
    return spread(np.log1p(age_h / tau_h), weights(rng, 4), tau_h=tau_h)


def narrow_bump(log, rng):
    half_width_k, phase = rng.uniform(1.5, 3.0), rng.uniform(-0.8, 0.8)
    reached_c = block_means(log, log.unit_c)
    inner_c = reached_c[(reached_c > -15) & (reached_c < 60)]
    centre_c = rng.choice(inner_c) + rng.uniform(-0.7, 0.7) * half_width_k
    x = (log.unit_c - centre_c) / half_width_k
    shape = np.exp(-x**2 / 2) * (np.cos(phase) + x * np.sin(phase))
    return spread(shape, weights(rng, 2), centre_c=centre_c, half_width_k=half_width_k, phase=phase)


def gradient(log, rng):
    return spread(log.air_c - log.unit_c, weights(rng, 3))


def position_memory(log, rng):
    tau_s = rng.uniform(180, 900)
    behind = per_run(log, lambda force: node(force, tau_s, force[0]), log.force_mps2) - log.force_mps2
    matrix = weights(rng, 3)[:, None] * rng.normal(0, 1, (6, 3))
    return behind @ matrix.T, dict(tau_s=tau_s, matrix=matrix.tolist())


def creep(log, rng):
    tau_s = rng.uniform(40, 200)
    return spread(np.exp(-log.since_turn_s / tau_s), weights(rng, 4), tau_s=tau_s)


def drying_water(log, rng):
    tau_h, activation_k, wet = rng.uniform(2, 6), rng.uniform(4000, 7000), rng.uniform(0.5, 1.0, len(log.slices))
    per_hour = np.exp(activation_k * (1 / 323.15 - 1 / (log.unit_c + 273.15))) / tau_h
    dried = per_run(log, lambda rate: np.exp(-np.cumsum(rate) * SAMPLE_S / 3600), per_hour)
    return spread(wet[log.run] * dried, weights(rng, 3), tau_at_50c_h=tau_h, activation_k=activation_k,
                  wet_at_start=wet.tolist())


def daily_wave(log, rng):
    phase = rng.uniform(0, 2 * np.pi)
    return spread(np.sin(2 * np.pi * log.utc_s / 86400 + phase), weights(rng, 3), phase=phase)


def step(log, rng):
    run, share = int(rng.integers(len(log.slices))), rng.uniform(0.25, 0.75)
    part = log.slices[run]
    at_s = float(log.t_s[part.start + int(share * (part.stop - part.start))])
    return spread((log.run == run) & (log.t_s >= at_s), weights(rng, 2), run=f"run{run + 1}", at_s=at_s)


def telegraph(log, rng):
    mean_s = rng.uniform(3600, 10800)
    state = np.cumsum(rng.random(len(log.t_s)) < SAMPLE_S / mean_s) % 2
    return spread(state, weights(rng, 2), mean_stay_s=mean_s)


SHAPES = {shape.__name__: shape for shape in (
    thermal_hysteresis, temperature_rate, warmup_transient, g_sensitivity, earth_rate, cross_axis, fixture_tilt,
    scale_nonlinearity, aging_drift, narrow_bump, gradient, position_memory, creep, drying_water, daily_wave, step,
    telegraph)}
EFFECTS = ("none", "sensor_lag", *SHAPES)


def sensor_lag(log, unit, size: float) -> tuple[np.ndarray, dict]:
    """The elements' node behind the thermometer's, with the time constant that reaches the size."""
    found, rows = bases(log), log.in_blocks

    def lagged(tau_s, taken):
        element_c = per_run(log, lambda temp_c: node(temp_c, tau_s, temp_c[0]), log.unit_c)[taken]
        force, rate = log.force_mps2[taken], log.rate_dps[taken]
        return (respond(unit, element_c, force, rate) - respond(unit, log.unit_c[taken], force, rate)) / BLOCK_SIGMA

    def missing(log_tau):
        blocks = lagged(np.exp(log_tau), rows).reshape(-1, BLOCK_SAMPLES, 6).mean(axis=1)
        return size_of(sizes_left(found, blocks), np.arange(6)) - size

    low, high = np.log(0.1), np.log(LONGEST_LAG_S)
    if missing(high) < 0:
        raise OutOfReach(f"sensor_lag reaches {missing(high) + size:.3g} at most in this design")
    tau_s = float(np.exp(brentq(missing, low, high, xtol=1e-5)))
    return lagged(tau_s, slice(None)), dict(tau_s=tau_s)


def hide(seed: int, log, unit, effect: str, size: float | None) -> tuple[np.ndarray, dict]:
    """The effect in blocks, scaled to its size, and what is true about it."""
    if effect == "none":
        return np.zeros((len(log.t_s), 6)), {}
    if effect == "sensor_lag":
        raw, found = sensor_lag(log, unit, size)
    else:
        raw, found = SHAPES[effect](log, stream(seed, "effect " + effect))
    affected = np.flatnonzero(np.any(raw != 0, axis=0))
    blocks = block_means(log, raw)
    sizes = sizes_left(bases(log, stiff=effect == "narrow_bump"), blocks)
    share = size_of(sizes, affected) / size_of(blocks.std(axis=0), affected)
    if share < 0.02:
        raise OutOfReach(f"the base absorbs {effect} but for {share:.2g} of it: this design cannot show it")
    scale = 1.0 if size is None or effect == "sensor_lag" else size / size_of(sizes, affected)
    return scale * raw, dict(
        parameters=found, scale=scale, size_reached=scale * size_of(sizes, affected),
        size_beyond_slopes=scale * size_of(sizes_left(bases(log, slopes=True), blocks), affected), share_not_absorbed=share,
        sensors=[SENSORS[k] for k in affected], sizes=dict(zip(SENSORS, (scale * sizes).tolist())),
        peak_to_peak=dict(zip(SENSORS, (scale * np.ptp(blocks, axis=0)).tolist())))


def make(seed: int, design: Design, effect: str = "none", size: float | None = None) -> Campaign:
    """One campaign. The same seed and design give the same unit, schedule and noise whatever is hidden."""
    if effect not in EFFECTS:
        raise ValueError(f"no effect {effect}; there are {', '.join(EFFECTS)}")
    if effect not in ("none", "earth_rate") and not (size and size > 0):
        raise ValueError(f"{effect} needs a size above 0")
    log, unit = campaign_log(seed, design), make_unit(seed)
    hidden, found = hide(seed, log, unit, effect, size)
    readings = respond(unit, log.unit_c, log.force_mps2, log.rate_dps)
    readings += BLOCK_SIGMA * (hidden + noise(seed, design, log))
    truth = dict(effect=effect, size=size if effect != "none" else None, seed=seed, design=asdict(design), **found,
                 block_sigma=dict(zip(SENSORS, BLOCK_SIGMA.tolist())), world=log.world, azimuths_deg=AZIMUTHS_DEG)
    return Campaign(design, log, hidden, readings, truth)


def csv_text(log, readings: np.ndarray) -> str:
    name = np.array([f"run{run + 1}" for run in range(len(log.slices))], dtype=object)[log.run]
    phase = np.where(log.kind == RAMP, "ramp", "soak")
    position = np.where(log.kind == TURN, "", np.array(POSITIONS)[log.position])
    columns = (log.t_s, name, phase, np.where(log.sweep > 0, "up", "down"), log.plateau_c, position, log.air_c,
               log.temp_c, *readings.T, log.powered_s, log.utc_s)
    rows = zip(*(column.tolist() for column in columns))
    return "\n".join([",".join(HEADER), *(ROW % row for row in rows)]) + "\n"


def columns_map() -> str:
    """What the laboratory knows of its fixture: a columns map with the headings of the positions."""
    return "[azimuths_deg]\n" + "".join(f'"{label}" = {azimuth}\n' for label, azimuth in AZIMUTHS_DEG.items())


def main() -> int:
    parser = argparse.ArgumentParser(description="writes one made-up campaign as CSV, and what is true about it as JSON")
    parser.add_argument("--out", required=True)
    parser.add_argument("--truth")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--effect", default="none", choices=EFFECTS)
    parser.add_argument("--size", type=float)
    choices = dict(positions=("fixed", "permuted"), ramps=("one", "two"), down=("all", "half"), slow_kind=SLOW_KINDS)
    for name, default in asdict(Design()).items():
        option = "--" + name.replace("_", "-")
        parser.add_argument(option, type=type(default), default=default, choices=choices.get(name))
    args = parser.parse_args()
    design = Design(**{name: getattr(args, name) for name in asdict(Design())})
    try:
        campaign = make(args.seed, design, args.effect, args.size)
    except ValueError as error:
        print(f"second_laboratory: {error}", file=sys.stderr)
        return 1
    Path(args.out).write_text(campaign.csv, encoding="utf-8")
    if args.truth:
        Path(args.truth).write_text(json.dumps(campaign.truth, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
