# SPDX-License-Identifier: Apache-2.0
"""A sensor with a thermometer of its own: from the recording to whoever deploys the file."""
import functools
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from blob_reader import Calibration, SensorFlag
from soak_cli import SoakTest, recording

SERIAL = "SN1"
PLATEAUS = (-20.0, 0.0, 20.0, 40.0, 60.0)
WARMER_C = 8.0
RAW = [1.0, -2.0, 3.0, 0.5, -1.5, 9.75]  # deg/s, m/s2
DEGREE = 3.141592653589793 / 180
SENSORS = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]


def with_thermometer(text):
    """The recording with gyro x's thermometer, 8 K above the unit's. Gyro x reads 0.1 + 0.01 (plateau) deg/s."""
    header, *rows = text.splitlines()
    at = header.split(",").index("temp_c")
    lines = [header + ",temp_gx_c"] + [f"{row},{float(row.split(',')[at]) + WARMER_C:.3f}" for row in rows]
    return "\n".join(lines) + "\n"


def run_soak(*arguments):
    return subprocess.run([os.environ["SOAK_BIN"], *map(str, arguments)], check=True, capture_output=True, text=True)


@functools.cache
def fitted():
    """A data folder with three runs of such a unit, fitted; what `soak fit --json` said."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-thermometers-"))
    for seed in (1, 2, 3):
        path = folder / f"r{seed}.csv"
        path.write_text(with_thermometer(recording(seed, f"r{seed}", PLATEAUS, 30)), encoding="utf-8")
        run_soak("import", path, "--unit", SERIAL, "--gravity-mps2", "9.80665", "--data", folder / "data")
    return folder, run_soak("fit", "--unit", SERIAL, "--json", "--data", folder / "data").stdout


def tearDownModule():
    if fitted.cache_info().currsize:
        shutil.rmtree(fitted()[0], ignore_errors=True)


class Thermometers(SoakTest):
    def setUp(self):
        super().setUp()
        shutil.copytree(fitted()[0] / "data", self.data)
        self.file = self.folder / "tg.soakcal"
        self.soak_json("export", "export", "--unreleased", "--unit", SERIAL, "--format", "blob", "-o", self.file)

    def eval(self, *arguments):
        return self.soak_json("eval", "eval", self.file, *arguments)

    @staticmethod
    def warnings_of(document):
        """Beside that the recordings heat only."""
        return [warning for warning in document["warnings"] if warning["code"] != "one_way"]

    def test_fit_names_the_thermometer_of_each_sensor(self):
        sensors = json.loads(fitted()[1])["sensors"]
        self.assertEqual({name: s["thermometer"] for name, s in sensors.items()},
                         {name: "own" if name == "gyro_x" else "unit" for name in SENSORS})
        self.assertAlmostEqual(sensors["gyro_x"]["temp_min_c"], -20 + WARMER_C, delta=0.1)

    def test_the_unit_s_temperature_alone_gives_no_bias_and_a_warning(self):
        document = self.eval("--temp-c", "25", "--raw", ",".join(map(str, RAW)))
        (point,) = document["points"]
        self.assertIsNone(point["bias"]["gyro_x"])
        self.assertIsNotNone(point["bias"]["gyro_y"])
        (warning,) = self.warnings_of(document)
        self.assertEqual(warning["code"], "own_thermometer")
        self.assertIn("--own-temp-c gyro_x=T", warning["text"])
        self.assertEqual(point["corrected"]["status"], "invalid")
        self.assertEqual(point["corrected"]["flags"], 1 << 16 | 1 << 25)
        self.assertAlmostEqual(point["corrected"]["out"]["gyro_x"], RAW[0], delta=1e-6)
        done = self.soak("eval", self.file, "--temp-c", "25")
        self.assertIn("warning: gyro_x: ", done.stderr)

    def test_its_own_temperature_gives_the_bias_that_it_has(self):
        document = self.eval("--temp-c", "25", "--own-temp-c", f"gyro_x={25 + WARMER_C}", "--raw", ",".join(map(str, RAW)))
        (point,) = document["points"]
        self.assertAlmostEqual(point["bias"]["gyro_x"], 0.1 + 0.01 * 25, delta=0.01)
        self.assertEqual((self.warnings_of(document), document["own_temps_c"]), ([], {"gyro_x": 33.0}))
        self.assertEqual((point["corrected"]["status"], point["corrected"]["flags"]), ("ok", 0))

    def test_a_stranger_reading_the_specification_corrects_as_the_runtime_does(self):
        stranger = Calibration.load(self.file.read_bytes())
        self.assertEqual(stranger.own_thermometers, ["gyro_x"])
        si = [value * (DEGREE if i < 3 else 1) for i, value in enumerate(RAW)]
        for temp_c, own in ((-15.0, None), (-15.0, 2.5), (40.0, 45.25), (20.0, 80.0)):
            options = [] if own is None else ["--own-temp-c", f"gyro_x={own}"]
            (point,) = self.eval("--temp-c", temp_c, "--raw", ",".join(map(str, RAW)), *options)["points"]
            out, flags = stranger.apply(temp_c, si, None if own is None else {"gyro_x": own})
            for i, name in enumerate(SENSORS):
                expected = out[i] / (DEGREE if i < 3 else 1)
                # deg/s: float32 of 0.05 rad/s is 4e-9 rad/s; m/s2: of 10
                self.assertAlmostEqual(point["corrected"]["out"][name], expected, delta=2e-6 if i < 3 else 5e-6)
                word = point["corrected"]["flags"]
                self.assertEqual(bool(word >> i & 1), bool(flags[i] & SensorFlag.OUT_OF_RANGE))
                self.assertEqual(bool(word >> (16 + i) & 1), bool(flags[i] & SensorFlag.NO_TEMPERATURE))

    def test_temperatures_of_other_sensors_and_no_numbers_are_refused(self):
        self.assertEqual(self.refusal("eval", self.file, "--temp-c", "25", "--own-temp-c", "gyro_y=20")["where"], "--own-temp-c")
        for bad in ("gyro_x", "gyro_x=", "gyro_q=20", "gyro_x=20,", "gyro_x=1e9", "gyro_x=20,gyro_x=21"):
            self.refusal("eval", self.file, "--temp-c", "25", "--own-temp-c", bad)
        for bad in ("1,2,3", "1,2,3,4,5,6,7", "1,2,3,4,5,x"):
            self.refusal("eval", self.file, "--temp-c", "25", "--raw", bad)

    def test_autopilots_are_refused_and_told_why(self):
        for name in ("px4", "ardupilot"):
            out = self.folder / name
            error = self.refusal("export", "--unreleased", "--unit", SERIAL, "--format", name, "-o", out)
            self.assertIn("gyro_x", error["message"])
            self.assertFalse(out.exists())

    def test_header_and_json_say_it(self):
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "c", "-o", self.folder / "tg.h")
        self.assertRegex((self.folder / "tg.h").read_text(), "gyro_x.*thermometer")
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "json", "-o", self.folder / "tg.json")
        sensors = json.loads((self.folder / "tg.json").read_text())["sensors"]
        self.assertEqual([sensors[name]["thermometer"] for name in SENSORS[:2]], ["own", "unit"])

    def test_a_run_without_it_is_not_fitted_together_with_the_others(self):
        self.imported("plain.csv", recording(4, "r4", PLATEAUS, 30), "--gravity-mps2", "9.80665")
        error = self.refusal("fit", "--unit", SERIAL)
        self.assertRegex(error["message"], "run r[123] .*gyro_x.* run r4 ")


if __name__ == "__main__":
    unittest.main()
