# SPDX-License-Identifier: Apache-2.0
"""The chamber of soaksim over its other wires, as other people's programs see them: mbpoll and pyserial on the terminal of
a Modbus RTU controller, a plain socket before one that speaks text."""
import os
import re
import select
import socket
import struct
import subprocess
import tomllib
import unittest

from pymodbus.utilities import computeCRC

from laboratory import PATIENCE_S, LaboratoryTest, Soaksim, read_register, wait_for, write_register

ON_F4T, OFF_F4T, MODE_F4T = 10, 62, 2730


class RtuTest(LaboratoryTest):
    def mbpoll(self, *words, status=0):
        command = ["mbpoll", "-m", "rtu", "-b", "19200", "-P", "none", "-a", "1", "-0", "-1", "-q", "-o", "10",
                   *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(done.returncode, status, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    def polled(self, address, *kind):
        text = self.mbpoll("-r", address, "-c", 1, "-t", *kind, self.lab.addresses["chamber_wire"])
        return float(re.search(rf"\[{address}\]:\s+(\S+)", text).group(1))

    def ask(self, frame, patience_s=PATIENCE_S):
        """The answer to a frame, which gets its check sum here; b"" where none comes."""
        frame += struct.pack(">H", computeCRC(frame))
        terminal = os.open(self.lab.addresses["chamber_wire"], os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(terminal, frame)
            answer = b""
            while select.select([terminal], [], [], patience_s if not answer else 0.3)[0]:
                answer += os.read(terminal, 300)
            return answer
        finally:
            os.close(terminal)


class EurothermTest(RtuTest):
    OPTIONS = ("--units", 1, "--rate", 50, "--chamber", "eurotherm-2400")
    FLOATS_HIGH_WORD_FIRST = ("4:float", "-B")

    def test_one_value_stands_in_both_areas(self):
        self.mbpoll("-r", 32772, "-t", "4:float", "-B", self.lab.addresses["chamber_wire"], "--", "-40.5")
        self.assertEqual(self.polled(32772, *self.FLOATS_HIGH_WORD_FIRST), -40.5)
        text = self.mbpoll("-r", 2, "-c", 1, "-t", "4", self.lab.addresses["chamber_wire"])
        self.assertIn("(-405)", text)
        self.assertAlmostEqual(self.polled(32770, *self.FLOATS_HIGH_WORD_FIRST), 23.0, delta=60.0)

    def test_the_instrument_mode_drives_the_chamber(self):
        wire = self.lab.addresses["chamber_wire"]
        self.mbpoll("-r", 32772, "-t", "4:float", "-B", wire, "--", "60")
        self.mbpoll("-r", 199, "-t", "4", wire, "--", "0")
        wait_for(lambda: self.polled(32774, *self.FLOATS_HIGH_WORD_FIRST) > 0.0, "it heats")
        self.assertEqual(read_register(self.lab.addresses["chamber"], MODE_F4T), ON_F4T, "the F4T's registers agree")
        self.mbpoll("-r", 199, "-t", "4", wire, "--", "1")
        self.assertEqual(self.polled(32774, *self.FLOATS_HIGH_WORD_FIRST), 0.0)
        self.assertEqual(read_register(self.lab.addresses["chamber"], MODE_F4T), OFF_F4T)

    def test_it_refuses_and_ignores_as_the_handbook_says(self):
        wire = self.lab.addresses["chamber_wire"]
        self.assertIn("Illegal data value", self.mbpoll("-r", 199, "-t", "4", wire, "--", "2", status=1))
        self.assertIn("Illegal data value",
                      self.mbpoll("-r", 32772, "-t", "4:float", "-B", wire, "--", "500", status=1))
        self.mbpoll("-r", 900, "-t", "4", wire, "--", "7")  # nothing is there: the write succeeds
        self.assertNotEqual(self.polled(900, "4"), 7)
        self.assertEqual(self.ask(bytes([1, 4, 0, 1, 0, 1]), patience_s=0.5), b"", "an unsupported function has no answer")
        self.assertEqual(self.ask(bytes([2, 3, 0, 1, 0, 1]), patience_s=0.5), b"", "that is another unit")

    def test_a_documented_request_is_answered(self):
        answer = self.ask(bytes.fromhex("010300010002"))
        self.assertEqual(answer[:3], bytes([1, 3, 4]))
        self.assertEqual(struct.unpack(">H", answer[-2:])[0], computeCRC(answer[:-2]))

    def test_damaged_frames_are_dropped(self):
        terminal = os.open(self.lab.addresses["chamber_wire"], os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(terminal, bytes.fromhex("0103000100029999"))
            self.assertFalse(select.select([terminal], [], [], 0.5)[0])
        finally:
            os.close(terminal)
        self.assertEqual(self.polled(199, "4"), 1.0, "and the next one is answered")


class F4tRtuTest(RtuTest):
    OPTIONS = ("--units", 1, "--rate", 50, "--chamber", "f4t-rtu")

    def test_it_has_the_registers_of_the_one_over_tcp(self):
        wire = self.lab.addresses["chamber_wire"]
        self.assertEqual(self.polled(14080, "4"), 15)
        self.mbpoll("-r", 2782, "-t", "4:float", wire, "--", "-40.25")
        self.assertEqual(self.polled(2782, "4:float"), -40.25)
        self.assertIn("Illegal data address", self.mbpoll("-r", 2000, "-c", 1, "-t", "4", wire, status=1))
        write_register(self.lab.addresses["chamber"], MODE_F4T, ON_F4T)
        self.assertEqual(self.polled(2814, "4"), ON_F4T)
        write_register(self.lab.addresses["chamber"], MODE_F4T, OFF_F4T)


class EspecTest(LaboratoryTest):
    OPTIONS = ("--units", 1, "--rate", 50, "--chamber", "espec-p300")

    def setUp(self):
        self.socket = socket.create_connection(("127.0.0.1", self.lab.addresses["chamber_wire"]), timeout=PATIENCE_S)
        self.addCleanup(self.socket.close)
        self.lines = self.socket.makefile("rb")
        self.addCleanup(self.lines.close)

    def say(self, text):
        self.socket.sendall(text.encode() + b"\r\n")
        line = self.lines.readline()
        self.assertTrue(line.endswith(b"\r\n"), line)
        return line[:-2].decode()

    def test_it_answers_with_four_temperatures(self):
        air, set_point, high, low = map(float, self.say("TEMP?").split(","))
        self.assertLess(abs(air - 23.0), 60.0)
        self.assertEqual((high, low), (180.0, -70.0))
        self.assertEqual(self.say(f"TEMP, S{set_point + 1:.1f}")[:3], "OK:")
        self.assertEqual(float(self.say("TEMP?").split(",")[1]), set_point + 1)

    def test_it_is_switched_on_and_off(self):
        self.assertEqual(self.say("MODE?"), "STANDBY")
        self.say("MODE,CONSTANT")
        self.assertEqual(self.say("MODE?"), "CONSTANT")
        self.assertEqual(read_register(self.lab.addresses["chamber"], MODE_F4T), ON_F4T, "the F4T's registers agree")
        self.say("MODE,STANDBY")
        self.assertEqual(read_register(self.lab.addresses["chamber"], MODE_F4T), OFF_F4T)
        self.assertEqual(self.say("ALARM?"), "0")
        self.assertEqual(len(self.say("MON?").split(",")), 4)

    def test_it_says_what_it_does_not_take(self):
        self.assertEqual(self.say("HELLO?"), "NA:CMD ERR")
        self.assertEqual(self.say("TEMP, Swarm"), "NA:PARA ERR")
        self.assertEqual(self.say("TEMP, S500.0"), "NA:DATA OUT OF RANGE")

    def test_a_line_may_come_in_pieces(self):
        for byte in b"MODE?\r":
            self.socket.sendall(bytes([byte]))
        self.socket.sendall(b"\nMODE?\r\n")
        self.assertEqual(self.lines.readline() + self.lines.readline(), b"STANDBY\r\nSTANDBY\r\n")


class StationFileTest(unittest.TestCase):
    def test_it_names_map_and_wire_of_each_kind(self):
        for kind, name, key in (("f4t", "watlow-f4t.toml", "port"), ("f4t-rtu", "watlow-f4t.toml", "device"),
                                ("eurotherm-2400", "eurotherm-2400.toml", "device"), ("espec-p300", "espec-p300.toml", "port")):
            with self.subTest(kind):
                lab = Soaksim("--units", 1, "--chamber", kind)
                self.addCleanup(lab.end)
                with (lab.folder / "station.toml").open("rb") as file:
                    section = tomllib.load(file)["chamber"]
                self.assertTrue(section["map"].endswith(name))
                self.assertEqual(section[key], lab.addresses["chamber_wire"])
                self.assertEqual(kind == "f4t", lab.addresses["chamber_wire"] == lab.addresses["chamber"])

    def test_another_kind_is_refused(self):
        done = subprocess.run([os.environ["SOAKSIM"], "--out", "/tmp", "--chamber", "oven"], capture_output=True, text=True,
                              check=False, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 2)
        self.assertIn("'oven'", done.stderr)


if __name__ == "__main__":
    unittest.main()
