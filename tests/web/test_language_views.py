# SPDX-License-Identifier: Apache-2.0
"""The views of what is stored, in German before a real `soakd` ($SOAK_BIN_FOLDER): no text is left in English that is not marked as such, and
the English page has no German."""
import getpass
import re
import shutil
import unittest
import urllib.parse

from browser import BROWSER, DRIVER, Browser, long_test
from test_runs import HOSTILE, StoredRuns  # first: others put a folder in front that has a module of this name, too
from test_accessibility import AXE, SERIOUS
from test_language import ROOT, SHOWN
from test_units import HOSTILE as UNIT_NAMES, OTHER, SERIAL, UnitStation, stored_units

REFERENCE = "K-17"  # name and certificate
# Words that both languages write alike; names and numbers of the stored runs are nobody's language.
SAME = {getpass.getuser(), "Soak", "Station", "English", "Deutsch", "Plateau", "SN1", "import", HOSTILE, "spring", "paused", "generic", "Export", "Eva", SERIAL, OTHER, REFERENCE, "Name", *UNIT_NAMES}
DATA = re.compile(r"(import )?R0\d(\.csv)?|[✕△– ]*[+−][XYZ]|[0-9a-f]{8}-[0-9a-f-]+|[^A-Za-z]*(°C|K|h|m|min|s|Hz|m/s²|Eva)?[^A-Za-z]*|\d+ (h|min) \d+ (min|s)|Soak \d\S*")
GERMAN = re.compile(r"[äöüß]|\b(der|die|das|und|nicht|kein|Lauf|von|Prüfling|ungültig|\d+,\d+ (?:Hz|°C|h|m))\b")


def places(soakd):
    """Address and what shows that the view is there, by name; of the run with a segment that the data gate refused."""
    run = next(run for run in soakd.get("runs")["runs"] if run["run"] == "R01")
    name = urllib.parse.urlencode({"run": run["run_id"], "unit": run["unit"]})
    return {"list": ("runs", "return document.querySelectorAll('#runs-campaigns .runs tbody tr').length >= 3"),
            "run": (name, "return document.querySelector('#segments tbody tr') && document.querySelector('#strip').ariaBusy === 'false' && "
                          "document.querySelector('#strip-panels canvas')")}


def go(browser, soakd, language, place, ready):
    browser.go(soakd.url)
    browser.run("localStorage.setItem('soak-language', arguments[0])", language)
    browser.go("about:blank")
    browser.go(f"{soakd.url}#{place}")
    browser.wait(ready)
    browser.wait("return document.querySelector('#version').innerText.startsWith('Soak 0')")


def unit_places(_):
    name = urllib.parse.urlencode({"unit": SERIAL})
    return {"units": ("units", "return document.querySelector('#units-list tbody tr')"),
            "events": ("events", "return document.querySelector('#audit tbody tr')"),
            "records": ("records", "return document.querySelectorAll('#references tbody tr').length === 2 && document.querySelector('#types tbody tr') && "
                                   "document.querySelector('#key-form').offsetParent && document.querySelector('#alarms-none').offsetParent"),
            "fleet": ("fleet=generic", "return document.querySelectorAll('#fleet-sensors svg').length === 6"),
            "unit": (name, "return document.querySelectorAll('#unit-sensors .sensor').length === 6 && document.querySelector('#unit-impact h2') && "
                           "document.querySelector('#unit-jobs').ariaBusy === 'false'")}


class JudgedUnit(UnitStation):
    """A station with a unit that is fitted and verified."""

    def __init__(self):
        super().__init__()
        for job in ({"kind": "fit"}, {"kind": "verify", "campaign": "verification"}):
            self.ended(self.post("jobs", unit=SERIAL, user="Eva", **job))
        for kind, due, value in (("gravity", "2099-03-02", 9.8123), ("level", "2025-03-02", 0.0125)):
            self.post("references/add", kind=kind, name=REFERENCE, certificate=REFERENCE, issued="2024-03-01", due=due, uncertainty=0.002, k=2, correction=value, user="Eva")


def tearDownModule():
    if stored_units.cache_info().currsize:
        shutil.rmtree(stored_units(), ignore_errors=True)


class Views(unittest.TestCase):
    """Views of one station, in both languages."""

    def setUp(self):
        self.browser.resize(1280, 900)

    @classmethod
    def begin(cls, soakd, find_places):
        cls.soakd, cls.browser = soakd, Browser()
        for thing in (cls.soakd, cls.browser):
            cls.addClassCleanup(thing.close)
        cls.places = find_places(cls.soakd)

    def go(self, language, view):
        go(self.browser, self.soakd, language, *self.places[view])

    def shown(self):
        return {text for text in self.browser.run(SHOWN) if text not in SAME and not DATA.fullmatch(text)}

    def assert_two_languages(self, view, act=""):
        texts = {}
        for language in ("en", "de"):
            self.go(language, view)
            self.browser.run(act)
            texts[language] = self.shown()
        self.assertGreater(len(texts["de"]), 10)
        self.assertEqual(texts["en"] & texts["de"], set(), "neither translated nor marked as English")
        self.assertEqual([text for text in texts["en"] if GERMAN.search(text)], [])
        self.assertGreater(len([text for text in texts["de"] if GERMAN.search(text)]), 5)

    def assert_accessible_and_not_too_wide(self):
        for view in self.places:
            self.go("de", view)
            for width in (1280, 390):
                self.browser.resize(width, 900)
                with self.subTest(view=view, width=width):
                    self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
                    self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [])


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Runs(Views):
    @classmethod
    def setUpClass(cls):
        cls.begin(StoredRuns(), places)

    def test_the_list(self):
        self.assert_two_languages("list")

    def test_a_run_with_its_segments(self):
        self.assert_two_languages("run")

    @long_test
    def test_what_becomes_void(self):
        self.assert_two_languages("run", "document.querySelector('#segments tbody .actions button[data-needs]').click()")

    def test_a_finding_has_a_german_name_and_the_stations_own_words(self):
        self.go("de", "run")
        self.browser.wait_for_text("#segments", "falsche Lage: ")
        why = self.browser.run("const row = document.querySelector('#segments tr[data-kind=refused]'); return [row.innerText, row.querySelector('[lang=en]').innerText]")
        self.assertIn("abgelehnt", why[0])
        self.assertRegex(why[1], r"\b(the|is|of)\b")

    def test_what_the_station_refuses_is_marked_as_english(self):
        go(self.browser, self.soakd, "de", "run=none&unit=none", "return document.querySelector('#run-failure').innerText")
        self.assertEqual(self.browser.run("return document.querySelector('#run-failure').lang"), "en")

    @long_test
    def test_a_view_that_somebody_goes_to_has_the_focus_on_its_title_once_that_has_words(self):
        go(self.browser, self.soakd, "de", "station", "return true")
        self.browser.click("#to-runs")
        self.browser.wait("return document.activeElement.id === 'runs-title' && document.activeElement.innerText === 'Kampagnen und Läufe'")

    def test_what_can_be_done_with_a_segment_is_whole_on_a_telephone(self):
        self.go("de", "run")
        self.browser.resize(390, 900)
        cut = self.browser.run("""const edge = document.querySelector('#segments-card .scroll').getBoundingClientRect().right;
            return [...document.querySelectorAll('#segments .actions button')].filter((node) => node.scrollWidth > node.clientWidth || node.getBoundingClientRect().right > edge).length""")
        self.assertEqual(cut, 0)

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_nothing_serious_is_found_and_nothing_is_wider_than_the_screen(self):
        self.assert_accessible_and_not_too_wide()

    def test_the_first_view_weighs_at_most_300_kb(self):
        go(self.browser, self.soakd, "de", "station", "return document.querySelectorAll('#start-choice option').length > 0")
        sizes = self.browser.loaded()
        self.assertGreater(len(sizes), 20)
        self.assertFalse([name for name, _ in sizes if re.search("run_view|text_runs|dygraph.min.js", name)])
        self.assertLessEqual(sum(size for _, size in sizes), 300_000, sizes)


# Warnings whose remedy names a command in a terminal, where the page has a button: it names that.
ON_THE_PAGE = {"runs_left_since", "copied_runs"}


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Units(Views):
    @classmethod
    def setUpClass(cls):
        cls.begin(JudgedUnit(), unit_places)

    def test_the_list_of_units(self):
        self.assert_two_languages("units")

    def test_a_unit_with_its_verdict_curves_and_jobs(self):
        self.assert_two_languages("unit", "document.querySelector('#unit-warnings-rest').open = true")

    def test_a_fleet(self):
        for curve in ("bias", "scale"):
            with self.subTest(curve=curve):
                self.assert_two_languages("fleet", f"document.querySelector('#fleet-{curve}').click()")

    def test_the_event_log(self):
        self.assert_two_languages("events")

    def test_the_records(self):
        self.assert_two_languages("records", "document.querySelector('#reference-form').closest('details').open = true")

    @long_test
    def test_a_reference_with_its_date_and_numbers_and_what_retires_it(self):
        self.go("de", "records")
        rows = self.browser.run("return [...document.querySelectorAll('#references tbody tr')].map((row) => row.innerText)")
        for row, parts in zip(sorted(rows), (("Horizontierung", "abgelaufen", "02.03.2025", "0,0125 °"), ("Örtliche Fallbeschleunigung", "gültig", "02.03.2099", "9,8123 m/s²", "0,001 m/s²"))):
            for part in parts:
                self.assertIn(part, row)
        self.assert_two_languages("records", "document.querySelector('#references button').click()")
        self.browser.wait_for_text("#retire-text", f"„{REFERENCE}“")

    @long_test
    def test_what_the_station_says_of_a_certificate_is_marked_as_english(self):
        self.go("de", "records")
        self.browser.run("""document.querySelector('#reference-form').closest('details').open = true;
            for (const [name, value] of Object.entries({name: 'g', certificate: 'G', issued: '2026-01-01', due: '2025-01-01', uncertainty: '1', user: 'Eva'}))
              document.querySelector(`#reference-${name}`).value = value;
            document.querySelector('#reference-form').requestSubmit();""")
        self.browser.wait_for_text("#reference-failure[lang=en]", "after the date of issue")

    def test_events_and_what_the_check_of_their_chain_finds(self):
        self.go("de", "events")
        newest = self.soakd.get("audit")["events"][0]
        said = self.browser.run("return [...document.querySelectorAll('#audit tbody tr:first-child [lang=en]')].map((node) => node.textContent)")
        self.assertEqual(said, [newest["text"]])
        self.browser.click("#chain-check")
        count = len(self.soakd.soak_json("events", "list")["events"])
        self.browser.wait_for_text("#chain-result", f"Ereignisse: {count}, keines verändert oder entfernt. Ende der Kette: ")

    def test_a_verdict_and_what_follows_from_it(self):
        self.go("de", "unit")
        self.browser.wait_for_text("#unit-verdict", "BESTANDEN")
        self.browser.wait_for_text("#unit-verdict", "alle Sensoren liegen innerhalb ihrer Grenzwerte")
        self.browser.wait_for_text("#unit-jobs", f"Verifizierung: Prüfling {SERIAL}, Modell 1, Kampagne verification")

    def test_every_warning_is_said_by_its_code(self):
        source = (ROOT / "calib" / "judge" / "detail" / "report_words.cpp").read_text(encoding="utf-8")
        remedies = {code: "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', text)) for code, text in re.findall(r'Remedy\{"(\w+)",(.*?)\}', source, re.S)}
        self.assertGreater(len(remedies), 50)
        self.go("de", "unit")
        said = self.browser.run("""return import('/unit_words.mjs').then(({ U }) =>
            arguments[0].map((code) => [code, U.warnings.name(code), U.warnings.remedy(code, 'in English')]));""", list(remedies))
        for code, name, remedy in said:
            with self.subTest(code=code):
                self.assertGreater(len(name), 3)
                self.assertIsInstance(remedy, str, "no German remedy")
                commands = re.findall(r"soak [a-z]+(?: [a-z]+)?(?=[.,;:)]|$)|[a-z]+(?:-[a-z]+){2,}", remedies[code])
                for command in commands:
                    if code in ON_THE_PAGE:
                        self.assertNotIn("soak ", remedy, "the page has a button for it")
                        continue
                    self.assertIn(command, remedy)
                    remedy = remedy.replace(command, "")
                self.assertNotRegex(f"{name}. {remedy}", r"\b(the|of|and|is|are|with|from|by|this|that|again|runs?|fit|no|not)\b")

    def test_a_warning_is_said_in_german_or_keeps_the_stations_own_words(self):
        self.go("de", "unit")
        unit = self.soakd.get("unit", unit=SERIAL)
        lines = self.browser.run("""return [...document.querySelectorAll('#unit-warnings li, #unit-warnings-rest-list li')]
            .map((line) => [line.textContent, line.querySelector('[lang=en]')?.textContent ?? null])""")
        self.assertIn("simulated", [warning["code"] for warning in unit["warnings"]])
        self.assertTrue(any("simulierte Daten: Das Modell stammt aus SIMULIERTEN Daten" in text and own is None for text, own in lines), lines)
        others = [own for text, own in lines if "simulierte Daten" not in text]
        self.assertGreater(len(others), 0)
        self.assertNotIn(None, others)
        self.assertEqual(self.browser.run("return import('/unit_words.mjs').then(({ U }) => [U.warnings.name('of_tomorrow'), U.warnings.remedy('of_tomorrow', 'Do this.')])"),
                         ["", {"english": "Do this."}])

    @long_test
    def test_a_curve_that_is_not_known_keeps_its_name(self):
        self.go("de", "unit")
        said = self.browser.run("return import('/unit_words.mjs').then(({ U }) => ['poly3', 'constructor', 'toString'].map((name) => String(U.sensors.kind(name))))")
        self.assertEqual(said, ["Polynom 3. Grades", "constructor", "toString"])

    @long_test
    def test_what_a_job_that_fails_says_is_marked_as_english(self):
        self.go("de", "unit")
        self.browser.run("document.querySelector('#unit-export').click()")
        self.browser.wait_for_text("#job-failure", "SIMULIERTEN")
        self.browser.run("""return fetch('/api/v1/jobs', {method: 'POST', headers: {'Content-Type': 'application/json'},
            body: JSON.stringify({kind: 'export', unit: arguments[0], format: 'blob', user: 'Eva'})}).then(({ok}) => ok);""", SERIAL)  # which soak refuses
        self.go("de", "unit")
        self.browser.wait_for_text("#unit-jobs li:first-child", "gescheitert")
        self.assertRegex(self.browser.run("return document.querySelector('#unit-jobs li:first-child p[lang=en]').innerText"), "SIMULATED")

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_nothing_serious_is_found_and_nothing_is_wider_than_the_screen(self):
        self.assert_accessible_and_not_too_wide()


if __name__ == "__main__":
    unittest.main()
