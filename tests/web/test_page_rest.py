# SPDX-License-Identifier: Apache-2.0
"""The page of a station that rests: what it has stored, and the form that starts or queues a campaign."""
import datetime
import json
import pathlib
import tempfile
import unittest

from browser import long_test
from page_test import STORED
from test_page_station import StationTest


class AtRest(StationTest):
    def rest(self):
        self.station.set("/state", "idle")
        self.station.set("/campaign", None)
        self.station.tell("stored " + json.dumps(STORED))
        self.open()
        self.see("#stored-campaigns", "2026-10")

    def test_it_shows_what_is_stored(self):
        self.rest()
        self.see("#stored-campaigns", "finished")
        self.see("#stored-units", "mti-300")
        self.see("#stored-units", "<b>x</b>")
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('#stored-units tbody a')].map((link) => [link.textContent, new URLSearchParams(link.hash.slice(1)).get('unit')])"),
                         [[unit["serial"]] * 2 for unit in STORED["units"]])
        self.assertEqual(self.browser.console(), [])
        self.station.tell("status " + json.dumps({**self.status(), "state": "running"}))
        self.hidden("#idle")

    def test_what_could_not_be_read_is_asked_for_again(self):
        once = """
          const real = window.fetch;
          let failures = 1;
          window.fetch = (path, ...more) =>
            String(path).endsWith("stored") && failures-- > 0 ? Promise.reject(new Error("no connection")) : real(path, ...more);"""
        script = self.browser.devtools("Page.addScriptToEvaluateOnNewDocument", source=once)
        self.addCleanup(self.browser.devtools, "Page.removeScriptToEvaluateOnNewDocument", **script)
        self.rest()
        self.browser.console()  # the page notes the failure there

    def test_a_view_that_cannot_be_loaded_is_said(self):
        self.rest()
        self.browser.devtools("Network.enable")
        self.addCleanup(self.browser.devtools, "Network.disable")
        self.browser.devtools("Network.setBlockedURLs", urls=["*fleet_view*"])
        self.browser.click("#to-fleet")
        self.shown("#view-failure")
        self.see("#view-failure", "could not be loaded")
        self.browser.click("#to-station")
        self.hidden("#view-failure")
        self.browser.console()  # the page notes the failure there

    @long_test
    def test_a_view_that_could_not_be_loaded_is_loaded_when_somebody_goes_there_again(self):
        for missing in ("text_fleet_en", "text_runs_en", "fleet_words", "fleet_view"):
            with self.subTest(missing=missing):
                self.rest()
                self.browser.devtools("Network.enable")
                self.addCleanup(self.browser.devtools, "Network.disable")
                self.browser.devtools("Network.setBlockedURLs", urls=[f"*{missing}*"])
                self.browser.click("#to-fleet")
                self.shown("#view-failure")
                self.browser.devtools("Network.setBlockedURLs", urls=[])
                self.browser.click("#to-station")
                self.browser.click("#to-fleet")
                self.see("#fleet-failure", "the station has no data folder")  # what that view says here
                self.hidden("#view-failure")
                self.browser.console()  # the page notes the failure there

    @long_test
    def test_what_was_stored_in_another_year_has_its_year(self):
        self.rest()
        self.assertNotIn(str(datetime.datetime.fromtimestamp(1789800000.0).year), self.text("#stored-campaigns td:nth-child(3)"))
        stored = json.loads(json.dumps(STORED))
        stored["campaigns"][0]["begun_utc_s"] -= 366 * 86400.0
        self.station.tell("stored " + json.dumps(stored))
        self.open()
        year = datetime.datetime.fromtimestamp(stored["campaigns"][0]["begun_utc_s"]).year
        self.see("#stored-campaigns td:nth-child(3)", str(year))

    def test_what_is_stored_fits_narrow_screens(self):
        self.rest()
        for width in (320, 390, 768, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)

    def test_a_campaign_is_started_from_the_page(self):
        self.rest()
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as procedure:
            procedure.write("name = 'short'")
            procedure.flush()
            self.browser.type("#start-procedure", procedure.name)
            self.browser.type("#start-name", "2026-11")
            self.browser.type("#start-slots > :nth-child(2) input", "SN0077")
            self.browser.press("Enter")  # as a scanner ends a serial number
            self.assertEqual(self.browser.run("return document.activeElement.id"), "start-send")
            self.assertEqual([command for command in self.station.commands() if command.startswith("start")], [])
            name = pathlib.Path(procedure.name).name
            self.browser.press("Enter")
            self.station.wait_for_command(f"start 2026-11 {name} [name = 'short'] 1=SN0042 2=SN0077 by web page")

    def test_the_units_of_the_last_campaign_are_offered_where_nothing_was_entered(self):
        self.rest()
        self.see("#start-last", "As last time: SN0043")
        self.browser.click("#start-last")
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('#start-slots input')].map(({ value }) => value)"), ["SN0042", "SN0043"])
        self.hidden("#start-last")

    @long_test
    def test_without_a_connection_nothing_can_be_started_or_taken_out_and_no_question_stays(self):
        self.station.set("/prompt", {"id": 7, "text": "Turn the fixture."})
        self.open()
        self.see("#prompt-text", "Turn the fixture.")
        inert = "return ['queue-list', 'start-card'].map((id) => document.getElementById(id).inert)"
        self.station.tell("stop")
        self.shown("#lost")
        self.hidden("#prompt-inner")
        self.assertEqual(self.browser.run(inert), [True, True])
        self.station.tell("start")
        self.shown("#prompt-inner")
        self.assertEqual(self.browser.run(inert), [False, False])
        self.browser.console()  # Chromium lists the connection that was gone

    def fill_form(self, name):
        procedure = tempfile.NamedTemporaryFile("w", suffix=".toml")
        self.addCleanup(procedure.close)
        procedure.write("name = 'short'")
        procedure.flush()
        self.browser.type("#start-procedure", procedure.name)
        self.browser.type("#start-name", name)
        return pathlib.Path(procedure.name).name

    def test_a_campaign_is_queued_at_rest_and_beside_another_one(self):
        self.rest()
        file = self.fill_form("check-1")
        self.browser.click("#start-queue")
        self.station.wait_for_command(f"queue check-1 {file} [name = 'short'] 1=SN0042 by web page")
        self.browser.run("document.querySelector('#start-name').focus()")
        self.station.set("/state", "running")
        self.hidden("#start-send")
        self.assertTrue(self.browser.run("return document.querySelector('#start-box').open"), "folded under whoever works with it")
        self.station.set("/state", "idle")
        self.browser.wait("return document.querySelector('#start-send').offsetParent !== null")
        self.browser.run("document.activeElement.blur()")
        self.station.set("/state", "running")
        self.browser.wait("return !document.querySelector('#start-box').open")
        self.browser.click("#start-box summary")
        file = self.fill_form("check-2")
        self.browser.type("#start-slots > :nth-child(2) input", "SN0077")
        self.browser.press("Enter")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "start-queue")
        self.browser.press("Enter")
        self.station.wait_for_command(f"queue check-2 {file} [name = 'short'] 1=SN0042 2=SN0077 by web page")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_page_opened_beside_a_campaign_knows_the_slots_of_the_next_one(self):
        self.station.tell("stored " + json.dumps(STORED))
        self.open()
        self.browser.click("#start-box summary")
        self.browser.wait("return document.querySelectorAll('#start-slots input').length === 2")
        file = self.fill_form("check-3")
        self.browser.press("Enter")  # in a field, with its first button hidden
        self.station.wait_for_command(f"queue check-3 {file} [name = 'short'] 1=SN0042 by web page")

    @long_test
    def test_while_the_slots_are_looked_into_start_says_what_it_waits_for(self):
        self.rest()
        self.browser.run("""
          const real = window.fetch;
          window.fetch = (path, ...more) => String(path).endsWith("campaign/look")
            ? new Promise((done) => { window.answerLook = () => done(real(path, ...more)); }) : real(path, ...more);""")
        self.browser.click("#start-look")
        self.see("#start-send", "Start: waits for the look into the slots")
        self.assertTrue(self.disabled("#start-send"))
        self.fill_form("check-1")
        self.browser.click("#start-queue")
        self.browser.wait("return document.querySelector('#start-name').value === ''")
        self.assertTrue(self.disabled("#start-send"))
        self.browser.wait("return Boolean(window.answerLook)")
        self.browser.run("window.answerLook()")
        self.browser.wait("return document.querySelector('#start-send').innerText === 'Start'")
        self.assertFalse(self.disabled("#start-send"))

    def test_a_refused_start_says_why(self):
        self.rest()
        self.station.tell("fail 2 --unit")
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as procedure:
            procedure.write("name = 'short'")
            procedure.flush()
            self.browser.type("#start-procedure", procedure.name)
            self.browser.type("#start-name", "2026-11")
            self.browser.click("#start-send")
            self.see("#start-failure", "scripted failure")
        self.browser.console()  # Chromium lists the 400


if __name__ == "__main__":
    unittest.main()
