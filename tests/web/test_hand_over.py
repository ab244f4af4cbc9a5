# SPDX-License-Identifier: Apache-2.0
"""Which models the page lets out, before a real `soakd` ($SOAK_BIN_FOLDER): by the rule of `soak release` and `soak export`, in whose words it
says what is in the way."""
import hashlib
import io
import json
import subprocess
import tarfile
import unittest
import urllib.error
import urllib.parse
import urllib.request

import test_units
from browser import BrowserTest, long_test
from real_soakd import programs
from test_units import OTHER, SERIAL, UnitStation, stored_units
from soak_cli import check_schema  # where that lies test_units has said

tearDownModule = test_units.tearDownModule


class HandOver(BrowserTest):
    """A station of its own for each test: states of models do not go back. Both units are fitted, the one is verified."""

    def setUp(self):
        super().setUp()
        self.soakd = UnitStation()
        self.addCleanup(self.soakd.close)
        for serial in (SERIAL, OTHER):
            self.soakd.soak("fit", "--unit", serial, "--rules", "2")
        self.verify(SERIAL)

    def job(self, **body):
        return self.soakd.ended(self.soakd.post("jobs", user="Eva", **body))

    def verify(self, serial):
        done = self.job(kind="verify", unit=serial, campaign="verification")
        self.assertEqual(done["result"]["verdict"], "pass", done)

    def refused(self, *words):
        """What `soak` says in a terminal."""
        done = subprocess.run([programs() / "soak", *words, "--data", self.soakd.data, "--json"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        return json.loads(done.stderr)["error"]["message"]

    def open_unit(self, serial):
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#{urllib.parse.urlencode({'unit': serial})}")
        self.browser.wait("return document.querySelector('#unit-jobs').ariaBusy === 'false'")

    def test_all_that_may_be_released_are_released_at_a_click_and_the_others_say_why_not(self):
        self.browser.go(f"{self.soakd.url}#units")
        self.browser.type("#user", "Eva")
        self.see("#units-verified", "1 model may be released.")
        self.see("#units-list", "verified")
        self.browser.click("#units-release")
        self.see("#sure-title", "Release this model?")
        self.see("#sure-list", f"{SERIAL}, model 1. Nobody has searched its gap.")
        self.browser.click("#sure-cancel")
        self.browser.wait("return !document.querySelector('#sure-dialog').open")
        self.assertEqual(self.soakd.get("unit", unit=SERIAL)["model"]["state"], "verified", "nothing is released that nobody has agreed to")
        self.browser.click("#units-release")
        self.browser.click("#sure-send")
        self.see("#units-last-job", "Release: all units, their newest models")
        self.see("#units-last-text", "1 of 2 newest models was released when it had ended.")
        self.see("#units-last-rest", f"{OTHER}, model 1, may not be released: it was never verified")
        self.see("#units-verified", "0 models may be released.")
        self.assertTrue(self.browser.run("return document.querySelector('#units-release').disabled"))
        self.see("#units-list", "released")
        listed = self.soakd.get("units")
        check_schema(listed, "http-units")
        self.assertEqual({unit["unit"]: unit["model"]["state"] for unit in listed["units"] if unit["model"]}, {SERIAL: "released", OTHER: "fitted"})
        kept = self.soakd.get("jobs")["jobs"][0]
        self.assertEqual((kept["kind"], kept["unit"], kept["user"], "units" in kept["result"]), ("release_all", "", "Eva", False))
        whole = self.soakd.get("job", id=kept["id"])
        check_schema(whole, "http-job")
        check_schema(whole["result"], "release")
        self.assertEqual(self.soakd.query("SELECT subject, user FROM event WHERE kind = 'model_released'"), [(SERIAL, "Eva")])
        self.assertEqual(self.soakd.refusal("jobs", kind="release_all", unit=SERIAL), (400, "unit"))
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_what_the_rule_refuses_the_page_refuses_in_the_same_words(self):
        # A run of the same days that the model has not seen: a fit of all would take it.
        self.soakd.soak("import", stored_units() / "small.csv", "--unit", SERIAL, "--campaign", "later", "--simulated", "--gravity-mps2", "9.80665")
        unit = self.soakd.get("unit", unit=SERIAL)
        check_schema(unit, "http-unit")
        obstacle, = unit["release"]["obstacles"]
        said = self.refused("release", "--unit", SERIAL)
        self.assertEqual(said, f"model 1 may not be released: {obstacle}")
        self.assertIn("runs for calibration are not in it: r1 of campaign later", said)
        self.open_unit(SERIAL)
        self.see("#unit-next", f"It may not be released: {obstacle}.")
        self.see("#unit-release-why", obstacle)
        self.open_unit(OTHER)
        self.see("#unit-release-why", "Not to be released yet: it was never verified.")
        self.open_unit(SERIAL)
        self.assertTrue(self.browser.run("return document.querySelector('#unit-release').disabled"))
        done = self.job(kind="release", unit=SERIAL)
        self.assertEqual((done["state"], done["exit_status"], done["message"]), ("failed", 2, f"{SERIAL}: {said}"))

        # Whoever looks for a campaign to verify with sees first what was recorded for that, and what the model was fitted to.
        self.assertEqual(unit["verify_with"], [{"campaign": "verification", "runs": 1, "purpose": "verification"},
                                               {"campaign": "later", "runs": 1, "purpose": "calibration"}])
        self.assertEqual([entry["campaign"] for entry in unit["fitted_to"]], ["campaign"])
        offered = self.browser.run("return [...document.querySelectorAll('#unit-campaign option')].map((o) => [o.value, o.disabled, o.text])")
        self.assertEqual([entry[:2] for entry in offered], [["verification", False], ["later", False], ["campaign", True]])
        self.assertIn("the next fit takes it", offered[1][2])
        self.assertIn("the model was fitted to it", offered[2][2])

    @long_test
    def test_the_page_of_a_unit_heeds_a_release_of_all(self):
        self.open_unit(SERIAL)
        self.see("#unit-badges", "verified")
        self.job(kind="release_all")
        self.see("#unit-badges", "released")

    @long_test
    def test_no_two_buttons_of_a_unit_lie_over_each_other_in_german(self):
        self.job(kind="release", unit=SERIAL)
        self.soakd.soak("fit", "--unit", SERIAL, "--rules", "3")  # a choice of models comes to the others
        self.browser.go(self.soakd.url)
        self.browser.run("localStorage.setItem('soak-language', 'de')")
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-language')")
        for width in (390, 770, 850, 950, 1280):
            self.browser.resize(width, 900)
            self.open_unit(SERIAL)
            self.see("#unit-release", "Freigeben")
            self.see("#unit-version", "1, älter, freigegeben")
            over = self.browser.run("""
                const boxes = [...document.querySelectorAll("#unit-work button, #unit-work select")].map((e) => [e.id, e.getBoundingClientRect()]).filter(([, b]) => b.width > 0);
                const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
                return boxes.flatMap(([id, a], i) => boxes.slice(i + 1).filter(([, b]) => overlap(a, b)).map(([other]) => `${id} ${other}`));""")
            self.assertEqual(over, [], width)

    def test_a_withdrawn_model_is_not_exported(self):
        self.job(kind="release", unit=SERIAL)
        self.soakd.soak("model", "retire", "--unit", SERIAL, "--model", "1", "--reason", "wrong reference", "--user", "Eva")
        done = self.job(kind="export", unit=SERIAL, format="blob", simulated=True)
        self.assertEqual((done["state"], done["file"]), ("failed", None), done)
        said = self.refused("export", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", self.soakd.folder / "x.soakcal")
        self.assertEqual(done["message"], said)
        self.assertIn("is withdrawn, not released", said)
        self.assertEqual(list((self.soakd.data / "jobs" / str(done["id"])).glob("*.soakcal")), [])
        self.open_unit(SERIAL)
        self.see("#unit-next", "this model is withdrawn, nobody may use it")
        self.see("#unit-badges", "withdrawn")
        self.assertIn("primary", self.browser.run("return document.querySelector('#unit-fit').className"))
        self.see("#unit-facts", "withdrawn")
        self.assertTrue(self.browser.run("return document.querySelector('#unit-export').disabled"))

    def test_a_released_model_is_withdrawn_at_a_click_and_the_page_says_why_and_by_whom(self):
        self.job(kind="release", unit=SERIAL)
        self.open_unit(SERIAL)
        self.see("#unit-badges", "released")
        self.browser.click("#unit-withdraw")
        self.see("#withdraw-title", f"Withdraw a model of unit {SERIAL}")
        self.browser.type("#withdraw-reason", "wrong reference")
        self.browser.type("#withdraw-user", "Eva")
        self.browser.click("#withdraw-send")
        self.see("#unit-verdict-title", "WITHDRAWN")
        self.see("#unit-verdict-text", "by Eva: wrong reference. Nobody may use it")
        self.see("#unit-badges", "withdrawn")
        self.see("#unit-jobs", "PASS, void")
        self.see("#unit-jobs", "This verdict does not hold any more: the model was withdrawn since.")
        self.assertTrue(self.browser.run("return document.querySelector('#unit-withdraw').hidden"), "there is no other")
        self.assertEqual(self.soakd.query("SELECT subject, user, text FROM event WHERE kind = 'model_withdrawn'"), [(SERIAL, "Eva", "version 1: wrong reference")])
        unit = self.soakd.get("unit", unit=SERIAL)
        check_schema(unit, "http-unit")
        self.assertEqual((unit["model"]["withdrawn"]["reason"], unit["model"]["withdrawn"]["user"]), ("wrong reference", "Eva"))
        self.assertEqual({one["unit"]: one["verdict"] for one in self.soakd.get("units")["units"]}[SERIAL], None)
        again = {"unit": SERIAL, "model": 1, "reason": "again", "user": "Eva"}
        self.assertEqual(self.soakd.refusal("model/withdraw", **again), (409, "state"))
        self.assertEqual(self.soakd.refusal("model/withdraw", **{**again, "model": 7}), (400, "model"))
        self.assertEqual(self.soakd.refusal("model/withdraw", **{**again, "reason": ""}), (400, "reason"))
        self.assertEqual(self.browser.console(), [])

    def test_an_open_page_heeds_a_withdrawal_in_a_terminal(self):
        self.job(kind="release", unit=SERIAL)
        self.open_unit(SERIAL)
        self.see("#unit-badges", "released")
        self.soakd.soak("model", "retire", "--unit", SERIAL, "--model", "1", "--reason", "wrong reference", "--user", "Bob")
        self.see("#unit-verdict-title", "WITHDRAWN")
        self.see("#unit-verdict-text", "by Bob: wrong reference")
        self.see("#unit-next", "this model is withdrawn, nobody may use it")

    def runs_of(self, campaign):
        return [run for run in self.soakd.get("runs", unit=SERIAL)["runs"] if run["campaign"] == campaign]

    def test_an_open_page_heeds_that_data_were_withdrawn_in_a_terminal(self):
        """The event is about the run: neither the unit nor its model is the subject."""
        self.job(kind="release", unit=SERIAL)
        self.open_unit(SERIAL)
        self.see("#unit-verdict-title", "PASS")
        self.see("#unit-badges", "released")
        run = self.runs_of("verification")[0]
        self.soakd.soak("runs", "void", run["run_id"], "--unit", SERIAL, "--campaign", "verification", "--reason", "door was open", "--user", "Bob")
        self.see("#unit-verdict-title", "NOT JUDGED")
        self.see("#unit-jobs", "PASS, void since")

    def test_points_and_noise_are_read_anew_once_a_visit_was_withdrawn(self):
        self.open_unit(SERIAL)
        self.browser.run("document.querySelector('#unit-noise').scrollIntoView()")
        self.see("#unit-noise-said", "From the longest rest")
        self.browser.run("document.querySelector('#unit-curves').scrollIntoView()")
        asked = "return performance.getEntriesByType('resource').map(({ name }) => name).filter((name) => /unit\\/noise|model\\/rows/.test(name)).length"
        self.browser.wait(asked.replace(".length", ".length >= 2"))
        before = self.browser.run(asked)
        run = self.runs_of("verification")[0]
        self.browser.run("location.hash = '#runs'")
        self.soakd.post("run/void", run=run["run_id"], unit=SERIAL, visit=0, reason="door was open", user="Bob")
        self.browser.run("location.hash = arguments[0]", "#" + urllib.parse.urlencode({"unit": SERIAL}))
        self.browser.wait(f"document.querySelector('#unit-noise').scrollIntoView(); {asked.replace('.length', f'.length > {before}')}")
        self.browser.wait(f"document.querySelector('#unit-curves').scrollIntoView(); {asked.replace('.length', f'.length >= {before + 2}')}")

    def test_a_file_of_a_model_whose_data_were_withdrawn_is_void_also_behind_a_newer_model(self):
        self.job(kind="release", unit=SERIAL)
        self.job(kind="export", unit=SERIAL, format="blob", simulated=True)
        calibration = self.soakd.get("unit", unit=SERIAL)["fitted_to"][0]["campaign"]
        run = self.runs_of(calibration)[0]
        self.soakd.post("run/void", run=run["run_id"], unit=SERIAL, visit=0, reason="door was open", user="Bob")
        self.soakd.soak("fit", "--unit", SERIAL, "--rules", "2")
        unit = self.soakd.get("unit", unit=SERIAL)
        check_schema(unit, "http-unit")
        newest, released = unit["versions"]
        self.assertEqual((newest["version"], newest["state"], newest["void"]), (2, "fitted", None))
        self.assertEqual((released["version"], released["state"], unit["released_before"]), (1, "released", []))
        self.assertIn("withdrawn", released["void"])
        self.assertEqual(sum(campaign["runs"] for campaign in unit["fit_campaigns"]), unit["to_fit"])
        self.open_unit(SERIAL)
        self.see("#unit-jobs", "Made from model 1. Data that this rests on were withdrawn since: void, do not use it.")
        self.browser.click("#unit-withdraw")
        self.see("#withdraw-version", "1, older, released")

    def test_what_is_released_is_handed_over_in_one_archive_with_its_manifest(self):
        self.job(kind="release", unit=SERIAL)
        self.assertEqual(self.soakd.refusal("jobs", kind="export_all", format="blob"), (400, "sign"), "there is no key")
        key = self.soakd.post("key/new", comment="Laboratory 1", user="Eva")["key"]
        self.assertEqual(self.soakd.refusal("jobs", kind="export_all", format="kalibr"), (400, "format"))
        self.browser.go(f"{self.soakd.url}#units")
        self.browser.wait("const b = document.querySelector('#units-export'); return !b.disabled && b.offsetParent !== null")
        self.browser.click("#units-simulated")
        self.browser.click("#units-export")
        self.see("#units-last-job", "Hand-over: all units, their released models, as Calibration file (.soakcal)")
        self.see("#units-last-job", "Download hand-over.tar")
        self.see("#units-last-text", "1 file and its signed manifest are in the archive.")
        self.see("#units-last-rest", f"{OTHER}, left out: no model of it is released; the newest is fitted")
        job = self.soakd.get("job", id=self.soakd.get("jobs")["jobs"][0]["id"])
        check_schema(job, "http-job")
        self.assertEqual(job["result"]["key_id"], key["key_id"])
        with urllib.request.urlopen(f"{self.soakd.url}api/v1/job/file?id={job['id']}") as answer, tarfile.open(fileobj=io.BytesIO(answer.read())) as archive:
            files = {member.name: archive.extractfile(member).read() for member in archive.getmembers()}
        self.assertEqual(sorted(files), [f"hand-over/{SERIAL}.soakcal", "hand-over/manifest.json", "hand-over/manifest.json.sig"])
        manifest = json.loads(files["hand-over/manifest.json"])
        check_schema(manifest, "manifest")
        unit, = manifest["units"]
        self.assertEqual(unit["sha256"], hashlib.sha256(files[f"hand-over/{SERIAL}.soakcal"]).hexdigest())
        self.assertEqual(self.browser.console(), [])

    def test_retiring_a_reference_says_whose_release_rests_on_it(self):
        self.soakd.soak("reference", "add", "--kind", "level", "--name", "Niveau 7", "--certificate", "N-7", "--issued", "2020-01-01", "--due", "2097-03-01", "--uncertainty", "0.0002")
        self.soakd.soak("import", stored_units() / "lab" / "verification" / f"{SERIAL}.csv", "--unit", SERIAL, "--campaign", "checked", "--procedure", "verification", "--simulated",
                        "--references", "--gravity-mps2", "9.80665")
        self.assertEqual(self.job(kind="verify", unit=SERIAL, campaign="checked")["result"]["verdict"], "pass")
        [entry] = self.soakd.get("references")["references"]
        question = {"record_id": entry["record_id"]}
        self.assertEqual(self.soakd.get("references/released", **question), {"released": []}, "it is not released")
        self.job(kind="release", unit=SERIAL)
        found = self.soakd.get("references/released", **question)
        check_schema(found, "http-references-released")
        self.assertEqual(found, {"released": [{"unit": SERIAL, "model": 1}]})
        self.browser.go(f"{self.soakd.url}#records")
        self.see("#references", "Niveau 7")
        self.browser.run("document.querySelector(\"#references [aria-label='Retire Niveau 7']\").click()")
        self.see("#retire-lost", "1 released unit rests on it and becomes “do not hand over”")
        self.see("#retire-units", f"{SERIAL}, model 1")
        self.browser.type("#retire-reason", "sold")
        self.browser.type("#retire-user", "Eva")
        self.browser.click("#retire-send")
        self.see("#references", "retired")
        self.open_unit(SERIAL)
        self.see("#unit-badges", "released, do not hand over")
        self.assertEqual(self.soakd.get("references/released", **question), {"released": []}, "nothing more is to be lost")
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#events")
        self.see("#audit", "Niveau 7, certificate N-7")  # and not the number of its entry
        for about in ("Niveau 7", "N-7", "Niveau 7, certificate N-7"):
            self.browser.run("document.querySelector('#audit-subject').value = arguments[0]", about)
            self.browser.click("#audit-send")
            self.browser.wait("return document.querySelectorAll('#audit tbody tr').length === 2")
        self.assertEqual(self.browser.console(), [])

    def test_a_model_that_failed_after_its_release_is_released_again_by_somebody(self):
        self.job(kind="release", unit=SERIAL)
        self.soakd.limits('name = "generic"\n[limits]\ngyro = 0.0001\naccel = 0.0001\n')
        self.assertEqual(self.job(kind="verify", unit=SERIAL, campaign="verification")["result"]["verdict"], "fail")
        self.soakd.limits('name = "generic"\n[limits]\ngyro = 50.0\naccel = 50.0\n')
        self.verify(SERIAL)
        self.open_unit(SERIAL)
        self.see("#unit-verdict", "PASS")
        self.see("#unit-badges", "released, do not hand over")
        self.see("#unit-next", "Release it again: it failed a verification after its release, and the last one says PASS.")
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#units")
        self.see("#units-verified", "1 model may be released.")
        self.browser.click("#units-release")
        self.see("#sure-list", f"{SERIAL}, model 1, again: it failed a verification after its release")
        self.browser.click("#sure-cancel")
        self.open_unit(SERIAL)
        self.browser.click("#unit-release")
        self.see("#unit-next", "Export it.")
        self.browser.wait("return document.querySelector('#unit-badges').textContent.includes('released') && !document.querySelector('#unit-badges').textContent.includes('do not')")
        self.assertEqual(len([row for row in self.soakd.soak_json("model", "show", "--unit", SERIAL)["history"] if row["state"] == "released"]), 2)

    def unit_file(self, **parameters):
        """Status, name and content, or where it is refused and why."""
        try:
            with urllib.request.urlopen(f"{self.soakd.url}api/v1/unit/file?{urllib.parse.urlencode(parameters)}") as answer:
                return answer.status, answer.headers["Content-Disposition"], answer.read()
        except urllib.error.HTTPError as refusal:
            with refusal:
                error = json.load(refusal)["error"]
            return refusal.code, error["where"], error["message"]

    def test_the_file_of_a_released_model_is_had_by_serial_number(self):
        status, where, why = self.unit_file(unit=SERIAL, format="json", simulated="true")
        self.assertEqual((status, where), (409, "state"))
        self.assertIn("no model of unit", why)
        self.job(kind="release", unit=SERIAL)
        status, where, why = self.unit_file(unit=SERIAL, format="json")
        self.assertEqual((status, where), (409, "state"))
        self.assertIn("SIMULATED", why)
        for _ in range(2):
            status, name, content = self.unit_file(unit=SERIAL, format="json", simulated="true")
            self.assertEqual((status, name), (200, f'attachment; filename="{SERIAL}.json"'))
            self.assertEqual(json.loads(content)["unit"], SERIAL)
        self.assertEqual(self.soakd.query("SELECT count(*) FROM event WHERE kind = 'calibration_exported'"), [(1,)])
        for format in ("blob", "c", "px4", "ardupilot"):
            self.assertEqual(self.unit_file(unit=SERIAL, format=format, simulated="true")[0], 200, format)
        for wrong, where in (({"unit": "nobody", "format": "json"}, "unit"), ({"unit": SERIAL, "format": "kalibr"}, "format"), ({"unit": SERIAL}, "format"),
                             ({"unit": SERIAL, "format": "json", "simulated": "yes"}, "simulated")):
            self.assertEqual(self.unit_file(**wrong)[:2], (400, where), wrong)
        self.soakd.soak("model", "retire", "--unit", SERIAL, "--model", "1", "--reason", "wrong reference", "--user", "Eva")
        self.assertEqual(self.unit_file(unit=SERIAL, format="json", simulated="true")[:2], (409, "state"))

    def test_no_older_file_is_given_in_place_of_the_newest_released_one(self):
        """As `soak export --all --released` leaves the unit out: whoever asks would not see that it is another model."""
        self.job(kind="release", unit=SERIAL)
        self.soakd.soak("fit", "--unit", SERIAL, "--rules", "3")
        self.verify(SERIAL)
        self.job(kind="release", unit=SERIAL)
        self.assertEqual(self.unit_file(unit=SERIAL, format="json", simulated="true")[0], 200)
        # A failed verification of the newest one alone.
        self.soakd.limits('name = "generic"\n[limits]\ngyro = 1e-9\naccel = 1e-9\n')
        self.assertEqual(self.job(kind="verify", unit=SERIAL, campaign="verification")["result"]["verdict"], "fail")
        self.assertEqual(self.soakd.get("unit", unit=SERIAL)["released_before"], [1])
        status, where, why = self.unit_file(unit=SERIAL, format="json", simulated="true")
        self.assertEqual((status, where), (409, "state"))
        self.assertIn(f"model 2 of unit {SERIAL} is released, but must not be handed over", why)

    @long_test
    def test_a_released_model_before_the_newest_is_exported_where_it_is_chosen(self):
        self.job(kind="release", unit=SERIAL)
        self.open_unit(SERIAL)
        self.see("#unit-badges", "released")
        self.assertTrue(self.browser.run("return document.querySelector('#unit-version-box').hidden"))
        self.soakd.soak("fit", "--unit", SERIAL, "--rules", "3")
        self.assertEqual(self.soakd.get("unit", unit=SERIAL)["released_before"], [1])
        self.open_unit(SERIAL)
        self.see("#unit-badges", "fitted")
        self.browser.run("const choice = document.querySelector('#unit-version'); choice.value = '1'; choice.dispatchEvent(new Event('change'));")
        self.browser.click("#unit-simulated")
        self.browser.click("#unit-export")
        self.see("#unit-jobs li", "Made from model 1; the newest is 2.")
        self.assertEqual(self.browser.text("#unit-jobs li a"), f"Download {SERIAL}.soakcal")
        self.browser.run("const choice = document.querySelector('#unit-version'); choice.value = ''; choice.dispatchEvent(new Event('change'));")
        self.browser.click("#unit-simulated")  # the tick was about model 1
        self.browser.click("#unit-export")
        self.see("#sure-title", "Export model 2, which is not released?")
        self.browser.click("#sure-send")
        self.see("#unit-jobs li", f"{SERIAL}.unreleased.soakcal")
        made = [job["result"] for job in self.soakd.get("jobs")["jobs"] if job["kind"] == "export"]
        self.assertEqual([(result["model"], result["unreleased"]) for result in made], [(2, True), (1, False)])
        for wrong in ({"kind": "export", "format": "blob", "model": 3}, {"kind": "export", "format": "kalibr", "model": 1}, {"kind": "fit", "model": 1}):
            self.assertEqual(self.soakd.refusal("jobs", unit=SERIAL, **wrong), (400, "model"), wrong)
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_the_tick_of_simulated_data_is_about_the_model_that_is_chosen(self):
        """A unit whose first model is of simulated and measured runs and released, and the second of measured ones alone."""
        lab = stored_units() / "lab"
        gravity = ("--gravity-mps2", "9.80665")
        self.soakd.soak("import", lab / "campaign" / f"{SERIAL}.csv", "--unit", "MIXED", "--campaign", "measured", *gravity)
        self.soakd.soak("import", lab / "campaign" / f"{OTHER}.csv", "--unit", "MIXED", "--campaign", "made up", "--simulated", *gravity)
        self.soakd.soak("import", lab / "verification" / f"{SERIAL}.csv", "--unit", "MIXED", "--campaign", "verification", "--procedure", "verification", *gravity)
        self.soakd.limits('name = "generic"\n[limits]\ngyro = 50.0\naccel = 50.0\n')
        self.soakd.soak("fit", "--unit", "MIXED", "--rules", "2")
        self.verify("MIXED")
        self.job(kind="release", unit="MIXED")
        self.soakd.soak("fit", "--unit", "MIXED", "--rules", "2", "--campaign", "measured")
        unit = self.soakd.get("unit", unit="MIXED")
        check_schema(unit, "http-unit")
        self.assertEqual((unit["model"]["version"], unit["model"]["simulated"], unit["released_before"], unit["simulated_before"]), (2, False, [1], [1]))
        self.open_unit("MIXED")
        self.see("#unit-version", "1, older, released")
        self.assertTrue(self.browser.run("return document.querySelector('#unit-simulated-box').hidden"))
        choose = "const choice = document.querySelector('#unit-version'); choice.value = arguments[0]; choice.dispatchEvent(new Event('change'));"
        self.browser.run(choose, "1")
        self.see("#unit-simulated-box", "Although model 1 is of SIMULATED data")
        self.browser.click("#unit-export")
        self.see("#job-failure", "model 1 is of SIMULATED data")
        self.browser.click("#unit-simulated")
        self.browser.run(choose, "")
        self.browser.run(choose, "1")
        self.assertFalse(self.browser.run("return document.querySelector('#unit-simulated').checked"))
        self.browser.click("#unit-simulated")
        self.browser.click("#unit-export")
        self.see("#unit-jobs li", "Export: unit MIXED, model 1, as Calibration file (.soakcal)")
        self.see("#unit-jobs li", "Made from model 1; the newest is 2.")

    @long_test
    def test_what_drives_lose_is_said_of_the_model_that_they_were_simulated_with(self):
        self.open_unit(SERIAL)
        self.see("#unit-impact", "What the calibration of model 1 buys in navigation")
        self.see("#unit-drives", "Model 1: With a navigation filter")
        first = self.soakd.get("impact", unit=SERIAL)
        self.soakd.soak("fit", "--unit", SERIAL, "--rules", "3")
        self.assertEqual(self.soakd.get("impact", unit=SERIAL, version=1), first)
        self.assertEqual(self.soakd.get("impact", unit=SERIAL)["model"], 2)
        for wrong in (0, 3, "x"):
            with self.assertRaises(urllib.error.HTTPError) as refused:
                self.soakd.get("impact", unit=SERIAL, version=wrong)
            self.assertEqual((refused.exception.code, json.load(refused.exception)["error"]["where"]), (400, "version"))
        # Whoever has the page of model 1 before them is told of model 1.
        told = self.browser.run("""const [unit, model] = arguments; const card = document.createElement('section'); document.body.append(card);
            return import('/impact_card.mjs').then(({ renderImpact }) => renderImpact(card, model, unit)).then(() => new Promise((done) => {
              const look = () => (card.innerText.includes('outages of') ? done(card.innerText) : setTimeout(look, 50)); look(); }));""",
                                SERIAL, self.soakd.get("model", unit=SERIAL, version=1)["model"])
        self.assertIn("Model 1: With a navigation filter", told)

    @long_test
    def test_a_released_model_that_breaks_the_rule_now_is_not_to_be_handed_over(self):
        self.job(kind="release", unit=SERIAL)
        self.soakd.soak("import", stored_units() / "small.csv", "--unit", SERIAL, "--campaign", "later", "--simulated", "--gravity-mps2", "9.80665")
        self.open_unit(SERIAL)
        self.see("#unit-next", "Do not hand it over. Fit it again, then verify and release it: runs for calibration are not in it: r1")
        self.see("#unit-facts", "yes, against the rule of release: do not hand it over")
        done = self.job(kind="export", unit=SERIAL, format="blob", simulated=True)
        self.assertEqual((done["state"], done["file"]), ("failed", None), done)


if __name__ == "__main__":
    unittest.main()
