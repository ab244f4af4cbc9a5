# SPDX-License-Identifier: Apache-2.0
"""Thermal ramps by the shipped procedure: recorded by soakd over the real protocols, judged branch by branch, the effect that the
laboratory hides named, accepted, fitted again, exported, and the gap smaller on ramps that nothing was fitted to, of the model and of
what a device makes of its file."""
import math
import unittest

import bench
from bench import ENDED, LONG_TESTS, ROOT, LabTest

# Behind the thermometer: on a ramp of 1 K/min every curve is read 2 K off, one way or the other.
LAG_S = 120.0
HIDDEN = f"""
[[hidden]]
effect = "sensor_lag"
amplitude = {LAG_S}
seed = 4
"""


class RampGap(LabTest):
    def json(self, *words):
        return self.lab.soak_json("gap", *words, "--unit", self.unit)

    def ramps(self, name, purpose):
        text = (ROOT / "procedures" / "thermal-ramp.toml").read_text(encoding="utf-8")
        shipped = 'purpose = "calibration"'
        self.assertIn(shipped, text)
        self.start_campaign(text.replace(shipped, f'purpose = "{purpose}"'), name)
        self.wait("the end of " + name, lambda s: s["campaign"]["name"] == name and s["state"] in ENDED, 800, lab_s=400.0)
        self.assertEqual(self.status()["state"], "finished", self.lab.log())

    def test_ramps_are_judged_and_what_is_named_goes_all_the_way(self):
        config = self.folder / "hidden.toml"
        config.write_text((ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8") + HIDDEN, encoding="utf-8")
        self.start_lab(rate=4000, seed=3, soaksim_options=("--config", config))
        self.unit = self.lab.truth()["units"][0]["unit"]
        self.ramps("ramps", "calibration")
        self.lab.soak("fit", "--unit", self.unit)
        found = self.json("find")
        self.check_schema(found, "gap-find")
        self.assertEqual((found["verdict"], found["held_out"]), ("named", "branch"), found["reason"])
        effect = found["effects"][0]
        self.assertIn("sensor_lag", [effect["name"], *effect["confusable_with"]])
        self.check_schema(self.json("accept"), "gap-accept")
        fitted = self.lab.soak_json("fit", "--unit", self.unit)
        self.assertIn(effect["name"], [term["name"] for term in fitted["terms"]])
        self.assertEqual(fitted["model"], 3)
        if LONG_TESTS:
            self.see_fresh_ramps(effect)

    def see_fresh_ramps(self, effect):
        """A second campaign: the effect is gone from ramps that no fit has seen, in the laboratory and on a device."""
        self.ramps("fresh", "verification")
        shown = self.json("show")
        self.check_schema(shown, "gap-show")
        for sensor in effect["sensors"]:
            fresh = shown["sensors"][sensor]["fresh"]
            print(f"{sensor}: {effect['name']}, fresh {fresh}")
            self.assertLess(fresh["after_rms"], 0.6 * fresh["before_rms"], sensor)
        before, after = self.corrected(1), self.corrected(3)
        for sensor in effect["sensors"]:
            print(f"{sensor}: on a device {before[sensor]:.4g}, with the effect {after[sensor]:.4g}")
            self.assertLess(after[sensor], 0.8 * before[sensor], sensor)

    def corrected(self, model):
        """What the file of this model leaves of the fresh ramps on a device: RMS of means of 30 s over all of them, by sensor."""
        file = self.folder / f"model{model}.soakcal"
        self.lab.soak("export", "--unreleased", "--simulated", "--unit", self.unit, "--model", model, "--format", "blob", "-o", file)
        runs = self.lab.soak_json("runs", "list", "--unit", self.unit, "--campaign", "fresh")["runs"]
        ramps = [run["run_id"] for run in runs if run["run"].startswith("V")]  # beside them there is what was recorded before the start
        self.assertEqual(len(ramps), 3)
        documents = [self.lab.soak_json("correct", file, run) for run in ramps]
        for document in documents:
            self.check_schema(document, "correct")
            self.assertEqual(document["moving_terms"] or document["thermal_history"], model != 1)
        return {sensor: math.sqrt(sum(document["blocks"] * document["sensors"][sensor]["corrected_rms"] ** 2 for document in documents)
                                  / sum(document["blocks"] for document in documents)) for sensor in documents[0]["sensors"]}


if __name__ == "__main__":
    bench.main()
