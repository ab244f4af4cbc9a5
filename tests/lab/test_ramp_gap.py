# SPDX-License-Identifier: Apache-2.0
"""Thermal ramps by the shipped procedure: recorded by soakd over the real protocols, judged branch by branch, the effect that the
laboratory hides named, accepted, fitted again, and the gap smaller on a ramp that nothing was fitted to."""
import unittest

import bench
from bench import ENDED, ROOT, LabTest

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
        self.ramps("fresh", "verification")
        shown = self.json("show")
        self.check_schema(shown, "gap-show")
        for sensor in effect["sensors"]:
            fresh = shown["sensors"][sensor]["fresh"]
            print(f"{sensor}: {effect['name']}, fresh {fresh}")
            self.assertLess(fresh["after_rms"], 0.6 * fresh["before_rms"], sensor)


if __name__ == "__main__":
    bench.main()
