# SPDX-License-Identifier: Apache-2.0
"""Positions that are missing at some temperatures: the scale factor is stated only where it was measured."""
import html
import json
import random
import unittest

from soak_cli import HEADER, SoakTest, check_schema

SERIAL = "SN1"
PLATEAUS = (-30, -15, 0, 15, 30, 45, 60)
UPS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}


def scale_ppm(temp_c):
    return -2000 + 15 * temp_c


def cold_without_x(seed, run):
    """Six positions of 30 s at each plateau, below 0 °C without +X and -X."""
    noise = random.Random(seed)
    lines, t = [HEADER], 0.0
    for plateau in PLATEAUS:
        for label, up in UPS.items():
            if plateau < 0 and label.endswith("X"):
                continue
            for _ in range(60):
                gyro = [noise.gauss(0, 0.01) for _ in range(3)]
                force = [9.80665 * (1 + 1e-6 * scale_ppm(plateau)) * u + noise.gauss(0, 0.002) for u in up]
                numbers = ",".join(f"{x:.6f}" for x in gyro + force)
                lines.append(f"{t:.1f},{run},soak,up,{plateau},{label},{plateau},{plateau + noise.gauss(0, 0.02):.3f},{numbers}")
                t += 0.5
    return "\n".join(lines) + "\n"


class ScaleRange(SoakTest):
    def setUp(self):
        super().setUp()
        for n in (1, 2, 3):
            self.imported(f"r{n}.csv", cold_without_x(n, f"r{n}"), "--gravity-mps2", "9.80665")
        self.fit = self.soak_json("fit", "fit", "--unit", SERIAL)

    def blob(self, *options):
        path = self.folder / "x.soakcal"
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "blob", "-o", path, *options)
        return path

    def test_fit_states_no_scale_where_none_was_measured_and_names_the_temperatures(self):
        sensor = self.fit["sensors"]["accel_x"]
        self.assertAlmostEqual(sensor["temp_min_c"], -30, delta=0.1)
        for point in sensor["curve"]:
            cold = point["temp_c"] < -0.1
            if cold:
                self.assertEqual((point["scale_ppm"], point["scale_ci95_ppm"]), (None, None), point)
            elif point["temp_c"] > 0.1:
                # what is stated holds: noise of a row is 2e-3/sqrt(60)/g, 26 ppm
                self.assertAlmostEqual(point["scale_ppm"], scale_ppm(point["temp_c"]), delta=80)
        warnings = {w["code"]: w["text"] for w in sensor["warnings"]}
        self.assertIn("-30, -15 °C", warnings["scale_range"])
        missing = [w["text"] for w in self.fit["warnings"] if w["code"] == "missing_position" and "accel_x" in w["text"]]
        self.assertRegex(" ".join(missing), r"\b2 of 7\b.*-30, -15 °C")
        for name in ("accel_y", "accel_z"):
            self.assertTrue(all(point["scale_ppm"] is not None for point in self.fit["sensors"][name]["curve"]))
            self.assertNotIn("scale_range", [w["code"] for w in self.fit["sensors"][name]["warnings"]])

    def test_eval_says_so_in_every_form_of_the_file(self):
        for options in ([], ["--table", "64"]):
            document = self.soak_json("eval", "eval", self.blob(*options), "--temp-c", "-30,-1,0.5,30,90",
                                      "--raw", "0,0,0,9.8,0,0")
            scale = [point["scale_ppm"]["accel_x"] for point in document["points"]]
            self.assertEqual([value is None for value in scale], [True, True, False, False, False])
            self.assertAlmostEqual(scale[3], scale_ppm(30), delta=80)
            self.assertTrue(all(point["scale_ppm"]["accel_y"] is not None for point in document["points"]))
            self.assertEqual([point["in_range"] for point in document["points"]], [True] * 4 + [False])
            self.assertEqual([point["corrected"]["status"] for point in document["points"]],
                             ["clamped", "clamped", "ok", "ok", "clamped"])
            self.assertEqual([point["corrected"]["flags"] >> 29 & 1 for point in document["points"]], [1, 1, 0, 0, 0])
            (warning,) = [w for w in document["warnings"] if w["code"] != "one_way"]  # heated only
            self.assertEqual(warning["code"], "scale_not_measured")
            self.assertIn("-30, -1 °C", warning["text"])

    def test_eval_for_people_has_no_number_there(self):
        done = self.soak("eval", self.blob(), "--temp-c", "-30,30")
        self.assertIn("warning: accel_x: ", done.stderr)
        rows = [line.split() for line in done.stdout.splitlines()[2:] if line.strip()]
        self.assertIn("–", " ".join(rows[0]))
        self.assertNotIn("–", " ".join(rows[-1]))

    def test_the_json_export_has_none_either(self):
        path = self.folder / "x.json"
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "json", "-o", path)
        document = json.loads(path.read_text())
        check_schema(document, "calibration")
        for point in document["sensors"]["accel_x"]["curve"]:
            if abs(point["temp_c"]) > 0.1:
                self.assertEqual(point["scale_ppm"] is None, point["temp_c"] < 0)

    def test_the_report_names_the_temperatures_too(self):
        path = self.folder / "x.html"
        summary = self.soak_json("report", "report", "--unit", SERIAL, "-o", path)["sections"]["summary"]
        (warning,) = [w for w in summary["warnings"] if w["code"] == "scale_range"]
        self.assertEqual(warning["sensors"], ["accel_x"])
        self.assertRegex(warning["text"], r"-30, -15 °C")
        self.assertIn(warning["text"], html.unescape(path.read_text(encoding="utf-8")))


if __name__ == "__main__":
    unittest.main()
