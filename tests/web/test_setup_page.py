# SPDX-License-Identifier: Apache-2.0
"""The page that sets a station up: a real `soakd` without a configuration in a real browser, before a real `soaksim`."""
import json
import socket
import tomllib
import unittest

from pymodbus.client import ModbusTcpClient

from browser import BROWSER, DRIVER, Browser, long_test
from new_station import Laboratory, unused_port
from test_accessibility import AXE, SERIOUS
from test_language import ENGLISH, SHOWN
from test_setup import WithStation, form, peers

SERIAL = "0380A001"
STEPS = ("chamber", "fixture", "units", "site", "alarms", "file")


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class OnThePage(WithStation):
    @classmethod
    def setUpClass(cls):
        cls.lab = Laboratory()
        cls.addClassCleanup(cls.lab.close)
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        super().setUp()
        self.open()

    def open(self, language="en"):
        self.browser.go("about:blank")
        self.browser.resize(1280, 900)
        self.browser.devtools("Network.setUserAgentOverride", userAgent=self.browser.run("return navigator.userAgent"), acceptLanguage=language)
        self.browser.go(self.station.url)
        self.browser.wait("return document.querySelectorAll('#chamber-map option').length > 5")
        self.browser.console()

    def choose(self, field, value):
        self.browser.click(f"#{field} option[value='{value}']")

    def fill(self, field, text):
        self.browser.run("document.getElementById(arguments[0]).value = ''", field)
        self.browser.type(f"#{field}", str(text))

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)

    def step(self):
        return self.browser.run("return document.querySelector('#steps [aria-current]').dataset.step")

    def wait_for_step(self, step):
        self.browser.wait("return document.querySelector('#steps [aria-current]').dataset.step === arguments[0]", step)

    def enter_chamber(self, port):
        self.choose("chamber-map", "watlow-f4t.toml")
        self.fill("chamber-host", "127.0.0.1")
        self.fill("chamber-port", port)

    def enter_slot(self, port):
        self.choose("unit_type", "mti-300")
        self.fill("slots-0-host", "127.0.0.1")
        self.fill("slots-0-port", port)

    def go_to(self, step):
        self.browser.click(f"#steps [data-step='{step}']")
        self.wait_for_step(step)

    def give_power(self):
        """As somebody at a switch of the laboratory would."""
        relays = ModbusTcpClient("127.0.0.1", port=self.lab.ports["relay"], timeout=30)
        self.addCleanup(relays.close)
        self.assertTrue(relays.connect())
        self.assertFalse(relays.write_register(0, 1, 1).isError())

    def test_a_technician_sets_the_station_up_by_clicks_and_sees_the_chamber(self):
        self.enter_chamber(self.lab.ports["chamber"])
        self.browser.click("#chamber-try")
        self.see("#chamber-answer", "It answers. The air is at 2")
        self.browser.click("#next")
        self.wait_for_step("fixture")
        self.choose("fixture-kind-choice", "machine")
        self.choose("fixture-map", "modbus-positioner.toml")
        self.fill("fixture-host", "127.0.0.1")
        self.fill("fixture-port", self.lab.ports["fixture"])
        self.browser.click("#fixture-try")
        self.see("#fixture-answer", "It answers, and all is as it should be.")
        self.browser.click("#next")
        self.wait_for_step("units")
        self.enter_slot(self.lab.ports["units"][0])
        self.give_power()
        self.browser.click("#look")
        self.see("#slots", SERIAL)
        self.browser.click("#slots .found button")
        self.assertEqual(self.browser.run("return document.querySelector('#slots-0-unit').value"), SERIAL)
        self.browser.click("#next")
        self.wait_for_step("site")
        self.fill("site-latitude_deg", "48,14")
        self.fill("site-height_m", "520")
        self.browser.click("#next")
        self.wait_for_step("alarms")
        self.browser.click("#next")
        self.wait_for_step("file")
        self.see("#text", SERIAL)
        self.fill("user", "Eva")
        self.browser.wait("return !document.querySelector('#write').disabled")
        self.assertEqual(self.browser.console(), [])
        self.browser.click("#write")
        self.browser.wait("return location.pathname === '/' && document.querySelector('#air')?.innerText.startsWith('2')")
        chamber = self.station.ask("status")[1]["chamber"]
        self.assertTrue(chamber["connected"])
        self.see("#air", f"{chamber['air_c']:.2f}"[:2])
        config = tomllib.loads(self.station.file.read_text(encoding="utf-8"))
        self.assertEqual(config["slot"], [{"name": "1", "host": "127.0.0.1", "port": self.lab.ports["units"][0], "decoder": "xsens", "unit": SERIAL, "unit_type": "mti-300"}])
        self.assertEqual(config["site"], {"latitude_deg": 48.14, "height_m": 520})
        self.assertEqual([(event["kind"], event["user"]) for event in self.station.events()], [("station_set_up", "Eva")])
        self.assertEqual(self.browser.run("return document.querySelector('#user').value"), "Eva", "who has set it up works at it now")
        self.browser.run("localStorage.clear()")

    def test_what_the_first_start_does_not_need_is_folded_and_opens_where_it_is_wrong(self):
        self.enter_chamber(self.lab.ports["chamber"])
        folds = "return [...document.querySelectorAll('details.more')].map(({ open }) => open)"
        self.assertEqual(self.browser.run(folds), [False, False, False])
        self.go_to("units")
        self.enter_slot(self.lab.ports["units"][0])
        self.assertFalse(self.browser.run("return document.querySelector('#slots-0-power_output').checkVisibility()"))
        self.browser.click("#step-units summary")
        self.choose("power-way-choice", "map")
        self.choose("power-map", "modbus-relay.toml")
        self.fill("power-host", "127.0.0.1")
        self.fill("power-port", self.lab.ports["relay"])
        self.browser.click("#power-try")
        self.see("#power-answer", "It answers")
        self.fill("slots-0-power_output", "many")
        self.browser.click("#next")
        self.see("#slots-0-power_output-mistake", "whole number")
        self.fill("slots-0-power_output", "1")
        self.fill("power-port", "many")
        self.browser.run("document.querySelector('#step-units details').open = false")
        self.browser.click("#next")
        self.see("#power-port-mistake", "whole number")
        self.fill("power-port", self.lab.ports["relay"])
        self.browser.click("#next")
        self.wait_for_step("site")
        self.fill("room-dew_point_c", "30")
        self.browser.click("#next")
        self.see("#room-dew_point_c-mistake", "above the temperature of the room")
        self.fill("room-dew_point_c", "11,5")
        self.go_to("file")
        self.see("#text", "power_output = 1")
        self.see("#text", "dew_point_c = 11.5")
        self.assertTrue(self.browser.run("return document.querySelector('#no-dew-point').hidden"))
        self.assertEqual(self.browser.console(), [])

    def test_a_test_of_alarms_is_sent_before_anything_is_written_and_no_secret_stays_in_the_browser(self):
        with peers() as (ports, lines):
            self.go_to("alarms")
            self.choose("webhook-wanted-choice", "yes")
            self.fill("webhook-url", f"http://127.0.0.1:{ports['webhook']}/hooks/s3cret")
            self.fill("webhook-token", "t0ken")
            self.browser.click("#alarms-test")
            self.see("#alarms-answer", "The webhook at 127.0.0.1 has taken the message.")
            self.assertEqual(json.loads(lines.readline())["authorization"], "Bearer t0ken")
            self.fill("webhook-url", f"http://127.0.0.1:{ports['webhook']}/refuses")
            self.browser.click("#alarms-test")
            self.see("#alarms-answer", "404")
        self.assertEqual(self.browser.run("return document.querySelector('#webhook-token').type"), "password")
        self.browser.run("dispatchEvent(new Event('pagehide'))")
        kept = self.browser.run("return sessionStorage.getItem('soak-setup')")
        self.assertIn("webhook.wanted.choice", kept)
        self.assertNotIn("t0ken", kept)
        self.assertNotIn("refuses", kept)
        self.browser.run("sessionStorage.clear()")

    def test_the_guide_opens_beside_what_was_entered(self):
        self.enter_chamber(5020)
        self.browser.click("[data-help='hardware']")
        self.see("#help-page", "Writing a map")
        self.browser.click("#help-page nav a[href='#help=alarms']")
        self.see("#help-page", "Alarms that reach a person")
        self.browser.click("#help form button")
        self.browser.wait("return !document.querySelector('#help').open")
        self.assertEqual(self.browser.run("return document.querySelector('#chamber-port').value"), "5020")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_place_that_is_not_known_is_said_with_what_it_costs(self):
        self.go_to("file")
        self.see("#no-gravity", "0.3 %")
        self.go_to("site")
        self.fill("site-latitude_deg", "north")
        self.browser.click("#next")
        self.see("#site-latitude_deg-mistake", "Please enter a number.")
        self.fill("site-latitude_deg", "148")
        self.browser.click("#next")
        self.see("#site-latitude_deg-mistake", "90")
        self.fill("site-latitude_deg", "48")
        self.go_to("file")
        self.browser.wait("return document.querySelector('#no-gravity').hidden")

    def test_a_controller_that_was_not_tried_or_did_not_answer_well_is_named_before_it_is_relied_on(self):
        self.enter_chamber(self.lab.ports["relay"])
        self.go_to("units")
        self.enter_slot(self.lab.ports["units"][0])
        self.go_to("file")
        self.see("#not-sound", "Chamber: never tried")
        self.go_to("chamber")
        self.browser.click("#chamber-try")
        self.see("#chamber-answer", "Is this the right controller?")
        self.go_to("file")
        self.see("#not-sound", "Chamber: the last try did not go well")
        self.go_to("chamber")
        self.enter_chamber(self.lab.ports["chamber"])
        self.browser.click("#chamber-try")
        self.see("#chamber-answer", "It answers. The air is at 2")
        self.go_to("file")
        self.see("#good", "The station takes it as it is.")
        self.assertFalse(self.browser.run("return document.querySelector('#not-sound').checkVisibility()"))

    @long_test
    def test_a_good_try_counts_after_a_reload_and_in_another_language_until_the_address_changes(self):
        self.enter_chamber(self.lab.ports["chamber"])
        self.browser.click("#chamber-try")
        self.see("#chamber-answer", "It answers.")
        self.go_to("units")
        self.enter_slot(self.lab.ports["units"][0])
        self.go_to("file")
        self.see("#good", "The station takes it as it is.")
        self.browser.run("window.isOld = true")
        self.choose("language", "de")
        self.browser.wait("return window.isOld === undefined && document.querySelector('#good')?.checkVisibility()")
        self.assertTrue(self.browser.run("return document.querySelector('#not-sound').hidden"))
        self.go_to("chamber")
        self.fill("chamber-port", "1")
        self.go_to("file")
        self.browser.wait("return !document.querySelector('#not-sound').hidden")
        self.browser.run("localStorage.clear()")

    @long_test
    def test_a_try_that_ends_on_the_last_step_is_told_there(self):
        self.enter_chamber(self.lab.ports["chamber"])
        self.go_to("units")
        self.enter_slot(self.lab.ports["units"][0])
        self.go_to("chamber")
        # Nothing answers the try before the last step is open.
        self.browser.run("""const fetched = window.fetch;
            window.fetch = (address, ...more) => (String(address).includes('setup/try') ? new Promise((go) => { window.go = go; }).then(() => fetched(address, ...more)) : fetched(address, ...more));""")
        self.browser.click("#chamber-try")
        self.browser.wait("return window.go !== undefined")
        self.go_to("file")
        self.see("#not-sound", "Chamber: never tried")
        self.browser.run("window.go()")
        self.browser.wait("return document.querySelector('#not-sound').hidden")

    def test_a_wrong_address_is_told_at_the_field(self):
        self.enter_chamber(unused_port())
        self.browser.click("#chamber-try")
        self.see("#chamber-host-mistake", "onnect")
        self.assertEqual(self.browser.run("const host = document.querySelector('#chamber-host'); return [host.getAttribute('aria-invalid'), document.activeElement.id]"), ["true", "chamber-host"])
        self.see("#chamber-host-mistake", "Is the controller switched on")
        self.see("#chamber-port-mistake", "Is the port right?")
        self.fill("chamber-port", "many")
        self.browser.click("#chamber-try")
        self.see("#chamber-port-mistake", "whole number")
        self.fill("chamber-port", 70000)
        self.browser.click("#next")
        self.see("#chamber-port-mistake", "65535")
        self.assertEqual(self.step(), "chamber")

    def test_mistakes_of_all_steps_are_listed_at_the_end_and_lead_to_their_fields(self):
        self.go_to("file")
        self.see("#mistakes", "Units, Slot 1, Port: Please fill this in.")
        self.assertTrue(self.browser.run("return document.querySelector('#write').disabled"))
        self.browser.click("#mistakes li button")
        self.wait_for_step("chamber")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "chamber-map")

    @long_test
    def test_a_file_that_is_there_by_then_is_not_written_over(self):
        self.enter_chamber(5020)
        self.go_to("units")
        self.enter_slot(4001)
        self.go_to("file")
        self.browser.wait("return !document.querySelector('#write').disabled")
        self.station.file.write_text("# of somebody else\n", encoding="utf-8")
        self.browser.click("#write")
        self.see("#failure", "not written over")
        self.assertEqual(self.station.file.read_text(encoding="utf-8"), "# of somebody else\n")
        self.browser.click("#use")
        self.see("#failure", "chamber")
        self.station.file.write_text(self.checked(form())[0], encoding="utf-8")
        self.browser.wait("return !document.querySelector('#write').disabled")
        self.browser.click("#write")
        self.see("#failure", "not written over")
        self.browser.click("#use")
        self.browser.wait("return location.pathname === '/' && document.querySelector('#air') !== null")

    @long_test
    def test_another_language_keeps_what_was_entered(self):
        self.enter_chamber(5020)
        self.go_to("units")
        self.enter_slot(4001)
        self.choose("decoder", "vectornav")
        self.browser.click("#slot-more")
        self.fill("slots-1-name", "oben")
        self.browser.run("window.isOld = true")
        self.choose("language", "de")
        self.browser.wait("return window.isOld === undefined && document.querySelector('#steps [aria-current]')?.dataset.step === 'units'")
        values = self.browser.run("return ['chamber-map', 'chamber-host', 'chamber-port', 'unit_type', 'decoder', 'slots-0-port', 'slots-1-name'].map((id) => document.getElementById(id).value)")
        self.assertEqual(values, ["watlow-f4t.toml", "127.0.0.1", "5020", "mti-300", "vectornav", "4001", "oben"])
        self.browser.run("localStorage.clear()")

    @long_test
    def test_what_a_controller_answered_is_gone_with_another_address(self):
        self.enter_chamber(self.lab.ports["chamber"])
        self.browser.click("#chamber-try")
        self.see("#chamber-answer", f"127.0.0.1:{self.lab.ports['chamber']}: It answers.")
        self.fill("chamber-port", "1")
        self.assertEqual(self.browser.run("return document.querySelector('#chamber-answer').innerText"), "")

    @long_test
    def test_what_was_found_in_a_slot_is_gone_with_another_address_and_a_late_answer_is_dropped(self):
        self.go_to("units")
        self.enter_slot(unused_port())
        found = "return document.querySelector('#slots .found')?.innerText ?? ''"
        self.browser.click("#look")
        self.browser.wait(found)
        self.fill("slots-0-port", "1")
        self.assertEqual(self.browser.run(found), "")
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            silent.listen()
            self.fill("slots-0-port", silent.getsockname()[1])
            self.browser.click("#look")
            self.browser.click("#slot-more")
            self.browser.wait("return !document.querySelector('#look').disabled")
            self.assertEqual(self.browser.run(found), "")

    @long_test
    def test_next_says_which_field_of_another_step_is_in_the_way(self):
        self.go_to("units")
        self.browser.run("document.querySelector('#slots-0-host').value = 'x'.repeat(300)")
        self.go_to("chamber")
        self.enter_chamber(5020)
        self.browser.click("#next")
        self.see("#failure", "Units, Slot 1, Address or name")
        self.browser.click("#failure button")
        self.wait_for_step("units")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "slots-0-host")

    def test_a_station_that_is_gone_is_said_in_words(self):
        self.enter_chamber(5020)
        self.station.stop()
        self.browser.click("#chamber-try")
        self.see("#failure", "is soakd running?")
        self.go_to("units")
        self.enter_slot(4001)
        self.browser.click("#look")
        self.see("#look-failure", "is soakd running?")

    def test_it_is_worked_by_the_keyboard_alone(self):
        browser = self.browser
        browser.run("document.querySelector('#chamber-map').focus()")
        browser.type("#chamber-map", "Watlow F4T")
        self.fill("chamber-host", "127.0.0.1")
        browser.press("Enter")
        self.wait_for_step("fixture")
        browser.wait("return document.activeElement.id === 'fixture-title'")
        browser.press("Tab")
        self.assertEqual(browser.run("return document.activeElement.id"), "fixture-kind-choice")

    @long_test
    def test_slots_come_and_go(self):
        self.go_to("units")
        self.browser.click("#slot-more")
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('#slots legend')].map((one) => one.innerText)"), ["Slot 1", "Slot 2"])
        self.assertEqual(self.browser.run("return document.activeElement.id"), "slots-1-name")
        self.browser.click("#slot-less")
        self.assertEqual(self.browser.run("return [document.querySelectorAll('#slots legend').length, document.querySelector('#slot-less').disabled]"), [1, True])

    def assert_fits(self):
        for width in (320, 390, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
            self.assertGreater(self.browser.run("return document.querySelector('#language').offsetWidth"), 80, "the language can be read")

    def everything(self):
        """Each step with all the fields that it can have, as (step, its mistakes)."""
        self.choose("chamber-map", "watlow-f4t.toml")
        self.choose("chamber-way", "serial")
        for step in STEPS:
            self.browser.run("scrollTo(0, 0)")  # the head lies over what is scrolled below it
            self.go_to(step)
            if step == "fixture":
                self.choose("fixture-kind-choice", "machine")
            self.browser.run("for (const fold of document.querySelectorAll('details.more')) fold.open = true")
            if step == "units":
                self.browser.click("#slot-more")
                self.choose("power-way-choice", "map")
            if step == "alarms":
                self.choose("mail-wanted-choice", "yes")
                self.choose("webhook-wanted-choice", "yes")
            if step == "file":
                self.browser.wait("return document.querySelectorAll('#mistakes li').length > 4")
            yield step

    def test_in_german_every_word_is(self):
        self.open("de")
        for step in self.everything():
            english = [text for text in self.browser.run(SHOWN) if ENGLISH.search(text)]
            self.assertEqual(english, [], step)
            self.assert_fits()
        self.see("#mistakes", "Prüflinge, Steckplatz 1, Port: Bitte ausfüllen.")

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_nothing_is_in_the_way_of_anybody_on_any_screen(self):
        for step in self.everything():
            self.assert_fits()
            for width in (390, 1280):
                self.browser.resize(width, 900)
                with self.subTest(step=step, width=width):
                    self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [])
            self.browser.colours("dark")
            self.assertEqual(self.browser.poor_contrast(), [], step)
            self.browser.colours("light")

    def test_a_station_that_is_set_up_says_so(self):
        self.assertEqual(self.station.ask("setup/write", form())[0], 200)
        self.station.process.stdout.readline()
        self.browser.go(self.station.url + "setup.html")
        self.see("#done", "This station is set up already.")
        self.browser.click("#done a")
        self.browser.wait("return document.querySelector('#state') !== null")


if __name__ == "__main__":
    unittest.main()
