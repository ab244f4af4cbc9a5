# SPDX-License-Identifier: Apache-2.0
"""Units that were recorded while heating only: every command says so, and a known hysteresis widens the bands."""
import bisect
import os
import random
import unittest

from blob_reader import Calibration
from one_way_campaign import GAP_DPS, Unit, binomial_interval
from soak_cli import SoakTest, long_test

RUNS = 3


def near(curve, temp_c):
    """The point of a fit's curve next to a temperature."""
    temps = [point["temp_c"] for point in curve]
    i = min(bisect.bisect_left(temps, temp_c), len(temps) - 1)
    return curve[i]


class OneWayTest(SoakTest):
    def setUp(self):
        super().setUp()
        units = self.folder / "procedures" / "units"
        units.mkdir(parents=True)
        (units / "silent.toml").write_text('name = "silent"\n', encoding="utf-8")
        (units / "stated.toml").write_text(f'name = "stated"\n[gyro]\nhysteresis_dps = {GAP_DPS}\n', encoding="utf-8")
        os.environ["SOAK_PROCEDURES"] = str(self.folder / "procedures")
        self.addCleanup(os.environ.pop, "SOAK_PROCEDURES")

    def record(self, unit, serial, unit_type, ways=("up",), runs=RUNS, campaign="a", procedure="soak"):
        for n in range(runs):
            path = self.write(f"{serial}-{campaign}-{n}.csv", unit.run(f"{campaign}{n}", ways))
            self.soak("import", path, "--unit", serial, "--type", unit_type, "--campaign", campaign,
                      "--procedure", procedure, "--gravity-mps2", "9.81")

    def fit(self, serial):
        return self.soak_json("fit", "fit", "--unit", serial)["sensors"]["gyro_x"]

    @staticmethod
    def codes(document):
        return [warning["code"] for warning in document["warnings"]]

    def exported(self, serial):
        path = self.folder / f"{serial}.soakcal"
        return path, self.soak_json("export", "export", "--unreleased", "--unit", serial, "--format", "blob", "-o", path)


class EveryCommand(OneWayTest):
    def test_says_it_of_a_unit_that_was_only_heated(self):
        unit = Unit(1)
        self.record(unit, "SN1", "silent")
        self.record(unit, "SN1", "silent", ("up",), 1, "fresh", "verification")
        self.record(unit, "SN1", "silent", ("up", "down"), 1, "back", "verification")
        sensor = self.fit("SN1")
        self.assertIn("one_way", self.codes(sensor))
        (found,) = sensor["one_way"]["ranges"]
        self.assertAlmostEqual(found["low_c"], -30, delta=0.1)
        self.assertAlmostEqual(found["high_c"], 70, delta=0.1)
        self.assertEqual((found["sweep"], sensor["one_way"]["source"], sensor["one_way"]["half_gap"]), ("up", "none", None))
        path, exported = self.exported("SN1")
        self.assertIn("one_way", self.codes(exported))
        stated = Calibration.load(path.read_bytes()).one_way["gyro_x"]
        self.assertEqual((stated.source, stated.half_gap, stated.ranges[0][2]), ("none", 0.0, "up"))
        self.assertIn("one_way", self.codes(self.soak_json("eval", "eval", path, "--temp-c", "20")))
        texts = []
        for campaign in ("fresh", "back"):
            verified = self.soak_json("verify", "verify", path, "--campaign", campaign)
            texts.append([w["text"] for w in verified["warnings"] if w["code"] == "one_way"])
            self.assertEqual(len(texts[-1]), 1)
        self.assertNotEqual(texts[0], texts[1])  # the second went the other way too
        report = self.folder / "report.html"
        self.soak("report", "--unit", "SN1", "-o", report)
        self.assertRegex(report.read_text(encoding="utf-8"), r"only heating was recorded from .30 to 70 .C")

    def test_says_nothing_of_one_that_went_both_ways(self):
        self.record(Unit(2), "SN2", "silent", ("up", "down"))
        sensor = self.fit("SN2")
        self.assertNotIn("one_way", self.codes(sensor))
        self.assertIsNone(sensor["one_way"])
        path, exported = self.exported("SN2")
        self.assertNotIn("one_way", self.codes(exported))
        self.assertEqual(Calibration.load(path.read_bytes()).one_way, {})

    def test_says_that_a_file_is_of_one_run(self):
        unit = Unit(3)
        self.record(unit, "SN3", "silent", ("up", "down"), runs=1)
        self.record(unit, "SN3", "silent", ("up", "down"), 1, "fresh", "verification")
        self.assertIn("few_runs", self.codes(self.fit("SN3")))
        path, exported = self.exported("SN3")
        self.assertIn("few_runs", self.codes(exported))
        self.assertTrue(Calibration.load(path.read_bytes()).uncertainties["gyro_x", "bias"].one_run)
        self.assertIn("one_run", self.codes(self.soak_json("eval", "eval", path, "--temp-c", "20")))
        self.assertIn("one_run", self.codes(self.soak_json("verify", "verify", path, "--campaign", "fresh")))


class KnownHysteresis(OneWayTest):
    def test_comes_from_the_newest_models_of_the_type_that_went_both_ways(self):
        for n in (1, 2):
            self.record(Unit(10 + n), f"BOTH{n}", "silent", ("up", "down"))
            self.fit(f"BOTH{n}")
        self.record(Unit(13), "ONE", "silent")
        sensor = self.fit("ONE")
        self.assertEqual(sensor["one_way"]["source"], "fleet")
        # the lens' root mean square over the visits between the turns: half of the gap times sqrt(mean of (1 - z^2)^2)
        lens = [(1 - ((t - 20) / 50)**2)**2 for t in range(-20, 70, 10)]
        expected = GAP_DPS / 2 * (sum(lens) / len(lens))**0.5
        self.assertAlmostEqual(sensor["one_way"]["half_gap"], expected, delta=0.1 * expected)
        # a type of its own knows nothing of the others
        self.record(Unit(14), "OTHER", "stated")
        self.assertEqual(self.fit("OTHER")["one_way"]["source"], "type")
        # fitted again, its own model that went one way does not count
        again = self.fit("ONE")
        self.assertAlmostEqual(again["one_way"]["half_gap"], sensor["one_way"]["half_gap"], 12)

    @long_test
    def test_of_eighteen_units_all_are_warned_of_and_the_bands_hold_the_way_that_was_not_recorded(self):
        inside = {"ci95": 0, "pi95": 0}
        warned, units, where = 0, int(os.environ.get("ONE_WAY_UNITS", "18")), random.Random(99)
        for n in range(units):
            unit, serial = Unit(100 + n), f"SN{n}"
            self.record(unit, serial, "stated")
            sensor = self.fit(serial)
            warned += "one_way" in self.codes(sensor)
            temp_c = where.uniform(-29, 69)
            point = near(sensor["curve"], temp_c)
            cooling = unit.branch(point["temp_c"], -1)
            inside["ci95"] += abs(point["bias"] - cooling) <= point["ci95"]
            inside["pi95"] += abs(point["bias"] - cooling - unit.power_on()) <= point["pi95"]
        self.assertEqual(warned, units)
        for band, count in inside.items():
            least, most = binomial_interval(count, units)
            print(f"cooling, {band}: {count} of {units} inside, 95 % interval {100 * least:.1f} to {100 * most:.1f} %")
            self.assertGreaterEqual(most, 0.95, band)


if __name__ == "__main__":
    unittest.main()
