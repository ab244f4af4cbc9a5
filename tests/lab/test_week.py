# SPDX-License-Identifier: Apache-2.0
"""A technician's week by clicks and keys alone: the first start and the set-up, records, a campaign with a fixture turned by hand, a chamber
that falls silent, a soakd that dies and is resumed, a verification, then fit, verify, report, release and export of the unit; of another
one, whose recordings came from elsewhere, the gap is found, accepted, compared and fitted. The page is a real browser's; the only hands
beside it are those that turn the fixture, mend the chamber's cable, start soakd again, let the laboratory's clock run fast and import the
recordings."""
import pathlib
import sys
import threading
import unittest
from concurrent.futures import ThreadPoolExecutor

from bench import ROOT, WAIT_S, FaultProxy, LabSession, LabTest, short_procedure
from lab_session import end, first_line

sys.path.insert(0, str(ROOT / "tests" / "web"))
from browser import BROWSER, DRIVER, Browser  # noqa: E402
from lagging_unit import LAGGING, lagging_recordings  # noqa: E402

SERIAL = "0380A001"
RATE = 1000
ALL_OF_IT = "\ue009a\ue000"  # Control+A, then no key held: what is typed next takes its place
FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
SET_POINTS = (10, 25, 40)
# Of an element that is there: for ten frames at the same place.
STANDS_STILL = """const link = arguments[0];
return new Promise((done) => {
  let before = "", still = 0, frames = 0;
  const look = () => {
    const box = document.querySelector(link)?.getBoundingClientRect();
    const now = box ? `${box.top} ${box.left}` : "";
    still = now !== "" && now === before ? still + 1 : 0;
    before = now;
    if (still >= 10 || ++frames > 600) done(still >= 10);
    else requestAnimationFrame(look);
  };
  look();
});"""


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

    def start_soakd(self):
        """With nothing but its data folder."""
        self.lab.soakd, log = self.lab.start("soakd", "--listen", self.lab.listen, "--data", self.lab.data)
        self.lab.page = first_line(self.lab.soakd, log)

    def start_station(self):
        """A new laboratory: the fixture is turned by hand, its own procedures lie in the data folder, no station was ever set up."""
        self.lab = LabSession(self.folder / "lab", units=1, rate=RATE)
        self.addCleanup(self.stop_lab)
        own = pathlib.Path(self.lab.data) / "procedures"
        own.mkdir(parents=True)
        (own / "our-soak.toml").write_text(named("our soak", runs=2), encoding="utf-8")
        (own / "our-check.toml").write_text(named("our check", purpose="verification"), encoding="utf-8")
        self.lab.start_soaksim()
        self.proxies["chamber"] = FaultProxy(self.lab.ports["chamber"])
        self.start_soakd()

    def set_up(self):
        """By the page that a first start opens, step by step."""
        self.browser.go(self.lab.page)
        self.choose("#chamber-map", "watlow-f4t.toml")
        self.enter_address("chamber", self.proxies["chamber"].port)
        self.click("#chamber-try")
        self.see("#chamber-answer", "It answers. The air is at 2")
        self.next_step("fixture")  # by hand, as it stands there
        self.next_step("units")
        self.choose("#unit_type", "mti-300")
        self.enter_address("slots-0", self.lab.ports["units"][0])
        self.click("#step-units summary")
        self.choose("#power-way-choice", "map")
        self.choose("#power-map", "modbus-relay.toml")
        self.enter_address("power", self.lab.ports["relay"])
        self.click("#power-try")
        self.see("#power-answer", "It answers")
        self.browser.type("#slots-0-power_output", "1")
        self.next_step("site")
        self.browser.type("#site-gravity_mps2", "9.80665")
        self.next_step("alarms")
        self.next_step("file")
        self.see("#good", "The station takes it as it is.")
        self.browser.type("#user", "Eva")
        self.assertEqual(self.browser.console(), [])  # the page asks in vain while soakd begins its work
        self.click("#write")
        self.browser.wait("return location.pathname === '/' && document.querySelector('#air')?.innerText.startsWith('2')")

    def enter_address(self, device, port):
        self.browser.type(f"#{device}-host", "127.0.0.1")
        self.browser.type(f"#{device}-port", str(port))

    def next_step(self, step):
        self.click("#next")
        self.browser.wait("return document.querySelector('#steps [aria-current]').dataset.step === arguments[0]", step)

    def run_fast(self):
        """The station's clock like that of the simulated laboratory, which no page offers."""
        self.browser.go("about:blank")
        self.browser.console()
        end(self.lab.soakd)
        file = pathlib.Path(self.lab.data) / "station.toml"
        file.write_text(f"{file.read_text(encoding='utf-8')}\n[clock]\nrate = {RATE}\n", encoding="utf-8")
        self.start_soakd()
        self.browser.go(self.lab.page)

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)

    def click(self, selector):
        """Once more where a list was drawn anew between the look and the click."""
        for is_last in (False, False, True):
            self.browser.wait("const b = document.querySelector(arguments[0]); return b && !b.disabled && b.offsetParent !== null", selector)
            self.browser.run("document.querySelector(arguments[0])?.scrollIntoView({block: 'center'})", selector)
            try:
                return self.browser.click(selector)
            except RuntimeError as error:
                if is_last or "stale element" not in str(error):
                    raise

    def choose(self, selector, value):
        option = f"{selector} option[value='{value}']"
        self.browser.wait("return document.querySelector(arguments[0])?.checkVisibility() && document.querySelector(arguments[1])", selector, option)
        self.browser.click(option)

    def enter_reference(self):
        self.click("#to-records")
        self.see("#references-none", "No certificate is entered.")
        self.click("#records-view .entry summary")
        self.choose("#reference-kind", "fixture_squareness")
        for name, text in (("name", "tumbling fixture"), ("certificate", "F-12"), ("issued", "01012026"), ("due", "01012099"), ("uncertainty", "0.02")):
            self.browser.type(f"#reference-{name}", text)
        self.click("#reference-form button[type=submit]")
        self.see("#references", "tumbling fixture")
        self.click("#to-station")

    def start_from_page(self, file, name):
        self.choose("#start-choice", file)
        self.browser.type("#start-name", name)
        self.browser.type("#start-slots input", ALL_OF_IT + SERIAL)
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
        self.start_soakd()
        self.browser.go("about:blank")
        self.browser.console()
        self.browser.go(self.lab.page)
        self.see("#campaign-name", "first")
        self.see("#alerts", "Resume")
        self.browser.type("#user", "Eva")
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
        for path, more in zip(lagging_recordings(self.folder), ((), ("--campaign", "fresh", "--procedure", "verification"))):
            self.lab.soak("import", path, "--unit", LAGGING, "--gravity-mps2", "9.80665", "--simulated", *more)

    def open_unit(self, serial):
        self.click("#to-units")
        link = f"#units-list a[href='#unit={serial}']"
        self.browser.wait(STANDS_STILL, link)
        self.click(link)
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
        self.click("#sure-send")
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
        self.set_up()
        self.run_fast()
        self.browser.type("#user", "Eva")  # another port is another station to the browser
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
        self.assertEqual([kind for kind, _ in by_eva][:2], ["station_set_up", "reference_added"])
        self.assertEqual([text for kind, text in by_eva if kind == "job_started"], ["fit", "verify against check", "report", "export as blob", "release", "export as blob", "fit",
                                                                                           "gap_find", "gap_accept of sensor_lag", "gap_show", "fit"])
        self.assertEqual(self.browser.console(), [])


if __name__ == "__main__":
    unittest.main()
