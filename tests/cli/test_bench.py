# SPDX-License-Identifier: Apache-2.0
"""Calibration on a bench: sessions at one temperature, from the CSV to the corrected sample."""
import math
import unittest

import hand_session as truth
from soak_cli import SoakTest, shared_data

SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def values_of(fit, key):
    return {name: sensor["curve"][0][key] for name, sensor in fit["sensors"].items()}


class Bench(SoakTest):
    def bring_in(self, text, name="session.csv", *options):
        self.write(name, text)
        return self.soak("import", self.folder / name, "--unit", "SN1", "--gravity-mps2", truth.GRAVITY, *options)

    def check_constants(self, fit):
        for axis in range(3):
            accel, gyro = fit["sensors"][SENSORS[3 + axis]], fit["sensors"][SENSORS[axis]]
            for sensor, bias, gain in ((accel, truth.ACCEL_BIAS[axis], truth.ACCEL_GAIN[axis][axis]),
                                       (gyro, truth.GYRO_BIAS_DPS[axis], truth.GYRO_GAIN[axis][axis])):
                self.assertEqual(sensor["deployed"], "constant")
                point = sensor["curve"][0]
                self.assertLess(abs(point["bias"] - bias), 2 * point["ci95"])
                self.assertLess(abs(point["scale_ppm"] - 1e6 * (gain - 1)), 2 * point["scale_ci95_ppm"])
                self.assertLess(point["scale_ci95_ppm"], 3000)

    def test_attitudes_without_a_label_from_the_file_to_the_corrected_sample(self):
        self.bring_in(truth.attitudes())
        shown = self.soak_json("runs-show", "runs", "show", "session", "--unit", "SN1")
        self.assertEqual(len(shown["segments"]), 22)
        self.assertEqual(shown["segments"][6]["position"], "rest 7")
        fit = self.soak_json("fit", "fit", "--unit", "SN1")
        self.check_constants(fit)
        for key, gain in (("accel_misalignment_rad", truth.ACCEL_GAIN), ("gyro_misalignment_rad", truth.GYRO_GAIN)):
            for i in range(3):
                for j in range(3):
                    if i != j:
                        error = abs(fit[key]["value"][i][j] - gain[i][j])
                        self.assertLessEqual(error, 2 * fit[key]["ci95"][i][j] + 1e-12, (key, i, j))
        self.assertIn("one_temperature", [w["code"] for w in fit["sensors"]["gyro_x"]["warnings"]])
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", self.folder / "c.soakcal")
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "c", "-o", self.folder / "c.h")
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "json", "-o", self.folder / "c.json")
        force, rate = (1.0, -3.0, 9.0), (40.0, -25.0, 70.0)
        raw = [g + b for g, b in zip(truth.times(truth.GYRO_GAIN, rate), truth.GYRO_BIAS_DPS)]
        raw += [f + b for f, b in zip(truth.times(truth.ACCEL_GAIN, force), truth.ACCEL_BIAS)]
        read = self.soak_json("eval", "eval", self.folder / "c.soakcal", "--temp-c", "24,40", "--raw",
                              ",".join(f"{x:.6f}" for x in raw))
        self.assertEqual([point["in_range"] for point in read["points"]], [True, False])
        corrected = read["points"][0]["corrected"]["out"]
        for name, expected in zip(SENSORS, (*rate, *force)):
            self.assertLess(abs(corrected[name] - expected), 0.2 if name[0] == "g" else 0.01)
        self.bring_in(truth.attitudes(seed=9), "check.csv", "--campaign", "check", "--procedure", "verification")
        limits = self.write("limits.toml", "[limits]\ngyro = 0.2\naccel = 0.05\naccel_scale_ppm = 3000\ngyro_scale_ppm = 8000\n")
        verified = self.soak_json("verify", "verify", self.folder / "c.soakcal", "--campaign", "check", "--limits", limits)
        self.assertEqual(verified["verdict"], "pass")
        self.assertIsNotNone(verified["sensors"]["gyro_z"]["scale"])
        self.soak("report", "--unit", "SN1", "-o", self.folder / "r.html")
        self.soak_json("report", "report", "--unit", "SN1", "-o", self.folder / "r2.html")

    def test_named_faces_with_whole_turns(self):
        self.bring_in(truth.ferraris())
        fit = self.soak_json("fit", "fit", "--unit", "SN1")
        self.check_constants(fit)

    def test_the_angle_of_all_turns_as_a_constant_of_the_columns_map(self):
        self.write("map.toml", '[constants]\nturn_deg = "360"\n')
        self.bring_in(truth.ferraris(turns=False), "s.csv", "--columns", self.folder / "map.toml")
        fit = self.soak_json("fit", "fit", "--unit", "SN1")
        self.assertNotIn("turns_without_angle", [w["code"] for w in fit["warnings"]])
        self.check_constants(fit)

    def test_turns_without_an_angle_are_told_of(self):
        self.bring_in(truth.ferraris(turns=False))
        fit = self.soak_json("fit", "fit", "--unit", "SN1")
        self.assertIn("turns_without_angle", [w["code"] for w in fit["warnings"]])

    def test_the_type_says_how_far_the_constants_hold(self):
        folder = self.folder / "procedures" / "units"
        folder.mkdir(parents=True)
        (folder / "mine.toml").write_text('name = "mine"\n[constants]\nwithin_c = 8\n[gyro]\nbias_per_k_dps = 0.05\n',
                                          encoding="utf-8")
        import os
        environment = {**os.environ, "SOAK_PROCEDURES": str(self.folder / "procedures")}
        self.write("s.csv", truth.attitudes())
        self.soak("import", self.folder / "s.csv", "--unit", "SN1", "--type", "mine", "--gravity-mps2", truth.GRAVITY,
                  env=environment)
        fit = self.soak_json("fit", "fit", "--unit", "SN1", env=environment)
        sensor = fit["sensors"]["gyro_x"]
        self.assertAlmostEqual(sensor["temp_max_c"] - sensor["temp_min_c"], 16, delta=0.5)
        self.assertGreater(sensor["curve"][0]["ci95"], 0.05 * 8 / math.sqrt(3))

    def test_a_rest_that_was_disturbed_is_left_out(self):
        self.bring_in(truth.attitudes())
        self.soak("runs", "void", "session", "--unit", "SN1", "--visit", 0, "--position", "rest 7", "--reason", "table moved")
        self.check_constants(self.soak_json("fit", "fit", "--unit", "SN1"))

    def test_too_few_attitudes_are_refused(self):
        self.bring_in(truth.attitudes(count=5))
        self.assertRegex(self.refusal("fit", "--unit", "SN1")["message"], r"\b5\b")

    def test_no_standstill_is_refused(self):
        session = truth.Session()
        for _ in range(15):
            session.turn(session.up(), 2.0, 2.0)
            session.tilt_to([session.noise.gauss(0, 1) for _ in range(3)])
        self.bring_in(session.csv())
        self.soak("fit", "--unit", "SN1", status=2)

    def test_an_angle_that_is_no_number_is_a_bad_row(self):
        self.write("s.csv", truth.ferraris().replace(",360", ",once"))
        self.soak("import", self.folder / "s.csv", "--unit", "SN1", status=2)

    def test_the_recording_of_a_real_unit(self):
        data = shared_data("multi_position_xsens")
        if data is None:
            self.skipTest("skipped: the Xsens recording is not here")
        rows = ["t,ax,ay,az,gx,gy,gz"]
        with open(data / "xsens_acc.mat", encoding="utf-8") as accels, open(data / "xsens_gyro.mat", encoding="utf-8") as gyros:
            for accel, gyro in zip(accels, gyros):
                rows.append(",".join((*accel.split(), *gyro.split()[1:])))
        self.write("xsens.csv", "\n".join(rows) + "\n")
        counts = "".join(f'"a{x}" = {{ as = "a{x}_mps2", scale = {1 / 415!r}, offset = {-32768 / 415!r} }}\n'
                         f'"g{x}" = {{ as = "g{x}_rps", scale = {1 / 4778!r}, offset = {-32768 / 4778!r} }}\n' for x in "xyz")
        self.write("map.toml", f'[columns]\n"t" = "t_s"\n{counts}[constants]\ntemp_c = "25"\n')
        self.soak("import", self.folder / "xsens.csv", "--unit", "MTi", "--columns", self.folder / "map.toml",
                  "--gravity-mps2", 9.81744)
        fit = self.soak_json("fit", "fit", "--unit", "MTi")
        factory = {"accel_x": 415, "accel_y": 413, "accel_z": 415, "gyro_x": 4778, "gyro_y": 4758, "gyro_z": 4766}
        nominal = {"a": 415, "g": 4778}
        for name, scale in factory.items():
            found = nominal[name[0]] * (1 + 1e-6 * fit["sensors"][name]["curve"][0]["scale_ppm"])
            self.assertLess(abs(found / scale - 1), 0.003, name)


if __name__ == "__main__":
    unittest.main()
