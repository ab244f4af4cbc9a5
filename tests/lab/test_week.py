# SPDX-License-Identifier: Apache-2.0
"""A technician's week by clicks alone: records, a campaign with a fixture turned by hand, a chamber that falls silent, a soakd that
dies and is resumed, a verification, then fit, verify, report, release and export of the unit; of another one, whose recordings came from
elsewhere, the gap is found, accepted, compared and fitted. The page is a real browser's; the only hands beside it are those that turn
the fixture, mend the chamber's cable, start soakd again and import the recordings."""
import subprocess
import sys
import threading
import unittest
from concurrent.futures import ThreadPoolExecutor

from bench import ROOT, WAIT_S, LabTest, short_procedure
from lab_session import bin_folder, end

sys.path.insert(0, str(ROOT / "tests" / "web"))
from browser import BROWSER, DRIVER, Browser  # noqa: E402

SERIAL = "0380A001"
LAGGING = "SN0042"  # its sensors lag behind its thermometer
HIDDEN = '\n[[hidden]]\neffect = "sensor_lag"\nmagnitude = 2.4\nseed = 31\n'
FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
SET_POINTS = (10, 25, 40)


def named(name, **more):
    return short_procedure(SET_POINTS, positions=FACES, **more).replace('name = "short"', f'name = "{name}"')


class Hands:
    """Turn the fixture to the face that the station asks for, as the technician at the chamber does."""

    def __init__(self, test, rest_at):
        """`rest_at(status)`: where they do nothing until go_on()."""
        self.test = test
        self.rest_at = rest_at
        self.turned = 0
        self.trouble = None
        self._stop = threading.Event()
        self._fixture = test.modbus("fixture")
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def _work(self):
        answered = None
        while not self._stop.wait(0.02):
            try:
                status = self.test.status()
            except OSError:
                continue  # soakd is down
            prompt = status["prompt"]
            if not prompt or prompt["id"] == answered or self.rest_at(status):
                continue
            face = next((face for face in FACES if face in prompt["text"]), None)
            if face is None:
                self.trouble = prompt["text"]
                return
            self._fixture.write_register(0, 1 + FACES.index(face), 1)
            answered, self.turned = prompt["id"], self.turned + 1

    def go_on(self):
        self.rest_at = lambda status: False

    def end(self):
        self._stop.set()
        self._thread.join(30)


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Week(LabTest):
    def setUp(self):
        super().setUp()
        self.browser = Browser()
        self.addCleanup(self.browser.close)
        self.browser.resize(1280, 1000)
        self.beside = ThreadPoolExecutor(1)
        self.addCleanup(self.beside.shutdown)

    def start_station(self):
        """A new laboratory: the fixture is turned by hand, its own procedures lie in the data folder, no unit is named."""
        def by_hand(text):
            begin, end_ = text.index("[fixture]"), text.index("[power]")
            return (text[:begin] + text[end_:]).replace(f'unit = "{SERIAL}"', 'unit = ""')

        own = self.folder / "lab" / "data" / "procedures"
        own.mkdir(parents=True)
        (own / "our-soak.toml").write_text(named("our soak", runs=2), encoding="utf-8")
        (own / "our-check.toml").write_text(named("our check", purpose="verification"), encoding="utf-8")
        self.start_lab(rate=1000, cut=("chamber",), edit=by_hand)
        self.browser.go(self.lab.page)

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)

    def click(self, selector):
        self.browser.wait("const b = document.querySelector(arguments[0]); return b && !b.disabled && b.offsetParent !== null", selector)
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", selector)
        self.browser.click(selector)

    def choose(self, selector, value):
        self.browser.wait("return [...document.querySelector(arguments[0]).options].some((o) => o.value === arguments[1])", selector, value)
        self.browser.run("""const choice = document.querySelector(arguments[0]); choice.value = arguments[1];
            for (const kind of ['input', 'change']) choice.dispatchEvent(new Event(kind, { bubbles: true }));""", selector, value)

    def enter_reference(self):
        self.click("#to-records")
        self.see("#references-none", "No certificate is entered.")
        self.click("#records-view .entry summary")
        self.choose("#reference-kind", "fixture_squareness")
        for name, text in (("name", "tumbling fixture"), ("certificate", "F-12"), ("uncertainty", "0.02")):
            self.browser.type(f"#reference-{name}", text)
        self.browser.run("""document.querySelector('#reference-issued').value = '2026-01-01';
            document.querySelector('#reference-due').value = '2099-01-01';""")
        self.click("#reference-form button[type=submit]")
        self.see("#references", "tumbling fixture")
        self.click("#to-station")

    def start_from_page(self, file, name):
        self.choose("#start-choice", file)
        self.browser.type("#start-name", name)
        serial = "#start-slots input"
        self.browser.run("document.querySelector(arguments[0]).value = ''", serial)
        self.browser.type(serial, SERIAL)
        self.see("#start-review", f"{SERIAL}, type")
        self.browser.wait("return document.querySelector('#start-review .bad') === null")
        self.click("#start-send")
        self.see("#campaign-name", name)

    def silence_and_mend_the_chamber(self):
        self.proxies["chamber"].silence()
        self.see("#alerts", "does not answer")
        self.proxies["chamber"].mend()
        self.browser.wait("return document.querySelector('#alerts').hidden")

    def kill_and_resume(self, hands):
        self.lab.soakd.kill()
        self.lab.soakd.wait(30)
        self.browser.wait("return !document.querySelector('#lost').hidden")
        end(self.lab.soakd)
        self.lab.start_soakd()
        self.browser.go("about:blank")
        self.browser.console()
        self.browser.go(self.lab.page)
        self.see("#campaign-name", "first")
        self.see("#alerts", "Resume")
        self.browser.type("#user", "Eva")  # another port is another station to the browser
        self.click("#resume")
        hands.go_on()
        self.confirm_by_itself()

    def confirm_by_itself(self):
        self.browser.wait("return document.querySelector('#itself-box').offsetParent !== null")
        self.click("#itself")

    def finish(self, name):
        self.browser.wait("return document.querySelector('#state').innerText.toLowerCase() === 'finished'")
        self.see("#stored-campaigns", name)

    def import_recordings(self):
        """Five runs of the unit to be fitted, and a sixth that no fit sees."""
        config, out = self.folder / "lagging.toml", self.folder / "lagging"
        config.write_text((ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8") + HIDDEN, encoding="utf-8")
        subprocess.run([f"{bin_folder()}/soaksim-campaign", "--out", out, "--seed", "31", "--units", "1", "--design", "identical", "--config", config,
                        "--truth", self.folder / "truth.json"], check=True, capture_output=True)
        head, *rows = next((out / "campaign").glob("*.csv")).read_text(encoding="utf-8").splitlines(keepends=True)
        run = head.rstrip().split(",").index("run")
        for name, chosen, more in (("five", lambda label: label != "R06", ()),
                                   ("sixth", lambda label: label == "R06", ("--campaign", "fresh", "--procedure", "verification"))):
            path = self.write(f"{name}.csv", head + "".join(row for row in rows if chosen(row.split(",")[run])))
            self.lab.soak("import", path, "--unit", LAGGING, "--gravity-mps2", "9.80665", "--simulated", *more)

    def open_unit(self, serial):
        self.click("#to-units")
        self.browser.wait("return [...document.querySelectorAll('#units-list tbody a')].some((a) => a.innerText === arguments[0])", serial)
        self.browser.run("[...document.querySelectorAll('#units-list tbody a')].find((a) => a.innerText === arguments[0]).click()", serial)
        self.see("#unit-title", serial)

    def close_the_gap(self):
        self.open_unit(LAGGING)
        self.click("#unit-fit")
        self.see("#unit-jobs", "made model 1")
        self.click("#gap-find")
        self.see("#gap-verdict-text", "sensor lag")
        self.click("#gap-accept")
        self.click("#accept-send")
        self.see("#unit-jobs", f"Accepted: unit {LAGGING}, model 1, sensor lag; made model 2")
        self.click("#gap-show")
        self.see("#gap-shown-text", "on 1 fresh run")
        shown = self.lab.soak_json("gap", "show", "--unit", LAGGING)["sensors"]
        closed = [sensor["fresh"]["closed_fraction"] for sensor in shown.values() if sensor["fresh"]]
        self.assertGreater(max(closed), 0.3, closed)
        self.click("#unit-fit")
        self.see("#unit-jobs", f"Fit: unit {LAGGING}, all runs for calibration; made model 3")
        self.see("#gap-terms", "sensor lag")

    def fit_meanwhile(self):
        """Stays at the unit, whose page says by itself when the campaign that it is verified against is there."""
        self.open_unit(SERIAL)
        self.see("#unit-verdict", "NOT JUDGED")
        self.click("#unit-fit")
        self.browser.wait("return document.querySelectorAll('#unit-curves .sensor').length === 6")
        self.browser.wait("return document.querySelector('#state').innerText.toLowerCase() === 'finished'")
        self.see("#unit-next", "Verify it")

    def judge_and_hand_over(self):
        self.choose("#unit-campaign", "check")
        self.click("#unit-verify")
        self.browser.wait("return document.querySelectorAll('#unit-jobs li').length === 2")
        self.see("#unit-verdict", "campaign check, by Eva")
        self.click("#unit-report")
        self.see("#unit-jobs", f"{SERIAL}.html")
        self.click("#unit-simulated")
        self.click("#unit-export")
        self.see("#unit-jobs", f"{SERIAL}.unreleased.soakcal")
        self.see("#unit-next", "Release it.")
        self.click("#unit-release")
        self.see("#unit-badges", "released")
        self.see("#unit-next", "Export it.")
        self.click("#unit-export")
        self.see("#unit-jobs", f"{SERIAL}.soakcal")
        self.click(f"#unit-jobs a[download='{SERIAL}.soakcal']")
        return self.browser.downloaded(f"{SERIAL}.soakcal")

    def test_from_the_first_start_to_the_file_for_the_firmware(self):
        self.start_station()
        self.browser.type("#user", "Eva")
        self.enter_reference()
        self.start_from_page("our-soak.toml", "first")
        def at_the_second_run_s_last_plateau(status):
            return status["campaign"]["run_label"] == "R02" and status["chamber"]["set_point_c"] == SET_POINTS[-1]

        hands = Hands(self, at_the_second_run_s_last_plateau)
        self.addCleanup(hands.end)
        self.confirm_by_itself()
        self.wait_for_step("record")
        imported = self.beside.submit(self.import_recordings)
        self.silence_and_mend_the_chamber()
        self.wait("a prompt at the second run's last plateau", lambda s: s["prompt"] and at_the_second_run_s_last_plateau(s))
        self.kill_and_resume(hands)
        self.finish("first")
        self.start_from_page("our-check.toml", "check")
        self.fit_meanwhile()
        hands.end()
        self.assertIsNone(hands.trouble)
        self.assertGreater(hands.turned, 3 * len(SET_POINTS) * len(FACES) - 1)
        self.assert_safe()
        file = self.judge_and_hand_over()
        imported.result(WAIT_S)
        self.close_the_gap()

        # What somebody at a terminal finds afterwards.
        path = self.write("unit.soakcal", "")
        path.write_bytes(file)
        points = self.lab.soak_json("eval", path, "--temp-c", ",".join(map(str, SET_POINTS)))["points"]
        self.assertTrue(all(point["in_range"] for point in points[1:-1]))
        self.assertFalse(self.lab.soak_json("eval", path, "--temp-c", "25")["unreleased"])
        runs = self.lab.soak_json("runs", "list", "--unit", SERIAL)["runs"]
        counted = [run["run"] for run in runs if run["purpose"] != "diagnosis" and not run["voided"]]
        self.assertEqual(counted, ["R01", "R02", "R02.2", "V01"])
        self.lab.soak("runs", "verify")
        self.lab.soak("events", "verify")
        by_eva = self.query("SELECT kind, text FROM event WHERE user = 'Eva' ORDER BY ordinal")
        self.assertIn("reference_added", [kind for kind, _ in by_eva])
        self.assertEqual([text for kind, text in by_eva if kind == "job_started"], ["fit", "verify against check", "report", "export as blob", "release", "export as blob", "fit",
                                                                                           "gap_find", "gap_accept of sensor_lag", "gap_show", "fit"])
        self.assertEqual(self.browser.console(), [])


if __name__ == "__main__":
    unittest.main()
