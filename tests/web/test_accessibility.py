# SPDX-License-Identifier: Apache-2.0
"""axe-core (npm, pinned in package-lock.json) finds nothing serious on any page nor in any dialog; in the dark, of its rules the one about
colours. At the width of a telephone where long tests are wanted. The log-in and the set-up are looked at by their own tests."""
import json
import pathlib
import re
import unittest

from lagging_station import LAGGING, ROOT, LaggingStation  # first: see there
from browser import LONG_TESTS
from page_test import STORED, PageTest

WEB = ROOT / "web"
AXE = pathlib.Path(__file__).resolve().parent / "node_modules" / "axe-core" / "axe.min.js"
SERIOUS = """
const [where, rules] = arguments;
return axe.run(where ?? document, {resultTypes: ["violations"], ...(rules && {runOnly: rules})}).then(({violations}) => violations
  .filter(({impact}) => impact === "serious" || impact === "critical")
  .flatMap(({id, nodes}) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)} ${node.failureSummary}`)));"""


def serious(browser, where=None):
    """What axe-core finds in the page, or in what a selector names: every rule in the light, that about colours in the dark."""
    script = AXE.read_text(encoding="utf-8") + SERIOUS
    found = browser.run(script, where)
    browser.colours("dark")
    found += [f"dark: {text}" for text in browser.run(script, where, ["color-contrast"])]
    browser.colours("light")
    return found


@unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
class AxeTest(PageTest):
    def assert_nothing_serious(self, what, where=None):
        with self.subTest(page=what):
            self.assertEqual(serious(self.browser, where), [])


class Live(AxeTest):
    def test_it_finds_what_is_wrong(self):
        self.open()
        self.browser.run("""const picture = document.createElement('img'); picture.src = 'icon.svg'; document.querySelector('main').append(picture);""")
        self.assertRegex("\n".join(serious(self.browser)), "image-alt")

    def test_the_station(self):
        self.open()
        self.see("#campaign-name", "acceptance")
        self.assert_nothing_serious("running")
        self.browser.click("#abort")
        self.assert_nothing_serious("abort", "dialog[open]")
        self.browser.press("Escape")
        self.station.set("/chamber/alarms", ["over-temperature"])
        self.station.set("/prompt", {"id": 1, "text": "Turn the fixture to +X"})
        self.see("#alert-list", "over-temperature")
        self.see("#prompt-text", "Turn")
        self.assert_nothing_serious("alarm")
        self.station.set("/state", "idle")
        self.station.set("/campaign", None)
        self.station.set("/prompt", None)
        self.station.set("/chamber/alarms", [])
        self.station.tell("stored " + json.dumps(STORED))
        self.open()
        self.see("#stored-campaigns", "2026-10")
        self.assert_nothing_serious("idle")

    def test_the_help(self):
        for page in ("operations", "gap-workflow"):
            self.browser.go(f"{self.station.url}#help={page}")
            self.browser.wait("return document.querySelector('#help-page [aria-current]')?.hash === arguments[0]", f"#help={page}")
            self.assert_nothing_serious(f"help {page}")


# Views of index.html: where each is, and what is seen there once it is whole.
VIEWS = {"station": (("station", "#stored-campaigns", "check"),),
         "runs": (("runs", "#runs-view", LAGGING),),
         "run": (("run={run}&unit={run_unit}", "#segments", "+X"),),
         "units": (("units", "#units-list", LAGGING),),
         "unit": (("unit={unit}", "#gap-verdict-text", "sensor lag"),),
         "fleet": (("fleet&type=generic", "#fleet-units", LAGGING),),
         "events": (("events", "#events-view table", "job ended"),),
         "records": (("records", "#types", "mti-300"),),
         "help": (("help=operations", "#help-page article h3", "Operating a station"), ("help=gap-workflow", "#help-page article h3", "gap"))}
# Dialogs of those views: where each is opened, and by which button.
DIALOGS = {"void": ("run", "#segments .actions button[data-needs]"), "repair": ("unit", "#unit-repair"), "withdraw": ("unit", "#unit-withdraw"),
           "accept": ("unit", "#gap-accept"), "sure": ("units", "#units-release"), "retire": ("records", "#references button")}
WIDTHS = (1280, 390) if LONG_TESTS else (1280,)
# Only for time: six sensors look alike, and so do the rows of a map; axe-core takes half a minute for all their cells. Long tests see them all.
ONE_OF_MANY = "" if LONG_TESTS else """
for (const alike of [':is(#gap-maps, #unit-sensors, #fleet-sensors) > :nth-child(n + 2)', '#gap-maps tbody > tr:nth-child(n + 4)'])
  document.querySelectorAll(alike).forEach((node) => node.remove());"""


class Stored(AxeTest):
    """Before a real `soakd` with a unit that was fitted, verified and searched for what its model lacks."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.soakd = LaggingStation()
        cls.addClassCleanup(cls.soakd.close)
        cls.soakd.work_through()

    def setUp(self):
        self.browser.resize(1280, 900)

    def assert_nothing_serious_at_any_width(self, what):
        for width in WIDTHS:
            self.browser.resize(width, 900)
            self.assert_nothing_serious(f"{what}, {width} pixels wide")

    def test_every_view_and_the_dialogs_that_open_there(self):
        views = re.findall(r'<div id="(\w+)-view" class="view"', (WEB / "index.html").read_text(encoding="utf-8"))
        self.assertEqual(set(views), set(VIEWS))
        names = self.soakd.names()
        for view in views:
            for place, selector, text in VIEWS[view]:
                self.browser.go("about:blank")
                self.browser.go(f"{self.soakd.url}#{place.format(**names)}")
                self.browser.wait("return document.querySelector(arguments[0]).offsetParent !== null", f"#{view}-view")
                self.see(selector, text.format(**names))
                self.browser.run(ONE_OF_MANY)
                self.assert_nothing_serious_at_any_width(place)
            for dialog in (name for name, (opened_at, _) in DIALOGS.items() if opened_at == view):
                self.browser.run("document.querySelector(arguments[0]).click()", DIALOGS[dialog][1])
                self.browser.wait("return document.querySelector(arguments[0]).open", f"#{dialog}-dialog")
                self.assert_nothing_serious(dialog, "dialog[open]")
                self.browser.press("Escape")

    def test_a_new_campaign_with_its_check(self):
        self.browser.go("about:blank")
        self.browser.go(self.soakd.url)
        self.browser.wait("return document.querySelectorAll('#start-choice option').length > 5")
        self.browser.run("""const choice = document.querySelector('#start-choice'); choice.value = 'six-position-soak.toml';
            for (const kind of ['input', 'change']) choice.dispatchEvent(new Event(kind, { bubbles: true }));""")
        self.browser.type("#start-slots input", "SN0043")
        self.see("#start-review", "the type of unit SN0043 is not known")
        self.assert_nothing_serious_at_any_width("refused")
        self.browser.run("document.querySelector('#start-slots input').value = ''")
        self.browser.type("#start-slots input", LAGGING)
        self.see("#start-review", f"{LAGGING}, type generic")
        self.assert_nothing_serious_at_any_width("checked")

    def test_a_report(self):
        for words, name in ((("--unit", LAGGING), "unit"), (("--campaign", "spring"), "spring")):
            page = self.soakd.folder / f"{name}.html"
            self.soakd.soak("report", *words, "-o", page)
            self.browser.go(page.as_uri())
            self.see("h1", words[1])
            self.assert_nothing_serious(f"report of {name}")


if __name__ == "__main__":
    unittest.main()
