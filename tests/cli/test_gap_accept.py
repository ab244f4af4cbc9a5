# SPDX-License-Identifier: Apache-2.0
"""`soak gap accept`, `withdraw` and `show`: an effect that soaksim-campaign hid is named, added to the model, and the gap is
smaller on runs that nothing was fitted to; file, report and later fits know of it."""
import csv
import json
import math
import os
import pathlib
import sqlite3
import sys
import unittest

import numpy as np
from soak_cli import ROOT, SoakTest, check_schema, long_test

sys.path.insert(0, str(ROOT / "tests" / "blind"))
import steep_curves  # noqa: E402
from blind_campaign import Programs, configuration  # noqa: E402

FRESH = ("R05", "R06")


def hidden(effect, seed=3):
    return {"effect": effect, "magnitude": 2.4, "seed": seed}


class Accept(SoakTest):
    def campaign(self, seed, effects, supply_off_v=0.0, *options):
        """Six runs as CSV: four to fit, two that no fit sees. The voltmeter of the supply is off by `supply_off_v`. Mean
        of the true voltage."""
        programs = Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
        config = self.write("lab.toml", configuration(programs.lab, {"kind": "identical"}, effects, []))
        programs.run("soaksim-campaign", "--out", self.folder / "csv", "--seed", seed, "--units", 1, "--config", config)
        with open(next((self.folder / "csv" / "campaign").glob("*.csv")), encoding="utf-8", newline="") as file:
            head, *rows = csv.reader(file)
        run, supply = head.index("run"), head.index("supply_v")
        volts = [float(row[supply]) for row in rows if row[supply] and row[run] not in FRESH]
        for row in rows:
            if row[supply] and supply_off_v:
                row[supply] = repr(float(row[supply]) + supply_off_v)
        for name, fresh in (("fit.csv", False), ("fresh.csv", True)):
            with open(self.folder / name, "w", encoding="utf-8", newline="") as file:
                csv.writer(file).writerows([head] + [row for row in rows if (row[run] in FRESH) == fresh])
        place = ("--unit", "SN1", "--gravity-mps2", "9.80665", *options)
        self.soak("import", self.folder / "fit.csv", *place)
        self.soak("import", self.folder / "fresh.csv", *place, "--procedure", "verification", "--campaign", "fresh")
        self.soak("fit", "--unit", "SN1", "--rules", 3)
        return sum(volts) / len(volts)

    def json(self, *arguments):
        return json.loads(self.soak(*arguments, "--json").stdout)

    def test_an_accepted_effect_closes_the_gap_on_fresh_runs(self):
        self.campaign(77, [hidden("thermal_hysteresis")])
        found = self.json("gap", "find", "--unit", "SN1")
        self.assertEqual(found["effects"][0]["name"], "thermal_hysteresis")
        accepted = self.json("gap", "accept", "--unit", "SN1")
        check_schema(accepted, "gap-accept")
        self.assertEqual((accepted["parent"], accepted["model"], accepted["not_added"]), (1, 2, []))
        term = accepted["terms"][0]
        self.assertEqual((term["name"], term["parent_version"], term["lab_only"]), ("thermal_hysteresis", 1, False))
        self.assertEqual(len(term["run_hashes"]), 4)
        self.assertEqual(len(term["parts"][0]["centre"]), 7)
        hit = found["effects"][0]["sensors"]
        self.assertEqual(sorted(sensor for part in term["parts"] for sensor in part["sensors"]), sorted(hit))

        page = self.folder / "gap.html"
        shown = self.json("gap", "show", "--unit", "SN1", "-o", page)
        check_schema(shown, "gap-show")
        self.assertEqual((shown["before"], shown["model"]), (1, 2))
        self.assertEqual([run["use"] for run in shown["runs"]].count("fresh"), 2)
        for sensor in hit:
            fresh = shown["sensors"][sensor]["fresh"]
            self.assertLess(fresh["after_rms"], fresh["before_rms"])
            self.assertGreater(fresh["closed_fraction"], 0.5, sensor)
        text = page.read_text(encoding="utf-8")
        self.assertIn("thermal_hysteresis", text)
        self.assertIn("Content-Security-Policy", text)
        self.assertEqual(text.count("<script"), 2)  # what its figures are drawn from, and what draws them

        self.assertEqual(self.json("gap", "find", "--unit", "SN1")["verdict"], "none")
        fitted = self.json("fit", "--unit", "SN1")
        check_schema(fitted, "fit")
        self.assertEqual([(t["name"], t["parent_version"]) for t in fitted["terms"]], [("thermal_hysteresis", 1)])
        report = self.json("report", "--unit", "SN1", "-o", self.folder / "report.html")
        check_schema(report, "report")
        self.assertIn("thermal_hysteresis", (self.folder / "report.html").read_text(encoding="utf-8"))
        self.assertEqual(self.kept_reports(), ["named", "named", "none"])

        withdrawn = self.json("gap", "withdraw", "--unit", "SN1", "--effect", "thermal_hysteresis", "--reason", "test",
                              "--user", "ann")
        check_schema(withdrawn, "gap-accept")
        self.assertEqual(withdrawn["terms"], [])
        self.assertEqual(self.json("gap", "find", "--unit", "SN1")["effects"][0]["name"], "thermal_hysteresis")
        error = self.refusal("gap", "withdraw", "--unit", "SN1", "--effect", "thermal_hysteresis", "--reason", "again")
        self.assertIn("'thermal_hysteresis'", error["message"])

    @long_test
    def test_the_voltmeters_certificate_moves_the_reference_voltage(self):
        # In force whenever the simulated campaign says that it was.
        self.soak("reference", "add", "--kind", "supply", "--name", "meter", "--certificate", "A", "--issued", "1990-01-01",
                  "--due", "2190-01-01", "--uncertainty", 0.02, "--correction", 0.4)
        mean_v = self.campaign(77, [hidden("supply_sensitivity")], -0.4, "--references")
        accepted = self.json("gap", "accept", "--unit", "SN1")
        term = accepted["terms"][0]
        self.assertEqual(term["name"], "supply_sensitivity")
        fitted = self.json("fit", "--unit", "SN1")
        check_schema(fitted, "fit")
        for part in term["parts"]:
            numbers = {parameter["name"]: parameter["value"] for parameter in part["parameters"]}
            # Of blocks at plateaus and of all rows; the supply wanders by 0.02 V.
            self.assertAlmostEqual(numbers["reference_v"], mean_v, delta=0.05)
            for sensor in part["sensors"]:
                line = next(p for p in fitted["sensors"][sensor]["uncertainty"] if p["name"] == "supply")
                printed = 180 / math.pi if sensor.startswith("gyro") else 1.0
                self.assertAlmostEqual(line["curve"]["max"], 0.01 * abs(numbers["per_v"]) * printed, delta=1e-12)

    def test_accepted_g_sensitivity_reaches_file_and_reading(self):
        self.campaign(81, [hidden("g_sensitivity")])
        self.assertIsNone(self.exported()["g_sensitivity_dps_per_mps2"])
        found = self.json("gap", "find", "--unit", "SN1")
        effect = found["effects"][0]
        self.assertEqual(effect["name"], "g_sensitivity")
        self.json("gap", "accept", "--unit", "SN1", "--effect", "g_sensitivity")
        matrix = self.exported()["g_sensitivity_dps_per_mps2"]
        norms = [sum(x * x for x in row) ** 0.5 for row in matrix]
        # The magnitude is that of the gyro in which it stands out most.
        self.assertTrue(any(abs(norm * 9.80665 / effect["magnitude"]["value"] - 1.0) < 1e-6 for norm in norms), norms)

    def test_a_verification_corrects_a_lag_that_the_file_carries(self):
        self.campaign(77, [hidden("sensor_lag")])
        errors = {}
        for model in ("before", "after"):
            if model == "after":
                accepted = self.json("gap", "accept", "--unit", "SN1")
                self.assertEqual([term["name"] for term in accepted["terms"]], ["sensor_lag"])
            file = self.folder / f"{model}.soakcal"
            self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", file, "--simulated")
            verified = self.json("verify", file, "--campaign", "fresh")
            check_schema(verified, "verify")
            self.assertEqual(verified["moving_terms"], ["sensor_lag"] if model == "after" else [])
            errors[model] = {name: sensor["rmse_shape"] for name, sensor in verified["sensors"].items()}
        ratios = sorted(errors["after"][name] / errors["before"][name] for name in errors["before"])
        self.assertLess(ratios[3], 0.85, ratios)
        self.assertLess(ratios[-1], 0.95, ratios)
        self.assertIn("sensor_lag", self.soak("verify", self.folder / "after.soakcal", "--campaign", "fresh").stdout)

    def test_a_device_follows_the_history_that_the_file_carries(self):
        self.campaign(77, [hidden("thermal_hysteresis", 6)])  # of a gyro, which is at rest in all positions
        shape, corrected, target = {}, {}, self.folder / "corrected.csv"
        for model in ("before", "after"):
            if model == "after":
                term, = self.json("gap", "accept", "--unit", "SN1")["terms"]
            file = self.folder / f"{model}.soakcal"
            self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", file, "--simulated")
            verified = self.json("verify", file, "--campaign", "fresh")
            check_schema(verified, "verify")
            self.assertEqual(verified["moving_terms"], ["thermal_hysteresis"] if model == "after" else [])
            shape[model] = {name: sensor["rmse_shape"] for name, sensor in verified["sensors"].items()}
            device = self.json("correct", file, FRESH[0], "--past", "cooling", "-o", target)
            check_schema(device, "correct")
            self.assertEqual(device["thermal_history"], model == "after")
            corrected[model] = {name: sensor["corrected_rms"] for name, sensor in device["sensors"].items()}
        hit = {sensor for part in term["parts"] for sensor in part["sensors"]}
        for sensor in hit:
            self.assertLess(shape["after"][sensor], 0.85 * shape["before"][sensor], sensor)
        # The report judges the same runs alike.
        report = self.json("report", "--unit", "SN1", "-o", self.folder / "report.html")["sections"]["sensors"]
        for sensor in hit:
            self.assertAlmostEqual(report[sensor]["verification"]["bias"]["rmse_shape"], shape["after"][sensor], delta=1e-6, msg=sensor)
        self.assertTrue(all(sensor.startswith("gyro") for sensor in hit), hit)
        for sensor in hit:
            # Most of what is left is the noise of 30 s.
            self.assertLess(corrected["after"][sensor], 0.92 * corrected["before"][sensor], sensor)
        self.assertEqual(device["unknown_at_end"], 0.0)
        with open(target, encoding="utf-8", newline="") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual(len(rows), device["blocks"])
        for sensor in hit:
            column = np.array([float(row[f"g{sensor[-1]}_corrected_dps"]) for row in rows])
            names = np.array([row["position"] for row in rows])
            self.assertEqual(set(names), {"+X", "-X", "+Y", "-Y", "+Z", "-Z"})
            about = np.concatenate([column[names == name] - column[names == name].mean() for name in set(names)])
            self.assertAlmostEqual(np.sqrt(np.mean(about**2)), corrected["after"][sensor], delta=1e-6)
        unknown = self.json("correct", file, FRESH[0])
        self.assertEqual((unknown["past"], unknown["file"]), ("unknown", None))
        width_c = max(parameter["value"] for part in term["parts"] for parameter in part["parameters"] if parameter["name"] == "width_c")
        temps_c = [float(row["temp_c"]) for row in rows]
        way_c = sum(abs(b - a) for a, b in zip(temps_c, temps_c[1:]))  # of means, and with turns of less than 0.5 K in it
        self.assertGreater(unknown["unknown_at_end"], 0.0)
        self.assertAlmostEqual(math.log(unknown["unknown_at_end"]), -way_c / width_c, delta=0.2 * way_c / width_c)
        self.assertIn("thermal history", self.soak("correct", file, FRESH[0]).stdout)
        self.assertIn("nobody", self.refusal("correct", file, "nobody")["message"])
        # What autopilots and firmware without it lack is told and documented.
        self.assertTrue(any("thermal_hysteresis" in note for note in
                            self.json("export", "--unreleased", "--unit", "SN1", "--format", "px4", "-o", self.folder / "px4", "--simulated")["notes"]))
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "json", "-o", self.folder / "out.json", "--simulated")
        document = json.loads((self.folder / "out.json").read_text(encoding="utf-8"))
        check_schema(document, "calibration")
        listed = next(entry for entry in document["terms"] if entry["name"] == "thermal_hysteresis")
        self.assertFalse(listed["lab_only"])
        self.assertEqual(sum(name.startswith("mean_") for name in listed["parameters"]), 14)  # seven plateaus

    @long_test
    def test_accepting_fits_what_the_model_was_fitted_to(self):
        self.campaign(77, [hidden("sensor_lag")])
        self.soak("import", self.folder / "fresh.csv", "--unit", "SN1", "--gravity-mps2", "9.80665", "--campaign", "later")
        runs = [run["run_id"] for run in self.json("runs", "list", "--unit", "SN1")["runs"] if run["run"] == "R01"]
        self.soak("runs", "void", runs[0], "--reason", "test")
        accepted = self.soak("gap", "accept", "--unit", "SN1")
        self.assertRegex(accepted.stderr, r"\b4 runs of model 1\b.*\b1\b")
        self.assertEqual(self.rules_of_models(), [3, 3])
        with sqlite3.connect(self.data / "station.db") as catalog:
            newest = json.loads(catalog.execute("SELECT document FROM model ORDER BY version DESC").fetchone()[0])
        self.assertEqual(len(newest["calibration"]["run_hashes"]), 3)

    def rules_of_models(self):
        with sqlite3.connect(self.data / "station.db") as catalog:
            rows = catalog.execute("SELECT document FROM model ORDER BY version").fetchall()
        return [json.loads(row[0])["options"]["rules"] for row in rows]

    @long_test
    def test_a_model_is_compared_with_one_without_any_effect(self):
        """Two effects, the first taken out again: the difference shown is that of the second alone."""
        self.campaign(78, [hidden("g_sensitivity"), hidden("thermal_hysteresis")])
        named = [effect["name"] for effect in self.json("gap", "find", "--unit", "SN1")["effects"]]
        self.assertEqual(sorted(named), ["g_sensitivity", "thermal_hysteresis"])
        self.soak("gap", "accept", "--unit", "SN1", "--effect", "g_sensitivity")
        self.soak("gap", "accept", "--unit", "SN1")
        refused = self.refusal("gap", "withdraw", "--unit", "SN1", "--effect", "g_sensitivity", "--reason", "")
        self.assertEqual(refused["where"], "--reason")
        self.soak("gap", "withdraw", "--unit", "SN1", "--effect", "g_sensitivity", "--reason", "a test")
        shown = self.json("gap", "show", "--unit", "SN1")
        self.assertEqual((shown["before"], shown["model"]), (1, 4))
        self.assertEqual([term["name"] for term in shown["terms"]], ["thermal_hysteresis"])

    @long_test
    def test_an_effect_has_one_size_in_one_unit_wherever_it_is_told(self):
        self.campaign(78, [hidden("g_sensitivity"), hidden("thermal_hysteresis")])
        found = self.soak("gap", "find", "--unit", "SN1").stdout
        sizes = [line.strip() for line in found.splitlines() if line.startswith(("  g_sensitivity: ", "  thermal_hysteresis: "))]
        self.assertEqual(len(sizes), 2, found)
        told = {"find": found, "accept": self.soak("gap", "accept", "--unit", "SN1").stdout}
        told["show"] = self.soak("gap", "show", "--unit", "SN1", "-o", self.folder / "gap.html").stdout
        for command in ("accept", "show"):
            for size in sizes:
                self.assertIn(size, told[command])
        self.soak("report", "--unit", "SN1", "-o", self.folder / "report.html")
        for page in ("gap.html", "report.html"):
            told[page] = (self.folder / page).read_text(encoding="utf-8")
        for where, text in told.items():
            self.assertNotIn("rad/s", text, where)
            self.assertIn("deg/s", text, where)

    @long_test
    def test_without_a_fresh_run_it_says_that_nothing_is_proved(self):
        self.campaign(77, [hidden("thermal_hysteresis")])
        self.soak("gap", "accept", "--unit", "SN1")
        fitted = next(run["campaign"] for run in self.json("runs", "list", "--unit", "SN1")["runs"] if run["run"] == "R01")
        shown = self.soak("gap", "show", "--unit", "SN1", "--campaign", fitted).stdout
        self.assertIn("--procedure verification", shown)

    def bumpy_unit(self):
        """Three runs of a unit with a resonance at 45 degC in its gyros, and two fresh ones at temperatures between the
        plateaus of these; accel_y puts out steps."""
        bump = steep_curves.Bump(30.0, 4.0, 45.0, (0, 1, 2))
        place = ("--unit", "SN1", "--gravity-mps2", "9.80665")
        between_c = steep_curves.PLATEAUS_C[:-1] + 2.5
        fresh = ("--procedure", "verification", "--campaign", "fresh")
        for name, plateaus_c, runs, options in (("fit", steep_curves.PLATEAUS_C, 3, ()), ("fresh", between_c, 2, fresh)):
            csv = self.folder / f"{name}.csv"
            steep_curves.write_campaign(csv, 2, "smooth", bump, runs, plateaus_c)
            head, *rows = csv.read_text(encoding="utf-8").splitlines()
            coarse = head.split(",").index("ay_mps2")
            cells = [row.split(",") for row in rows]
            for row in cells:
                row[coarse] = f"{0.01 * round(float(row[coarse]) / 0.01):.2f}"
            csv.write_text("\n".join([head] + [",".join(row) for row in cells]) + "\n", encoding="utf-8")
            self.soak("import", csv, *place, *options)
        self.soak("fit", "--unit", "SN1", "--rules", 3)
        return steep_curves.make_curves(2, "smooth", bump)

    def bias_at(self, name, sensor, *temps_c):
        """What the runtime reads out of the unit's newest file."""
        file = self.folder / name
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", file)
        listed = ",".join(str(temp_c) for temp_c in temps_c)
        points = self.json("eval", file, "--temp-c", listed)["points"]
        return np.array([point["bias"][sensor] for point in points])

    def error_of(self, name, truth, temps_c):
        """RMS of the newest file's curve of gyro_y about the truth, but for the offset of the power-ons."""
        off = self.bias_at(name, "gyro_y", *temps_c) - truth(temps_c)[:, 1]
        return float(np.sqrt(np.mean((off - np.median(off)) ** 2)))

    def test_a_bump_goes_all_the_way_into_the_deployed_curve(self):
        truth = self.bumpy_unit()
        found = self.json("gap", "find", "--unit", "SN1")
        effects = {effect["name"]: effect for effect in found["effects"]}
        self.assertEqual(sorted(effects), ["narrow_bump", "quantization"])
        hit = effects["narrow_bump"]["sensors"]
        temps_c = np.arange(-29.0, 69.5, 0.5)
        before = self.error_of("before.soakcal", truth, temps_c)
        accepted = self.json("gap", "accept", "--unit", "SN1")
        check_schema(accepted, "gap-accept")
        self.assertEqual(accepted["not_added"], [])
        term, = (term for term in accepted["terms"] if term["name"] == "narrow_bump")
        self.assertEqual((term["lab_only"], sorted(s for part in term["parts"] for s in part["sensors"])), (False, sorted(hit)))

        fitted = self.json("fit", "--unit", "SN1")
        check_schema(fitted, "fit")
        # The curve that was stiff before follows the resonance between the plateaus as well, as far as these tell its width.
        self.assertLess(self.error_of("after.soakcal", truth, temps_c), 0.75 * before)
        shown = self.json("gap", "show", "--unit", "SN1")
        check_schema(shown, "gap-show")
        for sensor in hit:
            fresh = shown["sensors"][sensor]["fresh"]
            self.assertLess(fresh["after_rms"], 0.75 * fresh["before_rms"], sensor)
            self.assertGreater(fresh["closed_fraction"], 0.5, sensor)
        again = self.json("gap", "find", "--unit", "SN1")
        self.assertEqual(again["verdict"], "none", again["reason"])
        shape = {}
        for file in ("before", "after"):
            verified = self.json("verify", self.folder / f"{file}.soakcal", "--campaign", "fresh")
            check_schema(verified, "verify")
            shape[file] = verified["sensors"]["gyro_y"]["rmse_shape"]
        self.assertLess(shape["after"], 0.75 * shape["before"])

    @long_test
    def test_an_export_that_cannot_hold_a_bump_says_so(self):
        self.bumpy_unit()
        self.soak("gap", "accept", "--unit", "SN1", "--effect", "narrow_bump")
        for form in ("px4", "ardupilot"):
            notes = self.json("export", "--unreleased", "--unit", "SN1", "--format", form, "-o", self.folder / form)["notes"]
            self.assertEqual(sum("narrow_bump" in note for note in notes), 1, notes)
        target = self.folder / "out.json"
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "json", "-o", target)
        document = json.loads(target.read_text(encoding="utf-8"))
        check_schema(document, "calibration")
        self.assertIn("narrow_bump", [term["name"] for term in document["terms"]])
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "c", "-o", self.folder / "cal.h")

    def test_nothing_is_accepted_that_was_not_named(self):
        self.campaign(90, [])
        self.assertIn("'none'", self.refusal("gap", "accept", "--unit", "SN1")["message"])

    def exported(self):
        target = self.folder / "out.json"
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "json", "-o", target, "--simulated")
        document = json.loads(target.read_text(encoding="utf-8"))
        check_schema(document, "calibration")
        return document

    def kept_reports(self):
        with sqlite3.connect(self.data / "station.db") as catalog:
            rows = catalog.execute("SELECT document FROM gap_report ORDER BY rowid").fetchall()
        return [json.loads(row[0])["verdict"] for row in rows]


if __name__ == "__main__":
    unittest.main()
