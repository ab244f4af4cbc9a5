# SPDX-License-Identifier: Apache-2.0
"""What the tests of whole campaigns share: a station before a simulated laboratory, short procedures, wires that can be
cut, and a look at the chamber's own registers that does not pass through soakd."""
import contextlib
import json
import pathlib
import re
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
from concurrent.futures import ThreadPoolExecutor

import jsonschema
from fault_proxy import FaultProxy
from modbus_proxy import ModbusProxy
from pymodbus.client import ModbusTcpClient
from short_procedure import short_procedure  # noqa: F401 (the tests take it from here)

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests")]
from long_tests import LONG_TESTS, REASON, long_test  # noqa: E402, F401 (the tests take it from here)
from lab_session import LabSession, ProgramFailed, bin_folder, end  # noqa: E402

OFF, AUTO = 62, 10  # modes of the controller
DEW_POINT_C = 15.0  # that the station assumes
WAIT_S = 300.0  # generous: the machine may be busy
EVENT_S = 60.0  # for which an entry of the journal is waited for
ENDED = ("finished", "failed", "aborted", "interrupted")
AT_ONCE = 4  # campaigns: most of their time is spent waiting for time-outs


class LabTest(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.mkdtemp(prefix="soak-lab-")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        self.folder = pathlib.Path(folder)
        self.lab = None
        self.proxies = {}

    def start_lab(self, units=1, rate=400, seed=1, cut=(), soaksim_options=(), edit=None):
        """Starts both programs. `cut`: wires that shall pass through a FaultProxy: chamber, fixture, power, unit1...
        `edit`: makes another station.toml out of that of soaksim."""
        self.lab = LabSession(self.folder / "lab", seed=seed, units=units, rate=rate)
        self.addCleanup(self.stop_lab)
        pathlib.Path(self.lab.folder).mkdir(parents=True, exist_ok=True)
        self.lab.start_soaksim(*soaksim_options)
        self.config = pathlib.Path(self.lab.folder) / "station.toml"
        for name in cut:
            self.put_proxy(name)
        if edit:
            self.config.write_text(edit(self.config.read_text(encoding="utf-8")), encoding="utf-8")
        self.lab.start_soakd()

    def with_chamber_proxy(self, text):
        """A station.toml whose chamber stands behind `proxy`, which can lie: for `edit` of start_lab."""
        text, self.proxy = self.with_proxy(text, "chamber")
        return text

    def with_proxy(self, text, device):
        """A station.toml whose chamber, fixture or relay stands behind a ModbusProxy, and that."""
        port = self.lab.ports[device]
        proxy = ModbusProxy(port)
        self.addCleanup(proxy.close)
        return re.sub(rf"^port = {port}$", f"port = {proxy.port}", text, flags=re.M), proxy

    def stop_lab(self):
        if self.lab.soakd and self.lab.soakd.poll() is None:
            self.lab.soakd.kill()  # no way to the safe state where only the test has ended
        end(self.lab.soakd)
        end(self.lab.soaksim)
        for proxy in self.proxies.values():
            proxy.close()

    def put_proxy(self, name):
        ports = {"chamber": self.lab.ports["chamber"], "fixture": self.lab.ports["fixture"], "power": self.lab.ports["relay"]}
        ports.update({f"unit{i}": port for i, port in enumerate(self.lab.ports["units"], 1)})
        proxy = self.proxies[name] = FaultProxy(ports[name])
        text = self.config.read_text(encoding="utf-8")
        changed = re.sub(rf"^port = {ports[name]}$", f"port = {proxy.port}", text, flags=re.M)
        self.assertNotEqual(changed, text)
        self.config.write_text(changed, encoding="utf-8")

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def start_campaign(self, procedure, name="c"):
        return self.lab.soak_json("campaign", "start", self.write("procedure.toml", procedure), "--name", name)

    def check_schema(self, document, name):
        schema = json.loads((ROOT / "docs" / "schema" / f"{name}.schema.json").read_text(encoding="utf-8"))
        jsonschema.Draft202012Validator(schema).validate(document)

    def status(self):
        with urllib.request.urlopen(self.lab.page + "api/v1/status", timeout=30) as answer:
            return json.load(answer)

    def wait(self, what, condition, seconds=WAIT_S, lab_s=4.0):
        """Waits until `condition(status)` holds; returns that status. Looks every `lab_s` seconds of the laboratory's clock, which
        is less than most steps take, and no more often than every two milliseconds."""
        end_s = time.monotonic() + seconds
        poll_s = min(max(0.002, lab_s / self.lab.rate), 0.1)
        while not condition(status := self.status()):
            self.assertLess(time.monotonic(), end_s, f"waited for: {what}\n{json.dumps(status, indent=1)}\n{self.lab.log()}")
            time.sleep(poll_s)
        return status

    def wait_for_step(self, kind, run="R01"):
        def there(status):
            campaign = status["campaign"]
            self.assertIn(status["state"], ("preflight", "running", "waiting"), f"before {kind}: {status['reason']}")
            return campaign["step_kind"] == kind and campaign["run_label"] == run
        return self.wait(f"step {kind} of {run}", there, lab_s=4.0 if kind in ("wait_stable", "record") else 0.5)

    def hold(self, held):
        """Time goes on, and the campaign's step and what is left of it stay as `held` has them."""
        self.wait("time goes on", lambda s: s["clock"]["process_s"] > held["clock"]["process_s"] + 200)
        later = self.status()
        for figure in ("step", "remaining_s", "progress"):
            self.assertEqual(later["campaign"][figure], held["campaign"][figure], "nothing comes nearer while it is held")

    def come_nearer(self, held):
        """What was left while the campaign was held is all that there is to do: it never grows afterwards."""
        left_s = []

        def is_beyond(status):
            left_s.append(status["campaign"]["remaining_s"])
            return status["campaign"]["step"] > held["campaign"]["step"] or status["state"] in ENDED

        self.wait("the step after", is_beyond)
        self.assertLessEqual(max(left_s), held["campaign"]["remaining_s"])

    def wait_for_end(self):
        return self.wait("the end", lambda s: s["state"] in ENDED, lab_s=60.0)

    def soak_fails(self, status, *words):
        """The message of a `soak` that must end with that status and print nothing else."""
        result = subprocess.run([bin_folder() + "/soak", *map(str, words), "--json"], env=self.lab.env, capture_output=True,
                                text=True)
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        self.assertEqual(result.stdout, "")
        error = json.loads(result.stderr)["error"]
        return f"{error['where']}: {error['message']}"

    def query(self, sql, *values):
        with contextlib.closing(sqlite3.connect(pathlib.Path(self.lab.data) / "station.db")) as db:
            return db.execute(sql, values).fetchall()

    def events(self):
        return self.query("SELECT kind, subject, text FROM event ORDER BY ordinal")

    def assert_event(self, kind, subject, *data):
        """The log has an event of that kind about that subject with all of `data` in its text: serial numbers, positions,
        numbers. How it is worded is not judged. The catalog is written beside the engine: a while is waited for it."""
        def is_there():
            return any(event[0] == kind and subject in event[1] and all(str(part) in event[2] for part in data) for event in self.events())
        end_s = time.monotonic() + EVENT_S
        while not is_there():
            self.assertLess(time.monotonic(), end_s, (kind, subject, data, self.events()))
            time.sleep(0.05)

    def modbus(self, device):
        """A pymodbus client beside soakd: chamber, fixture or relay."""
        client = ModbusTcpClient("127.0.0.1", port=self.lab.ports[device], timeout=30)
        self.addCleanup(client.close)
        self.assertTrue(client.connect())
        return client

    def chamber(self):
        """The chamber's own registers: (mode, output in percent, set point, air)."""
        client = self.modbus("chamber")
        mode = client.read_holding_registers(2814, 1, 1).registers[0]
        return mode, *(self.read_f32(client, address) for address in (2808, 2782, 2820))

    @staticmethod
    def read_f32(client, address):
        """The F4T sends the low word first."""
        low, high = client.read_holding_registers(address, 2, 1).registers
        return struct.unpack(">f", struct.pack(">HH", high, low))[0]

    @staticmethod
    def words_f32(value):
        high, low = struct.unpack(">HH", struct.pack(">f", value))
        return [low, high]

    def assert_safe(self):
        """Heating and cooling are off, at a temperature at which nothing gathers dew; units are off."""
        mode, output, set_point_c, air_c = self.chamber()
        self.assertEqual(mode, OFF)
        self.assertEqual(output, 0.0)
        self.assertGreaterEqual(set_point_c, 25.0)
        self.assertGreater(air_c, DEW_POINT_C)
        count = len(self.lab.ports["units"])
        self.assertEqual(self.modbus("relay").read_holding_registers(16, count, 1).registers, [0] * count, "units are on")


def is_long(case):
    """Whether it is left out here."""
    return getattr(getattr(case, case.id().split(".")[-1]), "__unittest_skip_why__", "") == REASON


def main(first=(), at_once=AT_ONCE):
    """Runs the tests of the calling script, several at once, each in a process of its own; those that are named in `first`
    (the longest ones) are begun first. With a test's name as argument only that one, in this process."""
    loader = unittest.defaultTestLoader.loadTestsFromModule(sys.modules["__main__"])
    cases = [case for suite in loader for case in suite]
    names = [case.id().removeprefix("__main__.") for case in cases if not is_long(case)]
    names.sort(key=lambda name: name.split(".")[-1] not in first)
    if len(sys.argv) > 1 or len(names) == 1:
        unittest.main()

    def run(name):
        begin_s = time.monotonic()
        result = subprocess.run([sys.executable, "-B", sys.argv[0], name], capture_output=True, text=True)
        print(f"{time.monotonic() - begin_s:6.1f} s  {name}{'' if result.returncode == 0 else '  FAILED'}", flush=True)
        if result.returncode != 0 or "skipped" in result.stderr:
            print(result.stdout + result.stderr, flush=True)
        return result.returncode

    for case in filter(is_long, cases):
        print(f"skipped   {case.id().removeprefix('__main__.')} ({REASON})", flush=True)
    with ThreadPoolExecutor(at_once) as pool:
        sys.exit(max(pool.map(run, names)))
