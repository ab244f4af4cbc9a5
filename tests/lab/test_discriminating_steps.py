# SPDX-License-Identifier: Apache-2.0
"""The steps that only the runs of docs/gap-workflow.md need: a power cycle in mid-run, and a turn of the whole fixture."""
import re
import unittest

import bench
from bench import AUTO, ROOT, LabTest, short_procedure
from lab_session import end

AZIMUTHS = "azimuths_deg = [0, 90, 90, 90, 270, 90]"


class DiscriminatingSteps(LabTest):
    def test_power_cycles_make_runs_at_one_temperature_while_the_chamber_holds_it(self):
        self.start_lab(rate=1000)
        procedure = short_procedure(set_points=(20, 40, 20)).replace("off_s = 10", "off_s = 2000\ncycle_at_visit = 1\ncycles = 2")
        self.start_campaign(procedure)
        self.wait_for_step("power_off", run="R01")
        mode, _, set_point_c, _ = self.chamber()
        self.assertEqual((mode, set_point_c), (AUTO, 40.0))
        self.wait("the units are off", lambda s: not s["units"][0]["powered"])
        self.wait_for_step("wait_stable", run="R02")
        mode, _, set_point_c, air_c = self.chamber()
        self.assertEqual((mode, set_point_c), (AUTO, 40.0))
        self.assertAlmostEqual(air_c, 40.0, delta=1.5)
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()

        runs = self.lab.soak_json("runs", "list")["runs"]
        self.assertEqual([(r["run"], r["purpose"], r["sealed"]) for r in runs],
                         [(run, "calibration", True) for run in ("R01", "R02", "R03")])
        recorded = []
        for run in runs:
            for s in self.lab.soak_json("runs", "show", run["run_id"])["segments"]:
                recorded.append((run["run"], s["visit"], s["plateau_c"], s["sweep"], s["position"]))
        self.assertEqual(recorded, [(run, visit, plateau, sweep, position) for run, visit, plateau, sweep in
                                    (("R01", 0, 20, "down"), ("R01", 1, 40, "up"), ("R02", 0, 40, "up"), ("R03", 0, 40, "up"),
                                     ("R03", 1, 20, "down"))
                                    for position in ("+Z", "-Z")])
        # Each run has a power-on of its own: the device's clock begins anew. The later ones begin where the first one's
        # temperature was, which nobody had to drive to.
        (first_c,), (second_c,), (third_c,) = (self.query("SELECT avg(temp_c) FROM segment WHERE run_id = ? AND plateau_c = 40", r["run_id"])[0]
                                               for r in runs)
        self.assertAlmostEqual(first_c, second_c, delta=1.0)
        self.assertAlmostEqual(first_c, third_c, delta=1.0)

    def test_a_turn_of_the_fixture_is_asked_for_kept_in_the_run_and_taken_back(self):
        self.start_lab()
        turned = short_procedure(set_points=(25,)).replace("[stability]", "turned_deg = 90\n[stability]")
        message = self.soak_fails(2, "campaign", "start", self.write("turned.toml", turned), "--name", "c")
        self.assertIn("azimuths_deg", message)
        self.give_azimuths()
        begun = self.start_campaign(turned)
        status = self.wait("the first prompt", lambda s: s["prompt"])
        self.assertIn("90°", status["prompt"]["text"])
        self.assertEqual(status["campaign"]["step_kind"], "turn_fixture")
        self.assertEqual(status["state"], "waiting")
        self.check_schema(status, "campaign-status")
        self.lab.soak("campaign", "confirm")
        self.wait("the last prompt", lambda s: s["prompt"] and s["campaign"]["step"] == begun["steps"] - 1)
        self.assert_safe()
        self.lab.soak("campaign", "confirm")
        self.assertEqual(self.wait_for_end()["state"], "finished")
        run = self.lab.soak_json("runs", "list")["runs"][0]
        segments = self.lab.soak_json("runs", "show", run["run_id"])["segments"]
        shown = {s["position"]: s["azimuth_deg"] for s in segments}
        usual = self.headings_without_turn()
        self.assertEqual(shown.keys(), usual.keys())
        for position, azimuth in shown.items():
            self.assertAlmostEqual((azimuth - usual[position]) % 360, 90.0, places=6)
        self.assert_event("step", "turn the whole fixture", "+90°")

    def headings_without_turn(self):
        self.start_campaign(short_procedure(set_points=(25,)), name="usual")
        self.assertEqual(self.wait_for_end()["state"], "finished")
        run = self.lab.soak_json("runs", "list", "--campaign", "usual")["runs"][0]
        return {s["position"]: s["azimuth_deg"] for s in self.lab.soak_json("runs", "show", run["run_id"])["segments"]}

    def give_azimuths(self):
        """Starts soakd anew with a fixture whose headings are known."""
        end(self.lab.soakd)
        text = (ROOT / "procedures" / "fixtures" / "modbus-positioner.toml").read_text(encoding="utf-8")
        changed = re.sub(r"^# azimuths_deg = .*$", AZIMUTHS, text, flags=re.M)
        self.assertNotEqual(changed, text)
        fixture = self.write("fixture.toml", changed)
        config = self.config.read_text(encoding="utf-8")
        known = re.sub(r"(\[fixture\]\nmap = )[^\n]*", rf'\g<1>"{fixture}"', config)
        self.assertNotEqual(known, config)
        self.config.write_text(known, encoding="utf-8")
        self.lab.start_soakd()


if __name__ == "__main__":
    bench.main()
