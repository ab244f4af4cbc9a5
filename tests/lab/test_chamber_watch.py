# SPDX-License-Identifier: Apache-2.0
"""The chamber overheats while the engine is blocked: the watch, with a connection of its own, switches heating and cooling off
before the engine turns again."""
import contextlib
import pathlib
import re
import sqlite3
import time
import unittest

import bench
from bench import AUTO, OFF, LabTest, short_procedure
from modbus_proxy import with_read_f32

AIR = 2820
TIMEOUT_S = 30  # of the fixture: for so long it blocks who asks


class ChamberWatch(LabTest):
    def edit(self, text):
        """The chamber behind a proxy that can lie, and a fixture whose silence blocks the engine for long."""
        text = self.with_chamber_proxy(text)
        fixture = re.search(r'^\[fixture\]\n(?:.+\n)*?map = "([^"]+)"', text, flags=re.M).group(1)
        source = pathlib.Path(fixture)
        slow = re.sub(r"^response_timeout_s = .*\n", "", source.read_text(encoding="utf-8"), flags=re.M)
        slow = slow.replace("[link]\n", f"[link]\nresponse_timeout_s = {TIMEOUT_S}\n", 1)
        return text.replace(fixture, str(self.write("slow-fixture.toml", slow)))

    def wait_until_blocked(self):
        """The status, once nothing in it has moved for two seconds: the chamber's last digits do while the engine turns."""
        end_s = time.monotonic() + bench.WAIT_S
        before, since_s = self.status(), time.monotonic()
        while time.monotonic() - since_s < 2.0:
            self.assertLess(time.monotonic(), end_s, "the engine is never blocked")
            time.sleep(0.05)
            status = self.status()
            if status != before:
                before, since_s = status, time.monotonic()
        return before

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


if __name__ == "__main__":
    bench.main()
