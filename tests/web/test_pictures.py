# SPDX-License-Identifier: Apache-2.0
"""A picture of every page, light and dark, on three screens, for people to look at: in $SOAK_PICTURES (build/check/pictures). A page that has
nothing on it, an error in the console or more than the screen is wide fails."""
import json
import os
import pathlib
import re
import unittest

from lagging_station import LAGGING, ROOT, LaggingStation  # first: see there
from browser import BROWSER, DRIVER, Browser
from guarded_station import GuardedStation
from new_station import NewStation
from page_test import STORED, Station, allan_noise, soak_history
from test_accessibility import DIALOGS, VIEWS
from test_page_station import RATE_1, attitude, set_step, soak_plan

WEB = ROOT / "web"
FOLDER = pathlib.Path(os.environ.get("SOAK_PICTURES", ROOT / "build" / "check" / "pictures"))
SCREENS = {390: 844, 1280: 900, 1920: 1080}
# Until eight frames in a row have the same elements at the same heights.
SETTLED = """return new Promise((done) => {
  let before = "", still = 0;
  const look = () => {
    const all = document.getElementsByTagName("*").length, now = `${all} ${document.documentElement.scrollHeight}`;
    still = now === before ? still + 1 : 0;
    before = now;
    if (still < 8) requestAnimationFrame(look);
    else done();
  };
  look();
});"""
MOST_PX = 6000  # in height: a report goes on for twenty screens
LEAST_LETTERS = 60  # of a page that is there
WORDS = "return (document.querySelector('dialog[open]') ?? document.querySelector('main, body')).innerText"
# Pages of their own, and where their pictures are taken below.
PAGES = {"index": "views and dialogs", "login": "log-in", "setup": "steps"}
OF_THE_STATION = {"abort"}  # the dialog that opens where a campaign runs
HELP_OF_SETUP = "help"  # the dialog of setup.html


def named(pattern, page):
    return re.findall(pattern, (WEB / f"{page}.html").read_text(encoding="utf-8"))


def states(station):
    """Name and state of the station's page, as people see it while a campaign runs and stops."""
    plan = soak_plan()
    for command, document in (("plan", plan), ("history", soak_history()), ("noise", allan_noise()), ("stored", STORED)):
        station.tell(f"{command} {json.dumps(document)}")
    for text in ("campaign acceptance started", "run 2 began", "plateau −20 °C reached", "recording +X"):
        station.tell("log " + text)
    station.set("/clock", RATE_1)
    station.set("/simulated", False)
    for unit in (0, 1):
        station.set(f"/units/{unit}/state", "streaming")
        station.set(f"/units/{unit}/temp_c", -18.7)
        station.set(f"/units/{unit}/attitude", attitude("+X", "+X", True))
    set_step(station, plan, "record", run=1, visit=1, position="+X")
    yield "running"
    for unit in (0, 1):
        station.set(f"/units/{unit}/attitude", attitude("+Y", "+X", False))
    set_step(station, plan, "move", run=1, visit=1, position="+X")
    station.set("/prompt", {"id": 7, "text": "Turn the fixture so that its +X points up, then confirm."})
    station.set("/state", "waiting")
    yield "turn"
    station.set("/prompt", None)
    station.set("/chamber/connected", False)
    station.set("/chamber/air_c", None)
    station.set("/reason", "the chamber does not answer: no answer within 1 s")
    yield "silent"
    station.set("/chamber/connected", True)
    station.set("/chamber/air_c", 24.6)
    for unit in (0, 1):
        station.set(f"/units/{unit}/state", "closed")
        station.set(f"/units/{unit}/temp_c", None)
        station.set(f"/units/{unit}/attitude", None)
    station.set("/campaign", None)
    station.set("/state", "interrupted")
    station.set("/reason", "soakd ended during the campaign")
    station.set("/resumable", "acceptance")
    yield "interrupted"


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        FOLDER.mkdir(parents=True, exist_ok=True)
        for old in FOLDER.glob("*.png"):
            old.unlink()
        cls.browser = Browser("--ignore-certificate-errors")
        cls.addClassCleanup(cls.browser.close)

    def go(self, url):
        self.browser.go("about:blank")
        self.browser.console()  # what a page complains of that was left is nobody's
        self.browser.go(url)

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)

    def shown(self, selector):
        self.browser.wait("return document.querySelector(arguments[0])?.offsetParent", selector)

    def picture(self, name, most_px=MOST_PX):
        """On each screen, in each colour; of the whole page, or of what the screen shows."""
        with self.subTest(page=name):
            for width, height in SCREENS.items():
                self.browser.resize(width, height)
                for scheme in ("light", "dark"):
                    self.browser.colours(scheme)
                    self.browser.run(SETTLED)
                    self.browser.screenshot(FOLDER / f"{name}-{scheme}-{width}.png", most_px)
                self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
            words = self.browser.run(WORDS)
            self.assertGreater(len(words), LEAST_LETTERS)
            self.assertNotRegex(words, r"\bundefined\b|\bNaN\b|\[object ")
            self.assertEqual(self.browser.console(), [])

    def test_nothing_of_the_pages_is_without_a_picture(self):
        self.assertEqual({page.stem for page in WEB.glob("*.html")}, set(PAGES))
        self.assertEqual(set(named(r'<div id="(\w+)-view" class="view"', "index")), set(VIEWS))
        self.assertEqual(set(named(r'<dialog id="(\w+)-dialog"', "index")), set(DIALOGS) | OF_THE_STATION)
        self.assertEqual(named(r'<dialog id="(\w+)"', "setup"), [HELP_OF_SETUP])

    def test_the_station_while_a_campaign_runs_and_stops(self):
        station = Station()
        self.addCleanup(station.close)
        for state in states(station):
            self.browser.resize(1280, 900)
            self.go(station.url)
            self.browser.wait("return document.querySelector('#chart path.unit-1')?.getAttribute('d')")
            if state == "running":
                self.browser.run("document.querySelector('#noise').scrollIntoView()")
                self.browser.wait("return document.querySelector('#noise-chart path')?.getAttribute('d')")
                self.browser.run("scrollTo(0, 0)")
            self.picture(f"station-{state}")
            if state == "running":
                self.browser.click("#abort")
                self.picture("abort", most_px=None)
        self.go("about:blank")

    def test_every_view_of_what_is_stored_and_every_dialog(self):
        soakd = LaggingStation()
        self.addCleanup(soakd.close)
        soakd.work_through()
        names = soakd.names()
        for view, places in VIEWS.items():
            place, selector, text = places[0]
            self.browser.resize(1280, 900)
            self.go(f"{soakd.url}#{place.format(**names)}")
            self.shown(f"#{view}-view")
            self.see(selector, text.format(**names))
            self.picture(view)
            for dialog, (opened_at, button) in DIALOGS.items():
                if opened_at != view:
                    continue
                self.browser.run("document.querySelector(arguments[0]).click()", button)
                self.browser.wait("return document.querySelector(arguments[0]).open", f"#{dialog}-dialog")
                self.picture(dialog, most_px=None)
                self.browser.press("Escape")
        self.go("about:blank")
        for words, name in ((("--unit", LAGGING), "unit"), (("--campaign", "spring"), "campaign")):
            page = soakd.folder / f"{name}.html"
            soakd.soak("report", *words, "-o", page)
            self.go(page.as_uri())
            self.see("h1", words[1])
            self.picture(f"report-{name}")

    def test_the_log_in(self):
        station = GuardedStation()
        self.addCleanup(station.close)
        self.go(station.url)
        self.see("h1", "Log in")
        self.picture("login")
        self.go("about:blank")

    def test_every_step_of_the_set_up(self):
        station = NewStation()
        self.addCleanup(station.close)
        self.go(station.url)
        self.browser.wait("return document.querySelectorAll('#chamber-map option').length > 5")
        for step in named(r'data-step="(\w+)"', "setup"):
            self.browser.run("document.querySelector(arguments[0]).click()", f"#steps [data-step='{step}']")
            self.shown(f"#step-{step}")
            if step == "file":
                self.browser.wait("return document.querySelector('#mistakes li')")
            self.picture(f"setup-{step}")
        self.browser.run("document.querySelector('#steps [data-step=chamber]').click(); document.querySelector('#step-chamber [data-help]').click()")
        self.see("#help-page", "Writing a map")
        self.picture("setup-help", most_px=None)
        self.go("about:blank")


if __name__ == "__main__":
    unittest.main()
