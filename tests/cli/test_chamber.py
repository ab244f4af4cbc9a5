# SPDX-License-Identifier: Apache-2.0
"""soak chamber check, probe: against pymodbus and against a peer that speaks text, with a wire between that notes every
request."""
import json
import re
import socket
import struct
import subprocess
import threading
import unittest

from soak_cli import ROOT, SoakTest, check_schema

CHAMBERS = ROOT / "procedures" / "chambers"
PEERS = ROOT / "tests" / "hal"
PYTHON = "/usr/bin/python3"
F4T = ["f32lo:2820:23.25", "f32lo:2782:25", "f32lo:2810:24.5", "f32lo:2808:-12.5", "f32lo:2774:-68", "f32lo:2776:150",
       "u16:2730:62", "u16:2814:62", "u16:2794:62", "u16:2796:39", "f32lo:2798:1", "u16:6730:15", "u16:90:138",
       "u16:11250:61", "u16:11264:138", "u16:11288:61", *(f"u16:{1356 + 100 * i}:61" for i in range(6))]


class Wire:
    """Hands bytes on to a server on this machine and keeps what the client sent."""

    def __init__(self, target):
        self.target = target
        self.swallow = 0  # so many requests do not reach the server
        self.sent = b""
        self.ended = []  # connections, to be closed with the wire
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        while True:
            try:
                client, _ = self.listener.accept()
                server = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                return
            threading.Thread(target=self.carry, args=(server, client, False), daemon=True).start()
            threading.Thread(target=self.carry, args=(client, server, True), daemon=True).start()

    def carry(self, source, sink, keep):
        try:
            while part := source.recv(4096):
                if keep:
                    self.sent += part
                    self.swallow -= 1
                if keep and self.swallow >= 0:
                    continue
                sink.sendall(part)
            sink.shutdown(socket.SHUT_WR)
        except OSError:
            pass
        if keep:
            self.ended.append((source, sink))

    def close(self):
        self.listener.close()
        for pair in self.ended:
            for end in pair:
                end.close()

    def function_codes(self):
        """Of all requests in Modbus TCP frames."""
        codes, rest = [], self.sent
        while len(rest) >= 8:
            codes.append(rest[7])
            rest = rest[6 + struct.unpack(">H", rest[4:6])[0]:]
        return codes


class ChamberTest(SoakTest):
    def peer(self, *command):
        """A peer that prints its port, and the wire to it."""
        process = subprocess.Popen([PYTHON, *map(str, command)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

        def end():
            process.stdin.close()
            process.wait(30)
            process.stdout.close()
        self.addCleanup(end)
        wire = Wire(int(process.stdout.readline().split()[1]))
        self.addCleanup(wire.close)
        return process, wire

    def pymodbus(self, *registers):
        try:
            return self.peer(PEERS / "pymodbus_server.py", "tcp", 0, *registers)[1]
        except IndexError:
            self.skipTest("python3-pymodbus is not installed")

    def probe(self, name, wire, status=0):
        done = self.soak("chamber", "probe", CHAMBERS / name, "--tcp", f"127.0.0.1:{wire.port}", "--json", status=status)
        document = json.loads(done.stdout)
        check_schema(document, "chamber-probe")
        return document


class Check(ChamberTest):
    def test_every_shipped_map_is_sound(self):
        for path in sorted(CHAMBERS.glob("*.toml")):
            document = self.soak_json("chamber-check", "chamber", "check", path)
            self.assertEqual(document["file"], str(path))
            self.assertTrue(document["probes"] and document["alarms"] and document["outputs_off"], path)
            # Set points are written to an EEPROM. Thermotron's is lost while the chamber stands: always written.
            sparing = path.name != "thermotron-8800.toml"
            self.assertEqual(document["write_policy"], {"only_on_change": sparing, "read_back": sparing}, path)

    def test_it_says_in_short_what_a_map_can_do(self):
        text = self.soak("chamber", "check", CHAMBERS / "watlow-f4t.toml").stdout
        for named in ("Watlow F4T", "Modbus", "tcp 127.0.0.1:502", "1 s", "-70 to 180 °C"):
            self.assertIn(named, text)
        text = self.soak("chamber", "check", CHAMBERS / "espec-p300.toml").stdout
        for named in ("ESPEC P300", "text", "tcp 127.0.0.1:10001"):
            self.assertIn(named, text)
        document = self.soak_json("chamber-check", "chamber", "check", CHAMBERS / "eurotherm-2200.toml")
        self.assertEqual((document["protocol"], document["can_ramp"], document["poll_s"]), ("modbus", False, 2))

    def test_every_mistake_is_named_with_its_line(self):
        for name, changes in (
                ("watlow-f4t.toml", {'type = "f32"': 'type = "f64"', "unit = 1": "unit = 300", "[write_policy]": "[polcy]"}),
                ("espec-p300.toml", {"fields = 4": "fields = 0", 'write = "MODE,{}"': 'write = "MODE"', "[[alarm]]": "[[alrm]]"})):
            text = (CHAMBERS / name).read_text(encoding="utf-8")
            lines = []
            for right, wrong in changes.items():
                at = text.index(right)
                lines.append(text[:at].count("\n") + 1)
                text = text[:at] + wrong + text[at + len(right):]
            path = self.write(name, text)
            message = self.refusal("chamber", "check", path)["message"]
            for line in lines:
                self.assertIn(f"{path}:{line}: ", message)

    def test_what_a_chamber_lacks_is_a_mistake(self):
        path = self.write("m.toml", 'name = "m"\nkind = "chamber"\n[link]\ntcp = "h"\n[quantity]\n')
        error = self.refusal("chamber", "check", path)
        self.assertEqual(error["where"], f"{path}:2")
        for name in ("air_c", "set_point_c", "control_mode"):
            self.assertIn(f"[quantity.{name}]", error["message"])

    def test_maps_of_fixtures_and_power_are_checked_alike(self):
        for kind in ("fixture", "power"):
            for path in sorted((ROOT / "procedures" / (kind + "s" * (kind == "fixture"))).glob("*.toml")):
                document = self.soak_json("chamber-check", "chamber", "check", path)
                self.assertEqual((document["kind"], document["min_set_point_c"]), (kind, None), path)
                self.assertTrue(document["probes"], path)
        path = self.write("p.toml", 'name = "p"\nkind = "power"\n[link]\ntcp = "h"\n[quantity]\n')
        self.refusal("chamber", "check", path)
        self.assertNotIn("set points", self.soak("chamber", "check", ROOT / "procedures/power/scpi-supply.toml").stdout)

    def test_a_syntax_error_has_its_line_and_a_missing_file_its_name(self):
        path = self.write("m.toml", 'name = "m"\nkind = = "chamber"\n')
        self.assertEqual(self.refusal("chamber", "check", path)["where"], f"{path}:2")
        self.assertEqual(self.refusal("chamber", "check", self.folder / "absent.toml")["where"], str(self.folder / "absent.toml"))


class Probe(ChamberTest):
    def test_it_reads_everything_and_writes_nothing(self):
        wire = self.pymodbus(*F4T)
        document = self.probe("watlow-f4t.toml", wire)
        self.assertTrue(document["sound"])
        self.assertEqual(document["address"], f"tcp 127.0.0.1:{wire.port}")
        values = {e["name"]: e["value"] for e in document["entries"] if e["kind"] == "quantity"}
        self.assertEqual((values["air_c"], values["set_point_c"], values["output_percent"]), (23.25, 25, -12.5))
        texts = {e["name"]: e["text"] for e in document["entries"]}
        self.assertEqual((texts["control_mode"], texts["ramp_scale"]), ("off", "per_hour"))
        alarms = [e for e in document["entries"] if e["kind"] == "alarm"]
        self.assertEqual(len(alarms), 9)
        self.assertFalse(any(e["active"] for e in alarms))
        codes = wire.function_codes()
        self.assertGreaterEqual(len(codes), len(document["entries"]))
        self.assertEqual(set(codes), {3}, "no request but reads reached the controller")

    def test_text_is_a_table(self):
        wire = self.pymodbus(*F4T)
        text = self.soak("chamber", "probe", CHAMBERS / "watlow-f4t.toml", "--tcp", f"127.0.0.1:{wire.port}").stdout
        self.assertTrue(text.startswith(f"Watlow F4T at 127.0.0.1:{wire.port}\n"))
        self.assertRegex(text, r"quantity +air_c +23\.25 +registers 2820 to 2821")
        self.assertRegex(text, r"alarm +limit tripped +not active \(61\) +register 11288")

    def test_what_is_wrong_does_not_keep_the_rest_from_being_read(self):
        registers = [r for r in F4T if not r.startswith("u16:11250")]  # no limit card: exception 2 here
        registers += ["u16:6730:30", "f32hi:2820:23.25", "u16:1456:37"]
        wire = self.pymodbus(*registers)
        document = self.probe("watlow-f4t.toml", wire, status=3)
        self.assertFalse(document["sound"])
        entries = {e["name"]: e for e in document["entries"]}
        self.assertRegex(entries["display units of Modbus TCP"]["trouble"], r"\b15\b")
        self.assertIsNotNone(entries["limit sensor error"]["trouble"])
        self.assertRegex(entries["air_c"]["trouble"], r"'word_order' .*\b23\.25\b")
        self.assertEqual(entries["set_point_c"]["value"], 25)
        self.assertTrue(entries["alarm 2"]["active"])
        self.assertIsNone(entries["alarm 2"]["trouble"], "an active alarm is read as well as one that is not")
        self.assertEqual(set(wire.function_codes()), {3})

    def test_it_probes_a_controller_that_speaks_text(self):
        process, wire = self.peer(PEERS / "espec_peer.py", 0)
        process.stdin.write("set alarm 3\n")
        process.stdin.flush()
        process.stdout.readline()
        document = self.probe("espec-p300.toml", wire)
        values = {e["name"]: e["value"] for e in document["entries"] if e["kind"] == "quantity"}
        self.assertEqual((values["air_c"], values["max_set_point_c"], values["min_set_point_c"]), (23.2, 150, -60))
        self.assertEqual([e["text"] for e in document["entries"] if e["kind"] == "alarm"], ["ACTIVE (1,3)"])
        self.assertEqual(set(wire.sent.decode().split("\r\n")), {"MODE?", "TEMP?", "ALARM?", ""}, "nothing but questions")

    def test_it_reads_a_supply(self):
        supply, wire = self.peer(PEERS / "scpi_supply.py", 0)
        supply.stdin.write("off 2\n")
        supply.stdin.flush()
        document = self.probe(ROOT / "procedures/power/scpi-supply.toml", wire)
        found = {entry["name"]: entry["value"] for entry in document["entries"] if entry["kind"] == "quantity"}
        self.assertTrue(document["sound"])
        self.assertEqual((found["output_2"], found["measured_a_1"], found["limit_a_3"]), (0, 0, 1))
        lines = [line.upper() for line in wire.sent.decode().splitlines()]
        self.assertTrue(all("?" in line for line in lines), lines)

    def spoilt(self, answers, status):
        process, wire = self.peer(PEERS / "espec_peer.py", 0)
        process.stdin.write(f"fault garbage {answers}\n")
        process.stdin.flush()
        process.stdout.readline()
        return self.probe("espec-p300.toml", wire, status=status)

    def test_a_spoilt_answer_is_asked_for_again(self):
        self.assertTrue(all(e["trouble"] is None for e in self.spoilt(1, status=0)["entries"]))

    def test_a_fault_in_mid_probe_is_got_over(self):
        document = self.spoilt(3, status=3)
        troubles = [e["trouble"] for e in document["entries"] if e["trouble"]]
        self.assertEqual(len(troubles), 1)
        self.assertEqual(len(document["entries"]), 7)

    def impatient(self, name):
        """A map of which a missing answer costs little beside the pause behind it."""
        text = re.sub("(?m)^response_timeout_s = .*", "response_timeout_s = 0.35", (CHAMBERS / name).read_text(encoding="utf-8"))
        return self.write(name, text)

    def test_what_comes_behind_two_questions_without_an_answer_is_read(self):
        """The second pause is longer than five time-outs: it must not count as time that the controller took."""
        wire = self.pymodbus(*F4T)
        wire.swallow = 2
        document = self.probe(self.impatient("watlow-f4t.toml"), wire, status=3)
        self.assertEqual([e["trouble"] is None for e in document["entries"]][:3], [False, False, True])
        self.assertTrue(all("Connection timed out" in e["trouble"] for e in document["entries"][:2]))
        self.assertTrue(all(e["trouble"] is None for e in document["entries"][2:]), document["entries"][2:])
        _, wire = self.peer(PEERS / "espec_peer.py", 0)
        wire.swallow = 2
        document = self.probe(self.impatient("espec-p300.toml"), wire, status=3)
        self.assertEqual([e["trouble"] for e in document["entries"]], ["no answer"] * 2 + [None] * 5)

    def test_where_three_questions_get_no_answer_no_more_are_asked(self):
        for name, peer in (("watlow-f4t.toml", lambda: self.pymodbus(*F4T)),
                           ("espec-p300.toml", lambda: self.peer(PEERS / "espec_peer.py", 0)[1])):
            wire = peer()
            wire.swallow = 1000
            error = self.refusal("chamber", "probe", self.impatient(name), "--tcp", f"127.0.0.1:{wire.port}", status=3)
            self.assertTrue(error["where"])
            self.assertEqual(wire.swallow, 997)

    def test_nobody_there_is_a_device_that_failed(self):
        for name in ("watlow-f4t.toml", "espec-p300.toml"):
            error = self.refusal("chamber", "probe", CHAMBERS / name, "--tcp", "127.0.0.1:1", status=3)
            self.assertTrue(error["where"].endswith("at 127.0.0.1:1"))
        self.refusal("chamber", "probe", CHAMBERS / "eurotherm-2400.toml", "--serial", "/dev/no-such-port", status=3)

    def test_addresses_that_make_no_sense_are_refused(self):
        f4t, espec = CHAMBERS / "watlow-f4t.toml", CHAMBERS / "espec-p300.toml"
        self.refusal("chamber", "probe", f4t, "--tcp", "host:0")
        self.refusal("chamber", "probe", f4t, "--tcp", "h", "--serial", "/dev/x")
        self.refusal("chamber", "probe", f4t, "--tcp", "h", "--baud", "9600")
        self.refusal("chamber", "probe", f4t, "--serial", "/dev/x", "--baud", "14400")
        self.assertEqual(self.refusal("chamber", "probe", espec, "--tcp", "h:1", "--unit", "3")["where"], "--unit")


if __name__ == "__main__":
    unittest.main()
