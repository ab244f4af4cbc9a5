#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The demo: a soak campaign in the simulated laboratory, over real protocols, from the pre-flight to calibration files
that are verified against a run which no fit has seen. Their errors are printed against the truth that only the simulator
knows. Everything is done by the release programs; this script only calls them and compares.

Exit status 1 if the worst gyro shape ratio is above 1/100 or any program fails.
"""
import argparse
import json
import math
import os
import subprocess
import sys
import time

from lab_session import IS_CHECKOUT, ROOT, LabSession, ProgramFailed, bin_folder, call, fresh_folder, page_address, procedure

SHAPE_LIMIT = 0.01
RATE = 20000
SENSORS = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]


def step(text):
    print(f"-- {text}", flush=True)


def call_json(*words):
    return json.loads(call(*words, "--json"))


def recording_folder():
    base = os.environ.get("SOAK_TEST_DATA", os.path.join(os.path.dirname(ROOT), "shared", "data"))
    path = os.path.join(base, "thermal_chamber_cycle", "imu_raw_data.csv")
    return path if os.path.exists(path) else None


def shape_errors(truth_temps, truth_values, temps, values):
    """Largest error, the temperature of it, and mean error, which is removed from the first; temps lie on the truth's grid."""
    grid = {round(t, 3): v for t, v in zip(truth_temps, truth_values)}
    errors = [v - grid[round(t, 3)] for t, v in zip(temps, values)]
    mean = sum(errors) / len(errors)
    worst, temp_c = max((abs(e - mean), t) for e, t in zip(errors, temps))
    return worst, temp_c, mean


def check_with_stranger(serial, blob):
    """Largest difference, in spans of the curve, between `soak eval` and the reader written from docs/blob-format.md."""
    sys.path.insert(0, os.path.join(ROOT, "tests", "cli"))
    import blob_reader
    with open(blob, "rb") as f:
        stranger = blob_reader.Calibration.load(f.read())
    temps = [-40 + 0.25 * i for i in range(480)]
    points = call_json("soak", "eval", blob, "--temp-c", ",".join(map(str, temps)))["points"]
    worst = 0.0
    for sensor in stranger.sensors:
        unit = math.degrees(1) if sensor.startswith("gyro") else 1.0
        pairs = [[(p["bias"][sensor], stranger.bias(sensor, t)[0] * unit) for p, t in zip(points, temps)]]
        if points[0]["scale_ppm"][sensor] is not None:
            pairs.append([(p["scale_ppm"][sensor], stranger.scale_ppm(sensor, t)[0]) for p, t in zip(points, temps)])
        for curve in pairs:
            span = max(b for _, b in curve) - min(b for _, b in curve)
            worst = max(worst, max(abs(a - b) for a, b in curve) / span)
    print(f"{serial}: a reader written from docs/blob-format.md alone differs by at most {worst:.1e} of a curve's span")
    if worst > 1e-6:
        sys.exit("that is more than 1e-6")


def compare(serial, blob, truth, runs):
    """Rows of the table for one unit: its file, read by the runtime, against the truth where the file states its range."""
    unit = next(u["sensors"] for u in truth["units"] if u["unit"] == serial)
    shown = call_json("soak", "eval", blob, "--temp-c", "25")["points"][0]["bias"]
    temps = [t for t in truth["temp_c"] if -29.5 <= t <= 69.5]
    points = call_json("soak", "eval", blob, "--temp-c", ",".join(str(t) for t in temps))["points"]
    points = [p for p in points if p["in_range"]]
    temps = [p["temp_c"] for p in points]
    rows = []
    for sensor in SENSORS:
        if sensor not in shown:
            continue
        sensor_truth = unit[sensor]
        worst, at_c, mean = shape_errors(truth["temp_c"], sensor_truth["bias"], temps, [p["bias"][sensor] for p in points])
        span = sensor_truth["uncompensated_span"]
        rows.append({"unit": serial, "sensor": sensor, "span": span, "worst_shape": worst, "at_c": at_c, "ratio": worst / span,
                     "absolute": abs(mean), "absolute_limit": 2 * sensor_truth["power_on_sigma"] / math.sqrt(runs)})
    return rows


def print_table(rows, fits):
    print(f"\n{'unit':10}{'sensor':9}{'model':8}{'rules':>5}{'span':>9}{'worst shape':>13}{'at °C':>8}{'ratio':>9}"
          f"{'level error':>13}{'2σ/√R':>9}")
    for r in rows:
        fit = fits[r["unit"]]["sensors"][r["sensor"]]
        unit = "deg/s" if r["sensor"].startswith("gyro") else "m/s2"
        print(f"{r['unit']:10}{r['sensor']:9}{fit['deployed']:8}{fit['rules']:5}{r['span']:9.3f}{r['worst_shape']:13.5f}{r['at_c']:8.2f}"
              f"{'1/%.0f' % (1 / r['ratio']):>9}{r['absolute']:13.5f}{r['absolute_limit']:9.4f}  {unit}")
    print("Worst shape error every 0.25 °C of the file's valid range between −29.5 and 69.5 °C, against the noise-free curve, "
          "the mean removed:\nthat is the run-to-run bias, which no thermal model removes; it stands beside its limit, two "
          "standard deviations of the mean over the runs.")


def run_campaign(lab, name, procedure_name):
    """Begins a campaign and waits for its end, showing what `soak campaign watch` shows on a terminal."""
    print(lab.soak("campaign", "start", procedure(procedure_name), "--name", name).splitlines()[0], flush=True)
    started = time.monotonic()
    watch = subprocess.run([os.path.join(bin_folder(), "soak"), "campaign", "watch"], env=lab.env,
                           stdout=subprocess.DEVNULL, stderr=None if sys.stderr.isatty() else subprocess.PIPE, text=True)
    if watch.returncode != 0:
        raise ProgramFailed(f"campaign {name} ended with status {watch.returncode}: {watch.stderr or ''}\n{lab.log()}")
    print(f"finished after {time.monotonic() - started:.0f} s", flush=True)


def campaigns(options, folder):
    """The laboratory's part. Returns what soaksim-truth says."""
    units = 1 if options.small else 3
    with LabSession(folder, options.seed, units, RATE, page_address()) as lab:
        step(f"simulated laboratory (seed {options.seed}) and station run; look at {lab.page} meanwhile")
        step("campaign: -30 to +70 °C and back by 5 °C, six positions each, 6 runs; a second of the clock is "
             f"{RATE} s in the chamber")
        run_campaign(lab, "demo", "six-position-demo")
        step("verification: one run between the plateaus, which no fit sees")
        run_campaign(lab, "demo-verification", "verification-demo")
        truth = lab.truth()
    with open(os.path.join(folder, "truth.json"), "w", encoding="utf-8") as f:
        json.dump(truth, f)
    return truth


def calibrate(folder, truth):
    """From stored runs to calibration files: rows of the table and the fits' documents."""
    data = os.path.join(folder, "data")
    rows, fits = [], {}
    for serial in [u["unit"] for u in truth["units"]]:
        step(f"unit {serial}: fit, verify, release, export")
        fits[serial] = call_json("soak", "fit", "--unit", serial, "--campaign", "demo", "--data", data)
        print(call("soak", "verify", "--unit", serial, "--campaign", "demo-verification", "--data", data), end="")
        call("soak", "release", "--unit", serial, "--data", data)
        for format, ending in (("blob", "soakcal"), ("c", "h"), ("json", "json")):
            call("soak", "export", "--unit", serial, "--format", format, "--simulated", "--data", data,
                 "-o", os.path.join(folder, f"{serial}.{ending}"))
        blob = os.path.join(folder, f"{serial}.soakcal")
        check_with_stranger(serial, blob)
        runs = len(fits[serial]["sensors"]["gyro_x"]["runs"])
        rows += compare(serial, blob, truth, runs)
    print_table(rows, fits)
    return rows


def real_recording(folder):
    path = recording_folder()
    if path is None:
        step("the real chamber recording is not here: skipped")
        return
    step("the real chamber recording: cool, heat, cool, one attitude")
    data = os.path.join(folder, "data")
    call("soak", "import", path, "--columns", os.path.join(ROOT, "procedures", "columns", "thermal-chamber-cycle.toml"),
         "--unit", "CHAMBER-1", "--campaign", "recording", "--gravity-mps2", "9.806", "--data", data)
    fit = call_json("soak", "fit", "--unit", "CHAMBER-1", "--data", data)
    print(f"RMS error on the branch held out (deg/s, m/s2)\n{'sensor':9}{'held out':32}{'anfis':>9}{'poly3':>9}{'poly5':>9}{'spline':>9}")
    for sensor, result in fit["sensors"].items():
        for check in result["checks"]:
            cells = "".join(f"{check[k]:9.4f}" if check[k] is not None else f"{'-':>9}"
                            for k in ("anfis", "poly3", "poly5", "spline"))
            print(f"{sensor:9}{check['held_out']:32}{cells}")
    for sensor, result in fit["sensors"].items():
        for warning in result["warnings"]:
            if warning["code"] == "hysteresis":
                print("warning:", warning["text"])


def run(options):
    started = time.monotonic()
    folder = fresh_folder(os.path.join(ROOT, "build", "demo") if IS_CHECKOUT else os.path.abspath("soak-demo"))
    rows = calibrate(folder, campaigns(options, folder))
    real_recording(folder)
    worst = max((r for r in rows if r["sensor"].startswith("gyro")), key=lambda r: r["ratio"])
    verdict = "within" if worst["ratio"] <= SHAPE_LIMIT else "ABOVE"
    here = os.path.relpath(folder, os.getcwd())
    programs = "build/release/bin/" if IS_CHECKOUT else ""
    print(f"\nworst gyro shape ratio 1/{1 / worst['ratio']:.0f} ({worst['unit']} {worst['sensor']}), {verdict} 1/100; "
          f"{time.monotonic() - started:.0f} s\n"
          f"calibration files: {here}/*.soakcal, *.h, *.json\n"
          f"stored runs:       {programs}soak runs list --data {here}/data\n"
          f"page:              {programs}soakd --config {here}/station.toml --data {here}/data")
    return 0 if worst["ratio"] <= SHAPE_LIMIT else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--small", action="store_true", help="one unit instead of three")
    parser.add_argument("--seed", type=int, default=1, help="seed of the simulated laboratory (default 1)")
    try:
        return run(parser.parse_args())
    except ProgramFailed as error:
        print(error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
