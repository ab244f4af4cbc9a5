# SPDX-License-Identifier: Apache-2.0
"""The page of a unit draws what its report draws, before a real `soakd`: the points behind each curve by run and sweep, what is left of
them, and the noise of the longest stored rest beside the limit of the type."""
import json
import random
import unittest
import urllib.error
import urllib.parse

import test_units
from browser import BrowserTest
from soak_cli import HEADER, check_schema
from test_units import SERIAL, UnitStation

STILL = "STILL"  # a unit that has rested once, and has no model
RATE_HZ, SIGMA_DPS, SIGMA_MPS2 = 20, 0.01, 0.005
LIMITS = ('name = "generic"\n[limits]\ngyro = 0.5\naccel = 0.5\n[gyro]\nnoise_max_dps_rthz = 0.01\n[accel]\nnoise_max_mps2_rthz = 0.001\n')


def rest(seconds=300):
    """A unit at rest on its Z, white noise alone."""
    noise = random.Random(7)
    lines = [HEADER]
    for i in range(seconds * RATE_HZ):
        gyro = [noise.gauss(0, SIGMA_DPS) for _ in range(3)]
        force = [noise.gauss(0, SIGMA_MPS2), noise.gauss(0, SIGMA_MPS2), 9.80665 + noise.gauss(0, SIGMA_MPS2)]
        lines.append(f"{i / RATE_HZ:.2f},r1,soak,up,25.0,+Z,25.0,25.0,{','.join(f'{x:.6f}' for x in gyro + force)}")
    return "\n".join(lines) + "\n"


def tearDownModule():
    test_units.tearDownModule()


class Curves(BrowserTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.soakd = UnitStation()
        cls.addClassCleanup(cls.soakd.close)
        cls.soakd.limits(LIMITS)
        (cls.soakd.folder / "rest.csv").write_text(rest(), encoding="utf-8")
        cls.soakd.soak("import", cls.soakd.folder / "rest.csv", "--unit", STILL, "--campaign", "rest", "--gravity-mps2", "9.80665")
        cls.soakd.soak("fit", "--unit", SERIAL)

    def setUp(self):
        super().setUp()
        self.soakd.limits(LIMITS)

    def open_at(self, serial, part):
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#{urllib.parse.urlencode({'unit': serial})}")
        self.browser.wait("return !document.querySelector('#unit-work').hidden && document.querySelector('#unit-jobs').ariaBusy === 'false'")
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView()", part)

    def marks(self, sensor, shows):
        """Of one figure: how many marks of each style and shape, and where they stand across."""
        paths = self.browser.run("""return [...document.querySelector(`section[aria-labelledby="sensor-${arguments[0]}"] figure[data-shows=${arguments[1]}]`)
            .querySelectorAll("path.mark")].map((path) => [path.getAttribute("class"), path.getAttribute("d")])""", sensor, shows)
        shapes = {"m0-3.4": "up", "m0 3.4": "down", "m-2.4": "unknown", "m-2.6": "fresh"}
        found = []
        for style, way in paths:
            for mark in way[1:].split("M"):
                shape = next(shape for start, shape in shapes.items() if start in mark)
                found.append((style.split()[1], shape, float(mark.split(" ")[0])))
        return found

    def test_points_stand_by_run_and_sweep_above_what_is_left_of_them_over_the_same_temperatures(self):
        version = self.soakd.get("unit", unit=SERIAL)["model"]["version"]
        answer = self.soakd.get("model/rows", unit=SERIAL, version=version)
        check_schema(answer, "http-model-rows")
        self.assertEqual((answer["unit"], answer["model"], len(answer["sensors"])), (SERIAL, version, 6))
        rows = answer["sensors"]["accel_x"]["rows"]
        self.assertEqual(len(rows["runs"]), 3)
        points = rows["points"]
        self.assertEqual(len(points["temp_c"]), rows["total"])
        self.assertEqual(set(points["sweep"]), {"up", "down"})
        self.open_at(SERIAL, "#unit-curves")
        self.browser.wait("return document.querySelectorAll('#unit-curves figure[data-shows=residuals]').length === 6")
        drawn = self.marks("accel_x", "bias")
        expected = sorted((f"unit-{run}", sweep) for run, sweep in zip(points["run"], points["sweep"], strict=True))
        self.assertEqual(sorted((style, shape) for style, shape, _ in drawn), expected)
        left = [mark for mark in self.marks("accel_x", "residuals") if mark[1] != "fresh"]
        self.assertEqual(sorted(left), sorted(drawn + drawn), "in both panels, at the same places across")
        fresh = answer["sensors"]["accel_x"]["fresh"]
        self.assertEqual(len(self.marks("accel_x", "residuals")) - len(left), len(fresh["points"]["temp_c"]))
        for run in rows["runs"]:
            self.see("#unit-sensors > :nth-child(1) .legend", run)
        self.see("#unit-sensors > :nth-child(1) .legend", "▲ heating ▼ cooling")
        self.assertEqual(len(self.marks("accel_x", "scale")), answer["sensors"]["accel_x"]["scale_rows"]["total"])
        self.see('section[aria-labelledby="sensor-gyro_x"]', "Scale: not known.")
        self.assertEqual(self.browser.run("return document.querySelector('#unit-points').textContent"), "")
        self.assertEqual(self.browser.console(), [])

    def test_noise_of_the_longest_rest_is_judged_by_the_limit_of_the_type(self):
        answer = self.soakd.get("unit/noise", unit=STILL)
        check_schema(answer, "http-unit-noise")
        self.assertEqual((answer["segment"]["run"], answer["segment"]["position"], len(answer["sensors"])), ("r1", "+Z", 6))
        for name, sensor in answer["sensors"].items():
            sigma, verdict = (SIGMA_DPS, "inside") if name.startswith("gyro") else (SIGMA_MPS2, "outside")
            # White samples of standard deviation s at R per second have the one-sided density s √(2/R); 6000 of them tell s to 1 %.
            self.assertAlmostEqual(sensor["density"]["value"] / (sigma * (2 / RATE_HZ) ** 0.5), 1.0, delta=0.06)
            self.assertEqual(sensor["verdict"], verdict)
        self.open_at(STILL, "#unit-noise")
        self.see("#unit-noise-verdicts", "Gyros: inside the limit. The type generic allows 0.01 °/s/√Hz.")
        self.see("#unit-noise-verdicts", "Accelerometers: outside the limit (accel x, accel y, accel z). The type generic allows 0.001 m/s²/√Hz.")
        self.see("#unit-noise-said", "run r1 of campaign rest")
        states = self.browser.run("return [...document.querySelectorAll('#unit-noise-verdicts li')].map((line) => line.dataset.state)")
        self.assertEqual(states, ["finished", "failed"])
        lines = self.browser.run("""return [...document.querySelectorAll('#unit-noise-figures svg')].map((drawing) =>
            [...drawing.querySelectorAll('path.line')].map((path) => [path.classList[1], Number(path.getAttribute('d').slice(1).split('L')[0].split(' ')[1])]))""")
        for kind, is_above in zip(lines, (True, False), strict=True):
            limit = dict(kind)["limit"]
            self.assertEqual([(y > limit) for style, y in kind if style != "limit"], [is_above] * 3, "pixels count downwards")
        self.assertEqual(self.browser.console(), [])

    def test_a_type_without_a_limit_of_noise_says_so_and_draws_no_line(self):
        self.soakd.limits(test_units.LIMITS)
        self.assertEqual({sensor["verdict"] for sensor in self.soakd.get("unit/noise", unit=STILL)["sensors"].values()}, {"no_limit"})
        self.open_at(STILL, "#unit-noise")
        self.see("#unit-noise-verdicts", "Gyros: no limit. The type generic states none.")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#unit-noise-figures path.limit').length"), 0)
        self.assertEqual(self.browser.run("return document.querySelectorAll('#unit-noise-figures svg').length"), 2)

    def test_a_model_of_one_temperature_whose_points_differ_by_their_rounding_alone_is_drawn(self):
        # An axis over less than what a number can tell apart once had no end of ticks: nothing was drawn, here and in the report.
        if self.soakd.get("unit", unit=STILL)["model"] is None:
            self.soakd.soak("fit", "--unit", STILL)
        self.open_at(STILL, "#unit-curves")
        self.browser.wait("return document.querySelectorAll('#unit-curves figure[data-shows=residuals] svg').length === 4")  # X and Y were never up
        self.assertEqual(self.browser.run("return document.querySelector('#unit-points').textContent"), "")

    def test_what_is_not_there_is_refused_by_name(self):
        for path, parameters, where in (("model/rows", {"unit": STILL, "version": 99}, "version"), ("model/rows", {"unit": "nobody", "version": 1}, "unit"),
                                        ("unit/noise", {"unit": "nobody"}, "unit")):
            with self.assertRaises(urllib.error.HTTPError) as refused:
                self.soakd.get(path, **parameters)
            self.assertEqual((refused.exception.code, json.load(refused.exception)["error"]["where"]), (400, where))


if __name__ == "__main__":
    unittest.main()
