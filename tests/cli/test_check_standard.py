# SPDX-License-Identifier: Apache-2.0
"""soak check: check standards, their control charts, in-run drift at the reference plateau."""
import functools
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import tempfile
import unittest

from soak_cli import HEADER, SoakTest

UPS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
SENSORS = ["accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"]
SCATTER_DPS = 0.01  # of gyro_x from campaign to campaign
SCATTER_MPS2 = 0.005
GOOD = 12  # campaigns in control


def campaign(level_dps, level_mps2=0.0, runs=1, plateaus=(25, 15, 35, 25), drift_dps=0.0, seed=1):
    """A recording with `level_dps` in the bias of gyro_x and `level_mps2` in that of accel_z; gyro_x drifts by
    `drift_dps` over the run. 12 s at 1 Hz in each position."""
    noise = random.Random(seed)
    lines = [HEADER]
    t = 0.0
    for run in range(1, runs + 1):
        for visit, plateau in enumerate(plateaus):
            drift = drift_dps * visit / (len(plateaus) - 1)
            for label, up in UPS.items():
                for _ in range(12):
                    gyro = [0.3 + level_dps + 0.002 * plateau + drift, 0.1, -0.1]
                    force = [9.80665 * u + 0.05 for u in up]
                    force[2] += level_mps2
                    numbers = ",".join(f"{x + noise.gauss(0, 0.001):.6f}" for x in gyro + force)
                    lines.append(f"{t:.0f},R{run:02},soak,,{plateau},{label},{plateau},{plateau + 2 + noise.gauss(0, 0.02):.3f},{numbers}")
                    t += 1
            t += 600
    return "\n".join(lines) + "\n"


def levels(seed=7):
    """What the campaigns in control scatter by: within 2 sigma, so that no seed makes a false alarm, alternating so
    that there is no run."""
    noise = random.Random(seed)
    return [(-1) ** i * noise.uniform(0.2, 1.5) for i in range(GOOD)]


@functools.cache
def folder_in_control():
    """A data folder with twelve campaigns of unit CS1, which is no check standard yet."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-check-"))
    for i, level in enumerate(levels()):
        path = folder / "c.csv"
        path.write_text(campaign(SCATTER_DPS * level, SCATTER_MPS2 * level, drift_dps=0.02, seed=i), encoding="utf-8")
        subprocess.run([os.environ["SOAK_BIN"], "import", str(path), "--unit", "CS1", "--campaign", f"c{i:02}",
                        "--gravity-mps2", "9.80665", "--data", str(folder / "data")], check=True, capture_output=True)
    return folder


def tearDownModule():
    if folder_in_control.cache_info().currsize:
        shutil.rmtree(folder_in_control(), ignore_errors=True)


def prediction_limits(values):
    """Second implementation: mean ± t s sqrt(1 + 1/n), t for 1/1200 in both tails (SciPy's stats.t.isf(1/2400, n - 1))."""
    n = len(values)
    half = {10: 4.912355190, 11: 4.706482565}[n] * statistics.stdev(values) * (1 + 1 / n) ** 0.5
    centre = statistics.mean(values)
    return centre, centre - half, centre + half


class CheckStandard(SoakTest):
    def with_history(self):
        shutil.copytree(folder_in_control() / "data", self.data)
        self.soak("check", "declare", "CS1", "--reason", "test")

    def add(self, name, text, unit="CS1", *arguments):
        path = self.write(f"{name}.csv", text)
        self.soak("import", path, "--unit", unit, "--campaign", name, "--gravity-mps2", "9.80665", *arguments)

    def chart(self, *arguments):
        units = self.soak_json("check-chart", "check", "chart", *arguments)["units"]
        self.assertEqual(len(units), 1)
        return units[0]

    def last(self, sensor="gyro_x"):
        campaign = self.chart()["campaigns"][-1]
        return campaign, campaign["sensors"][sensor]

    def test_ten_campaigns_are_not_established_and_the_next_are_judged_by_those_before(self):
        self.with_history()
        chart = self.chart()
        self.assertEqual((chart["unit"], chart["epoch"], chart["ended"]), ("CS1", 0, False))
        self.assertEqual([c["campaign"] for c in chart["campaigns"]], [f"c{i:02}" for i in range(GOOD)])
        self.assertEqual([c["verdict"] for c in chart["campaigns"]], ["not_established"] * 10 + ["in_control"] * 2)
        biases = []
        for number, (campaign, level) in enumerate(zip(chart["campaigns"], levels())):
            self.assertEqual(sorted(campaign["sensors"]), SENSORS)
            point = campaign["sensors"]["gyro_x"]
            # 0.3 + 0.002 per degree of set point, and half the in-run drift of 0.02. Noise 0.001 on 144 samples, and
            # the error of temperatures carried: 0.02 / sqrt(12) K at 0.002 per K: below 2e-4, four times that.
            self.assertAlmostEqual(point["bias"], 0.35 + 0.01 + SCATTER_DPS * level, delta=8e-4)
            if number >= 10:
                centre, lower, upper = prediction_limits(biases)
                self.assertEqual(point["limits"]["campaigns"], number)
                self.assertAlmostEqual(point["limits"]["centre"], centre, places=9)
                self.assertAlmostEqual(point["limits"]["lower"], lower, delta=1e-5 * (upper - lower))
                self.assertAlmostEqual(point["limits"]["upper"], upper, delta=1e-5 * (upper - lower))
            else:
                self.assertIsNone(point["limits"])
            if biases:
                self.assertAlmostEqual(point["moving_range"], abs(point["bias"] - biases[-1]), places=9)
            else:
                self.assertIsNone(point["moving_range"])
            biases.append(point["bias"])

    def test_drift_within_a_run_is_last_minus_first_visit(self):
        self.with_history()
        for campaign in self.chart()["campaigns"]:
            run, = campaign["runs"]
            self.assertEqual((run["run"], run["at_both_ends"], run["visits"]), ("R01", True, [0, 3]))
            for name, truth in (("gyro_x", 0.02), ("gyro_y", 0.0)):
                sensor = run["sensors"][name]
                # Two means of 72 readings of noise 0.001 each, and the temperatures carried: as above.
                self.assertAlmostEqual(sensor["drift"], truth, delta=1e-3)
                self.assertEqual(campaign["sensors"][name]["drift"], sensor["drift"])
                self.assertLess(sensor["drift_se"], 1e-3)

    def test_a_drift_that_repeats_in_each_run_shows_in_the_fit_only_with_reference_visits(self):
        up = list(range(-30, 71, 10))
        shape = {}
        for name, plateaus in (("without", up), ("with", [25, *up, 25])):
            self.add(name, campaign(0.0, runs=4, plateaus=plateaus, drift_dps=0.02), name)
            shape[name] = self.soak_json("fit", "fit", "--unit", name)["sensors"]["gyro_x"]["check_rmse_shape"]
        # Without: the drift is a function of the temperature, and goes into the curve. The noise of a bias is 1e-4.
        self.assertLess(shape["without"], 5e-4)
        # With: three values 0.01 apart at 25 degrees in 13 rows; their own scatter alone is 0.02/sqrt(2)/sqrt(13) = 0.004.
        self.assertGreater(shape["with"], 0.002)

    def test_a_campaign_far_away_is_out_of_control_and_stays_out_of_later_limits(self):
        self.with_history()
        self.add("bad", campaign(0.2))
        found, point = self.last()
        self.assertEqual((found["verdict"], point["verdict"]), ("out_of_control", "out_of_control"))
        self.assertEqual((point["beyond_limits"], point["shifted"]), (True, False))
        self.assertEqual(found["sensors"]["gyro_y"]["verdict"], "in_control")
        text = self.soak("check", "chart").stdout
        self.assertEqual(len([line for line in text.splitlines() if line.strip().startswith("bad") and "OUT OF CONTROL" in line]), 1)
        self.add("after", campaign(0.0, seed=50))
        after, point = self.last()
        self.assertEqual(after["verdict"], "in_control")
        self.assertEqual(point["limits"]["campaigns"], GOOD)

    def test_a_fit_of_any_unit_of_such_a_campaign_warns(self):
        self.with_history()
        self.add("bad", campaign(0.2))
        self.add("bad", campaign(0.0, seed=9).replace(",R01,", ",B01,"), "SN2")
        self.add("good", campaign(0.0, seed=9).replace(",R01,", ",B02,"), "SN3")
        for unit, warned in (("SN2", True), ("SN3", False)):
            codes = [w["code"] for w in self.soak_json("fit", "fit", "--unit", unit)["warnings"]]
            self.assertEqual("check_standard_out_of_control" in codes, warned, unit)

    def test_a_shift_within_the_limits_is_found_by_the_last_eight(self):
        self.with_history()
        for i in range(8):
            self.add(f"shift{i}", campaign(3.0 * SCATTER_DPS, 3.0 * SCATTER_MPS2, seed=100 + i))
        points = [c["sensors"]["gyro_x"] for c in self.chart()["campaigns"][GOOD:]]
        self.assertEqual({point["beyond_limits"] for point in points}, {False})
        self.assertIsNone(points[4]["last_eight"])  # nine campaigns before the last eight
        self.assertEqual(points[5]["last_eight"]["campaigns"], 10)
        self.assertEqual((points[7]["shifted"], points[7]["verdict"]), (True, "out_of_control"))
        self.assertAlmostEqual(points[7]["last_eight"]["mean"], statistics.mean(point["bias"] for point in points), places=9)
        self.assertIn("shifted", self.soak("check", "chart").stdout)

    def test_a_voided_run_is_off_the_chart(self):
        self.with_history()
        self.add("bad", campaign(0.2).replace(",R01,", ",B01,"))
        self.soak("runs", "void", "B01", "--unit", "CS1", "--reason", "door was open")
        self.assertEqual([c["campaign"] for c in self.chart()["campaigns"]][-1], f"c{GOOD - 1:02}")

    def test_mean_and_standard_error_are_those_of_the_runs(self):
        self.soak("unit", "add", "CS1")
        self.soak("check", "declare", "CS1", "--reason", "test")
        self.add("three", campaign(0.0, runs=3))
        found, point = self.last()
        biases = [run["sensors"]["gyro_x"]["bias"] for run in found["runs"]]
        temps = [run["sensors"]["gyro_x"]["temp_c"] for run in found["runs"]]
        self.assertEqual(len(biases), 3)
        mean = sum(biases) / 3
        # Carried by hundredths of a kelvin at 0.002 deg/s per K.
        self.assertAlmostEqual(point["bias"], mean, delta=0.002 * (max(temps) - min(temps)))
        scatter = (sum((bias - mean) ** 2 for bias in biases) / 2 / 3) ** 0.5
        self.assertAlmostEqual(point["bias_se"], scatter, delta=0.002 * (max(temps) - min(temps)))
        self.assertAlmostEqual(self.chart()["temp_c"]["gyro_x"], sum(temps) / 3, places=9)

    def test_without_reference_visits_the_nearest_plateau_is_carried_to_the_same_temperature(self):
        self.with_history()
        self.add("near", campaign(0.0, plateaus=(13, 23, 33, 43)))
        found, point = self.last()
        self.assertFalse(found["runs"][0]["at_both_ends"])
        self.assertEqual(found["runs"][0]["visits"], [1])
        self.assertIsNone(point["drift"])
        # At 23 degrees gyro_x reads 0.004 deg/s less than at 25.
        self.assertAlmostEqual(point["bias"], 0.35, delta=1e-3)
        self.assertAlmostEqual(found["runs"][0]["sensors"]["gyro_x"]["bias"], 0.346, delta=1e-3)
        self.add("far", campaign(0.0, plateaus=(0, 22, 40)))
        found = self.chart()["campaigns"][-1]
        self.assertEqual((found["sensors"], found["verdict"]), ({}, "not_established"))
        self.assertRegex(self.soak("check", "chart").stdout, r"25 °C.*\bfar\b")

    def test_verification_runs_and_other_units_are_not_on_the_chart(self):
        self.with_history()
        self.add("v", campaign(0.2), "CS1", "--procedure", "verification")
        self.add("other", campaign(0.2), "SN2")
        self.assertEqual(len(self.chart()["campaigns"]), GOOD)

    def test_an_end_and_a_new_declaration_begin_a_new_chart(self):
        self.with_history()
        ended = self.soak_json("check-record", "check", "end", "CS1", "--reason", "dropped")
        self.assertTrue(ended["ended"])
        self.add("later", campaign(0.2))
        self.refusal("check", "chart")
        chart = self.chart("--unit", "CS1")
        self.assertTrue(chart["ended"])
        self.assertEqual(len(chart["campaigns"]), GOOD)  # what came after the end is not judged
        declared = self.soak_json("check-record", "check", "declare", "CS1", "--reason", "repaired")
        self.assertNotEqual(declared["check_standard_id"], ended["check_standard_id"])
        self.assertEqual([c["campaign"] for c in self.chart()["campaigns"]], ["later"])

    def test_a_new_epoch_begins_a_new_chart(self):
        self.with_history()
        self.soak("unit", "add", "CS1", "--begin-epoch", "board repaired")
        self.assertEqual(self.chart()["campaigns"], [])
        self.assertRegex(self.soak("check", "chart").stdout, r"\b0 campaigns")

    def test_simulated_campaigns_say_so(self):
        self.soak("unit", "add", "CS1")
        self.soak("check", "declare", "CS1", "--reason", "test")
        self.add("s", campaign(0.0), "CS1", "--simulated")
        self.assertTrue(self.chart()["campaigns"][0]["simulated"])
        self.assertIn("(SIMULATED)", self.soak("check", "chart").stdout)

    def test_mistakes_are_refused_and_change_nothing(self):
        shutil.copytree(folder_in_control() / "data", self.data)
        before = self.state()
        self.refusal("check", "chart")
        self.refusal("check", "chart", "--unit", "CS1")
        self.refusal("check", "end", "CS1", "--reason", "x")
        self.refusal("check", "declare", "NOBODY", "--reason", "x")
        self.refusal("check", "declare", "CS1")
        self.refusal("check", "declare", "CS1", "--reason", "")
        self.assertEqual(self.state(), before)
        self.soak_json("check-record", "check", "declare", "CS1", "--reason", "x")
        self.refusal("check", "declare", "CS1", "--reason", "y")


if __name__ == "__main__":
    unittest.main()
