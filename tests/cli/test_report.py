# SPDX-License-Identifier: Apache-2.0
"""soak report, as a user calls it: the page against the fit's own numbers, the deployed file and the records."""
import hashlib
import html.parser
import json
import math
import os
import random
import re
import sqlite3
import subprocess
import unittest

import test_fit
from run_digest import open_catalog
from soak_cli import HEADER, ROOT, SoakTest, check_schema, long_test, shared_data
from test_fit import SENSORS, SERIAL

tearDownModule = test_fit.tearDownModule
VOID = {"meta", "link", "br"}
FAMILIES = ["anfis", "poly3", "poly5", "spline"]


class Page(html.parser.HTMLParser):
    """What a page holds: tables by caption, as rows of cells; a cell is its text, or the number of its <data> element."""

    def __init__(self, text):
        super().__init__()
        self.source, self.open, self.tags, self.ids, self.tables, self.text = text, [], [], [], {}, ""
        self.section, self.sections = None, {}  # tables by the id of their section
        self.attributes = []
        self.caption = self.cell = None
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.tags.append(tag)
        self.attributes.extend(attributes.items())
        if "id" in attributes:
            self.ids.append(attributes["id"])
        if tag == "section":
            self.section = attributes.get("id")
        if tag in VOID:
            return
        self.open.append(tag)
        if tag == "caption":
            self.caption = ""
        elif tag == "tr" and "tbody" in self.open:
            self.tables[self.caption].append([])
        elif tag in ("td", "th") and "tbody" in self.open:
            self.cell = []
        elif tag == "data" and self.cell is not None:
            self.cell.append(float(attributes["value"]))

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open}"
        self.open.pop()
        if tag == "caption":
            while self.caption in self.tables:  # six sensors have tables of one caption
                self.caption += "'"
            self.tables[self.caption] = []
            self.sections.setdefault(self.section, []).append(self.tables[self.caption])
        elif tag in ("td", "th") and self.cell is not None:
            numbers = [part for part in self.cell if isinstance(part, float)]
            text = "".join(part for part in self.cell if isinstance(part, str))
            self.tables[self.caption][-1].append(numbers[0] if len(numbers) == 1 else numbers or text)
            self.cell = None

    def handle_data(self, data):
        if self.open and self.open[-1] == "caption":
            self.caption += data
        if "style" not in self.open and "script" not in self.open:
            self.text += data
        if self.cell is not None:
            self.cell.append(data)

    def named(self, beginning):
        """The tables whose caption begins so, in their order."""
        return [rows for caption, rows in self.tables.items() if caption.startswith(beginning)]


def still_recording(seconds=3600, rate_hz=10, sigma=0.02, run="still"):
    """An hour at rest: white noise of gyro_x that is known: N = sigma / sqrt(rate)."""
    noise = random.Random(5)
    lines = [HEADER]
    for i in range(seconds * rate_hz):
        gyro = [0.1 + noise.gauss(0, sigma) for _ in range(3)]
        force = [noise.gauss(0, 0.005), noise.gauss(0, 0.005), 9.80665 + noise.gauss(0, 0.005)]
        lines.append(f"{i / rate_hz:.1f},{run},soak,up,25,+Z,25,{25 + noise.gauss(0, 0.01):.4f}," +
                     ",".join(f"{x:.6f}" for x in gyro + force))
    return "\n".join(lines) + "\n"


class Report(test_fit.FittedTest):
    def report(self, *arguments, status=0, name="page.html"):
        path = self.folder / name
        document = self.soak_json("report", "report", "--unit", SERIAL, "-o", path, *arguments, status=status)
        return document, Page(path.read_text(encoding="utf-8"))

    def limits(self, gyro, accel):
        return self.write("limits.toml", f"[limits]\ngyro = {gyro}\naccel = {accel}\n")

    def test_a_catalog_a_run_file_and_a_secret_key_are_never_replaced(self):
        key = self.folder / "station.key"
        self.soak("key", "new", "-o", key)
        for path in (self.data / "station.db", next((self.data / "runs").iterdir()), key):
            before = path.read_bytes()
            self.refusal("report", "--unit", SERIAL, "-o", path)
            self.assertEqual(path.read_bytes(), before)

    def test_page_is_whole_and_needs_nothing_else(self):
        document, page = self.report()
        self.assertEqual(document["bytes"], (self.folder / "page.html").stat().st_size)
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertEqual(page.tags.count("script"), 2)  # what its figures are drawn from, and what draws them
        for name, value in page.attributes:
            self.assertFalse(name.startswith("on"), name)
            self.assertNotIn("://", value or "")
        targets = [value for name, value in page.attributes if name == "href" and value.startswith("#")]
        self.assertGreater(len(targets), 8)
        self.assertLessEqual({target[1:] for target in targets}, set(page.ids))
        figures = [value for name, value in page.attributes if name == "data-chart"]
        self.assertEqual([figures.count(chart) for chart in ("curve", "residuals", "scale", "allan")], [6, 6, 3, 2])
        drawn = json.loads(re.search(r'id="data">(.*?)</script>', page.source)[1])["sensors"]
        self.assertEqual(set(drawn), set(SENSORS))
        for name in SENSORS:
            points = document["sections"]["sensors"][name]["rows"]["points"]
            self.assertEqual(drawn[name]["rows"]["points"]["run"], [point["run"] for point in points])

    def test_tables_hold_the_numbers_of_the_fit(self):
        _, page = self.report()
        for name, errors, folds in zip(SENSORS, page.named("Held-out errors"), page.named("Each fold"), strict=True):
            fit = self.fit["sensors"][name]
            expected = [["anfis", fit["check_rmse"], fit["check_rmse_shape"]]]
            expected += [[k, fit["baselines"][k]["rmse_abs"], fit["baselines"][k]["rmse_shape"]] for k in FAMILIES[1:]]
            self.assertEqual([row[:3] for row in errors], expected)
            self.assertEqual([row[0] for row in errors if "in the file" in row[3]], [fit["deployed"]])
            self.assertEqual(folds, [[check["held_out"], *(check[k] for k in FAMILIES)] for check in fit["checks"]])
        overview = {row[0]: row for row in page.tables["All sensors"]}
        for name, fit in self.fit["sensors"].items():
            self.assertEqual(overview[name][6:9], [fit["run_to_run_sigma"], max(p["ci95"] for p in fit["curve"]),
                                                   max(p["pi95"] for p in fit["curve"])])
        value, error = (self.fit["accel_misalignment_rad"][k] for k in ("value", "standard_error"))
        cells = page.named("Accelerometer misalignment")[0]
        self.assertAlmostEqual(cells[0][2][0], 1000 * value[0][1], places=12)
        self.assertAlmostEqual(cells[0][2][1], 1000 * error[0][1], places=12)

    def test_budgets_are_those_of_the_fit(self):
        _, page = self.report()
        for name, rows in zip(SENSORS, page.named("Uncertainty budget of the bias"), strict=True):
            budget = self.fit["sensors"][name]["uncertainty"]
            self.assertEqual([row[:2] for row in rows], [[part["name"], part["type"]] for part in budget])
            for row, part in zip(rows, budget):
                for cell, value in zip(row[3:7], [part[band][key] for band in ("curve", "fresh_power_on") for key in ("max", "at_25c")]):
                    self.assertEqual(cell, value if value is not None else "–" if part["stated"] else "not stated")
                self.assertEqual(row[7], re.sub(r" \('soak [^']*'\)", "", part["basis"]))  # who reads a report has no terminal of the station
        self.assertNotRegex(re.sub(r"<script.*?</script>", "", page.source, flags=re.S), r"\bsoak [a-z]+ |deg/s|m/s2")

    def test_metres_without_satellite_navigation_are_those_of_the_fitted_curve(self):
        """Against [AH05 eq. 6.5 and 6.6], from the points of the curve, one a kelvin or so."""
        document, page = self.report()
        impact = document["sections"]["impact"]
        rows = {row[0]: row for row in page.tables["Position error from each sensor's bias alone, m"]}
        self.assertEqual(set(rows), set(SENSORS))
        for shown in impact["free_inertial"]:
            sensor = document["sections"]["sensors"][shown["sensor"]]["fit"]
            biases = [point["bias"] for point in sensor["curve"] if impact["from_c"] <= point["temp_c"] <= impact["to_c"]]
            changes = [abs(bias - biases[0]) for bias in biases]
            step = max(abs(b - a) for a, b in zip(biases, biases[1:]))
            self.assertAlmostEqual(shown["change"], max(changes), delta=2 * step)
            for seconds in (30, 60):
                metres = shown[f"after_{seconds}_s_m"]
                for bias, error in ((shown["change"], metres["without"]), (shown["left"], metres["with"])):
                    of_gyro = math.radians(bias) * 9.80665 * seconds ** 3 / 6
                    self.assertAlmostEqual(error, of_gyro if shown["unit"] == "deg/s" else bias * seconds ** 2 / 2, delta=1e-9 + 1e-6 * error)
            self.assertEqual(rows[shown["sensor"]][4:], [shown["left_interval"]] + [shown[f"after_{s}_s_m"][which] for s in (30, 60) for which in ("without", "with")])
        self.assertNotIn("soak nav", page.text)

    def test_what_simulated_drives_lose_stands_in_the_page(self):
        document, page = self.report()
        drives = document["sections"]["impact"]["drives"]
        rows = page.tables["Position error of a navigation filter in outages on simulated drives, m [95 %]"]
        self.assertEqual([row[0] for row in rows], ["without", "with"])
        for which, *cells in rows:
            for cell, measure in zip(cells, ("horizontal_final_m", "horizontal_rmse_m"), strict=True):
                self.assertEqual(cell, [drives[which][measure]["value"], *drives[which][measure]["ci95"]])
        self.assertIn(f"{drives['outages']} outages of 30 s on {drives['drives']} simulated drives", page.text)
        # A filter of a unit of this grade, 30 s: metres, no kilometres.
        for which in ("without", "with"):
            self.assertGreater(drives[which]["horizontal_final_m"]["value"], 1.0)
            self.assertLess(drives[which]["horizontal_final_m"]["value"], 1000.0)

    def test_residuals_are_those_of_the_file_that_is_deployed(self):
        document, _ = self.report()
        path = self.blob()
        for name, sensor in document["sections"]["sensors"].items():
            points = sensor["rows"]["points"]
            self.assertEqual(len(points), 3 * 41)  # runs times visits of the made-up campaign
            curve = [p["bias"][name] for p in self.eval(path, [p["temp_c"] for p in points])]
            span = max(curve) - min(curve)
            for point, bias in zip(points, curve):
                # The runtime is float32, and the temperature that it is given is rounded to that too.
                self.assertAlmostEqual(point["value"] - point["residual"], bias, delta=1e-5 * span)
            squares = [p["residual"] ** 2 for p in points]
            self.assertAlmostEqual(sensor["rows"]["rmse_abs"], math.sqrt(sum(squares) / len(squares)), delta=1e-12)

    @long_test
    def test_the_training_error_of_a_deployed_anfis_is_that_of_its_rows(self):
        # Of four runs: of up to three another family is deployed where it is expected to err less.
        subprocess.run([os.environ["SOAK_SIM_BIN"], "--out", self.folder / "lab", "--units", "1", "--runs", "4", "--rows-per-position",
                        "10"], check=True, capture_output=True)
        self.soak("import", self.folder / "lab" / "campaign" / f"{SERIAL}.csv", "--unit", "four", "--campaign", "four",
                  "--gravity-mps2", "9.80665")
        fit = self.soak_json("fit", "fit", "--unit", "four")
        document = self.soak_json("report", "report", "--unit", "four", "-o", self.folder / "four.html")
        deployed = [name for name, sensor in fit["sensors"].items() if sensor["deployed"] == "anfis"]
        self.assertTrue(deployed)
        for name in deployed:
            self.assertAlmostEqual(document["sections"]["sensors"][name]["rows"]["rmse_abs"],
                                   fit["sensors"][name]["train_rmse"], delta=1e-9)

    @long_test
    def test_without_limits_nothing_passes(self):
        document, page = self.report()
        self.assertEqual(document["sections"]["summary"]["verdict"], "info")
        rows = page.tables["Verdict, sensor by sensor"]
        self.assertEqual({row[1] for row in rows}, {"no limit"})
        self.assertLessEqual({row[2] for row in rows}, {"no limit", "scale not known"})
        self.assertIn("NOT JUDGED", page.text)

    def test_limits_are_judged_on_fresh_runs_as_verify_does(self):
        wide = self.limits(1.0, 1.0)
        document, page = self.report("--limits", wide)
        verified = self.soak_json("verify", "verify", self.blob(), "--campaign", "verification", "--limits", wide)
        self.assertEqual(document["sections"]["summary"]["verdict"], "pass")
        self.assertIn("PASS", page.text)
        for name, sensor in document["sections"]["sensors"].items():
            # verify reads the file in float32
            self.assertAlmostEqual(sensor["verification"]["bias"]["worst_abs"], verified["sensors"][name]["worst_abs"], places=6)
        document, page = self.report("--limits", self.limits(0.0001, 1.0), status=5)
        self.assertEqual(document["sections"]["summary"]["verdict"], "fail")
        self.assertRegex(page.text, r"FAIL.*\(V01\): gyro_")

    def test_warnings_come_by_what_they_ask_for_and_those_that_ask_for_nothing_in_one_line(self):
        self.soak("runs", "void", "R02", "--reason", "test")
        document, page = self.report()
        warnings = document["sections"]["summary"]["warnings"]
        order = ["grave", "act", "none"]
        self.assertEqual([w["urgency"] for w in warnings], sorted((w["urgency"] for w in warnings), key=order.index))
        self.assertEqual({w["code"]: w["urgency"] for w in warnings if w["code"] in ("voided_since", "simulated", "baseline_deployed")},
                         {"voided_since": "grave", "simulated": "grave", "baseline_deployed": "none"})
        # Three runs: the file's families were chosen by the expected error.
        told = [w for w in warnings if w["code"] == "baseline_deployed"]
        spline = sum(len(w["sensors"]) for w in told if ": spline " in w["text"])
        counts = {"polynomial": sum(len(w["sensors"]) for w in told) - spline, "spline": spline}
        text = ", ".join(f"{count} {family}" for family, count in counts.items() if count)
        self.assertIn(f"Nothing to do: in the file for the least expected error, so few runs are no judge when held out: {text}", page.text)
        self.assertNotIn("better than the ANFIS", page.text)
        self.assertNotIn("What to do: No action", page.text)
        self.assertNotIn("baseline_deployed", page.text)

    def test_a_unit_that_was_repaired_is_not_judged_by_its_old_model_in_no_report(self):
        wide = self.limits(1.0, 1.0)
        self.assertEqual(self.report("--limits", wide)[0]["sections"]["summary"]["no_verdict"], None)
        self.soak("unit", "add", SERIAL, "--begin-epoch", "gyro replaced")
        document, page = self.report("--limits", wide)
        summary = document["sections"]["summary"]
        self.assertEqual((summary["verdict"], summary["no_verdict"]), ("info", "the unit was repaired or changed after this model"))
        self.assertEqual({row[1] for row in page.tables["Verdict, sensor by sensor"]}, {"not judged"})
        self.assertEqual({w["urgency"] for w in summary["warnings"] if w["code"] == "older_epoch"}, {"grave"})
        file = self.folder / "campaign.html"
        (line,) = self.soak_json("report-campaign", "report", "--campaign", "campaign", "-o", file, "--limits", wide)["units"]
        self.assertEqual(line["verdict"], "info")
        self.assertIn("1 unit: 1 not judged.", Page(file.read_text(encoding="utf-8")).text)

    def test_a_model_that_lost_runs_or_was_withdrawn_is_not_judged(self):
        wide = self.limits(1.0, 1.0)
        self.soak("runs", "void", "R02", "--campaign", "campaign", "--reason", "fell down")
        summary = self.report("--limits", wide)[0]["sections"]["summary"]
        self.assertEqual(summary["verdict"], "info")
        self.assertIn("R02", summary["no_verdict"])
        self.soak("model", "retire", "--unit", SERIAL, "--model", "1", "--reason", "wrong fixture", "--user", "ann")
        document, page = self.report("--limits", wide)
        self.assertRegex(document["sections"]["summary"]["no_verdict"], r"^the model was withdrawn on [\d-]{10} by ann: wrong fixture$")
        self.assertIn("withdrawn: not to be used", page.text)

    def test_no_verdict_holds_once_data_of_its_verification_were_withdrawn_until_it_is_verified_again(self):
        wide = self.limits(1.0, 1.0)
        verify = ("verify", "--unit", SERIAL, "--campaign", "verification", "--limits", wide)
        self.soak(*verify)
        self.soak("runs", "void", "V01", "--campaign", "verification", "--visit", "1", "--reason", "knocked")
        self.assertIn("data of campaign verification were withdrawn", self.report("--limits", wide)[0]["sections"]["summary"]["no_verdict"])
        self.soak(*verify)
        self.assertEqual(self.report("--limits", wide)[0]["sections"]["summary"]["no_verdict"], None)

    def test_a_certificate_says_who_verified_and_who_released(self):
        wide = self.limits(1.0, 1.0)
        document, page = self.report("--limits", wide)
        self.assertEqual((document["sections"]["release"]["verification"], document["sections"]["release"]["released"]), (None, None))
        self.assertIn("no verification is stored", page.text)
        self.soak("verify", "--unit", SERIAL, "--campaign", "verification", "--limits", wide)
        self.soak("release", "--unit", SERIAL, "--user", "eva")
        document, page = self.report("--limits", wide)
        release = document["sections"]["release"]
        self.assertEqual((release["state"], release["verification"]["verdict"], release["released"]["user"]), ("released", "pass", "eva"))
        self.assertRegex(page.text, r"Verified\s*[\d-]{10} by \S+, with campaign verification: PASS\s*Released\s*[\d-]{10} by eva\s*Valid until")
        self.assertRegex(page.text, rf"Certificate number\s*{SERIAL}, model 1, ")
        self.assertNotRegex(page.source.split("<body>")[1].split("<nav")[0], "soak [a-z]+")

    def test_runs_of_several_campaigns_are_named_with_them(self):
        for lab, campaign, procedure in (("verification", "check-2", "verification"), ("campaign", "later", "import")):
            lines = (test_fit.fitted_folder() / "lab" / lab / f"{SERIAL}.csv").read_text(encoding="utf-8").splitlines()
            other = self.write(f"{campaign}.csv", "\n".join([lines[0], *(f"{line}1" for line in lines[1:])]) + "\n")  # no copy
            self.soak("import", other, "--unit", SERIAL, "--campaign", campaign, "--procedure", procedure, "--simulated", "--gravity-mps2", "9.80665")
        summary = self.report("--limits", self.limits(1.0, 1.0))[0]["sections"]["summary"]
        self.assertIn("2 fresh runs (V01 of campaign verification, V01 of campaign check-2)", summary["sentence"])
        self.assertIn("R02 of campaign later", "".join(w["text"] for w in summary["warnings"] if w["code"] == "not_in_model"))

    def test_the_report_of_a_campaign_lists_its_units_with_verdicts_and_has_a_page_of_each(self):
        path = test_fit.fitted_folder() / "lab" / "campaign" / f"{SERIAL}.csv"
        self.soak("import", path, "--unit", "NEW", "--campaign", "campaign", "--simulated")
        file, wide = self.folder / "campaign.html", self.limits(1.0, 1.0)
        document = self.soak_json("report-campaign", "report", "--campaign", "campaign", "-o", file, "--limits", wide)
        own, own_page = self.report("--limits", wide)
        summary = own["sections"]["summary"]
        new, fitted = document["units"]
        self.assertEqual((new["unit"], new["verdict"]), ("NEW", None))
        self.assertIn("soak fit --unit NEW", new["trouble"])
        self.assertEqual([fitted[key] for key in ("unit", "model", "verdict", "sentence")], [SERIAL, 1, "pass", summary["sentence"]])
        page = Page(file.read_text(encoding="utf-8"))
        self.assertEqual([row[:2] for row in page.tables["Units of the campaign"]], [["NEW", "no report"], [SERIAL, "pass"]])
        self.assertEqual(page.tables["Verdict, sensor by sensor"], own_page.tables["Verdict, sensor by sensor"])
        self.assertIn("2 units: 1 no report, 1 pass.", page.text)
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertLessEqual({value for name, value in page.attributes if name == "href" and value.startswith("#")}, {f"#{i}" for i in page.ids})
        failing = ("report", "--campaign", "campaign", "-o", file, "--limits", self.limits(0.0001, 1.0))
        self.assertIn("1 of 2 units exceed their limits", self.soak(*failing, status=5).stderr)

    @long_test
    def test_simulated_data_are_marked_unit_by_unit_in_the_report_of_a_campaign(self):
        path = test_fit.fitted_folder() / "lab" / "campaign" / f"{SERIAL}.csv"
        self.soak("import", path, "--unit", "REAL", "--campaign", "campaign")
        self.soak("fit", "--unit", "REAL")
        file = self.folder / "campaign.html"
        document = self.soak_json("report-campaign", "report", "--campaign", "campaign", "-o", file)
        self.assertEqual({line["unit"]: line["simulated"] for line in document["units"]}, {"REAL": False, SERIAL: True})
        page = Page(file.read_text(encoding="utf-8"))
        self.assertEqual({row[0]: row[2] for row in page.tables["Units of the campaign"]}, {"REAL": "measured", SERIAL: "SIMULATED"})
        real, simulated = (page.source.split(f"<h2>Unit {unit}</h2>")[1].split("</section>")[0] for unit in ("REAL", SERIAL))
        self.assertIn("SIMULATED DATA", simulated)
        self.assertNotIn("SIMULATED", real)
        self.assertNotIn('class="watermark"', page.source)
        self.assertIn("<title>Calibration report", page.source)

    @long_test
    def test_what_is_wrong_with_one_unit_is_an_error_of_the_campaign_too(self):
        page = self.folder / "page.html"
        next((self.data / "runs").glob("*.soakrun")).unlink()
        of_unit = self.refusal("report", "--unit", SERIAL, "-o", page, status=4)
        self.assertEqual(self.refusal("report", "--campaign", "campaign", "-o", page, status=4), of_unit)
        self.assertTrue(of_unit["where"])
        self.assertFalse(page.exists())

    @long_test
    def test_limits_that_are_wrong_for_a_type_refuse_the_campaign_as_they_do_the_unit(self):
        units = self.folder / "procedures" / "units"
        units.mkdir(parents=True)
        (units / "generic.toml").write_text('name = "generic"\n[limits]\ngyro = -1\n', encoding="utf-8")
        os.environ["SOAK_PROCEDURES"] = str(units.parent)
        self.addCleanup(os.environ.pop, "SOAK_PROCEDURES")
        page = self.folder / "page.html"
        of_unit = self.refusal("report", "--unit", SERIAL, "-o", page)
        self.assertEqual(self.refusal("report", "--campaign", "campaign", "-o", page), of_unit)
        self.assertFalse(page.exists())

    def test_a_report_is_of_one_unit_or_of_one_campaign_that_has_runs(self):
        path = self.folder / "none.html"
        for wrong in ((), ("--unit", SERIAL, "--campaign", "campaign"), ("--campaign", "no-such"), ("--campaign", "campaign", "--model", "1")):
            self.refusal("report", *wrong, "-o", path)
        for run in ("R01", "R02", "R03"):
            self.soak("runs", "void", run, "--campaign", "campaign", "--reason", "test")
        self.assertIn("no run that counts", self.refusal("report", "--campaign", "campaign", "-o", path)["message"])
        self.assertFalse(path.exists())

    @long_test
    def test_limits_without_fresh_runs_are_not_measured(self):
        self.soak("runs", "void", "V01", "--reason", "test")
        document, page = self.report("--limits", self.limits(1.0, 1.0))
        self.assertEqual(document["sections"]["summary"]["verdict"], "not_measured")
        self.assertIn("NOT MEASURED", page.text)
        self.assertIsNone(document["sections"]["sensors"]["gyro_x"]["fresh"])

    @long_test
    def test_a_run_entered_later_is_named_and_not_shown_as_fitted(self):
        before, _ = self.report()
        path = test_fit.fitted_folder() / "lab" / "verification" / f"{SERIAL}.csv"
        self.soak("import", path, "--unit", SERIAL, "--campaign", "later", "--simulated")
        document, page = self.report()
        for name, sensor in document["sections"]["sensors"].items():
            self.assertEqual(sensor["rows"], before["sections"]["sensors"][name]["rows"])
        self.assertIn("not_in_model", [w["code"] for w in document["sections"]["summary"]["warnings"]])
        uses = {(run["campaign"], run["label"]): run["use"] for run in document["sections"]["provenance"]["runs"]}
        self.assertEqual(uses[("later", "V01")], "not_used")
        self.assertEqual(uses[("verification", "V01")], "fresh")
        self.assertEqual(uses[("campaign", "R01")], "fitted")
        self.assertIn("later", page.text)

    @long_test
    def test_what_was_withdrawn_since_the_fit_is_told_with_reason_and_user(self):
        self.soak("runs", "void", "R02", "--reason", "loose <b>fixture</b>", "--user", "Mo & Jo")
        document, page = self.report()
        self.assertEqual(document["sections"]["sensors"]["gyro_x"]["rows"]["runs"], ["R01", "R03"])
        self.assertIn("voided_since", [w["code"] for w in document["sections"]["summary"]["warnings"]])
        (row,) = page.tables["Withdrawn, with reason"]
        self.assertEqual(row[:4], ["R02", "the whole run", "loose <b>fixture</b>", "Mo & Jo"])
        self.assertNotIn("<b>fixture", page.source)
        for run in ("R01", "R03"):
            self.soak("runs", "void", run, "--reason", "test")
        document, _ = self.report()
        self.assertIsNone(document["sections"]["sensors"]["gyro_x"]["rows"])

    def test_provenance_names_the_runs_by_their_content(self):
        document, page = self.report()
        stored = {run["run"]: run for run in self.soak_json("runs-list", "runs", "list", "--unit", SERIAL)["runs"]}
        for run in document["sections"]["provenance"]["runs"]:
            self.assertEqual(run["content_sha256"], stored[run["label"]]["content_sha256"])
            self.assertIn(run["content_sha256"], page.source)
            self.assertEqual(run["source"], f"import {SERIAL}.csv")
        database = sqlite3.connect(self.data / "station.db")
        ((digest,),) = database.execute("SELECT sha256 FROM model").fetchall()
        database.close()
        self.assertEqual(document["sections"]["provenance"]["model_sha256"], digest)

    def test_simulated_data_cannot_be_missed(self):
        _, page = self.report()
        self.assertIn("SIMULATED DATA", page.text)
        self.assertIn("<title>SIMULATED: ", page.source)

    def test_noise_is_that_of_soak_signal_from_the_longest_segment(self):
        self.soak("import", self.write("still.csv", still_recording()), "--unit", SERIAL, "--campaign", "noise", "--simulated")
        document, page = self.report()
        noise = document["sections"]["noise"]
        self.assertEqual((noise["segment"]["run"], noise["segment"]["position"]), ("still", "+Z"))
        self.assertAlmostEqual(noise["segment"]["duration_s"], 3600, delta=1)
        alone = self.soak_json("signal-allan", "signal", "allan", "--run", "still", "--unit", SERIAL, "--column", "gyro_x")
        self.assertEqual(noise["sensors"]["gyro_x"], alone)
        coefficient = noise["sensors"]["gyro_x"]["coefficients"]["angle_random_walk"]
        self.assertLess(coefficient["ci95"][0], 0.02 / math.sqrt(10) * 1.02)
        self.assertGreater(coefficient["ci95"][1], 0.02 / math.sqrt(10) * 0.98)
        self.assertIn(["random walk of the integral (N)"], [row[:1] for row in page.named("Noise coefficients")[0]])

    @long_test
    def test_a_model_of_an_older_version_has_its_page(self):
        database = open_catalog(self.data / "station.db")
        ((text,),) = database.execute("SELECT document FROM model").fetchall()
        model = json.loads(text)
        model["fit"].pop("references", None)
        for sensor in model["fit"]["sensors"].values():
            for key in ("uncertainty", "scale_uncertainty", "lack_of_fit_sigma", "scale_deployed"):
                sensor.pop(key, None)
        model["calibration"].pop("references", None)
        older = json.dumps(model)
        database.execute("UPDATE model SET document = ?, sha256 = ?", (older, hashlib.sha256(older.encode()).hexdigest()))
        database.commit()
        database.close()
        _, page = self.report()
        self.assertNotIn("Uncertainty budget", page.tables)

    @long_test
    def test_an_older_version_says_that_it_is_not_the_newest(self):
        self.soak("fit", "--unit", SERIAL, "--rules", "3")
        document, _ = self.report("--model", "1")
        self.assertEqual(document["model"], 1)
        self.assertIn("older_model", [w["code"] for w in document["sections"]["summary"]["warnings"]])
        self.assertEqual(self.report()[0]["model"], 2)

    @long_test
    def test_a_model_from_before_a_repair_says_so(self):
        self.soak("unit", "add", SERIAL, "--begin-epoch", "board repaired")
        document, _ = self.report()
        self.assertIn("older_epoch", [w["code"] for w in document["sections"]["summary"]["warnings"]])
        self.assertEqual(len(document["sections"]["provenance"]["runs"]), 4)  # of the epoch of the model

    def test_what_cannot_be_reported_is_refused_and_no_file_written(self):
        path = self.folder / "none.html"
        self.refusal("report", "--unit", "NOBODY", "-o", path)
        self.refusal("report", "--unit", SERIAL, "-o", path, "--model", "9")
        self.soak("unit", "add", "NEW")
        self.refusal("report", "--unit", "NEW", "-o", path)
        self.refusal("report", "--unit", SERIAL, "-o", path, "--limits", self.write("bad.toml", "[limits]\ngyro = -1\n"))
        self.assertFalse(path.exists())
        self.soak("report", "--unit", SERIAL, "-o", self.folder / "no" / "such.html", status=2)

    def test_a_missing_run_file_is_damage(self):
        next((self.data / "runs").glob("*.soakrun")).unlink()
        self.refusal("report", "--unit", SERIAL, "-o", self.folder / "page.html", status=4)

    @long_test
    def test_a_changed_run_file_is_damage(self):
        path = next((self.data / "runs").glob("*.soakrun"))
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.chmod(0o600)
        path.write_bytes(bytes(content))
        error = self.refusal("report", "--unit", SERIAL, "-o", self.folder / "page.html", status=4)
        self.assertEqual(error["where"], str(path))
        self.assertFalse((self.folder / "page.html").exists())

    def test_the_check_standards_of_its_campaigns_are_on_the_page(self):
        document, page = self.report()
        self.assertEqual(document["sections"]["check_standards"]["units"], [])
        self.assertNotIn("check", page.sections)
        self.soak("check", "declare", SERIAL, "--reason", "test")
        document, page = self.report()
        chart, = document["sections"]["check_standards"]["units"]
        self.assertEqual(chart["unit"], SERIAL)
        campaigns = document["sections"]["check_standards"]["campaigns"]
        self.assertEqual([c["campaign"] for c in chart["campaigns"]], campaigns)
        self.assertEqual(chart["campaigns"][0]["verdict"], "not_established")
        (rows,) = page.sections["check"]
        self.assertEqual([row[1] for row in rows], SENSORS)
        for row in rows:
            self.assertEqual(row[3], chart["campaigns"][0]["sensors"][row[1]]["bias"])

    def test_text_on_the_terminal_says_the_verdict(self):
        done = self.soak("report", "--unit", SERIAL, "-o", self.folder / "page.html")
        self.assertIn("SIMULATED", done.stdout)
        self.assertIn("info: ", done.stdout)


class OneRunOfOneAttitude(SoakTest):
    def test_has_a_page_that_says_what_is_not_known(self):
        folder = shared_data("thermal_chamber_cycle")
        if folder is None:
            self.skipTest("the chamber recording is not here (SOAK_TEST_DATA)")
        columns = ROOT / "procedures" / "columns" / "thermal-chamber-cycle.toml"
        self.soak("import", folder / "imu_raw_data.csv", "--columns", columns, "--unit", "C1", "--gravity-mps2", "9.806")
        self.soak("fit", "--unit", "C1")
        path = self.folder / "page.html"
        document = self.soak_json("report", "report", "--unit", "C1", "-o", path)
        page = Page(path.read_text(encoding="utf-8"))
        for limitation in ("one run", "25 °C", "one attitude", "g-sensitivity", "power-on"):
            self.assertIn(limitation, page.text)
        self.assertNotIn("SIMULATED", page.text)
        for name in SENSORS[3:]:  # relative: rows are shifted to the curve
            points = document["sections"]["sensors"][name]["rows"]["points"]
            self.assertAlmostEqual(sum(p["residual"] for p in points) / len(points), 0, delta=1e-9)


class HostileNames(test_fit.FittedTest):
    SERIAL = "<script>alert(1)</script>"

    def test_stay_text(self):
        path = test_fit.fitted_folder() / "lab" / "campaign" / f"{SERIAL}.csv"
        text = path.read_text(encoding="utf-8").replace(",R01,", ",<img src=x onerror=alert(2)>,")
        self.soak("import", self.write("a.csv", text), "--unit", self.SERIAL, "--campaign", '"><svg onload=alert(3)>')
        self.soak("fit", "--unit", self.SERIAL)
        page = self.folder / "page.html"
        document = json.loads(self.soak("report", "--unit", self.SERIAL, "-o", page, "--json").stdout)
        check_schema(document, "report")
        read = Page(page.read_text(encoding="utf-8"))
        self.assertEqual(read.tags.count("script"), 2)  # those of the page
        self.assertNotIn("img", read.tags)
        self.assertNotIn("onload", [name for name, _ in read.attributes])
        self.assertIn(self.SERIAL, read.text)


if __name__ == "__main__":
    unittest.main()
