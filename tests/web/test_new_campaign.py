# SPDX-License-Identifier: Apache-2.0
"""A campaign is chosen, checked and refused from the page before a real `soakd` ($SOAK_BIN_FOLDER) whose chamber nobody answers for."""
import json
import tempfile
import unittest
import urllib.error
import urllib.request
import pathlib
import sys

from browser import BROWSER, DRIVER, Browser
from real_soakd import ROOT, Soakd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import check_schema  # noqa: E402

SHIPPED = "six-position-both-ways.toml"
OWN = """name = "of this laboratory"
purpose = "calibration"
kind = "soak"
runs = 2
[temperatures]
list_c = [0, 20]
[positions]
order = ["+X", "-X"]
"""


class Laboratory(Soakd):
    """With procedures of its own, one of them wrong, and one unit whose type is known."""

    def store_all(self):
        own = self.data / "procedures"
        own.mkdir(parents=True)
        (own / "ours.toml").write_text(OWN, encoding="utf-8")
        (own / "broken.toml").write_text("name = 3\n", encoding="utf-8")
        (own / SHIPPED).write_text(OWN.replace("of this laboratory", "instead of the shipped one"), encoding="utf-8")
        self.soak("unit", "add", "SN0042", "--type", "mti-300")

    def post(self, path, **body):
        request = urllib.request.Request(f"{self.url}api/v1/{path}", json.dumps(body).encode(), {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=30) as answer:
            return json.load(answer)

    def refused_at(self, path, **body):
        """Member that the refusal names."""
        try:
            self.post(path, **body)
        except urllib.error.HTTPError as error:
            assert error.code == 400, error.code
            return json.load(error)["error"]["where"]
        raise AssertionError("not refused")

    def check(self, **body):
        document = self.post("campaign/check", **body)
        check_schema(document, "http-campaign-check")
        return document


class WithLaboratory(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soakd = Laboratory()
        cls.addClassCleanup(cls.soakd.close)


class Interface(WithLaboratory):
    def procedures(self):
        document = self.soakd.get("procedures")
        check_schema(document, "http-procedures")
        return {entry["file"]: entry for entry in document["procedures"]}

    def test_the_laboratory_s_own_procedures_come_with_the_shipped_ones_and_before_them(self):
        procedures = self.procedures()
        self.assertEqual(set(procedures), {path.name for path in (ROOT / "procedures").glob("*.toml")} | {"ours.toml", "broken.toml"})
        self.assertEqual(procedures[SHIPPED]["name"], "instead of the shipped one")
        [ours] = self.soakd.get("procedures", file="ours.toml")["procedures"]
        self.assertEqual(ours["text"], OWN)
        self.assertIn("broken.toml:1", procedures["broken.toml"]["trouble"])
        self.assertEqual([file for file, entry in procedures.items() if entry["trouble"]], ["broken.toml"])

    def test_it_takes_as_long_as_the_command_line_says(self):
        path = ROOT / "procedures" / "six-position-soak.toml"
        expected = self.soakd.soak_json("procedure", "check", path)
        self.assertAlmostEqual(self.procedures()[path.name]["estimate_s"] / 3600, expected["estimate_h"], 6)
        document = self.soakd.check(procedure_text=path.read_text(encoding="utf-8"), procedure_file=path.name, campaign="c", units={"1": "SN0042"})
        self.assertAlmostEqual(document["procedure"]["estimate_s"] / 3600, expected["estimate_h"], 6)
        self.assertEqual(document["procedure"]["runs"], expected["runs"])
        self.assertEqual(document["units"], [{"slot": "1", "serial": "SN0042", "type": "mti-300"}])
        self.assertEqual(document["mistakes"], [])
        self.assertGreater(document["disk"]["needed_bytes"], 1e6)

    def test_all_mistakes_are_told_at_once_and_nothing_begins(self):
        before = self.soakd.query("SELECT count(*) FROM event")
        document = self.soakd.check(procedure_text="name = 3\nruns = 0\n", procedure_file="p.toml", campaign="", units={"1": "SN9", "Q": "SN8"})
        self.assertIsNone(document["procedure"])
        text = "\n".join(mistake["message"] for mistake in document["mistakes"])
        for part in ("p.toml:1", "p.toml:2", "name of the campaign", "SN9", "'Q'"):
            self.assertIn(part, text)
        self.assertEqual(self.soakd.query("SELECT count(*) FROM event"), before)
        self.assertEqual(self.soakd.get("stored")["campaigns"], [])

    def test_what_the_unit_cannot_bear_is_told_once(self):
        text = OWN.replace("[0, 20]", "[0, 200]")
        document = self.soakd.check(procedure_text=text, procedure_file="hot.toml", campaign="c", units={"1": "SN0042"})
        ratings = [mistake["message"] for mistake in document["mistakes"] if "mti-300" in mistake["message"]]
        self.assertEqual(len(ratings), 1, document["mistakes"])

    def test_a_unit_is_entered_once_with_a_type_that_there_is(self):
        answer = self.soakd.post("unit/add", unit="SN0077", type="mti-300", user="Eva")
        check_schema(answer, "http-unit-add")
        self.assertEqual(self.soakd.post("unit/add", unit="SN0077", type="mti-300", user="Eva"), answer)
        self.assertEqual(self.soakd.query("SELECT subject, text, user FROM event WHERE kind = 'unit_added' AND subject = 'SN0077'"), [("SN0077", "as mti-300", "Eva")])
        self.assertEqual(self.soakd.refused_at("unit/add", unit="SN0077", type="vn-200", user="Eva"), "type")
        self.assertEqual(self.soakd.refused_at("unit/add", unit="SN0078", type="no such", user="Eva"), "type")
        self.assertEqual(self.soakd.refused_at("unit/add", unit="a\nb", type="vn-200", user="Eva"), "unit")
        self.assertIn("SN0077", [unit["unit"] for unit in self.soakd.soak_json("unit", "list")["units"]])
        types = self.soakd.get("types")
        check_schema(types, "http-types")
        shown = self.soakd.soak_json("type", "show", "mti-300")["type"]
        self.assertEqual([one for one in types["types"] if one["name"] == "mti-300"], [shown])

    def test_a_certificate_is_entered_as_from_the_command_line(self):
        entry = {"kind": "chamber_probe", "name": "probe 3", "certificate": "C-1", "issued": "2026-03-01", "due": "2099-03-01", "uncertainty": 0.05,
                 "k": 2, "correction": -0.02, "user": "Eva"}
        document = self.soakd.post("references/add", **entry)
        check_schema(document, "reference-list")
        self.assertEqual(document, self.soakd.get("references"))
        # JCGM 100:2008, 6.2.1: u = U / k.
        shown = self.soakd.soak_json("reference", "list")["references"]
        self.assertEqual([(one["name"], one["standard_uncertainty"], one["correction"], one["user"]) for one in shown], [("probe 3", 0.025, -0.02, "Eva")])
        for wrong in ({"due": "2026-02-01"}, {"issued": "soon"}, {"uncertainty": 99}, {"k": 9}, {"correction": 40}, {"kind": "ruler"}, {"name": ""}):
            self.assertEqual(self.soakd.refused_at("references/add", **{**entry, **wrong}), *wrong)
        self.assertEqual(self.soakd.get("references"), document)
        record_id = document["references"][0]["record_id"]
        retired = self.soakd.post("references/retire", record_id=record_id, reason="dropped", user="Bob")["references"]
        self.assertEqual((retired[0]["standing"], retired[0]["retired"]["user"]), ("retired", "Bob"))


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class OnThePage(WithLaboratory):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def choose(self, file):
        self.browser.run("""const choice = document.querySelector('#start-choice'); choice.value = arguments[0];
            for (const kind of ['input', 'change']) choice.dispatchEvent(new Event(kind, { bubbles: true }));""", file)

    def open(self):
        self.browser.go(self.soakd.url)
        self.browser.wait("return document.querySelectorAll('#start-choice option').length > 5")
        self.browser.wait("return document.querySelectorAll('#start-slots input').length === 1")
        self.browser.console()

    def test_a_procedure_is_chosen_from_a_list_and_checked_as_the_form_is_filled_in(self):
        self.open()
        self.assertTrue(self.browser.run("return document.querySelector('#start-choice option[value=\"broken.toml\"]').disabled"))
        self.choose("ours.toml")
        self.browser.wait_for_text("#start-review", "of this laboratory")
        self.assertNotIn("Refused", self.browser.run("return document.querySelector('#start-review').innerText"), "nothing was entered yet")
        self.browser.type("#start-slots input", "SN0043")
        self.browser.wait_for_text("#start-review", "the type of unit SN0043 is not known")
        self.assertEqual(self.browser.run("return [document.querySelector('#start-unknown select').value, document.querySelector('#start-unknown button').disabled]"), ["", True])
        self.browser.run("""const types = document.querySelector('#start-unknown select'); types.value = 'vn-200';
            types.dispatchEvent(new Event('change', { bubbles: true }));""")
        self.browser.click("#start-unknown button")
        self.browser.wait_for_text("#start-review", "SN0043, type vn-200")
        self.browser.run("document.querySelector('#start-slots input').value = ''")
        self.browser.type("#start-slots input", "SN0042")
        self.browser.wait_for_text("#start-review", "SN0042, type mti-300")
        self.browser.wait("return document.querySelector('#start-review .bad') === null")
        self.browser.wait_for_text("#start-review", "of this laboratory: 2 runs, 2 visits each, from 0 to 20 °C, 2 positions")
        self.browser.wait_for_text("#start-review", "started now it ends")
        self.assertEqual(self.browser.console(), [])
        # Checked is not begun: now the chamber is asked, which does not answer.
        self.browser.type("#start-name", "2026-12")
        self.browser.click("#start-send")
        self.browser.wait_for_text("#start-failure", "cannot connect")
        self.browser.console()  # Chromium lists the 502

    def test_a_procedure_in_the_list_says_what_it_is_for_and_how_long_it_takes(self):
        self.open()
        said = dict(self.browser.run("return [...document.querySelectorAll('#start-choice option')].map((option) => [option.value, option.text])"))
        hours = round(next(entry["estimate_s"] for entry in self.soakd.get("procedures")["procedures"] if entry["file"] == "minor-loop.toml") / 60) // 60
        self.assertRegex(said["minor-loop.toml"], rf"^minor-loop, calibration, {hours} h( \d+ min)?: The set points of six-position-both-ways upwards, with a turn halfway$")
        cut = self.browser.run("""const [description] = arguments; return import('/start_words.mjs').then(({ procedureText }) =>
            procedureText({ file: 'x', name: 'x', trouble: null, description, purpose: 'calibration', estimate_s: 3600 }))""", "x" * 120)
        self.assertTrue(cut.endswith(": " + "x" * 90 + "…"), "one long word")
        self.assertRegex(said["verification.toml"], r"^verification, verification, \d+ h.*: ")
        self.assertRegex(said["ours.toml"], r"^of this laboratory, calibration, \d+ h( \d+ min)?$")
        self.assertEqual(said["broken.toml"], "broken.toml (has mistakes)")
        self.assertTrue(all(len(text) < 160 for text in said.values()), said)
        self.choose("minor-loop.toml")
        self.browser.wait_for_text("#start-review [lang=en]", "Thermal hysteresis remembers the turn, a warm-up or an ageing does not.")

    def review(self, procedure, **asked):
        """Lines of the review of a procedure, as texts."""
        document = {"name": "p", "description": "", "purpose": "calibration", "runs": 2, "visits": [9, 9], "turns": 120, "set_points_c": [-20, 20, 60], "positions": ["+X"],
                    "estimate_s": 36000, **procedure}
        review = {"procedure": document, "mistakes": [], "disk": {"needed_bytes": None, "free_bytes": None}}
        return self.browser.run("""const [review, asked] = arguments; return import('/start_words.mjs').then(({ reviewLines }) =>
            reviewLines(review, { named: true, filled: true, rate: 1, end: () => null, safe: null, ...asked }).map(({ parts }) => parts.map((part) => part.english ?? part).join('')))""", review, asked)

    def test_who_turns_by_hand_is_told_how_often_and_when_behind_a_closed_door(self):
        self.open()
        self.assertFalse(any("turn" in line for line in self.review({})), "a machine turns")
        lines = self.review({}, safe={"from_c": 20, "to_c": 47})
        self.assertTrue(any("120 times, about every 5 min" in line for line in lines), lines)
        self.assertTrue(any("At −20, 20, 60 °C turn it with the door closed" in line and "between 20 and 47 °C" in line for line in lines), lines)
        lines = self.review({}, safe={"from_c": 20, "to_c": 47}, rate=36000)
        self.assertTrue(any("about every 5 min of simulated time" in line for line in lines), lines)
        self.assertTrue(any(line.endswith("takes about 10 h of simulated time, and the time that each turn takes") for line in lines), "nobody keeps an end by the fast clock")
        lines = self.review({"set_points_c": [25, 40]}, safe={"from_c": 20, "to_c": 47})
        self.assertFalse(any("door closed" in line for line in lines), lines)

    def test_a_procedure_with_power_cycles_has_its_visits_told_run_by_run(self):
        self.open()
        self.assertTrue(any("2 runs, 4 and 6 visits, from" in line for line in self.review({"visits": [4, 6]})))
        text = (pathlib.Path(__file__).resolve().parents[2] / "procedures/power-cycle.toml").read_text(encoding="utf-8")
        document = self.soakd.check(procedure_text=text, procedure_file="p.toml", campaign="c", units={"1": "SN0042"})
        check_schema(document, "http-campaign-check")
        planned = document["procedure"]
        self.assertEqual((len(planned["visits"]), sum(planned["visits"][:2])), (planned["runs"], len(planned["set_points_c"]) + 1), "the visit of the cycle is in both")

    def test_the_question_after_start_gets_the_focus_but_not_from_a_field(self):
        self.open()
        reached = [self.browser.run("""const [id, number] = arguments; return import('/campaign_cards.mjs').then(({ renderPrompt }) => {
            document.querySelector('#start-box').open = true;
            Object.assign(document.querySelector('#start-card'), { hidden: false, inert: false });
            document.getElementById(id).focus();
            renderPrompt({ prompt: { id: number, code: "heading", text: "Turn it.", about: null }, campaign: null, units: [] }, null);
            return document.activeElement.id; })""", name, number) for number, name in enumerate(("start-send", "start-name"), 71)]
        self.assertEqual(reached, ["prompt-title", "start-name"])

    def test_two_times_are_told_by_their_names(self):
        self.open()
        self.assertTrue(any("takes about 10 h of simulated time, 10 min of real time" in line for line in self.review({}, rate=60)))
        self.assertTrue(any(line.endswith("takes about 10 h") for line in self.review({})))

    def test_without_a_serial_number_it_is_said_in_the_words_of_the_page(self):
        self.open()
        self.choose("ours.toml")
        self.browser.wait_for_text("#start-review", "No serial number yet")
        self.browser.type("#start-name", "without")
        self.browser.click("#start-send")
        self.browser.wait_for_text("#start-failure", "enter that of at least one unit")
        self.assertNotIn("--unit", self.browser.text("body"))
        self.browser.console()  # Chromium lists the 400

    def test_the_initial_of_a_name_ends_no_sentence(self):
        self.open()
        said = self.browser.run("""return import('/start_words.mjs').then(({ procedureText }) => procedureText({ file: 'x', name: 'x', trouble: null, purpose: 'calibration',
            estimate_s: 3600, description: 'The soak test of W. T. Fong. More of it.' }))""")
        self.assertTrue(said.endswith(": The soak test of W. T. Fong"), said)

    def test_a_file_that_was_changed_meanwhile_is_what_is_checked(self):
        path = self.soakd.data / "procedures" / "changing.toml"
        self.addCleanup(path.unlink)
        path.write_text(OWN, encoding="utf-8")
        self.open()
        self.choose("changing.toml")
        self.browser.wait_for_text("#start-review", "from 0 to 20 °C")
        path.write_text(OWN.replace("[0, 20]", "[0, 30]"), encoding="utf-8")
        self.browser.type("#start-name", "x")
        self.browser.wait_for_text("#start-review", "from 0 to 30 °C")
        path.write_text("name = 3\n", encoding="utf-8")
        self.browser.type("#start-name", "y")
        self.browser.wait_for_text("#start-review", "changing.toml:1")
        self.assertEqual(self.browser.console(), [])

    def test_a_file_of_one_s_own_is_checked_too(self):
        self.open()
        self.choose("own file")
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("name = 3\n")
            file.flush()
            self.browser.type("#start-procedure", file.name)
            self.browser.wait_for_text("#start-review", f"{pathlib.Path(file.name).name}:1")
            self.assertTrue(self.browser.run("return document.querySelector('#start-review .bad') !== null"))
        self.assertEqual(self.browser.console(), [])

    def test_a_reference_is_entered_and_retired(self):
        self.browser.go(self.soakd.url + "#records")
        self.browser.wait("return document.querySelectorAll('#types tbody tr').length >= 4")
        self.browser.run("document.querySelector('#reference-form').closest('details').open = true")
        for name, value in (("name", "level <b>1</b>"), ("certificate", "L-7"), ("uncertainty", "0.01"), ("user", "Eva")):
            self.browser.type(f"#reference-{name}", value)
        self.assertIn("K", self.browser.run("return document.querySelector('#reference-correction-box').innerText"))
        self.browser.run("""const kind = document.querySelector('#reference-kind'); kind.value = 'level';
            kind.dispatchEvent(new Event('change', { bubbles: true }));
            document.querySelector('#reference-issued').value = '2026-01-01'; document.querySelector('#reference-due').value = '2099-01-01';""")
        self.assertIn("°: level error", self.browser.run("return document.querySelector('#reference-correction-box').innerText"))
        self.browser.click("#reference-form button[type=submit]")
        self.browser.wait_for_text("#references", "level <b>1</b>")
        self.browser.wait_for_text("#references", "valid")
        retire = "#references [aria-label='Retire level <b>1</b>']"
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", retire)
        self.browser.click(retire)
        self.browser.type("#retire-reason", "bent")
        self.browser.type("#retire-user", "Bob")
        self.browser.click("#retire-send")
        self.browser.wait_for_text("#references", "retired")
        [entry] = [one for one in self.soakd.get("references")["references"] if one["certificate"] == "L-7"]
        self.assertEqual((entry["user"], entry["retired"]["user"]), ("Eva", "Bob"))
        self.assertEqual(self.browser.console(), [])
        for width in (320, 390, 768, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)

    def test_an_expired_certificate_is_mended_under_records_and_the_refusal_is_gone(self):
        self.soakd.soak("reference", "add", "--kind", "supply", "--name", "supply 1", "--certificate", "S-1", "--issued", "2024-01-01", "--due", "2025-01-01",
                        "--uncertainty", "0.01")
        self.open()
        self.choose("ours.toml")
        self.browser.wait_for_text("#start-review", "supply 1")
        self.browser.click("#start-review .bad a")
        self.browser.wait_for_text("#references", "No campaign begins with it: enter its next certificate, or have a waiver signed")
        key = self.soakd.folder / "head.key"
        self.soakd.soak("key", "new", "-o", key)
        self.soakd.soak("reference", "waive", "--kind", "supply", "--name", "supply 1", "--reason", "compared", "--key", key, "--signer", "Ann")
        self.browser.click("#to-station")
        self.browser.click("#to-records")
        self.browser.wait_for_text("#references", "waived by Ann")
        self.browser.wait_for_text("#references", "It ends when the next certificate is entered or the reference is retired.")
        self.browser.run("document.querySelector(\"#references [aria-label='Retire supply 1']\").click()")
        self.browser.type("#retire-reason", "sold")
        self.browser.type("#retire-user", "Bob")
        self.browser.click("#retire-send")
        self.browser.wait("return !document.querySelector('#retire-dialog').open")
        self.browser.click("#to-station")
        self.browser.wait("return document.querySelector('#start-review .bad') === null")
        self.assertEqual(self.browser.console(), [])

    def test_a_station_without_runs_says_what_it_has_not_and_where_its_events_are(self):
        self.open()
        self.browser.wait_for_text("#stored-nothing", "No campaign and no run is stored yet.")
        self.browser.wait_for_text("#log-empty", "since soakd started")
        self.soakd.post("unit/add", unit="SN0055", type="vn-200", user="Eva")  # as from Records
        self.browser.run("location.hash = 'help'")
        self.browser.wait_for_text("#help-page", "Guide")
        self.browser.click("#to-station")
        self.browser.wait_for_text("#stored-units", "SN0055")
        self.browser.run("document.querySelector('#log-empty a').click()")
        self.browser.wait_for_text("#audit", "unit added")

    def open_records(self):
        self.browser.go("about:blank")
        self.browser.go(self.soakd.url + "#records")
        self.browser.wait("return document.querySelectorAll('#types tbody tr').length >= 4")
        self.browser.run("document.querySelector('#reference-form').closest('details').open = true")

    def fill_gravity(self, **fields):
        self.browser.run("""document.querySelector('#reference-kind').value = 'gravity';
            document.querySelector('#reference-kind').dispatchEvent(new Event('change', { bubbles: true }));
            for (const [name, value] of Object.entries(arguments[0])) document.querySelector(`#reference-${name}`).value = value;""",
                         {"name": "g", "certificate": "G-1", "issued": "2026-01-01", "due": "2099-01-01", "uncertainty": "0.0001", "user": "Eva", **fields})
        self.browser.click("#reference-form button[type=submit]")

    def test_local_gravity_is_required_and_shown_with_the_digits_that_its_uncertainty_has(self):
        self.open_records()
        self.fill_gravity()
        self.assertEqual(self.browser.run("return document.querySelector('#reference-correction-box').innerText.trim()"), "Local gravity, m/s²")
        self.assertFalse(self.browser.run("return document.querySelector('#reference-correction').checkValidity()"))
        self.fill_gravity(correction="9.80665")
        self.browser.wait_for_text("#references", "9.80665 m/s²")
        self.browser.wait_for_text("#references", "0.00005 m/s²")  # JCGM 100:2008, 6.2.1: u = U / k
        self.fill_gravity(name="h", correction="9.80735", uncertainty="0.0002")  # two digits of u: JCGM 100:2008, 7.2.6
        self.browser.wait_for_text("#references", "9.80735 m/s²")

    def test_the_field_that_a_refusal_names_is_marked_and_has_the_focus(self):
        self.open_records()
        self.fill_gravity(correction="9.81", due="2025-01-01")
        self.browser.wait("return document.activeElement.id === 'reference-due' && document.activeElement.ariaInvalid === 'true'")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#records-view [aria-invalid]').length"), 1)
        self.browser.run("document.activeElement.dispatchEvent(new Event('input', { bubbles: true }))")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#records-view [aria-invalid]').length"), 0)
        self.browser.console()  # Chromium lists the 400

    def test_nobody_enters_a_certificate_without_a_name(self):
        self.open_records()
        self.fill_gravity(correction="9.81", user="", name="nameless")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "reference-user")
        self.assertNotIn("nameless", [one["name"] for one in self.soakd.get("references")["references"]])

    def test_a_unit_is_added_with_a_type_that_somebody_has_chosen(self):
        self.open_records()
        self.browser.type("#new-unit-serial", "SN0099")
        self.browser.run("document.querySelector('#new-unit-form').scrollIntoView({block: 'center'})")
        self.browser.click("#new-unit-form button")
        self.assertFalse(self.browser.run("return document.querySelector('#new-unit-type').checkValidity()"))
        self.browser.run("document.querySelector('#new-unit-type').value = 'vn-200'")
        self.browser.click("#new-unit-form button")
        self.browser.wait_for_text("#new-unit-done", "SN0099 is added, type vn-200.")
        self.assertEqual(self.browser.console(), [])

    def test_it_fits_narrow_screens(self):
        self.open()
        self.choose("ours.toml")
        self.browser.wait_for_text("#start-review", "of this laboratory")
        for width in (320, 390, 768, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)


if __name__ == "__main__":
    unittest.main()
