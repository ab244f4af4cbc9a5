# SPDX-License-Identifier: Apache-2.0
"""Devices that answer and do not obey: a chamber that does not take its set point any more, a fixture that somebody else
turns. The chamber's registers and the catalog are judged, not what soakd says of them."""
import struct
import unittest

import bench
from bench import AUTO, OFF, LabTest, long_test, short_procedure
from modbus_proxy import forgets, refuses, says_so_and_goes_on

SET_POINT, MODE = 2782, 2730
WORTH_OF_MEMORY = 12  # writes; controllers bear some 100,000 in their lives


class RefusingChamber(LabTest):
    def start(self, set_point_c, dwell_s=100000):
        self.start_lab(rate=400, edit=self.with_chamber_proxy)
        self.start_campaign(short_procedure(set_points=(set_point_c,), positions=("+Z",), dwell_s=dwell_s))
        self.wait_for_step("record")
        self.assertEqual(self.chamber()[0], AUTO)

    def abort_with(self, answer):
        self.proxy.answer = answer
        self.proxy.writes.clear()
        self.lab.soak("campaign", "abort", "--reason", "test")

    def wait_until_off(self):
        client = self.modbus("chamber")
        return self.wait("heating and cooling off", lambda s: client.read_holding_registers(2814, 1, 1).registers == [OFF])

    def expect_off_without_warmth(self, held_c):
        status = self.wait_until_off()
        if status["state"] == "stopping":
            self.wait("a word for the operator", lambda s: s["state"] != "stopping" or "+25 °C" in s["reason"])
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        mode, output, set_point_c, _ = self.chamber()
        self.assertEqual((mode, output, round(set_point_c, 3)), (OFF, 0.0, held_c))
        self.assert_event("device", "chamber", "+25 °C")
        self.assertLessEqual(len(self.proxy.writes_to(SET_POINT)), WORTH_OF_MEMORY)
        count = len(self.lab.ports["units"])
        self.assertEqual(self.modbus("relay").read_holding_registers(16, count, 1).registers, [0] * count, "units are on")

    def test_a_hot_chamber_that_refuses_to_be_driven_to_room_temperature_is_switched_off(self):
        self.start(60)
        self.abort_with(refuses(SET_POINT))
        self.expect_off_without_warmth(60.0)

    @long_test
    def test_a_cold_chamber_that_forgets_its_set_point_is_switched_off_and_the_units_stay_on_until_they_are_dry(self):
        self.start(-20)
        self.abort_with(forgets(SET_POINT))
        status = self.wait_until_off()
        self.assertEqual(status["state"], "stopping", "the air is cold: units would gather dew")
        self.expect_off_without_warmth(-20.0)
        self.assertGreater(self.chamber()[3], 15.0)

    @long_test
    def test_a_chamber_that_cannot_be_switched_off_is_told_so_once_a_second_and_not_more(self):
        self.start(25)
        self.abort_with(refuses(MODE))
        self.wait("a try", lambda s: self.proxy.writes_to(MODE))
        before = len(self.proxy.writes_to(MODE))
        status = self.wait("more tries", lambda s: len(self.proxy.writes_to(MODE)) >= before + 2)
        self.assertEqual(status["state"], "stopping")
        self.assertLessEqual(len(self.proxy.writes_to(MODE)), before + 3)
        self.check_schema(status, "campaign-status")
        self.assertTrue(status["ending"]["needs_somebody"])
        self.assert_event("alarm", "chamber", status["chamber"]["description"])
        self.proxy.answer = lambda request: None
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.assert_safe()

    @long_test
    def test_a_chamber_whose_register_says_off_while_it_heats_is_written_to_until_it_is_off(self):
        self.start(25)
        self.abort_with(says_so_and_goes_on(MODE, OFF, times=2))
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.assert_safe()
        self.assertEqual(self.proxy.writes_to(MODE).count(struct.pack(">H", OFF)), 3)

    @long_test
    def test_the_end_of_a_campaign_waits_for_somebody_where_the_chamber_cannot_be_switched_off(self):
        self.start(25, dwell_s=30)
        self.proxy.answer = forgets(MODE)
        status = self.wait("a word for somebody", lambda s: s["state"] == "waiting" and s["campaign"]["step_kind"] == "warm_end")
        self.assertTrue(status["reason"])
        self.assert_event("alarm", "chamber", status["chamber"]["description"])
        self.proxy.answer = lambda request: None
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.query("SELECT cut_short FROM run"), [("",)])
        self.assert_safe()


class FixtureTurnedBySomebodyElse(LabTest):
    def test_units_that_were_turned_between_judgement_and_recording_are_not_recorded(self):
        self.start_lab(units=2, rate=400)
        self.start_campaign(short_procedure(set_points=(15,), positions=("+Z",)))
        self.wait("the soak", lambda s: s["campaign"] and s["campaign"]["step_kind"] == "wait_stable")
        self.modbus("fixture").write_register(0, 1, 1)  # +X
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        for part in ("+Z", "0380A001", "slot 1"):
            self.assertIn(part, status["reason"])
        self.assertEqual(self.query("SELECT count(*) FROM segment"), [(0,)])
        self.assert_safe()


if __name__ == "__main__":
    bench.main()
