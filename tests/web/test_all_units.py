# SPDX-License-Identifier: Apache-2.0
"""All units at once from the page, before a real `soakd` ($SOAK_BIN_FOLDER): fit, verify, release, what a job that was cut short has done; and a
unit that was repaired begins its next epoch."""
import json
import unittest
import urllib.parse

import test_units
from browser import BrowserTest, long_test
from test_units import HOSTILE, OTHER, SERIAL, UnitStation
from soak_cli import check_schema  # where that lies test_units has said

tearDownModule = test_units.tearDownModule
CUT_SHORT = {"id": 1, "kind": "release_all", "unit": "", "user": "Eva", "state": "cancelled", "message": "cancelled by Bob", "started_utc_s": 1790000000.0,
             "ended_utc_s": 1790000009.0, "exit_status": 1,
             "result": {"units": [{"unit": SERIAL, "model": 1, "state": "released", "simulated": True, "expires": None, "obstacles": []},
                                  {"unit": OTHER, "model": 1, "state": "fitted", "simulated": True, "expires": None, "obstacles": ["it was never verified"]}]}}


class StationTest(BrowserTest):
    """A station of its own for each test."""

    def setUp(self):
        super().setUp()
        self.soakd = UnitStation()
        self.addCleanup(self.soakd.close)

    def open(self, place):
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#{place}")

    def click(self, button):
        self.browser.wait("const b = document.querySelector(arguments[0]); return !b.disabled && b.offsetParent !== null", button)
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", button)
        self.browser.click(button)

    def newest_job(self):
        return self.soakd.get("job", id=self.soakd.get("jobs")["jobs"][0]["id"])

    def disabled(self, button):
        return self.browser.run("return document.querySelector(arguments[0]).disabled", button)


class AllUnits(StationTest):
    def test_all_are_fitted_verified_and_released_by_clicks(self):
        self.open("units")
        self.browser.type("#user", "Eva")
        self.see("#units-to-fit", f"{2 + len(HOSTILE)} units have runs for a fit.")
        self.assertTrue(self.disabled("#units-release"))
        self.click("#units-fit")
        self.see("#units-last-text", f"2 fitted, 0 with nothing new, {len(HOSTILE)} not fitted.")
        self.see("#units-last-job", "Fit: all units, all runs for calibration")
        self.see("#units-last-rest", HOSTILE[0])
        self.assertTrue(self.browser.run("return document.querySelector('#units-last-message').hidden"), "each says its reason in the list")
        job = self.newest_job()
        check_schema(job, "http-job")
        check_schema(job["result"], "fit-brief")
        self.assertEqual((job["kind"], job["unit"], job["user"], job["state"]), ("fit_all", "", "Eva", "failed"))
        self.assertNotIn("units", self.soakd.get("jobs")["jobs"][0]["result"])
        self.see("#units-list", "fitted")
        self.soakd.post("unit/add", unit="SN-NEW", type="generic", user="Eva")
        self.click("#units-fit")
        self.see("#units-last-text", "1 has no run for a fit and was left alone.")
        self.assertNotIn("SN-NEW", self.browser.text("#units-last-rest"))
        self.see("#units-last-text", f"0 fitted, 2 with nothing new, {len(HOSTILE)} not fitted.")

        self.assertEqual(self.browser.text("#units-campaign"), "verification (2 units)")
        self.click("#units-verify")
        self.see("#units-last-text", "Judged: 2 PASS.")
        self.see("#units-last-job", "Verification: all units, their newest models, campaign verification")
        job = self.newest_job()
        check_schema(job, "http-job")
        check_schema(job["result"], "verify-all")
        listed = self.soakd.get("units")
        check_schema(listed, "http-units")
        self.assertEqual({unit["unit"]: unit["verdict"] for unit in listed["units"] if unit["model"]}, {SERIAL: "pass", OTHER: "pass"})
        unit = self.soakd.get("unit", unit=SERIAL)
        check_schema(unit, "http-unit")
        verification = unit["verification"]["job"]
        check_schema(verification, "http-job")
        self.assertEqual((verification["kind"], verification["unit"], verification["campaign"], verification["user"]), ("verify", SERIAL, "verification", "Eva"))
        check_schema({key: value for key, value in verification["result"].items()}, "verify")

        self.see("#units-verified", "2 models may be released.")
        self.click("#units-release")
        self.see("#sure-title", "Release these 2 models?")
        self.click("#sure-send")
        self.see("#units-last-text", "2 of 2 newest models were released when it had ended.")
        self.assertEqual(self.soakd.query("SELECT subject, user FROM event WHERE kind = 'model_released' ORDER BY subject"), [(SERIAL, "Eva"), (OTHER, "Eva")])
        self.see("#units-list", "released")
        self.browser.click(f"#units-list a[href='#unit={SERIAL}']")
        self.see("#unit-verdict", "PASS")
        self.see("#unit-verdict", "campaign verification, by Eva")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_who_comes_later_sees_what_runs_and_can_cancel_it(self):
        job = self.soakd.post("jobs", kind="fit_all", user="Eva")
        self.soakd.held_child()
        self.open("units")
        self.see("#units-running-text", "Fitting: all units, all runs for calibration")
        self.assertTrue(self.disabled("#units-fit"))
        self.click("#units-cancel")
        self.see("#units-last-job", "cancelled")
        self.see("#units-last-text", "What was fitted before that is stored; Fit all goes on with the others.")
        self.assertEqual(self.soakd.get("job", id=job["id"])["state"], "cancelled")
        self.browser.wait("return document.querySelector('#units-running').hidden")

    @long_test
    def test_a_release_that_was_cut_short_keeps_its_sentence(self):
        self.soakd.process.terminate()
        self.soakd.process.wait(30)
        folder = self.soakd.data / "jobs" / "1"
        folder.mkdir(parents=True)
        (folder / "job.json").write_text(json.dumps(CUT_SHORT), encoding="utf-8")
        self.soakd.start()
        for _ in range(2):  # whoever opens the page again reads it again
            self.open("units")
            self.see("#units-last-text", "Up to there 1 of the 2 models that it came to are released.")
            self.see("#units-last-job", "cancelled")
            self.see("#units-last-message", "cancelled by Bob")
            self.see("#units-last-rest", f"{OTHER}, model 1, may not be released: it was never verified")

    def test_what_cannot_be_verified_is_refused(self):
        self.assertEqual(self.soakd.refusal("jobs", kind="verify_all", campaign="no such"), (400, "campaign"))
        self.assertEqual(self.soakd.refusal("jobs", kind="verify_all"), (400, "campaign"))
        self.assertEqual(self.soakd.refusal("jobs", kind="fit_all", unit=SERIAL), (400, "unit"))

    def test_a_fit_that_was_cancelled_says_how_many_units_it_came_to(self):
        self.browser.go(self.soakd.url)
        units = [{"unit": f"SN{i}", "result": result, "model": 1, "message": None} for i, result in enumerate(("fitted", "fitted", "up_to_date"))]
        said = self.browser.run("const [job] = arguments; return import('/batch_words.mjs').then((words) => words.batchText(job))",
                                {"kind": "fit_all", "state": "cancelled", "exit_status": 1, "message": "cancelled by Eva", "result": {"units": units}})
        self.assertEqual(said, "2 fitted, 1 with nothing new, 0 not fitted. That is stored; Fit all goes on with the others.")

    @long_test
    def test_units_that_could_not_be_verified_are_listed_with_their_reason(self):
        self.browser.go(self.soakd.url)
        job = {"kind": "verify_all", "state": "failed", "exit_status": 2, "message": "1 of 2 units could not be verified:\n  SN2: no",
               "result": {"units": [{"unit": "SN1", "model": 2, "verdict": "pass"}], "not_verified": [{"unit": "SN2", "message": "no usable run"}],
                          "skipped": [{"unit": "SN3", "message": "it has no model yet"}]}}
        text, message, rest = self.browser.run("""const [job] = arguments; return import('/batch_words.mjs').then((words) =>
            [words.batchText(job), words.messageOf(job), words.restOf(job)])""", job)
        self.assertEqual(text, "Judged: 1 PASS. 1 unit could not be verified. 1 unit was left out.")
        self.assertIsNone(message)
        killed = {**job, "exit_status": 137, "message": "ended by signal 9"}
        self.assertEqual(self.browser.run("const [job] = arguments; return import('/batch_words.mjs').then((words) => words.messageOf(job))", killed), "ended by signal 9")
        self.assertEqual(rest, [{"unit": "SN2", "parts": [", not verified: ", {"english": "no usable run"}]}, {"unit": "SN3", "parts": [", left out: ", {"english": "it has no model yet"}]}])

    @long_test
    def test_of_all_the_newest_check_campaign_that_is_over_is_chosen(self):
        self.open("units")
        self.browser.wait("return document.querySelector('#units-verify').offsetParent !== null")
        chosen = self.browser.run("""return import('/batch_card.mjs').then(({ BatchCard }) => {
            const card = new BatchCard(() => "Eva", async () => {});
            const select = document.querySelector("#units-campaign");
            const said = () => [select.value, ...[...select.options].map(({ text }) => text)];
            const units = [{ to_fit: 0, model: { state: "fitted" } }];
            const offer = (...names) => card.offer({ units, check_campaigns: names.map((campaign) => ({ campaign, units: 1 })) });
            const status = { state: "running", campaign: { name: "new" }, resumable: null, resumes_by_itself: false };
            card.take(status);
            offer("new", "old");
            const during = said();
            card.take({ ...status, state: "finished" });
            const after = said();
            select.value = "old";
            select.dispatchEvent(new Event("change"));
            offer("newer", "new", "old");
            return [during, after[0], select.value];
        })""")
        self.assertEqual(chosen, [["old", "new (1 unit, still running)", "old (1 unit)"], "new", "old"])

    def test_two_widths_and_schemes_have_nothing_that_is_too_wide_or_too_faint(self):
        self.open("units")
        self.click("#units-fit")
        self.see("#units-last-text", "2 fitted")
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            for width in (390, 1280):
                self.browser.resize(width, 900)
                self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
                self.assertEqual(self.browser.poor_contrast(), [])
        self.browser.colours("light")


class Repairs(StationTest):
    def open_unit(self, serial):
        self.open(urllib.parse.urlencode({"unit": serial}))
        self.browser.wait("return document.querySelector('#unit-jobs').ariaBusy === 'false'")

    def test_a_repair_is_entered_with_reason_and_name_and_no_fit_uses_the_runs_before(self):
        self.soakd.soak("fit", "--unit", SERIAL, "--rules", "2")
        before = self.soakd.get("unit", unit=SERIAL)
        self.open_unit(SERIAL)
        self.click("#unit-repair")
        self.see("#repair-title", f"Unit {SERIAL} was repaired or changed")
        self.see("#repair-text", "No fit uses the runs so far any more")
        self.browser.click("#repair-send")
        self.assertTrue(self.browser.run("return document.querySelector('#repair-dialog').open"), "without a reason")
        self.browser.type("#repair-reason", "gyro replaced")
        self.browser.type("#repair-user", "Eva")
        self.browser.click("#repair-send")
        self.see("#unit-next", "it was repaired or changed after this model")
        after = self.soakd.get("unit", unit=SERIAL)
        self.assertEqual((after["epoch"], after["to_fit"]), (before["epoch"] + 1, 0))
        self.assertTrue(self.disabled("#unit-fit"))
        (text, user), = self.soakd.query(f"SELECT text, user FROM event WHERE kind = 'epoch_begun' AND subject = '{SERIAL}'")
        self.assertEqual((text, user), (f"epoch {after['epoch']}, by Eva: gyro replaced", "Eva"))
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_what_is_no_repair_is_refused(self):
        refused = self.soakd.refusal
        self.assertEqual(refused("unit/epoch", unit="SN9", reason="x", user="Eva"), (400, "unit"))
        self.assertEqual(refused("unit/epoch", unit=SERIAL, reason="", user="Eva"), (400, "reason"))
        self.assertEqual(refused("unit/epoch", unit=SERIAL, reason="two\nlines", user="Eva"), (400, "reason"))
        self.assertEqual(refused("unit/epoch", unit=SERIAL, reason="x"), (400, "user"))
        self.assertEqual(self.soakd.query("SELECT count(*) FROM event WHERE kind = 'epoch_begun'"), [(0,)])
        for name in HOSTILE:
            document = self.soakd.post("unit/epoch", unit=name, reason="re-flashed", user="Eva")
            check_schema(document, "http-unit-epoch")
            self.assertEqual(document["unit"], name)


if __name__ == "__main__":
    unittest.main()
