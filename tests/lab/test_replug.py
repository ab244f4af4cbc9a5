# SPDX-License-Identifier: Apache-2.0
"""A unit whose wire is cut in mid-recording, and that kept its power."""
import time
import unittest

import bench
from bench import LabTest, short_procedure


class Replug(LabTest):
    def test_it_comes_back_in_the_same_power_on_and_the_segment_is_recorded_again(self):
        self.start_lab(rate=200, cut=["unit1"])
        self.start_campaign(short_procedure(positions=("+Z", "-Z"), dwell_s=600))
        self.wait_for_step("record")
        time.sleep(0.3)
        self.proxies["unit1"].cut()
        time.sleep(0.3)
        self.proxies["unit1"].mend()
        self.assertEqual(self.wait_for_end()["state"], "finished")
        rows = self.query("SELECT position, visit, attempt, gyro_x_count FROM segment ORDER BY visit, position, attempt")
        self.assertEqual([row[:3] for row in rows],
                         [("+Z", 0, 0), ("+Z", 0, 1), ("-Z", 0, 0), ("+Z", 1, 0), ("-Z", 1, 0)])
        counts = [row[3] for row in rows]
        self.assertLess(counts[0], 6000, "it was cut short")
        for count in counts[1:]:
            self.assertAlmostEqual(count, 6000, delta=1, msg="30 s at 200 Hz, the first sample at any phase of its period")
        self.assertEqual(self.query("SELECT unit, visit, position, attempt FROM void"), [("0380A001", 0, "+Z", 0)])
        self.assert_event("segment", "0380A001", "+Z")
        self.assert_safe()


if __name__ == "__main__":
    bench.main()
