# SPDX-License-Identifier: Apache-2.0
"""The loop closes wherever a name is given: an effect is hidden, found, accepted, fitted, exported, and the gap is smaller on runs
that nothing was fitted to. One campaign for each effect; how often `soak gap` names which is measured elsewhere (docs/gap-workflow.md),
and what a device makes of a history, a rate, a lag or a g-sensitivity is in test_gap_accept.py."""
import csv
import dataclasses
import io
import json
import os
import pathlib
import sys
import unittest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
from soak_cli import ROOT, SoakTest, check_schema, long_test  # noqa: E402

sys.path.insert(0, str(ROOT / "tests" / "blind"))
import second_laboratory  # noqa: E402
from blind_campaign import Programs, configuration  # noqa: E402
from closed_gap import COLUMNS  # noqa: E402

MAGNITUDE = 2.4
EARTH_DPS = 0.004178  # more would be no rotation of the Earth
G = 9.80665
FRESH = 2  # runs at the end of a campaign, which no fit sees
PLACE = ("--unit", "SN1", "--gravity-mps2", G, "--simulated")


@dataclasses.dataclass(frozen=True)
class Case:
    """`seed`: of the campaign. `hidden_as`: what tests/blind/second_laboratory.py calls the effect; else soaksim-campaign hides it.
    `device`: what the file does about it: `corrected`, `listed` (as lab only), `even_order` (its section holds it), `not_listed`.
    `most_left`: what a device with that file may leave of a fresh run, over what one with the file before does; None: that is not met."""
    effect: str
    seed: int
    device: str = "listed"
    hidden_as: str = ""
    runs: int = 6
    most_left: float | None = 1.05


CASES = (
    # Not met: only the laboratory takes a warm-up off, and a device with the file leaves 24, 33 and 44 % more of a fresh run (gyros x, y, z) than
    # with the file before.
    Case("warmup_transient", 61, most_left=None),
    Case("earth_rate", 62, device="not_listed"),
    Case("cross_axis", 63, device="corrected", most_left=0.8),
    Case("fixture_tilt", 64, device="not_listed"),
    Case("scale_nonlinearity", 65, device="even_order"),
    Case("vibration_rectification", 66),
    Case("supply_sensitivity", 67),
    # What the simulator has of these kinds follows other equations than the library.
    Case("temperature_gradient", 71, hidden_as="gradient"),
    Case("position_memory", 72, hidden_as="position_memory"),
    Case("moisture", 73, hidden_as="drying_water"),
    # Of four runs nobody can tell ageing from chance.
    Case("aging_drift", 83, hidden_as="aging_drift", runs=8),
)
# One of each kind of device, one of each generator.
SAMPLE = ("cross_axis", "fixture_tilt", "scale_nonlinearity", "temperature_gradient")


class Loop(SoakTest):
    def json(self, schema, *arguments):
        return self.soak_json(schema, *arguments, "--unit", "SN1")

    def simulated(self, case):
        """A campaign of soaksim-campaign, and the sensors that the effect acts on."""
        programs = Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
        size = {"amplitude": EARTH_DPS} if case.effect == "earth_rate" else {"magnitude": MAGNITUDE}
        config = self.write("lab.toml", configuration(programs.lab, {"kind": "identical"}, [{"effect": case.effect, "seed": 3, **size}], []))
        programs.run("soaksim-campaign", "--out", self.folder / "csv", "--seed", case.seed, "--units", 1, "--config", config,
                     "--truth", self.folder / "truth.json")
        effect, = json.loads((self.folder / "truth.json").read_text(encoding="utf-8"))["units"][0]["effects"]
        self.hidden = {sensor: entry["amplitude"] for sensor, entry in effect["sensors"].items()}
        return next((self.folder / "csv" / "campaign").glob("*.csv")).read_text(encoding="utf-8")

    def made_up(self, case):
        """A campaign of the second laboratory."""
        design = second_laboratory.Design(positions="permuted", ramps="two", slow=0.4, runs=case.runs)
        campaign = second_laboratory.make(case.seed, design, case.hidden_as, MAGNITUDE)
        self.hidden = {COLUMNS[column]: None for column in campaign.truth["sensors"]}
        return campaign.csv

    def import_and_fit(self, text):
        head, *rows = text.splitlines(keepends=True)
        run = next(csv.reader(io.StringIO(head))).index("run")
        labels = [row.split(",")[run] for row in rows]
        self.fresh = list(dict.fromkeys(labels))[-FRESH:]
        for name, seen in (("fit", False), ("fresh", True)):
            self.write(f"{name}.csv", head + "".join(row for row, label in zip(rows, labels) if (label in self.fresh) == seen))
        self.soak("import", self.folder / "fit.csv", *PLACE)
        self.soak("import", self.folder / "fresh.csv", *PLACE, "--procedure", "verification", "--campaign", "fresh")
        self.fit()

    def fit(self):
        return self.json("fit", "fit", "--rules", 2, "--jobs", 1)

    def close(self, case):
        self.import_and_fit(self.made_up(case) if case.hidden_as else self.simulated(case))
        found = self.json("gap-find", "gap", "find")
        self.assertEqual([effect["name"] for effect in found["effects"]], [case.effect], found["reason"])
        sensors = found["effects"][0]["sensors"]
        self.assertLessEqual(set(sensors), set(self.hidden))
        accepted = self.json("gap-accept", "gap", "accept")
        self.assertEqual(([term["name"] for term in accepted["terms"]], accepted["not_added"]), ([case.effect], []))
        self.assertEqual([term["name"] for term in self.fit()["terms"]], [case.effect])
        shown = self.json("gap-show", "gap", "show")
        self.check_fresh_runs(case, sensors, shown)
        self.check_sentences(case, shown)
        self.check_document(case, sensors)
        self.check_device(case, sensors)

    def check_fresh_runs(self, case, sensors, shown):
        self.assertEqual(shown["not_evaluated"], [])
        fresh = {sensor: shown["sensors"][sensor]["fresh"] for sensor in sensors}
        about = [remark for remark in shown["remarks"] if case.effect in remark]
        self.assertEqual(len(about), 0 if case.device == "corrected" else 1, about)
        if case.effect == "fixture_tilt":
            # Each mounting leans in its own way: the runs that were fitted say nothing of the next.
            self.assertIn("another in each mounting", about[0])
            for sensor, figures in fresh.items():
                self.assertEqual((figures["closed_fraction"], figures["after_rms"]), (0.0, figures["before_rms"]), sensor)
            return
        for remark in about:
            self.assertIn("the unit itself does not correct", remark)
        for sensor, figures in fresh.items():
            self.assertLess(figures["after_rms"], figures["before_rms"], sensor)
        closed = {sensor: figures["closed_fraction"] for sensor, figures in fresh.items() if figures["closed_fraction"] is not None}
        self.assertTrue(closed)
        for sensor, fraction in closed.items():
            self.assertGreaterEqual(fraction, 0.5, sensor)

    def check_sentences(self, case, shown):
        """What is said first of a right effect: never that it is to be taken out."""
        what, evidence, following = self.soak("gap", "show", "--unit", "SN1").stdout.splitlines()[:3]
        self.assertIn(case.effect, what)
        self.assertNotIn("withdraw", following)
        self.assertIn("soak verify --unit SN1", following)
        self.assertNotIn("single readings", evidence)
        self.assertEqual("cannot tell" in evidence, case.effect == "fixture_tilt", evidence)
        self.assertEqual("only what changes within it" in evidence, case.effect == "aging_drift", evidence)
        self.assertEqual("soak release" in following, case.effect != "fixture_tilt", shown["sensors"])

    def export(self, form, *options):
        target = self.folder / f"out{''.join(map(str, options))}.{form}"
        self.soak("export", "--unreleased", "--simulated", "--unit", "SN1", "--format", form, "-o", target, *options)
        return target

    def check_document(self, case, sensors):
        document = json.loads(self.export("json").read_text(encoding="utf-8"))
        check_schema(document, "calibration")
        listed = {sensor: term["lab_only"] for term in document["terms"] if term["name"] == case.effect for sensor in term["sensors"]}
        there = case.device in ("listed", "corrected")
        self.assertEqual(listed, {sensor: case.device == "listed" for sensor in sensors} if there else {})
        if case.device == "even_order":
            for sensor in sensors:
                stated = document["accel_even_order_per_mps2"][sensor]["value"]
                self.assertAlmostEqual(stated * G**2 / self.hidden[sensor], 1.0, delta=0.2, msg=sensor)

    def check_device(self, case, sensors):
        """The file without the effect beside that with it: what a device leaves of a fresh run."""
        left = []
        for model in (1, 3):
            device = self.soak_json("correct", "correct", self.export("blob", "--model", model), self.fresh[-1], "--campaign", "fresh")
            self.assertEqual(device["moving_terms"], case.device == "corrected" and model == 3)
            left.append({sensor: device["sensors"][sensor]["corrected_rms"] for sensor in sensors})
        for sensor in sensors if case.most_left is not None else ():
            self.assertLess(left[1][sensor], case.most_left * left[0][sensor], sensor)


def test_of(case):
    def test(self):
        self.close(case)
    return test if case.effect in SAMPLE else long_test(test)


for one in CASES:
    setattr(Loop, f"test_{one.effect}", test_of(one))


if __name__ == "__main__":
    unittest.main()
