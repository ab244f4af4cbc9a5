# SPDX-License-Identifier: Apache-2.0
"""axe-core (npm, pinned in package-lock.json) finds nothing serious on any page. Contrast in the dark scheme is looked at by the tests of
the pages."""
import json
import pathlib
import shutil
import unittest

import test_units
from page_test import STORED, PageTest
from real_soakd import Soakd
from test_units import SERIAL

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


class StoredUnits(Soakd):
    def store_all(self):
        shutil.copytree(test_units.stored_units() / "data", self.data)
        self.soak("fit", "--unit", SERIAL)


class Stored(AxeTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.soakd = StoredUnits()
        cls.addClassCleanup(cls.soakd.close)

    def setUp(self):
        self.browser.resize(1280, 900)

    def test_what_is_stored(self):
        run = self.soakd.get("runs", unit=SERIAL)["runs"][0]["run_id"]
        for place, selector, text in (("runs", "#runs-view", SERIAL), (f"run={run}&unit={SERIAL}", "#run-title", f"unit {SERIAL}"), ("units", "#units-list", SERIAL),
                                      (f"unit={SERIAL}", "#unit-verdict", "NOT JUDGED")):
            self.browser.go(f"{self.soakd.url}#{place}")
            self.see(selector, text)
            self.assert_nothing_serious(place)

    def test_a_report(self):
        for words, name in ((("--unit", SERIAL), "unit"), (("--campaign", "campaign"), "campaign")):
            page = self.soakd.folder / f"{name}.html"
            self.soakd.soak("report", *words, "-o", page)
            self.browser.go(page.as_uri())
            self.see("h1", "SIM-0001" if name == "unit" else "campaign")
            self.assert_nothing_serious(f"report of a {name}")


if __name__ == "__main__":
    unittest.main()
