# SPDX-License-Identifier: Apache-2.0
"""Whatever feeds the units: a supply that measures, outputs of the chamber's controller, a supply that is not ours.

The supply is tests/hal/scpi_supply.py, a peer after SCPI-99; what it or the chamber's event outputs switch is wired to
soaksim's relays, and so to the units."""
import csv
import re
import subprocess
import sys
import threading
import time
import unittest

import bench
from bench import OFF, ROOT, WAIT_S, LabTest, bin_folder, long_test, short_procedure

sys.path.insert(0, str(ROOT / "tests" / "hal"))
from scpi_supply import Supply  # noqa: E402

OHM = 50.0  # a unit
EVENT_ON = 63
MAPS = ROOT / "procedures"


def section(text, name, content):
    """The configuration with another section of that name."""
    changed = re.sub(rf"^\[{name}\]\n(?:(?!\[).*\n)*", f"[{name}]\n{content}\n", text, count=1, flags=re.M)
    assert changed != text
    return changed


def in_slot(text, number, lines):
    return text.replace(f"power_output = {number}\n", lines + "\n")


class UnitPower(LabTest):
    def start_with_supply(self, units=1, rate=200, volts=12.0, limit_a=0.5):
        """A station whose units are fed by a supply of three outputs."""
        self.switched = []  # output, on, when
        self.supply = Supply(switched=self.wire)
        for output in self.supply.outputs[:units]:
            output.ohm = OHM
        port = self.supply.start()

        def edit(text):
            # Before the first command comes from soakd.
            self.relays = self.modbus("relay")
            supply_map = MAPS / "power" / "scpi-supply.toml"
            text = section(text, "power", f'map = "{supply_map}"\nhost = "127.0.0.1"\nport = {port}\n')
            for n in range(1, units + 1):
                text = in_slot(text, n, f"power_output = {n}\nsupply_v = {volts}\nsupply_limit_a = {limit_a}")
            return text

        self.start_lab(units=units, rate=rate, edit=edit)

    def wire(self, output, on):
        self.switched.append((output, on, time.monotonic()))
        self.relays.write_register(output - 1, int(on), 1)

    def test_volts_and_amps_are_shown_and_recorded(self):
        self.start_with_supply()
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",)))
        status = self.wait("volts", lambda s: s["units"] and (s["units"][0]["supply_v"] or 0.0) > 0.0)
        self.check_schema(status, "campaign-status")
        self.assertEqual((status["units"][0]["supply_v"], status["units"][0]["supply_a"]), (12.0, 0.24))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_safe()
        self.assertFalse(self.supply.outputs[0].on)
        self.assertIsNone(self.status()["units"][0]["supply_v"], "nobody asks after the run")
        (run_id,), = self.query("SELECT run_id FROM run")
        table = self.folder / "run.csv"
        self.lab.soak("runs", "export", run_id, "--unit", "0380A001", "-o", table)
        with open(table, encoding="utf-8") as rows:
            said = {(row["supply_v"], row["supply_a"]) for row in csv.DictReader(rows) if row["supply_v"]}
        self.assertEqual({(float(volts), float(amps)) for volts, amps in said}, {(12.0, 0.24)})

    def expect_unit_2_left_out(self, *data):
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertIn("0380A002 in R01", status["reason"])
        self.assert_event("unit", "0380A002", "slot 2", *data)
        self.assertEqual(self.query("SELECT DISTINCT unit FROM segment"), [("0380A001",)])
        self.assertFalse(self.supply.outputs[1].on)

    def test_a_unit_that_stays_at_the_current_limit_is_switched_off_and_left_out(self):
        self.start_with_supply(units=2)
        self.supply.outputs[1].ohm = 1.0
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",)))
        self.expect_unit_2_left_out("output 2", "0.5 A")

    @long_test
    def test_a_unit_that_trips_the_protection_is_tried_once_and_left_out(self):
        self.start_with_supply(units=2)
        self.supply.outputs[1].ohm = 1.0
        self.supply.outputs[1].protects_current = True
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",)))
        self.expect_unit_2_left_out("output 2")
        self.assertEqual([message for message in self.supply.log if message == "OUTP 1,(@2)"], ["OUTP 1,(@2)"])

    @long_test
    def test_a_unit_whose_output_goes_off_in_mid_run_is_lost_and_the_other_goes_on(self):
        self.start_with_supply(units=2)
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",), dwell_s=120))
        self.wait_for_step("record")
        self.supply.obey(["off", "2"])
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_event("unit", "0380A002", "output 2")
        self.assertEqual(self.query("SELECT DISTINCT unit FROM void"), [("0380A002",)])

    def test_a_shorted_unit_in_the_pre_flight_ends_the_campaign_before_anything_is_recorded(self):
        self.start_with_supply(units=2)
        self.supply.outputs[1].ohm = 1.0
        self.start_campaign(short_procedure(preflight_s=30))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assertRegex(status["reason"], "0380A002.*slot 2.*output 2")
        self.assertEqual(self.query("SELECT run_id FROM run"), [])
        self.assert_safe()

    @long_test
    def test_a_supply_that_comes_back_at_the_end_still_switches_the_units_off(self):
        self.start_with_supply()
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",), dwell_s=100000))
        self.wait_for_step("record")
        self.supply.obey(["fault", "close", "1000"])
        self.lab.soak("campaign", "abort", "--reason", "test")
        chamber = self.modbus("chamber")
        self.wait("the chamber to be off", lambda s: chamber.read_holding_registers(2814, 1, 1).registers == [OFF])
        self.assertTrue(self.supply.outputs[0].on)
        self.supply.obey(["fault", "close", "0"])
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.assertFalse(self.supply.outputs[0].on)
        self.assert_safe()

    @long_test
    def test_an_output_stays_off_for_its_time_also_after_an_abort(self):
        rate, off_s = 50, 150
        self.start_with_supply(rate=rate)
        procedure = short_procedure(set_points=(25,)).replace("off_s = 10", f"off_s = {off_s}")
        self.start_campaign(procedure, "a")
        self.wait_for_step("wait_stable")
        self.lab.soak("campaign", "abort", "--reason", "test")
        self.wait("the safe state", lambda s: s["state"] == "aborted")
        self.start_campaign(procedure, "b")
        self.wait_for_step("wait_stable")
        # As far as its first run: on at the beginning, off by the abort, on again.
        times = [(on, at) for _, on, at in self.switched]
        self.assertEqual([on for on, _ in times], [True, False, True])
        self.assertGreaterEqual((times[2][1] - times[1][1]) * rate, off_s)

    def test_the_chambers_own_outputs_feed_the_units(self):
        own_map = self.folder / "f4t.toml"
        quantities = "".join(f"""
[quantity.unit_power_{n}]
address = {16594 + 2 * (n - 1)}
type = "u16"
write_function = 6
codes = {{ off = 62, on = 63 }}
""" for n in (1, 2))
        shipped = (MAPS / "chambers" / "watlow-f4t.toml").read_text(encoding="utf-8")
        own_map.write_text(shipped + quantities, encoding="utf-8")

        def edit(text):
            text = section(text, "power", 'from = "chamber"\n')
            return text.replace(str(MAPS / "chambers" / "watlow-f4t.toml"), str(own_map))

        self.start_lab(units=2, rate=200, edit=edit)
        self.assertIn(str(own_map), self.config.read_text(encoding="utf-8"))
        self.wire_events()
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",)))
        self.wait_for_step("record")
        outputs = self.modbus("chamber").read_holding_registers(16594, 3, 1).registers
        self.assertEqual((outputs[0], outputs[2]), (EVENT_ON, EVENT_ON))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.wait_for_relays_off()
        self.assert_safe()
        self.assertEqual(self.query("SELECT unit, count(*) FROM segment GROUP BY unit"), [("0380A001", 1), ("0380A002", 1)])

    def wire_events(self):
        done = threading.Event()
        wires = threading.Thread(target=self.mirror_events, args=(done,), daemon=True)
        wires.start()

        def cut():
            done.set()
            wires.join()
        self.addCleanup(cut)

    def wait_for_relays_off(self):
        """The wires take their time."""
        relays = self.modbus("relay")
        end_s = time.monotonic() + WAIT_S
        while relays.read_holding_registers(16, 2, 1).registers != [0, 0]:
            self.assertLess(time.monotonic(), end_s, "the event outputs are on")
            time.sleep(0.01)

    def mirror_events(self, done):
        """The wires from the chamber's event outputs 1 and 2 to what feeds the units."""
        chamber, relays = self.modbus("chamber"), self.modbus("relay")
        held = [None, None]
        while not done.wait(0.002):
            registers = chamber.read_holding_registers(16594, 3, 1).registers
            for n, on in enumerate((registers[0] == EVENT_ON, registers[2] == EVENT_ON)):
                if on != held[n]:
                    relays.write_register(n, int(on), 1)
                held[n] = on

    def start_with_foreign_supply(self):
        """Unit 2 is fed by a supply that nobody switches; its slot names an output that feeds nothing."""
        def edit(text):
            self.modbus("relay").write_register(1, 1, 1)
            return in_slot(text, 2, "power_output = 9")
        self.start_lab(units=2, edit=edit)

    @long_test
    def test_a_unit_that_another_supply_feeds_is_named_and_left_out(self):
        self.start_with_foreign_supply()
        self.start_campaign(short_procedure(set_points=(25,), positions=("+Z",)))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_event("unit", "0380A002", "slot 2", "output 9")
        self.assertEqual(self.query("SELECT DISTINCT unit FROM segment"), [("0380A001",)])

    def test_the_pre_flight_ends_a_campaign_with_a_unit_that_another_supply_feeds(self):
        self.start_with_foreign_supply()
        self.start_campaign(short_procedure(preflight_s=30))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assertRegex(status["reason"], "0380A002.*slot 2.*output 9")
        self.assertEqual(self.query("SELECT run_id FROM run"), [])

    def test_what_the_supply_cannot_do_is_refused_at_the_start(self):
        for lines, said in (("power_output = 4", "slot 1: .* 4"), ("power_output = 3\nsupply_v = 48", "slot 1: .* 3 .* 48")):
            config = self.write("station.toml", f"""[chamber]
map = "{MAPS}/chambers/watlow-f4t.toml"
host = "127.0.0.1"
[power]
map = "{MAPS}/power/scpi-supply.toml"
host = "127.0.0.1"
[[slot]]
name = "1"
host = "127.0.0.1"
port = 1
{lines}
""")
            done = subprocess.run([bin_folder() + "/soakd", "--config", config, "--data", self.folder / "data"], text=True,
                                  capture_output=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertRegex(done.stderr, said)

    def test_the_chamber_goes_cold_only_once_somebody_says_that_dry_air_flows(self):
        self.start_lab(edit=lambda text: "[purge]\nbelow_c = 18\n\n" + text)
        self.start_campaign(short_procedure(set_points=(21, 15)))
        status = self.wait("the question", lambda s: s["prompt"] is not None)
        self.assertEqual(status["campaign"]["step_kind"], "set_temperature")
        self.assertIn("+15.0 °C", status["prompt"]["text"])
        self.check_schema(status, "campaign-status")
        self.assertEqual(status["state"], "waiting")
        self.assertEqual(self.chamber()[2], 21.0, "the chamber still holds the set point before")
        self.lab.soak("campaign", "confirm")
        self.wait("the cold", lambda s: s["chamber"]["set_point_c"] == 15.0)
        self.assert_event("chamber", "purge")


if __name__ == "__main__":
    bench.main()
