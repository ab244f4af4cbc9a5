# SPDX-License-Identifier: Apache-2.0
"""soak import --decoder: files of the bytes that a unit sent."""
import random
import struct
import unittest

from soak_cli import SoakTest


def mt_data2(counter, time_fine, gyro, accel, temp=None):
    """A packet after Xsens' low-level protocol: preamble, bus, MTData2, length, fields, check sum."""
    def field(identifier, data):
        return struct.pack(">HB", identifier, len(data)) + data
    body = field(0x1020, struct.pack(">H", counter % 65536)) + field(0x1060, struct.pack(">I", time_fine))
    body += field(0x4020, struct.pack(">3f", *accel)) + field(0x8020, struct.pack(">3f", *gyro))
    if temp is not None:
        body += field(0x0810, struct.pack(">f", temp))
    message = bytes([0xFF, 0x36, len(body)]) + body
    return b"\xFA" + message + bytes([-sum(message) % 256])


def stream(count, first=0, temp=True):
    """Packets at 100 Hz, a new temperature each tenth."""
    return b"".join(mt_data2(i, 100 * i, (0.001 * i, 0, -0.5), (0, 0.25, 9.75), 25 + i / 64 if temp and i % 10 == 0 else None)
                    for i in range(first, first + count))


def at_rest(count):
    noise = random.Random(7)
    return b"".join(mt_data2(i, 100 * i, [noise.gauss(0, 2e-3) for _ in range(3)],
                             [noise.gauss(g, 0.01) for g in (0, 0, 9.81)], noise.gauss(25, 0.01)) for i in range(count))


class ImportStream(SoakTest):
    def imported_stream(self, name, data, *options):
        return self.soak_json("import", "import", self.write(name, data), "--unit", "SN1", "--decoder", "xsens", *options)

    def rows(self, run):
        lines = self.soak("runs", "export", run["run_id"]).stdout.splitlines()
        return [dict(zip(lines[0].split(","), line.split(","))) for line in lines[1:]]

    def test_every_packet_becomes_a_row_with_the_units_own_numbers(self):
        document = self.imported_stream("log.mtb", stream(500))
        self.assertEqual((len(document["runs"]), document["runs"][0]["run"], document["runs"][0]["rows"]), (1, "log", 500))
        rows = self.rows(document["runs"][0])
        self.assertEqual([float(r["t_s"]) for r in rows], [i / 100 for i in range(500)])
        self.assertAlmostEqual(float(rows[200]["gx_dps"]), 0.2 * 57.29577951308232, places=5)
        self.assertEqual((float(rows[200]["ay_mps2"]), float(rows[200]["az_mps2"])), (0.25, 9.75))
        self.assertEqual([r["temp_c"] for r in rows[10:12]], ["25.15625", ""])
        self.assertEqual(int(rows[499]["packet"]), 499)

    def test_each_power_on_is_a_run(self):
        document = self.imported_stream("two.bin", stream(300) + stream(200))
        self.assertEqual([(r["run"], r["rows"]) for r in document["runs"]], [("two 1", 300), ("two 2", 200)])

    def test_losses_and_garbage_are_counted(self):
        document = self.imported_stream("holes.bin", stream(100) + b"\x00garbage" + stream(100, first=103))
        self.assertEqual([r["rows"] for r in document["runs"]], [200])
        first, second = [w for w in document["warnings"] if "holes.bin" in w]
        self.assertRegex(first, r"\b3\b.*\b203\b")
        self.assertRegex(second, r"\b8\b")

    def test_the_same_log_again_changes_nothing(self):
        self.imported_stream("log.bin", stream(100))
        before = self.state()
        self.assertEqual(self.imported_stream("log.bin", stream(100))["runs"][0]["status"], "unchanged")
        self.assertEqual(self.state(), before)

    def test_what_cannot_be_decoded_is_refused_and_leaves_nothing(self):
        path = self.write("log.bin", stream(100))
        for data, options, where in (
                (b"t_s,temp_c,gx_dps\n0,25,1\n", ["--decoder", "xsens"], str(path)),
                (stream(100), ["--decoder", "vectornav"], str(path)),
                (b"", ["--decoder", "xsens"], str(path)),
                (stream(100, temp=False), ["--decoder", "xsens"], str(path)),
                (stream(100), ["--decoder", "ahrs400"], "--decoder"),
                (stream(100), ["--decoder", "ahrs400", "--type", "generic"], "--type"),
                (stream(100), ["--decoder", "xsens", "--skip-bad"], "--decoder"),
                (stream(100), ["--rate-hz", "50"], "--rate-hz")):
            path.write_bytes(data)
            self.assertEqual(self.refusal("import", path, "--unit", "SN1", *options)["where"], where, options)
            self.assertFalse((self.data / "runs").exists())
        self.soak("import", path, "--unit", "SN1", "--decoder", "crossbow", status=2)
        self.refusal("import", self.folder, "--unit", "SN1", "--decoder", "xsens")
        self.refusal("import", self.folder / "absent", "--unit", "SN1", "--decoder", "xsens")

    def test_a_recording_at_rest_gives_an_allan_deviation(self):
        run = self.imported_stream("rest.bin", at_rest(6000))["runs"][0]
        document = self.soak_json("signal-allan", "signal", "allan", "--run", run["run_id"], "--column", "gyro_y")
        self.assertEqual(document["samples"], 6000)


if __name__ == "__main__":
    unittest.main()
