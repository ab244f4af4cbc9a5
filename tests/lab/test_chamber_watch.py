# SPDX-License-Identifier: Apache-2.0
"""The chamber overheats while the engine is blocked: the watch, with a connection of its own, switches heating and cooling off
before the engine turns again."""
import contextlib
import pathlib
import re
import sqlite3
import struct
import threading
import time
import unittest

import bench
from bench import AUTO, OFF, LabTest, long_test, short_procedure
from modbus_proxy import READ, WRITE_ONE, reads, with_read_f32

AIR, MODE = 2820, 2730
SWITCH_OFF = struct.pack(">BHH", WRITE_ONE, MODE, OFF)
TIMEOUT_S = 30  # of a link: for so long a device may block who asks
SHORTEST_POLL_S = 0.1
LONGER_THAN_POLL = 4  # readings of the watch, which rests for 50 ms between two


class ChamberWatch(LabTest):
    def edit(self, text):
        """The chamber behind a proxy that can lie, and a fixture whose silence blocks the engine for long."""
        return self.with_link(self.with_chamber_proxy(text), "fixture", response_timeout_s=TIMEOUT_S)

    def with_link(self, text, device, **link):
        """The configuration with a map of that device whose link has other settings."""
        name = re.search(rf'^\[{device}\]\n(?:.+\n)*?map = "([^"]+)"', text, flags=re.M).group(1)
        changed = pathlib.Path(name).read_text(encoding="utf-8")
        for key, value in link.items():
            changed = re.sub(rf"^{key} = .*\n", "", changed, flags=re.M)
            changed = changed.replace("[link]\n", f"[link]\n{key} = {value}\n", 1)
        return text.replace(name, str(self.write(f"{device}.toml", changed)))

    def wait_until_blocked(self):
        """The status, once the engine waits for the fixture."""
        self.assertTrue(self.proxies["fixture"].lost.wait(bench.WAIT_S), "nobody asks the fixture")
        return self.status()

    def test_an_overheating_chamber_is_switched_off_while_the_engine_is_blocked(self):
        self.start_lab(cut=["fixture"], edit=self.edit)
        self.start_campaign(short_procedure(set_points=(30,)))
        self.wait_for_step("wait_stable")
        self.proxies["fixture"].silence()
        blocked = self.wait_until_blocked()
        self.assertEqual(self.chamber()[0], AUTO)
        self.proxy.change_answer = with_read_f32(AIR, lambda value: value + 60.0)
        client = self.modbus("chamber")
        end_s = time.monotonic() + TIMEOUT_S
        while client.read_holding_registers(2814, 1, 1).registers != [OFF]:
            self.assertLess(time.monotonic(), end_s, "nobody has switched the chamber off")
            time.sleep(0.02)
        self.assertEqual(self.status(), blocked, "the engine turned: it was not the watch")
        self.proxies["fixture"].mend()
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assertEqual(self.chamber()[:2], (OFF, 0.0))
        self.assert_event("campaign", "c", status["reason"])


    def test_a_trip_while_the_last_step_waits_for_its_entry_ends_the_campaign_as_tripped(self):
        self.start_lab(edit=self.edit)
        begun = self.start_campaign(short_procedure(set_points=(30,)))
        with contextlib.closing(sqlite3.connect(f"{self.lab.data}/station.db", timeout=30)) as catalog:
            catalog.execute(f"CREATE TRIGGER refuse BEFORE INSERT ON step WHEN NEW.step_index = {begun['steps'] - 1} "
                            "BEGIN SELECT RAISE(ABORT, 'refused by the test'); END")
        self.wait("the last step's end", lambda s: s["suspension"] and s["campaign"]["step"] == begun["steps"] - 1)
        self.proxy.change_answer = with_read_f32(AIR, lambda value: value + 60.0)
        self.wait("the trip", lambda s: s["state"] not in ("running", "waiting"))
        self.proxy.change_answer = lambda request, answer: answer
        with contextlib.closing(sqlite3.connect(f"{self.lab.data}/station.db", timeout=30)) as catalog:
            catalog.execute("DROP TRIGGER refuse")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assertIn("air", status["reason"])
        self.assertEqual(status["resumable"], "c")
        self.assert_safe()

    def edit_patiently(self, text):
        """Chamber and relay behind proxies that may hold answers back for long."""
        text, self.relay = self.with_proxy(self.with_chamber_proxy(text), "relay")
        text = self.with_link(text, "chamber", response_timeout_s=TIMEOUT_S, poll_s=SHORTEST_POLL_S)
        return self.with_link(text, "power", response_timeout_s=TIMEOUT_S)

    @long_test
    def test_a_trip_in_the_very_turn_in_which_the_last_step_ends_ends_the_campaign_as_tripped(self):
        """The engine has looked at the watch for the last time when the trip comes. What is held back makes that so: first the command
        that switches the unit off, until the run is sealed and the chamber due to be read again, then that reading, which begins the
        turn, until the watch, which reads beside the engine, has tripped."""
        self.start_lab(edit=self.edit_patiently)
        begun = self.start_campaign(short_procedure(set_points=(30,)).replace("off_s = 10", "off_s = 0"))
        engine = []  # the thread of the proxy that serves it: who switches the chamber off at the campaign's end
        reads_of_watch = []
        unit_is_off, tripped = threading.Event(), threading.Event()

        def at_chamber(request):
            me = threading.get_ident()
            if request == SWITCH_OFF and not engine:
                engine.append(me)
                self.relay.answer = at_relay
            if request == SWITCH_OFF and me not in engine:
                tripped.set()
            if reads(request, AIR) and me not in engine:
                reads_of_watch.append(request)
            if request[0] == READ and me in engine and unit_is_off.is_set() and not tripped.is_set():
                self.proxy.change_answer = with_read_f32(AIR, lambda value: value + 60.0)
                tripped.wait(TIMEOUT_S)

        def at_relay(request):
            if request[0] == WRITE_ONE and not unit_is_off.is_set():
                reads_of_watch.clear()
                end_s = time.monotonic() + TIMEOUT_S
                while time.monotonic() < end_s and not (self.query("SELECT 1 FROM run") and len(reads_of_watch) >= LONGER_THAN_POLL):
                    time.sleep(0.01)
                unit_is_off.set()

        self.proxy.answer = at_chamber
        status = self.wait_for_end()
        self.assertEqual(self.query("SELECT count(*) FROM step WHERE outcome = 'done'"), [(begun["steps"],)])
        self.assertTrue(tripped.is_set())
        self.assertEqual(status["state"], "failed")
        self.assertIn("air", status["reason"])
        self.assertEqual(status["resumable"], "c")
        self.assert_safe()


if __name__ == "__main__":
    bench.main()
