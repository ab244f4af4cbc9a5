# SPDX-License-Identifier: Apache-2.0
"""`soak gap find` on campaigns with runs that are not what they say: another unit's, with swapped axes, in Fahrenheit, with labels
mixed up or a sensor stuck. No effect may be named; the run and what is wrong with it must be."""
import csv
import os
import pathlib
import random
import sys
import unittest

from soak_cli import ROOT, SoakTest

sys.path.insert(0, str(ROOT / "tests" / "blind"))
from blind_campaign import Campaign, Programs  # noqa: E402

PLACE = ("--unit", "SN1", "--gravity-mps2", "9.80665", "--simulated")


class BadRuns(SoakTest):
    def rows(self, seed):
        """Head and rows of a campaign in which nothing is hidden."""
        programs = Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
        folder = self.folder / f"campaign-{seed}"
        folder.mkdir()
        with open(Campaign(programs, folder, seed, {"kind": "identical"}, []).csv, encoding="utf-8", newline="") as file:
            head, *rows = csv.reader(file)
        self.column = {name: number for number, name in enumerate(head)}
        return head, rows

    def of_run(self, rows, *labels):
        return [list(row) for row in rows if row[self.column["run"]] in labels]

    def bring_in(self, head, rows):
        path = self.folder / "rows.csv"
        with open(path, "w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head] + rows)
        self.soak("import", path, *PLACE)

    def find(self, head, good, bad=()):
        """The report on a campaign whose model was fitted before the bad run came."""
        self.bring_in(head, good)
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        if bad:
            self.bring_in(head, bad)
        report = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual((report["effects"], report["suspects"]), ([], []), report["reason"])
        return report

    def refused(self, report, *named):
        self.assertEqual(report["verdict"], "cannot_judge", report["reason"])
        for name in named:
            self.assertIn(name, report["reason"])

    def test_one_of_two_runs_of_another_unit(self):
        head, rows = self.rows(21)
        _, other = self.rows(22)
        report = self.find(head, self.of_run(rows, "R01"), self.of_run(other, "R02"))
        self.refused(report, "R01", "R02")

    def test_two_of_six_runs_of_another_unit(self):
        head, rows = self.rows(21)
        _, other = self.rows(22)
        report = self.find(head, self.of_run(rows, "R01", "R02", "R03", "R04") + self.of_run(other, "R05", "R06"))
        self.refused(report, "R05, R06")

    def test_swapped_axes_of_one_run(self):
        head, rows = self.rows(21)
        bad = self.of_run(rows, "R06")
        for row in bad:
            x, y = self.column["gx_dps"], self.column["gy_dps"]
            row[x], row[y] = row[y], row[x]
        report = self.find(head, self.of_run(rows, "R01", "R02", "R03", "R04", "R05"), bad)
        self.refused(report, "R06", "gyro_x, gyro_y")

    def test_fahrenheit_in_one_run(self):
        head, rows = self.rows(21)
        bad = self.of_run(rows, "R06")
        for row in bad:
            row[self.column["temp_c"]] = f"{1.8 * float(row[self.column['temp_c']]) + 32.0:.3f}"
        report = self.find(head, self.of_run(rows, "R01", "R02", "R03", "R04", "R05"), bad)
        self.refused(report, "R06", "thermometer")

    def test_labels_that_were_mixed_up_are_said_to_be_left_out(self):
        head, rows = self.rows(21)
        bad = self.of_run(rows, "R06")
        mix = random.Random(2)
        names = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"]
        mixed = {}
        for row in bad:
            label = row[self.column["position"]]
            visit = (row[self.column["sweep"]], row[self.column["plateau_c"]])
            if visit not in mixed:
                mixed[visit] = dict(zip(names, mix.sample(names, 6)))
            row[self.column["position"]] = mixed[visit].get(label, label)
        report = self.find(head, self.of_run(rows, "R01", "R02", "R03", "R04", "R05"), bad)
        self.refused(report, "R06")
        (entry,) = report["rejected_by_gate"]
        self.assertEqual((entry["run"], entry["sensor"], entry["code"]), ("R06", None, "wrong_position"))
        self.assertGreater(2 * entry["segments"], entry["of"])
        self.assertIn("run R06:", self.soak("gap", "find", "--unit", "SN1").stdout)

    def test_a_stuck_sensor_of_one_run_is_said_to_be_left_out(self):
        head, rows = self.rows(21)
        bad = self.of_run(rows, "R06")
        for row in bad:
            row[self.column["gy_dps"]] = "0.01000"
        report = self.find(head, self.of_run(rows, "R01", "R02", "R03", "R04", "R05"), bad)
        self.assertEqual(report["verdict"], "none", report["reason"])
        self.assertRegex(report["reason"], "gyro_y.* R06")
        self.assertEqual([(entry["run"], entry["sensor"]) for entry in report["rejected_by_gate"]], [("R06", "gyro_y")])


if __name__ == "__main__":
    unittest.main()
