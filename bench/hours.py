# SPDX-License-Identifier: Apache-2.0
"""The table of `./run bench hours`: what campaigns cost and leave, from the lines of bench_hours."""
import csv
import math
import pathlib
import statistics
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests" / "blind"))
import intervals  # noqa: E402

CAMPAIGNS = ["full", "six-runs", "coarse", "ramp-cubic", "planned"]


def percentile(values, share):
    """The least value that so large a share of all do not exceed."""
    return sorted(values)[math.ceil(share * len(values)) - 1]


def table(rows):
    lines = ["| fleet | campaign | hours | of full | worst shape error over full's: median, 95th percentile | level error, rms deg/s | curve's band held | fresh band held |",
             "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for fleet in dict.fromkeys(row["fleet"] for row in rows):
        of = {c: [r for r in rows if r["fleet"] == fleet and r["campaign"] == c] for c in CAMPAIGNS}
        full = {r["unit"]: float(r["worst_shape_dps"]) for r in of["full"]}
        full_hours = float(of["full"][0]["hours"])
        for campaign in CAMPAIGNS:
            some = of[campaign]
            hours = float(some[0]["hours"])
            ratios = [float(r["worst_shape_dps"]) / full[r["unit"]] for r in some]
            level = statistics.fmean(float(r["level_dps"]) ** 2 for r in some) ** 0.5
            held = [intervals.share(sum(r[key] == "1" for r in some), sum(r[key] != "" for r in some)) for key in ("curve_held", "fresh_held")]
            lines.append(f"| {fleet} | {campaign} | {hours:.1f} | {hours / full_hours:.3f} | {statistics.median(ratios):.2f}, {percentile(ratios, 0.95):.2f} "
                         f"| {level:.4f} | {held[0]} | {held[1]} |")
    return "\n".join(lines)


def main():
    program, *options = sys.argv[1:]
    done = subprocess.run([program, *options], stdout=subprocess.PIPE, text=True, check=True)
    print(table(list(csv.DictReader(done.stdout.splitlines()))))


if __name__ == "__main__":
    main()
