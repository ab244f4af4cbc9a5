# SPDX-License-Identifier: Apache-2.0
"""The views of what is stored, in German before a real `soakd` ($SOAK_BIN_FOLDER): no text is left in English that is not marked as such, and
the English page has no German."""
import pathlib
import re
import sys
import unittest
import urllib.parse

from browser import BROWSER, DRIVER, Browser
from test_runs import HOSTILE, StoredRuns  # first: others put a folder in front that has a module of this name, too
from test_accessibility import AXE, SERIOUS
from test_language import SHOWN

# Words that both languages write alike; names and numbers of the stored runs are nobody's language.
SAME = {"Soak", "Station", "English", "Deutsch", "Plateau", "SN1", "import", HOSTILE, "spring", "paused"}
DATA = re.compile(r"(import )?R0\d(\.csv)?|[✕△– ]*[+−][XYZ]|[0-9a-f]{8}-[0-9a-f-]+|[^A-Za-z]*(°C|h|min|s|Hz|m/s²)?[^A-Za-z]*|\d+ (h|min) \d+ (min|s)|Soak \d\S*")
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


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Runs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soakd, cls.browser = StoredRuns(), Browser()
        for thing in (cls.soakd, cls.browser):
            cls.addClassCleanup(thing.close)
        cls.places = places(cls.soakd)

    def setUp(self):
        self.browser.resize(1280, 900)

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

    def test_the_list(self):
        self.assert_two_languages("list")

    def test_a_run_with_its_segments(self):
        self.assert_two_languages("run")

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

    def test_a_view_that_somebody_goes_to_has_the_focus_on_its_title_once_that_has_words(self):
        go(self.browser, self.soakd, "de", "station", "return true")
        self.browser.click("#to-runs")
        self.browser.wait("return document.activeElement.id === 'runs-title' && document.activeElement.innerText === 'Kampagnen und Läufe'")

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_nothing_serious_is_found_and_nothing_is_wider_than_the_screen(self):
        for view in self.places:
            self.go("de", view)
            for width in (1280, 390):
                self.browser.resize(width, 900)
                with self.subTest(view=view, width=width):
                    self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
                    self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [])

    def test_the_first_view_weighs_at_most_300_kb(self):
        go(self.browser, self.soakd, "de", "station", "return document.querySelectorAll('#start-choice option').length > 0")
        sizes = self.browser.run("""const all = [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')];
            return all.filter(({ name }) => !name.includes('/api/')).map(({ name, decodedBodySize }) => [name, decodedBodySize]);""")
        self.assertGreater(len(sizes), 20)
        self.assertFalse([name for name, _ in sizes if re.search("run_view|text_runs|dygraph.min.js", name)])
        self.assertLessEqual(sum(size for _, size in sizes), 300_000, sizes)


def take_pictures(folder):
    """Pictures of the German views for people to look at: test_language_views.py --pictures FOLDER."""
    soakd, browser = StoredRuns(), Browser()
    for scheme in ("light", "dark"):
        browser.colours(scheme)
        for view, (place, ready) in places(soakd).items():
            go(browser, soakd, "de", place, ready)
            for width in (1280, 390):
                browser.resize(width, 900)
                browser.screenshot(pathlib.Path(folder) / f"de-{view}-{width}-{scheme}.png")
    browser.close()
    soakd.close()


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--pictures":
        take_pictures(sys.argv[2])
    else:
        unittest.main()
