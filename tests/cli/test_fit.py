# SPDX-License-Identifier: Apache-2.0
"""From stored runs to a calibration file: fit, export, eval, verify, as a user calls them."""
import contextlib
import functools
import json
import os
import pathlib
import random
import shutil
import sqlite3
import struct
import subprocess
import tempfile
import unittest

from blob_reader import Calibration
from run_digest import open_catalog, run_digest
from soak_cli import ROOT, SoakTest, check_schema, long_test, recording, shared_data

SERIAL = "SIM-0001"
SENSORS = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]
DEGREES = 57.29577951308232


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


@functools.cache
def fitted_folder():
    """A data folder with a small simulated campaign of one unit, fitted once for all tests; they work on copies."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-fit-"))
    soak, data = os.environ["SOAK_BIN"], ["--data", str(folder / "data")]
    quiet = {"check": True, "capture_output": True}
    subprocess.run([os.environ["SOAK_SIM_BIN"], "--out", str(folder / "lab"), "--units", "1", "--runs", "3",
                    "--rows-per-position", "10"], **quiet)
    for campaign, procedure in (("campaign", "import"), ("verification", "verification")):
        subprocess.run([soak, "import", str(folder / "lab" / campaign / f"{SERIAL}.csv"), "--unit", SERIAL, "--campaign",
                        campaign, "--procedure", procedure, "--simulated", "--gravity-mps2", "9.80665", *data], **quiet)
    done = subprocess.run([soak, "fit", "--unit", SERIAL, "--json", *data], text=True, **quiet)
    (folder / "fit.json").write_text(done.stdout, encoding="utf-8")
    return folder


def tearDownModule():
    if fitted_folder.cache_info().currsize:
        shutil.rmtree(fitted_folder(), ignore_errors=True)


class FittedTest(SoakTest):
    def setUp(self):
        super().setUp()
        shutil.copytree(fitted_folder() / "data", self.data)
        self.fit = json.loads((fitted_folder() / "fit.json").read_text(encoding="utf-8"))

    def blob(self, name="unit.soakcal"):
        path = self.folder / name
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", path)
        return path

    def eval(self, path, temps):
        done = subprocess.run([os.environ["SOAK_BIN"], "eval", str(path), "--json", "--temp-c", ",".join(map(repr, temps))],
                              capture_output=True, text=True, check=True)
        return json.loads(done.stdout)["points"]


class Fit(FittedTest):
    def test_document_follows_its_schema_and_covers_the_range_degree_by_degree(self):
        fit = self.soak_json("fit", "fit", "--unit", SERIAL)
        self.assertEqual(list(fit["sensors"]), sorted(SENSORS))
        for name, sensor in fit["sensors"].items():
            temps = [point["temp_c"] for point in sensor["curve"]]
            self.assertEqual((temps[0], temps[-1]), (sensor["temp_min_c"], sensor["temp_max_c"]))
            self.assertTrue(all(abs(b - a - 1) < 1e-9 for a, b in zip(temps[:-2], temps[1:-1])))
            self.assertEqual(sensor["holdout"], "run")
            self.assertEqual([check["held_out"] for check in sensor["checks"]], sensor["runs"])
            self.assertTrue(all((point["scale_ppm"] is None) == name.startswith("gyro") for point in sensor["curve"]))
            self.assertLess(sensor["check_rmse_shape"], sensor["check_rmse"])

    def test_what_the_units_type_says_is_used(self):
        """An accelerometer that reads -g upwards, and a thermometer that repeats to 0.1 K."""
        units = self.folder / "procedures" / "units"
        units.mkdir(parents=True)
        (units / "minus.toml").write_text('name = "minus"\nsign_at_rest = -1\n[thermometers]\nrepeatability_c = 0.1\n')
        os.environ["SOAK_PROCEDURES"] = str(units.parent)
        self.addCleanup(os.environ.pop, "SOAK_PROCEDURES")
        header, *lines = (fitted_folder() / "lab" / "campaign" / f"{SERIAL}.csv").read_text().splitlines()
        columns = [i for i, name in enumerate(header.split(",")) if name.startswith("a") and name.endswith("_mps2")]
        self.assertEqual(len(columns), 3)
        turned = [header]
        for line in lines:
            cells = line.split(",")
            for i in columns:
                cells[i] = cells[i][1:] if cells[i].startswith("-") else "-" + cells[i]
            turned.append(",".join(cells))
        path = self.write("minus.csv", "\n".join(turned) + "\n")
        self.soak("unit", "add", "M1", "--type", "minus")
        self.soak("import", path, "--unit", "M1", "--campaign", "m", "--gravity-mps2", "9.80665")
        fit = self.soak_json("fit", "fit", "--unit", "M1")
        for name, sensor in fit["sensors"].items():
            thermometer, = [part for part in sensor["uncertainty"] if part["name"] == "thermometer"]
            self.assertTrue(thermometer["stated"] and thermometer["curve"]["max"] > 0, name)
            sign = 1 if name.startswith("gyro") else -1
            for mine, theirs in zip(sensor["curve"][::10], self.fit["sensors"][name]["curve"][::10]):
                self.assertAlmostEqual(mine["bias"], sign * theirs["bias"], delta=0.1 * theirs["ci95"])

    def test_a_fit_adds_a_version_and_the_old_one_stays(self):
        self.assertEqual(self.fit["model"], 1)
        self.assertEqual(self.soak_json("fit", "fit", "--unit", SERIAL, "--rules", "3")["model"], 2)
        old, new = self.folder / "old.json", self.folder / "new.json"
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "json", "--simulated", "--model", "1", "-o", old)
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "json", "--simulated", "-o", new)
        self.assertEqual((json.loads(old.read_text())["model"], json.loads(new.read_text())["model"]), (1, 2))

    @long_test
    def test_the_number_of_threads_does_not_change_the_result(self):
        one, two = (self.soak_json("fit", "fit", "--unit", SERIAL, "--jobs", jobs) for jobs in ("1", "4"))
        self.assertEqual(one["sensors"], two["sensors"])

    def test_all_units_at_once(self):
        self.assertEqual([u["unit"] for u in self.soak_json("fit-all", "fit", "--all")["units"]], [SERIAL])

    @long_test
    def test_verification_runs_are_left_out(self):
        self.assertEqual(self.fit["sensors"]["gyro_x"]["runs"], ["R01", "R02", "R03"])
        self.refusal("fit", "--unit", SERIAL, "--campaign", "verification")

    def test_what_cannot_be_fitted_is_refused_and_nothing_stored(self):
        before = self.state()
        self.refusal("fit", "--unit", "NOBODY")
        message = self.refusal("fit", "--unit", SERIAL, "--campaign", "none")["message"]
        for name in ("'none'", "campaign, verification"):
            self.assertIn(name, message)
        self.refusal("fit", "--unit", SERIAL, "--rules", "1")
        self.refusal("fit")
        self.assertEqual(self.state(), before)

    def test_one_run_only_is_fitted_with_nulls_and_a_warning(self):
        for run in ("R02", "R03"):
            self.soak("runs", "void", run, "--reason", "test")
        sensor = self.soak_json("fit", "fit", "--unit", SERIAL)["sensors"]["gyro_x"]
        self.assertIsNone(sensor["check_rmse"])
        self.assertIsNone(sensor["run_to_run_sigma"])
        self.assertIsNone(sensor["curve"][0]["pi95"])
        self.assertIn("few_runs", [warning["code"] for warning in sensor["warnings"]])

    def test_voided_runs_do_not_count(self):
        for run in ("R01", "R02", "R03"):
            self.soak("runs", "void", run, "--reason", "test")
        self.refusal("fit", "--unit", SERIAL)


class StuckSensor(SoakTest):
    def test_is_refused_by_name_with_a_remedy_and_no_model_is_stored(self):
        header, *rows = recording(plateaus=(-20.0, 0.0, 20.0, 40.0), seconds=20).splitlines()
        column = header.split(",").index("gy_dps")
        stuck = [",".join("0.25" if i == column else cell for i, cell in enumerate(row.split(","))) for row in rows]
        self.imported("stuck.csv", "\n".join([header, *stuck]) + "\n")
        before = self.state()
        error = self.refusal("fit", "--unit", "SN1")
        for part in ("gyro_y", "SN1", "0.25"):
            self.assertIn(part, error["message"])
        self.assertEqual(self.state(), before)


class WrongSignsAndUnits(SoakTest):
    def test_accelerometers_that_do_not_read_gravity_are_refused_with_a_remedy(self):
        text = recording(plateaus=(-20.0, 0.0, 20.0, 40.0), seconds=20)
        swapped = text.replace(",+X,", ",@,").replace(",-X,", ",+X,").replace(",@,", ",-X,")
        for name, bad in (("swapped.csv", swapped), ("unit.csv", text.replace("ax_mps2", "ax_g"))):
            with self.subTest(name):
                self.imported(name, bad, "--campaign", name)
                error = self.refusal("fit", "--unit", "SN1", "--campaign", name)
                for part in ("accel_x", "SN1"):
                    self.assertIn(part, error["message"])


class DataGate(SoakTest):
    def test_a_simulated_campaign_has_no_findings(self):
        data = ["--data", str(fitted_folder() / "data")]
        for run in ("R01", "R02", "R03"):
            done = subprocess.run([os.environ["SOAK_BIN"], "runs", "show", run, "--campaign", "campaign", "--json", *data],
                                  check=True, capture_output=True, text=True)
            document = json.loads(done.stdout)
            check_schema(document, "runs-show")
            self.assertEqual(len(document["segments"]), 246)
            self.assertEqual([s["findings"] for s in document["segments"] if s["findings"]], [])

    def test_a_wrong_label_is_named_at_import_left_out_of_the_fit_and_kept(self):
        rows = recording(plateaus=(-20.0, 0.0, 20.0, 40.0), seconds=30).splitlines()
        # The first -Z segment is labelled +Y: rows 300 to 359 after the header.
        text = "\n".join(row.replace(",-Z,", ",+Y,") if 300 < i <= 360 else row for i, row in enumerate(rows)) + "\n"
        path = self.write("wrong.csv", text)
        document = self.soak_json("import", "import", path, "--unit", "SN1", "--gravity-mps2", "9.80665")
        self.assertRegex(" ".join(document["warnings"]), "wrong_position .*\\b1 of 24\\b.* -Z")
        shown = self.soak_json("runs-show", "runs", "show", "r1")["segments"]
        found = [(s["position"], f["code"], f["severity"]) for s in shown for f in s["findings"]]
        self.assertEqual(found, [("+Y", "wrong_position", "reject")])
        self.assertIn("reject: visit 0, position +Y, attempt 1: wrong_position", self.soak("runs", "show", "r1").stdout)
        fit = self.soak_json("fit", "fit", "--unit", "SN1")
        warning, = [warning["text"] for warning in fit["warnings"] if warning["code"] == "wrong_position"]
        # Word for word what the import has said.
        said, = [text for text in document["warnings"] if "wrong_position" in text]
        self.assertEqual(warning, said.replace("run 'r1'", "run r1"))


class ImplausibleValues(SoakTest):
    def test_are_bad_rows_with_line_and_column(self):
        header, *rows = recording(seconds=10).splitlines()
        for column, value in (("temp_c", "-300"), ("temp_c", "1e9"), ("t_s", "1e300")):
            with self.subTest(column=column, value=value):
                cells = rows[-1].split(",")
                cells[header.split(",").index(column)] = value
                path = self.write("bad.csv", "\n".join([header, *rows[:-1], ",".join(cells)]) + "\n")
                error = self.refusal("import", path, "--unit", "SN1")
                self.assertIn(f"line {len(rows) + 1}, column '{column}'", error["where"])

    def test_readings_that_no_sensor_gives_are_kept_but_not_fitted(self):
        header, *rows = recording(seconds=10).splitlines()
        column = header.split(",").index("gx_dps")
        huge = [",".join(cell + "e150" if i == column else cell for i, cell in enumerate(row.split(","))) for row in rows]
        self.imported("huge.csv", "\n".join([header, *huge]) + "\n")
        before = self.state()
        self.refusal("fit", "--unit", "SN1")
        self.assertEqual(self.state(), before)

    @long_test
    def test_a_recording_that_never_rests_gives_no_model(self):
        self.imported("ramp.csv", recording(seconds=10).replace(",soak,", ",ramp,"))
        before = self.state()
        self.refusal("fit", "--unit", "SN1")
        self.assertEqual(self.state(), before)


class MissingRunFile(FittedTest):
    def test_is_damage_not_a_fit(self):
        next(iter(sorted((self.data / "runs").glob("*.soakrun")))).unlink()
        self.refusal("fit", "--unit", SERIAL, status=4)


    @long_test
    def test_one_that_was_changed_is_damage_too_and_named(self):
        path = sorted((self.data / "runs").glob("*.soakrun"))[0]
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.chmod(0o600)
        path.write_bytes(bytes(content))
        before = self.state()
        error = self.refusal("fit", "--unit", SERIAL, status=4)
        self.assertEqual(error["where"], str(path))
        self.assertEqual(self.state(), before)


class CalibrationFile(FittedTest):
    def test_a_stranger_reading_the_specification_gets_what_eval_says(self):
        path = self.blob()
        stranger = Calibration.load(path.read_bytes())
        temps = [float32(-40 + 0.37 * i) for i in range(330)]
        points = self.eval(path, temps)
        self.assertEqual(list(stranger.sensors), SENSORS)
        for sensor in SENSORS:
            unit = DEGREES if sensor.startswith("gyro") else 1.0
            theirs = [stranger.bias(sensor, t)[0] * unit for t in temps]
            self.assert_same_curve([p["bias"][sensor] for p in points], theirs)
            if not sensor.startswith("gyro"):
                self.assert_same_curve([p["scale_ppm"][sensor] for p in points],
                                       [stranger.scale_ppm(sensor, t)[0] for t in temps])
        inside = [all(stranger.bias(s, t)[1] for s in SENSORS) for t in temps]
        self.assertEqual([p["in_range"] for p in points], inside)

    def assert_same_curve(self, ours, theirs):
        span = max(theirs) - min(theirs)
        self.assertGreater(span, 0.0)
        self.assertLess(max(abs(a - b) for a, b in zip(ours, theirs)), 1e-6 * span)

    def test_eval_agrees_with_the_fit(self):
        temps = [point["temp_c"] for point in self.fit["sensors"]["gyro_z"]["curve"]]
        points = self.eval(self.blob(), temps)
        for point, curve in zip(points, self.fit["sensors"]["gyro_z"]["curve"]):
            self.assertAlmostEqual(point["bias"]["gyro_z"], curve["bias"], delta=2e-6)

    def test_outside_its_range_it_clamps_and_says_so(self):
        low, end, far = self.eval(self.blob(), [-30.0, 75.0, 200.0])
        self.assertTrue(low["in_range"])
        self.assertFalse(far["in_range"])
        self.assertEqual(end["bias"], far["bias"])

    def test_a_flipped_bit_is_refused(self):
        data = self.blob().read_bytes()
        damaged = self.folder / "damaged.soakcal"
        positions = random.Random(7).sample(range(8 * len(data)), 60) + list(range(0, 64, 7))
        for bit in positions:
            flipped = bytearray(data)
            flipped[bit // 8] ^= 1 << bit % 8
            damaged.write_bytes(flipped)
            done = subprocess.run([os.environ["SOAK_BIN"], "eval", str(damaged), "--temp-c", "25", "--json"],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 4, f"bit {bit}: {done.stderr}")
            self.assertIn(str(damaged), json.loads(done.stderr)["error"]["where"])

    def test_what_is_no_calibration_file_is_refused(self):
        for content in (b"", b"t_s,temp_c\n", os.urandom(500)):
            path = self.write("other", content)
            done = subprocess.run([os.environ["SOAK_BIN"], "eval", str(path), "--temp-c", "25"], capture_output=True, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
        for temps in ("nan", "1,,2", "x", "1e300"):
            done = subprocess.run([os.environ["SOAK_BIN"], "eval", str(self.blob()), "--temp-c", temps], capture_output=True,
                                  check=False)
            self.assertEqual(done.returncode, 2, temps)

    def test_simulated_data_are_exported_only_on_demand(self):
        error = self.refusal("export", "--unreleased", "--unit", SERIAL, "--format", "blob", "-o", self.folder / "x")
        self.assertIn("--simulated", error["message"])
        self.assertFalse((self.folder / "x").exists())

    @long_test
    def test_a_link_is_followed_and_a_pipe_not_replaced(self):
        target, link, pipe = (self.folder / name for name in ("target", "link", "pipe"))
        target.write_bytes(b"old")
        link.symlink_to(target)
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", link)
        self.assertTrue(link.is_symlink())
        self.assertGreater(target.stat().st_size, 1000)
        os.mkfifo(pipe)
        reader = subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE)
        self.soak("export", "--unreleased", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", pipe)
        self.assertEqual(reader.communicate(timeout=30)[0], target.read_bytes())
        self.assertTrue(pipe.is_fifo())

    def test_export_names_the_file_and_its_hash(self):
        document = self.soak_json("export", "export", "--unreleased", "--unit", SERIAL, "--format", "c", "--simulated", "-o", self.folder / "u.h")
        self.assertEqual(document["bytes"], (self.folder / "u.h").stat().st_size)
        self.refusal("export", "--unreleased", "--unit", SERIAL, "--format", "json", "--simulated",
                                                              "--model", "9", "-o", self.folder / "x")


class Verify(FittedTest):
    def limits(self, text):
        return self.write("limits.toml", "[limits]\n" + text)

    def test_without_limits_it_informs(self):
        document = self.soak_json("verify", "verify", self.blob(), "--campaign", "verification")
        self.assertEqual(document["verdict"], "info")
        self.assertEqual(set(document["sensors"]), set(SENSORS))
        for sensor in document["sensors"].values():
            self.assertLessEqual(sensor["rmse_shape"], sensor["rmse_abs"])

    def test_passes_wide_limits_and_fails_narrow_ones(self):
        wide = self.limits("gyro = 0.2\naccel = 0.2\n")
        self.assertEqual(self.soak_json("verify", "verify", self.blob(), "--campaign", "verification", "--limits", wide)["verdict"],
                         "pass")
        narrow = self.limits("gyro = 0.2\naccel = 0.2\ngyro_y = 0.0001\n")
        done = self.soak("verify", self.blob(), "--campaign", "verification", "--limits", narrow, "--json", status=5)
        document = json.loads(done.stdout)
        self.assertEqual(document["verdict"], "fail")
        self.assertEqual([s for s, v in document["sensors"].items() if v["verdict"] == "fail"], ["gyro_y"])

    def test_a_run_that_says_little_never_passes(self):
        wide = self.limits("gyro = 0.2\naccel = 0.2\n")
        lines = (fitted_folder() / "lab" / "verification" / f"{SERIAL}.csv").read_text().splitlines()
        plateau = lines[0].split(",").index("plateau_c")
        one = [lines[0]] + [line for line in lines[1:] if line.split(",")[plateau] == "22.5"]
        path = self.write("one.csv", "\n".join(one) + "\n")
        self.soak("import", path, "--unit", SERIAL, "--campaign", "one", "--procedure", "verification", "--simulated")
        document = self.soak_json("verify", "verify", self.blob(), "--campaign", "one", "--limits", wide)
        self.assertEqual(document["verdict"], "info")
        self.assertIn("partial_range", [warning["code"] for warning in document["warnings"]])

    @long_test
    def test_takes_no_runs_for_diagnosis(self):
        with contextlib.closing(open_catalog(self.data / "station.db")) as catalog, catalog:
            catalog.execute("UPDATE run SET purpose = 'diagnosis' WHERE campaign = 'verification'")
            for key in catalog.execute("SELECT run_id, unit FROM run WHERE campaign = 'verification'").fetchall():
                catalog.execute("UPDATE run SET numbers_sha256 = ? WHERE run_id = ? AND unit = ?", (run_digest(catalog, *key), *key))
        self.refusal("verify", self.blob(), "--campaign", "verification")

    def test_refuses_numbers_of_the_catalog_that_were_changed(self):
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog, catalog:
            runs = catalog.execute("SELECT run_id, unit, numbers_sha256 FROM run").fetchall()
            self.assertEqual([digest for _, _, digest in runs], [run_digest(catalog, run_id, unit) for run_id, unit, _ in runs])
            catalog.execute("UPDATE segment SET gyro_x_mean = gyro_x_mean + 0.05")
        for arguments in (("verify", self.blob(), "--campaign", "verification"), ("fit", "--unit", SERIAL), ("runs", "verify")):
            self.assertIn(runs[0][1], self.soak(*arguments, status=4).stderr)

    def test_refuses_runs_that_the_fit_has_seen(self):
        self.refusal("verify", self.blob(), "--campaign", "campaign")

    def test_refuses_a_campaign_without_the_unit_and_bad_limits(self):
        blob = self.blob()
        self.refusal("verify", blob, "--campaign", "none")
        for text in ("gyro = -1\n", "gyrox = 1\n", "gyro = \n"):
            error = self.refusal("verify", blob, "--campaign", "verification", "--limits", self.limits(text))
            self.assertTrue(error["where"].endswith("limits.toml:2"), error)


class ChamberRecording(SoakTest):
    def test_is_fitted_by_branches_with_a_warning_of_hysteresis(self):
        folder = shared_data("thermal_chamber_cycle")
        if folder is None:
            self.skipTest("the chamber recording is not here (SOAK_TEST_DATA)")
        columns = ROOT / "procedures" / "columns" / "thermal-chamber-cycle.toml"
        self.soak("import", folder / "imu_raw_data.csv", "--columns", columns, "--unit", "C1", "--gravity-mps2", "9.806")
        fit = self.soak_json("fit", "fit", "--unit", "C1")
        gyro = fit["sensors"]["gyro_x"]
        self.assertEqual(gyro["holdout"], "branch")
        self.assertEqual(len(gyro["checks"]), 3)
        # RMS over a branch of models of the two others: a quintic and an offset for each of these, by plain least squares on the means
        # of 30 s, leave so much (about their mean).
        for check, left in zip(gyro["checks"], (0.181, 0.511, 0.483)):
            self.assertAlmostEqual(check["poly5"], left, delta=0.02)
            self.assertTrue(all(check[family] > 0.15 for family in ("anfis", "poly3", "poly5", "spline")))
        for sensor in SENSORS:
            self.assertIn("hysteresis", [warning["code"] for warning in fit["sensors"][sensor]["warnings"]])
            self.assertIsNone(fit["sensors"][sensor]["check_rmse"])
        # Each branch covers a range of its own and has its own offset (gx up to 0.75 deg/s): the curve must not step where one ends.
        for name in ("gyro_x", "gyro_y", "gyro_z"):
            points = fit["sensors"][name]["curve"]
            steps = [abs(b["bias"] - a["bias"]) / (b["temp_c"] - a["temp_c"]) for a, b in zip(points, points[1:])]
            self.assertLess(max(steps), 0.06, name)
        at_25 = min(fit["sensors"]["accel_z"]["curve"], key=lambda point: abs(point["temp_c"] - 25.0))
        self.assertAlmostEqual(at_25["bias"], 0.0, delta=0.01)


if __name__ == "__main__":
    unittest.main()
