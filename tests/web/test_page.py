# SPDX-License-Identifier: Apache-2.0
"""The station's page in a real browser, before a scripted laboratory ($TEST_PAGE_SERVER)."""
import json
import math
import os
import pathlib
import subprocess
import sys
import time
import unittest

from browser import BROWSER, DRIVER, Browser


class Station:
    """tests/web/page_server.cpp."""

    def __init__(self):
        self.process = subprocess.Popen([os.environ["TEST_PAGE_SERVER"]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.url = f"http://127.0.0.1:{int(self.process.stdout.readline())}/"

    def tell(self, line):
        """Sends a line; the lines of the answer."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        answer = []
        while (text := self.process.stdout.readline().strip()) != "done":
            assert text, "the page server has ended"
            answer.append(text)
        return answer

    def set(self, pointer, value):
        self.tell(f"set {pointer} {json.dumps(value)}")

    def commands(self):
        return json.loads(self.tell("commands")[0])

    def wait_for_command(self, command):
        end = time.monotonic() + 30
        while command not in self.commands():
            assert time.monotonic() < end, f"'{command}' is not among {self.commands()}"
            time.sleep(0.02)

    def close(self):
        self.process.stdin.close()
        self.process.wait(30)
        self.process.stdout.close()


def soak_history(points=3000):
    """Chamber and two units that follow it late, over 39000 s."""
    t = [13.0 * i for i in range(points)]
    set_point = [float([25, -20, 0, 20, 40, 60, 40, 20, 0, -20][int(10 * i / points)]) for i in range(points)]
    chamber, units, air, unit = [], {"SN0042": [], "SN0043": []}, 25.0, [25.0, 25.0]
    for i in range(points):
        air += 0.05 * (set_point[i] - air)
        unit = [u + k * (air - u) for u, k in zip(unit, (0.02, 0.012))]
        chamber.append(air + 0.1 * math.sin(i / 3))
        units["SN0042"].append(unit[0])
        units["SN0043"].append(None if 1000 < i < 1200 else unit[1])
    return {"t_s": t, "chamber_c": chamber, "set_point_c": set_point, "units": units}


def allan_noise(unit="SN0042", white_dps=0.0375, samples=123456, count=48):
    """GET /noise: white noise that ends in bias instability, at 100 Hz; the three axes differ by 10 %."""
    multiples = [1, 2, 3] + [m * 2 ** k for k in range(12) for m in (4, 5, 6, 7)]
    tau_s = [m / 100 for m in multiples[:count]]
    sensors = {}
    for kind, name, white, floor in (("gyro", "deg/s", white_dps, 0.0018), ("accel", "m/s2", 0.00167, 0.0003)):
        for i, axis in enumerate("xyz"):
            values = [(1 + 0.1 * i) * math.hypot(white / math.sqrt(t), floor) for t in tau_s]
            sensors[f"{kind}_{axis}"] = {"unit": name, "oadev": values, "mdev": values[:-4] + [None] * 4 if values else []}
    return {"unit": unit, "rate_hz": 100.0, "samples": samples, "tau_s": tau_s, "sensors": sensors}


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.station = Station()
        self.addCleanup(self.station.close)
        self.browser.console()
        self.browser.resize(1280, 900)

    def open(self):
        self.browser.go(self.station.url)
        self.browser.wait("return document.querySelector('#version').innerText.startsWith('Soak 0')")

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)

    def hidden(self, selector):
        self.browser.wait("return document.querySelector(arguments[0]).offsetParent === null", selector)

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
        self.see("#chamber-link", "not connected")
        self.see("#air", "–")
        self.station.tell("status " + json.dumps({**self.status(), "units": []}))
        self.browser.wait("return document.querySelector('#units').childElementCount === 0")
        self.assertEqual(self.browser.console(), [])

    def status(self):
        return self.browser.run("return fetch('/api/v1/status').then((answer) => answer.json())")

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
        for _ in range(6):
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
        self.see("#idle", "soak campaign start")
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
        warmest = max(range(3000), key=lambda i: history["chamber_c"][i])
        top = min(y for _, y in points["chamber"])
        at = x0 + (x1 - x0) * warmest / 2999
        self.assertTrue(any(abs(x - at) < 2 and y <= top + 0.1 for x, y in points["chamber"]))
        # Equal steps of the set point are equal steps on the screen: 60, 40, 25, 20, 0, -20.
        levels = sorted({y for _, y in points["set"]})
        scale = (levels[5] - levels[0]) / 80
        for level, temp_c in zip(levels, (60, 40, 25, 20, 0, -20), strict=True):
            self.assertAlmostEqual(level, levels[0] + scale * (60 - temp_c), delta=0.11)  # written with one decimal
        self.station.set("/clock/process_s", 78000.0)
        self.browser.wait(path.format("chamber").replace("?? ''", "!== arguments[0]"), self.browser.run(path.format("chamber")))
        self.see("#legend", "−19.3")
        self.browser.run("document.querySelector('#chart').focus()")
        self.browser.press("ArrowLeft")
        self.see("#legend", "at ")
        self.assertEqual(self.browser.console(), [])

    def test_unit_cards_show_the_noise_beside_the_axes(self):
        self.open()
        first, second = "#units > :nth-child(1)", "#units > :nth-child(2)"
        self.see(first, "noise at 0.96 s")
        self.assertEqual(self.cells(first, "gyro-noise"), ["37.5", "38.1", "36.9"])  # m°/s
        self.assertEqual(self.cells(first, "accel-noise"), ["1.67", "1.71", "1.66"])  # mm/s²
        self.assertEqual(self.cells(second, "gyro-noise"), ["–", "–", "–"])
        self.station.set("/units/1/noise", {"tau_s": 1.0, "gyro_dps": [0.5, 0.05, 0.000123], "accel_mps2": [0.0, 12.0, 0.0016666]})
        self.see(second, "noise at 1.0 s")
        self.assertEqual(self.cells(second, "gyro-noise"), ["500", "50.0", "0.123"])
        self.assertEqual(self.cells(second, "accel-noise"), ["0", "12000", "1.67"])
        self.assertEqual(self.browser.console(), [])

    def cells(self, card, row):
        script = "return [...document.querySelectorAll(arguments[0])].map((cell) => cell.innerText)"
        return self.browser.run(script, f"{card} .{row} td")

    def noise_lines(self):
        """Pixels of the three lines of the noise chart."""
        paths = self.browser.run("return [...document.querySelectorAll('#noise-chart path')].map((p) => p.getAttribute('d'))")
        return [[tuple(map(float, p.split())) for p in path[1:].split("L")] if path else [] for path in paths]

    def wait_for_noise(self):
        self.browser.wait("return document.querySelector('#noise-chart path')?.getAttribute('d')")

    def test_the_noise_chart_draws_the_allan_deviation_with_both_axes_logarithmic(self):
        noise = allan_noise()
        self.station.tell("noise " + json.dumps(noise))
        self.open()
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.wait_for_noise()
        self.hidden("#noise-empty")
        self.see("#noise", "123\u202f456 samples at 100 Hz")
        lines = self.noise_lines()
        self.assertEqual([len(line) for line in lines], [48, 48, 48])
        # A power of ten is as long anywhere on an axis: pixels are straight lines in the logarithms.
        sensors = noise["sensors"]
        for axis, line in zip("xyz", lines):
            for pixels, values in (([x for x, _ in line], noise["tau_s"]), ([y for _, y in line], sensors[f"gyro_{axis}"]["oadev"])):
                a, b = (math.log10(values[0]), pixels[0]), (math.log10(values[-1]), pixels[-1])
                decade = (b[1] - a[1]) / (b[0] - a[0])
                for value, pixel in zip(values, pixels):
                    self.assertAlmostEqual(pixel, a[1] + decade * (math.log10(value) - a[0]), delta=0.11)
        # The guides fall by half a decade a decade, as white noise does.
        x_decade = (lines[0][-1][0] - lines[0][0][0]) / math.log10(noise["tau_s"][-1] / noise["tau_s"][0])
        oadev = sensors["gyro_x"]["oadev"]
        y_decade = (lines[0][0][1] - lines[0][-1][1]) / math.log10(oadev[0] / oadev[-1])
        guides = self.browser.run("""return [...document.querySelectorAll('#noise-chart .guide')].map((line) =>
            ['x1', 'x2', 'y1', 'y2'].map((name) => Number(line.getAttribute(name))))""")
        self.assertGreaterEqual(len(guides), 2)
        for x1, x2, y1, y2 in guides:
            self.assertAlmostEqual((y2 - y1) / y_decade, -0.5 * (x2 - x1) / x_decade, delta=0.01)
        self.assertIn("averaging time", self.browser.run("return document.querySelector('#noise-chart').textContent"))
        self.assertIn("m°/s", self.browser.run("return document.querySelector('#noise-chart').textContent"))
        self.assertEqual(self.browser.console(), [])

    def test_the_noise_legend_says_the_values_at_one_second_and_at_the_cursor(self):
        noise = allan_noise()
        self.station.tell("noise " + json.dumps(noise))
        self.open()
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.see("#noise-legend", "at 0.960 s")
        at = noise["tau_s"].index(0.96)
        self.see("#noise-legend", f"{1000 * noise['sensors']['gyro_x']['oadev'][at]:.1f} m°/s")
        self.browser.run("document.querySelector('#noise-chart').focus()")
        self.browser.press("ArrowRight")
        self.see("#noise-legend", "at 1.12 s")
        self.see("#noise-legend", f"{1000 * noise['sensors']['gyro_z']['oadev'][at + 1]:.1f} m°/s")
        self.assertIn("at 1.12 s", self.browser.run("return document.querySelector('#noise-chart').ariaLabel"))
        self.browser.press("Escape")
        self.see("#noise-legend", "at 0.960 s")

    def test_the_noise_of_another_unit_and_of_the_accelerometers_is_chosen_by_keyboard(self):
        self.station.tell("noise " + json.dumps(allan_noise()))
        self.station.tell("noise " + json.dumps(allan_noise("SN0043", white_dps=0.5)))
        self.open()
        self.browser.run("document.querySelector('#noise-unit').focus()")
        self.see("#noise-legend", "38.3 m°/s")  # 37.5 / sqrt(0.96), bias instability beside it
        height = "return document.querySelector('#noise').offsetHeight"
        before = self.browser.run(height)
        self.browser.type("#noise-unit", "SN0043")
        self.see("#noise-legend", "510 m°/s")
        self.browser.run("document.querySelector('#noise-gyro').focus()")
        self.browser.press("ArrowRight")
        self.see("#noise-legend", "1.73 mm/s²")
        self.assertTrue(self.browser.run("return document.querySelector('#noise-accel').checked"))
        self.assertEqual(self.browser.run(height), before, "nothing jumps")
        self.assertEqual(self.browser.console(), [])

    def test_the_noise_card_says_when_there_is_nothing_and_keeps_its_size(self):
        self.open()
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.see("#noise-empty", "Nothing yet")
        height = "return document.querySelector('#noise').offsetHeight"
        before = self.browser.run(height)
        self.station.tell("noise " + json.dumps(allan_noise()))
        self.station.set("/campaign/run", 3)  # another run: asked for anew at once
        self.wait_for_noise()
        self.hidden("#noise-empty")
        self.assertEqual(self.browser.run(height), before)
        self.assertEqual(self.browser.console(), [])

    def test_noise_is_loaded_when_it_can_be_seen_and_anew_every_ten_seconds_while_recording(self):
        self.browser.resize(1280, 300)  # the card is far below
        self.station.set("/campaign/step_kind", "wait_stable")
        self.open()
        self.station.set("/campaign/step_text", "changed")
        self.see("#step-text", "changed")
        self.assertEqual(self.noise_calls(), 0)
        # Ten seconds of the page's clock pass at once.
        self.browser.run("const now = Date.now; window.later = 0; Date.now = () => now() + window.later;")
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.wait_for_calls(1)
        for step, kind, calls in ((31, "wait_stable", 1), (32, "record", 2), (33, "move", 3), (34, "wait_stable", 3)):
            self.browser.run("window.later += 10000")
            self.station.set("/campaign/step_kind", kind)
            self.station.set("/campaign/step", step)
            self.see("#step", f"{step + 1} of")
            self.wait_for_calls(calls)
        self.station.set("/campaign/step_kind", "record")
        self.wait_for_calls(4)
        self.station.set("/campaign/step", 35)
        self.see("#step", "36 of")
        self.assertEqual(self.noise_calls(), 4, "ten seconds have not passed")

    def noise_calls(self):
        return int(self.station.tell("noise-calls")[0])

    def wait_for_calls(self, calls):
        end = time.monotonic() + 30
        while self.noise_calls() < calls:
            assert time.monotonic() < end, f"asked {self.noise_calls()} times, not {calls}"
            time.sleep(0.02)
        self.assertEqual(self.noise_calls(), calls)

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
        self.assertTrue(self.browser.run("return document.querySelector('#pause').disabled"))
        self.station.tell("log while nobody looked")
        self.station.tell("start")
        self.hidden("#lost")
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
            self.assertEqual(self.browser.run(CONTRAST), [], scheme)


# Visible text whose contrast is below 4.5 : 1 (WCAG 2.1, 1.4.3, with its formula of relative luminance). What cannot be
# used (a button that is disabled) is exempt there.
CONTRAST = """
const parse = (text) => text.match(/[\\d.]+/g).map(Number);
const light = (rgb) => {
  const [r, g, b] = rgb.slice(0, 3).map((v) => v / 255).map((c) => (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const behind = (node) => {
  for (; node; node = node.parentElement) {
    const rgb = parse(getComputedStyle(node).backgroundColor);
    if (rgb.length === 3 || rgb[3] === 1) return rgb;
  }
  return [255, 255, 255];
};
const low = [];
for (const node of document.querySelectorAll('body *')) {
  const text = [...node.childNodes].filter((n) => n.nodeType === 3).map((n) => n.data.trim()).join('');
  if (!text || node.disabled || node.offsetParent === null && !node.ownerSVGElement) continue;
  const style = getComputedStyle(node);
  const [a, b] = [light(parse(node.ownerSVGElement ? style.fill : style.color)), light(behind(node.parentElement && node))];
  const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (contrast < 4.5) low.push(`${text}: ${contrast.toFixed(2)}`);
}
return low;
"""


def take_pictures(folder):
    """Pictures of the page for people to look at: test_page.py --pictures FOLDER."""
    station, browser = Station(), Browser()
    station.tell("history " + json.dumps(soak_history()))
    station.tell("noise " + json.dumps(allan_noise()))
    for text in ("campaign acceptance started", "run 2 began", "plateau −20 °C reached", "recording +X"):
        station.tell("log " + text)
    for scheme in ("light", "dark"):
        browser.colours(scheme)
        for width in (1280, 390):
            browser.resize(width, 900)
            browser.go(station.url)
            browser.wait("return document.querySelector('#chart path.unit-1')?.getAttribute('d')")
            browser.run("document.querySelector('#noise').scrollIntoView()")
            browser.wait("return document.querySelector('#noise-chart path')?.getAttribute('d')")
            browser.run("scrollTo(0, 0)")
            browser.screenshot(pathlib.Path(folder) / f"{scheme}-{width}.png")
            station.set("/prompt", {"id": 12, "text": "Turn the fixture to −Z up, close the door, then confirm."})
            station.set("/state", "waiting")
            station.set("/chamber/alarms", ["compressor over-pressure"])
            browser.wait_for_text("#prompt-text", "Turn")
            browser.screenshot(pathlib.Path(folder) / f"{scheme}-{width}-prompt.png")
            station.set("/prompt", None)
            station.set("/state", "running")
            station.set("/chamber/alarms", [])
    browser.click("#abort")
    browser.screenshot(pathlib.Path(folder) / "abort.png")
    station.tell("stop")
    browser.press("Escape")
    browser.wait_for_text("#lost", "No connection")
    browser.screenshot(pathlib.Path(folder) / "lost.png")
    browser.close()
    station.close()


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--pictures":
        take_pictures(sys.argv[2])
    else:
        unittest.main()
