# SPDX-License-Identifier: Apache-2.0
"""Set points, runs and times of a procedure are changed by clicks in *New campaign*, and a campaign begins with them: a real `soakd` before a real
`soaksim`, in a real browser."""
import json
import pathlib
import re
import shutil
import sys
import tempfile
import tomllib
import unittest
import urllib.request

from browser import BROWSER, DRIVER, Browser
from real_soakd import Soakd
from test_accessibility import AXE, SERIOUS
from test_language import ENGLISH, SHOWN

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]
from lab_session import LabSession  # noqa: E402
from soak_cli import check_schema  # noqa: E402

SOURCE = "six-position-both-ways"
CHANGED = "minus20-to-60"


class WithForm(unittest.TestCase):
    """`url` of a station, in one browser."""

    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def get(self, path):
        with urllib.request.urlopen(f"{self.url}api/v1/{path}", timeout=30) as answer:
            return json.load(answer)

    def open(self, file=f"{SOURCE}.toml", language="en"):
        """The form, with that procedure and the fields for its changes."""
        self.browser.go("about:blank")
        self.browser.resize(1280, 900)
        self.browser.devtools("Network.setUserAgentOverride", userAgent=self.browser.run("return navigator.userAgent"), acceptLanguage=language)
        self.browser.go(self.url)
        self.browser.wait("return document.querySelectorAll('#start-choice option').length > 5")
        self.browser.console()
        self.choose("#start-choice", file)
        self.browser.click("#changes-box summary")
        self.browser.wait("return document.querySelector('#change-points')?.value")

    def choose(self, selector, value):
        self.browser.run("""const select = document.querySelector(arguments[0]); select.value = arguments[1];
            for (const kind of ['input', 'change']) select.dispatchEvent(new Event(kind, { bubbles: true }));""", selector, value)

    def fill(self, field, text):
        self.browser.run("document.querySelector(arguments[0]).value = ''", f"#{field}")
        self.browser.type(f"#{field}", text)

    def value(self, field):
        return self.browser.run("return document.getElementById(arguments[0]).value", field)

    def see(self, text):
        self.browser.wait_for_text("#start-review", text)

    def hours(self):
        return re.search(r"takes about ([^;\n]+)", self.browser.run("return document.querySelector('#start-review').innerText")).group(1)

    def wrong(self):
        """(id, message) of the fields that are marked."""
        return self.browser.run("""return [...document.querySelectorAll('#changes-box [aria-invalid]')].map((input) =>
            [input.id, document.getElementById(`${input.id}-mistake`).innerText])""")


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Start(WithForm):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-changes-"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        cls.lab = LabSession(folder, units=1, rate=1)
        cls.lab.__enter__()
        cls.addClassCleanup(cls.lab.__exit__)
        cls.url = cls.lab.page
        cls.own = pathlib.Path(cls.lab.data) / "procedures"

    def test_a_campaign_begins_with_set_points_that_were_changed_by_clicks(self):
        source = (ROOT / "procedures" / f"{SOURCE}.toml").read_text(encoding="utf-8")
        self.open()
        self.see("43 visits each, from −30 to 70 °C")
        before = self.hours()
        self.assertEqual(self.value("change-course"), "back")
        self.assertTrue(self.value("change-points").startswith("−30, −25, "))
        for name, text in (("even-0", "-20"), ("even-1", "60"), ("even-2", "40")):
            self.fill(f"change-{name}", text)
        self.browser.click("#changes-box fieldset button")
        self.assertEqual(self.value("change-points"), "−20, 20, 60")
        self.see("7 visits each, from −20 to 60 °C")  # 25 -20 20 60 20 -20 25
        self.fill("change-runs", "1")
        self.see("1 run, 7 visits")
        self.assertNotEqual(self.hours(), before)
        self.assertEqual(self.value("change-name"), f"{SOURCE}-2")
        self.fill("change-name", CHANGED)
        self.assertEqual(self.browser.text("#changes-box summary"), "Changed: 5 set points, 1 run")
        self.assertFalse(self.own.exists(), "nothing is kept before the start")
        self.browser.run("document.querySelector('#user').value = ''")
        self.browser.type("#user", "Eva")
        self.browser.type("#start-name", "narrow")
        self.browser.wait("return document.querySelector('#start-review .bad') === null")
        self.browser.click("#start-send")
        self.browser.wait("return document.querySelector('#start-choice').value === arguments[0]", f"{CHANGED}.toml")
        status = self.lab.wait_for("the campaign", lambda status: status["campaign"] and status["campaign"]["name"] == "narrow")
        self.assertEqual(status["campaign"]["procedure"], CHANGED)
        plan = self.get("plan")
        self.assertEqual([step["temp_c"] for step in plan["steps"] if step["kind"] == "set_temperature"], [25, -20, 20, 60, 20, -20, 25])
        # Everything else is as it was, and the station says where it comes from.
        text = (self.own / f"{CHANGED}.toml").read_text(encoding="utf-8")
        self.assertRegex(text.splitlines()[0], rf"^# Made from {SOURCE}\.toml, \d{{4}}-\d\d-\d\d \d\d:\d\d UTC by Eva: 5 set points from -20 to 60 °C, 1 run\.$")
        made, old = tomllib.loads(text), tomllib.loads(source)
        self.assertEqual(made["temperatures"].pop("list_c"), [-20, 20, 60, 20, -20])
        for key in ("start_c", "stop_c", "step_c", "sweep"):
            del old["temperatures"][key]
        self.assertEqual({**made, "name": 0, "description": 0, "runs": 0}, {**old, "name": 0, "description": 0, "runs": 0})
        [event] = self.lab.soak_json("events", "list", "--kind", "procedure_made")["events"]
        self.assertEqual((event["subject"], event["user"]), (CHANGED, "Eva"))
        document = self.get(f"procedures?file={CHANGED}.toml")
        check_schema(document, "http-procedures")
        self.assertEqual(document["procedures"][0]["text"], text)
        # What is half typed may be refused as a draft, which its field says; Chromium notes that as well.
        refused = re.compile(r"/api/v1/procedures/new - Failed to load resource: the server responded with a status of 400 ")
        self.assertEqual([line for line in self.browser.console() if not refused.search(line)], [])


class Laboratory(Soakd):
    """With one unit whose type is known."""

    def store_all(self):
        self.soak("unit", "add", "SN0042", "--type", "mti-300")


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Fields(WithForm):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.soakd = Laboratory()
        cls.addClassCleanup(cls.soakd.close)
        cls.url = cls.soakd.url

    def test_a_mistake_stands_at_its_field_and_nothing_is_kept(self):
        self.open("six-position-soak.toml")
        kept = self.get("procedures")
        self.fill("change-points", "-20, warm")
        self.browser.wait("return document.querySelector('#change-points').ariaInvalid === 'true'")
        self.assertEqual(self.wrong(), [["change-points", "“warm” is no temperature."]])
        self.fill("change-points", "-20 400")
        self.browser.wait("return document.querySelector('#change-points-mistake').innerText.includes('400')")
        self.assertEqual(self.browser.run("return document.querySelector('#change-points-mistake span').lang"), "en", "the station's own words")
        # What the unit is rated for is no field's mistake, but the campaign's.
        self.browser.type("#start-slots input", "SN0042")
        self.fill("change-points", "-20; 22.5 °C, 150")
        self.see("Refused: ")
        self.assertEqual(self.wrong(), [])
        self.browser.type("#start-name", "hot")
        self.browser.click("#start-queue")
        self.browser.wait_for_text("#start-failure", "rated")
        self.fill("change-points", "0, 40")
        for name in ("../x", "six-position-soak"):
            self.fill("change-name", name)
            self.browser.click("#start-queue")
            self.browser.wait("return document.activeElement.id === 'change-name' && document.activeElement.ariaInvalid === 'true'")
        self.assertIn("There is a procedure six-position-soak already", self.browser.text("#start-failure"))
        self.assertEqual(self.get("procedures"), kept)
        self.browser.click("#changes-box > div > button")
        self.see("23 visits each, from −30 to 70 °C")
        self.assertEqual(self.browser.text("#changes-box summary"), "Change its set points")
        self.browser.console()  # Chromium lists the refusal

    def test_a_kind_is_asked_only_for_what_it_has(self):
        shown = "return [...document.querySelectorAll('#changes-box > div > *')].filter((node) => node.offsetParent).map((node) => node.querySelector('[id]').id)"
        self.open("thermal-ramp.toml")
        self.assertEqual(self.browser.run(shown), ["change-points", "change-even-0", "change-runs"])
        self.assertEqual(self.value("change-points"), "−30, 70, 25")
        self.choose("#start-choice", "static-allan.toml")
        self.browser.wait("return !document.querySelector('#change-points').value.includes(',')")
        self.assertEqual(self.browser.run(shown), ["change-points", "change-runs", "change-soak", "change-dwell"])
        self.fill("change-dwell", "90,5")
        self.browser.wait_for_text("#changes-box summary", "Changed: 90.5 min recorded")

    def lists(self, *texts):
        return self.browser.run("""const [texts] = arguments; return import('/set_points.mjs').then(({ typedList, listText }) =>
            texts.map((text) => { const { points, wrong } = typedList(text); return [points, wrong, listText(points.filter(Number.isFinite))]; }))""", texts)

    def test_lists_are_read_as_people_write_them(self):
        self.open()
        self.assertEqual(self.lists("-20,-10,0,10", " −20 ; 22.5", "5\t-5°C\n7 °C", "", "1..2", "-"),
                         [[[-20, -10, 0, 10], None, "−20, −10, 0, 10"], [[-20, 22.5], None, "−20, 22.5"], [[5, -5, 7], None, "5, −5, 7"], [[], None, ""],
                          [[None], "1..2", ""], [[None], "-", ""]])
        even = self.browser.run("""return import('/set_points.mjs').then(({ evenList, wayThere, thereAndBack }) => [evenList(-20, 60, 40), evenList(60, 0, 25), evenList(5, 5, 1),
            evenList(0, 1, 0.1).length, evenList(0, 9, 0), evenList(0, 9, NaN), evenList(0, 1e6, 1), wayThere([1, 2, 3, 2, 1]), wayThere([1, 2, 1, 2, 1]), wayThere([1, 2]),
            wayThere([1, 1, 1]), thereAndBack([1, 2, 3])])""")
        self.assertEqual(even, [[-20, 20, 60], [60, 35, 10, 0], [5], 11, None, None, None, [1, 2, 3], None, None, None, [1, 2, 3, 2, 1]])

    def test_the_fields_speak_german_and_fit_every_screen(self):
        self.open(language="de")
        self.assertEqual(self.lists("-20,-10; 22,5", "-20; 0,5; 3"), [[[-20, -10, 22.5], None, "−20; −10; 22,5"], [[-20, 0.5, 3], None, "−20; 0,5; 3"]])
        self.fill("change-points", "-20; x")
        self.browser.wait("return document.querySelector('#change-points').ariaInvalid === 'true'")
        shown = self.browser.run(SHOWN.replace("walk(document.body)", "walk(document.querySelector('#changes-box'))").replace("document.title, ", ""))
        self.assertGreater(len(shown), 10)
        self.assertEqual([text for text in shown if ENGLISH.search(text)], [])
        for width in (320, 390, 768, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            self.assertEqual(self.browser.poor_contrast(), [], scheme)

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_axe_finds_nothing_serious_in_the_fields(self):
        self.open()
        self.fill("change-points", "-20; x")
        self.browser.wait("return document.querySelector('#change-points').ariaInvalid === 'true'")
        self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [])



if __name__ == "__main__":
    unittest.main()
