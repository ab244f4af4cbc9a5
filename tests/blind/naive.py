# SPDX-License-Identifier: Apache-2.0
"""What quick statistics say of the same recording. A straw man on purpose, to show what the care of `soak gap` is for.

Rows are means of stays in a position, taken as independent and equally noisy. The base is a cubic in temperature and an
offset per run; for accelerometers also a scale error that is linear in temperature and two constant off-axis terms.
Each effect is one set of regressors, with a few shapes; its parameters are free in every sensor that it can hit. Ordinary
least squares; F test against the fit's own residual, p < 0.01 without regard to how many effects and shapes are tried.
The smallest p gives the name; it is one name at most.
"""
import numpy as np
from scipy import stats

GATE = 0.01
GYROS, ACCELEROMETERS, ALL = (0, 1, 2), (3, 4, 5), (0, 1, 2, 3, 4, 5)
WIDTHS_C = (5.0, 10.0, 20.0)
WARMUPS_S = (300.0, 1000.0, 3000.0)


def stay_means(blocks, values):
    """Means over the blocks of each stay; `values` (blocks,) or (blocks, any)."""
    count = np.bincount(blocks.stay)
    if values.ndim > 1:
        return np.column_stack([stay_means(blocks, column) for column in values.T])
    return np.bincount(blocks.stay, weights=values) / count


class Stays:
    """Means of stays: run, temp_c, up, readings (as in Blocks); rate_kps; memory by width; since_power_s; other logs."""

    def __init__(self, blocks):
        recording = blocks.recording
        self.run = np.round(stay_means(blocks, blocks.run)).astype(int)
        self.temp_c, self.up = stay_means(blocks, blocks.temp_c), np.round(stay_means(blocks, blocks.up))
        self.readings = stay_means(blocks, blocks.readings)

        def mean(column):
            return stay_means(blocks, blocks.mean(column))

        time_s, temp_c = recording.number("utc_s"), recording.number("temp_c")
        first_of_run = np.concatenate(([True], recording.text("run")[1:] != recording.text("run")[:-1]))
        self.rate_kps = mean(smoothed_rate(time_s, temp_c))
        self.memory = {width_c: mean(branch_memory(temp_c, first_of_run, width_c)) for width_c in WIDTHS_C}
        self.since_power_s = mean(recording.number("t_since_power_s"))
        self.logs = {name: mean(recording.number(name)) for name in ("compressor", "supply_v") if recording.has(name)}


def smoothed_rate(time_s, temp_c, rows=9):
    """Slope of the straight line through `rows` rows about each row."""
    kernel = np.ones(rows) / rows

    def smooth(values):
        return np.convolve(np.pad(values, rows // 2, mode="edge"), kernel, mode="valid")

    time_s = time_s - time_s[0]
    variance = smooth(time_s**2) - smooth(time_s) ** 2
    return (smooth(time_s * temp_c) - smooth(time_s) * smooth(temp_c)) / variance.clip(1.0)


def branch_memory(temp_c, first_of_run, width_c):
    """h of dh = (sign(dT) - h)(1 - e^(-|dT|/w)), 0 at the start of a run; steps below 0.05 K are noise."""
    memory, level, anchor_c = np.zeros(len(temp_c)), 0.0, temp_c[0]
    for row, now_c in enumerate(temp_c):
        if first_of_run[row]:
            level, anchor_c = 0.0, now_c
        step_c = now_c - anchor_c
        if abs(step_c) >= 0.05:
            level += (np.sign(step_c) - level) * (1.0 - np.exp(-abs(step_c) / width_c))
            anchor_c = now_c
        memory[row] = level
    return memory


def base_columns(stays, sensor):
    warmth = (stays.temp_c - 25.0) / 50.0
    columns = [warmth, warmth**2, warmth**3, *((stays.run == run).astype(float) for run in np.unique(stays.run))]
    if sensor >= 3:
        force, beside = stays.up[:, sensor % 3], [stays.up[:, (sensor + turn) % 3] for turn in (1, 2)]
        columns += [force, force * warmth, *beside]
    return np.column_stack(columns)


def earth_columns(stays, sensor):
    """Of the rotation of the Earth, in all gyros alike: the vertical part, and those along the two horizontal axes of a
    fixture that turns the axis after the vertical one, cyclically, always to the same heading."""
    before, after = stays.up[:, (sensor + 2) % 3], stays.up[:, (sensor + 1) % 3]
    return np.column_stack([stays.up[:, sensor], abs(before), after])


def tilt_columns(stays, sensor):
    """A small rotation per run, in all accelerometers alike."""
    turned = np.zeros((len(stays.run), 3))
    turned[:, (sensor + 1) % 3] = stays.up[:, (sensor + 2) % 3]
    turned[:, (sensor + 2) % 3] = -stays.up[:, (sensor + 1) % 3]
    return np.hstack([turned * (stays.run == run)[:, None] for run in np.unique(stays.run)])


def cross_columns(stays, sensor):
    return np.column_stack([stays.up[:, (sensor + turn) % 3] * (stays.temp_c - 25.0) for turn in (1, 2)])


def lag_column(stays, sensor):
    """Slope of the sensor's cubic times the rate of temperature: one time constant for all."""
    warmth = (stays.temp_c - 25.0) / 50.0
    cubic = np.linalg.lstsq(base_columns(stays, sensor), stays.readings[:, sensor], rcond=None)[0][:3]
    return (cubic[0] + 2.0 * cubic[1] * warmth + 3.0 * cubic[2] * warmth**2) * stays.rate_kps


def library(stays):
    """(name, sensors, shared parameters?, columns of a sensor) for every effect and shape that the recording allows."""
    entries = [("thermal_hysteresis", ALL, False, lambda sensor, column=column: column) for column in stays.memory.values()]
    entries += [("warmup_transient", ALL, False, lambda sensor, tau_s=tau_s: np.exp(-stays.since_power_s / tau_s))
                for tau_s in WARMUPS_S]
    entries += [("temperature_rate", ALL, False, lambda sensor: stays.rate_kps),
                ("sensor_lag", ALL, True, lambda sensor: lag_column(stays, sensor)),
                ("g_sensitivity", GYROS, False, lambda sensor: stays.up),
                ("earth_rate", GYROS, True, lambda sensor: earth_columns(stays, sensor)),
                ("cross_axis", ACCELEROMETERS, False, lambda sensor: cross_columns(stays, sensor)),
                ("fixture_tilt", ACCELEROMETERS, True, lambda sensor: tilt_columns(stays, sensor)),
                ("scale_nonlinearity", ACCELEROMETERS, False, lambda sensor: stays.up[:, sensor % 3] ** 2)]
    names = {"compressor": "vibration_rectification", "supply_v": "supply_sensitivity"}
    entries += [(names[log], ALL, False, lambda sensor, column=column: column) for log, column in stays.logs.items()]
    return entries


class Base:
    """The base fit of one sensor: its residual and what it leaves of columns, both over the residual's own scatter."""

    def __init__(self, stays, sensor):
        self.basis = np.linalg.qr(base_columns(stays, sensor))[0]
        residual = self.left(stays.readings[:, sensor])
        self.freedom = len(residual) - self.basis.shape[1]
        self.scatter = np.sqrt(residual @ residual / self.freedom)
        self.residual = residual / self.scatter

    def left(self, columns):
        return columns - self.basis @ (self.basis.T @ columns)


def gain(bases, sensors, shared, columns_of):
    """What the regressors take off the sum of squares, and their number."""
    parts = [bases[s].left(columns_of(s).reshape(len(bases[s].residual), -1)) / bases[s].scatter for s in sensors]
    residuals = [bases[s].residual for s in sensors]
    if shared:
        parts, residuals = [np.vstack(parts)], [np.concatenate(residuals)]
    total, number = 0.0, 0
    for part, residual in zip(parts, residuals):
        fitted, _, rank, _ = np.linalg.lstsq(part, residual, rcond=1e-8)
        total, number = total + residual @ (part @ fitted), number + rank
    return total, number


def quick_name(blocks):
    """{"name": of the smallest p or None beyond the gate, "log_p": its natural logarithm}."""
    stays = Stays(blocks)
    bases = [Base(stays, sensor) for sensor in ALL]
    squares, freedom = (sum(values) for values in zip(*((b.residual @ b.residual, b.freedom) for b in bases)))
    found = []
    for name, sensors, shared, columns_of in library(stays):
        gained, number = gain(bases, sensors, shared, columns_of)
        f = gained / number / ((squares - gained) / (freedom - number)) if number else 0.0
        found.append((float(stats.f.logsf(f, max(number, 1), freedom - number)), name))
    log_p, name = min(found)
    return {"name": name if log_p < np.log(GATE) else None, "log_p": log_p}
