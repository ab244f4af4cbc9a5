# SPDX-License-Identifier: Apache-2.0
"""What a unit's page says of documents that are made up here: jobs, campaigns to verify with, warnings, what to do next. The modules are those that a real
`soakd` ($SOAK_BIN_FOLDER) without units serves."""
import re
import unittest

from browser import BrowserTest
from real_soakd import ROOT, Soakd
from test_language import ENGLISH


# What stands in the braces of the station's sentences, in turn.
FILLED_IN = {
    "it was never verified: 'soak verify --unit {} --campaign NAME'": ("SN1",),
    "its last verification, against campaign '{}', says {}, not pass: {}": ("week-1", "marginal", "fit again, or verify it against other fresh runs"),
    "{} of the runs that it was fitted to are withdrawn or not in this data folder: fit again": ("2",),
    "runs for calibration are not in it: {}: fit again with all of them": ("R01 of campaign week-1, R02 of campaign week-1",),
    "it was measured, and runs of campaign '{}' are SIMULATED: verify it against measured runs": ("week-1",),
    "runs of campaign '{}' were withdrawn after it was verified against them: verify it again": ("week-1",),
    "{} was due on {}: record with a newer certificate and fit again": ("chamber_probe 'PT-7' (certificate K-12)", "2026-11-26"),
    "it is withdrawn: fit again": (),
    "a verification on {}, after its release, said {}: release it again ('soak release --unit {}')": ("2026-11-26", "fail", "SN1"),
    "it belongs to epoch {}, the unit is in epoch {}: fit again": ("1", "2"),
}
# Warnings that become one, with the sentences that stand in their braces.
WARNINGS = {
    "withdrawn, whole or in part, after the model was fitted to it: {}": [("R01, R02",)],
    "the entry of {} was withdrawn {}; {}": [("rate 'table' (certificate K-3)", "on 2026-11-26 by Eva: Komma", end) for end in (
        "its values still apply here; the corrected entry applies from the next fit on", "no entry corrects it, and its values still apply here")],
    "{}, which was used for this measurement, was retired {}": [("level 'O' (certificate 7)", "on 2026-11-26 by Eva: Sturz")],
    "{}, which was used for this measurement, expired on {} and has no newer certificate: nothing confirms that it was still correct": [("gravity 'g' (certificate P 1)", "2026-11-26")],
}


def source_of(path):
    """Of the station, with each sentence in one piece."""
    return re.sub(r'"\s*"', "", (ROOT / "station" / path).read_text(encoding="utf-8"))


def obstacles_of_the_rule():
    """An example of each sentence that the rule of release says. Fails where it says others than those above."""
    rule = source_of("release/release_rule.cpp")
    # Beside those above two of warnings; whether it passed is told in two sentences at one place.
    assert len(re.findall(r"obstacles\.(?:push|emplace)_back\(", rule)) == len(FILLED_IN) - 1 + 2
    assert all(f'"{sentence}"' in rule for sentence in FILLED_IN)
    others = source_of("report/runs_of_model.cpp") + source_of("fit/reference_rule.cpp")
    assert all(f'"{sentence}"' in others for sentence in WARNINGS)
    remedies = re.findall(r'warning\.text \+ ": ([^"]+)"', rule)
    assert len(remedies) == 2
    texts = [sentence.format(*words) for sentence, words in FILLED_IN.items()]
    warnings = [sentence.format(*words) for sentence, examples in WARNINGS.items() for words in examples]
    return texts + [f"{warning}: {remedy}" for remedy in remedies for warning in warnings if remedy == "fit again" or not warning.startswith("withdrawn,")]


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
        fitting = "Fitting: unit SN1, all runs for calibration; for 12 s now, started by Eva."
        self.assertEqual(said(True, kind="fit", model=None, result=None, doing="reading"), f"{fitting} Reading the recordings.")
        self.assertEqual(said(True, kind="fit", model=None, result=None, doing="fitting", progress=0.5), f"{fitting} Fitting the sensors. 50 %.")
        self.assertEqual(said(True, kind="fit", model=None, result=None, doing="no words for it"), fitting)
        self.assertEqual(said(True, kind="fit_all", unit="", model=None, result=None, doing="fitting", progress=0.4), "Fitting: all units, all runs for calibration; for 12 s now, started by Eva. 40 %.")

    def test_a_bar_shows_the_share_of_a_job_and_none_where_nobody_knows_it(self):
        self.browser.go(self.soakd.url)
        shown = self.browser.run("""const bar = document.createElement('progress');
            return import('/text.mjs').then(({ textsOf }) => Promise.all([textsOf('units'), textsOf('gap')])).then(() => import('/job_words.mjs'))
              .then(({ showShare }) => [0.4, null, undefined, 1].map((progress) => { showShare(bar, { progress }); return bar.position; }));""")
        self.assertEqual(shown, [0.4, -1, -1, 1])

    def test_every_step_that_a_command_tells_has_words_in_both_languages(self):
        told = {name for path in ("commands/fit_command.cpp", "commands/gap_commands.cpp", "commands/verify_command.cpp", "commands/report_command.cpp", "commands/export_command.cpp", "gap/gap_search.cpp")
                for name in re.findall(r'(?:begin|progress)\("(\w+)"\)', source_of(path))}
        self.assertGreater(len(told), 5)
        for language in ("en", "de"):
            steps = re.search(r"steps: \{(.*?)\n    \}", (ROOT / "web" / f"text_units_{language}.mjs").read_text(encoding="utf-8"), re.S).group(1)
            self.assertLessEqual(told, set(re.findall(r"(\w+): \"", steps)), language)

    def test_what_a_verification_takes_is_a_check_campaign_that_is_over_before_one_that_is_open(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "type": "mti-300", "epoch": 1, "to_fit": 0, "exported": None, "warnings": [], "model": {"version": 1, "epoch": 1, "state": "fitted", "terms": []}, "gap": {"find": None, "show": None},
                "verification": None}

        def campaign(name, purpose="verification"):
            return {"campaign": name, "runs": 1, "purpose": purpose}

        def told(*campaigns, stopped=False, of=3, checks=()):
            return self.browser.run("""const [unit, open] = arguments; return import('/unit_words.mjs').then((words) =>
                ({ ...words.nextOf(unit, open), chosen: words.campaignToVerifyWith(unit.verify_with, open)?.campaign }))""",
                                    {**unit, "verify_with": campaigns}, {"name": "open", "of": of, "stopped": stopped, "checks": checks, "records": []})
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
        self.assertEqual(opened, [{"name": "c", "stopped": False, "checks": [], "records": []}, {"name": "c", "stopped": True, "checks": [], "records": []},
                                  {"name": "c", "stopped": False, "checks": [], "records": []}, None, {"name": "c", "stopped": False, "checks": ["SN1"], "records": []}])

    def test_a_unit_is_not_to_be_fitted_while_its_campaign_records_it(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "to_fit": 5, "fit_campaigns": [{"campaign": "autumn", "runs": 3}, {"campaign": "week", "runs": 2}], "model": None, "verify_with": []}

        def told(stopped, records):
            return self.browser.run("const given = arguments; return import('/unit_words.mjs').then((words) => words.nextOf(...given))",
                                    unit, {"name": "week", "of": 4, "stopped": stopped, "checks": [], "records": records})
        self.assertEqual((told(False, ["SN1"])["kind"], told(False, ["SN1"])["text"]),
                         (None, "Wait: campaign week still records it. 2 of 4 runs recorded so far; fit it when the campaign has ended."))
        self.assertIn("has stopped, 2 of 4 runs recorded: resume it on Station, then fit.", told(True, ["SN1"])["text"])
        self.assertEqual(told(False, ["SN2"])["kind"], "fit")

    def test_a_unit_that_has_a_model_waits_for_the_runs_that_its_campaign_still_records(self):
        self.browser.go(self.soakd.url)
        verification = {"stale": None, "job": {"id": 1, "result": {"verdict": "pass", "model": 1}}, "warnings": []}
        unit = {"unit": "SN1", "epoch": 0, "to_fit": 7, "fit_campaigns": [{"campaign": "autumn", "runs": 3}, {"campaign": "week", "runs": 4}], "exported": None, "warnings": [],
                "verify_with": [], "verification": verification, "gap": {"find": None}, "model": {"version": 1, "epoch": 0, "state": "verified", "terms": []}, "release": {"obstacles": [], "expires": None}}

        def told(stopped, records):
            return self.browser.run("const given = arguments; return import('/unit_words.mjs').then((words) => words.nextOf(...given))",
                                    unit, {"name": "week", "of": 6, "stopped": stopped, "checks": [], "records": records})
        self.assertEqual((told(False, ["SN1"])["kind"], told(False, ["SN1"])["text"]),
                         (None, "Wait: campaign week still records it, 4 of 6 runs so far. When it has ended, fit again with all runs, then verify and release."))
        self.assertEqual(told(False, ["SN2"])["kind"], "release")

    def test_a_campaign_that_has_stopped_does_not_keep_a_unit_from_what_comes_next(self):
        """Nobody can abort one that failed: it may stay like that until another one is begun."""
        self.browser.go(self.soakd.url)
        verification = {"stale": None, "job": {"id": 1, "result": {"verdict": "pass", "model": 1}}, "warnings": []}
        unit = {"unit": "SN1", "epoch": 0, "to_fit": 4, "fit_campaigns": [{"campaign": "autumn", "runs": 3}, {"campaign": "week", "runs": 1}], "exported": None, "warnings": [],
                "verify_with": [], "verification": verification, "gap": {"find": None}, "model": {"version": 1, "epoch": 0, "state": "verified", "terms": []},
                "release": {"obstacles": [], "expires": None}}
        stopped = {"name": "week", "of": 4, "stopped": True, "checks": [], "records": ["SN1"]}

        def told(role):
            return self.browser.run("const [unit, open, role] = arguments; return import('/unit_words.mjs').then((words) => words.nextForRole(words.nextOf(unit, open), role))", unit, stopped, role)
        following = told("engineer")
        self.assertEqual((following["kind"], following["text"]), ("release", "Release it."))
        self.assertEqual(following["beside"], {"text": "Campaign week, which records it, has stopped, 1 of 4 runs recorded. To have the others too, resume it on Station; then fit again with all runs.",
                                               "link": {"text": "Station", "address": "#station"}})
        self.assertNotIn("link", told("viewer")["beside"])

    def test_who_may_not_do_what_comes_next_is_told_who_does(self):
        self.browser.go(self.soakd.url)
        link = {"text": "New campaign", "address": "#station"}

        def told(kind, role, **more):
            return self.browser.run("const given = arguments; return import('/unit_words.mjs').then((words) => words.nextForRole(...given))", {"kind": kind, "text": "Do it.", **more}, role)
        by_engineer, by_operator = "Do it. An engineer does that; your account may not.", "Do it. An operator or an engineer does that; your account only looks."
        for kind, role, text in (("release", "operator", by_engineer), ("export", "viewer", by_engineer), ("release", "engineer", "Do it."), ("release", None, "Do it."), ("fit", "operator", "Do it."),
                                 ("fit", "viewer", by_operator), (None, "viewer", "Do it.")):
            self.assertEqual(told(kind, role)["text"], text, (kind, role))
        self.assertEqual(told(None, "viewer", link=link), {"kind": None, "text": by_operator, "link": None})
        self.assertEqual(told(None, "operator", link=link)["link"], link)

    def test_a_released_model_that_only_a_new_fit_mends_is_not_to_be_verified_first(self):
        self.browser.go(self.soakd.url)
        fresh = [{"campaign": "check", "runs": 1, "purpose": "verification"}]
        left_out = "runs for calibration are not in it: R07 of campaign c: fit again with all of them"
        unit = {"unit": "SN1", "type": "t", "epoch": 0, "to_fit": 4, "exported": None, "warnings": [], "verify_with": fresh, "verification": None, "gap": {"find": None},
                "model": {"version": 1, "epoch": 0, "state": "released", "terms": []}, "release": {"obstacles": [left_out], "expires": None}}

        def told(unit):
            return self.browser.run("const [unit] = arguments; return import('/unit_words.mjs').then((words) => [words.nextOf(unit), words.verdictText(unit)[0]])", unit)
        (following, why) = told(unit)
        self.assertEqual((following["kind"], following["text"], following["why"]), ("fit", "Do not hand it over. Fit it again, then verify and release it:", [left_out]))
        self.assertEqual(why, "Model 1 was verified, but not from this page: its numbers are in its report.")
        (following, why) = told({**unit, "release": {"obstacles": ["it was never verified: 'soak verify'"], "expires": None}})
        self.assertEqual((following["kind"], why), ("verify", "Model 1 has not been verified here."))

    def test_a_model_that_failed_after_its_release_is_to_be_released_again(self):
        self.browser.go(self.soakd.url)
        again = "a verification on 2026-11-26, after its release, said fail: release it again ('soak release --unit SN1')"

        def told(obstacles):
            return self.browser.run("""const [obstacles] = arguments; return import('/text.mjs').then(({ textsOf }) => textsOf('units')).then(() => import('/unit_words.mjs'))
                .then(({ isToReleaseAgain }) => isToReleaseAgain({ obstacles }))""", obstacles)
        self.assertEqual([told(list) for list in ([again], [again, "it is withdrawn: fit again"], ["it is withdrawn: fit again"], [])], [True, False, False, False])

    def test_the_largest_difference_of_two_curves_is_where_they_share_a_temperature(self):
        self.browser.go(self.soakd.url)

        def told(newest, older):
            curve = [[{"temp_c": t, "bias": bias, "ci95": ci95} for t, bias, ci95 in points] for points in (newest, older)]
            return self.browser.run("""const [newest, older] = arguments[0]; return import('/text.mjs').then(({ textsOf }) => textsOf('units')).then(() => import('/curve_words.mjs'))
                .then(({ differenceText }) => [differenceText(newest, older, ['bias', 'ci95'], '°/s'), differenceText(newest, older, ['scale_ppm', 'scale_ci95_ppm'], 'ppm')])""", curve)
        apart = told([(-10, 0.5, 0.01), (0, 0.1, 0.01), (20, 0.3, 0.02)], [(-5, 0.0, 0.03), (5, 0.02, 0.03), (25, 0.2, 0.05)])
        # Of the second curve 0.01 at 0 °C and 0.155 at 20 °C, on straight lines between its points; −10 °C it does not reach.
        self.assertEqual(apart, ["Largest difference between the two: +0.145 °/s at 20 °C, where the wider 95 % band is ±0.045 °/s.", ""])
        self.assertEqual(told([(0, 1.0, 0.1)], [(10, 1.0, 0.1)])[0], "The two curves have no temperature in common.")

    def test_a_file_and_a_verdict_from_before_a_repair_or_a_void_are_told_to_be_void(self):
        self.browser.go(self.soakd.url)
        job = {"id": 1, "unit": "SN1", "state": "done", "started_utc_s": 1000.0, "result": {"model": 1, "verdict": "pass"}}
        unit = {"epoch": 0, "warnings": [], "verification": {"stale": None, "job": {**job, "kind": "verify"}}, "model": {"version": 1, "epoch": 0, "state": "released"},
                "versions": [{"version": 1, "epoch": 0, "state": "released", "void": None}]}

        def told(kind, verdict="pass", **more):
            return self.browser.run("""const given = arguments; return Promise.all([import('/text.mjs').then(({ textsOf }) => Promise.all([textsOf('units'), textsOf('gap')])),
                import('/job_words.mjs')]).then(([, words]) => [words.madeFrom(...given), words.isVoid(...given)])""",
                                    {**job, "kind": kind, "result": {"model": 1, "verdict": verdict}}, {**unit, **more})
        self.assertEqual(told("report"), ["Made from model 1.", False])
        repaired = "Made from model 1, of the unit before it was repaired or changed: void since, do not use it."
        self.assertEqual([told(kind, epoch=1) for kind in ("export", "report", "verify")], [[repaired, True], [repaired, True], ["", True]])
        void = "Made from model 1. Data that this rests on were withdrawn since: void, do not use it."
        self.assertEqual(told("export", warnings=[{"code": "voided_since"}]), [void, True])
        self.assertEqual(told("report", verification={"stale": "data of its campaign were withdrawn since", "job": job}), [void, True])
        self.assertEqual(told("report", "info", epoch=1), ["Made from model 1.", False], "made after the repair: it says so itself")

        def after_a_newer_fit(kind, epoch=0, **of_the_older):
            newer = {"version": 2, "epoch": epoch, "state": "fitted", "void": None}
            older = {"version": 1, "epoch": 0, "state": "released", "void": None, **of_the_older}
            again = {"stale": "the unit was fitted again since", "job": {**job, "kind": "verify"}}
            return told(kind, epoch=epoch, model=newer, versions=[newer, older], verification=again)
        self.assertEqual([after_a_newer_fit(kind) for kind in ("export", "verify")], [["Made from model 1; the newest is 2.", False], ["", False]])
        for kind in ("export", "report", "verify"):
            said = kind != "verify"
            self.assertEqual(after_a_newer_fit(kind, void="withdrawn since: data of the run of week"), [void if said else "", True])
            self.assertEqual(after_a_newer_fit(kind, state="withdrawn", void="the model was withdrawn"),
                             ["Made from model 1, which is withdrawn: do not use it." if said else "", True])
            self.assertEqual(after_a_newer_fit(kind, epoch=1), [repaired if said else "", True])

    def test_every_version_that_is_not_withdrawn_can_be(self):
        """Also one that is released and breaks the rule of release by now, behind a newer one."""
        self.browser.go(self.soakd.url)
        versions = [{"version": 3, "epoch": 0, "state": "withdrawn", "void": "withdrawn"}, {"version": 2, "epoch": 0, "state": "fitted", "void": None},
                    {"version": 1, "epoch": 0, "state": "released", "void": "withdrawn since: data of the run of week"}]
        unit = {"unit": "SN1", "model": {"version": 3, "state": "withdrawn"}, "released_before": [], "versions": versions}
        listed = self.browser.run("""const [unit] = arguments; return import('/text.mjs').then(({ textsOf }) => textsOf('units')).then(() => import('/withdraw_dialog.mjs'))
            .then(({ WithdrawDialog }) => { new WithdrawDialog(() => {}).open(unit, "Eva"); return [...document.getElementById('withdraw-version').options].map(({ text }) => text); })""", unit)
        self.assertEqual(listed, ["2, older, fitted", "1, older, released"])

    def test_a_fleet_of_one_model_says_that_nothing_is_compared(self):
        self.browser.go(self.soakd.url)

        def told(drift):
            curve = {"units": [{"unit": "SN1", "outlier": False, "drift": drift}]}
            fleet = {"units": [{"unit": "SN1", "model": {}}, {"unit": "SN2", "model": None}], "rule": {"fewest_units": 20},
                     "sensors": {"gyro_x": {"unit": "deg/s", "bias": curve, "scale": None}}}
            return self.browser.run("const [fleet] = arguments; return import('/fleet_words.mjs').then((words) => words.summaryOf(fleet, words.findingsOf(fleet)))", fleet)
        self.assertEqual(told(None), "Only one unit of this type has a model: nothing to compare with yet.")
        self.assertIn("It has not moved since the model before.", told({"beyond_band": False, "change": 0.1, "band": 1, "temp_c": 20}))
        self.assertIn("It has moved since the model before.", told({"beyond_band": True, "change": 2, "band": 1, "temp_c": 20}))

    def test_a_fleet_in_which_nothing_is_compared_does_not_say_that_nothing_was_found(self):
        self.browser.go(self.soakd.url)

        def told(units, drifts):
            curve = {"units": [{"unit": f"SN{i}", "outlier": False, "drift": drift and {"beyond_band": drift == "moved", "change": 2, "band": 1, "temp_c": 20}} for i, drift in enumerate(drifts)]}
            fleet = {"units": [{"unit": f"SN{i}", "model": {}} for i in range(units)], "rule": {"fewest_units": 20}, "sensors": {"gyro_x": {"unit": "deg/s", "bias": curve, "scale": None}}}
            return self.browser.run("const [fleet] = arguments; return import('/fleet_words.mjs').then((words) => [words.summaryOf(fleet, words.findingsOf(fleet)), words.noneMarked(fleet)])", fleet)
        few = "Too few units to say which is unlike the others: 2 have a model, 20 are needed."
        unknown = "Whether one has moved is not known: that takes two models of the same unit, each of several runs."
        self.assertEqual(told(2, [None, None]), [f"{few} {unknown}", "No unit is marked. With fewer than 20 models nobody can say which is unlike the others."])
        self.assertEqual(told(2, ["same", None])[0], f"{few} Of 1 unit with a model before, none has moved since.")
        self.assertEqual(told(20, [None] * 20), [f"No unit stands out from the others. {unknown}", "No unit stands out."])
        self.assertEqual(told(20, ["moved", "same"])[0], "No unit stands out from the others. Of 2 units with a model before, 1 has moved since.")

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
        sensors["accel_x"]["scale"]["worst_abs"] = 560.0
        beyond = self.browser.run("const [unit] = arguments; return import('/unit_words.mjs').then((words) => words.verdictText(unit)[0])", unit)
        self.assertTrue(beyond.endswith("Farthest beyond its limit: accel x, scale, 560 ± 60 ppm at 56 °C, limit 500 ppm."), beyond)
        self.assertEqual(rows[1], ["accel x", "0.0183", "±0.0050", "0.030", "m/s²", "−4", "PASS"])

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

    def test_each_sensor_is_held_against_what_was_expected_when_its_own_effect_was_accepted(self):
        self.browser.go(self.soakd.url)
        def term(name, sensor, low=None):
            return {"name": name, "parts": [{"sensors": [sensor]}], "gap": {} if low is None else {sensor: {"closed_ci95": [low, 1.05]}}}
        def said(gyro, accel, terms):
            sensors = {name: {"fresh": {"before_rms": 0.03, "after_rms": 0.004, "floor_rms": 0.004, "closed_fraction": closed}, "fitted": None}
                       for name, closed in (("gyro_x", gyro), ("accel_x", accel))}
            return self.browser.run("const [result] = arguments; return import('/gap_words.mjs').then((words) => words.shownText(result))",
                                    {"before": 1, "model": 3, "terms": terms, "runs": [{"use": "fresh"}], "sensors": sensors})
        two_steps = [term("sensor_lag", "gyro_x", 0.93), term("hysteresis", "accel_x", 0.6)]
        self.assertIn("As much is closed as was expected.", said(0.95, 0.7, two_steps))
        self.assertIn("In gyro x less is closed than was expected", said(0.36, 0.7, two_steps))
        self.assertIn("In accel x less is closed than was expected", said(0.95, 0.5, two_steps))
        again = [term("sensor_lag", "gyro_x", 0.93), term("hysteresis", "gyro_x", 0.5), term("hysteresis", "accel_x", 0.6)]
        self.assertIn("As much is closed as was expected.", said(0.55, 0.7, again), "the newest counts")
        unknown = [term("sensor_lag", "gyro_x", 0.93), term("hysteresis", "accel_x")]
        self.assertNotIn("expected", said(0.95, 0.7, unknown))
        self.assertIn("In gyro x less is closed than was expected", said(0.36, 0.7, unknown))

    def obstacles(self, language, *texts):
        """Parts that the page makes of each."""
        self.browser.go(self.soakd.url)
        self.browser.run("localStorage.setItem('soak-language', arguments[0])", language)
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-language')")
        self.browser.go("about:blank")
        self.browser.go(self.soakd.url)
        return self.browser.run("const texts = arguments; return import('/obstacle_words.mjs').then((words) => [...texts].map((text) => words.obstacleParts([text])))", *texts)

    def test_every_obstacle_to_a_release_is_told_in_the_language_of_the_page(self):
        texts = sorted(obstacles_of_the_rule())
        self.assertEqual(len(texts), 19)
        for language in ("en", "de"):
            for text, parts in zip(texts, self.obstacles(language, *texts)):
                with self.subTest(text, language=language):
                    self.assertTrue(all(isinstance(part, str) for part in parts), parts)
                    if language == "de":
                        self.assertNotRegex("".join(parts), ENGLISH)

    def test_a_campaign_keeps_its_name_in_an_obstacle(self):
        left_out = "runs for calibration are not in it: r1 of campaign rest of campaign 3, r2 of campaign a, b: fit again with all of them"
        self.assertIn("r1 der Kampagne rest of campaign 3, r2 der Kampagne a, b:", self.obstacles("de", left_out)[0][0])
        self.assertIn(left_out, self.obstacles("en", left_out)[0][0])

    def test_a_released_model_that_breaks_the_rule_by_now_is_not_exported_and_the_page_says_why(self):
        self.browser.go(self.soakd.url)
        unit = {"unit": "SN1", "type": "t", "epoch": 1, "to_fit": 0, "verify_with": [], "fitted_to": [], "released_before": [1], "simulated_before": [], "warnings": [], "exported": None,
                "verification": None, "gap": {"find": None, "show": None}, "model": {"version": 2, "epoch": 1, "state": "released", "simulated": False, "terms": []},
                "release": {"obstacles": ["it was never verified: 'soak verify'"], "expires": None}}
        def offered(unit, format="blob", version=""):
            return self.browser.run("""const [unit, format, version] = arguments;
                return import('/text.mjs').then(({ textsOf }) => Promise.all([textsOf('units'), textsOf('gap')])).then(() => import('/job_panel.mjs')).then(({ JobPanel }) => {
                  window.panel ??= new JobPanel(() => 'Eva', () => {}, () => {});
                  document.getElementById('unit-format').value = format;
                  window.panel.offer(unit, null);
                  document.getElementById('unit-version').value = version;
                  document.getElementById('unit-version').dispatchEvent(new Event('change'));
                  return [document.getElementById('unit-export').disabled, document.getElementById('unit-older-why').textContent];
                });""", unit, format, version)
        why = "Export is off: model 2 is released, and does not keep the rule of release any more: it was never verified."
        self.assertEqual(offered(unit), [True, why])
        self.assertEqual(offered(unit, "kalibr"), [False, ""])
        self.assertEqual(offered(unit, version="1"), [False, ""])
        self.assertEqual(offered({**unit, "release": {"obstacles": [], "expires": None}}), [False, ""])
        repaired = {**unit, "epoch": 2}
        self.assertTrue(offered(repaired)[1].startswith("Verify, Release and Export are off: model 2 is of the unit before"))
        off, said = offered(repaired, "kalibr")
        self.assertEqual((off, said.split(":")[0]), (False, "Verify and Release are off"))

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
