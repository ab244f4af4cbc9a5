# SPDX-License-Identifier: Apache-2.0
"""soakd as a service: the test plays the manager that started it, with the lines of packaging/systemd/soakd.service. What
systemd itself makes of that file is asked of systemd-analyze, where it is installed."""
import os
import pathlib
import re
import select
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from unittest import mock

import bench
from bench import AUTO, ROOT, LabTest, short_procedure
from lab_session import bin_folder, end

UNIT = ROOT / "packaging" / "systemd" / "soakd.service"
WATCHDOG_S = 2.0


def setting(name, unit=UNIT):
    return re.search(rf"(?m)^{name}=(.*)$", unit.read_text(encoding="utf-8")).group(1)


class Service(LabTest):
    def manager(self, address, **environment):
        """The socket of a manager; programs that are started from now on know of it."""
        receiver = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(receiver.close)
        receiver.bind(address.replace("@", "\0"))
        told = {"NOTIFY_SOCKET": address, "WATCHDOG_USEC": str(int(WATCHDOG_S * 1e6)), **environment}
        patch = mock.patch.dict(os.environ, told)
        patch.start()
        self.addCleanup(patch.stop)
        return receiver

    def message(self, receiver, seconds=60):
        """The next datagram as a dictionary; None where there is none in that time."""
        if not select.select([receiver], [], [], seconds)[0]:
            return None
        text = receiver.recv(4096).decode()
        return dict(line.split("=", 1) for line in text.splitlines())

    def wait_for(self, receiver, key):
        end_s = time.monotonic() + bench.WAIT_S
        while key not in (message := self.message(receiver) or {}):
            self.assertLess(time.monotonic(), end_s, key)
        return message

    def drain(self, receiver):
        while self.message(receiver, 0) is not None:
            pass

    def test_it_says_when_it_serves_that_it_turns_and_when_it_ends(self):
        receiver = self.manager(str(self.folder / "notify"))
        self.start_lab()
        first = self.message(receiver)
        self.assertEqual(first["READY"], "1")
        self.assertIn(self.lab.page, first["STATUS"])
        for _ in range(6):
            self.assertEqual(self.message(receiver), {"WATCHDOG": "1"})
        self.lab.soakd.send_signal(signal.SIGTERM)
        self.assertEqual(self.wait_for(receiver, "STOPPING")["STOPPING"], "1")
        self.assertEqual(self.lab.soakd.wait(60), 0)

    def test_an_engine_that_stands_still_is_not_called_alive(self):
        """At an address without a file, as systemd's may be."""
        receiver = self.manager(f"@soak-test-{os.getpid()}")
        self.start_lab()
        self.wait_for(receiver, "WATCHDOG")
        self.lab.soakd.send_signal(signal.SIGSTOP)
        time.sleep(0.2)
        self.drain(receiver)
        self.assertIsNone(self.message(receiver, 2 * WATCHDOG_S))
        self.lab.soakd.send_signal(signal.SIGCONT)
        self.wait_for(receiver, "WATCHDOG")

    def test_a_watchdog_of_another_process_gets_nothing(self):
        receiver = self.manager(str(self.folder / "notify"), WATCHDOG_PID="1")
        self.start_lab()
        self.assertIn("READY", self.message(receiver))
        self.assertIsNone(self.message(receiver, 2 * WATCHDOG_S))

    def test_without_a_manager_or_with_one_that_is_gone_it_works_as_ever(self):
        receiver = self.manager(str(self.folder / "notify"))
        receiver.close()
        os.unlink(self.folder / "notify")
        self.start_lab()
        self.assertEqual(self.status()["state"], "idle")

    def test_lines_for_the_journal_have_no_date_of_their_own(self):
        self.start_lab()
        self.assertRegex(self.lab.log(), r"(?m)^\d{4}-\d\d-\d\dT.* serving ")
        end(self.lab.soakd)
        log = pathlib.Path(self.lab.folder) / "soakd.log"
        place = log.stat()
        with mock.patch.dict(os.environ, {"JOURNAL_STREAM": f"{place.st_dev}:{place.st_ino}"}):
            self.lab.start_soakd()
        self.assertRegex(self.lab.log(), r"(?m)^serving ")

    def test_what_the_unit_runs_after_a_crash_makes_the_chamber_safe_and_after_a_good_end_does_nothing(self):
        self.start_lab()
        self.start_campaign(short_procedure(set_points=(60,), positions=("+Z",), dwell_s=100000))
        self.wait_for_step("record")
        # As systemd reads the line: its own escape, then the station's paths.
        command = setting("ExecStopPost").replace("$$", "$").replace("/usr/bin", bin_folder()) \
            .replace("/etc/soak/station.toml", str(self.config)).replace("/var/lib/soak", self.lab.data)
        self.lab.soakd.kill()
        self.lab.soakd.wait()

        def stop_post(result):
            subprocess.run(command, shell=True, check=True, env={"SERVICE_RESULT": result, "PATH": "/usr/bin:/bin"}, capture_output=True)
            return self.chamber()[0], self.chamber()[2]
        self.assertEqual(stop_post("success"), (AUTO, 60.0))
        self.assertEqual(stop_post("watchdog"), (AUTO, 25.0))
        self.lab.soakd.stdout.close()
        self.lab.start_soakd()
        self.assertEqual(self.wait_for_end()["state"], "interrupted")
        self.assert_safe()


class UnitFile(unittest.TestCase):
    def test_it_names_options_that_the_programs_have(self):
        alarm = setting("ExecStart", UNIT.with_name(setting("OnFailure")))
        for line, program in ((setting("ExecStart"), ["soakd"]), (setting("ExecStopPost"), ["soak", "chamber", "make-safe"]),
                              (alarm, ["soak", "alarm", "send"])):
            known = subprocess.run([f"{bin_folder()}/{program[0]}", *program[1:], "--help"], capture_output=True, text=True,
                                   check=True).stdout
            for option in re.findall(r"--[\w-]+", line):
                self.assertIn(option, known)

    def test_systemd_accepts_it(self):
        if not shutil.which("systemd-analyze"):
            self.skipTest("systemd-analyze is not installed")
        with tempfile.TemporaryDirectory() as folder:
            copies = [pathlib.Path(folder) / name for name in ("soakd.service", "soakd-alarm.service")]
            for copy in copies:
                text = UNIT.with_name(copy.name).read_text(encoding="utf-8")
                copy.write_text(text.replace("/usr/bin", bin_folder()), encoding="utf-8")
            done = subprocess.run(["systemd-analyze", "verify", *map(str, copies)], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))


if __name__ == "__main__":
    bench.main()
