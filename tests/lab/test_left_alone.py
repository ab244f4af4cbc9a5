# SPDX-License-Identifier: Apache-2.0
"""What a station that nobody looks at for weeks notices by itself: units that are dropped, a chamber that never answers again."""
import signal
import time
import unittest

import bench
from bench import LabTest, short_procedure

SECOND = "0380A002"
SILENT_FOR_GOOD_S = 7200.0  # process time after which a soakd that is to end gives up a chamber that does not answer


class Units(LabTest):
    def test_one_that_was_dropped_and_sends_again_is_said_to_be_dropped(self):
        self.start_lab(units=2, rate=50, cut=["unit2"])
        self.start_campaign(short_procedure(dwell_s=3000))
        self.wait_for_step("record")
        self.assertEqual([unit["dropped"] for unit in self.status()["units"]], [None, None])
        self.proxies["unit2"].cut()
        self.wait("the drop", lambda s: s["units"][1]["dropped"])
        self.proxies["unit2"].mend()
        status = self.wait("the unit", lambda s: s["units"][1]["state"] == "streaming")
        self.check_schema(status, "campaign-status")
        self.assertIsNone(status["units"][0]["dropped"])
        self.assertTrue(status["units"][1]["dropped"])
        self.assertRegex(self.lab.soak("campaign", "status"), f"{SECOND}.*dropped")

    def test_a_campaign_that_waits_ends_safely_when_all_of_them_are_dropped(self):
        self.start_lab(rate=400, cut=["chamber", "unit1"])
        self.start_campaign(short_procedure(dwell_s=6000, extra="[suspend]\ngive_up_h = 100.0\n"))
        self.wait_for_step("record")
        for wire in self.proxies.values():
            wire.cut()
        status = self.wait("the end of waiting", lambda s: s["state"] == "stopping", seconds=180)  # a minute, and no 15
        self.assertEqual(status["ending"]["outcome"], "failed")
        self.proxies["chamber"].mend()
        self.assertEqual(self.wait_for_end()["state"], "failed")
        self.assert_safe()
        self.assertEqual(self.status()["resumable"], "c")


class DeadChamber(LabTest):
    def test_a_station_that_is_asked_to_stop_gives_up_a_chamber_that_never_answers(self):
        self.start_lab(rate=400, cut=["chamber"])
        self.start_campaign(short_procedure())
        self.wait_for_step("wait_stable")
        self.proxies["chamber"].cut()
        stopped_s = time.monotonic()
        self.lab.soakd.send_signal(signal.SIGTERM)
        self.assertEqual(self.lab.soakd.wait(bench.WAIT_S), 3)
        self.assertGreater((time.monotonic() - stopped_s) * self.lab.rate, SILENT_FOR_GOOD_S)
        self.lab.soakd.stdout.close()
        self.proxies["chamber"].mend()
        self.assertEqual(self.chamber()[0], bench.AUTO, "nobody has switched it off")
        self.lab.start_soakd()
        status = self.wait_for_end()
        self.assertIn(status["state"], ("interrupted", "failed"), "by this fast clock the way to the safe state was overdue as well")
        self.assertEqual(status["resumable"], "c")
        self.assert_safe()


if __name__ == "__main__":
    bench.main()
