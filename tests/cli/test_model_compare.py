# SPDX-License-Identifier: Apache-2.0
"""Two versions of a unit's model beside each other: curves and errors on held-out runs, against what the fits themselves printed."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy
import scipy.stats

from one_way_campaign import Unit
from soak_cli import SoakTest

GOOD, BAD = [f"G{k}" for k in range(4)], [f"B{k}" for k in range(3)]


class ModelCompare(SoakTest):
    @classmethod
    def setUpClass(cls):
        """Version 1 is of four runs of one curve and three of another, as if somebody had taken another unit; 2 and 3 are of the four."""
        cls.store = pathlib.Path(tempfile.mkdtemp(prefix="soak-compare-"))
        cls.addClassCleanup(shutil.rmtree, cls.store, ignore_errors=True)

        def soak(*arguments):
            return subprocess.run([os.environ["SOAK_BIN"], *map(str, arguments), "--data", str(cls.store / "data")], check=True, text=True,
                                  capture_output=True).stdout
        unit, other = Unit(50), Unit(51)
        for name in GOOD + BAD:
            path = cls.store / f"{name}.csv"
            path.write_text((unit if name in GOOD else other).run(name, ("up", "down")), encoding="utf-8")
            soak("import", path, "--unit", "SN1", "--campaign", "c", "--gravity-mps2", "9.81")
        cls.fits = [json.loads(soak("fit", "--unit", "SN1", "--json"))]
        for name in BAD:
            soak("runs", "void", name, "--unit", "SN1", "--reason", "another unit")
        cls.fits += [json.loads(soak("fit", "--unit", "SN1", "--json")) for _ in range(2)]

    def setUp(self):
        super().setUp()
        shutil.copytree(self.store / "data", self.data)

    def compared(self, *options):
        return self.soak_json("model-compare", "model", "compare", "--unit", "SN1", *options)["sensors"]["gyro_x"]

    def errors(self, version):
        sensor = self.fits[version - 1]["sensors"]["gyro_x"]
        return {check["held_out"]: check[sensor["deployed"]] for check in sensor["checks"]}

    def curve(self, version):
        points = self.fits[version - 1]["sensors"]["gyro_x"]["curve"]
        return [numpy.array([point[key] for point in points]) for key in ("temp_c", "bias", "ci95")]

    def test_a_version_without_foreign_runs_is_better_and_the_other_way_round_worse(self):
        there, back = self.compared("--model", "1", "--with", "2"), self.compared("--model", "2", "--with", "1")
        self.assertEqual((there["verdict"], back["verdict"]), ("better", "worse"))
        before, after = self.errors(1), self.errors(2)
        ratios = numpy.log([after[run] / before[run] for run in GOOD])
        low, high = scipy.stats.t.interval(0.95, len(ratios) - 1, ratios.mean(), scipy.stats.sem(ratios))
        held_out = there["held_out"]
        self.assertEqual(held_out["runs"], len(GOOD))
        for key, value in (("ratio", ratios.mean()), ("ratio_low", low), ("ratio_high", high)):
            self.assertAlmostEqual(numpy.log(held_out[key]), value, 9)
        for key, errors in (("before_rms", before), ("after_rms", after)):
            self.assertAlmostEqual(held_out[key], numpy.sqrt(numpy.mean([errors[run]**2 for run in GOOD])), 12)
        self.assertAlmostEqual(held_out["ratio"] * back["held_out"]["ratio"], 1.0, 12)

    def test_differences_are_those_of_the_curves_that_the_fits_printed(self):
        there = self.compared("--model", "1", "--with", "2")
        temps = numpy.array([point["temp_c"] for point in there["curve"]])
        (t1, b1, c1), (t2, b2, c2) = self.curve(1), self.curve(2)
        common = numpy.arange(numpy.ceil(max(t1[0], t2[0])), min(t1[-1], t2[-1]) + 1e-9)
        numpy.testing.assert_array_equal(temps, common)
        # between points 1 K apart a line is off by at most an eighth of the second difference
        bend = max(numpy.abs(numpy.diff(b, 2)).max() for b in (b1, b2)) / 8
        expected = numpy.interp(temps, t2, b2) - numpy.interp(temps, t1, b1)
        differences = numpy.array([point["difference"] for point in there["curve"]])
        self.assertLess(numpy.abs(differences - expected).max(), 2 * bend)
        bands = numpy.hypot(numpy.interp(temps, t1, c1), numpy.interp(temps, t2, c2))
        numpy.testing.assert_allclose([point["ci95"] for point in there["curve"]], bands, rtol=0.01)
        self.assertEqual(there["beyond_ci95"], sum(abs(point["difference"]) > point["ci95"] for point in there["curve"]))

    def test_the_same_fit_twice_is_equal(self):
        same = self.compared("--model", "2")  # with the newest, which is 3
        self.assertEqual((same["verdict"], same["held_out"]["ratio"], same["beyond_ci95"]), ("equal", 1.0, 0))
        self.assertEqual({point["difference"] for point in same["curve"]}, {0.0})

    def test_with_too_few_common_runs_nothing_is_said(self):
        for name in GOOD[2:]:
            self.soak("runs", "void", name, "--unit", "SN1", "--reason", "test")
        self.soak("fit", "--unit", "SN1")
        few = self.compared("--model", "3")
        self.assertEqual((few["verdict"], few["held_out"]["ratio"]), ("unknown", None))

    def recorded(self, serial, campaigns):
        """Runs R0 to R2 in each campaign, all of them other recordings of one unit."""
        unit = Unit(60)
        for campaign in campaigns:
            for k in range(3):
                path = self.write(f"{campaign}{k}.csv", unit.run(f"R{k}", ("up", "down")))
                self.soak("import", path, "--unit", serial, "--campaign", campaign, "--gravity-mps2", "9.81")

    def test_runs_of_one_label_in_two_campaigns_are_not_taken_for_each_other(self):
        self.recorded("SN2", "ab")
        for campaign in ("a", "b", None):
            self.soak("fit", "--unit", "SN2", *(["--campaign", campaign] if campaign else []))
        for before, after, common in ((1, 2, 0), (1, 3, 3), (2, 3, 3)):
            sensor = self.soak_json("model-compare", "model", "compare", "--unit", "SN2", "--model", str(before), "--with", str(after))
            self.assertEqual(sensor["sensors"]["gyro_x"]["held_out"]["runs"], common)
            self.assertEqual(sensor["sensors"]["gyro_x"]["verdict"] == "unknown", common == 0)

    def test_unknown_versions_are_refused(self):
        self.refusal("model", "compare", "--unit", "SN1", "--model", "9")
        self.refusal("model", "compare", "--unit", "SN1", "--model", "1", "--with", "9")
        self.refusal("model", "compare", "--unit", "SN9", "--model", "1")

    def test_a_version_is_not_compared_with_itself(self):
        self.refusal("model", "compare", "--unit", "SN1", "--model", "3")
        self.refusal("model", "compare", "--unit", "SN1", "--model", "1", "--with", "1")


if __name__ == "__main__":
    unittest.main()
