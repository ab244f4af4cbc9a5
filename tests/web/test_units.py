# SPDX-License-Identifier: Apache-2.0
"""A technician judges and hands over a unit from the page alone, before a real `soakd` ($SOAK_BIN_FOLDER) with a unit of
soaksim-campaign: fit, verify, report, release, export; what fails says why; a cancelled job and a stopped daemon leave no process."""
import contextlib
import functools
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

from browser import BrowserTest, long_test
from real_soakd import Soakd, programs

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import check_schema, recording  # noqa: E402

SERIAL, OTHER = "SIM-0001", "SIM-0002"  # the one is handed over, the other is for what goes wrong
HOSTILE = ("<script>alert(1)</script>", "../x", "--help", "-o", "__proto__", "[a,b]")
LIMITS = 'name = "generic"\n[limits]\ngyro = 0.5\naccel = 0.5\n'


@functools.cache
def stored_units():
    """A data folder with two small simulated units, not fitted, and units whose names are meant to do harm; stations work on copies."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-units-"))
    data = ["--data", folder / "data"]
    simulator = os.environ.get("SOAK_SIM_BIN", programs() / "soaksim-campaign")
    subprocess.run([simulator, "--out", folder / "lab", "--units", "2", "--runs", "3", "--rows-per-position", "6"], check=True, capture_output=True)
    for serial in (SERIAL, OTHER):
        for campaign, procedure in (("campaign", "import"), ("verification", "verification")):
            subprocess.run([programs() / "soak", "import", folder / "lab" / campaign / f"{serial}.csv", "--unit", serial, "--campaign", campaign,
                            "--procedure", procedure, "--simulated", "--gravity-mps2", "9.80665", *data], check=True, capture_output=True)
    (folder / "small.csv").write_text(recording(3, "r1", (0.0,), 10), encoding="utf-8")
    for name in HOSTILE:
        subprocess.run([programs() / "soak", "import", folder / "small.csv", f"--unit={name}", f"--campaign={name}", "--gravity-mps2", "9.80665",
                        *data], check=True, capture_output=True)
    return folder


def tearDownModule():
    if stored_units.cache_info().currsize:
        shutil.rmtree(stored_units(), ignore_errors=True)


class UnitStation(Soakd):
    """With limits for the unit's type, and units whose names are meant to do harm."""

    def __init__(self):
        self.types = pathlib.Path(tempfile.mkdtemp(prefix="soak-types-"))
        (self.types / "units").mkdir()
        self.limits(LIMITS)
        # By its configuration: what the page asks for must be judged by the same limits as the page shows.
        self.settings = f'[unit_types]\nfolder = "{self.types / "units"}"\n'
        super().__init__()

    def store_all(self):
        shutil.copytree(stored_units() / "data", self.data)

    def limits(self, text):
        (self.types / "units" / "generic.toml").write_text(text, encoding="utf-8")

    def post(self, path, **body):
        request = urllib.request.Request(f"{self.url}api/v1/{path}", json.dumps(body).encode(), {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=30) as answer:
            return json.load(answer)

    def refusal(self, path, **body):
        try:
            self.post(path, **body)
        except urllib.error.HTTPError as error:
            document = json.load(error)
            check_schema(document, "error")
            return error.code, document["error"]["where"]
        raise AssertionError("not refused")

    def ended(self, job):
        """The document of a job once it has ended."""
        end = time.monotonic() + 60
        while (document := self.get("job", id=job["id"]))["state"] == "running":
            assert time.monotonic() < end
            time.sleep(0.02)
        check_schema(document, "http-job")
        return document

    def children(self):
        tasks = pathlib.Path(f"/proc/{self.process.pid}/task")
        found = []
        for task in list(tasks.iterdir()):
            with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # a thread that has ended meanwhile
                found += map(int, (task / "children").read_text().split())
        return found

    def held_child(self):
        """The process of the fit that runs, which gets no further from here on."""
        end = time.monotonic() + 30
        while not (found := [pid for pid in self.children() if b"fit" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()]):
            assert time.monotonic() < end
            time.sleep(0.01)
        os.kill(found[0], signal.SIGSTOP)
        return found[0]

    def close(self):
        super().close()
        os.environ.pop("SOAK_PROCEDURES", None)
        shutil.rmtree(self.types, ignore_errors=True)


def is_alive(pid):
    try:
        state = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


class WithStation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soakd = UnitStation()
        cls.addClassCleanup(cls.soakd.close)


class Interface(WithStation):
    def test_names_that_are_meant_to_do_harm_are_names(self):
        units = self.soakd.get("units")
        check_schema(units, "http-units")
        self.assertEqual({unit["unit"] for unit in units["units"]}, {SERIAL, OTHER, *HOSTILE})
        for name in HOSTILE:
            document = self.soakd.get("unit", unit=name)
            check_schema(document, "http-unit")
            self.assertEqual((document["unit"], document["runs"], document["model"]), (name, 1, None))
            self.assertEqual(self.soakd.refusal("jobs", kind="verify", unit=name, campaign=name), (400, "unit"), "no model")
        # Those that soak itself may take for something else: the unit is found, and refused for what it lacks.
        for name in HOSTILE[2:]:
            job = self.soakd.ended(self.soakd.post("jobs", kind="report", unit=name, user="Eva"))
            self.assertEqual((job["state"], job["exit_status"]), ("failed", 2), job)
            self.assertIn("has no model yet", job["message"])
        job = self.soakd.ended(self.soakd.post("jobs", kind="export", unit="../x", format="kalibr", user="Eva"))
        self.assertEqual(job["state"], "failed")
        self.assertEqual(list(self.soakd.folder.rglob("x.yaml")), [])

    def test_a_signature_needs_a_key_and_a_file_that_takes_one(self):
        refused = self.soakd.refusal
        check_schema(self.soakd.get("key"), "http-key")
        self.assertEqual(self.soakd.get("key"), {"key": None})
        self.assertEqual(refused("jobs", kind="export", unit=SERIAL, format="blob", sign=True), (400, "sign"))
        self.assertEqual(refused("key/new", comment="two\nlines", user="Eva"), (400, "comment"))
        made = self.soakd.post("key/new", comment="Laboratory 1", user="Eva")
        check_schema(made, "http-key")
        self.assertEqual(self.soakd.get("key"), made)
        self.assertEqual((self.soakd.data / "station.key").stat().st_mode & 0o777, 0o600)
        self.assertNotIn((self.soakd.data / "station.key").read_text(encoding="utf-8").splitlines()[1], json.dumps(made))
        self.assertEqual(refused("key/new", comment="another", user="Eva"), (409, "state"))
        for other in ({"kind": "export", "format": "c"}, {"kind": "fit"}):
            self.assertEqual(refused("jobs", unit=SERIAL, sign=True, **other), (400, "sign"))
        self.assertEqual(refused("jobs", kind="export", unit=SERIAL, format="blob", sign="yes"), (400, "sign"))
        self.assertIn(("key_made", made["key"]["key_id"], "Eva"), self.soakd.query("SELECT kind, subject, user FROM event"))

    def test_what_is_no_job_is_refused(self):
        refused = self.soakd.refusal
        self.assertEqual(refused("jobs", kind="rm", unit=SERIAL), (400, "kind"))
        self.assertEqual(refused("jobs", kind="fit", unit="SN9"), (400, "unit"))
        self.assertEqual(refused("jobs", kind="fit", unit=""), (400, "unit"))
        self.assertEqual(refused("jobs", kind="fit"), (400, "unit"))
        self.assertEqual(refused("jobs", kind="fit", unit=SERIAL, arguments=["--all"]), (400, "arguments"))
        self.assertEqual(refused("jobs", kind="verify", unit=SERIAL), (400, "campaign"))
        self.assertEqual(refused("jobs", kind="export", unit=SERIAL, format="exe"), (400, "format"))
        self.assertEqual(refused("jobs", kind="export", unit=SERIAL, format="blob", simulated="yes"), (400, "simulated"))
        self.assertEqual(refused("jobs/cancel", id=999), (400, "id"))
        for path in ("job?id=999", "job?id=x", "job?id=1&id=2", "job/file?id=999", "unit?unit=SN9", "unit", "units?x=1"):
            with self.assertRaises(urllib.error.HTTPError) as refusal:
                urllib.request.urlopen(f"{self.soakd.url}api/v1/{path}", timeout=30)
            self.assertEqual(refusal.exception.code, 400, path)
            check_schema(json.load(refusal.exception), "error")

    def test_a_job_is_a_process_apart_that_a_cancel_ends_and_a_stopped_soakd_takes_along(self):
        job = self.soakd.post("jobs", kind="fit", unit=SERIAL, user="Eva")
        child = self.soakd.held_child()
        self.assertEqual(os.getpriority(os.PRIO_PROCESS, child), 10)
        files = [os.readlink(link) for link in pathlib.Path(f"/proc/{child}/fd").iterdir()]
        self.assertEqual([name for name in files if "socket" in name or "soakd" in name or "eventfd" in name], [])
        self.assertEqual(self.soakd.refusal("jobs", kind="fit", unit=SERIAL), (409, "state"))
        ended = self.soakd.post("jobs/cancel", id=job["id"], user="Bob")
        self.assertEqual((ended["state"], ended["message"]), ("cancelled", "cancelled by Bob"))
        self.assertFalse(is_alive(child))
        self.assertEqual(self.soakd.refusal("jobs/cancel", id=job["id"]), (409, "state"))
        events = self.soakd.query("SELECT kind, user, text FROM event WHERE subject = 'SIM-0001' ORDER BY ordinal DESC LIMIT 2")
        self.assertEqual(events, [("job_ended", "Bob", "fit: cancelled"), ("job_started", "Eva", "fit")])
        self.soakd.soak("events", "verify")

        self.soakd.post("jobs", kind="fit", unit=SERIAL, user="Eva")
        child = self.soakd.held_child()
        self.soakd.process.terminate()
        self.soakd.process.wait(30)
        self.assertFalse(is_alive(child))
        self.assertEqual(self.soakd.query("SELECT count(*) FROM model"), [(0,)])
        self.soakd.start()  # and what was kept is kept
        kept = self.soakd.get("jobs")
        check_schema(kept, "http-jobs")
        job = kept["jobs"][0]
        self.assertEqual((job["state"], job["message"]), ("cancelled", "soakd was stopped"))

        self.soakd.post("jobs", kind="fit", unit=SERIAL, user="Eva")
        child = self.soakd.held_child()
        self.soakd.process.kill()
        self.soakd.process.wait(30)
        end = time.monotonic() + 10
        while is_alive(child):
            self.assertLess(time.monotonic(), end, "the job outlives a killed soakd")
            time.sleep(0.01)
        self.soakd.start()
        self.assertEqual(self.soakd.get("jobs")["jobs"][0]["message"], "soakd ended meanwhile")


class Page(BrowserTest, WithStation):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()

    def open_unit(self, serial):
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#{urllib.parse.urlencode({'unit': serial})}")
        self.browser.wait("return !document.querySelector('#unit-work').hidden")
        # Whoever leaves the page while it waits for an answer has a warning in the console.
        self.browser.wait("return document.querySelector('#unit-jobs').ariaBusy === 'false'")

    def click(self, button):
        self.browser.wait("return !document.querySelector(arguments[0]).disabled", button)
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", button)
        self.browser.click(button)

    def sign_in_the_browser(self):
        """A key of the station, and a calibration file with its signature, which soak finds good with the public key that the page gave."""
        self.click("#to-records")
        self.browser.wait("return document.querySelector('#key-comment').offsetParent")
        self.browser.type("#key-comment", "Laboratory 1")
        self.click("#key-form button")
        self.see("#key-text", "Laboratory 1, key ")
        key = self.soakd.get("key")["key"]["key_id"]
        self.browser.click("#key-text a")
        public = self.soakd.folder / "lab.pub"
        public.write_bytes(self.browser.downloaded(f"{key}.pub"))
        self.open_unit(SERIAL)
        self.see("#unit-sign-text", f"Sign it with key {key}")
        self.browser.run("const s = document.querySelector('#unit-format'); s.value = 'blob'; s.dispatchEvent(new Event('change'));")
        for choice in ("#unit-simulated", "#unit-sign", "#unit-export"):
            self.click(choice)
        self.see("#unit-jobs li:first-child", f"signed with key {key}")
        self.see("#unit-badges", "released")
        self.browser.click("#unit-jobs li:first-child a")
        signed = self.soakd.folder / "signed.soakcal"
        signed.write_bytes(self.browser.downloaded("SIM-0001.soakcal"))
        self.assertEqual(self.soakd.soak_json("key", "verify", str(signed), "--key", str(public))["key_id"], key)

    def expect_the_impact_of(self, unit):
        """Metres to two digits, as the document has them."""
        rows = "return [...document.querySelectorAll('#unit-impact tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))"
        self.browser.wait(f"return (() => {{ {rows} }})().length === 6")
        shown = self.browser.run(rows)
        model = self.soakd.get("unit", unit=unit)["model"]
        for row, sensor in zip(shown, model["impact"]["free_inertial"], strict=True):
            self.assertEqual(row[0], sensor["sensor"].replace("_", " "))
            metres = [sensor[f"after_{seconds}_s_m"][which] for seconds in (30, 60) for which in ("without", "with")]
            for text, value in zip(row[3:], metres, strict=True):
                self.assertAlmostEqual(float(text.removesuffix(" m")), value, delta=0.06 * value)
        answer = self.soakd.get("impact", unit=unit)
        check_schema(answer, "http-impact")
        self.assertEqual(answer["model"], model["version"])
        drives = answer["impact"]["drives"]
        for which in ("without", "with"):
            self.see("#unit-drives", f"{drives[which]['horizontal_final_m']['value']:.1f} m")
        self.see("#unit-drives", f"{drives['outages']} outages")

    @long_test
    def test_metres_of_a_unit_without_a_model_are_refused(self):
        with self.assertRaises(urllib.error.HTTPError) as refused:
            self.soakd.get("impact", unit=HOSTILE[0])
        self.assertEqual(refused.exception.code, 400)
        self.assertIn("no model yet", json.loads(refused.exception.read())["error"]["message"])

    def px4_says_what_its_cubic_loses(self):
        self.browser.run("const s = document.querySelector('#unit-format'); s.value = 'px4'; s.dispatchEvent(new Event('change'));")
        self.see("#unit-ids-none", "Without it the parameters do nothing")
        self.browser.type("#unit-ids", "12,x")
        self.click("#unit-export")
        self.see("#job-failure", "one or two whole numbers")
        self.browser.run("document.querySelector('#unit-ids').value = arguments[0]", "1310988, 77")
        self.click("#unit-export")
        self.click("#sure-send")
        self.see("#unit-jobs li:first-child", "as PX4 parameters")
        self.browser.wait("return document.querySelector('#unit-jobs li:first-child details')")
        [job] = [job for job in self.soakd.get("jobs")["jobs"] if job["format"] == "px4"]
        most = max(round(100 * loss["beyond_ci95"]) for loss in job["result"]["cubic"].values())
        self.see("#unit-jobs li:first-child summary", f"leaves the 95 % band of the curve in up to {most} % of the range" if most else "The cubic")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#unit-jobs li:first-child tbody tr').length"), 6)
        content = urllib.request.urlopen(f"{self.soakd.url}api/v1/job/file?id={job['id']}").read().decode()
        self.assertIn("TC_A0_ID\t1310988", content)
        self.assertIn("TC_G0_ID\t77", content)
        self.assertNotIn("No device id was given", content)

    def test_a_unit_is_fitted_judged_and_handed_over_by_clicks(self):
        self.browser.go(self.soakd.url)
        loaded = self.browser.run("return performance.getEntriesByType('resource').map(({ name }) => name)")
        self.assertTrue(any("app.mjs" in name for name in loaded))
        self.assertEqual([name for name in loaded if re.search("unit_view|impact_card", name)], [], "with the first view")
        self.browser.click("#to-units")
        self.see("#units-list", HOSTILE[0])
        self.assertEqual(self.browser.run("return document.querySelector('#to-units').ariaCurrent"), "page")
        self.browser.type("#units-find", SERIAL)
        self.browser.wait("return document.querySelectorAll('#units-list tbody tr').length === 1")
        self.see("#units-list tbody", "NOT JUDGED")
        self.browser.click("#units-list tbody a")
        self.see("#unit-title", SERIAL)
        self.see("#unit-verdict", "NOT JUDGED")
        self.see("#unit-next", "Fit it.")
        self.browser.type("#user", "Eva")
        self.click("#unit-fit")
        self.browser.wait("return document.querySelectorAll('#unit-curves .sensor').length === 6")
        self.see("#unit-next", "Verify it with a run that the fit has not seen.")
        self.see("#unit-verdict", "NOT JUDGED")
        self.see("#unit-badges", "SIMULATED")
        self.see("#unit-badges", "fitted")
        self.see("#unit-warnings", "simulated")
        self.see("#unit-release-why", "never verified")
        self.assertTrue(self.browser.run("return document.querySelector('#unit-release').disabled"))
        bands = self.browser.run("return document.querySelectorAll('#unit-curves figure[data-shows=bias] svg .band.ci95').length")
        self.assertEqual(bands, 6)
        self.expect_the_impact_of(SERIAL)

        self.click("#unit-verify")
        self.see("#unit-verdict", "PASS")
        self.see("#unit-verdict", "campaign verification, by Eva")
        self.see("#unit-next", "Release it.")
        self.see("#unit-curves .sensor", "PASS")

        self.click("#unit-report")
        self.see("#unit-jobs", "Download SIM-0001.html")
        self.browser.click("#unit-jobs a[download='SIM-0001.html']")
        self.assertIn(b"<title>", self.browser.downloaded("SIM-0001.html"))

        self.click("#unit-export")
        self.see("#job-failure", "Tick “Although model 1 is of SIMULATED data”")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "unit-simulated")
        self.click("#unit-simulated")
        for form, name in (("blob", "SIM-0001.unreleased.soakcal"), ("c", "SIM-0001.unreleased.h")):
            self.browser.run("const s = document.querySelector('#unit-format'); s.value = arguments[0];", form)
            self.click("#unit-export")
            self.see("#sure-title", "Export model 1, which is not released?")
            self.click("#sure-send")
            self.browser.wait("return document.querySelector(arguments[0])", f"#unit-jobs a[download='{name}']")
            self.browser.click(f"#unit-jobs a[download='{name}']")
            content = self.browser.downloaded(name)
            path = self.soakd.folder / name
            self.soakd.soak("export", "--unreleased", "--unit", SERIAL, "--format", form, "--simulated", "-o", path)
            self.assertEqual(content, path.read_bytes())
        self.px4_says_what_its_cubic_loses()
        self.see("#unit-next", "Release it.")
        self.see("#unit-jobs li:first-child", "Made from model 1.")
        self.click("#unit-release")
        self.see("#unit-badges", "released")
        self.see("#unit-jobs", f"Release: unit {SERIAL}, model 1")
        self.see("#unit-jobs li:nth-child(2)", "Made from model 1 before that was released")
        self.see("#unit-next", "Export it.")  # the files that there are say that they are not released
        self.assertEqual(self.soakd.query("SELECT user FROM event WHERE kind = 'model_released' AND subject = 'SIM-0001'"), [("Eva",)])
        self.sign_in_the_browser()
        self.browser.run("const s = document.querySelector('#unit-format'); s.value = 'kalibr'; s.dispatchEvent(new Event('change'));")
        self.browser.wait("return document.querySelector('#unit-sign-box').hidden")
        self.click("#unit-export")  # values of the noise say nothing of what was handed over
        self.see("#unit-jobs li:first-child", "Kalibr")
        self.see("#unit-next", "verified, released and exported")
        self.assertEqual(self.browser.console(), [])

        self.assertEqual(self.soakd.refusal("jobs", kind="verify", unit=SERIAL, campaign="default"), (400, "campaign"), "its own runs")
        self.soakd.soak("fit", "--unit", SERIAL)  # by somebody at a terminal
        self.assertIsNone(self.listed_verdict(SERIAL))
        self.open_unit(SERIAL)
        self.see("#unit-verdict", "fitted again since")
        self.see("#unit-jobs li:nth-child(2)", "Made from model 1; the newest is 2.")
        self.assertIsNone(self.soakd.get("unit", unit=SERIAL)["exported"])

    def test_a_verdict_goes_with_what_it_stands_on(self):
        self.soakd.limits(LIMITS.replace("0.5", "0.000001"))
        self.addCleanup(self.soakd.limits, LIMITS)
        self.soakd.soak("fit", "--unit", OTHER)
        self.open_unit(OTHER)
        self.click("#unit-verify")
        self.see("#unit-verdict", "FAIL")
        self.see("#unit-verdict", "gyro x")
        self.see("#unit-next", "Do not hand it over")
        self.assertEqual(self.listed_verdict(OTHER), "fail")
        self.soakd.soak("runs", "void", "--unit", OTHER, "--campaign", "verification", "--reason", "fixture slipped", self.run_of(OTHER))
        self.open_unit(OTHER)
        self.see("#unit-verdict", "NOT JUDGED")
        self.see("#unit-verdict", "does not hold any more: data of its campaign were withdrawn since. It was FAIL")
        self.assertIsNone(self.listed_verdict(OTHER))

    def test_a_grave_warning_of_the_verification_comes_first_and_keeps_the_unit_from_being_handed_over(self):
        lab = stored_units() / "lab"
        for campaign, procedure in (("campaign", "import"), ("verification", "verification")):
            self.soakd.soak("import", lab / campaign / f"{SERIAL}.csv", "--unit", "WARNED", "--campaign", campaign, "--procedure", procedure, "--simulated",
                            "--gravity-mps2", "9.80665")
        for job in ({"kind": "fit"}, {"kind": "verify", "campaign": "verification"}):
            done = self.soakd.ended(self.soakd.post("jobs", unit="WARNED", user="Eva", **job))
            self.assertEqual(done["state"], "done", done)
        # Bands of three runs are too wide for one fresh run to leave them: the warning is put into what soak said.
        self.soakd.process.terminate()
        self.soakd.process.wait(30)
        path = self.soakd.data / "jobs" / str(done["id"]) / "job.json"
        done["result"]["warnings"] = [{"code": "partial_range", "text": "a part only"}, {"code": "band_too_narrow", "text": "twice the band"}]
        path.write_text(json.dumps(done), encoding="utf-8")
        self.soakd.start()
        document = self.soakd.get("unit", unit="WARNED")
        check_schema(document, "http-unit")
        self.assertEqual(document["verification"]["job"]["result"]["verdict"], "pass")
        warned = {warning["code"]: warning for warning in document["verification"]["warnings"]}
        self.assertEqual(warned["band_too_narrow"]["urgency"], "grave")
        self.assertIn("Rely on the errors of the fresh runs", warned["band_too_narrow"]["remedy"])
        self.open_unit("WARNED")
        self.see("#unit-verdict", "PASS")
        self.see("#unit-next", "Do not hand it over")
        shown = self.browser.run("return [...document.querySelectorAll('#unit-warnings li')].map((line) => [line.dataset.urgency, line.innerText])")
        urgencies = [urgency for urgency, _ in shown]
        self.assertEqual(urgencies, sorted(urgencies, key=["grave", "act", "none"].index))
        self.assertTrue(any("band_too_narrow" in text and "Rely on" in text for _, text in shown), shown)
        self.soakd.soak("fit", "--unit", "WARNED")  # of a verification that does not hold nothing is warned
        self.assertEqual(self.soakd.get("unit", unit="WARNED")["verification"]["warnings"], [])

    def listed_verdict(self, serial):
        return next(unit["verdict"] for unit in self.soakd.get("units")["units"] if unit["unit"] == serial)

    def run_of(self, serial):
        return next(run["run_id"] for run in self.soakd.get("runs", unit=serial, campaign="verification")["runs"])

    def test_a_job_is_cancelled_and_one_that_fails_says_why(self):
        self.open_unit(OTHER)
        self.click("#unit-fit")
        self.soakd.held_child()
        self.see("#job-running-text", f"Fitting: unit {OTHER}, all runs for calibration; for ")
        self.assertTrue(self.browser.run("return document.querySelector('#job-progress').checkVisibility()"))
        self.click("#unit-cancel")
        self.see("#unit-jobs li", "cancelled by")
        self.assertTrue(self.browser.run("return document.querySelector('#job-running').hidden"))
        self.open_unit("--help")
        self.see("#unit-title", "--help")
        self.click("#unit-fit")
        self.see("#unit-jobs li", "failed")
        self.assertIn("run r1", self.browser.text("#unit-jobs li"))
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_verification_is_offered_once_its_campaign_is_over(self):
        """The real station's documents, but that its status tells of a campaign that still runs."""
        lab = stored_units() / "lab"
        for campaign, procedure in (("campaign", "import"), ("verification", "verification")):
            self.soakd.soak("import", lab / campaign / f"{OTHER}.csv", "--unit", "CHECKED", "--campaign", campaign, "--procedure", procedure, "--simulated",
                            "--gravity-mps2", "9.80665")
        self.soakd.soak("fit", "--unit", "CHECKED", "--rules", "2")
        script = """
          window.campaign = "verification";
          const read = JSON.parse;
          const listen = EventSource.prototype.addEventListener;
          EventSource.prototype.addEventListener = function (kind, listener) {
            listen.call(this, kind, listener);
            if (kind === "status") window.tell = (data) => listener({ data });
          };
          JSON.parse = (text, ...more) => {
            const value = read(text, ...more);
            if (value?.clock && value.state) window.said = text;
            if (value?.clock && value.state && window.campaign) Object.assign(value, { state: "running", campaign: { name: window.campaign, procedure: "verification",
              purpose: "verification", run_label: "V02", run: 3, runs: 4, step: 0, steps: 1, step_kind: "record", step_text: "records", step_trouble: null, on_way_back: false,
              progress: 0.5, remaining_s: 100, started_utc_s: 1 } });
            if (value?.clock && value.state && window.stopped) Object.assign(value, { state: "interrupted", campaign: null, resumable: window.stopped, resumes_by_itself: false });
            return value;
          };
          const ask = window.fetch;
          const plan = { procedure: {}, runs: [true, false, false, false].map((preflight) => ({ preflight })), steps: [], estimate_s: 1 };
          window.fetch = (path, ...more) => (String(path).includes("/plan?") && window.campaign ? Promise.resolve(new Response(JSON.stringify(plan), { headers: { "Content-Type": "application/json" } })) : ask(path, ...more));
        """
        added = self.browser.devtools("Page.addScriptToEvaluateOnNewDocument", source=script)
        self.addCleanup(self.browser.devtools, "Page.removeScriptToEvaluateOnNewDocument", **added)
        self.open_unit("CHECKED")
        self.see("#unit-next", "Wait: campaign verification still runs, 1 of 3 check runs recorded.")
        self.see("#unit-campaign", "verification (still running: 1 of 3 runs recorded)")
        self.assertEqual(self.browser.run("const b = document.querySelector('#unit-verify'); return [b.disabled, b.classList.contains('primary')]"), [False, False])
        self.browser.run("window.campaign = null; window.stopped = 'verification'; window.tell(window.said)")
        self.see("#unit-next", "Campaign verification has stopped, 1 of 3 check runs recorded: resume it on Station.")
        self.see("#unit-campaign", "verification (stopped: 1 of 3 runs recorded)")
        self.browser.run("window.stopped = null; window.tell(window.said)")
        self.see("#unit-next", "Verify it with a run that the fit has not seen.")
        self.assertTrue(self.browser.run("return document.querySelector('#unit-verify').classList.contains('primary')"))
        # Who comes after it stopped learns how many runs it has once it goes on.
        self.browser.run("window.stopped = 'verification'; window.tell(window.said)")
        self.see("#unit-next", "has stopped, 1 check run recorded")
        self.browser.run("window.stopped = null; window.campaign = 'verification'; window.tell(window.said)")
        self.see("#unit-next", "Wait: campaign verification still runs, 1 of 3 check runs recorded.")

    @long_test
    def test_an_older_version_lies_beside_the_newest_on_the_same_axes(self):
        self.soakd.soak("fit", "--unit", OTHER)
        runs = self.soakd.get("runs", unit=OTHER, campaign="campaign")["runs"]
        self.soakd.soak("runs", "void", runs[0]["run_id"], "--unit", OTHER, "--reason", "test", "--user", "Eva")
        self.soakd.soak("fit", "--unit", OTHER)
        newest = self.soakd.get("unit", unit=OTHER)["model"]
        older = self.soakd.get("model", unit=OTHER, version=newest["version"] - 1)
        check_schema(older, "http-model")
        self.assertNotEqual(older["model"]["sensors"]["gyro_x"]["curve"], newest["sensors"]["gyro_x"]["curve"])
        self.open_unit(OTHER)
        self.browser.wait("return document.querySelectorAll('#unit-curves .sensor').length === 6")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#unit-curves .older').length"), 0)
        self.browser.run("""const choice = document.querySelector('#unit-older'); choice.value = arguments[0];
            choice.dispatchEvent(new Event('change'));""", str(older["model"]["version"]))
        self.browser.wait("return document.querySelectorAll('#unit-curves figure[data-shows=bias] svg .line.older').length === 6")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#unit-curves figure[data-shows=bias] svg .band.older').length"), 6)
        self.see("#unit-curves .sensor .legend", f"model {older['model']['version']}")
        curves = [model["sensors"]["accel_x"]["curve"] for model in (newest, older["model"])]
        if [point["temp_c"] for point in curves[0]] == [point["temp_c"] for point in curves[1]]:
            most = max(zip(*curves), key=lambda pair: abs(pair[0]["bias"] - pair[1]["bias"]))
            self.see("#unit-sensors .difference", f" m/s² at {most[0]['temp_c']:.0f} °C".replace("-", "−"))
        self.see("#unit-sensors .difference", "Bias: Largest difference between the two: ")
        ways = self.browser.run("""return ['.line.curve', '.line.older'].map((style) =>
            document.querySelector(`#unit-sensors > :nth-child(1) svg ${style}`).getAttribute('d').slice(1).split('L').map((p) => p.split(' ').map(Number)))""")
        drawn = [[point for point in model["sensors"]["accel_x"]["curve"]] for model in (newest, older["model"])]
        # Pixels are one affine function of temperature and bias for both: found from the newest, it gives the other.
        for axis, key in ((0, "temp_c"), (1, "bias")):
            low, high = (pick(range(len(drawn[0])), key=lambda i: drawn[0][i][key]) for pick in (min, max))
            scale = (ways[0][high][axis] - ways[0][low][axis]) / (drawn[0][high][key] - drawn[0][low][key])
            for way, point in zip(ways[1], drawn[1], strict=True):
                self.assertAlmostEqual(way[axis], ways[0][low][axis] + scale * (point[key] - drawn[0][low][key]), delta=0.5)  # rounded to 0.1 of a pixel
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_version_that_cannot_be_had_is_told_of_that_choice_alone(self):
        while (self.soakd.get("unit", unit=OTHER)["model"] or {"version": 0})["version"] < 2:
            self.soakd.soak("fit", "--unit", OTHER)
        self.open_unit(OTHER)
        self.browser.wait("return document.querySelectorAll('#unit-older option').length > 1")
        self.browser.run("""const real = window.fetch;
            window.fetch = (...asked) => (String(asked[0]).includes('model?') ? new Promise((done, fail) => (window.lose = () => fail(new TypeError('lost')))) : real(...asked));""")
        choose = "const choice = document.querySelector('#unit-older'); choice.value = arguments[0]; choice.dispatchEvent(new Event('change'));"
        failed = "return !document.querySelector('#unit-older-failure').hidden"
        self.browser.run(choose, "1")
        self.browser.run("window.lose()")
        self.browser.wait(failed)
        self.browser.run(f"location.hash = 'unit={SERIAL}'")
        self.see("#unit-title", SERIAL)
        self.assertFalse(self.browser.run(failed), "of another unit")
        self.browser.run(f"location.hash = 'unit={OTHER}'")
        self.browser.wait("return document.querySelectorAll('#unit-older option').length > 1 && document.querySelector('#unit-curves').hidden === false")
        self.browser.run(choose, "1")
        self.browser.run(choose, "")
        self.browser.run("window.lose(); return new Promise(requestAnimationFrame);")  # whatever follows from a refusal is done before the next frame
        self.assertFalse(self.browser.run(failed), "of a choice that was taken back")

    @long_test
    def test_a_version_that_there_is_not_is_refused(self):
        newest = self.soakd.get("unit", unit=OTHER)["model"]
        instead = f"its newest is {newest['version']}" if newest else "it has none yet"
        for serial, version, where, says in ((OTHER, "0", "version", "from 1 on"), (OTHER, "99", "version", instead), (OTHER, "x", "version", "from 1 on"),
                                             ("nobody", "1", "unit", "/api/v1/units")):
            with self.assertRaises(urllib.error.HTTPError) as refused:
                self.soakd.get("model", unit=serial, version=version)
            error = json.load(refused.exception)["error"]
            self.assertEqual((refused.exception.code, error["where"]), (400, where))
            self.assertIn(says, error["message"])

    def test_names_are_text(self):
        for name in HOSTILE:
            self.open_unit(name)
            self.see("#unit-title", name)
            self.assertEqual(self.browser.run("return document.querySelector('main script')"), None)
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#unit=nobody")
        self.see("#unit-failure", "there is no such unit")
        self.assertEqual([line for line in self.browser.console() if "400" not in line], [])

    def test_every_width_and_both_schemes_can_be_read(self):
        if self.soakd.get("unit", unit=OTHER)["model"] is None:
            self.soakd.soak("fit", "--unit", OTHER)
        for width in (320, 390, 768, 1280, 1920):
            self.browser.resize(width, 900)
            self.browser.go("about:blank")
            self.browser.go(f"{self.soakd.url}#units")
            self.browser.wait("return document.querySelector('#units-list tbody tr')")
            wide = "return document.documentElement.scrollWidth - innerWidth"
            self.assertLessEqual(self.browser.run(wide), 0, f"list at {width}")
            self.open_unit(OTHER)
            self.assertLessEqual(self.browser.run(wide), 0, f"unit at {width}")
        self.browser.run("document.querySelector('#unit-warnings-rest').open = true")
        self.addCleanup(self.browser.colours, "light")
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            self.assertEqual(self.browser.poor_contrast(), [], scheme)
        nameless = self.browser.run("""
          return [...document.querySelectorAll("a, button, input, select, summary, [tabindex], svg[role=img]")].filter((node) => node.getClientRects().length)
            .filter((node) => !(node.ariaLabel || node.innerText?.trim() || node.labels?.length || node.getAttribute("aria-labelledby")))
            .map((node) => node.outerHTML)""")
        self.assertEqual(nameless, [])
        ids = self.browser.run("return [...document.querySelectorAll('[id]')].map((node) => node.id)")
        self.assertEqual(len(ids), len(set(ids)), "ids are unique")


if __name__ == "__main__":
    unittest.main()
