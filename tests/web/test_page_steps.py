# SPDX-License-Identifier: Apache-2.0
"""What the station's page says of a campaign's steps and of its end: times, what comes next, how the door is opened. As test_page_station.py."""
import datetime
import json
import unittest

from browser import long_test
from test_page_station import RATE_1, set_step, soak_plan, StationTest


class Step(StationTest):
    def setUp(self):
        super().setUp()
        self.plan = soak_plan()
        self.station.tell("plan " + json.dumps(self.plan))

    def test_the_step_is_told_in_words_with_what_is_left_of_it(self):
        set_step(self.station, self.plan, "wait_stable", run=1, visit=1)
        self.open()
        self.see("#step-text", "Run 1 of 2, −20 °C (2 of 3): units settling, 6 min")
        set_step(self.station, self.plan, "record", run=2, visit=2, position="-Z")
        self.see("#step-text", "Run 2 of 2, 40 °C (3 of 3): recording, −Z up, 6 min")
        set_step(self.station, self.plan, "check", run=0)
        self.see("#step-text", "Pre-flight: units are checked")
        set_step(self.station, self.plan, "wait_stable", run=1, visit=1)
        self.station.set("/campaign/step_text", "R01 visit 1, -20 °C down: wait until settled, at most 7200 s")
        self.station.set("/state", "interrupted")
        self.see("#step-text", "Stopped at: Run 1 of 2, −20 °C (2 of 3): units settling")

    def test_the_end_is_a_time_of_day_by_the_stations_clock(self):
        left_s = set_step(self.station, self.plan, "wait_stable", run=1, visit=1)
        self.open()
        self.see("#finish", self.local(RATE_1["utc_s"] + left_s))
        self.station.set("/clock/rate", 60.0)
        self.see("#finish", self.local(RATE_1["utc_s"] + left_s / 60))
        self.station.set("/state", "stopping")
        self.hidden("#finish-box")

    def test_an_end_on_another_day_is_told_with_the_day(self):
        self.station.set("/campaign/remaining_s", 3 * 86400.0)
        self.open()
        end = datetime.datetime.fromtimestamp(RATE_1["utc_s"] + 3 * 86400.0)
        self.see("#finish", f"{end.strftime('%a')} {end.day} {end.strftime('%b')}")
        self.assertNotIn(str(end.year), self.text("#finish"))

    @long_test
    def test_an_end_in_another_year_is_told_with_the_year(self):
        self.station.set("/campaign/remaining_s", 400 * 86400.0)
        self.open()
        end = datetime.datetime.fromtimestamp(RATE_1["utc_s"] + 400 * 86400.0)
        self.see("#finish", f"{end.day} {end.strftime('%b')} {end.year}")

    def test_the_abort_dialog_says_that_the_run_is_lost(self):
        set_step(self.station, self.plan, "record", run=2, visit=1, position="+X")
        self.open()
        self.see("#step-text", "Run 2 of 2")
        self.browser.click("#abort")
        self.see("#abort-text", "run 2 of 2")
        self.see("#abort-text", "void")
        self.see("#abort-text", "cannot be resumed")

    def test_the_lamp_says_when_the_door_may_be_opened(self):
        left_s = set_step(self.station, self.plan, "record", run=1, visit=1, position="+X")
        self.open()
        lamp = "return document.querySelector('#door').dataset.lamp"
        self.assertEqual(self.browser.run(lamp), "no")
        self.see("#door-text", "dew point of the room 12 °C")
        self.station.set("/room/dew_point_assumed", True)
        self.see("#door-text", "dew point 12 °C: assumed, as no dew point of the room is stated")
        self.station.set("/room/dew_point_assumed", False)
        self.see("#door-text", "dew point of the room 12 °C")
        # All of run 2 and the power-off of run 1 come after the warm-up.
        after_s = sum(s["estimate_s"] for s in self.plan["steps"] if s["run"] == 2) + 600.0
        self.see("#door-text", self.local(RATE_1["utc_s"] + left_s - after_s))
        for air_c, unit_c, state, expected in ((25.0, 25.0, "paused", "yes"), (25.0, 25.0, "running", "no"), (25.0, 13.9, "paused", "no"),
                                               (25.0, 14.1, "paused", "yes"), (80.0, 60.0, "paused", "no"), (25.0, 25.0, "stopping", "no"),
                                               (25.0, None, "finished", "yes"), (25.0, None, "failed", "unknown"),
                                               (25.0, None, "aborted", "unknown"), (25.0, None, "interrupted", "unknown"), (25.0, 24.0, "aborted", "yes")):
            self.station.set("/chamber/air_c", air_c)
            self.station.set("/units/0/temp_c", unit_c)
            self.station.set("/state", state)
            with self.subTest(air_c=air_c, unit_c=unit_c, state=state):
                self.browser.wait(f"{lamp} === arguments[0]", expected)
        self.station.set("/state", "paused")
        self.station.set("/units/0/temp_c", 25.0)
        self.station.set("/fixture/moving", True)
        self.browser.wait(f"{lamp} === 'no'")


    def at_20_c_below(self):
        """Recording at −20 °C, the second of three plateaus of run 1."""
        set_step(self.station, self.plan, "record", run=1, visit=1, position="+X")
        self.station.set("/chamber/air_c", -20.0)
        for unit in (0, 1):
            self.station.set(f"/units/{unit}/temp_c", -19.0)
        self.open()
        self.see("#door-text", "Dew forms on cold units: the coldest part is at −20 °C")

    def test_who_wants_the_door_open_at_a_cold_plateau_is_told_when_to_pause(self):
        self.at_20_c_below()
        # Six minutes of this recording, three steps of the next one, three until the first recording at 40 °C.
        warm_utc_s = RATE_1["utc_s"] + 6 * 60.0 + 6 * 600.0
        self.see("#door-text", f"press Pause at 40 °C, from {self.local(warm_utc_s)} (in 1 h 6 min)")
        self.station.set("/state", "paused")
        self.see("#door-text", "A pause holds this temperature: press Resume")
        self.assertNotIn("press Pause", self.text("#door-text"))
        self.station.set("/chamber/set_point_c", 40.0)
        self.see("#door-text", "Wait for the green lamp: this set point is safe")
        self.assertNotIn("press Resume", self.text("#door-text"))

    @long_test
    def test_on_the_way_back_nobody_is_sent_to_a_plateau_that_is_done(self):
        self.at_20_c_below()
        self.see("#door-text", "press Pause at 40 °C")
        self.station.set("/campaign/on_way_back", True)
        self.browser.wait("return !document.querySelector('#door-text').innerText.includes('press Pause')")
        self.see("#door-text", "Once the campaign is back where it stopped")

    def test_who_is_asked_to_turn_at_a_cold_plateau_is_told_how_and_when_the_door_can_be_opened(self):
        self.at_20_c_below()
        self.station.set("/prompt", {"id": 7, "text": "Turn the fixture.", "code": "position", "about": {"position": "+X", "wrong": []}})
        self.station.set("/state", "waiting")
        self.see("#door-text", "Turn the fixture with the door closed")
        self.see("#door-text", "press Pause at the next plateau of 40 °C")
        self.station.set("/prompt", None)
        self.station.set("/state", "running")
        self.see("#door-text", "press Pause at 40 °C, from")
        self.assertNotIn("Turn the fixture", self.text("#door-text"))

    @long_test
    def test_between_two_runs_the_chamber_does_not_become_safe_by_itself(self):
        self.at_20_c_below()
        self.see("#door-text", "At the end of this run")
        self.assertNotIn("without a pause", self.text("#door-text"))
        set_step(self.station, self.plan, "record", run=2, visit=1, position="+X")
        self.see("#door-text", "Safe without a pause when the campaign is over")

    @long_test
    def test_a_plateau_of_the_next_run_is_no_reason_to_wait_for_it(self):
        set_step(self.station, self.plan, "record", run=1, visit=2, position="-Z")
        self.station.set("/chamber/air_c", -20.0)
        self.open()
        self.see("#door-text", "At the end of this run")
        self.assertNotIn("press Pause at", self.text("#door-text"))

    def test_a_time_that_has_passed_or_is_not_planned_is_not_told(self):
        self.at_20_c_below()
        end = next(i for i, s in enumerate(self.plan["steps"]) if s["run"] == 1 and s["kind"] == "warm_end")
        set_step(self.station, self.plan, "warm_end", run=1)
        self.station.set("/campaign/remaining_s", sum(s["estimate_s"] for s in self.plan["steps"][end + 1:]))
        self.see("#step-text", "warming up")
        self.browser.wait("return !document.querySelector('#door-text').innerText.includes('At the end of this run')")
        self.station.set("/campaign/remaining_s", 60.0 + sum(s["estimate_s"] for s in self.plan["steps"][end + 1:]))
        self.see("#door-text", "(in 1 min)")
        self.station.set("/state", "waiting")
        self.browser.wait("return !document.querySelector('#door-text').innerText.includes('At the end of this run')")

    @long_test
    def test_a_set_temperature_is_told_as_it_was_set(self):
        for step in self.plan["steps"]:
            step["temp_c"] += 2.5
        self.station.tell("plan " + json.dumps(self.plan))
        set_step(self.station, self.plan, "wait_stable", run=1, visit=1)
        self.station.set("/chamber/set_point_c", -17.5)
        self.open()
        self.see("#step-text", "−17.5 °C (2 of 3)")
        self.see("#set-point", "−17.5 °C")

    def test_units_in_the_stations_own_words_are_spelt_as_those_of_the_page(self):
        self.station.tell("plan null")
        self.station.set("/campaign/step_text", "rotate at +60 deg/s in +X")
        self.station.set("/reason", "unit SN0042 measures 54.2 deg/s, 9.7 m/s2")
        self.open()
        self.station.tell("log position +X, 60 deg/s")
        self.see("#step-text", "+60 °/s")
        self.see("#reason", "54.2 °/s, 9.7 m/s²")
        self.see("#log", "60 °/s")


class Over(StationTest):
    """A campaign that is over."""

    def end(self, state="finished"):
        self.station.set("/state", state)
        self.open()
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-dismissed')")

    def height(self):
        return self.browser.run("return document.querySelector('#progress-card').offsetHeight")

    def test_it_says_first_what_comes_next_and_counts_nothing_down(self):
        self.end()
        self.see("#after", "acceptance is finished.")
        self.browser.wait("return [...document.querySelectorAll('main p')].find((node) => node.offsetParent).id === 'after'")
        for part in ("#process-time", "#finish-box", "#host-time", "#pause", "#step-text"):
            self.hidden(part)
        self.browser.click("#after a[href='#units']")
        self.shown("#units-view")
        self.station.set("/state", "aborted")
        self.see("#after", "acceptance was aborted")
        self.station.set("/state", "running")
        self.hidden("#after")
        self.shown("#facts")

    @long_test
    def test_beside_other_views_it_is_one_line(self):
        self.end()
        self.shown("#facts")
        large = self.height()
        self.browser.click("#to-runs")
        self.shown("#runs-view")
        self.see("#after", "acceptance is finished.")
        for part in ("#facts", "#progress", "#progress-title"):
            self.hidden(part)
        self.assertLess(self.height(), 0.5 * large)

    def test_once_put_away_it_stays_away_until_there_is_another_one(self):
        self.end()
        self.shown("#after")
        self.browser.click("#dismiss")
        self.hidden("#progress-card")
        self.open()
        self.see("#campaign-name", "acceptance")
        self.hidden("#progress-card")
        self.station.set("/campaign/started_utc_s", self.status()["campaign"]["started_utc_s"] + 86400.0)
        self.shown("#after")

    def test_what_can_be_resumed_or_waits_in_the_queue_is_not_put_away(self):
        self.station.set("/resumable", "acceptance")
        self.end("failed")
        self.shown("#resume")
        self.hidden("#after")
        self.station.set("/resumable", None)
        self.station.set("/state", "finished")
        self.shown("#dismiss")
        waiting = {"name": "check-1", "procedure": "verification", "user": "eva", "queued_utc_s": 1790000000.0, "estimate_s": 7200.0}
        self.station.set("/queue", {"campaigns": [waiting], "waits_for": "somebody", "begins_utc_s": None, "trouble": None})
        self.hidden("#dismiss")
        self.shown("#next")


if __name__ == "__main__":
    unittest.main()
