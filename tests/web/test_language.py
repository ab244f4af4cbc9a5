# SPDX-License-Identifier: Apache-2.0
"""The page in the languages it has: each whole, chosen by the browser or by hand, and numbers as that language writes them."""
import html.parser
import json
import pathlib
import re
import unittest

import jsonschema

from browser import long_test
from page_test import STORED, PageTest, allan_noise, soak_history
from test_accessibility import AXE, SERIOUS
from test_page_station import RATE_1, attitude, set_step, soak_plan

ROOT = pathlib.Path(__file__).resolve().parents[2]
WEB = ROOT / "web"
STATUS_SCHEMA = json.loads((ROOT / "docs" / "schema" / "campaign-status.schema.json").read_text(encoding="utf-8"))
# English words that are no German ones: one of them is enough to give a sentence away.
ENGLISH = re.compile(r"\b(the|of|and|is|are|it|its|with|from|by|this|that|you|your|has|have|been|not|no|for|which|whether|to|unit|units|chamber|"
                     r"waiting|waits|run|runs|slot|slots|dew|turn|turned|safe|nothing|on|off|up|down|after|before|noise|samples|last|choose|own)\b", re.I)
# Every text and name on the page but those that are English by their mark; what the form is filled with is nobody's text.
SHOWN = """
const shown = [];
const walk = (node) => {
  if (node.nodeType === 3) { if (node.data.trim()) shown.push(node.data.trim()); return; }
  if (node.nodeType !== 1 || node.lang === 'en' || ['CODE', 'SCRIPT', 'STYLE', 'TEMPLATE', 'DATALIST'].includes(node.tagName)) return;
  if (node.offsetParent === null && !node.ownerSVGElement && getComputedStyle(node).position !== 'fixed' && node !== document.body &&
      !['HTML', 'SVG', 'OPTION', 'DIALOG'].includes(node.tagName.toUpperCase())) return;
  for (const name of ['aria-label', 'placeholder', 'title']) if (node.getAttribute(name)) shown.push(node.getAttribute(name));
  node.childNodes.forEach(walk);
};
walk(document.body);
return [document.title, ...shown];"""
# Names and parameters of all texts of a module.
PARTS = """
const parts = (group, way) => Object.entries(group).flatMap(([name, value]) =>
  typeof value === 'object' ? parts(value, `${way}${name}.`) : [`${way}${name} ${typeof value === 'function' ? value.length : 'text'}`]);
return import(`/${arguments[0]}`).then(({ text }) => parts(text, ''));"""
# The report is a document of record in English; the languages themselves and types.
NO_VIEWS = {"documents.mjs", "figure.mjs", "figure_words.mjs", "kept_documents.mjs", "report.mjs"} | {path.name for path in WEB.glob("text_*.mjs")}


class OwnTexts(html.parser.HTMLParser):
    """Texts and names that stand in a page itself, but for those marked as English and for what is typed or a name."""

    NAMES = ("aria-label", "placeholder", "title", "alt")
    VOID = ("meta", "link", "img", "input")

    def __init__(self, text):
        super().__init__()
        self.open, self.found = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        left_out = tag in ("code", "title", "head", "script") or (tag != "html" and attributes.get("lang") == "en") or any(out for _, out in self.open)
        if not left_out:
            self.found += [attributes[name] for name in self.NAMES if attributes.get(name)]
        if tag not in self.VOID:
            self.open.append((tag, left_out))

    def handle_endtag(self, tag):
        while self.open and self.open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        if re.search("[A-Za-z]{2}", data) and not any(out for _, out in self.open):
            self.found.append(data.strip())


class Named(html.parser.HTMLParser):
    """The texts that a page names: (group of views, key)."""

    def __init__(self, text):
        super().__init__()
        self.open, self.asked = [("", "")], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        group = attributes.get("data-texts", self.open[-1][1])
        self.asked += [(group, attributes[f"data-{name}"]) for name in ("text", "label", "hint", "tip") if f"data-{name}" in attributes]
        if tag not in OwnTexts.VOID:
            self.open.append((tag, group))

    def handle_endtag(self, tag):
        while len(self.open) > 1 and self.open.pop()[0] != tag:
            pass


def module_of(group, language):
    return f"text_{group}_{language}.mjs" if group else f"text_{language}.mjs"


# Of views whose texts load together; "" of the station's own view.
GROUPS = sorted({re.sub(r"^text_|_?en\.mjs$", "", path.name) for path in WEB.glob("text_*en.mjs")})


def sentences_in(code):
    """String literals that read like words for people; names of keys, and what is for the console or a style sheet, are none."""
    code = re.sub(r"/\*.*?\*/|(?<!:)//[^\n]*", "", code, flags=re.S)
    code = "\n".join(line for line in code.splitlines() if not re.search(r"console\.|element\(.code|className|class:|\.tell\(|new Error\(`HTTP|\.key\b|LANGUAGES =", line))
    return [text for _, text in re.findall(r"""(["`])((?:(?!\1)[^\\\n]|\\.)*)\1""", code) if re.search(r"^[A-Z][a-z]+( [a-z]+|…|\.|$)|[a-z] [a-z]+ [a-z]+ ", text)]


class Sources(unittest.TestCase):
    def test_the_pages_carry_no_text_of_their_own(self):
        for page, names in (("index.html", ["Soak", "Soak"]), ("login.html", ["Soak"]), ("setup.html", ["Soak"])):
            with self.subTest(page=page):
                self.assertEqual(sorted(OwnTexts((WEB / page).read_text(encoding="utf-8")).found), sorted(names[: 2 if page == "index.html" else 1]))

    def test_a_text_in_a_page_is_found(self):
        self.assertEqual(OwnTexts('<body lang="de"><p data-text="a"></p><p>Left behind</p><div lang="en">Known</div><i title="A tip"></i></body>').found, ["Left behind", "A tip"])

    def test_the_modules_of_whole_views_carry_no_sentence(self):
        modules = [path for path in WEB.glob("*.mjs") if path.name not in NO_VIEWS]
        self.assertGreater(len(modules), 15)
        for module in modules:
            with self.subTest(module=module.name):
                self.assertEqual(sentences_in(module.read_text(encoding="utf-8")), [])

    def test_a_button_that_is_to_be_pressed_has_that_name(self):
        german = (WEB / "text_de.mjs").read_text(encoding="utf-8")
        named = set(re.findall("„([^“]+)“ drücken", german))
        self.assertIn("Fortsetzen", named)
        self.assertEqual([name for name in named if f'"{name}"' not in german], [])

    def test_a_sentence_in_a_module_is_found(self):
        for code in ('say(node, "Sending…");', "say(node, `Mail to ${name}`);", 'throw new Error("The station does not answer");', "const text = `last sent at ${time}: look there `;"):
            with self.subTest(code=code):
                self.assertNotEqual(sentences_in(code), [])


PLAN = soak_plan()


class LanguageTest(PageTest):
    def setUp(self):
        super().setUp()
        self.station.set("/clock", RATE_1)
        self.station.set("/chamber/description", "VT 4011")
        self.station.tell("plan " + json.dumps(PLAN))
        set_step(self.station, PLAN, "record", run=1)
        self.station.set("/units/0/state", "streaming")
        self.station.set("/units/1/state", "closed")
        self.speak("en")

    def speak(self, tags):
        """What the browser asks for; each station has a port, and with it a memory, of its own."""
        self.browser.devtools("Network.setUserAgentOverride", userAgent=self.browser.run("return navigator.userAgent"), acceptLanguage=tags)

    def open_german(self):
        self.speak("de-AT,de,en")
        self.open()


class Choice(LanguageTest):
    def test_the_browser_decides_until_somebody_does_and_one_language_is_loaded(self):
        language = "return document.documentElement.lang"
        loaded = "return performance.getEntriesByType('resource').map(({ name }) => name.split('/').pop()).filter((name) => /^text_/.test(name))"
        for tags, expected in (("fr-FR,de-AT,en", "de"), ("fr-FR,it", "en"), ("en-US,de", "en")):
            self.speak(tags)
            self.open()
            self.assertEqual(self.browser.run(language), expected, tags)
            self.assertEqual(self.browser.run(loaded), [f"text_{expected}.mjs"])
        self.browser.run("const select = document.querySelector('#language'); select.value = 'de'; select.dispatchEvent(new Event('change'));")
        self.see("#to-units", "Prüflinge")
        self.open()
        self.see("#to-units", "Prüflinge")
        self.assertEqual(self.browser.run(language), "de")

    def test_all_languages_have_the_same_texts_with_the_same_parameters(self):
        self.open()
        for group in GROUPS:
            english, german = [self.browser.run(PARTS, module_of(group, tag)) for tag in ("en", "de")]
            with self.subTest(group=group):
                self.assertGreater(len(english), 20)
                self.assertEqual(english, german)

    def test_every_text_that_index_html_names_is_there(self):
        self.open_german()
        known = {group: {part.split()[0] for part in self.browser.run(PARTS, module_of(group, "de")) if part.endswith(" text")} for group in GROUPS}
        for page in ("index.html", "login.html", "setup.html"):
            asked = Named((WEB / page).read_text(encoding="utf-8")).asked
            self.assertGreater(len(asked), 5)
            self.assertEqual([(group, key) for group, key in asked if key not in known.get(group, ())], [])

    def test_the_head_takes_one_line_on_a_screen_of_1280(self):
        self.station.set("/campaign/name", "acceptance of the second lot, repeated after the repair")
        for tags in ("en", "de"):
            self.speak(tags)
            self.open()
            self.browser.resize(1280, 900)
            boxes = self.browser.run("""return [...document.querySelectorAll('.top > *, .top nav a, .top input')].map((node) => [node.id || node.textContent, node.getBoundingClientRect()])
                .filter(([, box]) => box.width > 0 && box.height > 0).map(([name, { left, right, top, bottom }]) => ({ name, left, right, top, bottom }));""")
            self.assertGreater(len(boxes), 10)
            self.assertLess(max(box["top"] for box in boxes), min(box["bottom"] for box in boxes), boxes)
            self.assertLessEqual(max(box["right"] for box in boxes), 1280, boxes)
            self.assertEqual([box for box in boxes if box["name"] == "campaign-name" and box["right"] - box["left"] < 48], [])

    def test_numbers_and_dates_are_written_as_the_language_does(self):
        self.station.set("/campaign/remaining_s", 86400.0)
        for tags, air, day in (("de", "−20,04", "morgen"), ("en", "−20.04", "tomorrow")):
            self.speak(tags)
            self.open()
            self.see("#air", air)
            self.see("#finish", day)
        self.speak("de")
        self.station.set("/clock/rate", 0.5)
        self.open()
        self.see("#host-label", "0,5-fach")


class German(LanguageTest):
    """A technician's way, as somebody sees it who has chosen German; what the station itself says is marked as English."""

    def assert_german(self, what):
        english = [text for text in self.browser.run(SHOWN) if ENGLISH.search(text)]
        self.assertEqual(english, [], what)

    def assert_fits(self):
        for width in (390, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)

    def test_an_english_sentence_would_be_found(self):
        self.open()
        found = [text for text in self.browser.run(SHOWN) if ENGLISH.search(text)]
        for text in ("Keep the door closed", "Set point", "Last events"):
            self.assertIn(text, " ".join(self.browser.run(SHOWN)))
        self.assertGreater(len(found), 20)

    def test_a_running_campaign(self):
        for command, document in (("history", soak_history()), ("noise", allan_noise())):
            self.station.tell(f"{command} {json.dumps(document)}")
        self.open_german()
        for kind, text in (("set_temperature", "Kammer fährt zum Sollwert"), ("wait_stable", "Temperaturausgleich"), ("record", "Aufzeichnung, +X oben"),
                           ("move", "dreht, +X oben"), ("warm_end", "Tau"), ("power_off", "ausgeschaltet"), ("power_on", "starten")):
            set_step(self.station, PLAN, kind, run=1)
            self.see("#step-text", text)
            self.see("#step-text", "Lauf 1 von 2")
            self.assert_german(kind)
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.wait_for_noise()
        self.assert_german("noise")
        self.assert_fits()
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_every_question_that_the_station_asks(self):
        self.open_german()
        self.station.set("/state", "waiting")
        asked = {"position": ({"position": "-Z", "wrong": ["SN1", "SN2"]}, "Noch nicht richtig: Prüfling SN1 und SN2. Die Vorrichtung so drehen, dass ihr −Z nach oben zeigt"), "heading": ({"heading_deg": -22.5}, "22,5° gegen den Uhrzeigersinn"),
                 "dry_air": ({"temp_c": -20.0}, "−20 °C."), "power": ({"off_s": 10.0, "slots": ["A", "C"]}, "Steckplätzen A und C mindestens 10 s"),
                 "units": ({"slots": ["B"], "expected": ["SN2"], "found": ["SN9"]}, "In Steckplatz B steckt Prüfling SN9, erwartet ist SN2.")}
        self.assertEqual(set(asked), set(STATUS_SCHEMA["properties"]["prompt"]["properties"]["code"]["enum"]))
        for number, (code, (about, text)) in enumerate(asked.items(), 1):
            prompt = {"id": number, "text": "The station's own words for it.", "code": code, "about": about}
            jsonschema.Draft202012Validator(STATUS_SCHEMA["properties"]["prompt"]).validate(prompt)
            self.station.set("/prompt", prompt)
            self.see("#prompt-text", text)
            self.assert_german(code)

    def test_a_question_to_turn_with_its_faces(self):
        set_step(self.station, PLAN, "move", run=1, visit=1, position="+X")
        self.open_german()
        self.station.set("/prompt", {"id": 7, "text": "Turn the fixture.", "code": "position", "about": {"position": "+X", "wrong": []}})
        self.station.set("/state", "waiting")
        for face, text in ((attitude("+Y", "+X", False), "Vierteldrehung auf +X"), (attitude("-X", "+X", False), "halbe Drehung auf +X"),
                           (attitude("+X", "+X", False), "5° von +X"), (attitude("+X", "+X", True), "+X liegt oben ✓")):
            self.station.set("/units/0/attitude", face)
            self.see("#prompt-faces", text)
            self.assert_german(text)
        self.see("#state", "wartet auf Sie")
        self.assert_fits()

    def test_every_alarm_is_said_by_its_code(self):
        self.station.set("/units/0/attitude", attitude("+Y", "-X", False))
        self.open_german()
        codes = STATUS_SCHEMA["properties"]["alarms"]["items"]["properties"]["code"]["enum"]
        self.assertGreater(len(codes), 12)
        said = self.browser.run("""
            return import('/words.mjs').then(async ({ alertsOf }) => {
              const status = await fetch('/api/v1/status').then((answer) => answer.json());
              return arguments[0].flatMap((code) => ['running', 'stopping', 'paused'].flatMap((state) => [true, false].map((resumes) => {
                const of = { ...status, state, resumes_by_itself: resumes, resumable: resumes ? 'acceptance' : null };
                const [{ title, action }] = alertsOf({ ...of, alarms: [{ code, about: code.startsWith('unit_') ? 'SN0042' : 'acceptance', title: 'the title of the station',
                  action: 'the action of the station', deadline: { text: 'the deadline', utc_s: status.clock.utc_s } }] });
                return [code, title, action];
              })));
            });""", codes)
        self.assertEqual({code for code, *_ in said}, set(codes))
        for code, *texts in said:
            for text in texts:
                self.assertNotRegex(text, ENGLISH, code)

    @long_test
    def test_what_to_do_at_a_silent_chamber_is_what_the_station_says(self):
        self.open_german()
        self.station.set("/chamber/connected", False)
        says = {"goes on by itself": "läuft die Kampagne von selbst weiter", "something else, too": "wartet auch noch auf etwas anderes", "stays paused": "bleibt pausiert",
                "within a minute": "binnen einer Minute", "by hand": "von Hand abschalten"}
        told = set()
        for state, causes in (("waiting", ["chamber"]), ("waiting", ["disk"]), ("waiting", ["chamber", "disk"]), ("paused", None), ("running", None), ("stopping", None)):
            self.station.set("/suspension", causes and {"causes": causes, "for_s": 60.0, "gives_up_in_s": 86400.0})
            self.station.set("/state", state)
            silent = next(alarm for alarm in self.status()["alarms"] if alarm["code"] == "chamber_silent")
            [english] = [phrase for phrase in says if phrase in silent["action"]]
            told.add(english)
            self.browser.wait("return [...document.querySelectorAll('#alerts li')].some((item) => item.innerText.includes('Temperaturkammer antwortet nicht') && "
                              "item.innerText.includes(arguments[0]))", says[english])
        self.assertEqual(told, set(says))

    @long_test
    def test_how_a_unit_comes_to_rest_as_it_should(self):
        set_step(self.station, PLAN, "record", run=1)
        self.station.set("/fixture/description", "by hand")
        self.station.set("/units/0/attitude", attitude("+Y", "-X", False))
        self.open_german()
        self.see("#alerts .alarm", "hat +Y oben statt −X")
        self.see("#alerts .alarm", "Die Vorrichtung drehen: +Y liegt jetzt oben, eine Vierteldrehung auf −X drehen.")
        self.station.set("/units/0/attitude", attitude("-X", "-X", False))
        self.see("#alerts .alarm", "weicht um mehr als 5° von −X ab")

    @long_test
    def test_alarms_as_they_stand_on_the_page(self):
        self.open_german()
        self.station.set("/chamber/alarms", ["E-14"])
        self.see("#alerts .alarm", "meldet einen Alarm: E-14")
        self.assert_german("alarm of the chamber")
        self.station.set("/chamber/alarms", [])
        self.station.set("/suspension", {"causes": ["supply"], "for_s": 60.0, "gives_up_in_s": 86400.0})
        self.station.set("/state", "waiting")
        self.station.set("/reason", "the supply gives 3 V")
        self.see("#alerts .warning", "Sonst endet die Kampagne: morgen")
        self.see("#state", "wartet auf die Versorgungsspannung")
        self.see("#reason", "the supply gives 3 V")  # its own words
        self.assert_german("suspended")
        self.assert_fits()

    def test_the_door_and_the_dialog_before_an_abort(self):
        set_step(self.station, PLAN, "record", run=2)
        self.open_german()
        for state in ("running", "paused", "preflight"):
            self.station.set("/state", state)
            self.browser.wait("return document.querySelector('#state').dataset.state === arguments[0]", state)
            self.assert_german(state)
        self.station.set("/state", "running")
        self.station.set("/chamber/air_c", -20.0)
        self.see("#door-text", "Zum Öffnen bei 40 °C „Pausieren“ drücken")
        self.assert_german("cold")
        self.browser.click("#abort")
        self.see("#abort-dialog", "Was von Lauf 2 von 2 aufgezeichnet ist, wird ungültig")
        self.see("#abort-dialog", "Der Lauf davor bleibt.")
        self.see("#abort-send", "Kampagne abbrechen")  # "Abbrechen" alone closes a dialog, in German
        self.see("#abort-cancel", "Weiterlaufen lassen")
        self.assert_german("abort")
        self.browser.click("#abort-cancel")

    @long_test
    def test_a_campaign_that_is_over(self):
        self.open_german()
        for state, text in (("finished", "acceptance ist fertig."), ("aborted", "acceptance wurde abgebrochen")):
            self.station.set("/state", state)
            self.see("#after", text)
            self.assert_german(state)
            self.assert_fits()

    @long_test
    def test_a_refusal_in_the_station_s_own_words_is_marked_as_english(self):
        self.open_german()
        self.station.tell("fail 2 state")
        self.browser.click("#pause")
        self.see("#failure", "Pausieren: scripted failure")
        self.assertEqual(self.browser.text("#failure [lang=en]"), "scripted failure")
        self.assert_german("refusal")

    def test_a_station_at_rest_with_a_new_campaign(self):
        self.station.set("/state", "idle")
        self.station.set("/campaign", None)
        self.station.tell("stored " + json.dumps(STORED))
        self.open_german()
        self.see("#stored-campaigns", "fertig")
        self.see("#start-box", "Neue Kampagne")
        self.see("#start-slots", "Steckplatz 1: Seriennummer")
        self.assert_german("idle")
        self.assert_fits()

    @long_test
    def test_the_help_says_that_the_guide_is_english(self):
        self.open_german()
        self.browser.go(f"{self.station.url}#help")
        self.see("#help-english", "nur auf Englisch")
        self.browser.wait_for_text("#help-page[lang=en]", "Guide")
        self.assert_german("help")
        self.browser.go(f"{self.station.url}#help=no-such-page")
        self.see("#help-failure", "„no-such-page“")
        self.browser.console()  # Chromium lists the 404
        self.speak("en")
        self.open()
        self.browser.go(f"{self.station.url}#help")
        self.browser.wait_for_text("#help-page", "Guide")
        self.hidden("#help-english")

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_nothing_serious_is_found(self):
        self.open_german()
        self.see("#door", "Tür")
        for width in (1280, 390):
            self.browser.resize(width, 900)
            self.assertEqual(self.browser.run(AXE.read_text(encoding="utf-8") + SERIOUS), [])

    def test_the_log_in(self):
        self.speak("de")
        self.browser.go(f"{self.station.url}login.html")
        self.see("#log-in-title", "anmelden")
        self.assert_german("login")


if __name__ == "__main__":
    unittest.main()
