# SPDX-License-Identifier: Apache-2.0
"""What a unit's page says of documents that are made up here: jobs, campaigns to verify with, warnings, what to do next. The modules are those that a real
`soakd` ($SOAK_BIN_FOLDER) without units serves."""
import unittest

from browser import BrowserTest
from real_soakd import Soakd


class EmptyStation(Soakd):
    def store_all(self):
        self.data.mkdir()


class Words(BrowserTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.soakd = EmptyStation()
        cls.addClassCleanup(cls.soakd.close)

    def test_a_job_says_what_it_works_on(self):
        self.browser.go(self.soakd.url)
        job = {"id": 1, "unit": "SN1", "model": 2, "campaign": None, "format": None, "effects": None, "sign": None, "user": "Eva", "state": "done", "progress": None,
               "started_utc_s": 1000.0, "result": {"model": 2}, "message": None}

        def said(running=False, **more):
            return self.browser.run("""const [job, running] = arguments;
                return import('/text.mjs').then(({ textsOf }) => Promise.all([textsOf('units'), textsOf('gap')])).then(() => import('/job_words.mjs'))
                  .then((words) => (running ? words.runningText(job, 1012) : words.endedText(job).title));""", {**job, **more}, running)
        self.assertEqual(said(kind="fit", model=None, result={"model": 3}), "Fit: unit SN1, all runs for calibration; made model 3")
        self.assertEqual(said(kind="verify", campaign="check-1"), "Verification: unit SN1, model 2, campaign check-1")
        self.assertEqual(said(kind="report"), "Report: unit SN1, model 2")
        self.assertEqual(said(kind="release", state="failed", result=None), "Release: unit SN1, model 2")
        self.assertEqual(said(kind="export", format="px4", sign=False), "Export: unit SN1, model 2, as PX4 parameters")
        self.assertEqual(said(kind="export", format="kalibr", sign=False, model=None, result={"model": None}), "Export: unit SN1, as Kalibr noise values")
        self.assertEqual(said(kind="gap_accept", effects=["sensor_lag"], result={"model": 3}), "Accepted: unit SN1, model 2, sensor lag; made model 3")
        self.assertEqual(said(kind="gap_find"), "Gap search: unit SN1, model 2")
        self.assertEqual(said(kind="verify", campaign="c", model=None), "Verification: unit SN1, model 2, campaign c", "kept before jobs said it")
        self.assertEqual(said(kind="verify_all", unit="", model=None, campaign="c", result={}), "Verification: all units, their newest models, campaign c")
        self.assertEqual(said(True, kind="export", format="px4", sign=False, result=None), "Exporting: unit SN1, model 2; for 12 s now, started by Eva.")
        self.assertEqual(said(True, kind="fit_all", unit="", model=None, result=None, progress=0.4), "Fitting: all units, all runs for calibration; for 12 s now, started by Eva. 40 %.")

    def test_what_a_verification_takes_is_a_check_campaign_that_is_over_before_one_that_is_open(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "type": "mti-300", "epoch": 1, "to_fit": 0, "exported": None, "warnings": [], "model": {"version": 1, "epoch": 1, "state": "fitted", "terms": []}, "gap": {"find": None, "show": None},
                "verification": None}

        def campaign(name, purpose="verification"):
            return {"campaign": name, "runs": 1, "purpose": purpose}

        def told(*campaigns, stopped=False, of=3, checks=()):
            return self.browser.run("""const [unit, open] = arguments; return import('/unit_words.mjs').then((words) =>
                ({ ...words.nextOf(unit, open), chosen: words.campaignToVerifyWith(unit.verify_with, open)?.campaign }))""",
                                    {**unit, "verify_with": campaigns}, {"name": "open", "of": of, "stopped": stopped, "checks": checks})
        waits = told(campaign("open"))
        self.assertEqual((waits["kind"], waits["text"].split(".")[0]), (None, "Wait: campaign open still runs, 1 of 3 check runs recorded"))
        waits = told(campaign("open"), campaign("cold", "calibration"))
        self.assertEqual((waits["kind"], waits["chosen"]), (None, "open"))
        over = told(campaign("open"), campaign("old"))
        self.assertEqual((over["kind"], over["chosen"]), ("verify", "old"))
        self.assertEqual(told(campaign("open", "calibration"))["kind"], "verify", "its runs are no check runs")
        self.assertEqual(told(campaign("open", "calibration"), campaign("cold", "calibration"))["chosen"], "cold")
        stopped = told(campaign("open"), stopped=True)
        self.assertIn("Campaign open has stopped, 1 of 3 check runs recorded: resume it on Station.", stopped["text"])
        self.assertEqual(stopped["link"]["address"], "#station")
        # Nothing of it is stored yet, and the unit is in it: nobody shall record another one.
        begun = told(checks=["SN0", "SN1"])
        self.assertEqual((begun["kind"], begun["text"]), (None, "Wait: campaign open still runs, 0 of 3 check runs recorded. Then verify."))
        self.assertEqual(told(campaign("cold", "calibration"), checks=["SN1"])["text"], begun["text"])
        self.assertIn("Record a run that the fit has not seen", told(checks=["SN0"])["text"])
        self.assertEqual(told(campaign("old"), checks=["SN1"])["kind"], "verify")

    def test_a_campaign_that_has_stopped_or_calibrates_says_so_where_one_is_chosen(self):
        self.browser.go(self.soakd.url)
        said = self.browser.run("""return import('/unit_words.mjs').then(({ U }) => [U.jobs.campaignOpen("c", 1, { of: 3, stopped: true }, "verification"),
            U.jobs.campaignOpen("c", 1, { of: null, stopped: false }, "calibration"), U.batch.campaignUnits("c", 2, { stopped: false })])""")
        self.assertEqual(said, ["c (stopped: 1 of 3 runs recorded)", "c (still running: 1 run recorded, calibration: the next fit takes it)", "c (2 units, still running)"])
        opened = self.browser.run("""return import('/words.mjs').then(({ openCampaign }) => [
            openCampaign({ state: "running", campaign: { name: "c" }, resumable: null, resumes_by_itself: false }),
            openCampaign({ state: "interrupted", campaign: null, resumable: "c", resumes_by_itself: false }),
            openCampaign({ state: "interrupted", campaign: null, resumable: "c", resumes_by_itself: true }),
            openCampaign({ state: "finished", campaign: { name: "c" }, resumable: null, resumes_by_itself: false }),
            openCampaign({ state: "running", campaign: { name: "c", purpose: "verification" }, units: [{ serial: "SN1" }], resumable: null, resumes_by_itself: false })])""")
        self.assertEqual(opened, [{"name": "c", "stopped": False, "checks": []}, {"name": "c", "stopped": True, "checks": []}, {"name": "c", "stopped": False, "checks": []}, None,
                                  {"name": "c", "stopped": False, "checks": ["SN1"]}])

    def test_the_same_warning_of_several_sensors_is_one_line(self):
        warnings = [{"code": code, "text": f"{sensor}{text}", "remedy": None, "sensors": [sensor], "urgency": "act"}
                    for code, text in (("few", ": too few"), ("few", " scale: too few"), ("other", ": of a kind of its own")) for sensor in ("gyro_x", "gyro_y", "accel_z") if code == "few" or sensor == "gyro_y"]
        self.browser.go(self.soakd.url)
        told = self.browser.run("const [warnings] = arguments; return import('/unit_words.mjs').then((words) => words.sortedWarnings({ warnings, verification: null }))", warnings)
        self.assertEqual([(one["code"], one["text"], one["sensors"]) for one in told["act"]],
                         [("few", "too few", ["gyro_x", "gyro_y", "accel_z"]), ("few", "scale: too few", ["gyro_x", "gyro_y", "accel_z"]), ("other", "gyro_y: of a kind of its own", ["gyro_y"])])

    def test_what_is_to_be_done_leads_to_where_it_is_done(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "type": "mti-300", "epoch": 1, "to_fit": 0, "exported": None, "warnings": [], "model": {"version": 1, "epoch": 1, "state": "fitted"}}
        judged = {"stale": None, "job": {"result": {"verdict": "info"}}, "warnings": []}
        for verification, text, address in ((None, "verification procedure", "#station"), (judged, "limits of the type mti-300", "#help=guide&at=change-a-limit")):
            told = self.browser.run("const [unit] = arguments; return import('/unit_words.mjs').then((words) => words.nextOf(unit))",
                                    {**unit, "verify_with": [], "verification": verification})
            self.assertIn(text, told["text"])
            self.assertEqual(told["link"]["address"], address)

    def test_a_unit_that_was_repaired_is_fitted_once_runs_of_it_are_there(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "type": "mti-300", "epoch": 1, "exported": None, "warnings": [], "model": {"version": 1, "epoch": 0, "state": "released"}, "verification": None, "verify_with": []}
        for to_fit, kind in ((0, None), (2, "fit")):
            told = self.browser.run("const [unit] = arguments; return import('/unit_words.mjs').then((words) => words.nextOf(unit))", {**unit, "to_fit": to_fit})
            self.assertEqual(told["kind"], kind)

    def test_a_verdict_is_told_with_its_numbers_the_nearest_to_its_limit_first(self):
        self.browser.go(self.soakd.url)
        def sensor(worst, limit, **scale):
            return {"bias_verdict": "pass", "verdict": "pass", "worst_abs": worst, "guard": 0.005, "limit": limit, "worst_temp_c": -3.97, **scale}
        scale = {"verdict": "marginal", "worst_abs": 480.0, "guard": 60.0, "limit": 500.0, "worst_temp_c": 56.0}
        sensors = {"accel_x": sensor(0.0183, 0.03, scale=scale), "gyro_x": sensor(0.01, 0.5, scale=None), "gyro_y": sensor(0.01, None)}
        unit = {"unit": "SN1", "type": "t", "model": {"version": 1, "sensors": {"accel_x": {"unit": "m/s2"}, "gyro_x": {"unit": "deg/s"}, "gyro_y": {"unit": "deg/s"}}},
                "verification": {"stale": None, "job": {"campaign": "check", "user": "Eva", "result": {"verdict": "pass", "limits": "unit type t", "model": 1, "sensors": sensors}}}}
        curves, told, rows = self.browser.run("""const [unit] = arguments; return Promise.all([import('/unit_words.mjs'), import('/unit_judged.mjs')]).then(([words, { renderJudged }]) => {
            const box = document.createElement('details');
            renderJudged(box, unit);
            return [words.judgedCurves(unit.verification.job.result, unit.model).map(({ name, isScale }) => [name, isScale]), words.verdictText(unit)[0],
              [...box.querySelectorAll('tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))]; });""", unit)
        self.assertEqual(curves, [["accel_x", True], ["accel_x", False], ["gyro_x", False]])
        self.assertTrue(told.endswith("Nearest to its limit: accel x, scale, 480 ± 60 ppm at 56 °C, limit 500 ppm."), told)
        self.assertEqual(rows[1], ["accel x", "0.018", "±0.0050", "0.030", "m/s²", "−4", "PASS"])

    def test_what_accepted_effects_close_is_held_against_what_was_expected(self):
        self.browser.go(self.soakd.url)
        def part(closed, after=0.004):
            return {"fresh": {"before_rms": 0.03, "after_rms": after, "floor_rms": 0.004, "closed_fraction": closed}, "fitted": None}
        terms = [{"parts": [{"sensors": ["gyro_x"]}], "gap": {"gyro_x": {"closed_ci95": [0.93, 1.05]}}}]
        def said(closed, accel_after):
            return self.browser.run("const [result] = arguments; return import('/gap_words.mjs').then((words) => words.shownText(result))",
                                    {"before": 1, "model": 2, "terms": terms, "runs": [{"use": "fresh"}], "sensors": {"gyro_x": part(closed), "accel_x": part(0.0, accel_after)}})
        self.assertIn("As much is closed as was expected.", said(0.95, 0.03))
        less = said(0.36, 0.004)
        self.assertIn("In gyro x less is closed than was expected", less)
        self.assertIn("search again", less)
        self.assertIn("accel x, on which the effects do not act, are far above the floor", said(0.36, 0.014))

    def test_nothing_is_to_be_done_only_when_no_gap_is_open(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "type": "mti-300", "epoch": 1, "to_fit": 1, "warnings": [], "verify_with": [],
                "verification": {"stale": None, "job": {"result": {"verdict": "pass"}}, "warnings": []},
                "release": {"obstacles": [], "expires": None}, "exported": {"result": {"unreleased": False}}}
        def said(verdict, effects=(), terms=(), stale=None, state="released"):
            find = verdict and {"stale": stale, "job": {"result": {"verdict": verdict, "effects": [{"name": name} for name in effects]}}}
            model = {"version": 2, "epoch": 1, "state": state, "terms": [{"name": name} for name in terms]}
            return self.browser.run("const [unit] = arguments; return import('/unit_words.mjs').then((words) => words.nextOf(unit))",
                                    {**unit, "model": model, "gap": {"find": find, "show": None}})["text"]
        for left in (said(None), said("none"), said("named", ("sensor_lag",), ("sensor_lag",)), said("unknown", stale="runs were added since")):
            self.assertIn("Nothing:", left)
        for left in (said("named", ("sensor_lag",)), said("named", ("sensor_lag", "cross_axis"), ("sensor_lag",)), said("unknown"),
                     said("named", ("sensor_lag",), stale="the unit was fitted again since")):
            self.assertIn("see Gap below", left)
        self.assertEqual(said("named", ("sensor_lag",), ("sensor_lag",), state="verified"), "Release it.")
        self.assertIn("look at Gap below before", said("named", ("sensor_lag",), state="verified"))


if __name__ == "__main__":
    unittest.main()
