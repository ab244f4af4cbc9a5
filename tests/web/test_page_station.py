# SPDX-License-Identifier: Apache-2.0
"""What the station's page tells a technician to do, in a real browser, before a scripted laboratory."""
import datetime
import json
import unittest

from browser import long_test
from page_test import PageTest, soak_history

RATE_1 = {"rate": 1.0, "process_s": 39000.0, "utc_s": 1790000650.0}


def attitude(up, expected, right):
    return {"up": up, "expected": expected, "right": right}


def soak_plan(count=2, set_points_c=(0.0, -20.0, 40.0), positions=("+X", "-Z")):
    """A pre-flight and so many runs; ten minutes a step."""
    steps, runs = [], []

    def step(kind, run, temp_c=25.0, visit=None, position="", estimate_s=600.0):
        steps.append({"kind": kind, "run": run, "temp_c": temp_c, "sweep": "down", "position": position, "seconds": 0.0,
                      "after_turn": False, "estimate_s": estimate_s, "visit": visit})

    for run in range(count + 1):
        first = len(steps)
        step("power_on", run)
        for visit, temp_c in enumerate(set_points_c if run else ()):
            step("set_temperature", run, temp_c, visit)
            for position in positions:
                step("move", run, temp_c, visit, position)
                step("wait_stable", run, temp_c, visit)
                step("record", run, temp_c, visit, position)
        if not run:
            step("check", run)
        else:
            step("warm_end", run)
        step("power_off", run)
        runs.append({"label": f"P0{run}", "preflight": run == 0, "first_step": first, "last_step": len(steps) - 1})
    return {"procedure": {"name": "six-position-soak"}, "runs": runs, "steps": steps, "estimate_s": 600.0 * len(steps)}


def set_step(station, plan, kind, run, visit=None, position=""):
    """Puts the campaign into that step of the plan, of which four minutes are gone."""
    at = next(i for i, s in enumerate(plan["steps"])
              if s["kind"] == kind and s["run"] == run and (visit is None or s["visit"] == visit)
              and (not position or s["position"] == position))
    left_s = sum(s["estimate_s"] for s in plan["steps"][at:]) - 240.0
    for key, value in (("run", run + 1), ("runs", 3), ("step", at), ("steps", len(plan["steps"])), ("step_kind", kind),
                       ("remaining_s", left_s)):
        station.set(f"/campaign/{key}", value)
    return left_s


class StationTest(PageTest):
    def setUp(self):
        super().setUp()
        self.station.set("/clock", RATE_1)
        self.station.set("/units/0/state", "streaming")
        self.station.set("/units/1/state", "closed")
        for unit in (0, 1):
            self.station.set(f"/units/{unit}/attitude", None)

    def local(self, utc_s, form="%H:%M"):
        """Local time as the browser, which runs on this machine, has it."""
        return datetime.datetime.fromtimestamp(utc_s).strftime(form)

    def text(self, selector):
        return self.browser.run("return document.querySelector(arguments[0]).innerText", selector)

    def disabled(self, selector):
        return self.browser.run("return document.querySelector(arguments[0]).disabled", selector)


class AfterABreak(StationTest):
    def test_a_page_that_saw_the_campaign_goes_on_when_soakd_knows_it_no_more(self):
        self.station.tell("plan " + json.dumps(soak_plan()))
        set_step(self.station, soak_plan(), "move", run=1, visit=0, position="+X")
        self.station.set("/prompt", {"id": 7, "text": "Turn", "code": "position", "about": {"position": "+X", "wrong": []}})
        self.open()
        self.shown("#prompt-inner")
        self.see("#step-text", "Run 1 of 2")
        self.station.tell("status " + json.dumps({**self.status(), "state": "interrupted", "campaign": None, "resumable": "acceptance", "prompt": None, "units": []}))
        self.hidden("#prompt-inner")
        self.see("#step-text", "Campaign acceptance can be resumed")
        self.assertEqual(self.browser.console(), [])

    def broken(self, state, **more):
        self.browser.go(self.station.url)
        status = {**self.status(), "state": state, "campaign": None, "units": [], "reason": "the supply failed",
                  "resumable": "acceptance", **more}
        self.browser.go("about:blank")
        self.station.tell("status " + json.dumps(status))
        self.open()

    def test_a_restart_in_mid_campaign_offers_to_resume_it(self):
        self.broken("interrupted")
        self.see("#campaign-name", "acceptance")
        self.see("#alerts", "the supply failed")
        self.assertFalse(self.disabled("#resume"))
        self.assertFalse(self.disabled("#abort"))
        self.assertTrue(self.disabled("#pause"))
        self.browser.click("#resume")
        self.station.wait_for_command("resume by web page")
        self.assertEqual(self.browser.console(), [])

    def test_who_starts_another_campaign_is_told_what_that_gives_up(self):
        self.broken("failed")
        self.see("#start-gives-up", "acceptance")
        self.station.set("/resumable", None)
        self.hidden("#start-gives-up")

    def test_a_failed_campaign_can_be_resumed_from_the_page(self):
        self.broken("failed")
        self.see("#alerts", "Resume")
        self.browser.click("#resume")
        self.station.wait_for_command("resume by web page")

    def test_a_unit_that_was_dropped_does_not_look_like_one_that_is_recorded(self):
        self.station.set("/units/0/dropped", "it has stopped sending")
        self.open()
        self.see("#units > :nth-child(1) .unit-state", "dropped")
        self.see("#alerts", "it has stopped sending")
        self.assertNotIn("dropped", self.text("#units > :nth-child(2)"))

    def test_a_data_folder_that_is_gone_is_an_alarm_though_nothing_runs(self):
        self.station.set("/state", "idle")
        self.station.set("/campaign", None)
        self.station.set("/data/trouble", "/var/lib/soak is gone")
        self.open()
        self.see("#alerts .alarm", "/var/lib/soak is gone")

    def test_a_failed_campaign_that_still_stands_in_the_status_can_be_resumed(self):
        self.station.set("/state", "failed")
        self.station.set("/resumable", "acceptance")
        self.open()
        self.browser.wait("return !document.querySelector('#resume').disabled")

    def test_what_is_to_be_done_is_told_while_a_station_that_began_again_makes_itself_safe(self):
        reason = "soakd ended during the campaign; the chamber does not answer: go to the chamber and switch it off by hand"
        self.broken("stopping", reason=reason, resumable=None, ending={"outcome": "interrupted", "needs_somebody": False})
        self.see("#alerts .alarm", reason)
        self.see("#alerts .alarm .action", "Resume continues it once the station is safe")
        self.see("#progress-card #reason", reason)
        self.see("#state", "stopping")
        self.assertNotIn("null", self.text("#progress-card"))
        for part in ("#facts", "#progress", "#idle"):
            self.hidden(part)
        for button in ("#pause", "#resume", "#abort"):
            self.assertTrue(self.disabled(button), button)
        self.station.set("/chamber/connected", False)
        self.station.set("/chamber/air_c", None)
        self.browser.wait("return document.querySelectorAll('#alerts .alarm').length === 2")
        self.assertEqual(self.text("#alerts").count(reason), 1)
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_campaign_that_is_not_known_yet_is_shown_by_its_state(self):
        self.broken("running", reason=None, resumable=None)
        self.see("#progress-card #step-text", "running")
        self.assertNotIn("null", self.text("#progress-card"))
        self.assertEqual(self.browser.console(), [])

    def test_what_cannot_be_resumed_is_not_offered(self):
        self.broken("finished", resumable=None)
        self.hidden("#progress-card")


class Alarms(StationTest):
    def test_on_a_wall_screen_what_matters_is_read_from_three_metres(self):
        self.browser.resize(1920, 1080)
        self.addCleanup(self.browser.resize, 1280, 900)
        self.station.set("/units/0/attitude", attitude("+Y", "+X", False))
        self.open()
        self.browser.wait("return document.querySelector('#alert-list .action')")
        sizes = self.browser.run("""return ['#step-text', '#finish', '#door-title', '#alert-list strong', '#alert-list .action'].map((name) => [name, parseFloat(getComputedStyle(document.querySelector(name)).fontSize)])""")
        for name, pixels in sizes:
            self.assertGreaterEqual(pixels, 40, name)  # 2.5 rem
        self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), 1920)

    def test_a_silent_chamber_is_an_alarm_that_says_what_to_do(self):
        self.open()
        self.hidden("#alerts")
        self.station.set("/chamber/connected", False)
        self.station.set("/chamber/air_c", None)
        self.station.set("/state", "waiting")
        self.station.set("/reason", "the chamber does not answer: timed out")
        self.see("#alerts .alarm", "does not answer")
        self.see("#alerts .alarm .action", "Go to the chamber")
        self.see("#state", "waiting for the chamber")
        self.assertNotIn("Waiting for you", self.browser.run("return document.title"))
        self.assertEqual(self.browser.run("return document.querySelector('#alerts').getAttribute('role')"), "alert")
        self.assertEqual(self.browser.run("return document.querySelector('#door').dataset.lamp"), "unknown")
        self.station.set("/chamber/connected", True)
        self.station.set("/state", "running")
        self.hidden("#alerts")

    def test_a_campaign_that_waits_by_itself_has_one_banner_with_what_to_do(self):
        self.open()
        titles = set()
        for cause, level in (("chamber", "alarm"), ("air", "alarm"), ("disk", "warning"), ("storage", "warning"),
                             ("supply", "warning"), ("catalog", "warning")):
            self.station.set("/chamber/connected", cause != "chamber")
            self.station.set("/suspension", {"causes": [cause], "for_s": 60.0, "gives_up_in_s": 7200.0})
            self.station.set("/state", "waiting")
            self.station.set("/reason", f"numbers of {cause}")
            self.see("#reason", f"numbers of {cause}")
            self.browser.wait("return document.querySelectorAll('#alerts li').length === 1"
                              " && document.querySelector('#alerts li').className === arguments[0]", level)
            self.assertIn(self.local(self.status()["clock"]["utc_s"] + 7200), self.text("#alerts .action"))
            titles.add(self.text("#alerts strong"))
            self.assertNotIn("waiting for you", self.text("#state"))
            self.assertEqual(self.browser.run("return document.querySelector('#door').dataset.lamp === 'yes'"), False)
        self.assertEqual(len(titles), 6)
        self.assertFalse(self.disabled("#abort"))
        self.assertFalse(self.disabled("#pause"))
        self.station.set("/suspension", None)
        self.station.set("/state", "running")
        self.hidden("#alerts")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_of_several_causes_the_most_urgent_is_told_first_though_a_question_is_open(self):
        self.station.set("/prompt", {"id": 1, "text": "Turn the fixture"})
        self.station.set("/state", "waiting")
        self.open()
        self.see("#state", "waiting for you")
        self.station.set("/chamber/connected", False)
        self.station.set("/suspension", {"causes": ["disk", "chamber"], "for_s": 60.0, "gives_up_in_s": 7200.0})
        self.see("#state", "waiting for the chamber")
        self.browser.wait("return document.querySelectorAll('#alerts li').length === 2")
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('#alerts li')].map((li) => li.className)"), ["alarm", "warning"])

    def test_an_abort_that_somebody_asked_for_is_no_alarm_unless_somebody_has_to_come(self):
        self.open()
        self.station.set("/ending", {"outcome": "aborted", "needs_somebody": False})
        self.station.set("/state", "stopping")
        self.see("#alerts .warning", "aborted")
        self.assertNotIn("Resume", self.text("#alerts"))
        self.browser.wait("return document.querySelectorAll('#alerts .alarm').length === 0")
        for ending, alarms in (({"outcome": "aborted", "needs_somebody": True}, 2), ({"outcome": "failed", "needs_somebody": False}, 1),
                               ({"outcome": "interrupted", "needs_somebody": False}, 1), (None, 1)):
            self.station.set("/ending", {"outcome": "aborted", "needs_somebody": False})
            self.browser.wait("return document.querySelectorAll('#alerts .alarm').length === 0")
            self.station.set("/ending", ending)
            self.browser.wait("return document.querySelectorAll('#alerts .alarm').length === arguments[0]", alarms)
            self.assertEqual("Resume" in self.text("#alerts"), ending is not None and ending["outcome"] != "aborted", ending)
        self.station.set("/ending", {"outcome": "aborted", "needs_somebody": False})
        self.browser.wait("return document.querySelectorAll('#alerts .alarm').length === 0")
        self.station.set("/chamber/alarms", ["over-temperature"])
        self.see("#alerts .alarm", "over-temperature")

    @long_test
    def test_what_resumes_by_itself_keeps_the_door_closed_and_can_be_aborted(self):
        self.station.set("/state", "interrupted")
        self.station.set("/resumable", "acceptance")
        self.station.set("/chamber/air_c", 25.0)
        for unit in (0, 1):
            self.station.set(f"/units/{unit}/temp_c", 25.0)
        self.open()
        self.browser.wait("return document.querySelector('#door').dataset.lamp === 'yes'")
        for state in ("interrupted", "stopping"):
            self.station.set("/resumes_by_itself", True)
            self.station.set("/state", state)
            self.browser.wait("return document.querySelector('#door').dataset.lamp === 'no'")
            self.browser.wait("return !document.querySelector('#abort').disabled")
        self.station.set("/resumes_by_itself", False)
        self.browser.wait("return document.querySelector('#abort').disabled")

    @long_test
    def test_the_next_campaign_keeps_the_door_closed_or_waits_for_its_button(self):
        waiting = {"campaigns": [{"name": name, "procedure": "verification", "user": "eva", "queued_utc_s": 1790000000.0,
                                  "estimate_s": 7200.0} for name in ("check-1", "check-2")],
                   "waits_for": "campaign", "begins_utc_s": None, "trouble": None}
        self.station.set("/queue", waiting)
        self.open()
        self.see("#queue", "check-1, check-2")
        self.see("#queue-list li:nth-child(2)", "verification, about 2 h")
        self.browser.click("#queue-list li:nth-child(2) button")
        self.station.wait_for_command("unqueue check-2 by web page")
        self.station.set("/state", "running")
        self.hidden("#next")
        self.station.set("/state", "finished")
        self.station.set("/chamber/air_c", 25.0)
        for unit in (0, 1):
            self.station.set(f"/units/{unit}/temp_c", 25.0)
        self.station.set("/queue", {**waiting, "waits_for": "time", "begins_utc_s": self.status()["clock"]["utc_s"] + 240.0})
        self.browser.wait("return document.querySelector('#door').dataset.lamp === 'no'")
        self.browser.wait("return !document.querySelector('#abort').disabled")
        self.see("#alerts .warning", "check-1")
        self.hidden("#next")
        self.station.set("/queue", {**waiting, "waits_for": "somebody", "trouble": "the chamber does not answer"})
        self.see("#alerts .warning", "the chamber does not answer")
        self.browser.wait("return document.querySelector('#door').dataset.lamp === 'yes'")
        self.browser.wait("return document.querySelector('#abort').disabled")
        self.browser.click("#next")
        self.station.wait_for_command("next check-1 by web page")
        self.assertEqual(self.browser.console(), [])

    def test_a_chamber_that_is_off_while_nothing_runs_is_no_alarm(self):
        self.station.set("/state", "idle")
        self.station.set("/campaign", None)
        self.station.set("/chamber/connected", False)
        self.open()
        self.see("#chamber-link", "does not answer")
        self.hidden("#alerts")

    def test_a_wrong_face_is_told_with_both_faces(self):
        self.station.set("/units/0/attitude", attitude("+Y", "-X", False))
        self.open()
        self.see("#alerts .alarm", "SN0042")
        for text in ("+Y", "−X"):
            self.see("#alerts .alarm", text)
            self.see("#units > :nth-child(1) .position", text)
        self.station.set("/units/0/attitude", attitude("-X", "-X", True))
        self.hidden("#alerts")
        self.browser.wait("return document.querySelector('#units .position').innerText === '−X'")

    def test_a_unit_that_is_tilted_on_the_right_face_is_to_be_seated_not_turned(self):
        self.station.set("/units/0/attitude", attitude("+X", "+X", False))
        for fixture in ("by hand", "two-axis fixture"):
            self.station.set("/fixture/description", fixture)
            self.open()
            self.see("#alerts .alarm .action", "5° from +X: seat it")
            for selector in ("#alerts", "#units > :nth-child(1) .position"):
                self.assertNotIn("turn", self.text(selector))
                self.assertNotIn("not +X", self.text(selector))
        self.see("#units > :nth-child(1) .position.bad", "tilted")
        self.station.set("/units/0/attitude", attitude("+X", "+X", True))
        self.hidden("#alerts")
        self.browser.wait("return document.querySelector('#units .position').innerText === '+X'")

    def test_a_face_that_is_not_known_yet_is_no_alarm(self):
        self.station.set("/units/0/attitude", attitude("+Y", "+X", None))
        self.open()
        self.see("#units > :nth-child(1) .position", "turning to +X")
        self.hidden("#alerts")

    def test_the_alarm_sounds_only_where_it_is_asked_for_and_only_while_there_is_one(self):
        self.open()
        self.browser.run("localStorage.setItem('soak-alarm-sound', 'off')")
        self.open()
        self.browser.run("window.tones = 0; const start = OscillatorNode.prototype.start;"
                         "OscillatorNode.prototype.start = function (t) { ++window.tones; start.call(this, t); }")
        self.station.set("/chamber/alarms", ["over-temperature"])
        self.see("#alerts", "over-temperature")
        self.assertEqual(self.browser.run("return window.tones"), 0)
        self.browser.click("#sound")
        self.browser.wait("return window.tones > 0")
        self.assertEqual(self.browser.run("return document.querySelector('#sound').ariaPressed"), "true")
        self.station.set("/chamber/alarms", [])
        self.hidden("#alerts")
        self.browser.run("window.tones = 0")
        self.browser.click("#sound")
        self.browser.click("#sound")
        self.assertEqual(self.browser.run("return window.tones"), 0)
        self.browser.run("localStorage.removeItem('soak-alarm-sound')")


class Sound(StationTest):
    """A browser that allows sound only after a click, as browsers do for people; scripts of the tests count as clicks."""

    STRICT = """
      window.tones = 0;
      let clicked = false;
      addEventListener("click", () => { clicked = true; }, true);
      const count = OscillatorNode.prototype.start;
      OscillatorNode.prototype.start = function (t) { ++window.tones; count.call(this, t); };
      window.AudioContext = class extends AudioContext {
        #state = "suspended";
        get state() { return this.#state; }
        async resume() {
          if (!clicked || this.#state === "running") return;
          await null;
          this.#state = "running";
          this.dispatchEvent(new Event("statechange"));
        }
      };
      window.repetitions = 0;
      const every = window.setInterval;
      window.setInterval = (work, ms) => every(() => { work(); window.repetitions += ms === 4000; }, ms);
      localStorage.setItem("soak-alarm-sound", "on");"""

    @long_test
    def test_after_a_reload_it_says_that_it_needs_a_click_and_saves_up_no_tones_till_then(self):
        script = self.browser.devtools("Page.addScriptToEvaluateOnNewDocument", source=self.STRICT)
        self.addCleanup(self.browser.devtools, "Page.removeScriptToEvaluateOnNewDocument", **script)
        self.station.set("/chamber/alarms", ["over-temperature"])
        self.open()
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-alarm-sound')")
        self.see("#alerts", "over-temperature")
        self.see("#sound", "click to allow")
        self.browser.wait("return window.repetitions >= 2")
        self.assertEqual(self.browser.run("return window.tones"), 0)
        self.browser.click("#sound")
        self.see("#sound", "Alarm sound on")
        self.browser.wait("return window.tones > 0")
        self.assertLessEqual(self.browser.run("return window.tones"), 4)  # of two tones each: at once, and perhaps the next
        self.browser.click("#sound")
        self.see("#sound", "Alarm sound off")
        self.assertEqual(self.browser.run("return localStorage.getItem('soak-alarm-sound')"), "off")


class Turning(StationTest):
    def ask(self, up, expected, right):
        plan = soak_plan()
        self.station.tell("plan " + json.dumps(plan))
        set_step(self.station, plan, "move", run=1, visit=1, position="+X")
        self.station.set("/units/0/attitude", attitude(up, expected, right))
        self.station.set("/prompt", {"id": 7, "text": "Turn the fixture so that its +X points up, then confirm."})
        self.station.set("/state", "waiting")

    def test_a_prompt_to_turn_shows_the_face_that_is_up_and_the_way(self):
        self.ask("+Y", "+X", False)
        self.open()
        self.see("#prompt-faces", "SN0042, slot A: +Y is up now, turn it a quarter turn to +X")
        self.assertNotIn("its own axes", self.text("#prompt-faces"))
        self.station.set("/units/0/attitude", attitude("+Y", "-Y", False))  # mounted otherwise than the fixture, whose +X is asked for
        self.see("#prompt-faces", "half a turn to −Y (in its own axes)")
        self.station.set("/units/0/attitude", attitude("+Y", "+X", False))
        self.see("#prompt-faces", "quarter turn to +X")
        self.browser.wait("return document.querySelectorAll('#prompt-pose svg').length === 2")
        label = "return document.querySelector('#prompt-pose').ariaLabel"
        self.assertEqual(self.browser.run(label), "+Y is up now, +X shall be up")
        self.hidden("#alerts")  # the prompt itself says it
        self.station.set("/units/0/attitude", attitude("-X", "+X", False))
        self.see("#prompt-faces", "half a turn")
        self.station.set("/units/0/attitude", attitude("+X", "+X", True))
        self.see("#prompt-faces", "+X is up ✓")
        self.browser.wait("return document.querySelectorAll('#prompt-pose svg').length === 1")
        self.assertEqual(self.station.commands(), [])

    def test_the_drawing_is_of_a_unit_that_is_mounted_straight(self):
        self.ask("+Y", "+X", False)
        self.station.set("/units/1/attitude", attitude("-Z", "+X", False))
        self.station.set("/units/0/attitude", attitude("+Y", "-Y", False))  # its −Y lies along the fixture's +X
        self.open()
        label = "return document.querySelector('#prompt-pose').ariaLabel === arguments[0]"
        self.browser.wait(label, "−Z is up now, +X shall be up")
        self.station.set("/units/1/attitude", None)
        self.browser.wait(label, "+Y is up now, −Y shall be up")
        self.browser.wait("return document.querySelector('#prompt-pose').textContent.includes('SN0042')")

    def test_where_asked_it_confirms_itself_once_the_unit_rests_right(self):
        self.ask("+Y", "+X", False)
        self.open()
        self.browser.click("#itself")
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-itself')")
        self.station.set("/units/0/attitude", attitude("+X", "+X", None))
        self.see("#prompt-faces", "…")
        self.assertEqual(self.station.commands(), [])
        self.station.set("/units/0/attitude", attitude("+X", "+X", True))
        self.station.wait_for_command("confirm 7 by web page")
        self.assertEqual(self.station.commands(), ["confirm 7 by web page"])

    def confirm_itself(self):
        self.ask("+Y", "+X", False)
        self.open()
        self.browser.click("#itself")
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-itself')")
        self.browser.run("""
          window.answered = 0;
          const ask = window.fetch;
          window.fetch = async (...what) => {
            const answer = await ask(...what);
            for (const read of what[1]?.method === "POST" ? ["json", "text"] : []) {
              const own = answer[read].bind(answer);
              answer[read] = () => own().finally(() => setTimeout(() => ++window.answered));
            }
            return answer;
          };""")
        self.station.set("/units/0/attitude", attitude("+X", "+X", True))
        self.station.wait_for_command("confirm 7 by web page")
        self.browser.wait("return window.answered > 0")  # the page has read the answer, and had its turn

    @long_test
    def test_when_somebody_else_was_faster_a_confirmation_by_itself_is_no_failure(self):
        self.station.tell("fail 2 state")
        self.confirm_itself()
        self.hidden("#failure")
        self.browser.click("#confirm")
        self.browser.wait("return !document.querySelector('#confirm').offsetParent")
        self.browser.console()  # Chromium lists the 409

    @long_test
    def test_another_refusal_of_a_confirmation_by_itself_is_shown(self):
        self.station.tell("fail 2 user")
        self.confirm_itself()
        self.see("#failure", "scripted failure")
        self.browser.console()  # Chromium lists the 400

    @long_test
    def test_a_late_click_says_that_it_was_refused(self):
        self.ask("+Y", "+X", False)
        self.open()
        self.station.tell("fail 2 state")
        self.browser.click("#confirm")
        self.see("#failure", "scripted failure")
        self.browser.console()  # Chromium lists the 409

    @long_test
    def test_a_unit_that_is_tilted_on_the_right_face_is_not_drawn_as_done(self):
        self.ask("+X", "+X", False)
        self.open()
        self.see("#prompt-faces", "5° from +X: seat it")
        self.assertNotIn("turn", self.text("#prompt-faces"))
        reached = "return document.querySelectorAll('#prompt-pose .reached').length === arguments[0]"
        self.browser.wait(reached, 0)
        self.station.set("/units/0/attitude", attitude("+X", "+X", True))
        self.browser.wait(reached, 1)

    @long_test
    def test_without_a_face_the_wanted_one_is_still_drawn(self):
        self.ask("+Y", "+X", False)
        self.station.set("/units/0/attitude", None)
        self.open()
        self.browser.wait("return document.querySelectorAll('#prompt-pose svg').length === 1")
        self.hidden("#itself-box")

    def test_the_drawing_fits_narrow_screens(self):
        self.ask("+Y", "+X", False)
        for width in (320, 390, 768, 1280):
            self.browser.resize(width, 900)
            self.open()
            self.browser.wait("return document.querySelectorAll('#prompt-pose svg').length === 2")
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)

    def test_another_prompt_has_no_drawing(self):
        self.station.set("/prompt", {"id": 8, "text": "Switch the dry-air purge on."})
        self.open()
        self.see("#prompt-text", "purge")
        self.hidden("#prompt-pose")
        self.hidden("#itself-box")


class Devices(StationTest):
    def test_a_unit_that_is_off_does_not_settle(self):
        self.station.set("/campaign/step_kind", "power_on")
        self.open()
        self.see("#units > :nth-child(2)", "off")
        self.assertNotIn("settling", self.text("#units > :nth-child(2)"))
        self.station.set("/units/0/stable", False)
        self.see("#units > :nth-child(1)", "settling")

    @long_test
    def test_a_unit_whose_link_is_dead_while_it_shall_be_on_is_not_called_off(self):
        self.station.set("/units/0/state", "closed")
        self.station.set("/campaign/step_kind", "record")
        self.open()
        self.see("#units > :nth-child(1)", "no connection")
        self.station.set("/campaign/step_kind", "power_on")
        self.see("#units > :nth-child(1)", "off")

    def test_a_fixture_that_is_turned_by_hand_is_not_called_unconnected(self):
        self.station.set("/fixture", {"description": "by hand", "connected": False, "position": None, "moving": None})
        self.open()
        self.see("#fixture", "turned by hand")
        self.station.set("/fixture/description", "two-axis fixture")
        self.see("#fixture", "not connected")


class TimeAxis(StationTest):
    def draw(self, history):
        self.station.tell("history " + json.dumps(history))
        self.open()
        self.browser.wait("return document.querySelector('#chart path.chamber')?.getAttribute('d')")

    def path(self, name):
        return self.browser.run("return document.querySelector('#chart path.' + arguments[0])?.getAttribute('d') ?? ''", name)

    def test_the_set_point_is_drawn_in_steps(self):
        self.draw(soak_history())
        pieces = self.path("set")[1:].split("L")
        points = [tuple(map(float, piece.split())) for piece in pieces]
        self.assertGreater(len({y for _, y in points}), 4)
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            self.assertTrue(x0 == x1 or y0 == y1, f"a slope from {(x0, y0)} to {(x1, y1)}")

    def test_a_time_of_which_nothing_is_known_is_a_gap(self):
        history = soak_history(900)
        history["t_s"] = [t + (9000.0 if i >= 600 else 0.0) for i, t in enumerate(history["t_s"])]
        self.draw(history)
        for name in ("chamber", "set", "unit-0"):
            self.assertEqual(self.path(name).count("M"), 2, name)

    def test_the_axis_has_times_of_day(self):
        self.draw(soak_history())
        labels = self.browser.run("return [...document.querySelectorAll('#chart .grid text')].map((t) => t.textContent)")
        begin_s, end_s = RATE_1["utc_s"] - 39000.0, RATE_1["utc_s"]
        full_hours = {self.local(t) for t in range(int(begin_s // 3600 + 1) * 3600, int(end_s), 3600)}
        times = [label for label in labels if ":" in label]
        self.assertGreater(len(times), 2)
        self.assertLessEqual(set(times), full_hours)
        self.browser.run("document.querySelector('#chart').focus()")
        self.browser.press("ArrowLeft")
        self.see("#legend", "at ")

    @long_test
    def test_with_another_rate_the_axis_counts_from_the_first_point(self):
        self.station.set("/clock/rate", 60.0)
        history = soak_history()
        history["t_s"] = [t + 86400.0 for t in history["t_s"]]
        self.station.set("/clock/process_s", 86400.0 + 39000.0)
        self.draw(history)
        labels = self.browser.run("return [...document.querySelectorAll('#chart .grid text')].map((t) => t.textContent)")
        self.assertIn("0", labels)
        self.assertIn("2 h", labels)


if __name__ == "__main__":
    unittest.main()
