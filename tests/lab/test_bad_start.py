# SPDX-License-Identifier: Apache-2.0
"""What cannot go well is refused before anything moves: a clear message, the right exit status, nothing half done."""
import pathlib
import shutil
import subprocess
import unittest

import bench
from bench import AUTO, OFF, LabTest, long_test, short_procedure
from lab_session import ROOT, ProgramFailed, bin_folder, end


class BadStart(LabTest):
    def refused(self, status, procedure, *options):
        """The message with which a start is refused; the station is as before, the journal is empty, nothing moved."""
        message = self.soak_fails(status, "campaign", "start", self.write("p.toml", procedure), "--name", "c", *options)
        self.assertEqual(self.status()["state"], "idle")
        self.assertEqual(self.query("SELECT * FROM journal"), [])
        self.assertEqual(self.query("SELECT * FROM run"), [])
        self.assertEqual(list((pathlib.Path(self.lab.data) / "runs").glob("*")), [])
        self.assertEqual(self.chamber()[0], OFF)
        return message

    def test_procedures_with_mistakes(self):
        self.start_lab()
        good = short_procedure()
        message = self.refused(2, good + "colour = 1\n")
        self.assertIn(f":{len(good.splitlines()) + 1}:", message)
        self.assertIn("'colour'", message)
        message = self.refused(2, short_procedure(positions=("+X", "-X", "+X")))
        self.assertIn("+X", message)
        self.assertIn("p.toml:8", message)

    def test_set_points_beyond_the_rating_of_a_unit(self):
        self.start_lab()
        message = self.refused(2, short_procedure(set_points=(25, 84)))
        for word in ("84", "85", "mti-300"):
            self.assertIn(word, message)

    def test_set_points_beyond_the_chamber(self):
        self.start_lab()
        client = self.modbus("chamber")
        client.write_registers(2776, self.words_f32(60.0), 1)
        self.assertIn("60", self.refused(2, short_procedure(set_points=(25, 70))))

    @long_test
    def test_a_pre_flight_in_a_hot_chamber(self):
        self.start_lab(rate=2000)
        client = self.modbus("chamber")
        client.write_registers(2782, self.words_f32(60.0), 1)
        client.write_registers(2730, [AUTO], 1)
        self.wait("hot air", lambda s: (s["chamber"]["air_c"] or 0.0) > 40.0)
        message = self.soak_fails(2, "campaign", "start", self.write("p.toml", short_procedure(preflight_s=10)), "--name", "c")
        self.assertRegex(message, r"^state: .*\+25\.0 °C")
        self.assertEqual(self.query("SELECT * FROM journal"), [])

    def test_two_slots_with_one_serial(self):
        self.start_lab(units=2)
        message = self.refused(2, short_procedure(), "--unit", "1=0380A001", "--unit", "2=0380A001")
        self.assertIn("--unit: ", message)
        self.assertIn("0380A001", message)

    def test_a_unit_in_another_slot_than_stated_is_found_before_anything_is_recorded(self):
        self.start_lab(units=2)
        self.lab.soak("campaign", "start", self.write("p.toml", short_procedure()), "--name", "c", "--unit", "1=0380A002",
                      "--unit", "2=0380A001")
        asked = self.wait("a question", lambda s: s["prompt"])["prompt"]
        # One question for both slots, with the answer in it.
        self.assertRegex(asked["text"], "slot 1.*0380A001.*0380A002.*slot 2.*0380A002.*0380A001.*"
                         "--unit 1=0380A001 --unit 2=0380A002")
        self.assertEqual(self.query("SELECT * FROM run"), [])
        # Confirmed without a change it looks again, and asks again.
        self.lab.soak("campaign", "confirm")
        self.wait("the question again", lambda s: s["prompt"] and s["prompt"]["id"] != asked["id"])
        self.lab.soak("campaign", "abort", "--reason", "wrong serial numbers")
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.assertEqual(self.query("SELECT * FROM run"), [])
        self.assert_safe()

    @long_test
    def test_once_the_right_units_are_in_their_slots_the_campaign_goes_on(self):
        self.start_lab(units=2, cut=("unit1", "unit2"))
        wires = self.proxies["unit1"], self.proxies["unit2"]

        def swap():
            for wire in wires:
                wire.cut()
            wires[0].target, wires[1].target = wires[1].target, wires[0].target
            for wire in wires:
                wire.mend()
        swap()
        self.start_campaign(short_procedure(set_points=(20,)))
        self.wait("a question", lambda s: s["prompt"] and "belongs in slot" in s["prompt"]["text"])
        swap()
        self.lab.soak("campaign", "confirm")
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assertEqual({run for (run,) in self.query("SELECT DISTINCT unit FROM run")}, {"0380A001", "0380A002"})

    @long_test
    def test_a_unit_mounted_otherwise_than_stated_is_found_at_the_first_turn(self):
        self.start_lab(edit=lambda text: text.replace('axes = ["+X", "+Y", "+Z"]', 'axes = ["+X", "-Y", "-Z"]'))
        self.start_campaign(short_procedure())
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        for part in ("0380A001", "slot 1", "+Z"):
            self.assertIn(part, status["reason"])
        self.assert_safe()

    def expect_with_one_of_two_units_mounted_otherwise(self, preflight_s, state):
        def mount(text):
            changed = text.replace('axes = ["+Y", "-X", "+Z"]', 'axes = ["+Y", "+X", "-Z"]')
            self.assertNotEqual(changed, text)
            return changed
        self.start_lab(units=2, edit=mount)
        self.start_campaign(short_procedure(set_points=(20,), preflight_s=preflight_s))
        status = self.wait_for_end()
        self.assertEqual(status["state"], state)
        self.assertIn("0380A002", status["reason"])
        self.assertNotIn("0380A001", status["reason"])
        self.assert_safe()

    @long_test
    def test_one_of_two_units_that_reads_otherwise_is_left_out_of_a_run(self):
        self.expect_with_one_of_two_units_mounted_otherwise(0, "finished")

    @long_test
    def test_one_of_two_units_that_reads_otherwise_ends_the_pre_flight(self):
        self.expect_with_one_of_two_units_mounted_otherwise(10, "failed")

    def test_a_chamber_that_refuses_the_connection(self):
        self.start_lab(cut=["chamber"])
        self.proxies["chamber"].cut()
        message = self.refused(3, short_procedure())
        self.assertIn("127.0.0.1", message)

    def test_configurations_with_mistakes(self):
        self.start_lab(units=2)
        end(self.lab.soakd)
        text = self.config.read_text(encoding="utf-8")

        def refusal(wrong):
            self.config.write_text(wrong, encoding="utf-8")
            with self.assertRaises(ProgramFailed) as failed:
                self.lab.start_soakd()
            self.lab.soakd.stdout.close()
            self.assertIn("ended with status 2", str(failed.exception))
            return str(failed.exception)

        self.assertIn("0380A001", refusal(text.replace("0380A002", "0380A001")))
        maps = self.folder / "maps"
        shutil.copytree(pathlib.Path(ROOT) / "procedures", maps)
        broken = maps / "chambers" / "watlow-f4t.toml"
        lines = broken.read_text(encoding="utf-8").replace('type = "f32"', 'type = "f31"', 1)
        broken.write_text(lines, encoding="utf-8")
        line = next(i for i, l in enumerate(lines.splitlines(), 1) if "f31" in l)
        message = refusal(text.replace(str(pathlib.Path(ROOT) / "procedures"), str(maps)))
        self.assertIn(f"{broken}:{line}", message)
        self.assertIn("'quantity.air_c.type'", message)

    def test_a_configuration_that_is_named_and_missing_is_refused_with_how_to_get_one(self):
        missing = self.folder / "missing.toml"
        done = subprocess.run([bin_folder() + "/soakd", "--config", missing, "--data", self.folder], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn(str(missing), done.stderr)
        self.assertIn("'soakd --write-config'", done.stderr)

    def test_commands_that_need_the_station_say_that_it_is_not_set_up(self):
        done = subprocess.run([bin_folder() + "/soak", "chamber", "make-safe", "--data", self.folder], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn(str(self.folder / "station.toml"), done.stderr)
        self.assertIn("start soakd and open its page", done.stderr)


if __name__ == "__main__":
    bench.main()
