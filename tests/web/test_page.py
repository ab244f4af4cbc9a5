# SPDX-License-Identifier: Apache-2.0
"""The station's page in a real browser, before a scripted laboratory ($TEST_PAGE_SERVER)."""
import json
import unittest

from page_test import STORED, PageTest, allan_noise, soak_history
from test_page_station import soak_plan


class Page(PageTest):
    def test_shows_where_the_campaign_is(self):
        self.open()
        self.see("#campaign-name", "acceptance")
        self.see("#state", "running")
        self.see("#simulated", "SIMULATED")
        self.see("#step-text", "record at -20 °C, +X up")
        self.see("#percent", "31.0 %")
        self.see("#run", "2 of 5")
        self.see("#step", "31 of 240")
        self.see("#remaining", "24 h 00 min")
        self.see("#host-time", "24 min 00 s")  # 86400 s at rate 60
        self.assertEqual(self.browser.run("return document.querySelector('#progress').value"), 0.31)
        self.station.set("/campaign/step_text", "soak at 0 °C")
        self.station.set("/simulated", False)
        self.station.set("/clock/rate", 1.0)
        self.see("#step-text", "soak at 0 °C")
        self.hidden("#simulated")
        self.hidden("#host-time")
        self.assertEqual(self.browser.console(), [])

    def test_shows_chamber_and_units(self):
        self.open()
        self.see("#air", "−20.04")
        self.see("#set-point", "−20.0 °C")
        self.see("#output", "38 %")
        self.station.set("/fixture/description", "two-axis fixture")
        self.see("#fixture", "+X")
        first, second = "#units > :nth-child(1)", "#units > :nth-child(2)"
        for text in ("SN0042", "slot A", "recording", "−19.31", "0.004 ± 0.006", "✓ stable", "+X", "0.120", "−0.030", "9.790"):
            self.see(first, text)
        for text in ("SN0043", "slot B", "settling", "– ± –"):
            self.see(second, text)
        self.see(second + " .lost", "7")
        self.station.set("/chamber/alarms", ["over-temperature"])
        self.see("#alarms", "over-temperature")
        self.station.set("/chamber/connected", False)
        self.station.set("/chamber/air_c", None)
        self.see("#chamber-link", "does not answer")
        self.see("#air", "–")
        self.station.tell("status " + json.dumps({**self.status(), "units": []}))
        self.browser.wait("return document.querySelector('#units').childElementCount === 0")
        self.assertEqual(self.browser.console(), [])

    def test_a_prompt_is_shown_announced_and_confirmed(self):
        self.open()
        self.hidden("#prompt-inner")
        self.station.set("/prompt", {"id": 12, "text": "Turn the fixture to −Z up."})
        self.station.set("/state", "waiting")
        self.see("#prompt-text", "Turn the fixture to −Z up.")
        self.see("#state", "waiting for you")
        self.assertIn("Waiting for you", self.browser.run("return document.title"))
        self.assertEqual(self.browser.run("return document.querySelector('#prompt-text').closest('[aria-live]').ariaLive"), "assertive")
        self.browser.type("#user", "Eva")
        self.browser.click("#confirm")
        self.station.wait_for_command("confirm 12 by Eva")
        self.hidden("#prompt-inner")

    def test_pause_resume_and_abort_with_a_reason(self):
        self.open()
        self.browser.click("#pause")
        self.station.wait_for_command("pause by web page")
        self.see("#state", "paused")
        self.browser.wait("return document.querySelector('#pause').disabled && !document.querySelector('#resume').disabled")
        self.browser.click("#resume")
        self.station.wait_for_command("resume by web page")
        self.browser.click("#abort")
        self.browser.click("#abort-send")  # without a reason nothing is sent
        self.assertTrue(self.browser.run("return document.querySelector('#abort-dialog').open"))
        self.browser.click("#abort-cancel")
        self.assertFalse(self.browser.run("return document.querySelector('#abort-dialog').open"))
        self.browser.click("#abort")
        self.browser.type("#abort-reason", "a cable is loose")
        self.browser.press("Enter")
        self.station.wait_for_command("abort by web page: a cable is loose")
        self.assertEqual([c for c in self.station.commands() if c.startswith("abort")], ["abort by web page: a cable is loose"])
        self.see("#state", "stopping")
        self.browser.wait("return document.querySelector('#abort').disabled")

    def test_the_buttons_are_reached_and_pressed_by_keyboard(self):
        self.open()
        reached = []
        for _ in range(12):
            self.browser.press("Tab")
            reached.append(self.browser.run("return document.activeElement.id"))
            if reached[-1] == "pause":
                self.browser.press("Enter")
                break
        self.assertIn("pause", reached)
        self.station.wait_for_command("pause by web page")

    def test_a_refused_command_says_why(self):
        self.open()
        self.station.tell("fail 2 state")
        self.browser.click("#pause")
        self.see("#failure", "scripted failure")
        self.browser.console()  # Chromium lists the 409

    def test_no_campaign(self):
        self.station.tell("status " + json.dumps({**self.idle(), "state": "idle", "campaign": None}))
        self.open()
        self.see("#start-card", "soak campaign start")
        self.hidden("#progress-card")
        self.see("#units", "SN0042")

    def idle(self):
        self.browser.go(self.station.url)
        return self.status()

    def test_the_chart_draws_the_history_and_goes_on_with_what_comes(self):
        history = soak_history()
        self.station.tell("history " + json.dumps(history))
        self.open()
        path = "return document.querySelector('#chart path.{}')?.getAttribute('d') ?? ''"
        self.browser.wait(path.format("unit-1"))
        for name in ("chamber", "set", "unit-0", "unit-1"):
            self.assertGreater(len(self.browser.run(path.format(name)).split("L")), 20, name)
        self.assertEqual(self.browser.run(path.format("unit-1")).count("M"), 2)  # the gap
        points = {name: [tuple(map(float, p.split())) for p in self.browser.run(path.format(name))[1:].split("L")]
                  for name in ("chamber", "set")}
        # The highest point of the chamber's line stands where its highest temperature does.
        (x0, _), (x1, _) = points["chamber"][0], points["chamber"][-1]
        warmest = max(range(len(history["t_s"])), key=lambda i: history["chamber_c"][i])
        top = min(y for _, y in points["chamber"])
        at = x0 + (x1 - x0) * warmest / (len(history["t_s"]) - 1)
        self.assertTrue(any(abs(x - at) < 2 and y <= top + 0.1 for x, y in points["chamber"]))
        # Equal steps of the set point are equal steps on the screen: 60, 40, 25, 20, 0, -20.
        levels = sorted({y for _, y in points["set"]})
        scale = (levels[5] - levels[0]) / 80
        for level, temp_c in zip(levels, (60, 40, 25, 20, 0, -20), strict=True):
            self.assertAlmostEqual(level, levels[0] + scale * (60 - temp_c), delta=0.11)  # written with one decimal
        before = self.browser.run(path.format("chamber"))
        self.station.set("/clock/process_s", 78000.0)
        self.browser.wait(path.format("chamber").replace("?? ''", "!== arguments[0]"), before)
        self.see("#legend", "−19.3")
        self.browser.run("document.querySelector('#chart').focus()")
        self.browser.press("ArrowLeft")
        self.see("#legend", "after ")
        self.assertEqual(self.browser.console(), [])

    def test_events_are_listed_once_newest_first(self):
        self.station.tell("log campaign acceptance started")
        self.open()
        self.see("#log", "campaign acceptance started")
        self.station.tell("log plateau reached <b>&amp;")
        self.see("#log > :first-child", "plateau reached <b>&amp;")
        self.assertEqual(self.browser.run("return document.querySelector('#log').childElementCount"), 2)
        self.hidden("#log-empty")

    def test_a_lost_connection_is_shown_and_taken_up_again(self):
        self.open()
        self.hidden("#lost")
        self.station.tell("stop")
        self.see("#lost", "No connection to soakd")
        self.see("#lost", "If soakd is dead, nobody drives the chamber: go and look")
        self.addCleanup(self.browser.colours, "light")
        for scheme in ("dark", "light"):
            self.browser.colours(scheme)
            self.assertEqual(self.browser.poor_contrast(), [], scheme)
        self.assertEqual(self.browser.run("return document.querySelector('#door').dataset.lamp"), "unknown")
        self.see("#door-text", "no connection to soakd")
        self.assertNotIn("°C", self.browser.run("return document.querySelector('#door-text').innerText"))  # what it said last
        self.assertTrue(self.browser.run("return document.querySelector('#pause').disabled"))
        self.station.tell("log while nobody looked")
        self.station.tell("start")
        self.hidden("#lost")
        self.see("#door-text", "°C")
        self.see("#log", "while nobody looked")
        self.browser.wait("return !document.querySelector('#pause').disabled")

    def test_many_tabs_share_one_stream(self):
        self.open()
        first = self.browser.tab()
        others = []
        for _ in range(7):  # with the first more than the six connections that a browser allows
            others.append(self.browser.new_tab())
            self.open()
        self.station.set("/campaign/step_text", "all tabs see this")
        for tab in (first, *others):
            self.browser.switch(tab)
            self.see("#step-text", "all tabs see this")
        self.browser.switch(first)
        self.browser.close_tab()
        self.station.set("/campaign/step_text", "without the first tab")
        for tab in others:
            self.browser.switch(tab)
            self.see("#step-text", "without the first tab")
        for tab in others[1:]:
            self.browser.switch(tab)
            self.browser.close_tab()
        self.browser.switch(others[0])

    def test_the_first_view_with_the_history_of_a_long_campaign_weighs_at_most_300_kb(self):
        """Answers of the interface included. Set points, positions and runs are as many as in six-position-soak."""
        plan = soak_plan(20, [-30.0 + 5.0 * i for i in range(21)], ("+X", "-X", "+Y", "-Y", "+Z", "-Z"))
        self.assertGreater(len(json.dumps(plan)), 1_000_000)
        for command, document in (("history", soak_history()), ("plan", plan), ("noise", allan_noise()), ("stored", STORED)):
            self.station.tell(f"{command} {json.dumps(document)}")
        for i in range(100):
            self.station.tell(f"log plateau {i} reached")
        self.open()
        self.browser.wait("return document.querySelector('#chart path.unit-1')?.getAttribute('d') && document.querySelectorAll('#log li').length === 100")
        sizes = self.browser.loaded()
        self.assertGreater(dict(sizes)[f"{self.station.url}api/v1/history"], 40_000)
        self.assertIn(f"{self.station.url}api/v1/plan?around=30", dict(sizes))
        self.assertLessEqual(sum(size for _, size in sizes), 300_000, sizes)

    def test_fits_narrow_screens(self):
        self.station.tell("history " + json.dumps(soak_history()))
        self.station.tell("noise " + json.dumps(allan_noise()))
        self.station.set("/prompt", {"id": 12, "text": "Turn the fixture to −Z up, close the door, then confirm."})
        for width in (320, 400, 768, 1280, 1920):
            self.browser.resize(width, 900)
            self.open()
            self.see("#prompt-text", "−Z up")
            self.browser.wait("return document.querySelector('#chart path')")
            self.browser.run("document.querySelector('#noise').scrollIntoView()")
            self.wait_for_noise()
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)

    def test_text_is_readable_in_light_and_dark(self):
        self.addCleanup(self.browser.colours, "light")
        self.station.tell("noise " + json.dumps(allan_noise()))
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            self.station.set("/prompt", {"id": 12, "text": "Turn the fixture."})
            self.station.set("/chamber/alarms", ["over-temperature"])
            self.open()
            self.see("#alarms", "over")
            self.browser.run("document.querySelector('#noise').scrollIntoView()")
            self.wait_for_noise()
            self.assertEqual(self.browser.poor_contrast(), [], scheme)


if __name__ == "__main__":
    unittest.main()
