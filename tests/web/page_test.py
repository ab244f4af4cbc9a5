# SPDX-License-Identifier: Apache-2.0
"""What the tests of the station's page share: the scripted laboratory ($TEST_PAGE_SERVER), what it is told, and a browser
before it."""
import json
import math
import os
import subprocess
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


# What a station at rest answers that it has stored.
STORED = {"slots": [{"name": "1", "unit": "SN0042", "unit_type": "mti-300", "last_unit": "SN0042"}, {"name": "2", "unit": "", "unit_type": "", "last_unit": "SN0043"}],
          "units": [{"serial": "SN0042", "type": "mti-300", "runs": 6, "newest_run_utc_s": 1789900000.0},
                    {"serial": "<b>x</b>", "type": "generic", "runs": 0, "newest_run_utc_s": None}],
          "campaigns": [{"name": "2026-10", "procedure": "six-position", "state": "finished", "reason": None,
                         "begun_utc_s": 1789800000.0, "runs": 3, "units": ["SN0042"]}]}


def soak_history(points=1600):
    """Chamber and two units that follow it late, over 39000 s: as many numbers of as many digits as a station gives of a long campaign."""
    t = [round(39000.0 / points * i, 2) for i in range(points)]
    set_point = [float([25, -20, 0, 20, 40, 60, 40, 20, 0, -20][int(10 * i / points)]) for i in range(points)]
    chamber, units, air, unit = [], {"SN0042": [], "SN0043": []}, 25.0, [25.0, 25.0]
    for i in range(points):
        share = 39000.0 / points / 13.0  # of 13 s
        air += (1 - 0.95 ** share) * (set_point[i] - air)
        unit = [u + (1 - k ** share) * (air - u) for u, k in zip(unit, (0.98, 0.988))]
        chamber.append(round(air + 0.1 * math.sin(i / 3), 2))
        units["SN0042"].append(round(unit[0], 2))
        units["SN0043"].append(None if points / 3 < i < 0.4 * points else round(unit[1], 2))
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
class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.station = Station()
        self.addCleanup(self.station.close)
        self.browser.go("about:blank")  # the page before this one would complain of its own station, which has gone
        self.browser.console()
        self.browser.resize(1280, 900)

    def open(self):
        self.browser.go(self.station.url)
        self.browser.wait("return document.querySelector('#version').innerText.startsWith('Soak 0')")

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)

    def shown(self, selector):
        self.browser.wait("return document.querySelector(arguments[0]).offsetParent !== null", selector)

    def hidden(self, selector):
        self.browser.wait("return document.querySelector(arguments[0]).offsetParent === null", selector)

    def status(self):
        return self.browser.run("return fetch('/api/v1/status').then((answer) => answer.json())")

    def wait_for_noise(self):
        self.browser.wait("return document.querySelector('#noise-chart path')?.getAttribute('d')")
