# SPDX-License-Identifier: Apache-2.0
"""soak signal allan, psd, acf, wmra on CSV files and stored runs, against plain formulas and other programs' numbers."""
import csv
import json
import math
import pathlib
import random
import signal
import subprocess
import unittest

from soak_cli import ROOT, SoakTest, long_test, recording, shared_data

VECTORS = ROOT / "tests" / "data" / "vectors"


def plain_oadev(rate, multiple):
    """Overlapping Allan deviation from its definition: differences of neighbouring means."""
    sums = [0.0]
    for y in rate:
        sums.append(sums[-1] + y)
    terms = [(sums[i + 2 * multiple] - 2 * sums[i + multiple] + sums[i]) / multiple for i in range(len(rate) - 2 * multiple + 1)]
    return math.sqrt(sum(t * t for t in terms) / (2 * len(terms)))


class Signal(SoakTest):
    def csv_of(self, values, rate_hz=None, column="gx_dps", name="x.csv"):
        if rate_hz is None:
            return self.write(name, column + "\n" + "\n".join(f"{v:.17g}" for v in values) + "\n")
        lines = [f"{i / rate_hz:.6f},{v:.17g}" for i, v in enumerate(values)]
        return self.write(name, f"t_s,{column}\n" + "\n".join(lines) + "\n")

    def refused(self, *arguments):
        return self.refusal("signal", *arguments)


class Allan(Signal):
    def setUp(self):
        super().setUp()
        noise = random.Random(5)
        self.white = [noise.gauss(3.0, 0.5) for _ in range(4000)]

    def test_deviations_are_those_of_the_definition(self):
        path = self.csv_of(self.white)
        document = self.soak_json("signal-allan", "signal", "allan", path, "--column", "gx_dps", "--rate-hz", "100",
                                  "--taus", "0.01,0.1,1,10")
        self.assertEqual(document["tau_s"], [0.01, 0.1, 1.0, 10.0])
        for multiple, value in zip((1, 10, 100, 1000), document["oadev"]):
            self.assertAlmostEqual(value / plain_oadev(self.white, multiple), 1.0, places=10)
        for key in ("adev", "oadev", "mdev", "ci95", "fitted"):
            self.assertEqual(len(document[key]), 4, key)

    def test_white_noise_has_its_random_walk_coefficient_and_no_other(self):
        path = self.csv_of(self.white, rate_hz=100)
        document = self.soak_json("signal-allan", "signal", "allan", path, "--column", "gx_dps")
        walk = document["coefficients"]["angle_random_walk"]
        self.assertTrue(walk["found"])
        self.assertEqual(walk["unit"], "deg/s/sqrt(Hz)")
        # sigma/sqrt(rate) = 0.05; 4000 samples know their standard deviation to 1.1 %: 5 sigma.
        self.assertAlmostEqual(walk["value"], 0.05, delta=0.05 * 0.056)
        self.assertLess(walk["ci95"][0], walk["value"])
        self.assertLess(walk["value"], walk["ci95"][1])
        self.assertFalse(document["coefficients"]["rate_ramp"]["found"])
        for (low, high), oadev in zip(document["ci95"], document["oadev"]):
            self.assertTrue(low < oadev < high)
        self.assertIn("deg/sqrt(h)", self.soak("signal", "allan", path, "--column", "gx_dps").stdout)

    def test_phase_is_the_integral_of_the_rate(self):
        phase = [0.0]
        for y in self.white:
            phase.append(phase[-1] + y / 100)
        of_phase = self.soak_json("signal-allan", "signal", "allan", self.csv_of(phase, name="p.csv", column="angle"),
                                  "--column", "angle", "--rate-hz", "100", "--phase")
        of_rate = self.soak_json("signal-allan", "signal", "allan", self.csv_of(self.white, column="y"), "--column", "y",
                                 "--rate-hz", "100")
        for a, b in zip(of_phase["oadev"], of_rate["oadev"]):
            self.assertAlmostEqual(a / b, 1.0, places=6)

    def test_the_nist_set_has_its_printed_deviations(self):
        expected = json.loads((VECTORS / "nist_sp1065_1000.json").read_text(encoding="utf-8"))
        with open(VECTORS / "nist_sp1065_1000.csv", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        column = rows[0][-1]
        document = self.soak_json("signal-allan", "signal", "allan", VECTORS / "nist_sp1065_1000.csv", "--column", column,
                                  "--rate-hz", "1", "--taus", "1,10,100")
        for kind in ("adev", "oadev", "mdev"):
            for i, tau in enumerate(("1", "10", "100")):
                self.assertAlmostEqual(document[kind][i], expected[kind][tau], places=12)

    def test_phase_dat_matches_stable32(self):
        folder = shared_data("allan_stable32")
        if folder is None:
            self.skipTest("the recordings are absent")
        points = [float(line) for line in (folder / "phasedat" / "PHASE.DAT").read_text().split("\n") if line.strip() and line.strip()[0] != "#"]
        path = self.csv_of(points, column="phase")
        document = self.soak_json("signal-allan", "signal", "allan", path, "--column", "phase", "--rate-hz", "1", "--phase",
                                  "--taus", "1,2,4,8,16,32,64,128,256")
        rows = [line.split() for line in (folder / "phasedat" / "phase_dat_oadev_octave.txt").read_text().split("\n")]
        printed = {int(float(r[1])): r[5] for r in rows if len(r) == 7 and r[0].isdigit()}
        compared = 0
        for tau, value in zip(document["tau_s"], document["oadev"]):
            if int(tau) in printed:
                self.assertEqual(f"{value:.4e}", f"{float(printed[int(tau)]):.4e}")
                compared += 1
        self.assertGreaterEqual(compared, 7)

    def test_lacking_rows_and_empty_cells_are_gaps(self):
        lines = [f"{i / 100:.2f},{v:.9g}" for i, v in enumerate(self.white)]
        del lines[2000:2500]
        lines[100] = "1.00,"
        path = self.write("gaps.csv", "t_s,gx_dps\n" + "\n".join(lines) + "\n")
        document = self.soak_json("signal-allan", "signal", "allan", path, "--column", "gx_dps")
        self.assertEqual((document["samples"], document["missing"], document["bridged"], document["gaps"]), (3499, 501, 1, 1))

    def test_a_stored_run_is_taken_segment_by_segment(self):
        self.imported("r.csv", recording(seconds=60))
        whole = self.soak_json("signal-allan", "signal", "allan", "--run", "r1", "--column", "accel_x")
        # Twelve segments in positions 20 m/s2 apart: only noise is left, 0.005 m/s2 at 2 Hz (1440 samples: 5 sigma = 9 %).
        self.assertAlmostEqual(whole["oadev"][0], 0.005, delta=0.0005)
        self.assertEqual((whole["column"], whole["unit"], whole["samples"]), ("accel_x", "m/s2", 1440))
        part = self.soak_json("signal-allan", "signal", "allan", "--run", "r1", "--column", "ax_mps2", "--visit", "1",
                              "--position", "-X")
        self.assertEqual(part["samples"], 120)

    def test_refusals_name_what_would_be_right(self):
        path = self.csv_of(self.white)
        for arguments, named in (((path, "--column", "gy_dps", "--rate-hz", "100"), "gx_dps"),
                                 ((path, "--column", "gx_dps"), "--rate-hz"),
                                 ((path, "--column", "gx_dps", "--rate-hz", "100", "--taus", "1,x"), "--taus"),
                                 ((path, "--column", "gx_dps", "--rate-hz", "100", "--taus", "1000"), ""),
                                 (("--column", "gx_dps"), "--run"), ((path, "--run", "r1", "--column", "gx_dps"), "--run")):
            error = self.refused("allan", *arguments)
            self.assertIn(named, error["message"] + error["where"], arguments)
        error = self.refused("allan", self.write("bad.csv", "t_s,gx_dps\n0,1\n0.01,nan\n"), "--column", "gx_dps")
        self.assertIn("line 3, column 'gx_dps'", error["where"])
        error = self.refused("allan", self.write("fall.csv", "t_s,gx_dps\n0,1\n0,2\n"), "--column", "gx_dps")
        self.assertIn("line 3, column 't_s'", error["where"])
        timed = self.csv_of(self.white, rate_hz=50, name="timed.csv")
        self.refused("allan", self.write("h.csv", "t_s,gx_dps\n"), "--column", "gx_dps")
        self.refused("allan", self.write("d.csv", "gx_dps,gx_dps\n1,2\n"), "--column", "gx_dps", "--rate-hz", "1")
        self.refused("allan", self.write("b.csv", "gx_dps\n1e200\n"), "--column", "gx_dps", "--rate-hz", "1")
        half = [f"{i * 0.01 if i < 2000 else 20 + (i - 2000) * 0.02:.2f},{v}" for i, v in enumerate(self.white)]
        self.refused("allan", self.write("c.csv", "t_s,y\n" + "\n".join(half) + "\n"), "--column", "y")
        self.refused("allan", timed, "--column", "gx_dps", "--rate-hz", "100")


    def test_jitter_and_lost_rows_leave_rate_and_coefficient_right(self):
        noise = random.Random(6)
        lines = []
        for i, v in enumerate(self.white):
            if noise.random() < 0.002:
                continue
            lines.append(f"{(i + noise.uniform(-0.35, 0.35)) / 100:.6f},{v:.9g}")
        done = self.soak("signal", "allan", self.write("j.csv", "t_s,rate_dps\n" + "\n".join(lines) + "\n"), "--column", "rate_dps", "--json")
        document = json.loads(done.stdout)
        self.assertAlmostEqual(document["rate_hz"], 100.0, delta=0.02)
        self.assertEqual(document["samples"] + document["missing"], 4000)
        self.assertEqual(document["unit"], "deg/s")
        self.assertIn("scatter", done.stderr)
        self.assertAlmostEqual(document["coefficients"]["angle_random_walk"]["value"], 0.05, delta=0.05 * 0.056)

    def test_an_empty_line_of_a_single_column_is_a_missing_sample(self):
        path = self.write("one.csv", "gx_dps\n" + "\n".join("" if i % 100 == 50 else f"{v:.9g}" for i, v in enumerate(self.white)) + "\n\n")
        document = self.soak_json("signal-allan", "signal", "allan", path, "--column", "gx_dps", "--rate-hz", "100")
        self.assertEqual((document["samples"], document["missing"]), (3960, 40))

    @long_test
    def test_segments_that_the_gate_rejected_are_left_out(self):
        text = recording(seconds=60)
        lines = text.split("\n")
        first = next(i for i, line in enumerate(lines) if ",+Y," in line)
        for i in range(first + 60, first + 120):  # the second half of one segment, turned by 17 degrees
            cells = lines[i].split(",")
            cells[11:13] = f"{float(cells[11]) + 2.9:.6f}", f"{float(cells[12]) - 0.4:.6f}"
            lines[i] = ",".join(cells)
        self.imported("m.csv", "\n".join(lines))
        done = self.soak("signal", "allan", "--run", "r1", "--column", "accel_y", "--json")
        self.assertEqual(json.loads(done.stdout)["samples"], 1320)
        self.assertRegex(done.stderr, r"(?m)^soak: accel_y: .*'soak runs show'")

    @long_test
    def test_an_interrupt_ends_it_without_output(self):
        path = self.csv_of(self.white * 100, rate_hz=100)
        process = subprocess.Popen(self.command("signal", "wmra", path, "--column", "gx_dps", "-o", self.folder / "o.csv"),
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while pathlib.Path(f"/proc/{process.pid}/status").read_text().split("SigCgt:")[1].split()[0][-1] not in "2367abef":
            self.assertIsNone(process.poll(), "it ended before it could be interrupted")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual((process.returncode, out), (1, ""))
        self.assertIn("interrupted", err)
        self.assertFalse((self.folder / "o.csv").exists())


class Spectrum(Signal):
    def test_density_of_noise_integrates_to_its_variance(self):
        noise = random.Random(7)
        values = [noise.gauss(0.0, 2.0) for _ in range(20000)]
        document = self.soak_json("signal-psd", "signal", "psd", self.csv_of(values, rate_hz=200, column="ax_mps2"), "--column", "ax_mps2")
        self.assertEqual(document["psd_unit"], "(m/s2)^2/Hz")
        # Variance 4, known to 1 % from 20000 samples: 5 sigma. Taking off each section's mean costs less than 1/section.
        self.assertAlmostEqual(document["variance"], 4.0, delta=0.21)
        self.assertAlmostEqual(document["frequency_hz"][-1], 100.0)

    def test_a_line_stands_at_its_frequency_before_and_not_after_denoising(self):
        noise = random.Random(8)
        values = [0.3 * math.sin(2 * math.pi * 40 * i / 200) + noise.gauss(0.0, 0.1) for i in range(16384)]
        path = self.csv_of(values, rate_hz=200)
        document = self.soak_json("signal-psd", "signal", "psd", path, "--column", "gx_dps", "--section", "1024", "--level", "6")
        line = document["lines"][0]
        self.assertAlmostEqual(line["frequency_hz"], 40.0, delta=0.1)
        self.assertAlmostEqual(line["amplitude"], 0.3, delta=0.015)
        peak = max(range(len(document["psd"])), key=document["psd"].__getitem__)
        self.assertAlmostEqual(document["frequency_hz"][peak], 40.0, delta=200 / 1024)
        self.assertIsNotNone(document["after_wmra"])
        self.assertLess(document["after_wmra"]["variance"], document["variance"])
        text = self.soak("signal", "psd", path, "--column", "gx_dps", "--level", "6").stdout
        self.assertIn("WMRA", text)
        self.assertRegex(text, r"\b40\.?\d* Hz")


class Correlation(Signal):
    def test_a_first_order_process_shows_its_correlation_time(self):
        noise = random.Random(9)
        rate_hz, time_s = 50.0, 2.0
        keep = math.exp(-1 / (rate_hz * time_s))
        x, values = 0.0, []
        for _ in range(100000):
            x = keep * x + math.sqrt(1 - keep * keep) * noise.gauss(0, 1)
            values.append(x)
        path = self.csv_of(values, rate_hz=rate_hz, column="y")
        document = self.soak_json("signal-acf", "signal", "acf", path, "--column", "y", "--max-lag-s", "20")
        # 2000 s are 500 independent pieces of 2 T: the time is known to about 1/sqrt(500) = 4.5 %; four of these.
        self.assertAlmostEqual(document["correlation_time_s"], 2.0, delta=0.36)
        self.assertAlmostEqual(document["gauss_markov_1"]["correlation_s"], 2.0, delta=0.36)
        self.assertEqual(document["acf"][0], 1.0)
        text = self.soak("signal", "acf", path, "--column", "y", "--level", "4").stdout
        self.assertIn("Gauss-Markov", text)
        self.assertIn("WMRA", text)


class Wmra(Signal):
    def test_split_of_the_reference_signal_is_that_of_pywavelets(self):
        expected = json.loads((VECTORS / "wmra_db8.json").read_text(encoding="utf-8"))
        out = self.folder / "out.csv"
        for mode in ("symmetric", "periodization"):
            reference = expected[mode]
            for rule in ("soft", "hard"):
                self.soak_json("signal-wmra", "signal", "wmra", VECTORS / "wmra_signal.csv", "--column", "x", "--wavelet", "db8",
                               "--level", reference["level"], "--mode", mode, "--threshold", rule, "-o", out)
                with open(out, encoding="utf-8") as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual(list(rows[0]), ["t_s", "raw", "denoised", "trend"])
                for key, column in ((rule, "denoised"), ("trend", "trend")):
                    numbers = next(v for k, v in reference.items() if k.startswith(key) and isinstance(v, list))
                    for row, number in zip(rows, numbers):
                        self.assertAlmostEqual(float(row[column]), number, places=10)

    @long_test
    def test_a_run_is_split_stretch_by_stretch(self):
        self.imported("r.csv", recording(seconds=60))
        out = self.folder / "out.csv"
        document = self.soak_json("signal-wmra", "signal", "wmra", "--run", "r1", "--column", "gyro_x", "--level", "3", "-o", out)
        self.assertEqual((document["stretches"], document["samples"]), (12, 1440))
        self.assertEqual(len(out.read_text(encoding="utf-8").splitlines()), 1441)

    def test_refusals(self):
        path = self.csv_of([0.0] * 64)
        for arguments, words in ((("--wavelet", "db99"), "db10"), (("--level", "99"), "--level"), (("--mode", "zero"), "--mode"),
                                 (("--relaxation", "1,-1"), "--relaxation"), ((), "--output")):
            out = () if words == "--output" else ("-o", self.folder / "o.csv")
            error = self.refused("wmra", path, "--column", "gx_dps", "--rate-hz", "1", *arguments, *out)
            self.assertIn(words, error["message"] + error["where"], arguments)
        self.assertFalse((self.folder / "o.csv").exists())

    def test_the_file_that_is_read_is_never_written_over(self):
        path = self.csv_of([float(i % 7) for i in range(64)])
        before = path.read_bytes()
        error = self.refused("wmra", path, "--column", "gx_dps", "--rate-hz", "1", "-o", path)
        self.assertEqual(error["where"], str(path))
        self.assertEqual(path.read_bytes(), before)

    def test_too_deep_a_level_is_told(self):
        path = self.csv_of([float(i % 7) for i in range(64)])
        done = self.soak("signal", "wmra", path, "--column", "gx_dps", "--rate-hz", "1", "--level", "20", "-o", self.folder / "o.csv")
        self.assertRegex(done.stderr, r"level 20: .*\b2\b.* db8")


if __name__ == "__main__":
    unittest.main()
