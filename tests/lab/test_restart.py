# SPDX-License-Identifier: Apache-2.0
"""soakd is killed in mid-campaign: the next one makes the chamber safe, keeps what was recorded, and can go on."""
import time
import unittest

import bench
from bench import LabTest, short_procedure
from lab_session import ProgramFailed, end


class Restart(LabTest):
    def kill_and_start_again(self):
        self.lab.soakd.kill()
        self.lab.soakd.wait()
        self.lab.soakd.stdout.close()
        self.lab.start_soakd()

    def test_a_killed_campaign_is_made_safe_and_goes_on_with_the_run_that_was_cut_short(self):
        self.start_lab(units=2, rate=100)
        begun = self.start_campaign(short_procedure(set_points=(15,)))
        self.wait_for_step("wait_stable")
        time.sleep(6)  # what was recorded is flushed every five seconds
        self.kill_and_start_again()
        status = self.wait_for_end()
        self.assertEqual(status["state"], "interrupted")
        self.assert_safe()
        cut = [run for run in self.lab.soak_json("runs", "list")["runs"] if run["run"] == "R01"]
        self.assertEqual([run["unit"] for run in cut], ["0380A001", "0380A002"])
        for run in cut:
            self.assertGreater(run["rows"], 100)
            self.assertTrue(run["sealed"])
        self.assertEqual(self.query("SELECT DISTINCT label FROM run JOIN void USING (run_id)"), [("R01",)])
        self.lab.soak("runs", "verify")

        # Still so after one more restart.
        end(self.lab.soakd)
        self.lab.start_soakd()
        self.assertEqual(self.status()["state"], "interrupted")
        self.soak_fails(2, "campaign", "start", self.write("procedure.toml", short_procedure(set_points=(15,))), "--name", "c")
        self.lab.soak("campaign", "resume")
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()
        self.assertEqual([label for (label,) in self.query("SELECT DISTINCT label FROM run ORDER BY created_utc_s")],
                         ["R01", "R01.2"])
        done = {index for index, in self.query("SELECT step_index FROM step WHERE outcome = 'done'")}
        self.assertEqual(done, set(range(begun["steps"])))

    def test_a_second_soakd_is_refused_the_data_folder(self):
        self.start_lab()
        first = self.lab.soakd
        with self.assertRaises(ProgramFailed) as refused:
            self.lab.start_soakd()
        self.lab.soakd.stdout.close()
        self.lab.soakd = first
        self.assertIn("status 2", str(refused.exception))
        self.assertIn(str(first.pid), str(refused.exception))
        self.assertEqual(self.status()["state"], "idle")


if __name__ == "__main__":
    bench.main()
