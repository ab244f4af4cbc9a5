# SPDX-License-Identifier: Apache-2.0
"""The gap workflow end to end: an effect that the simulated laboratory's configuration hides, campaigns over the real
protocols, nothing imported. It is named, accepted, fitted again, and the gap is smaller on fresh runs by what was stated."""
import pathlib
import unittest

import bench
from bench import ENDED, ROOT, LabTest, short_procedure

HIDDEN = """
[[hidden]]
effect = "thermal_hysteresis"
amplitude = 0.02
seed = 4
sensors = ["accel_x", "accel_y", "accel_z"]
"""
SIX = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
BOTH_WAYS = (-5, 10, 25, 40, 55, 40, 25, 10, -5)


class Gap(LabTest):
    def json(self, *words):
        return self.lab.soak_json("gap", *words, "--unit", self.unit)

    def test_a_hidden_effect_is_named_accepted_and_gone_from_fresh_runs(self):
        config = self.folder / "hidden.toml"
        config.write_text((ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8") + HIDDEN, encoding="utf-8")
        self.start_lab(rate=4000, seed=3, soaksim_options=("--config", config))
        self.unit = self.lab.truth()["units"][0]["unit"]
        for name, runs, purpose in (("c", 4, "calibration"), ("fresh", 2, "verification")):
            self.start_campaign(short_procedure(BOTH_WAYS, runs, SIX, dwell_s=180, purpose=purpose), name)
            self.wait("the end of " + name, lambda s, n=name: s["campaign"]["name"] == n and s["state"] in ENDED, 600, lab_s=400.0)
            self.assertEqual(self.status()["state"], "finished", self.lab.log())
        self.lab.soak("fit", "--unit", self.unit)
        found = self.json("find")
        self.assertEqual(found["verdict"], "named", found["reason"])
        self.assertEqual(found["effects"][0]["name"], "thermal_hysteresis")
        self.json("accept", "--effect", "thermal_hysteresis")
        self.lab.soak("fit", "--unit", self.unit)
        page = pathlib.Path(self.folder) / "gap.html"
        shown = self.json("show", "-o", page)
        self.check_schema(shown, "gap-show")
        self.assertIn("SIMULATED", page.read_text(encoding="utf-8"))
        for sensor in ("accel_x", "accel_y", "accel_z"):
            stated = found["gap"][sensor]
            fresh = shown["sensors"][sensor]["fresh"]
            print(f"{sensor}: stated closed {stated['closed_fraction']:.2f} {stated['closed_ci95']}, fresh {fresh}")
            low, high = stated["closed_ci95"]
            self.assertTrue(low - 0.05 < fresh["closed_fraction"] < high + 0.05, sensor)
            self.assertLess(fresh["after_rms"], 0.5 * fresh["before_rms"], sensor)


if __name__ == "__main__":
    bench.main()
