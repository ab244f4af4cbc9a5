# SPDX-License-Identifier: Apache-2.0
"""What a model lacks, a fleet and the event log from the page alone, before a real `soakd` ($SOAK_BIN_FOLDER): a lag that
soaksim-campaign hides is found, accepted and gone on a fresh run; an odd unit stands out of twenty; a log that was changed says so."""
import contextlib
import csv
import functools
import json
import pathlib
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

from browser import BrowserTest, long_test
from lagging_unit import LAGGING, ROOT, lagging_recordings, simulate
from real_soakd import programs
from test_language import SHOWN
from test_units import UnitStation

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import check_schema  # noqa: E402

ODD = '<img src=x onerror="document.title=1">'  # the serial number of the unit that is not like the others
ODD_DPS = 3.0  # added to the rate of its gyro x; units of the simulator differ by a few tenths
FLEET = 20
SEARCH_S = 300  # a job yields to everybody else on the machine


@functools.cache
def stored_data():
    """A data folder with a unit whose elements lag behind its thermometer, fitted, and with twenty fitted units of one type; stations work
    on copies."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-gap-"))

    def soak(*words):
        subprocess.run([programs() / "soak", *map(str, words), "--data", folder / "data"], check=True, capture_output=True)

    five, sixth = lagging_recordings(folder)
    common = ["--gravity-mps2", "9.80665", "--simulated"]
    soak("import", five, "--unit", LAGGING, *common)
    soak("import", sixth, "--unit", LAGGING, "--campaign", "check", "--procedure", "verification", *common)
    soak("fit", "--unit", LAGGING, "--rules", "3")

    simulate(folder / "many", "--seed", 7, "--units", FLEET, "--runs", 2, "--rows-per-position", 4)
    for path in sorted((folder / "many" / "campaign").glob("*.csv")):
        serial = path.stem
        if path.stem == f"SIM-{FLEET:04}":
            serial = ODD
            with path.open(encoding="utf-8", newline="") as file:
                rows = list(csv.DictReader(file))
            with path.open("w", encoding="utf-8", newline="") as file:
                writer = csv.DictWriter(file, rows[0])
                writer.writeheader()
                writer.writerows({**row, "gx_dps": float(row["gx_dps"]) + ODD_DPS} for row in rows)
        soak("import", path, f"--unit={serial}", "--type", "mti-300", "--campaign", serial, *common)
        soak("fit", f"--unit={serial}", "--rules", "2")
    return folder


def tearDownModule():
    if stored_data.cache_info().currsize:
        shutil.rmtree(stored_data(), ignore_errors=True)


class GapStation(UnitStation):
    def __init__(self):
        stored_data()  # with the unit types that come with Soak, before the station's own take their place
        super().__init__()

    def store_all(self):
        shutil.copytree(stored_data() / "data", self.data)

    def ended(self, job):
        end = time.monotonic() + SEARCH_S
        while (document := self.get("job", id=job["id"]))["state"] == "running":
            assert time.monotonic() < end
            time.sleep(0.05)
        check_schema(document, "http-job")
        return document


class WithStation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soakd = GapStation()
        cls.addClassCleanup(cls.soakd.close)


class Interface(WithStation):
    def refused(self, path):
        with self.assertRaises(urllib.error.HTTPError) as refusal:
            urllib.request.urlopen(f"{self.soakd.url}api/v1/{path}", timeout=30)
        document = json.load(refusal.exception)
        check_schema(document, "error")
        return refusal.exception.code, document["error"]["where"]

    def test_jobs_of_the_gap_that_are_none_are_refused(self):
        refused = self.soakd.refusal
        self.assertEqual(refused("jobs", kind="gap_accept", unit=LAGGING), (400, "effects"))
        self.assertEqual(refused("jobs", kind="gap_accept", unit=LAGGING, effects="sensor_lag"), (400, "effects"))
        self.assertEqual(refused("jobs", kind="gap_accept", unit=LAGGING, effects=[1]), (400, "effects"))
        self.assertEqual(refused("jobs", kind="gap_accept", unit=LAGGING, effects=["x"] * 21), (400, "effects"))
        self.assertEqual(refused("jobs", kind="gap_accept", unit=LAGGING, effects=["x\ny"]), (400, "effects"))
        self.assertEqual(refused("jobs", kind="gap_accept", unit=LAGGING, effects=["sensor_lag", ""]), (400, "effects"))
        self.assertEqual(refused("jobs", kind="gap_withdraw", unit=LAGGING), (400, "kind"))

    def test_a_fleet_is_compared_unit_by_unit(self):
        fleet = self.soakd.get("fleet", type="mti-300")
        check_schema(fleet, "http-fleet")
        self.assertEqual(len(fleet["units"]), FLEET)
        self.assertEqual({unit["verdict"] for unit in fleet["units"]}, {None})
        bias = fleet["sensors"]["gyro_x"]["bias"]
        self.assertEqual([unit["unit"] for unit in bias["units"] if unit["outlier"]], [ODD])
        # Against the models themselves, as `soak fit` has stored them: the median of twenty lies between the tenth and the eleventh.
        at = bias["temp_c"].index(20.0)
        values = []
        for unit in fleet["units"]:
            curve = self.soakd.get("unit", unit=unit["unit"])["model"]["sensors"]["gyro_x"]["curve"]
            values.append(between(curve, 20.0))
        self.assertAlmostEqual(bias["median"][at], sum(sorted(values)[9:11]) / 2, delta=1e-5 * max(map(abs, values)))
        self.assertEqual([unit["drift"] for unit in bias["units"]], [None] * FLEET, "one model each")
        self.assertEqual(self.refused("fleet?type=nothing"), (400, "type"))
        self.assertEqual(self.refused("fleet"), (400, "type"))
        self.assertEqual(self.refused("fleet?type=%E2%80%AEx"), (400, "type"), "U+202E")

    def test_events_are_those_that_soak_lists(self):
        listed = self.soakd.soak_json("events", "list")["events"]
        page = self.soakd.get("audit", most=500)
        check_schema(page, "http-audit")
        self.assertEqual(page["events"], listed[::-1][:500])
        self.assertEqual(page["kinds"], sorted({event["kind"] for event in listed}))
        self.assertEqual(page["users"], sorted({event["user"] for event in listed if event["user"]}))
        self.assertGreater(len(page["users"]), 0)
        for name, value in (("kind", "model_added"), ("subject", LAGGING)):
            mine = [event for event in listed if event[name] == value]
            self.assertGreater(len(mine), 0)
            self.assertEqual(self.soakd.get("audit", **{name: value}, most=500)["events"], mine[::-1])
        middle = listed[len(listed) // 2]["utc_s"]
        self.assertEqual(self.soakd.get("audit", from_utc_s=middle, most=500)["events"], [event for event in listed if event["utc_s"] >= middle][::-1])
        self.assertEqual(self.soakd.get("audit", to_utc_s=middle, most=500)["events"], [event for event in listed if event["utc_s"] < middle][::-1])
        first = self.soakd.get("audit", most=2)
        self.assertTrue(first["has_older"])
        second = self.soakd.get("audit", most=2, before=first["events"][-1]["number"])
        self.assertEqual(first["events"] + second["events"], listed[::-1][:4])
        self.assertFalse(self.soakd.get("audit", before=2)["has_older"])
        of_runs = [event for event in listed if event["kind"] == "run_added"]
        run = self.soakd.get("runs")["runs"][0]
        same = {one["run_id"] for one in self.soakd.get("runs")["runs"] if one["run"] == run["run"]}
        by_label = self.soakd.get("audit", about=run["run"], most=500)["events"]
        self.assertEqual([event for event in by_label if event["kind"] == "run_added"], [event for event in of_runs[::-1] if event["subject"] in same])
        by_both = self.soakd.get("audit", about=f"{run['run']} of {run['campaign']}", most=500)["events"]
        self.assertIn(run["run_id"], {event["subject"] for event in by_both})
        self.assertLess(len(by_both), len(by_label))
        self.assertEqual(self.soakd.get("audit", about=LAGGING, most=500)["events"], self.soakd.get("audit", subject=LAGGING, most=500)["events"])
        self.assertFalse({"position", "power", "segment", "step"} & {event["kind"] for event in self.soakd.get("audit", routine="false", most=500)["events"]})
        for wrong in ("routine=no", "about=", "most=0", "most=501", "before=x", "from_utc_s=now", "kind=", "since=1"):
            self.assertEqual(self.refused(f"audit?{wrong}"), (400, wrong.split("=")[0]))

    def test_the_chain_of_events_is_checked(self):
        check = self.soakd.get("audit/check")
        check_schema(check, "events-verify")
        self.assertEqual(check, self.soakd.soak_json("events", "verify"))
        self.assertTrue(check["ok"])


class Changed(WithStation):
    def change(self, statement, *values):
        """Changes the catalog behind the station's back: no trigger notices."""
        with contextlib.closing(sqlite3.connect(self.soakd.data / "station.db")) as catalog, catalog:
            triggers = catalog.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger' ORDER BY rowid").fetchall()
            for name, _ in triggers:
                catalog.execute(f"DROP TRIGGER {name}")
            self.assertEqual(catalog.execute(statement, values).rowcount, 1)
            for _, text in triggers:
                catalog.execute(text)

    def line(self):
        """What the fleet says of the bias of gyro x of a unit, and of the unit."""
        fleet = self.soakd.get("fleet", type="mti-300")
        check_schema(fleet, "http-fleet")
        of = next(unit for unit in fleet["units"] if unit["unit"] == "SIM-0001")
        return of, next(unit for unit in fleet["sensors"]["gyro_x"]["bias"]["units"] if unit["unit"] == "SIM-0001")

    def test_a_damaged_model_before_leaves_out_the_drift_only(self):
        self.soakd.soak("fit", "--unit=SIM-0001", "--rules", "2")
        of, line = self.line()
        self.assertEqual((of["before"], of["trouble"]), (1, None))
        self.assertEqual((line["drift"]["change"], line["drift"]["beyond_band"]), (0.0, False), "the same runs")
        self.change("UPDATE model SET document = document || ' ' WHERE unit = ? AND version = 1", "SIM-0001")
        of, line = self.line()
        self.assertEqual((of["model"]["version"], of["before"], of["trouble"]), (2, None, None))
        self.assertIsNone(line["drift"])
        self.assertIsNotNone(line["values"])

    def test_a_log_that_was_changed_says_so(self):
        self.change("UPDATE event SET user = ? WHERE ordinal = 2", "nobody")
        check = self.soakd.get("audit/check")
        check_schema(check, "events-verify")
        self.assertEqual((check["ok"], check["where"]), (False, "event 2"))


class Kept(WithStation):
    def stale(self):
        return self.soakd.get("unit", unit=LAGGING)["gap"]["find"]["stale"]

    def search(self):
        self.soakd.ended(self.soakd.post("jobs", kind="gap_find", unit=LAGGING, user="Eva"))

    def test_a_search_goes_with_the_runs_that_it_looked_at(self):
        self.search()
        self.assertIsNone(self.stale())
        run = self.soakd.get("runs", unit=LAGGING, campaign="check")["runs"][0]["run_id"]
        self.soakd.soak("runs", "void", run, "--unit", LAGGING, "--reason", "fixture slipped")
        self.assertEqual(self.stale(), "data were withdrawn since")
        self.search()
        self.assertIsNone(self.stale())
        again = ["import", stored_data() / "sixth.csv", "--unit", LAGGING, "--gravity-mps2", "9.80665", "--simulated"]
        self.soakd.soak(*again, "--campaign", "check again", "--procedure", "verification")
        self.assertIsNone(self.stale(), "a search takes no such run")
        self.soakd.soak(*again, "--campaign", "more")
        self.assertEqual(self.stale(), "runs were added since")


def between(curve, temp_c):
    """The value of a curve of points at a temperature: a straight line between neighbours."""
    above = next(i for i, point in enumerate(curve) if point["temp_c"] >= temp_c)
    a, b = curve[max(0, above - 1)], curve[above]
    share = 0.0 if a is b else (temp_c - a["temp_c"]) / (b["temp_c"] - a["temp_c"])
    return a["bias"] + share * (b["bias"] - a["bias"])


class Page(BrowserTest, WithStation):
    def go(self, place, ready):
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#{place}")
        self.browser.wait(ready)

    def open_unit(self, serial):
        self.go(urllib.parse.urlencode({"unit": serial}), "return !document.querySelector('#unit-work').hidden")
        self.browser.wait("return document.querySelector('#unit-jobs').ariaBusy === 'false'")

    def click(self, button):
        self.browser.wait("return !document.querySelector(arguments[0]).disabled", button)
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", button)
        self.browser.click(button)

    def done(self, kind):
        """Waits until the newest job is of that kind and has ended."""
        end = time.monotonic() + SEARCH_S
        while not ((jobs := self.soakd.get("jobs")["jobs"]) and (jobs[0]["kind"], jobs[0]["state"]) == (kind, "done")):
            self.assertLess(time.monotonic(), end, jobs)
            time.sleep(0.1)

    def coloured(self):
        """Of all cells of the maps shown: how many are coloured."""
        return self.browser.run("return document.querySelectorAll('#gap-maps td[class]').length")

    def test_a_hidden_effect_is_found_accepted_and_gone(self):
        self.open_unit(LAGGING)
        self.see("#gap-none", "Nobody has searched yet")
        self.browser.type("#user", "Eva")
        self.click("#gap-find")
        self.done("gap_find")
        self.see("#gap-verdict-title", "EFFECT FOUND")
        self.see("#gap-verdict-text", "sensor lag")
        self.see("#gap-effects", "below 1 in a million")
        self.assertEqual(self.browser.run("return document.querySelector('#gap-effects h3').innerText"), "Sensor lag")
        found = self.soakd.get("unit", unit=LAGGING)
        check_schema(found, "http-unit")
        result = found["gap"]["find"]["job"]["result"]
        check_schema(result, "gap-find")
        truth = json.loads((stored_data() / "truth.json").read_text(encoding="utf-8"))["units"][0]["effects"][0]
        self.assertEqual([effect["name"] for effect in result["effects"]], [truth["name"]])
        self.assertEqual(self.browser.run("return document.querySelectorAll('#gap-maps .heat-map').length"), len(result["map"]["sensors"]))
        cells = sum(abs(cell) >= 3 * sigma for sensor in result["map"]["sensors"].values() for row, sigmas in zip(sensor["before"], sensor["sigma"])
                    for cell, sigma in zip(row, sigmas) if cell is not None)
        self.assertEqual(self.coloured(), cells)
        self.assertGreater(cells, 0)
        self.click("label:has(> #gap-map-after)")
        self.assertLess(self.coloured(), cells / 4)
        self.assertNotIn("map", self.soakd.get("jobs")["jobs"][0]["result"])

        self.click("#gap-accept")
        self.see("#accept-dialog", "Model 2 will carry them")
        self.see("#accept-dialog", "nothing is taken")
        self.browser.run("location.hash = 'units'")
        self.browser.wait("return !document.querySelector('#accept-dialog').open")
        self.open_unit(LAGGING)
        self.click("#gap-accept")
        self.browser.click("#accept-cancel")
        self.assertEqual(self.soakd.get("unit", unit=LAGGING)["model"]["version"], 1)
        self.click("#gap-accept")
        self.browser.run("document.querySelector('#accept-effects input').click()")
        self.assertTrue(self.browser.run("return document.querySelector('#accept-send').disabled"), "nothing is chosen")
        self.browser.run("document.querySelector('#accept-effects input').click()")
        self.click("#accept-send")
        self.done("gap_accept")
        self.see("#gap-terms", "sensor lag")
        self.see("#gap-stale", "of before its effects were accepted")
        self.see("#gap-verdict-title", "EFFECT ACCEPTED")
        self.see("#gap-verdict-text", "found sensor lag in model 1. Model 2 carries it.")
        self.see("#unit-jobs", "Accepted: unit SN0042, model 1, sensor lag; made model 2")
        self.assertTrue(self.browser.run("return document.querySelector('#gap-accept').hidden"))

        self.click("#gap-show")
        self.done("gap_show")
        self.see("#gap-shown-text", "on 1 fresh run")
        shown = self.soakd.get("unit", unit=LAGGING)["gap"]["show"]
        self.assertIsNone(shown["stale"])
        check_schema(shown["job"]["result"], "gap-show")
        self.assertEqual(shown["job"]["result"], self.soakd.soak_json("gap", "show", "--unit", LAGGING))
        self.see("#gap-shown-table", "fresh")
        events = self.soakd.get("audit", kind="job_ended", subject=LAGGING)["events"]
        self.assertEqual([(event["user"], event["text"]) for event in events[:2]],
                         [("Eva", "gap_show: done, model 2"), ("Eva", "gap_accept of sensor_lag: done, model 2")])
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_what_was_found_is_said_in_german_and_effects_keep_their_names(self):
        if self.soakd.get("unit", unit=LAGGING)["gap"]["find"] is None:
            self.soakd.ended(self.soakd.post("jobs", kind="gap_find", unit=LAGGING, user="Eva"))
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-language')")
        shown = {}
        for language in ("en", "de"):
            self.browser.go(self.soakd.url)
            self.browser.run("localStorage.setItem('soak-language', arguments[0])", language)
            self.go(f"unit={LAGGING}", "return document.querySelector('#gap-maps table')")
            self.browser.run("document.querySelector('#gap-limits').open = true")
            shown[language] = set(self.browser.run(SHOWN.replace("document.body);", "document.querySelector('#unit-gap'));"))[1:])
        same = {text for text in shown["en"] & shown["de"] if re.search("[A-Za-z]{3}", text) and "tau" not in text}
        self.assertEqual(same, set(), "neither translated nor marked as English")
        self.assertGreater(len(shown["de"]), 40)
        accepted = self.soakd.get("unit", unit=LAGGING)["model"]["terms"] != []  # by another test
        self.see("#gap-verdict-title", "EFFEKT ANGENOMMEN" if accepted else "EFFEKT GEFUNDEN")
        self.see("#gap-verdict-text", f"{'Die Suche in Modell 1 ergab:' if accepted else 'Dem Modell fehlt'} Sensor folgt dem Thermometer verspätet (sensor lag)")
        self.see("#gap-effects", "unter 1 zu 1 Million")
        self.assertEqual(self.browser.run("return document.querySelector('#gap-effects h3').innerText"), "Sensor folgt dem Thermometer verspätet (sensor lag)")
        self.assertEqual(self.browser.run("return getComputedStyle(document.querySelector('#gap-next'), '::first-letter').textTransform"), "none")
        names = re.findall(r"^\| `(\w+)` \|", (ROOT / "docs" / "gap-workflow.md").read_text(encoding="utf-8").split("## The library")[1].split("\n## ")[0], re.M)
        self.assertIn("sensor_lag", names)
        said = self.browser.run("return import('/gap_words.mjs').then(({ G }) => arguments[0].map(G.effect))", names)
        self.assertEqual([text for name, text in zip(names, said, strict=True) if not text.endswith(f" ({name.replace('_', ' ')})")], [])
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_an_effect_that_is_named_after_a_symbol_keeps_it(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        said = self.browser.run("return import('/gap_words.mjs').then(({ G }) => ['g_sensitivity', 'sensor_lag'].map(G.effectTitle))")
        self.assertEqual(said, ["g sensitivity", "Sensor lag"])

    def test_the_fleet_begins_with_the_type_of_most_units_then_with_the_one_looked_at_last(self):
        self.go("fleet", "return document.querySelectorAll('#fleet-sensors .sensor').length === 6")
        self.assertEqual(self.browser.run("return document.querySelector('#fleet-type').value"), "mti-300")
        self.go("fleet=generic", "return document.querySelector('#fleet-type').value === 'generic'")
        self.go("fleet", "return document.querySelector('#fleet-type').value === 'generic'")
        self.browser.run("localStorage.removeItem('soak-fleet-type')")

    def test_an_odd_unit_stands_out_and_its_name_is_text(self):
        self.go("fleet=mti-300", "return document.querySelectorAll('#fleet-sensors .sensor').length === 6")
        self.assertEqual(self.browser.run("return document.querySelector('#to-fleet').ariaCurrent"), "page")
        self.see("#fleet-summary", "1 unit stands out from the others")
        self.see("#fleet-units tbody tr:first-child", ODD)
        self.see("#fleet-units tbody tr:first-child", "bias of gyro x")
        self.see("[aria-labelledby=fleet-of-gyro_x] .legend", ODD)
        self.assertEqual(self.browser.run("return document.querySelectorAll('[aria-labelledby=fleet-of-gyro_x] path.each').length"), FLEET - 1)
        self.assertEqual(self.browser.run("return document.querySelectorAll('main img').length"), 0)
        self.click("#fleet-marked")
        self.browser.wait("return document.querySelectorAll('#fleet-units tbody tr').length === 1")
        self.click("#fleet-marked")
        self.click("label:has(> #fleet-scale)")
        self.see("#fleet-sensors", "accel x")
        self.browser.run("const s = document.querySelector('#fleet-type'); s.value = 'generic'; s.dispatchEvent(new Event('change'))")
        self.see("#fleet-summary", "Only one unit of this type has a model")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_an_odd_unit_of_a_fleet_is_told_in_german(self):
        self.browser.go(self.soakd.url)
        self.browser.run("localStorage.setItem('soak-language', 'de')")
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-language')")
        self.go("fleet=mti-300", "return document.querySelectorAll('#fleet-sensors .sensor').length === 6")
        self.see("#fleet-summary", "1 Prüfling weicht von den anderen ab. Ob sich einer verschoben hat, ist nicht bekannt")
        self.assertRegex(self.browser.text("#fleet-units tbody tr:first-child"), r"Nullpunktfehler, Drehrate x: \d+,\d Streuungen, am weitesten bei −?\d+ °C")
        self.see("[aria-labelledby=fleet-of-gyro_y] .legend", "jeder Prüfling")

    @long_test
    def test_what_is_carried_is_not_accepted_again(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        effects = [{"name": name, "next_experiment": None, "confusable_with": [], "odds": {}} for name in ("sensor_lag", "cross_axis")]
        said = [self.browser.run("const given = arguments; return import('/gap_words.mjs').then((words) => words.gapNextOf(...given).join(''))",
                                 {"verdict": "named", "effects": effects}, carried)
                for carried in ([], ["sensor_lag"], ["sensor_lag", "cross_axis"])]
        self.assertIn("Accept it", said[0])
        self.assertIn("Accept cross axis", said[1])
        self.assertNotIn("ccept", said[2])

    @long_test
    def test_what_asks_for_an_experiment_first_is_not_to_be_accepted_next(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        effects = [{"name": "sensor_lag", "next_experiment": "a slower ramp", "confusable_with": ["moisture"], "odds": {"moisture": 0.02}}]
        decided = [effects[0] | {"odds": {"moisture": 4e-9}}]
        before_odds = [{name: value for name, value in effects[0].items() if name != "odds"}]  # of a document that was kept before they were told
        for effects, carried, accepts in ((effects, [], False), (effects, ["sensor_lag"], True), (decided, [], True), (before_odds, [], False)):
            said = self.browser.run("""const given = arguments; return import('/gap_words.mjs').then((words) => [words.acceptsNext(...given), words.gapNextOf(...given).map((part) => part.english ?? part).join("")])""",
                                    {"verdict": "named", "effects": effects}, carried)
            self.assertEqual(said[0], accepts)
            self.assertEqual("Before you accept" in said[1], not accepts)

    def test_a_rival_that_is_out_is_not_nearly_as_good_nor_worth_an_experiment(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        lag = {"name": "sensor_lag", "magnitude": {"value": 312, "unit": "s"}, "shape": "", "sensors": ["gyro_x"], "next_experiment": "a slower ramp",
               "evidence": {"p_adjusted": 1e-9, "heldout_gain": 0.84}}
        for rivals, row, experiment in (({"moisture": 4e-9}, "nothing else: moisture is ruled out", None), ({"moisture": 4e-9, "cross_axis": 0.1}, "cross axis", "a slower ramp")):
            effect = lag | {"confusable_with": list(rivals), "odds": rivals}
            said = self.browser.run("const [effect] = arguments; return import('/gap_words.mjs').then((w) => [w.evidenceOf(effect).at(-1)[1], w.experimentOf(effect, false)])", effect)
            self.assertEqual(said, [row, experiment])

    def test_accepting_says_what_each_effect_explains_and_which_runs_are_fresh(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        effects = [{"name": name, "next_experiment": None, "confusable_with": [], "odds": {}, "evidence": {"heldout_gain": gain}} for name, gain in (("sensor_lag", 0.84), ("quantization", 0))]
        said = self.browser.run("const [effects] = arguments; return import('/gap_words.mjs').then((w) => [...effects.map(w.shareText), ...w.gapNextOf({ verdict: 'named', effects }, [], 'check48')])", effects)
        self.assertEqual(said, ["explains 84 % of the gap", "explains nothing of the gap: it shows in the single samples only",
                                "Accept it, then compare before and after: campaign check48 has runs that no fit has seen."])

    def told(self, report, carried=()):
        """What a report says first on the page: what was found, how sure that is, what to do next."""
        return self.browser.run("""const [report, carried] = arguments;
          const joined = (parts) => parts.map((part) => part.english ?? part).join("");
          return import('/gap_words.mjs').then((words) => [words.gapText(report, { version: 1, terms: [] }), words.gapSureOf(report, { version: 1, terms: [] }),
            words.gapNextOf(report, carried)].map(joined))""", report, list(carried))

    def report(self, verdict, **members):
        structure = {"axis": "time of day", "kind": "daily_wave", "closer_plateaus_k": None, "p_adjusted": 1e-5, "sensors": ["gyro_y"], "steps": []}
        return {"verdict": verdict, "model": 1, "effects": [], "suspects": [], "reason": "one run only", "held_out": "run", "detection_limit": {"gyro_x": 0.001, "accel_x": 0.002},
                "gap": {"gyro_y": {"before_rms": 0.005, "after_rms": 0.005, "floor_rms": 0.001}},
                "residual_structure": structure | members.pop("structure", {}) if verdict == "unknown" else None, **members}

    @long_test
    def test_three_sentences_stand_first_whatever_the_verdict(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        lag = {"name": "sensor_lag", "magnitude": {"value": 312, "unit": "s"}, "shape": "", "sensors": ["gyro_x"], "confusable_with": ["moisture"], "odds": {"moisture": 0.02},
               "next_experiment": "a slower ramp", "evidence": {"p_adjusted": 1e-9}}
        what, sure, following = self.told(self.report("named", effects=[lag]))
        for wanted, line in (("312 s", what), ("gyro x", what), ("thermometer", what), ("sensor lag", sure), ("moisture", sure), ("a slower ramp", following)):
            self.assertIn(wanted, line)
        _, sure, following = self.told(self.report("named", effects=[lag | {"odds": {"moisture": 4e-9}}]))
        self.assertIn("these runs tell them apart", sure)
        self.assertIn("Accept it", following)
        what, sure, following = self.told(self.report("none"))
        self.assertIn("0.0010 °/s", sure)
        self.assertTrue(what and following)
        what, sure, following = self.told(self.report("cannot_judge"))
        self.assertIn("one run only", sure)
        what, sure, following = self.told(self.report("unknown"))
        for wanted, line in (("time of day", what), ("gyro y", what), ("0.00500 °/s", what), ("building", sure), ("room", following)):
            self.assertIn(wanted, line)
        self.assertIn("10 K", self.told(self.report("unknown", structure={"closer_plateaus_k": 10}))[2])
        self.assertIn("third branch", self.told(self.report("unknown", held_out="half"))[2])
        drift = {"kind": "drift_in_run", "axis": "time of the recording", "runs": None}
        self.assertIn("same cycle once more", self.told(self.report("unknown", held_out="branch", structure=drift))[2])
        sweep = self.told(self.report("unknown", held_out="branch", structure={"kind": "direction_of_sweep", "axis": "direction of the sweep", "runs": None}))
        self.assertIn("ramp rate", sweep[2])
        self.assertNotIn("first position", sweep[2])
        few, many = (self.told(self.report("unknown", structure={"kind": "wander", "runs": runs})) for runs in (3, 4))
        self.assertIn("too few runs", few[1])
        self.assertNotIn("too few runs", many[1])
        self.assertNotIn("four or more", many[2])
        kept = self.report("unknown")  # before there were kinds
        for key in ("kind", "steps", "closer_plateaus_k"):
            del kept["residual_structure"][key]
        what, sure, following = self.told(kept)
        self.assertIn("time of day", what)
        self.assertTrue(following)

    @long_test
    def test_a_step_says_when_and_in_which_sensor(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        steps = [{"run": run, "sensor": "gyro_y", "t_s": 9000.0, "since_start_s": since, "last_before_s": since - 240.0, "temp_c": 25.04, "size": size, "unit": "deg/s"}
                 for run, since, size in (("R2", 600.0, 0.002), ("R3", 7260.0, -0.02))]
        report = self.report("unknown", structure={"kind": "step", "steps": steps})
        what, sure, following = self.told(report)
        for wanted in ("gyro y", "R3", "1 h 57 min to 2 h 1 min", "at a plateau", "25 °C", "0.020 °/s"):
            self.assertIn(wanted, what.replace("2 h 01 min", "2 h 1 min"))
        self.assertEqual(len(self.browser.run("return import('/gap_words.mjs').then((words) => words.stepRows(arguments[0]))", steps)), 2)

    @long_test
    def test_every_kind_is_told_in_both_languages(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        schema = json.loads((ROOT / "docs" / "schema" / "gap-find.schema.json").read_text(encoding="utf-8"))
        kinds = schema["properties"]["residual_structure"]["oneOf"][1]["properties"]["kind"]["enum"]
        for language in ("en", "de"):
            said = self.browser.run("return import(`/text_gap_${arguments[0]}.mjs`).then(({ text }) => arguments[1].flatMap((kind) => [text.kinds(kind, false, 3), text.kinds(kind, true, 6)]))", language, kinds)
            for kind, words in zip([kind for kind in kinds for _ in range(2)], said, strict=True):
                self.assertTrue(words and words["usual"] and words["look"], f"{language}: {kind}")

    def test_slow_noise_stands_beside_the_rest(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        noise = [{"sensor": "gyro_x", "unit": "deg/s", "within_run": 0.0031, "share_minutes": 0.25, "share_hours": 0.75,
                  "bias_instability": {"value": 0.0007, "ci95": [0.0006, 0.0008], "tau_s": 900.0, "campaign": "rest", "run": "R1", "duration_s": 72000.0}},
                 {"sensor": "accel_x", "unit": "m/s2", "within_run": 0.002, "share_minutes": 1.0, "share_hours": 0.0, "bias_instability": None}]
        rows = self.browser.run("return import('/gap_words.mjs').then((words) => words.slowNoiseRows(arguments[0]))", noise)
        self.assertEqual(rows[0][:5], ["gyro x", "0.0031", "°/s", "25 %", "75 %"])
        self.assertIn("0.00070", rows[0][5])
        self.assertEqual(rows[1][5], "–")

    @long_test
    def test_what_takes_nothing_of_the_gap_says_why_it_counts(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        said = [
            self.browser.run("const [name] = arguments; return import('/gap_words.mjs').then((words) => words.outsideText({ name }))", name)
            for name in ("quantization", "sensor_lag")]
        self.assertIn("single samples", said[0])
        self.assertEqual(said[1], "")

    def test_the_log_is_filtered_paged_and_checked(self):
        self.go("events", "return document.querySelector('#audit tbody tr')")
        listed = self.soakd.soak_json("events", "list")["events"]
        rows = "return document.querySelectorAll('#audit tbody tr').length"
        self.assertEqual(self.browser.run(rows), min(100, len(listed)))
        self.browser.run("document.querySelector('#audit-kind').value = 'model_added'")
        self.browser.type("#audit-subject", LAGGING)
        self.click("#audit-send")
        models = [event for event in listed if (event["kind"], event["subject"]) == ("model_added", LAGGING)]
        self.browser.wait(f"{rows} === arguments[0]", len(models))
        self.see("#audit tbody", models[-1]["text"])
        self.assertIn("kind=model_added", self.browser.run("return location.hash"))
        self.click("#audit-clear")
        self.browser.wait(f"{rows} > arguments[0]", len(models))
        self.click("#chain-check")
        self.see("#chain-result", "none changed or missing")
        self.browser.type("#audit-user", "nobody at all")
        self.click("#audit-send")
        self.see("#audit-nothing", "No event is like that. “About” takes what the column shows")
        names = sorted({event["user"] for event in listed if event["user"]})
        self.assertEqual(self.browser.run("return [...document.querySelector('#audit-user').list.options].map(({ value }) => value)"), names)
        self.assertEqual(self.browser.run(rows), 0)
        self.assertEqual(self.browser.console(), [])

    def test_every_kind_of_event_has_a_name_in_both_languages(self):
        source = (ROOT / "station" / "commands" / "events_commands.cpp").read_text(encoding="utf-8")
        kinds = set(re.findall(r'"(\w+)"', re.search(r"kKnownKinds = \{(.*?)\};", source, re.S)[1]))
        self.assertIn("position", kinds)
        self.go("events", "return document.querySelector('#audit tbody tr')")
        for language in ("en", "de"):
            named = self.browser.run("return import(`/text_events_${arguments[0]}.mjs`).then(({ text }) => Object.keys(text.kinds))", language)
            self.assertEqual(kinds - set(named), set(), language)

    @long_test
    def test_older_events_come_page_by_page(self):
        listed = len(self.soakd.soak_json("events", "list")["events"])
        for repair in range(max(0, 105 - listed)):
            self.soakd.soak("unit", "add", "SIM-0002", "--begin-epoch", f"repair {repair}", "--user", "ann")
        everything = self.soakd.soak_json("events", "list")["events"]
        self.go("events", "return document.querySelector('#audit tbody tr')")
        self.assertGreater(len(everything), 100)
        self.assertLess(len(everything), 200)
        # Impatient: the same page must not come twice.
        self.assertTrue(self.browser.run("const older = document.querySelector('#audit-older'); older.click(); older.click(); return older.disabled"))
        self.browser.wait("return !document.querySelector('#audit-older').disabled")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#audit tbody tr').length"), len(everything))
        self.see("#audit tbody tr:last-child", everything[0]["text"])
        self.assertTrue(self.browser.run("return document.querySelector('#audit-older').hidden"))

    def test_every_width_and_both_schemes_can_be_read(self):
        if self.soakd.get("unit", unit=LAGGING)["gap"]["find"] is None:
            self.soakd.ended(self.soakd.post("jobs", kind="gap_find", unit=LAGGING, user="Eva"))
        places = (("fleet=mti-300", "return document.querySelector('#fleet-sensors svg')"), ("events", "return document.querySelector('#audit tbody tr')"))
        wide = "return document.documentElement.scrollWidth - innerWidth"
        self.addCleanup(self.browser.colours, "light")
        for width in (320, 390, 768, 1280, 1920):
            self.browser.resize(width, 900)
            for place, ready in places:
                self.go(place, ready)
                self.assertLessEqual(self.browser.run(wide), 0, f"{place} at {width}")
            self.open_unit(LAGGING)
            self.assertLessEqual(self.browser.run(wide), 0, f"gap at {width}")
        for place, ready in (*places, (f"unit={LAGGING}", "return document.querySelector('#gap-maps table')")):
            self.go(place, ready)
            self.browser.run("for (const box of document.querySelectorAll('details')) box.open = true")
            for scheme in ("light", "dark"):
                self.browser.colours(scheme)
                self.assertEqual(self.browser.poor_contrast(), [], f"{place}, {scheme}")
            nameless = self.browser.run("""
              return [...document.querySelectorAll("a, button, input, select, summary, [tabindex], svg[role=img]")].filter((node) => node.getClientRects().length)
                .filter((node) => !(node.ariaLabel || node.innerText?.trim() || node.labels?.length || node.getAttribute("aria-labelledby")))
                .map((node) => node.outerHTML)""")
            self.assertEqual(nameless, [], place)
        ids = self.browser.run("return [...document.querySelectorAll('[id]')].map((node) => node.id)")
        self.assertEqual(len(ids), len(set(ids)), "ids are unique")


if __name__ == "__main__":
    unittest.main()
