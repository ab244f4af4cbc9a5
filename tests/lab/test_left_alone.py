# SPDX-License-Identifier: Apache-2.0
"""What a station that nobody looks at for weeks notices by itself: a data folder that goes away, units that are dropped one after the
other, a chamber that never answers again, or never goes off."""
import os
import signal
import time
import unittest

import bench
from bench import LabTest, long_test, short_procedure
from modbus_proxy import refuses

SECOND = "0380A002"
HOPELESS_S = 7200.0  # process time after which a soakd that is to end gives up a chamber that does not answer, or does not go off
MODE = 2730  # register of the controller


class DataFolder(LabTest):
    def move_away(self):
        os.rename(self.lab.data, self.lab.data + ".away")

    def move_back(self):
        os.rename(self.lab.data + ".away", self.lab.data)

    def trouble(self, status):
        self.check_schema(status, "campaign-status")
        return status["data"]["trouble"]

    def start(self):
        return self.lab.soak("campaign", "start", self.write("procedure.toml", short_procedure()), "--name", "c")

    @long_test
    def test_one_that_goes_away_under_an_idle_station_is_a_problem_and_no_campaign_begins(self):
        self.start_lab()
        self.assertIsNone(self.trouble(self.status()))
        self.move_away()
        self.assertIn(self.lab.data, self.wait("the finding", self.trouble, seconds=20)["reason"])
        self.assertIn(self.lab.data, self.lab.soak("campaign", "status"))
        self.soak_fails(1, "campaign", "start", self.write("procedure.toml", short_procedure()), "--name", "c")
        self.assertFalse(os.path.exists(self.lab.data), "nothing is made in its place")
        os.mkdir(self.lab.data)  # the mount point without its disk
        time.sleep(2)
        self.assertTrue(self.trouble(self.status()))
        os.rmdir(self.lab.data)
        self.move_back()
        self.wait("its return", lambda s: not self.trouble(s), seconds=20)
        self.assert_event("storage", self.lab.data)
        self.start()
        self.assertEqual(self.wait_for_end()["state"], "finished")

    def test_one_that_goes_away_under_a_campaign_suspends_it_until_it_is_back(self):
        self.start_lab(rate=100)
        self.start_campaign(short_procedure(set_points=(15,), dwell_s=1500))
        self.wait_for_step("record")
        self.move_away()
        status = self.wait("the suspension", lambda s: s["suspension"])
        self.assertEqual((status["state"], status["suspension"]["causes"]), ("waiting", ["storage"]))
        time.sleep(6)  # a flush is tried meanwhile
        status = self.status()
        self.assertEqual(status["state"], "waiting")
        self.assertEqual(self.chamber()[0], bench.AUTO, "the chamber holds its set point")
        self.move_back()
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_safe()
        self.lab.soak("runs", "verify")
        self.assertEqual(self.query("SELECT label, cut_short FROM run"), [("R01", "")])


class Units(LabTest):
    @long_test
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

    @long_test
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


class ChamberWithoutHope(LabTest):
    def test_a_station_that_is_asked_to_stop_gives_up_a_chamber_that_never_answers(self):
        self.start_lab(rate=400, cut=["chamber"])
        self.start_campaign(short_procedure())
        self.wait_for_step("wait_stable")
        self.proxies["chamber"].cut()
        stopped_s = time.monotonic()
        self.lab.soakd.send_signal(signal.SIGTERM)
        self.assertEqual(self.lab.soakd.wait(bench.WAIT_S), 3)
        self.assertGreater((time.monotonic() - stopped_s) * self.lab.rate, HOPELESS_S)
        self.lab.soakd.stdout.close()
        self.proxies["chamber"].mend()
        self.assertEqual(self.chamber()[0], bench.AUTO, "nobody has switched it off")
        self.lab.start_soakd()
        status = self.wait_for_end()
        self.assertIn(status["state"], ("interrupted", "failed"), "by this fast clock the way to the safe state was overdue as well")
        self.assertEqual(status["resumable"], "c")
        self.assert_safe()


    @long_test
    def test_a_station_that_is_asked_to_stop_gives_up_a_chamber_that_answers_and_does_not_go_off(self):
        self.start_lab(rate=400, edit=self.with_chamber_proxy)
        self.start_campaign(short_procedure(set_points=(25,)))
        self.wait_for_step("wait_stable")
        self.proxy.answer = refuses(MODE)
        stopped_s = time.monotonic()
        self.lab.soakd.send_signal(signal.SIGTERM)
        self.assertEqual(self.lab.soakd.wait(bench.WAIT_S), 3)
        self.assertGreater((time.monotonic() - stopped_s) * self.lab.rate, HOPELESS_S)
        self.assertIn("not confirmed safe", self.lab.log())
        self.assert_event("alarm", "chamber", "127.0.0.1")
        self.lab.soakd.stdout.close()
        self.assertEqual(self.chamber()[0], bench.AUTO, "nobody has switched it off")
        self.proxy.answer = lambda request: None
        self.lab.start_soakd()
        status = self.wait_for_end()
        self.assertIn(status["state"], ("interrupted", "failed"), "what went wrong on the way is for people")
        self.assertEqual(status["resumable"], "c")
        self.assert_safe()


if __name__ == "__main__":
    bench.main()
