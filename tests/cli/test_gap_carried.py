# SPDX-License-Identifier: Apache-2.0
"""Effects that means do not show, accepted: `soak gap find` does not name them again, and says which sensors it cannot judge."""
import os
import pathlib
import sys
import unittest

from soak_cli import ROOT, SoakTest

sys.path.insert(0, str(ROOT / "tests" / "blind"))
from blind_campaign import Campaign, Programs  # noqa: E402


class Carried(SoakTest):
    def named_then_accepted(self, effect):
        """The reports before and after accepting all that is named."""
        programs = Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
        campaign = Campaign(programs, self.folder, 51, {"kind": "identical"}, [{"effect": effect, "magnitude": 2.4, "seed": 3}])
        self.soak("import", campaign.csv, "--unit", "SN1", "--gravity-mps2", "9.80665", "--simulated")
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        before = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual([entry["name"] for entry in before["effects"]], [effect], before["reason"])
        self.assertEqual(sorted(before["effects"][0]["sensors"]), sorted(campaign.truth["units"][0]["effects"][0]["sensors"]))
        self.soak_json("gap-accept", "gap", "accept", "--unit", "SN1")
        after = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual((after["verdict"], after["effects"]), ("none", []), after["reason"])
        return before, after

    def test_noise_against_temperature(self):
        self.named_then_accepted("noise_vs_temperature")

    def test_steps_of_the_output(self):
        self.named_then_accepted("quantization")

    def test_saturation_leaves_its_sensors_out_and_says_so(self):
        for report in self.named_then_accepted("saturation"):
            self.assertIn("accel_", report["reason"])
            for entry in report["not_testable"]:
                self.assertNotIn("was recorded", entry["why"])


if __name__ == "__main__":
    unittest.main()
