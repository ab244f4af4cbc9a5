# SPDX-License-Identifier: Apache-2.0
"""Samples that were filed more than once: under other labels, in other campaigns, of another unit."""
import json
import unittest

from soak_cli import SoakTest, recording

PLATEAUS = tuple(float(t) for t in range(-20, 60, 8))


def run_of(seed, label):
    return recording(seed=seed, run=label, plateaus=PLATEAUS, seconds=20)


def joined(*runs):
    """One CSV file of several runs."""
    return runs[0] + "".join(run.split("\n", 1)[1] for run in runs[1:])


def copy(run, of_run, of_campaign, of_unit="SN1"):
    """What the import's document says of a run that holds the samples of another."""
    return {"run": run, "of": {"unit": of_unit, "campaign": of_campaign, "run": of_run}}


def columns_turned(text):
    """The same cells in another order of columns, and a column more."""
    rows = [line.split(",") for line in text.splitlines()]
    return "\n".join(",".join(row[:8] + row[11:14] + row[8:11] + ["note" if i == 0 else "7"]) for i, row in enumerate(rows)) + "\n"


class Copies(SoakTest):
    def store(self, name, text, campaign, unit="SN1", *more):
        path = self.write(name, text)
        return self.soak_json("import", "import", path, "--unit", unit, "--campaign", campaign, "--gravity-mps2", "9.80665", *more)

    def fit(self, *more):
        return self.soak_json("fit", "fit", "--unit", "SN1", "--rules", 2, *more)

    def test_count_once_in_a_fit_which_names_them(self):
        three = joined(*(run_of(seed, f"r{seed}") for seed in (1, 2, 3)))
        self.store("three.csv", three, "first")
        alone = self.fit()
        self.store("three.csv", three, "second")
        relabelled = joined(*(run_of(seed, f"x{seed}") for seed in (1, 2, 3)))
        copies = self.store("relabelled.csv", relabelled, "third")["copies"]
        self.assertEqual(copies, [copy(f"x{seed}", f"r{seed}", "first") for seed in (1, 2, 3)])
        again = self.fit()
        self.assertEqual(again["sensors"], alone["sensors"], "neither curve nor intervals nor folds")
        told = [w["text"] for w in again["warnings"] if w["code"] == "copied_runs"]
        self.assertEqual(len(told), 3, told)
        self.assertRegex(told[0], "second/r1, third/x1 .* first/r1")
        # A copy is kept where it is the only one left, and the model knows each run once.
        for run in ("r1", "r2", "r3"):
            self.soak("runs", "void", run, "--campaign", "first", "--reason", "imported anew")
        self.assertEqual(self.fit()["sensors"]["gyro_x"]["curve"], alone["sensors"]["gyro_x"]["curve"])
        path = self.folder / "unit.json"
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "json", "-o", path)
        self.assertEqual(len(json.loads(path.read_text(encoding="utf-8"))["runs"]), 3)

    def test_are_seen_through_another_order_of_columns(self):
        self.store("a.csv", run_of(1, "r1"), "first")
        self.store("b.csv", run_of(2, "r2"), "first")
        told = self.store("turned.csv", columns_turned(run_of(1, "r1")), "second")
        self.assertEqual(told["copies"], [copy("r1", "r1", "first")])
        self.assertTrue(any("'r1'" in warning and "'first'" in warning for warning in told["warnings"]), told)
        document = self.fit()
        self.assertIn("copied_runs", [w["code"] for w in document["warnings"]])
        self.assertEqual(document["sensors"]["gyro_x"]["runs"], ["r1", "r2"])

    def test_runs_of_their_own_are_told_apart(self):
        self.store("a.csv", joined(run_of(1, "r1"), run_of(2, "r2")), "first")
        self.assertEqual(self.store("b.csv", run_of(3, "r1"), "second")["copies"], [])
        self.assertNotIn("copied_runs", [w["code"] for w in self.fit()["warnings"]])

    def test_of_another_unit_are_pointed_out(self):
        self.store("a.csv", joined(run_of(1, "r1"), run_of(2, "r2")), "first")
        told = self.store("b.csv", joined(run_of(2, "r2"), run_of(3, "r3")), "first", "SN2")
        self.assertEqual(told["copies"], [copy("r2", "r2", "first", "SN1")])
        self.assertTrue(any("'r2'" in warning and "SN1" in warning for warning in told["warnings"]), told)
        # What was withdrawn there may be filed here.
        self.soak("runs", "void", "r1", "--unit", "SN1", "--reason", "was SN3")
        self.assertEqual(self.store("c.csv", run_of(1, "r1"), "first", "SN3")["copies"], [])

    def test_twice_in_one_file_are_pointed_out(self):
        told = self.store("a.csv", joined(run_of(1, "r1"), run_of(1, "again")), "first")
        self.assertEqual(told["copies"], [copy("again", "r1", "first")])

    def test_count_once_in_a_verification(self):
        self.store("a.csv", joined(run_of(1, "r1"), run_of(2, "r2")), "first")
        self.fit()
        blob = self.folder / "unit.soakcal"
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", blob)
        self.store("v.csv", joined(run_of(9, "v1"), run_of(9, "v2")), "check", "SN1", "--procedure", "verification")
        document = self.soak_json("verify", "verify", blob, "--campaign", "check")
        self.assertIn("copied_runs", [w["code"] for w in document["warnings"]])
        self.assertEqual(document["sensors"]["gyro_x"]["rows"], len(PLATEAUS))


if __name__ == "__main__":
    unittest.main()
