# SPDX-License-Identifier: Apache-2.0
"""A chamber whose thermometer is wrong, stuck or unreadable, and a wire that spoils answers. The chamber's own registers, which
the station does not see here, and the units' recordings are judged."""
import math
import random
import struct
import unittest

import bench
from bench import AUTO, OFF, LabTest, long_test, short_procedure
from modbus_proxy import READ, with_read_f32, with_written_f32

SET_POINT, WORKING, AIR = 2782, 2810, 2820
ALARM, ALARM_ON = 1356, 60  # 61, which is none, with its lowest bit flipped
RATED_MAX_C = 85.0  # of the simulated units' type


class WrongChamber(LabTest):
    def start(self, procedure, rate=400, **changes):
        def edit(text):
            text = self.with_chamber_proxy(text)
            for name, change in changes.items():
                setattr(self.proxy, name, change)
            return text
        self.start_lab(rate=rate, edit=edit)
        self.start_campaign(procedure)

    def wait_until_off(self):
        client = self.modbus("chamber")
        return self.wait("heating and cooling off", lambda s: client.read_holding_registers(2814, 1, 1).registers == [OFF], lab_s=8.0)

    def test_a_chamber_that_is_far_hotter_than_it_says_is_switched_off_by_the_units_thermometers(self):
        def answer(request, data):
            for register in (SET_POINT, WORKING, AIR):
                data = with_read_f32(register, lambda value: value - 35.0)(request, data)
            return data
        self.start(short_procedure(set_points=(15, 60), positions=("+Z",), dwell_s=100000), change_answer=answer,
                   change_request=with_written_f32(SET_POINT, lambda value: value + 35.0))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assertIn("0380A001", status["reason"])
        mode, output, *_ = self.chamber()
        self.assertEqual((mode, output), (OFF, 0.0))
        (hottest,), = self.query("SELECT max(temp_c) FROM segment") or [(0,)]
        self.assertLess(hottest or 0.0, RATED_MAX_C + 8.0)

    @long_test
    def test_a_thermometer_that_is_stuck_ends_the_campaign(self):
        self.start(short_procedure(set_points=(60,), positions=("+Z",)), change_answer=with_read_f32(AIR, lambda value: min(value, 34.0)))
        status = self.wait_until_off()
        self.assertNotEqual(status["state"], "finished")
        self.assertEqual(self.wait_for_end()["state"], "failed")
        self.assertEqual(self.chamber()[:2], (OFF, 0.0))
        self.assertLess(self.chamber()[3], 70.0)

    @long_test
    def test_a_chamber_whose_temperature_is_no_number_is_switched_off(self):
        self.start(short_procedure(set_points=(30,), positions=("+Z",), dwell_s=100000))
        self.wait_for_step("record")
        self.assertEqual(self.chamber()[0], AUTO)
        self.proxy.change_answer = with_read_f32(AIR, lambda value: math.nan)
        self.wait_until_off()
        self.assertEqual(self.chamber()[1], 0.0)
        # Once it can be read again it is driven to where no unit gathers dew, and the campaign ends as it should.
        self.proxy.change_answer = lambda request, answer: answer
        self.assertEqual(self.wait_for_end()["state"], "failed")
        self.assert_safe()

    @long_test
    def test_a_flipped_bit_that_looks_like_an_alarm_ends_nothing(self):
        flips = []

        def answer(request, data):
            # Alarm 1 of the loop, in the middle of the recording, once.
            if request[0] == READ and request[1:3] == struct.pack(">H", ALARM) and not flips and self.flip:
                flips.append(data)
                return data[:2] + struct.pack(">H", ALARM_ON) + data[4:]
            return data
        self.flip = False
        self.start(short_procedure(set_points=(30,), positions=("+Z", "-Z"), dwell_s=2000), change_answer=answer)
        self.wait_for_step("record")
        self.flip = True
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assertEqual(len(flips), 1)
        self.assert_safe()

    def test_a_wire_that_spoils_every_tenth_answer_costs_no_campaign(self):
        noise = random.Random(4)

        def answer(request, data):
            if noise.random() >= 0.1:
                return data
            return noise.choice([bytes([request[0] | 0x80, 4]), data[:-1], bytes(noise.randrange(256) for _ in data), b"\x83\x0b"])
        self.start(short_procedure(set_points=(15, 30)))
        self.proxy.change_answer = answer
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assertEqual(self.query("SELECT count(DISTINCT visit || position) FROM segment_dps"), [(4,)])
        self.assert_safe()


if __name__ == "__main__":
    bench.main(first=("test_a_chamber_whose_temperature_is_no_number_is_switched_off",))
