# SPDX-License-Identifier: Apache-2.0
"""The noise of the units on the station's page: beside the axes, and as Allan deviations in their chart."""
import json
import math
import time
import unittest

from page_test import PageTest, allan_noise


class Noise(PageTest):
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

    def test_what_keeps_the_chart_from_showing_more_is_said_with_what_to_do(self):
        self.station.tell("types " + json.dumps([{"name": "mti-300", "gyro_noise_max_dps_rthz": 0.5, "accel_noise_max_mps2_rthz": None}]))
        self.station.set("/units/0/type", "mti-300")
        self.station.tell("noise " + json.dumps({**allan_noise(count=0), "samples": 40}))
        self.open()
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.see("#noise-empty", "Too little yet: 40 samples at rest")
        self.see("#noise-limit", "allows its gyros 0.5 °/s/√Hz")
        self.browser.click("label:has(> #noise-accel)")
        self.see("#noise-limit", "The type mti-300 states no limit for the noise of its accelerometers")
        self.see("#noise-limit", "noise_max_mps2_rthz in mti-300.toml sets one")
        noise = allan_noise()
        self.station.tell("noise " + json.dumps(noise))
        self.station.set("/campaign/run", 3)
        self.see("#noise-reach", f"Averaging times reach {noise['tau_s'][-1]:.2g} s; for longer ones record a longer rest")
        limit = "return document.querySelectorAll('#noise-chart .line.limit').length"
        self.assertEqual(self.browser.run(limit), 0, "none is stated")
        self.browser.click("label:has(> #noise-gyro)")
        self.browser.wait(f"{limit} === 1")
        # White noise of 0.5 °/s/√Hz has σ = 0.5/√(2τ); the legend is at the averaging time nearest to 1 s.
        tau = min(noise["tau_s"], key=lambda tau_s: abs(tau_s - 1))
        self.see("#noise-legend", f"allowed by the type {1000 * 0.5 / math.sqrt(2 * tau):.0f} m°/s")
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
        # The page's clock stands still but where ten seconds pass at once.
        self.browser.run("const start = Date.now(); window.later = 0; Date.now = () => start + window.later;")
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.wait_for_calls(1)
        for step, kind, at_once, ten_seconds_later in ((31, "wait_stable", 1, 1), (32, "record", 2, 3), (33, "move", 3, 4),
                                                       (34, "wait_stable", 4, 4), (35, "record", 5, 6)):
            self.begin(kind)
            self.wait_for_calls(at_once)
            self.station.set("/campaign/step", step)
            self.see("#step", f"{step + 1} of")
            self.assertEqual(self.noise_calls(), at_once, "ten seconds have not passed")
            self.browser.run("window.later += 10000")
            self.station.set("/campaign/step_text", f"ten seconds of {kind}")
            self.see("#step-text", f"ten seconds of {kind}")
            self.wait_for_calls(ten_seconds_later)

    def test_the_noise_of_a_recording_shorter_than_ten_seconds_is_loaded_after_it(self):
        self.station.set("/campaign/step_kind", "move")
        self.open()
        self.browser.run("const start = Date.now(); window.later = 0; Date.now = () => start + window.later;")
        self.browser.run("document.querySelector('#noise').scrollIntoView()")
        self.wait_for_calls(1)
        for kind in ("record", "check"):
            self.begin(kind)
        self.assertEqual(self.noise_calls(), 1, "ten seconds have not passed")
        self.browser.run("window.later += 10000")
        self.station.set("/campaign/step_text", "ten seconds later")
        self.wait_for_calls(2)

    def begin(self, step_kind):
        """The page knows of the step once it shows the text that was set after it."""
        self.station.set("/campaign/step_kind", step_kind)
        self.station.set("/campaign/step_text", f"it is {step_kind} now")
        self.see("#step-text", f"it is {step_kind} now")

    def noise_calls(self):
        return int(self.station.tell("noise-calls")[0])

    def wait_for_calls(self, calls):
        end = time.monotonic() + 30
        while self.noise_calls() < calls:
            assert time.monotonic() < end, f"asked {self.noise_calls()} times, not {calls}"
            time.sleep(0.02)
        self.assertEqual(self.noise_calls(), calls)


if __name__ == "__main__":
    unittest.main()
