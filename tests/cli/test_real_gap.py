# SPDX-License-Identifier: Apache-2.0
"""`soak gap find` on recordings in one attitude without plateaus: a made-up cycle with a memory, and the chamber's recording
(tools/prove/real-gap), which is not part of the project."""
import math
import os
import random
import re
import subprocess
import unittest

from soak_cli import ROOT, SoakTest, shared_data


def cycle(branches, seed=3):
    """Ramps of 3 K/min between -15 and 70 °C from 25 °C on; gx is pushed by three rods with play, gy follows the temperature alone.
    At one speed a memory and what follows the speed look alike: the set must hold the truth."""
    noise = random.Random(seed)
    lines = ["t_s,temp_c,gx_dps,gy_dps"]
    temp, rods, t = 25.0, {2.0: 25.0, 5.0: 25.0, 9.0: 25.0}, 0.0
    for branch in range(branches):
        step = 0.05 if branch % 2 else -0.05
        while (temp < 70.0) if step > 0 else (temp > -15.0):
            temp += step
            t += 1.0
            rods = {play: min(max(rod, temp - play), temp + play) for play, rod in rods.items()}
            pushed = sum((temp - rod) / play for play, rod in rods.items()) / 3
            gx = 0.5 * math.atan((temp - 20.0) / 30.0) + 0.05 * pushed + noise.gauss(0, 0.02)
            gy = 0.3 * math.atan((temp - 10.0) / 40.0) + noise.gauss(0, 0.02)
            lines.append(f"{t},{temp + noise.gauss(0, 0.01):.4f},{gx:.6f},{gy:.6f}")
    return "\n".join(lines) + "\n"


class Branches(SoakTest):
    def find(self, branches):
        self.soak("import", self.write("cycle.csv", cycle(branches)), "--unit", "R1")
        self.soak("fit", "--unit", "R1")
        return self.soak_json("gap-find", "gap", "find", "--unit", "R1")

    def test_three_name_the_memory_or_a_set_with_it(self):
        report = self.find(3)
        self.assertEqual((report["verdict"], report["held_out"]), ("named", "branch"), report["reason"])
        effect = report["effects"][0]
        self.assertIn("thermal_hysteresis", [effect["name"], *effect["confusable_with"]])
        self.assertEqual(effect["sensors"], ["gyro_x"])
        gap = report["gap"]["gyro_x"]
        self.assertGreater(gap["before_rms"], 1.5 * gap["floor_rms"])
        self.assertLess(gap["after_rms"], 0.5 * gap["before_rms"])
        self.assertIsNone(report["gap"]["gyro_y"]["closed_fraction"])
        self.assertLessEqual({"g_sensitivity", "earth_rate", "cross_axis", "fixture_tilt", "supply_sensitivity"},
                             {entry["name"] for entry in report["not_testable"]})
        self.assertIn("gyro_x", self.soak("gap", "find", "--unit", "R1").stdout)

    def test_a_name_leads_to_a_model_that_reads_a_fresh_cycle_better(self):
        effect = self.find(3)["effects"][0]
        accepted = self.soak_json("gap-accept", "gap", "accept", "--unit", "R1")
        self.assertEqual([(term["name"], term["parent_version"]) for term in accepted["terms"]], [(effect["name"], 1)])
        self.assertEqual([part["sensors"] for part in accepted["terms"][0]["parts"]], [["gyro_x"]])
        self.assertEqual([term["name"] for term in self.soak_json("fit", "fit", "--unit", "R1")["terms"]], [effect["name"]])
        self.soak("import", self.write("fresh.csv", cycle(3, seed=8)), "--unit", "R1", "--procedure", "verification",
                  "--campaign", "fresh")
        fresh = self.soak_json("gap-show", "gap", "show", "--unit", "R1")["sensors"]["gyro_x"]["fresh"]
        self.assertLess(fresh["after_rms"], 0.5 * fresh["before_rms"], fresh)
        again = self.soak_json("gap-find", "gap", "find", "--unit", "R1")
        self.assertEqual(again["effects"], [], again["reason"])
        for form in ("blob", "c", "json"):
            self.soak("export", "--unreleased", "--unit", "R1", "--format", form, "-o", self.folder / form)
        self.soak("eval", self.folder / "blob", "--temp-c", "0,25,50")

    def test_two_give_no_name(self):
        report = self.find(2)
        self.assertIn(report["verdict"], ("unknown", "cannot_judge"))
        self.assertEqual(report["effects"], [])
        self.assertEqual(report["held_out"], "half")

    def test_a_suspect_of_two_goes_into_the_model_only_by_name_and_on_request(self):
        suspect, = {effect["name"] for effect in self.find(2)["suspects"]}
        for arguments in ((), ("--effect", suspect)):
            refused = self.refusal("gap", "accept", "--unit", "R1", *arguments)
            self.assertIn("--suspect", refused["message"])
        self.refusal("gap", "accept", "--unit", "R1", "--suspect")
        term, = self.soak_json("gap-accept", "gap", "accept", "--unit", "R1", "--suspect", "--effect", suspect)["terms"]
        self.assertEqual((term["name"], term["verdict"], term["lab_only"]), ("thermal_hysteresis", "unknown", False))
        self.soak("export", "--unreleased", "--unit", "R1", "--format", "blob", "-o", self.folder / "blob")
        self.soak("import", self.write("fresh.csv", cycle(3, seed=8)), "--unit", "R1", "--procedure", "verification",
                  "--campaign", "fresh")
        device = self.soak_json("correct", "correct", self.folder / "blob", "fresh", "--past", "unknown")
        self.assertTrue(device["thermal_history"])
        # What the curve cannot follow of gyro_x: three rods of 0.05 deg/s.
        self.assertLess(device["sensors"]["gyro_x"]["corrected_rms"], 0.015)

    def test_one_cannot_be_judged(self):
        report = self.find(1)
        self.assertEqual(report["verdict"], "cannot_judge")
        self.assertTrue(report["reason"])


class Recording(unittest.TestCase):
    def test_the_proof_runs_and_names_nothing_on_two_branches(self):
        if shared_data("thermal_chamber_cycle") is None:
            self.skipTest("skipped: recording thermal_chamber_cycle is absent (SOAK_TEST_DATA)")
        done = subprocess.run([ROOT / "tools" / "prove" / "real-gap"], capture_output=True, text=True, check=False, timeout=250, env=dict(os.environ))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        verdict, = re.findall(r"^soak gap find .*: (\w+)$", done.stdout, re.M)
        self.assertIn(verdict, ("none", "unknown", "cannot_judge"))

    def test_the_proof_says_skipped_without_the_recording(self):
        done = subprocess.run([ROOT / "tools" / "prove" / "real-gap"], capture_output=True, text=True, check=True, timeout=60,
                              env={**os.environ, "SOAK_TEST_DATA": "/nonexistent"})
        self.assertTrue(done.stdout.startswith("skipped"), done.stdout)


if __name__ == "__main__":
    unittest.main()
