# SPDX-License-Identifier: Apache-2.0
"""Every command on the pages of docs/ and in the README is carried out, in the order of its page, in a folder that holds what the
page takes for granted: a unit with stored runs and a model, its files, or a (simulated) laboratory. Each must end with status 0.

What a test cannot have is replaced: addresses of chambers by those of the simulated one, whole campaigns by one of minutes.
A page that shows commands and has no test here fails the last test. `./run` itself is what tools/prove/bare-machine runs.
"""
import http.server
import json
import os
import pathlib
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "cli"), str(ROOT / "tests" / "lab")]
import drive_files  # noqa: E402
import hand_session  # noqa: E402
from short_procedure import short_procedure  # noqa: E402
from soak_cli import recording  # noqa: E402

BIN = pathlib.Path(os.environ["SOAK_BIN_FOLDER"])
PROGRAMS = ("soak", "soakd", "soaksim", "soaksim-campaign", "soaksim-truth")
SHORT = short_procedure((10, 17, 24, 31, 38), positions=("+X", "-X", "+Y", "-Y", "+Z", "-Z"))
LIMITS = "[limits]\ngyro = 10.0\naccel = 10.0\naccel_scale_ppm = 100000\n"


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def commands_of(page, programs=PROGRAMS):
    """The command lines of a page's indented blocks, without comments, lines that end in a backslash joined."""
    found, held = [], ""
    for line in page.read_text(encoding="utf-8").splitlines():
        if not line.startswith("    "):
            held = ""
            continue
        text = re.sub(r"\s+#( .*)?$", "", line).strip()
        text = held + text
        if text.endswith("\\"):
            held = text[:-1]
            continue
        held = ""
        if text.split(" ")[0] in programs and "COMMAND" not in text:
            found.append(re.sub(r" \[[^]]*\]", "", text))
    return found


class Page(unittest.TestCase):
    """Base of all pages: `folder` is where its commands run, `replaced` what stands in for what a test cannot have."""
    def setUp(self):
        folder = tempfile.mkdtemp(prefix="soak-docs-")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        self.folder = pathlib.Path(folder)
        for name in ("procedures", "hal", "docs"):
            (self.folder / name).symlink_to(ROOT / name)
        (self.folder / "short.toml").write_text(SHORT, encoding="utf-8")
        (self.folder / "limits.toml").write_text(LIMITS, encoding="utf-8")
        self.env = {**os.environ, "SOAK_DATA": str(self.folder / "data"), "XDG_DATA_HOME": str(self.folder / "xdg"),
                    "PATH": f"{BIN}:/usr/bin:/bin"}
        self.replaced = [(r"campaign start procedures/[\w-]+\.toml", "campaign start short.toml"), (r" &$", "")]
        self.campaign_runs = False

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")

    def run_line(self, line, status=0):
        done = subprocess.run(line, shell=True, executable="/bin/bash", cwd=self.folder, env=self.env, capture_output=True, text=True,
                              timeout=300, check=False)
        self.assertEqual(done.returncode, status, f"{line}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def begin(self, line):
        """Starts a program that goes on; returns the first line that it prints."""
        process = subprocess.Popen(shlex.split(line), cwd=self.folder, env=self.env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                   text=True)
        self.addCleanup(self.end, process)
        first = process.stdout.readline()
        self.assertTrue(first, line)
        return first

    @staticmethod
    def end(process):
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
        process.stdout.close()

    def laboratory(self, *options):
        """A simulated laboratory for this page; its addresses."""
        addresses = json.loads(self.begin(shlex.join(["soaksim", "--out", "lab", "--rate", "max", "--maps", str(ROOT / "procedures"), *options])))
        shutil.copy(self.folder / "lab" / "station.toml", self.folder / "station.toml")
        return addresses

    def unit(self, serial, runs=3, seconds=30):
        """A unit with stored runs R01, R02 ... and a model."""
        for number in range(1, runs + 1):
            name = f"R{number:02}"
            self.write(f"{serial}-{name}.csv", recording(number, name, (-20.0, 0.0, 20.0, 40.0), seconds))
            self.run_line(f"soak import {serial}-{name}.csv --unit {serial} --campaign first --gravity-mps2 9.80665")
        self.run_line(f"soak fit --unit {serial}")

    def released(self, serial):
        """The unit's model, verified against a fresh run and released."""
        self.write(f"{serial}-fresh.csv", recording(9, "F01", (-18.0, 2.0, 22.0, 38.0), 30))
        self.run_line(f"soak import {serial}-fresh.csv --unit {serial} --campaign fresh --procedure verification --gravity-mps2 9.80665")
        self.run_line(f"soak verify --unit {serial} --campaign fresh --limits limits.toml")
        self.run_line(f"soak release --unit {serial}")

    def still(self, seconds=2000, rate_hz=10):
        """An hour at rest, as CSV."""
        noise = random.Random(5)
        lines = ["t_s,run,plateau_c,position,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2"]
        for i in range(seconds * rate_hz):
            values = [noise.gauss(0, 0.05) for _ in range(3)] + [noise.gauss(0, 0.01) for _ in range(2)] + [9.80665 + noise.gauss(0, 0.01)]
            lines.append(f"{i / rate_hz:.3f},still,25,+Z,{25 + noise.gauss(0, 0.01):.3f}," + ",".join(f"{v:.6f}" for v in values))
        return "\n".join(lines) + "\n"

    def carry_out(self, name, skip=(), only=None, extra=None):
        """All commands of a page. `skip`: those that contain one of these; `extra`: {part of a command: what to do before it}."""
        page = ROOT / name
        for line in commands_of(page):
            if any(part in line for part in skip) or (only and not any(part in line for part in only)):
                continue
            for pattern, text in self.replaced:
                line = re.sub(pattern, text, line)
            for part, action in (extra or {}).items():
                if part in line:
                    action()
            with self.subTest(command=line):
                self.carry_out_line(line)

    def carry_out_line(self, line):
        if line.startswith("soaksim "):
            self.laboratory()
            return
        if line.startswith("soakd "):
            page = self.begin(line + " --listen 127.0.0.1:0")
            self.env["SOAK_STATION"] = re.search(r"//([^/\s]+)", page).group(1)
            data = re.search(r"--data (\S+)", line)
            self.env["SOAK_DATA"] = str(self.folder / (data.group(1) if data else "data"))
            return
        if self.campaign_runs and not line.startswith("soak campaign watch"):
            self.run_line("soak campaign watch")
        self.campaign_runs = line.startswith("soak campaign start")
        self.run_line(line)


class Readme(Page):
    def test_own_laboratory(self):
        addresses = self.laboratory()
        self.replaced += [(r"--tcp 192\.168\.7\.20", f"--tcp 127.0.0.1:{addresses['chamber']}")]
        self.carry_out("README.md", skip=["SN0042"])

    def test_own_recording(self):
        runs = [recording(n, f"R{n:02}", (-20.0, 0.0, 20.0, 40.0), 30) for n in (1, 2, 3)]
        self.write("runs.csv", runs[0] + "".join(run.split("\n", 1)[1] for run in runs[1:]))
        self.write("check.csv", recording(9, "C01", (-18.0, 2.0, 22.0, 38.0), 30))

        def check():
            self.run_line("soak import check.csv --unit SN0042 --campaign check --procedure verification --gravity-mps2 9.80665")
        self.carry_out("README.md", only=["SN0042"], extra={"soak verify": check})


class Access(Page):
    def test_access(self):
        """From a pipe in place of the terminal."""
        self.replaced += [(r"^(soak user (?:add|password) .*)$", r"echo 'a long password' | \1")]
        self.carry_out("docs/access.md")


class Bench(Page):
    def test_bench(self):
        self.write("session.csv", hand_session.attitudes())
        self.write("check.csv", hand_session.attitudes(seed=2))
        self.carry_out("docs/bench.md", skip=["soak runs void RUN"])


class Campaigns(Page):
    def test_campaigns(self):
        self.carry_out("docs/campaigns.md")


class ChamberHours(Page):
    def test_chamber_hours(self):
        self.run_line("soak unit add SN0009 --type mti-300")
        self.carry_out("docs/chamber-hours.md")


class CheckStandard(Page):
    def test_check_standard(self):
        self.unit("SN0001")
        self.carry_out("docs/check-standard.md")


class Deployment(Page):
    def test_deployment(self):
        for serial in ("SN-0001", "SN0042"):
            self.unit(serial)
            self.released(serial)
        self.write("still.csv", self.still())
        self.run_line("soak import still.csv --unit SN0042 --campaign rest --procedure verification --gravity-mps2 9.80665")
        axes = "\n".join(f"{i * 10000},0,25.{i % 10},{i % 3 * 0.001},{i % 5 * 0.001},{9.8 + i % 7 * 0.001}" for i in range(1, 400))
        for sensor in ("accel", "gyro"):
            self.write(f"LOG_sensor_{sensor}_0.csv", "timestamp_sample,device_id,temperature,x,y,z\n" + axes + "\n")
        self.write("imu0.csv", "TimeUS,timestamp,T,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n" + "\n".join(
            f"{i * 10000},{1.7e9 + i * 0.01:.2f},25.{i % 10},0.001,{i % 3 * 0.001},0.002,0.1,{i % 5 * 0.001},-9.8" for i in range(1, 400)) + "\n")

        def sign():
            self.run_line("soak key new -o station.key")
            self.run_line("soak key sign SN-0001.soakcal --key station.key")
        self.carry_out("docs/deployment.md", extra={"soak key verify": sign})


class GapWorkflow(Page):
    def test_gap_workflow(self):
        """With the two commands of the page that are no program of ours."""
        text = (ROOT / "docs/gap-workflow.md").read_text(encoding="utf-8")
        block = text[text.index("    { cat hal/sim/lab.toml"):]
        self.run_line("set -e\n" + block[:block.index("\n\n")])
        self.carry_out("docs/gap-workflow.md", skip=["soaksim-campaign", "soak import", "soak fit"])


class Guide(Page):
    def test_guide(self):
        self.write("logger.csv", "time;T;x\n" + "\n".join(f"{i};{20 + i % 3}.5;{i % 7 * 0.1:.1f}" for i in range(200)) + "\n")
        self.write("my-logger.toml", 'separator = ";"\n[columns]\n"time" = "t_s"\n"T" = "temp_c"\n"x" = "gx_dps"\n')
        self.write("still.csv", self.still())

        def own_unit():
            if not (self.folder / "SN0042-R01.csv").exists():
                self.unit("SN0042")
                self.released("SN0042")
                self.run_line("soak import still.csv --unit SN0042 --campaign rest --procedure verification --gravity-mps2 9.80665")
        self.replaced += [("--unit SN0042$", "--unit LOGGED")]
        self.carry_out("docs/guide.md", extra={"--device-id": own_unit})
        kept = sorted(path.name for path in (self.folder / "data" / "runs").glob("*.soakrun"))
        self.assertTrue(kept)
        self.assertEqual(sorted(path.name for path in (self.folder / "station-copy" / "runs").iterdir()), kept)
        self.run_line("soak runs verify --data station-copy")


class Hardware(Page):
    def test_hardware(self):
        f4t = self.laboratory()
        eurotherm = json.loads(self.begin("soaksim --out e --chamber eurotherm-2400"))
        espec = json.loads(self.begin("soaksim --out p --chamber espec-p300"))
        shutil.copy(ROOT / "procedures/chambers/watlow-f4t.toml", self.folder / "my-chamber.toml")
        self.replaced += [(r"192\.168\.7\.20:10001", f"127.0.0.1:{espec['chamber_wire']}"), (r"192\.168\.7\.20", f"127.0.0.1:{f4t['chamber']}"),
                          ("/dev/ttyUSB0", eurotherm["chamber_wire"])]
        self.carry_out("docs/hardware.md")
        self.carry_out("docs/register-maps.md")
        self.doctor()

    def doctor(self):
        """The page shows it with what it prints: the same subjects, each with a standing that the program has."""
        page = (ROOT / "docs/hardware.md").read_text(encoding="utf-8")
        command, sample = re.search(r"^    \$ (soak doctor .*)\n((?:    .*\n)+)", page, re.M).groups()
        done = subprocess.run(shlex.split(command), cwd=self.folder, env=self.env, capture_output=True, text=True, timeout=60, check=False)
        self.assertIn(done.returncode, (0, 2), done.stderr)  # 2: the clock of this computer
        subjects = [re.findall(r"^ *(?:ok|warning|failed) +([a-z]+)(?: \d+)?: ", text, re.M) for text in (sample, done.stdout)]
        self.assertEqual(len(subjects[0]), len(sample.splitlines()) - 1)  # the last one is the error
        self.assertLessEqual(set(subjects[0]), set(subjects[1]))


class Alarms(Page):
    def test_alarms(self):
        """Before a webhook of this machine."""
        got = []

        class Hook(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                got.append(json.loads(self.rfile.read(int(self.headers["Content-Length"])))["title"])
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.laboratory()
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Hook) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            with (self.folder / "station.toml").open("a", encoding="utf-8") as file:
                file.write(f'\n[alarms.webhook]\nurl = "http://127.0.0.1:{server.server_address[1]}/"\n')
            self.replaced += [("/etc/soak/station.toml", "station.toml")]
            self.carry_out("docs/alarms.md")
            server.shutdown()
        self.assertEqual(got, ["a test"])


class HttpApi(Page):
    def test_http_api(self):
        """The event stream, asked for as the page says; by Python, as not everybody has curl."""
        line, = commands_of(ROOT / "docs/http-api.md", ("curl",))
        url = re.search(r"http://127\.0\.0\.1:8088(/\S+)", line)[1]
        self.laboratory()
        self.carry_out_line("soakd --config station.toml --data data")
        with urllib.request.urlopen(f"http://{self.env['SOAK_STATION']}{url}", timeout=60) as answer:
            self.assertEqual(answer.headers.get_content_type(), "text/event-stream")
            self.assertEqual(answer.readline().strip(), b"event: status")
            self.assertTrue(answer.readline().startswith(b"data: {"))


class Nav(Page):
    def test_nav(self):
        self.unit("SN0042")
        drive_files.write_drive(self.folder)
        self.replaced += [("--drives 4", "--drives 1"), ("(nav impact .*)", r"\1 --drives 1")]
        self.carry_out("docs/nav.md")


class Operations(Page):
    def test_operations(self):
        addresses = self.laboratory()
        self.unit("SN0042")
        self.replaced += [("/mnt/backup/soak", "backup"), (r"--tcp 192\.168\.7\.20", f"--tcp 127.0.0.1:{addresses['chamber']}"),
                          ("--campaign spring-2024", "--campaign first")]

        def campaign():
            """One that was paused, so that there is something to go on with."""
            self.run_line("soak campaign start short.toml --name c")
            self.run_line("soak campaign pause")
        self.carry_out("docs/operations.md", skip=["--write-config"], extra={
            "soak campaign resume": campaign, "soak runs verify --data restored": lambda: self.run_line("cp -r backup restored")})
        self.run_line("soakd --write-config > new-station.toml")


class Procedures(Page):
    def test_procedures(self):
        self.carry_out("docs/procedures.md")


class Records(Page):
    def test_records(self):
        self.unit("SN0042", runs=8, seconds=20)
        self.run_line("soak reference add --kind level --name 'level 1' --certificate L-1 --issued 2025-03-01 --due 2026-03-01 --uncertainty 0.01")
        self.replaced += [("--campaign spring-2024", "--campaign first")]
        self.carry_out("docs/records.md")


class ReportPage(Page):
    def test_report(self):
        self.unit("SN0042")
        self.replaced += [("--campaign spring-2027", "--campaign first")]
        self.carry_out("docs/report.md")


class ScaleOut(Page):
    def test_scale_out(self):
        for serial in ("SN0042", "SN0043"):
            self.write(f"{serial}.csv", recording(1, "R01", (-20.0, 0.0, 20.0, 40.0), 30))
            self.run_line(f"soak import {serial}.csv --unit {serial} --campaign first --gravity-mps2 9.80665")
        self.replaced += [("/shared/", "shared-")]
        self.carry_out("docs/scale-out.md")


class Signal(Page):
    def test_signal(self):
        self.write("still.csv", self.still(rate_hz=200, seconds=120))
        self.run_line("soak import still.csv --unit SN0042 --campaign rest --procedure verification --gravity-mps2 9.80665")
        self.replaced += [("--run R01", "--run still")]
        self.carry_out("docs/signal.md")


class WholeDocumentation(unittest.TestCase):
    def test_no_page_with_commands_is_left_out(self):
        source = pathlib.Path(__file__).read_text(encoding="utf-8")
        missing = [str(page.relative_to(ROOT)) for page in pages()
                   if commands_of(page, (*PROGRAMS, "curl", "sqlite3")) and f'"{page.relative_to(ROOT)}"' not in source]
        self.assertEqual(missing, [])


if __name__ == "__main__":
    unittest.main()
