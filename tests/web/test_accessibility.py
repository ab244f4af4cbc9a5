# SPDX-License-Identifier: Apache-2.0
"""axe-core (npm, pinned in package-lock.json) finds nothing serious on any page. Contrast in the dark scheme is looked at by the tests of
the pages; at the width of a telephone where long tests are wanted."""
import json
import pathlib
import re
import shutil
import unittest

import test_units
from browser import LONG_TESTS
from page_test import STORED, PageTest
from real_soakd import ROOT
from test_units import SERIAL, UnitStation

WEB = ROOT / "web"
AXE = pathlib.Path(__file__).resolve().parent / "node_modules" / "axe-core" / "axe.min.js"
SERIOUS = """
return axe.run(document, {resultTypes: ["violations"]}).then(({violations}) => violations
  .filter(({impact}) => impact === "serious" || impact === "critical")
  .flatMap(({id, nodes}) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)} ${node.failureSummary}`)));"""

tearDownModule = test_units.tearDownModule


@unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
class AxeTest(PageTest):
    def assert_nothing_serious(self, what):
        with self.subTest(page=what):
            self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [])


class Live(AxeTest):
    def test_it_finds_what_is_wrong(self):
        self.open()
        self.browser.run("""const picture = document.createElement('img'); picture.src = 'icon.svg'; document.querySelector('main').append(picture);""")
        self.assertRegex("\n".join(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS)), "image-alt")

    def test_the_station(self):
        self.open()
        self.see("#campaign-name", "acceptance")
        self.assert_nothing_serious("running")
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
VIEWS = {"station": (("station", "#stored-campaigns", "verification"),),
         "runs": (("runs", "#runs-view", SERIAL),),
         "run": (("run={run}&unit={unit}", "#run-title", "unit {unit}"),),
         "units": (("units", "#units-list", SERIAL),),
         "unit": (("unit={unit}", "#gap-verdict", " "),),
         "fleet": (("fleet&type=generic", "#fleet-units", SERIAL),),
         "events": (("events", "#events-view table", "job ended"),),
         "records": (("records", "#types", "mti-300"),),
         "help": (("help=operations", "#help-page article h3", "Operating a station"), ("help=gap-workflow", "#help-page article h3", "gap"))}
WIDTHS = (1280, 390) if LONG_TESTS else (1280,)
# Six sensors look alike, and so do the rows of a map; axe-core takes half a minute for all their cells.
ONE_OF_MANY = """
for (const alike of [':is(#gap-maps, #unit-sensors, #fleet-sensors) > :nth-child(n + 2)', '#gap-maps tbody > tr:nth-child(n + 4)'])
  document.querySelectorAll(alike).forEach((node) => node.remove());"""


class Station(UnitStation):
    """With the procedures and types that are shipped."""

    def store_all(self):
        super().store_all()
        shutil.copytree(ROOT / "procedures", self.types, dirs_exist_ok=True)


class Stored(AxeTest):
    """Before a real `soakd` with a unit that was fitted, verified and searched for what its model lacks."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.soakd = Station()
        cls.addClassCleanup(cls.soakd.close)
        for job in ({"kind": "fit"}, {"kind": "verify", "campaign": "verification"}, {"kind": "gap_find"}):
            assert cls.soakd.ended(cls.soakd.post("jobs", unit=SERIAL, user="Eva", **job))["state"] == "done"

    def setUp(self):
        self.browser.resize(1280, 900)

    def assert_nothing_serious_at_any_width(self, what):
        for width in WIDTHS:
            self.browser.resize(width, 900)
            self.assert_nothing_serious(f"{what}, {width} pixels wide")

    def test_every_view(self):
        views = re.findall(r'<div id="(\w+)-view" class="view"', (WEB / "index.html").read_text(encoding="utf-8"))
        self.assertEqual(set(views), set(VIEWS))
        names = {"run": self.soakd.get("runs", unit=SERIAL)["runs"][0]["run_id"], "unit": SERIAL}
        for view in views:
            for place, selector, text in VIEWS[view]:
                self.browser.go("about:blank")
                self.browser.go(f"{self.soakd.url}#{place.format(**names)}")
                self.browser.wait("return document.querySelector(arguments[0]).offsetParent !== null", f"#{view}-view")
                self.see(selector, text.format(**names))
                self.browser.run(ONE_OF_MANY)
                self.assert_nothing_serious_at_any_width(place)

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
        self.browser.type("#start-slots input", SERIAL)
        self.see("#start-review", f"{SERIAL}, type generic")
        self.assert_nothing_serious_at_any_width("checked")

    def test_a_report(self):
        for words, name in ((("--unit", SERIAL), "unit"), (("--campaign", "campaign"), "campaign")):
            page = self.soakd.folder / f"{name}.html"
            self.soakd.soak("report", *words, "-o", page)
            self.browser.go(page.as_uri())
            self.see("h1", "SIM-0001" if name == "unit" else "campaign")
            self.assert_nothing_serious(f"report of a {name}")


if __name__ == "__main__":
    unittest.main()
