# SPDX-License-Identifier: Apache-2.0
"""How often the intervals that a fit states hold the truth: what tests and tools/prove/parameters share.

One campaign per seed, made by tests/blind/six_positions.py, goes through the programs as a user runs them: soak reference
add, soak import, soak fit --json. Each interval is asked for at one temperature per curve, drawn from the seed: points of
one curve are not independent, but the draws of different units are, and their count is binomial.
"""
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "blind"))
import six_positions  # noqa: E402

GYROS = ("gyro_x", "gyro_y", "gyro_z")
ACCELS = ("accel_x", "accel_y", "accel_z")


def upper_tail(n, k, p):
    """P(X >= k) of a binomial."""
    if k <= 0:
        return 1.0
    terms = [math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1) + i * math.log(p) + (n - i) * math.log1p(-p)
             for i in range(k, n + 1)]
    return min(1.0, sum(map(math.exp, terms)))


def fewest_inside(n, share=0.95, chance=0.01):
    """The smallest count that n independent intervals of that share still allow: fewer come with less than `chance`."""
    k = n
    while k > 0 and 1.0 - upper_tail(n, k, share) >= chance:  # P(X <= k - 1)
        k -= 1
    return k


def clopper_pearson(n, k, level=0.95):
    """Exact interval of a share of which k of n were seen."""
    tail = (1.0 - level) / 2.0

    def solve(goal, reached):
        low, high = 1e-12, 1.0 - 1e-12
        for _ in range(200):
            middle = (low + high) / 2.0
            low, high = (middle, high) if reached(middle) < goal else (low, middle)
        return low

    lower = 0.0 if k == 0 else solve(tail, lambda p: upper_tail(n, k, p))
    upper = 1.0 if k == n else solve(1.0 - tail, lambda p: upper_tail(n, k + 1, p))
    return lower, upper


# Kinds of interval that allow for more than the campaigns draw, and so may hold the truth too often. Along the axis the
# mean of four runs has Student's factor, 3.18, also where what they read is noisier than what they scatter by. Off the axis
# the Earth's horizontal rotation enters as if a pair of faces had it whole, and a sine is never beyond 1.41 of its standard
# deviation.
MAY_BE_WIDE = ("g-sensitivity, own axis", "g-sensitivity, others")


class Coverage:
    """Counts, by kind of interval."""

    def __init__(self):
        self.seen = {}

    def add(self, kind, error, half_width):
        inside, count, squares = self.seen.get(kind, (0, 0, 0.0))
        self.seen[kind] = (inside + (abs(error) <= half_width), count + 1, squares + (error / half_width) ** 2)

    def merge(self, other):
        for kind, (inside, count, squares) in other.seen.items():
            mine = self.seen.get(kind, (0, 0, 0.0))
            self.seen[kind] = (mine[0] + inside, mine[1] + count, mine[2] + squares)


def interpolate(x, y, at):
    i = min(max(sum(value <= at for value in x) - 1, 0), len(x) - 2)
    return y[i] + (y[i + 1] - y[i]) * (at - x[i]) / (x[i + 1] - x[i])


def run(*arguments, **options):
    return subprocess.run(list(map(str, arguments)), check=True, capture_output=True, text=True, **options).stdout


def fitted(folder, seed, runs, units, rows):
    """Truth and the fits of a campaign, by serial number."""
    soak, data = os.environ["SOAK_BIN"], ["--data", folder / "data"]
    truth, texts = six_positions.campaign(seed, runs, units, rows)
    for kind, u, *correction in (("fixture_squareness", six_positions.FACE_U_DEG), ("level", six_positions.LEVEL_U_DEG),
                                 ("gravity", six_positions.GRAVITY_U_MPS2, "--correction", truth["gravity_mps2"])):
        run(soak, "reference", "add", "--kind", kind, "--name", kind, "--certificate", "1", "--issued", "2026-01-01", "--due",
            "2200-01-01", "--uncertainty", 2 * u, *correction, *data)
    fits = {}
    for serial, text in texts.items():
        recording = folder / f"{serial}.csv"
        recording.write_text(text, encoding="utf-8")
        run(soak, "import", recording, "--unit", serial, "--references", "--latitude-deg", six_positions.LATITUDE_DEG, *data)
        fits[serial] = json.loads(run(soak, "fit", "--unit", serial, "--json", *data))
    return truth, fits


def count_curves(coverage, truth, unit, fit, draw):
    for name, sensor in unit["sensors"].items():
        kind = name.split("_")[0]
        point = draw.choice(fit["sensors"][name]["curve"])
        error = point["bias"] - interpolate(truth["temp_c"], sensor["bias"], point["temp_c"])
        coverage.add(f"{kind} bias, ci95", error, point["ci95"])
        # The verification run's power-on is one that the fit has not seen.
        coverage.add(f"{kind} bias, pi95", error - sensor["verification_power_on_offset"], point["pi95"])
        if sensor["scale_ppm"] is not None:
            error = point["scale_ppm"] - interpolate(truth["temp_c"], sensor["scale_ppm"], point["temp_c"])
            coverage.add(f"{kind} scale, ci95", error, point["scale_ci95_ppm"])


def count_constants(coverage, unit, fit, draw):
    """One entry per sensor: those of a row come from the same segments."""
    for key, field, sensors in (("accel_misalignment_rad", "misalignment_rad", ACCELS),
                                ("g_sensitivity_dps_per_g", "g_sensitivity_dps_per_g", GYROS)):
        for i, name in enumerate(sensors):
            own = draw.random() < 0.5
            j = i if sensors is GYROS and own else (i + draw.choice((1, 2))) % 3
            kind = "misalignment" if sensors is ACCELS else "g-sensitivity, own axis" if j == i else "g-sensitivity, others"
            error, half = fit[key]["value"][i][j] - unit["sensors"][name][field][j], fit[key]["ci95"][i][j]
            coverage.add(kind, error, half)


def coverage_of(seed, runs, units=1, rows=10):
    """Counts of one campaign."""
    coverage = Coverage()
    draw = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="soak-truth-") as folder:
        truth, fits = fitted(pathlib.Path(folder), seed, runs, units, rows)
    for unit in truth["units"]:
        count_curves(coverage, truth, unit, fits[unit["unit"]], draw)
        count_constants(coverage, unit, fits[unit["unit"]], draw)
    return coverage
