# SPDX-License-Identifier: Apache-2.0
"""soaksim and soaksim-truth as programs: options, files, ends."""
import json
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import tomllib
import unittest

from laboratory import PATIENCE_S, ROOT, Soaksim, read_register, truth


class ProgramsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def refused(self, *options, program="SOAKSIM", status=2):
        """What a program that cannot do its work says."""
        done = subprocess.run([os.environ[program], *map(str, options)], capture_output=True, text=True, check=False,
                              timeout=PATIENCE_S)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        return done.stderr

    def test_signals_end_it_with_status_0(self):
        for how in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(how=how):
                self.assertEqual(Soaksim("--units", 2, "--rate", "max").end(how), (0, ""))

    def test_it_ends_though_a_unit_is_not_read(self):
        lab = Soaksim("--units", 1, "--rate", "max")
        with lab.powered_unit(1) as unit:
            unit.measurements(1)
            self.assertEqual(lab.end(), (0, ""))

    def test_wrong_options_are_named(self):
        out = ("--out", self.folder / "lab")
        self.assertIn("--out", self.refused())
        self.assertIn("'--speed'", self.refused(*out, "--speed", 3))
        self.assertIn("--seed", self.refused(*out, "--seed"))
        self.assertIn("--seed", self.refused(*out, "--seed", 1, "--seed", 2))
        self.assertIn("'seven'", self.refused(*out, "--seed", "seven"))
        self.assertIn("'65'", self.refused(*out, "--units", 65))
        self.assertIn("20000", self.refused(*out, "--rate", 0))
        self.assertIn("'nan'", self.refused(*out, "--rate", "nan"))
        self.assertIn("'3'", self.refused(*out, "--units", 2, "--pty", 1, 3))
        self.assertIn("'70000'", self.refused(*out, "--base-port", 70000))
        self.assertIn("'hexapod'", self.refused(*out, "--fixture", "hexapod"))
        self.assertFalse((self.folder / "lab").exists(), "nothing is left behind")
        self.assertIn("'--out'", self.refused(*out, program="SOAKSIM_TRUTH"))
        self.assertIn("'0'", self.refused("--units", 0, program="SOAKSIM_TRUTH"))

    def test_wrong_magnitudes_are_named_with_their_line(self):
        text = (ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8")
        mistakes = {"leak_time_s = 7200.0": "leak_time_s = -1.0", 'mountings = ["+X+Y+Z"': 'mountings = ["+X+Z+Y"',
                    "quarter_turn_s = 5.0": "half_turn_s = 10.0\nquarter_turn_s = 5.0"}
        config = self.folder / "wrong.toml"
        for right, wrong in mistakes.items():
            with self.subTest(wrong=wrong):
                line = text[:text.index(right)].count("\n") + 1
                config.write_text(text.replace(right, wrong), encoding="utf-8")
                self.assertIn(f"{config}:{line}", self.refused("--out", self.folder / "lab", "--config", config))
        self.assertIn("absent.toml", self.refused("--out", self.folder, "--config", self.folder / "absent.toml"))

    def test_a_port_that_is_taken_is_named(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            self.assertIn(f"port {port} ", self.refused("--out", self.folder / "lab", "--base-port", port))

    def test_a_folder_that_cannot_be_made_is_named(self):
        (self.folder / "file").write_text("")
        self.assertIn("file/lab", self.refused("--out", self.folder / "file" / "lab"))

    def test_help_goes_to_standard_output(self):
        for program in ("SOAKSIM", "SOAKSIM_TRUTH"):
            done = subprocess.run([os.environ[program], "--help"], capture_output=True, text=True, check=True,
                                  timeout=PATIENCE_S)
            self.assertTrue(done.stdout.startswith("usage: " + os.path.basename(os.environ[program])))
            self.assertEqual(done.stderr, "")

    def test_station_file_says_how_to_reach_everything(self):
        lab = Soaksim("--units", 3, "--rate", 50, "--seed", 9, "--pty", 2)
        self.addCleanup(lab.end)
        path = lab.folder / "station.toml"
        self.assertEqual(lab.addresses["station"], str(path))
        with path.open("rb") as file:
            station = tomllib.load(file)
        self.assertEqual(station["clock"]["rate"], 50)
        for section, device in (("chamber", "chamber"), ("fixture", "fixture"), ("power", "relay")):
            self.assertEqual(station[section]["port"], lab.addresses[device])
            self.assertTrue(pathlib.Path(station[section]["map"]).is_file())
        self.assertTrue(pathlib.Path(station["unit_types"]["folder"], "mti-300.toml").is_file())
        slots = station["slot"]
        self.assertEqual([slot["name"] for slot in slots], ["1", "2", "3"])
        self.assertEqual([slot["power_output"] for slot in slots], [1, 2, 3])
        self.assertEqual([slot.get("port", slot.get("device")) for slot in slots], lab.addresses["units"])
        self.assertTrue(lab.addresses["units"][1].startswith("/dev/"))
        self.assertEqual(slots[0]["axes"], ["+X", "+Y", "+Z"])
        serials = [unit["unit"] for unit in json.loads(truth("--units", 3))["units"]]
        self.assertEqual([slot["unit"] for slot in slots], serials)

    def test_station_file_tells_the_latitude_of_a_laboratory_on_a_turning_earth(self):
        text = (ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8")
        config = self.folder / "turning.toml"
        turning = text.replace("[site]\n", "[site]\nlatitude_deg = -33.5\nazimuth_deg = 30.0\n")
        config.write_text(turning, encoding="utf-8")
        lab = Soaksim("--units", 1, "--config", config)
        self.addCleanup(lab.end)
        with (lab.folder / "station.toml").open("rb") as file:
            self.assertEqual(tomllib.load(file)["site"], {"gravity_mps2": 9.80665, "latitude_deg": -33.5})
        two_axis = Soaksim("--units", 1, "--config", config, "--fixture", "two-axis")
        self.addCleanup(two_axis.end)
        with (two_axis.folder / "station.toml").open("rb") as file:
            station = tomllib.load(file)
        self.assertEqual(station["site"]["azimuth_deg"], 30.0)
        self.assertTrue(station["fixture"]["map"].endswith("fixtures/two-axis.toml"))

    def test_base_port_names_all_ports(self):
        for base in range(21000, 29000, 100):  # the first place where all are free
            try:
                lab = Soaksim("--units", 2, "--base-port", base)
                break
            except AssertionError as error:
                self.assertRegex(str(error), rf"\b{base // 100}\d\d\b")
        self.addCleanup(lab.end)
        addresses = lab.addresses
        self.assertEqual((addresses["chamber"], addresses["fixture"], addresses["relay"]), (base, base + 1, base + 2))
        self.assertEqual(addresses["units"], [base + 11, base + 12])
        self.assertEqual(read_register(base, 6730), 15)

    def test_truth_is_that_of_the_seed(self):
        text = truth("--seed", 5, "--units", 2)
        self.assertEqual(truth("--seed", 5, "--units", 2), text)
        self.assertNotEqual(truth("--seed", 6, "--units", 2), text)
        document = json.loads(text)
        self.assertEqual(document["seed"], 5)
        self.assertEqual(document["units"][0], json.loads(truth("--seed", 5, "--units", 1))["units"][0],
                         "a unit does not depend on the others")

    def test_truth_has_the_size_that_was_asked_for(self):
        document = json.loads(truth("--seed", 5, "--units", 16))
        self.assertEqual((document["temp_c"][0], document["temp_c"][-1]), (-30.0, 70.0))
        offsets = []
        for unit in document["units"]:
            for name, sensor in unit["sensors"].items():
                self.assertEqual(len(sensor["bias"]), len(document["temp_c"]))
                self.assertEqual(len(sensor["power_on_offset"]), len(document["runs"]))
                span = max(sensor["bias"]) - min(sensor["bias"])
                self.assertAlmostEqual(span, sensor["uncompensated_span"], places=5)
                low, high = (0.42, 0.58) if name.startswith("gyro") else (0.25, 0.35)
                self.assertTrue(low - 1e-6 <= span <= high + 1e-6, (name, span))
                if name.startswith("gyro"):
                    offsets += sensor["power_on_offset"]
        # 16 × 3 × 64 draws of sigma 0.02: known to 1.3 %.
        sigma = (sum(x * x for x in offsets) / len(offsets)) ** 0.5
        self.assertAlmostEqual(sigma, 0.02, delta=0.05 * 0.02)


if __name__ == "__main__":
    unittest.main()
