# SPDX-License-Identifier: Apache-2.0
"""soak export --format px4, ardupilot, kalibr: what the files make an autopilot do; logs of autopilots as recordings."""
import functools
import json
import math
import os
import pathlib
import random
import shutil
import struct
import subprocess
import tempfile
import unittest

from soak_cli import ROOT, SoakTest, recording

SERIAL = "SN1"
AXES = "xyz"
RADIANS = math.pi / 180
TEMPERATURES = [-20.0 + 0.7 * i for i in range(115)]


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


@functools.cache
def fitted_folder():
    """A data folder with two runs of one unit (gx 0.1 + 0.01 T deg/s, all else 0), fitted, and the same as simulated."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-autopilot-"))
    quiet = {"check": True, "capture_output": True}
    for name, options in (("data", []), ("simulated", ["--simulated"])):
        data = ["--data", str(folder / name)]
        for seed, run in ((1, "r1"), (2, "r2")):
            path = folder / f"{run}.csv"
            path.write_text(recording(seed, run, (-20.0, 0.0, 20.0, 40.0, 60.0), 30), encoding="utf-8")
            subprocess.run([os.environ["SOAK_BIN"], "import", str(path), "--unit", SERIAL, *options, *data], **quiet)
        subprocess.run([os.environ["SOAK_BIN"], "fit", "--unit", SERIAL, *data], **quiet)
    return folder


def tearDownModule():
    if fitted_folder.cache_info().currsize:
        shutil.rmtree(fitted_folder(), ignore_errors=True)


def parameters(text, columns, name, value):
    """NAME -> VALUE of the lines that are no comment, after a check of how many columns each has."""
    found = {}
    for line in text.splitlines():
        if line.startswith("#") or not line:
            continue
        words = line.split()
        assert len(words) == columns, line
        assert words[name] not in found, line
        found[words[name]] = float(words[value])
    return found


def px4_offset(p, kind, n, axis, temp_c):
    """PX4's documented thermal offset in float32, subtracted from the raw value."""
    prefix = f"TC_{kind}{n}"
    clipped = min(max(f32(temp_c), f32(p[f"{prefix}_TMIN"])), f32(p[f"{prefix}_TMAX"]))
    d = f32(clipped - f32(p[f"{prefix}_TREF"]))
    return f32(sum(f32(p[f"{prefix}_X{k}_{axis}"]) * d ** k for k in range(4)))


def ardupilot_correction(p, kind, n, axis, temp_c):
    """What ArduPilot takes off the raw value, in float32: p(T) - p(CALTEMP) + OFFS about 35 degC, coefficients in 1e-6."""
    low, high = p[f"INS_TCAL{n}_TMIN"], p[f"INS_TCAL{n}_TMAX"]

    def polynomial(temp):
        d = f32(min(max(f32(temp), low), high) - 35.0)
        c = [f32(p[f"INS_TCAL{n}_{kind}{k}_{axis}"]) for k in (1, 2, 3)]
        return f32((c[0] + (c[1] + c[2] * d) * d) * d * 1e-6)
    offset = {"GYR": "INS_GYROFFS", "ACC": "INS_ACCOFFS"}[kind] if n == 1 else f"INS_{kind}{n}OFFS"
    return f32(polynomial(temp_c) - polynomial(p[f"INS_{kind}{n}_CALTEMP"]) + p[f"{offset}_{axis}"])


class AutopilotTest(SoakTest):
    def setUp(self):
        super().setUp()
        for name in ("data", "simulated"):
            shutil.copytree(fitted_folder() / name, self.folder / name)

    def export(self, kind, *options):
        path = self.folder / f"unit.{kind}"
        document = self.soak_json("export", "export", "--unreleased", "--unit", SERIAL, "--format", kind, "-o", path, *options)
        return path.read_text(encoding="ascii"), document

    def model(self):
        path = self.folder / "unit.json"
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "json", "-o", path)
        return json.loads(path.read_text(encoding="utf-8"))

    def check_stated_loss(self, document, correction):
        """The correction of every sensor differs from the model's points by no more than the stated worst."""
        for name, sensor in self.model()["sensors"].items():
            loss = document["cubic"][name]
            factor = RADIANS if name.startswith("gyro") else 1.0
            worst = max(abs(correction(name, point["temp_c"]) / factor - point["bias"]) for point in sensor["curve"])
            # The exported JSON has whole degrees only, so its worst is at most the stated one; 1e-6 for float32.
            self.assertLessEqual(worst, loss["worst"] * 1.001 + 1e-6, name)
            self.assertGreaterEqual(loss["worst"], loss["rms"])
            self.assertEqual((loss["scale_ppm"] is None), name.startswith("gyro"))


class Px4(AutopilotTest):
    def test_parameters_correct_the_known_bias_inside_the_range_and_hold_it_outside(self):
        text, document = self.export("px4", "--device-id", "1310988,1311244", "--instance", "1")
        p = parameters(text, 5, 2, 3)
        self.assertEqual((p["TC_A1_ID"], p["TC_G1_ID"], p["TC_A_ENABLE"], p["TC_G_ENABLE"]), (1310988, 1311244, 1, 1))
        low, high = p["TC_G1_TMIN"], p["TC_G1_TMAX"]
        for temp in TEMPERATURES:
            # Truth 0.1 + 0.01 T; 60 means of 60 samples of noise 0.01 deg/s: 0.0013 each, and T is 0.05 degC off at most.
            truth = (0.1 + 0.01 * min(max(temp, low), high)) * RADIANS
            self.assertAlmostEqual(px4_offset(p, "G", 1, 0, temp), truth, delta=0.005 * RADIANS)
        self.assertEqual(px4_offset(p, "G", 1, 0, 200.0), px4_offset(p, "G", 1, 0, high))
        letters = {"gyro": "G", "accel": "A"}
        self.check_stated_loss(document, lambda name, temp: px4_offset(p, letters[name[:-2]], 1, AXES.index(name[-1]), temp))

    def test_file_is_tab_separated_with_types(self):
        text, document = self.export("px4")
        for line in text.splitlines():
            if line.startswith("#"):
                continue
            self.assertRegex(line, r"^1\t1\tTC_[AG](_ENABLE\t1\t6|0_(X[0-3]_[0-2]|TREF|TMIN|TMAX)\t\S+\t9)$")
        self.assertIn("TC_A0_ID", " ".join(document["notes"]))
        for part in ("# unit: SN1\n", "# model version: 1\n", "# created: 20", "# gravity: 9.80665 m/s2 (assumed)\n", "rms "):
            self.assertIn(part, text)

    def test_text_output_states_the_loss(self):
        done = self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "px4", "-o", self.folder / "unit.params")
        for part in ("loss of the cubic", "ci95 there", "gyro_x", "CAL_ACCn_*OFF"):
            self.assertIn(part, done.stdout)


class ArduPilot(AutopilotTest):
    def test_parameters_correct_the_known_bias_inside_the_range_and_hold_it_outside(self):
        for instance in ("0", "2"):
            text, document = self.export("ardupilot", "--instance", instance)
            p = parameters(text, 2, 0, 1)
            n = int(instance) + 1
            self.assertEqual((p[f"INS_TCAL{n}_ENABLE"], p[f"INS_ACC{n}_CALTEMP"], p[f"INS_GYR{n}_CALTEMP"]), (1, 35, 35))
            low, high = p[f"INS_TCAL{n}_TMIN"], p[f"INS_TCAL{n}_TMAX"]
            for temp in TEMPERATURES:
                truth = (0.1 + 0.01 * min(max(temp, low), high)) * RADIANS
                self.assertAlmostEqual(ardupilot_correction(p, "GYR", n, "X", temp), truth, delta=0.005 * RADIANS)
            kinds = {"gyro": "GYR", "accel": "ACC"}
            self.check_stated_loss(
                document, lambda name, temp: ardupilot_correction(p, kinds[name[:-2]], n, name[-1].upper(), temp))

    def test_one_attitude_gives_no_accelerometer_offsets(self):
        lines = recording(3, "flat", (-20.0, 0.0, 20.0, 40.0, 60.0), 30).splitlines()
        at = lines[0].split(",").index("position")
        flat = [lines[0]] + [line for line in lines[1:] if line.split(",")[at] == "+Z"]
        flat = [",".join(cell for i, cell in enumerate(line.split(",")) if i != at) for line in flat]
        self.data = self.folder / "flat"
        self.imported("flat.csv", "\n".join(flat) + "\n")
        self.soak("fit", "--unit", SERIAL)
        text, document = self.export("ardupilot")
        p = parameters(text, 2, 0, 1)
        self.assertNotIn("INS_ACCOFFS_X", p)
        self.assertNotIn("INS_ACC1_CALTEMP", p)
        self.assertIn("INS_GYROFFS_X", p)
        self.assertIn("accelerometers", " ".join(document["notes"]))
        self.assertIn("accelerometers", self.export("px4")[0])


class Forms(AutopilotTest):
    def blob(self, name, *options):
        path = self.folder / name
        self.soak_json("export", "export", "--unreleased", "--unit", SERIAL, "--format", "blob", "-o", path, *options)
        return path

    def test_a_table_is_smaller_and_says_what_the_model_says_within_its_bound(self):
        whole, table = self.blob("w.soakcal"), self.blob("t.soakcal", "--table", "64")
        asked = ("--temp-c", "-15,3,25,51")
        for a, b in zip(*(self.soak_json("eval", "eval", file, *asked)["points"] for file in (whole, table))):
            for sensor, bias in a["bias"].items():
                # Curves of 80 K in 63 steps; their curvature is far below 1e-4 deg/s per K squared: h^2/8 of it is 2e-5.
                self.assertAlmostEqual(b["bias"][sensor], bias, delta=2e-4, msg=sensor)
        self.assertNotEqual(whole.read_bytes(), table.read_bytes())

    def test_a_file_is_signed_as_it_is_exported(self):
        key = self.folder / "lab.key"
        self.soak("key", "new", "-o", key)
        signed = self.blob("s.soakcal", "--sign", key)
        self.soak("key", "verify", signed, "--key", f"{key}.pub")
        self.soak("key", "verify", self.blob("u.soakcal"), "--key", f"{key}.pub", status=4)

    def test_forms_that_mean_nothing_to_the_format_are_refused(self):
        for option, value in (("--table", "64"), ("--sign", "lab.key")):
            error = self.refusal("export", "--unreleased", "--unit", SERIAL, "--format", "json", option, value, "-o", self.folder / "x")
            self.assertEqual(error["where"], option)
        self.refusal("export", "--unreleased", "--unit", SERIAL, "--format", "blob", "--table", "1", "-o", self.folder / "x")


class Refusals(AutopilotTest):
    def refused(self, *arguments):
        before = self.state()
        accepted = () if "kalibr" in arguments else ("--unreleased",)
        error = self.refusal("export", *accepted, "--unit", SERIAL, *arguments, "-o", self.folder / "no.file")
        self.assertFalse((self.folder / "no.file").exists())
        self.assertEqual(self.state(), before)
        return error

    def test_simulated_models_need_the_flag_and_are_marked(self):
        self.data = self.folder / "simulated"
        for kind in ("px4", "ardupilot"):
            self.assertIn("--simulated", self.refused("--format", kind)["message"])
            text, document = self.export(kind, "--simulated")
            self.assertIn("SIMULATED SIMULATED SIMULATED", text)
            self.assertTrue(document["simulated"])

    def test_options_that_mean_nothing_to_the_format(self):
        self.assertEqual(self.refused("--format", "blob", "--instance", "0")["where"], "--instance")
        self.assertEqual(self.refused("--format", "ardupilot", "--device-id", "7")["where"], "--device-id")
        self.assertEqual(self.refused("--format", "kalibr", "--model", "1")["where"], "--model")
        self.assertEqual(self.refused("--format", "kalibr", "--unreleased")["where"], "--unreleased")

    def test_instances_and_ids_that_do_not_exist(self):
        self.refused("--format", "px4", "--instance", "4")
        self.refused("--format", "ardupilot", "--instance", "3")
        for ids in ("0", "1.5", "x", "1,2,3", "3000000000"):
            self.assertIn("--device-id", self.refused("--format", "px4", "--device-id", ids)["message"])

    def test_short_segments_give_no_noise_for_kalibr(self):
        message = self.refused("--format", "kalibr")["message"]
        self.assertIn("procedures/static-allan.toml", message)


class Kalibr(SoakTest):
    def still(self, *options, seconds=3600):
        """An hour at rest at 2 Hz: white noise 0.02 deg/s on gyro z, 0.01 on the others, 0.004 m/s2 on the accelerometers."""
        noise = random.Random(7)
        lines = ["t_s,run,plateau_c,position,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2"]
        for i in range(2 * seconds):
            gyro = [noise.gauss(0, sigma) for sigma in (0.01, 0.01, 0.02)]
            force = [noise.gauss(g, 0.004) for g in (0, 0, 9.80665)]
            numbers = ",".join(f"{x:.6f}" for x in gyro + force)
            lines.append(f"{i / 2},still,25,+Z,{25 + noise.gauss(0, 0.01):.3f},{numbers}")
        self.imported("still.csv", "\n".join(lines) + "\n", *options)

    @staticmethod
    def yaml(text):
        pairs = [line.split("#")[0].split(":") for line in text.splitlines() if not line.startswith("#")]
        return {key.strip(): value.strip() for key, value in pairs}

    def test_values_are_those_of_the_worst_axis_and_above_zero(self):
        self.still()
        path = self.folder / "imu.yaml"
        document = self.soak_json("export", "export", "--unit", SERIAL, "--format", "kalibr", "-o", path)
        values = self.yaml(path.read_text(encoding="ascii"))
        self.assertEqual(list(values), ["rostopic", "update_rate", "accelerometer_noise_density", "accelerometer_random_walk",
                                        "gyroscope_noise_density", "gyroscope_random_walk"])
        self.assertAlmostEqual(float(values["update_rate"]), 2.0, places=3)
        # N = sigma / sqrt(rate). 7200 samples give it to about 1.2 %; 5 % is four of that.
        self.assertAlmostEqual(float(values["gyroscope_noise_density"]) / (0.02 * RADIANS / math.sqrt(2)), 1, delta=0.05)
        self.assertAlmostEqual(float(values["accelerometer_noise_density"]) / (0.004 / math.sqrt(2)), 1, delta=0.05)
        stated = document["noise"]["values"]
        self.assertEqual(stated["gyroscope_noise_density"]["worst_axis"], "gyro_z")
        for key, value in stated.items():
            self.assertGreater(float(values[key]), 0)
            self.assertAlmostEqual(float(values[key]) / value["value"], 1, places=6)
        text = path.read_text(encoding="ascii")
        self.assertEqual(text.count("UPPER BOUND"), sum(value["upper_bound"] for value in stated.values()))
        self.assertIn("# longest averaging time: 1200 s", text)
        self.assertIsNone(document["model"])

    def test_a_longer_segment_in_which_the_fixture_turns_is_not_at_rest(self):
        noise = random.Random(7)
        lines = ["t_s,run,plateau_c,position,rate_dps,temp_c,gz_dps,az_mps2"]
        for i in range(9000):
            rate = 0 if i < 3800 else 30
            lines.append(f"{i / 2},table,25,+Z,{rate},25,{noise.gauss(rate, 0.02):.6f},{noise.gauss(9.80665, 0.004):.6f}")
        self.imported("table.csv", "\n".join(lines) + "\n")
        path = self.folder / "imu.yaml"
        self.soak("export", "--unit", SERIAL, "--format", "kalibr", "-o", path)
        density = float(self.yaml(path.read_text(encoding="ascii"))["gyroscope_noise_density"])
        self.assertAlmostEqual(density / (0.02 * RADIANS / math.sqrt(2)), 1, delta=0.05)
        self.assertIn("# longest averaging time: 6", path.read_text(encoding="ascii"))

    def test_simulated_runs_need_the_flag(self):
        self.still("--simulated", seconds=1860)
        path = self.folder / "imu.yaml"
        arguments = ("export", "--unit", SERIAL, "--format", "kalibr", "-o", path)
        self.refusal(*arguments)
        self.soak(*arguments, "--simulated")
        self.assertIn("SIMULATED", path.read_text(encoding="ascii"))

    def test_an_unknown_unit(self):
        self.still(seconds=60)
        self.assertIn("'NOBODY'", self.refusal("export", "--unit", "NOBODY", "--format", "kalibr", "-o", self.folder / "no.yaml")["message"])


class Logs(SoakTest):
    """Synthetic CSV with the columns of ulog2csv and mavlogdump, read by the maps in procedures/columns."""

    def read_back(self, name, text, columns):
        run = self.imported(name, text, "--columns", ROOT / "procedures" / "columns" / columns)
        path = self.folder / "back.csv"
        self.soak("runs", "export", run["run"], "--unit", SERIAL, "-o", path)
        header, *rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
        return [dict(zip(header, row)) for row in rows]

    def test_px4_accelerometer(self):
        lines = ["timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count,clip_counter[0],clip_counter[1],"
                 "clip_counter[2],samples"]
        lines += [f"{5000500 + 2500 * i},{5000000 + 2500 * i},1310988,0.125,-0.25,-9.75,{41.5 + i / 4096},0,0,0,0,8"
                  for i in range(400)]
        row = self.read_back("log_sensor_accel_0.csv", "\n".join(lines) + "\n", "px4-ulog2csv-accel.toml")[4]
        self.assertEqual([float(row[k]) for k in ("ax_mps2", "ay_mps2", "az_mps2")], [0.125, -0.25, -9.75])
        self.assertAlmostEqual(float(row["t_s"]), 5.01, places=9)
        self.assertAlmostEqual(float(row["temp_c"]), 41.5 + 4 / 4096, places=9)
        self.assertEqual(float(row["device_id"]), 1310988)

    def test_px4_gyro(self):
        lines = ["timestamp,timestamp_sample,device_id,temperature,error_count,clip_counter[0],clip_counter[1],clip_counter[2],"
                 "samples,x,y,z"]
        lines += [f"{5000500 + 2500 * i},{5000000 + 2500 * i},1311244,{41.5 + i / 4096},0,0,0,0,8,0.5,-0.25,0.125"
                  for i in range(400)]
        row = self.read_back("log_sensor_gyro_0.csv", "\n".join(lines) + "\n", "px4-ulog2csv-gyro.toml")[0]
        for key, rad in (("gx_dps", 0.5), ("gy_dps", -0.25), ("gz_dps", 0.125)):
            self.assertAlmostEqual(float(row[key]), rad / RADIANS, places=9)

    def test_px4_rows_before_the_first_temperature_are_left_out_on_demand(self):
        # Newer logs have range and scale too, and "nan" until the sensor has told its temperature.
        lines = ["timestamp,timestamp_sample,device_id,temperature,scale,dynamic_range,error_count,clip_counter[0],clip_counter[1],"
                 "clip_counter[2],samples,x,y,z"]
        lines += [f"{5000500 + 2500 * i},{5000000 + 2500 * i},1311244,{'nan' if i < 3 else 41.5},16.384,2000.0,0,0,0,0,8,0.5,-0.25,0.125"
                  for i in range(400)]
        path = self.write("gyro.csv", "\n".join(lines) + "\n")
        arguments = ("import", path, "--unit", SERIAL, "--columns", ROOT / "procedures/columns/px4-ulog2csv-gyro.toml")
        self.refusal(*arguments)
        document = self.soak_json("import", *arguments, "--skip-bad")
        self.assertEqual(document["runs"][0]["rows"], 397)

    def ardupilot(self, instances):
        lines = ["timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"]
        for i in range(400):
            for n in range(instances):
                lines.append(f"{1700000000 + i / 64:.8f},{9000000 + 15625 * i},{n},0.5,-0.25,0.125,0.25,-0.5,-9.75,0,0,"
                             f"{38.25 + i / 4096},1,1,1000,1000")
        return "\n".join(lines) + "\n"

    def test_ardupilot(self):
        row = self.read_back("imu0.csv", self.ardupilot(1), "ardupilot-imu.toml")[8]
        self.assertAlmostEqual(float(row["gx_dps"]), 0.5 / RADIANS, places=9)
        self.assertEqual([float(row[k]) for k in ("ax_mps2", "ay_mps2", "az_mps2")], [0.25, -0.5, -9.75])
        self.assertAlmostEqual(float(row["t_s"]), 9.125, places=9)
        self.assertAlmostEqual(float(row["utc_s"]), 1700000000.125, places=6)

    def test_ardupilot_units_that_are_mixed_are_refused(self):
        path = self.write("mixed.csv", self.ardupilot(2))
        error = self.refusal("import", path, "--unit", SERIAL, "--columns", ROOT / "procedures/columns/ardupilot-imu.toml")
        self.assertTrue(error["where"].startswith(f"{path}, line "), error)


if __name__ == "__main__":
    unittest.main()
