# SPDX-License-Identifier: Apache-2.0
"""Settings of a station that works, changed from its page: a real `soakd` ($SOAK_BIN_FOLDER) begins anew with them in the same process,
goes back to those of before where it cannot, and refuses while something is under way."""
import hashlib
import http.client
import json
import pathlib
import shutil
import sys
import tempfile
import time
import unittest
import urllib.error

from test_accessibility import AXE, SERIOUS  # first: see lagging_station.py
from browser import BROWSER, DRIVER, Browser
from guarded_station import GuardedStation
from new_station import ROOT, NewStation, ask
from test_language import ENGLISH, SHOWN
from test_setup import peers

sys.path.insert(0, str(ROOT / "tools"))
sys.path.insert(0, str(ROOT / "tests" / "cli"))
from lab_session import LabSession  # noqa: E402
from soak_cli import check_schema  # noqa: E402

CONFIG = """# The station of the cellar.
[chamber]
map = "{maps}/chambers/watlow-f4t.toml"
host = "127.0.0.1"   # beside the door
port = 5020

[alarms.mail]
host = "127.0.0.1"
security = "none"
from = "soak@lab.example"
to = ["eva@lab.example"]

[alarms.webhook]
url_file = "hook"

[clock]
rate = 1

[[slot]]
name = "A"
host = "127.0.0.1"
port = 4001
axes = ["+Y", "-X", "+Z"]   # as it is screwed down
unit_type = "mti-300"
"""
HOOK = "http://127.0.0.1:9/hooks/s3cret"
WITHIN_S = 60


class SetUpStation(NewStation):
    """Its configuration is there before it starts."""

    def start(self, *options):
        self.data.mkdir(exist_ok=True)
        if not self.file.exists():
            hook = self.data / "hook"
            hook.write_text(HOOK + "\n", encoding="utf-8")
            hook.chmod(0o600)
            self.file.write_text(CONFIG.format(maps=ROOT / "procedures"), encoding="utf-8")
        super().start(*options)

    def text(self):
        return self.file.read_text(encoding="utf-8")

    def settings(self):
        status, document = self.ask("station")
        assert status == 200, document
        check_schema(document, "http-station")
        check_schema(document["choices"], "http-setup")
        return document

    def wait_until_it_is_back(self):
        end_s = time.monotonic() + WITHIN_S
        while time.monotonic() < end_s:
            try:
                settings = self.settings()
                if not settings["changing"]:
                    return settings
            except (ConnectionError, urllib.error.URLError, http.client.HTTPException, TimeoutError):
                pass  # it ends and begins
            time.sleep(0.1)
        raise AssertionError(self.said())


class WithSettings(unittest.TestCase):
    def setUp(self):
        self.station = SetUpStation()
        self.addCleanup(self.station.close)
        self.before = self.station.text()

    def body(self, **more):
        """As the page sends it."""
        settings = self.station.settings()
        return {**settings["answers"], "revision": settings["revision"], **more}

    def refused(self, path, body):
        status, document = self.station.ask(path, body)
        self.assertGreaterEqual(status, 400, document)
        self.assertEqual(self.station.text(), self.before, "nothing is written")
        return status, document["error"]["where"], document["error"]["message"]

    def changed(self, **more):
        """The file with one more change, once the station works with it."""
        status, document = self.station.ask("station/write", self.body(**more))
        self.assertEqual(status, 200, document)
        check_schema(document, "http-station-write")
        return self.station.wait_until_it_is_back()

    def events(self, kind):
        return [event for event in self.station.events() if event["kind"] == kind]


class Interface(WithSettings):
    def test_it_shows_what_it_works_with_and_no_secret(self):
        settings = self.station.settings()
        self.assertEqual((settings["file"], settings["obstacle"], settings["trouble"]), (str(self.station.file), None, None))
        self.assertEqual(settings["answers"]["chamber"], {"map": "watlow-f4t.toml", "host": "127.0.0.1", "port": 5020})
        self.assertEqual(settings["kept"], {"password": False, "url": True, "token": False})
        self.assertNotIn("s3cret", json.dumps(settings))
        status, document = self.station.ask("station/check", self.body())
        check_schema(document, "http-setup-check")
        self.assertEqual((status, document), (200, {"text": "", "mistakes": []}))

    def test_the_station_begins_anew_with_the_change_and_the_file_keeps_the_rest(self):
        slots = self.body()["slots"]
        slots[0]["port"] = 4009
        process, url = self.station.process.pid, self.station.url
        settings = self.changed(slots=slots, user="Eva")
        self.assertEqual(self.station.text(), self.before.replace("port = 4001", "port = 4009"))
        self.assertEqual((self.station.data / "station.toml.before").read_text(encoding="utf-8"), self.before)
        self.assertIsNone(settings["trouble"])
        self.assertEqual((self.station.process.poll(), self.station.process.pid, self.station.url), (None, process, url))
        (event,) = self.events("station_changed")
        self.assertEqual((event["subject"], event["user"]), (str(self.station.file), "Eva"))
        self.assertIn("slot 1: port", event["text"])
        self.assertEqual(self.station.ask("campaign/look", {"user": "Eva"})[1]["slots"][0]["trouble"], "tcp 127.0.0.1:4009: cannot connect: Connection refused")
        self.assertEqual(self.station.stop(), 0)

    def test_a_new_webhook_is_called_and_its_address_is_in_a_file_of_its_own(self):
        with peers() as (ports, lines):
            hook = f"http://127.0.0.1:{ports['webhook']}/hooks/n3w"
            told = self.station.ask("station/tell", {"webhook": {"url": hook}})[1]
            self.assertIsNone(told["ways"][0]["trouble"])
            lines.readline()
            self.assertEqual(self.station.text(), self.before)
            self.changed(webhook={"url": hook}, user="Eva")
            self.assertIn('url_file = "webhook.url"', self.station.text())
            self.assertEqual((self.station.data / "webhook.url").stat().st_mode & 0o777, 0o600)
            ways = self.station.ask("alarms/test", {"user": "Eva"})[1]["ways"]
            self.assertIsNone(next(way for way in ways if way["way"] == "webhook")["trouble"])
        said = self.station.said() + self.station.text() + json.dumps(self.station.events())
        self.assertNotIn("n3w", said)

    def test_it_goes_on_with_the_settings_of_before_where_it_cannot_begin_with_the_new_ones(self):
        settings = self.changed(power={"from": "chamber"}, user="Eva")  # the parser takes it, the chamber has no such outputs
        self.assertEqual(self.station.text(), self.before)
        self.assertIn("unit_power_1", settings["trouble"]["text"])
        self.assertEqual(settings["trouble"]["user"], "Eva")
        self.assertEqual([(event["user"], "unit_power_1" in event["text"]) for event in self.events("station_change_undone")], [("Eva", True)])
        self.assertEqual(len(self.events("station_changed")), 1)
        settings = self.changed(room={"temp_c": 22}, user="Eva")
        self.assertIsNone(settings["trouble"])
        self.assertIn("[room]\ntemp_c = 22\n", self.station.text())

    def test_a_file_that_somebody_else_has_changed_is_not_written_over(self):
        body = self.body(room={"temp_c": 22})
        self.before = self.before + "# a remark\n"
        self.station.file.write_text(self.before, encoding="utf-8")
        for path in ("station/check", "station/write"):
            status, where, message = self.refused(path, body)
            self.assertEqual((status, where), (409, "state"))
            self.assertIn("was changed by somebody else", message)

    def test_what_stands_in_the_file_and_is_not_in_use_does_not_begin_with_somebody_elses_change(self):
        answers = self.station.settings()["answers"]
        self.before = self.before.replace("rate = 1", "rate = 2")
        self.station.file.write_text(self.before, encoding="utf-8")
        settings = self.station.settings()
        self.assertIsNone(settings["answers"])
        self.assertIn("restart soakd", settings["obstacle"])
        body = {**answers, "room": {"temp_c": 22}, "revision": hashlib.sha256(self.before.encode()).hexdigest()}
        for path in ("station/check", "station/write"):
            self.assertEqual(self.refused(path, body)[:2], (409, "state"))
        self.station.stop()
        self.station.start()
        self.assertIsNone(self.station.settings()["obstacle"])

    def test_an_edit_that_does_not_begin_is_not_taken_for_the_settings_of_before(self):
        self.station.ask("station/write", self.body(power={"from": "chamber"}, user="Eva"))
        edited = self.station.text() + "no_such_key = 1\n"
        self.station.file.write_text(edited, encoding="utf-8")  # before or after it was taken back
        settings = self.station.wait_until_it_is_back()
        self.assertIsNone(self.station.process.poll())
        self.assertIn("no_such_key", self.station.text(), "it is left as somebody saved it")
        self.assertIsNotNone(settings["obstacle"])

    def test_what_the_form_cannot_show_is_refused_with_the_file(self):
        more = '[[slot]]\nname = "B"\nhost = "127.0.0.1"\nport = 4002\nunit_type = "vn-200"\n'
        body = self.body(room={"temp_c": 22})
        self.before = self.before + more
        self.station.file.write_text(self.before, encoding="utf-8")
        settings = self.station.settings()
        self.assertIsNone(settings["answers"])
        for part in (str(self.station.file), "slot B is for units of another type"):
            self.assertIn(part, settings["obstacle"])
            self.assertIn(part, self.refused("station/write", body)[2])

    def test_mistakes_are_told_at_their_fields_and_nothing_is_written(self):
        slots = [{"name": "A", "host": "127.0.0.1", "port": 5020}]
        document = self.station.ask("station/check", self.body(slots=slots))[1]
        self.assertEqual([mistake["field"] for mistake in document["mistakes"]], ["slots.0"])
        self.assertEqual(self.refused("station/write", self.body(slots=slots))[:2], (400, "slots.0"))
        self.assertEqual(self.refused("station/write", self.body(no_such=1))[:2], (400, "no_such"))
        self.assertEqual(self.refused("station/write", self.body(chamber={"map": "../../secret.toml", "host": "a"}))[:2], (400, "chamber.map"))
        self.assertEqual(self.refused("station/write", {"revision": 5})[:2], (400, "revision"))
        self.assertEqual(self.refused("station/write", self.body())[:2], (409, "state"), "nothing was changed")


class Laboratory(unittest.TestCase):
    def test_nothing_is_written_during_a_campaign_and_after_it_the_station_begins_anew_with_its_chamber(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-settings-"))
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        with LabSession(folder, units=1, rate=100) as lab:
            config = folder / "station.toml"
            text = config.read_text(encoding="utf-8")

            def asked(path, body=None):
                return ask(lab.page, path, body)

            def write():
                settings = asked("station")[1]
                return asked("station/write", {**settings["answers"], "room": {"temp_c": 22}, "revision": settings["revision"]})

            lab.soak("campaign", "start", ROOT / "procedures" / "static-allan.toml", "--name", "c")
            for state in ("running", "paused"):
                status, document = write()
                self.assertEqual(status, 409, document)
                self.assertIn("campaign 'c' is", document["error"]["message"])
                if state == "running":
                    lab.soak("campaign", "pause")
            self.assertEqual(config.read_text(encoding="utf-8"), text)
            self.assertFalse((folder / "station.toml.before").exists())
            lab.soak("campaign", "abort", "--reason", "enough")
            lab.wait_for("the end of the campaign", lambda status: status["state"] == "aborted")
            self.assertEqual(write()[0], 200)
            self.assertIn("temp_c = 22", config.read_text(encoding="utf-8"))
            end_s = time.monotonic() + WITHIN_S
            while not self.serves_with_its_chamber(asked):
                self.assertLess(time.monotonic(), end_s, lab.log())
                time.sleep(0.1)
            self.assertIsNone(asked("station")[1]["trouble"])

    @staticmethod
    def serves_with_its_chamber(asked):
        try:
            return not asked("station")[1]["changing"] and asked("status")[1]["chamber"]["connected"]
        except (ConnectionError, urllib.error.URLError, http.client.HTTPException):
            return False


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class OnThePage(WithSettings):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def open(self, language="en"):
        self.browser.go("about:blank")
        self.browser.resize(1280, 900)
        self.browser.devtools("Network.setUserAgentOverride", userAgent=self.browser.run("return navigator.userAgent"), acceptLanguage=language)
        self.browser.go(self.station.url + "#records")
        self.browser.wait("return document.querySelector('#alarms-ways li')?.checkVisibility() ?? false")  # the last that comes: the page stands still
        self.browser.click("#station-change")
        self.browser.wait("return document.querySelector('#chamber-port')?.value === '5020'")
        self.browser.console()

    def go_to(self, step):
        self.browser.click(f"#steps [data-step='{step}']")
        self.browser.wait("return document.querySelector('#steps [aria-current]').dataset.step === arguments[0]", step)

    def fill(self, field, text):
        self.browser.run("document.getElementById(arguments[0]).value = ''", field)
        self.browser.type(f"#{field}", str(text))

    def use(self):
        self.go_to("file")
        self.fill("user", "Eva")
        self.browser.wait("return !document.querySelector('#write').disabled")
        self.browser.click("#write")

    def test_an_engineer_changes_a_port_and_the_webhook_and_the_station_comes_back(self):
        self.open()
        self.go_to("file")
        self.browser.wait_for_text("#same", "Nothing is changed yet.")
        self.assertTrue(self.browser.run("return document.querySelector('#write').disabled"))
        self.go_to("units")
        self.assertFalse(self.browser.run("return document.querySelector('#look').checkVisibility()"), "the units are the station's own")
        self.fill("slots-0-port", "4009")
        with peers() as (ports, lines):
            self.go_to("alarms")
            self.assertEqual(self.browser.run("return document.querySelector('#webhook-url').value"), "")
            self.fill("webhook-url", f"http://127.0.0.1:{ports['webhook']}/hooks/n3w")
            self.browser.click("#alarms-test")
            self.browser.wait_for_text("#alarms-answer", "The webhook at 127.0.0.1 has taken the message.")
            self.go_to("file")
            self.browser.wait_for_text("#text", "+ port = 4009")
            self.assertEqual(self.browser.console(), [])
            self.use()
            self.browser.wait_for_text("#done", "The station works with the new settings.")
        self.assertIn("port = 4009\naxes = [\"+Y\", \"-X\", \"+Z\"]   # as it is screwed down\n", self.station.text())
        self.assertEqual([event["user"] for event in self.events("station_changed")], ["Eva"])
        self.browser.click("#done a")
        self.browser.wait("return document.querySelector('#state') !== null")

    def test_settings_with_which_the_station_cannot_begin_are_taken_back_and_the_page_says_why(self):
        self.open()
        self.go_to("units")
        self.browser.run("document.querySelector('#step-units details').open = true")
        self.browser.click("#power-way-choice option[value='chamber']")
        self.use()
        self.browser.wait_for_text("#done", "It works with those of before.")
        self.browser.wait_for_text("#done", "unit_power_1")
        self.assertEqual(self.station.text(), self.before)
        self.open()
        self.browser.wait_for_text("#failure", "was taken back")

    def test_in_german_every_word_is_and_nothing_is_in_the_way(self):
        self.open("de")
        for step in ("chamber", "fixture", "units", "site", "alarms", "file"):
            self.browser.run("scrollTo(0, 0)")
            self.go_to(step)
            if step == "file":
                self.browser.wait_for_text("#same", "Noch ist nichts geändert.")
            self.assertEqual([text for text in self.browser.run(SHOWN) if ENGLISH.search(text)], [], step)
            if AXE.exists():
                self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [], step)
            for width in (320, 390, 1280):
                self.browser.resize(width, 900)
                self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)

    def test_another_language_keeps_what_was_entered_and_leaving_does_not(self):
        self.open()
        self.go_to("units")
        self.fill("slots-0-port", "4009")
        self.browser.click("#language option[value='de']")
        self.browser.wait("return document.querySelector('#slots-0-port')?.value === '4009' && document.documentElement.lang === 'de'")
        self.browser.run("localStorage.clear()")
        self.open()
        self.assertEqual(self.browser.run("return document.querySelector('#slots-0-port').value"), "4001")

    def test_a_station_that_the_form_cannot_show_is_left_alone_with_the_reason(self):
        self.station.file.write_text(self.before.replace('unit_type = "mti-300"', 'unit_type = "none"'), encoding="utf-8")
        self.browser.go(self.station.url + "setup.html#change")
        self.browser.wait_for_text("#done", "cannot show the settings of this station")
        self.browser.wait_for_text("#done", str(self.station.file))
        self.assertFalse(self.browser.run("return document.querySelector('#form').checkVisibility()"))


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Roles(unittest.TestCase):
    def test_who_is_no_engineer_is_told_so(self):
        station = GuardedStation()
        self.addCleanup(station.close)
        browser = Browser("--ignore-certificate-errors")
        self.addCleanup(browser.close)
        for name, sees in (("otto", False), ("eva", True)):
            browser.go(f"https://localhost:{station.port}/login.html")
            browser.wait("return document.querySelector('#name') !== null")
            browser.type("#name", name)
            browser.type("#password", f"the password of {name}")
            browser.press("Enter")
            browser.wait("return document.body.dataset.role !== undefined")
            browser.go(f"https://localhost:{station.port}/#records")
            browser.wait("return !document.querySelector('#records-view').hidden")
            self.assertEqual(browser.run("return document.querySelector('#station-change').checkVisibility()"), sees)
            browser.go(f"https://localhost:{station.port}/setup.html#change")
            if sees:
                browser.wait("return document.querySelector('#form').checkVisibility()")
            else:
                browser.wait_for_text("#done", "Settings are changed by an engineer.")


if __name__ == "__main__":
    unittest.main()
