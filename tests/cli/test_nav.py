# SPDX-License-Identifier: Apache-2.0
"""soak nav: outages on a recording made from plain formulas, on simulated drives and on a real drive; eq. 6.5 and 6.6 from a unit's own
curve."""
import json
import math
import random
import re
import shutil
import unittest

from drive_files import write_drive, write_rtklib
from soak_cli import SoakTest, long_test, recording, shared_data

REAL_DRIVE = """name = "car"
lever_arm_m = [-0.05, 0.0, 0.0]
[imu]
file = "{folder}/imu_1934.csv"
columns = ["ax_g", "ay_g", "az_g", "gx_dps", "gy_dps", "gz_dps", "t_ms"]
start_s = 1752003261.854
clock_ratio = 1.000292
offset_s = -0.125
axes = ["y", "-x", "z"]
mounting_deg = [5.35, -6.79, 0.0]
[gnss]
file = "{folder}/gnss_1934_sf.pos"
every = 4
least_sigma_m = 0.05
"""


def by_name(document):
    return {pipeline["name"]: pipeline for pipeline in document["pipelines"]}


class Outages(SoakTest):
    def test_a_straight_way_stays_straight(self):
        """The formulas of the recording share nothing with the filter. 0.02 deg/s of noise at 50 Hz turn the heading by 0.015 deg in 30 s;
        what fixes of 2 cm and 3 cm/s leave unknown is a tilt of some 0.2 mrad, 1 m in 30 s."""
        drive = write_drive(self.folder)
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 3)
        self.assertEqual(len(document["outages"]), 3)
        for outage in document["outages"]:
            self.assertAlmostEqual(outage["distance_m"], 290, delta=11)
            for errors in outage["errors"].values():
                self.assertLess(errors["horizontal_final_m"], 2.0)
        self.assertIsNone(by_name(document)["raw"]["gain"]["ci95"])

    @long_test
    def test_the_number_of_threads_changes_nothing(self):
        drive = write_drive(self.folder)
        documents = [self.soak_json("nav-outages", "nav", "outages", drive, "--number", 4, "--jobs", jobs) for jobs in (1, 2)]
        self.assertEqual(*documents)

    @long_test
    def test_fixes_of_rtklib_are_read_as_those_of_csv(self):
        drive = write_drive(self.folder, start_s=1752003000)
        of_csv = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 2)
        write_rtklib(self.folder / "fixes.csv", self.folder / "fixes.pos", "2025/07/08 19:30:00.000")
        drive.write_text(drive.read_text(encoding="utf-8").replace("fixes.csv", "fixes.pos"), encoding="utf-8")
        of_rtklib = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 2)
        self.assertEqual(of_csv, of_rtklib)

    def test_a_byte_order_mark_and_line_ends_of_windows_change_nothing(self):
        drive = write_drive(self.folder)
        plain = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 1)
        for name in ("imu.csv", "fixes.csv"):
            text = (self.folder / name).read_text(encoding="utf-8")
            self.write(name, b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
        self.assertEqual(self.soak_json("nav-outages", "nav", "outages", drive, "--number", 1), plain)

    def test_a_wrong_row_is_refused_with_its_line(self):
        drive = write_drive(self.folder, seconds=40)
        path = self.folder / "imu.csv"
        lines = path.read_text(encoding="utf-8").splitlines()
        lines[7] = lines[7].replace(",", ",x", 1)
        path.write_text("\n".join(lines), encoding="utf-8")
        error = self.refusal("nav", "outages", drive)
        self.assertIn("imu.csv, line 8", error["where"])

    def test_a_drive_file_that_is_wrong_is_refused_with_its_lines(self):
        drive = write_drive(self.folder, seconds=40)
        text = drive.read_text(encoding="utf-8")
        drive.write_text(text.replace('"-y", "x", "z"', '"y", "x", "z"').replace("[gnss]", "[gnss]\nevery = 0"), encoding="utf-8")
        error = self.refusal("nav", "outages", drive)
        self.assertIn("drive.toml:4", error["message"])
        self.assertIn("drive.toml:6", error["message"])

    def test_a_clock_ratio_without_a_start_is_refused(self):
        drive = write_drive(self.folder, seconds=40)
        text = drive.read_text(encoding="utf-8")
        drive.write_text(text.replace("axes =", "clock_ratio = 1.0003\naxes ="), encoding="utf-8")
        error = self.refusal("nav", "outages", drive)
        self.assertIn("drive.toml:4", error["where"])
        self.assertIn("start_s", error["message"])

    def test_two_columns_of_a_sensor_are_refused_with_their_names(self):
        drive = write_drive(self.folder, seconds=40)
        path = self.folder / "imu.csv"
        header, *rows = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join([header + ",gx_rps", *(row + ",0" for row in rows)]), encoding="utf-8")
        error = self.refusal("nav", "outages", drive)
        self.assertIn("'gx_dps' and 'gx_rps'", error["message"])
        self.assertIn("imu.csv", error["where"])

    def test_readings_that_cannot_be_and_gaps_are_refused_with_the_sample(self):
        drive = write_drive(self.folder, seconds=40)
        path = self.folder / "imu.csv"
        lines = path.read_text(encoding="utf-8").splitlines()
        cells = lines[7].split(",")
        self.write("imu.csv", "\n".join([*lines[:7], ",".join([cells[0], "1e200", *cells[2:]]), *lines[8:]]))
        self.assertIn("sample 7: rates must", self.refusal("nav", "outages", drive)["message"])
        self.write("imu.csv", "\n".join(lines[:7] + lines[17:]))
        self.assertIn("sample 7: comes 0.220 s after", self.refusal("nav", "outages", drive)["message"])

    # Of 20 s without fixes, but for 2 s at both ends.
    UNKNOWN_S = (171, 188)

    def errors_judged_by(self, truth):
        """Errors along east and north at the end of the outages whose end both truths know, and the drive's truth in the document. `truth`:
        what [truth] holds."""
        drive = self.write("judged.toml", (self.folder / "drive.toml").read_text(encoding="utf-8") + f"[truth]\n{truth}\n")
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 12)
        known = [outage for outage in document["outages"] if not self.UNKNOWN_S[0] < outage["end_s"] < self.UNKNOWN_S[1]]
        ends = [outage["errors"]["raw"]["position_final_m"] for outage in known]
        return [end[axis] for end in ends for axis in ("east", "north")], document["drives"][0]["truth"]

    def write_noisy_drive(self):
        """Fixes that are wrong by 1 m, and none for 20 s; exact.csv holds those of the formulas."""
        write_drive(self.folder, seconds=240)
        shutil.copy(self.folder / "fixes.csv", self.folder / "exact.csv")
        header, *rows = (self.folder / "fixes.csv").read_text(encoding="utf-8").splitlines()
        noise = random.Random(5)
        for i, row in enumerate(rows):
            cells = row.split(",")
            cells[1] = f"{float(cells[1]) + noise.gauss(0, 1) / 111252:.12f}"
            cells[2] = f"{float(cells[2]) + noise.gauss(0, 1) / 70197:.12f}"
            rows[i] = ",".join([*cells[:4], "1", "1", "1", *cells[7:]])
        self.write("fixes.csv", "\n".join([header, *rows[:170], *rows[190:]]) + "\n")

    def test_a_smoothed_truth_is_as_good_as_it_says_and_better_than_the_fixes(self):
        """The formulas of the recording judge it. The antenna goes straight: the fixes are the same where it lies 3 m before the unit."""
        self.write_noisy_drive()
        drive = self.folder / "drive.toml"
        for lever in ("", "lever_arm_m = [0.0, 3.0, 0.0]\n"):
            with self.subTest(lever):
                drive.write_text(lever + drive.read_text(encoding="utf-8"), encoding="utf-8")
                self.expect_a_smoothed_truth_as_good_as_it_says()

    def expect_a_smoothed_truth_as_good_as_it_says(self):
        exact, of_file = self.errors_judged_by('file = "exact.csv"')
        smoothed, of_smoother = self.errors_judged_by("smoothed = true")
        self.assertEqual((of_file["from"], of_smoother["from"]), ("file", "smoother"))
        # Of 20 numbers the root mean square lies within 40 % by chance alone, and more as neighbours in time depend on each other.
        per_axis = of_smoother["horizontal_sigma_m"] / math.sqrt(2)
        truth_error = math.sqrt(sum((a - b) ** 2 for a, b in zip(exact, smoothed)) / len(exact))
        self.assertLess(truth_error, 2 * per_axis)
        self.assertGreater(truth_error, per_axis / 3)
        self.assertLess(truth_error, 0.5)

    @long_test
    def test_how_well_a_smoothed_truth_is_known_does_not_depend_on_where_the_unit_lies(self):
        """On a straight way fixes of the antenna say as much of it wherever the unit is; of the unit they say less the further away it is."""
        self.write_noisy_drive()
        drive = self.folder / "drive.toml"
        _, beside = self.errors_judged_by("smoothed = true")
        drive.write_text("lever_arm_m = [0.0, 3.0, 0.0]\n" + drive.read_text(encoding="utf-8"), encoding="utf-8")
        _, away = self.errors_judged_by("smoothed = true")
        self.assertAlmostEqual(away["horizontal_sigma_m"], beside["horizontal_sigma_m"], delta=0.02 * beside["horizontal_sigma_m"])

    @long_test
    def test_an_outage_in_a_gap_of_the_receiver_is_refused_with_a_smoothed_truth_too(self):
        """From 140 to 189 s there are no fixes: what a smoother says there is the filter's own word."""
        drive = write_drive(self.folder, seconds=240)
        header, *rows = (self.folder / "fixes.csv").read_text(encoding="utf-8").splitlines()
        self.write("fixes.csv", "\n".join([header, *rows[:140], *rows[190:]]) + "\n")
        in_the_gap = ("--number", 1, "--first-s", 145, "--length-s", 30)
        error = self.refusal("nav", "outages", drive, *in_the_gap)
        self.assertIn("no truth lies in the outage", error["message"])
        drive.write_text(drive.read_text(encoding="utf-8") + "[truth]\nsmoothed = true\n", encoding="utf-8")
        self.assertEqual(self.refusal("nav", "outages", drive, *in_the_gap), error)

    def test_a_page_that_cannot_be_written_is_refused_before_the_outages(self):
        """The drive is too short for an outage, which is found before the first one runs."""
        drive = write_drive(self.folder, seconds=100)
        self.assertEqual(self.refusal("nav", "outages", drive)["where"], "straight")
        error = self.refusal("nav", "outages", drive, "-o", self.folder / "none" / "page.html")
        self.assertIn("cannot create the file", error["message"])
        self.assertIn("none/page.html", error["where"])
        self.refusal("nav", "outages", drive, "-o", self.folder / "page.html")
        self.assertFalse((self.folder / "page.html").exists())

    def test_a_truth_from_a_file_and_smoothed_is_refused(self):
        drive = write_drive(self.folder, seconds=40)
        text = drive.read_text(encoding="utf-8")
        drive.write_text(text + '[truth]\nfile = "fixes.csv"\nsmoothed = true\n', encoding="utf-8")
        error = self.refusal("nav", "outages", drive)
        self.assertIn("drive.toml:9", error["where"])
        self.assertIn("'file'", error["message"])

    def changed_fixes(self, change):
        """Runs the fixes of the drive through change(index, cells)."""
        header, *rows = (self.folder / "fixes.csv").read_text(encoding="utf-8").splitlines()
        changed = [",".join(change(i, row.split(","))) for i, row in enumerate(rows)]
        self.write("fixes.csv", "\n".join([header, *changed]) + "\n")

    @long_test
    def test_fixes_that_are_wrong_by_what_they_say_have_the_median_of_chi_squared(self):
        """The median of chi-squared with 3 degrees of freedom is 2.37; of 165 draws it scatters by 0.17, one standard deviation."""
        drive = write_drive(self.folder)
        noise = random.Random(9)

        def with_noise(_, cells):
            for cell, sigma in ((1, 1 / 111252), (2, 1 / 70197), (3, 1), (7, 0.3), (8, 0.3), (9, 0.3)):
                cells[cell] = f"{float(cells[cell]) + noise.gauss(0, sigma):.12f}"
            return [*cells[:4], "1", "1", "1", *cells[7:10], "0.3", "0.3", "0.3"]

        self.changed_fixes(with_noise)
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 1)
        fixes = document["drives"][0]["fixes"]
        self.assertEqual(fixes["number"], 200 - 32)  # from the first that is faster than 3 m/s
        for what in ("position", "velocity"):
            self.assertAlmostEqual(fixes[what]["median_nis"], 2.37, delta=3 * 0.17)
            self.assertEqual(fixes[what]["left_out"], 0)
        self.changed_fixes(lambda _, cells: [*cells[:4], "0.2", "0.2", "0.2", *cells[7:]])
        too_sure = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 1)["drives"][0]["fixes"]["position"]
        self.assertGreater(too_sure["median_nis"], 5 * 2.37)
        self.assertGreater(too_sure["left_out"], 10)

    @long_test
    def test_fixes_that_jump_and_stay_there_are_believed_after_ten(self):
        """As where a receiver was wrong before: a filter that left out all of them would stay 100 m away for the rest of the drive."""
        drive = write_drive(self.folder)
        self.changed_fixes(lambda i, cells: [*cells[:2], f"{float(cells[2]) + (100 / 70197 if i >= 80 else 0):.12f}", *cells[3:]])
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 1, "--first-s", 160)
        self.assertGreaterEqual(document["drives"][0]["fixes"]["position"]["left_out"], 10)
        self.assertLess(document["outages"][0]["errors"]["raw"]["horizontal_final_m"], 50)

    def test_a_drive_that_is_too_short_is_refused(self):
        error = self.refusal("nav", "outages", write_drive(self.folder, seconds=100))
        self.assertEqual(error["where"], "straight")

    def test_a_calibration_without_temperatures_is_refused(self):
        drive = write_drive(self.folder, seconds=100)
        self.assertIn("temp_c", self.refusal("nav", "outages", drive, "--calibration", "none.soakcal")["message"])

    def drive_with_a_thermal_bias(self):
        """On gx what recording() has: 0.1 deg/s + 0.01 deg/s/K, over 0 to 40 degC in 200 s."""
        drive = write_drive(self.folder, temp_c=lambda t: 0.2 * t)
        header, *rows = (self.folder / "imu.csv").read_text(encoding="utf-8").splitlines()
        gx, temp = (header.split(",").index(name) for name in ("gx_dps", "temp_c"))
        for i, row in enumerate(rows):
            cells = row.split(",")
            cells[gx] = str(float(cells[gx]) + 0.1 + 0.01 * float(cells[temp]))
            rows[i] = ",".join(cells)
        self.write("imu.csv", "\n".join([header, *rows]) + "\n")
        return drive

    def calibration_file(self, without=""):
        """Of a fit to recording(), without the columns that begin with `without`."""
        header, *rows = recording(plateaus=(0.0, 20.0, 40.0)).splitlines()
        kept = [i for i, name in enumerate(header.split(",")) if not (without and name.startswith(without))]
        text = "\n".join(",".join(line.split(",")[i] for i in kept) for line in [header, *rows]) + "\n"
        self.soak("import", self.write("R.csv", text), "--unit", "SN1", "--campaign", "c", "--gravity-mps2", 9.80665)
        self.soak("fit", "--unit", "SN1")
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", self.folder / "unit.soakcal")
        return self.folder / "unit.soakcal"

    def expect_the_bias_of_gx_gone(self, drive, calibration, uncorrected):
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 3, "--calibration", calibration)
        self.assertEqual(document["uncorrected"], uncorrected)
        raw, calibrated = (by_name(document)[name]["horizontal_final_m"]["value"] for name in ("raw", "calibrated"))
        # 0.06 deg/s of change in 30 s that the filter does not foresee: g w t^4/24 with w = 0.002 deg/s/s is 11.5 m.
        self.assertGreater(raw, 4.0)
        self.assertLess(calibrated, 2.0)

    def test_a_full_calibration_takes_a_thermal_bias_away(self):
        self.expect_the_bias_of_gx_gone(self.drive_with_a_thermal_bias(), self.calibration_file(), [])

    def test_readings_outside_the_calibration_are_told_with_their_share(self):
        drive, calibration = write_drive(self.folder, temp_c=lambda t: 0.5 * t), self.calibration_file()  # 0 to 100 degC, known to 40
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 1, "--calibration", calibration)
        self.assertAlmostEqual(document["outside_calibration"][0]["share"], 0.6, delta=0.03)
        self.assertIn("outside the calibration", self.soak("nav", "outages", drive, "--number", 1, "--calibration", calibration).stdout)

    @long_test
    def test_outages_that_overlap_are_told(self):
        drive = write_drive(self.folder, seconds=200)
        for number, overlap in ((2, False), (8, True)):
            document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", number, "--first-s", 100)
            self.assertEqual(document["outages_overlap"], overlap)

    @long_test
    def test_a_calibration_of_the_gyros_alone_corrects_these_and_says_what_stays_raw(self):
        drive, calibration = self.drive_with_a_thermal_bias(), self.calibration_file(without="a")
        self.expect_the_bias_of_gx_gone(drive, calibration, ["accel_x", "accel_y", "accel_z"])
        text = self.soak("nav", "outages", drive, "--number", 1, "--calibration", calibration).stdout
        self.assertIn("does not correct accel_x, accel_y, accel_z", text)

    def test_an_anfis_without_drives_to_learn_from_is_refused(self):
        drive = write_drive(self.folder)
        error = self.refusal("nav", "outages", drive, "--also", "anfis_updates")
        self.assertEqual(error["where"], "--also")
        self.assertIn("--learn FILE.toml", error["message"])

    def test_drives_to_learn_from_without_an_anfis_are_refused(self):
        error = self.refusal("nav", "outages", write_drive(self.folder), "--also", "wmra", "--learn", "none.toml")
        self.assertEqual(error["where"], "--learn")
        self.assertIn("--also anfis_position", error["message"])

    def test_drives_too_short_to_learn_from_are_refused_with_what_they_hold(self):
        drive = write_drive(self.folder)
        error = self.refusal("nav", "outages", drive, "--also", "anfis_position", "--learn", drive)
        self.assertEqual(error["where"], "straight")
        # From 65 s, half a minute after the start of the filter, to 200 s.
        self.assertIn("4 artificial outages of 30 s", error["message"])

    def test_a_real_drive(self):
        folder = shared_data("drive_rtk")
        if folder is None:
            self.skipTest("the recorded drive is not here")
        drive = self.write("real.toml", REAL_DRIVE.format(folder=folder))
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 6, "--first-s", 100)
        pipelines = by_name(document)
        # Without aids a MEMS unit loses tens to hundreds of metres in 30 s [AH05 table 7.2]; less than 1 m would be a leak of the truth.
        self.assertGreater(pipelines["raw"]["horizontal_final_m"]["value"], 5.0)
        self.assertLess(pipelines["raw"]["horizontal_final_m"]["value"], 300.0)
        self.assertGreater(pipelines["physics"]["gain"]["value"], 0.5)
        self.assertGreater(pipelines["physics"]["horizontal_final_m"]["value"], 0.5)
        self.assertGreater(max(outage["distance_m"] for outage in document["outages"]), 100.0)

    def test_an_anfis_makes_no_outage_of_a_real_drive_worse(self):
        folder = shared_data("drive_rtk")
        if folder is None:
            self.skipTest("the recorded drive is not here")
        drive = self.write("real.toml", REAL_DRIVE.format(folder=folder))
        names = ("anfis_position", "anfis_updates")
        also = [argument for name in names for argument in ("--also", name)]
        document = self.soak_json("nav-outages", "nav", "outages", drive, "--number", 12, "--learn", drive, *also)
        self.assertEqual(document["learnt_and_judged"], [str(drive)])
        for outage in document["outages"]:
            errors = outage["errors"]
            for name in names:
                # Belief from one standard error made 47 m of 25 m in one of the twelve.
                self.assertLess(errors[name]["horizontal_final_m"], 1.1 * errors["raw"]["horizontal_final_m"] + 0.5)


class Pages(SoakTest):
    def page_of(self, *arguments):
        """The words of a page, and what its figures are drawn from."""
        path = self.folder / "page.html"
        self.soak(*arguments, "-o", path)
        text = path.read_text(encoding="utf-8")
        return text, json.loads(re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)[1])

    @long_test
    def test_a_line_has_300_points_at_most_and_keeps_its_last(self):
        """A smoothed truth has four points a second."""
        drive = write_drive(self.folder)
        drive.write_text(drive.read_text(encoding="utf-8") + "[truth]\nsmoothed = true\n", encoding="utf-8")
        _, short = self.page_of("nav", "outages", drive, "--number", 1, "--length-s", 60, "--first-s", 60)
        _, long = self.page_of("nav", "outages", drive, "--number", 1, "--length-s", 120, "--first-s", 60)
        self.assertEqual(len(short["outages"][0]["truth"]), 240)
        (outage,) = long["outages"]
        for line in (outage["truth"], *outage["tracks"], *outage["errors"], *long["mean"]):
            self.assertLessEqual(len(line), 300)
        self.assertEqual(len(outage["truth"]), 300)
        self.assertAlmostEqual(outage["truth"][-1][1], 1200, delta=5)
        for errors, mean in zip(outage["errors"], long["mean"]):
            self.assertAlmostEqual(errors[-1][0], 120, delta=0.25)
            self.assertEqual(mean[-1], [120, errors[-1][1]])

    @long_test
    def test_the_mean_error_begins_where_the_first_truth_is(self):
        """With the fixes for truth, one each second: 0.98 s after an outage that begins with a sample at 120.02 s."""
        _, data = self.page_of("nav", "outages", write_drive(self.folder), "--number", 1)
        for errors, mean in zip(data["outages"][0]["errors"], data["mean"]):
            self.assertEqual(mean[0], [1, errors[0][1]])
            self.assertEqual(mean[-1], [30, errors[-1][1]])

    def test_the_page_of_a_comparison_says_what_is_simulated(self):
        text, _ = self.page_of("nav", "compare", "--drives", 1, "--number", 1, "--errors", "isi", "--temp-end-c", 40, "--left-percent", 2)
        self.assertIn("Simulated drives, errors of isi, from -10 to 40 °C; the calibration leaves 2 %.", text)

    @long_test
    def test_the_page_of_an_impact_says_of_which_unit_and_model(self):
        text = recording(1, "R1", (-20.0, 0.0, 20.0, 40.0), 30)
        self.soak("import", self.write("R1.csv", text), "--unit", "SN1", "--campaign", "c", "--gravity-mps2", 9.80665)
        self.soak("fit", "--unit", "SN1")
        text, _ = self.page_of("nav", "impact", "--unit", "SN1", "--drives", 1, "--number", 1, "--from-c", -15, "--to-c", 35)
        self.assertIn("Simulated drives with the curves of unit SN1, model 1, from -15.0 to 35.0 °C; other errors of ahrs400ca.", text)


class Compare(SoakTest):
    def test_a_calibration_pays_over_a_ramp_of_temperature(self):
        document = self.soak_json("nav-outages", "nav", "compare", "--drives", 2, "--number", 4, "--errors", "isi")
        pipelines = by_name(document)
        self.assertEqual(list(pipelines), ["raw", "calibrated", "physics"])
        self.assertEqual(pipelines["raw"]["gain"]["value"], 0.0)
        self.assertGreater(pipelines["calibrated"]["gain"]["value"], 0.2)
        self.assertGreater(pipelines["physics"]["gain"]["value"], pipelines["calibrated"]["gain"]["value"])
        self.assertEqual(document["simulated"]["errors"], "isi")

    def test_the_pipelines_of_the_thesis_come_where_they_are_asked_for(self):
        document = self.soak_json("nav-outages", "nav", "compare", "--drives", 1, "--number", 1, "--errors", "isi",
                                  "--also", "anfis_position", "--also", "wmra_batch", "--also", "wmra")
        pipelines = by_name(document)
        self.assertEqual(list(pipelines), ["raw", "calibrated", "physics", "wmra", "wmra_batch", "anfis_position"])
        self.assertIn("LOOKS AHEAD", pipelines["wmra_batch"]["description"])
        errors = document["outages"][0]["errors"]
        # 30 s of a MEMS unit lose metres; wavelets take off what averages out anyway.
        self.assertAlmostEqual(errors["wmra"]["horizontal_final_m"], errors["raw"]["horizontal_final_m"], delta=1.0)
        self.assertNotEqual(errors["wmra"], errors["raw"])


class Impact(SoakTest):
    def test_free_inertial_errors_are_those_of_the_curve(self):
        """recording(): the bias of gx rises by 0.01 deg/s per kelvin, that of the others does not."""
        for number in (1, 2, 3):
            text = recording(number, f"R{number}", (-20.0, 0.0, 20.0, 40.0), 30)
            self.soak("import", self.write(f"R{number}.csv", text), "--unit", "SN1", "--campaign", "c", "--gravity-mps2", 9.80665)
        self.soak("fit", "--unit", "SN1")
        document = self.soak_json("nav-impact", "nav", "impact", "--unit", "SN1", "--drives", 1, "--number", 5, "--from-c", -15, "--to-c", 35)
        sensors = {sensor["sensor"]: sensor for sensor in document["free_inertial"]}
        change = sensors["gyro_x"]["change"]
        self.assertAlmostEqual(change, 0.5, delta=0.05)
        for seconds in (30, 60):
            metres = sensors["gyro_x"][f"after_{seconds}_s_m"]
            self.assertAlmostEqual(metres["without"], math.radians(change) * 9.80665 * seconds ** 3 / 6, delta=1e-6 * metres["without"])
            # power-on constant removed: at least 98 % less for a gyro curve of 0.5 deg/s
            self.assertLess(metres["with"], 0.02 * metres["without"])
        self.assertLess(sensors["gyro_y"]["change"], 0.05)
        accel = sensors["accel_x"]
        self.assertAlmostEqual(accel["after_60_s_m"]["without"], 0.5 * accel["change"] * 3600, delta=1e-6)
        self.assertEqual([pipeline["name"] for pipeline in document["drive"]["pipelines"]], ["raw", "calibrated", "physics"])

    def fitted_with_slopes(self, slopes_dps_per_k):
        """A run for each slope: that of gy over temperature, which is 0 in recording()."""
        for number, slope in enumerate(slopes_dps_per_k):
            header, *rows = recording(number, f"R{number}", (-20.0, 0.0, 20.0, 40.0), 30).splitlines()
            gy, temp = (header.split(",").index(name) for name in ("gy_dps", "temp_c"))
            for i, row in enumerate(rows):
                cells = row.split(",")
                cells[gy] = str(float(cells[gy]) + slope * float(cells[temp]))
                rows[i] = ",".join(cells)
            text = "\n".join([header, *rows]) + "\n"
            self.soak("import", self.write(f"R{number}.csv", text), "--unit", "SN1", "--campaign", "c", "--gravity-mps2", 9.80665)
        self.soak("fit", "--unit", "SN1")

    IMPACT = ("nav", "impact", "--unit", "SN1", "--drives", 1, "--number", 1, "--from-c", -15, "--to-c", 35)

    @long_test
    def test_what_is_left_holds_the_scatter_of_slopes_between_power_ons(self):
        sigma = 0.002
        unit_scatter = [x / math.sqrt(14) for x in (-5, -3, -1, 1, 3, 5)]  # standard deviation 1, mean 0
        self.fitted_with_slopes([sigma * x for x in unit_scatter])
        document = self.soak_json("nav-impact", *self.IMPACT)
        self.assertEqual(document["warnings"], [])
        sensor = {sensor["sensor"]: sensor for sensor in document["free_inertial"]}["gyro_y"]
        self.assertEqual(sensor["left_interval"], "pi95")
        # From -15 to 35 degC the bias of the next power-on moves by 50 K times its slope.
        truth_95 = 1.96 * sigma * 50
        self.assertGreater(sensor["left"], truth_95)
        self.assertLess(sensor["left"], 4 * truth_95)
        for seconds in (30, 60):
            truth_m = math.radians(truth_95) * 9.80665 * seconds ** 3 / 6
            self.assertGreater(sensor[f"after_{seconds}_s_m"]["with"], truth_m)

    @long_test
    def test_a_model_of_one_run_says_that_the_scatter_is_unknown(self):
        self.fitted_with_slopes([0.0])
        document = self.soak_json("nav-impact", *self.IMPACT)
        self.assertEqual([warning["code"] for warning in document["warnings"]], ["one_run"])
        self.assertEqual({sensor["left_interval"] for sensor in document["free_inertial"]}, {"ci95"})
        self.assertIn("how the curve of the next power-on scatters is not known", self.soak(*self.IMPACT).stderr)

    def test_a_unit_without_a_model_is_refused(self):
        self.imported("R1.csv", recording(), "--campaign", "c")
        self.assertIn("soak fit", self.refusal("nav", "impact", "--unit", "SN1")["message"])


if __name__ == "__main__":
    unittest.main()
