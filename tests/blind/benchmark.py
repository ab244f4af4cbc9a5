#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The blind benchmark of the gap workflow: how often `soak gap find` is right, with exact binomial intervals.

Campaigns are made up by soaksim-campaign (hal/sim, which shares nothing with calib but its vocabulary), reach soak as
CSV through `soak import`, and the truth stays with this program. Seeds from --first on.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import statistics
import sys
import time

from blind_campaign import Programs, judge

ROOT = pathlib.Path(__file__).resolve().parents[2]
DESIGNS = {"identical": {}, "mixed": {"kind": "mixed"}, "three": {"kind": "three"}, "missing_logs": {"kind": "missing_logs"},
           "drift x 3": {"drift_factor": 3.0}, "strength varies": {"amplitude_spread": 0.3}, "dropped visit": {"dropped_visit": True},
           "wrong position": {"wrong_position": True}, "whole degrees": {"thermometer_step_c": 1.0}}
STRESS = ("drift x 3", "strength varies", "dropped visit", "wrong position", "whole degrees")
EFFECTS = ("thermal_hysteresis", "temperature_rate", "sensor_lag", "warmup_transient", "g_sensitivity", "earth_rate", "cross_axis",
           "fixture_tilt", "scale_nonlinearity", "vibration_rectification", "supply_sensitivity")
UNKNOWN = ("reposition_creep", "position_memory", "daily_wave", "telegraph_noise", "bias_step", "moisture", "gradient_rate")


def binomial_tail(k, n, p):
    """P(X >= k) of n trials."""
    return math.fsum(math.comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k, n + 1))


def bound(k, n, upper):
    """End of the exact (Clopper-Pearson) 95 % interval for k of n."""
    if upper and k == n:
        return 1.0
    if not upper and k == 0:
        return 0.0
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = 1.0 - binomial_tail(k + 1, n, middle) > 0.025 if upper else binomial_tail(k, n, middle) < 0.025
        low, high = (middle, high) if inside else (low, middle)
    return low


def share(k, n):
    if n == 0:
        return "-"
    return f"{k}/{n} = {100 * k / n:.1f} % ({100 * bound(k, n, False):.1f}..{100 * bound(k, n, True):.1f})"


class Case:
    def __init__(self, table, design, seed, hidden):
        self.table, self.design, self.seed, self.hidden = table, design, seed, hidden
        self.report = self.seconds = None

    def run(self, programs):
        start = time.monotonic()
        self.report, self.truth = judge(programs, self.seed, DESIGNS[self.design], self.hidden)
        self.seconds = time.monotonic() - start
        return self

    def names(self):
        return [effect["name"] for effect in self.report["effects"]]

    def first_right(self):
        return self.names()[:1] == [self.hidden[0]["effect"]]


def cases(options):
    seed = options.first
    for design in DESIGNS:
        for _ in range(options.nulls):
            yield Case("null", design, seed, [])
            seed += 1
    for design in DESIGNS:
        for effect in EFFECTS:
            # Beyond 0.6 more than the Earth turns would have to be hidden.
            for magnitude in options.magnitudes if effect != "earth_rate" else [m for m in options.magnitudes if m <= 0.6]:
                for _ in range(options.seeds if design not in STRESS else options.stress_seeds):
                    yield Case("named", design, seed, [{"effect": effect, "magnitude": magnitude, "seed": seed}])
                    seed += 1
    for effect in UNKNOWN:
        for magnitude in (1.2, 2.4):
            for _ in range(options.seeds):
                yield Case("unknown", "identical", seed, [{"effect": effect, "magnitude": magnitude, "seed": seed}])
                seed += 1


def print_nulls(done):
    print("\nFalse names where nothing is hidden (exact 95 % interval), and campaigns called unknown")
    for design in DESIGNS:
        found = [case for case in done if case.table == "null" and case.design == design]
        print(f"  {design:16} {share(sum(bool(case.names()) for case in found), len(found)):36}"
              f" unknown {sum(case.report['verdict'] == 'unknown' for case in found)}")


def print_named(done, magnitudes):
    print("\nNamed first, where it is hidden")
    for design in DESIGNS:
        for magnitude in magnitudes:
            found = [c for c in done if c.table == "named" and c.design == design and c.hidden[0]["magnitude"] == magnitude]
            named = [c for c in found if c.names()]
            right = sum(c.first_right() for c in found)
            if found:
                print(f"  {design:16} {magnitude:4} {share(right, len(found)):36} right when it names one {share(right, len(named))}")
    print("\nBy effect, all designs: named first at each magnitude")
    for effect in EFFECTS:
        row = []
        for magnitude in magnitudes:
            found = [c for c in done if c.table == "named" and c.hidden[0]["effect"] == effect and c.hidden[0]["magnitude"] == magnitude]
            row.append(f"{sum(c.first_right() for c in found)}/{len(found)}")
        print(f"  {effect:24} " + "  ".join(row))


def closed_fractions(case):
    """Of the sensors that the named effect hits."""
    sensors = case.report["effects"][0]["sensors"]
    values = [case.report["gap"][sensor]["closed_fraction"] for sensor in sensors if sensor in case.report["gap"]]
    return [value for value in values if value is not None]


def print_closed(done, magnitudes):
    print("\nClosed fraction on held-out runs where the name is right: median over campaigns and sensors")
    for magnitude in magnitudes:
        values = [value for case in done if case.table == "named" and case.hidden[0]["magnitude"] == magnitude and case.first_right()
                  for value in closed_fractions(case)]
        print(f"  {magnitude:4} " + (f"{statistics.median(values):.2f} of {len(values)}" if values else "-"))


def print_unknown(done):
    print("\nUnknown effects: called unknown; given a false name; passed over")
    for effect in UNKNOWN:
        found = [c for c in done if c.table == "unknown" and c.hidden[0]["effect"] == effect]
        verdicts = [c.report["verdict"] for c in found]
        print(f"  {effect:18} {share(verdicts.count('unknown'), len(found)):34} named {verdicts.count('named')}  none {verdicts.count('none')}")


def main():
    parser = argparse.ArgumentParser(prog="./run bench gap", description=__doc__.split("\n")[0])
    parser.add_argument("--bin", default=str(ROOT / "build" / "release" / "bin"), help="folder of the programs")
    parser.add_argument("--first", type=int, default=100000, help="first seed")
    parser.add_argument("--nulls", type=int, default=500, help="campaigns without effect, per design")
    parser.add_argument("--seeds", type=int, default=20, help="campaigns per effect and magnitude")
    parser.add_argument("--stress-seeds", type=int, default=5, help="the same in the stress designs")
    parser.add_argument("--magnitudes", type=float, nargs="+", default=[0.3, 0.6, 1.2], help="RMS over the repeatability of a block")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("-o", "--output", help="write every verdict as JSON, a line each")
    options = parser.parse_args()
    programs = Programs(options.bin, ROOT / "hal" / "sim" / "lab.toml")
    done = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for case in pool.map(lambda case: case.run(programs), list(cases(options))):
            done.append(case)
            if sys.stderr.isatty():
                print(f"\r{len(done)} campaigns", end="", file=sys.stderr)
    if options.output:
        lines = [json.dumps({"table": c.table, "design": c.design, "seed": c.seed, "hidden": c.hidden, "verdict": c.report["verdict"],
                             "names": c.names(), "leftover": c.report["leftover"]}) for c in done]
        pathlib.Path(options.output).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{len(done)} campaigns, seeds from {options.first}; {statistics.mean(c.seconds for c in done):.2f} s each, all programs together")
    print_nulls(done)
    print_named(done, options.magnitudes)
    print_closed(done, options.magnitudes)
    print_unknown(done)


if __name__ == "__main__":
    main()
