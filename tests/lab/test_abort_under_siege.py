# SPDX-License-Identifier: Apache-2.0
"""An abort reaches the chamber although 200 connections drip, the disk is full and a unit hangs, all at once. What came of it is
judged, not how long it took; that is printed."""
import socket
import subprocess
import threading
import time
import unittest
from urllib.parse import urlparse

import bench
from bench import AUTO, LabTest, bin_folder, short_procedure

CONNECTIONS = 200
SET_POINT_C = 15.0
SAFE_C = 25.0


class Siege(LabTest):
    def mount(self, size):
        data = self.folder / "lab" / "data"
        data.mkdir(parents=True)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(data)], capture_output=True).returncode != 0:
            self.skipTest("no right to mount a small disk: skipped")
        self.addCleanup(subprocess.run, ["umount", "-l", str(data)])
        return data

    def drip(self):
        """200 clients that send a request byte by byte and never end it."""
        page = urlparse(self.lab.page)
        stop = threading.Event()
        self.addCleanup(stop.set)

        def client():
            while not stop.is_set():
                try:
                    with socket.create_connection((page.hostname, page.port), timeout=30) as wire:
                        for byte in b"GET /api/v1/status HTTP/1.1\r\nHost: " + b"x" * 4000:
                            if stop.wait(0.5):
                                return
                            wire.sendall(bytes([byte]))
                except OSError:
                    stop.wait(0.2)  # shut out: it comes again
        for _ in range(CONNECTIONS):
            threading.Thread(target=client, daemon=True).start()

    def test_an_abort_reaches_the_chamber(self):
        data = self.mount("128m")
        self.start_lab(units=2, rate=100, cut=["unit2"])
        self.start_campaign(short_procedure(set_points=(SET_POINT_C,), dwell_s=3000))
        self.wait_for_step("wait_stable")
        mode, _, set_point_c, _ = self.chamber()
        self.assertEqual((mode, set_point_c), (AUTO, SET_POINT_C))
        self.drip()
        self.proxies["unit2"].silence()
        time.sleep(2)  # the connections are there
        with (data / "filler").open("wb", buffering=0) as file:
            try:
                while file.write(b"x" * 65536):
                    pass
            except OSError:
                pass
        client = self.modbus("chamber")
        begin_s = time.monotonic()
        # The answer comes later: it waits two seconds for the event log, which the full disk does not take.
        abort = subprocess.Popen([bin_folder() + "/soak", "campaign", "abort", "--reason", "siege"], env=self.lab.env,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        end_s = begin_s + bench.WAIT_S
        while self.read_f32(client, 2782) < SAFE_C and client.read_holding_registers(2814, 1, 1).registers == [AUTO]:
            self.assertLess(time.monotonic(), end_s, "the chamber was not told anything")
            time.sleep(0.01)
        told_s = time.monotonic() - begin_s
        _, message = abort.communicate(timeout=bench.WAIT_S)
        print(f"abort at the chamber after {told_s:.2f} s, answered after {time.monotonic() - begin_s:.2f} s", flush=True)
        # Refused (2) where the full disk came first and the campaign is on its way to the safe state already.
        self.assertIn(abort.returncode, (0, 2), message)
        self.assertIn(self.wait_for_end()["state"], ("aborted", "failed"))  # failed: the full disk came first
        self.assert_safe()


if __name__ == "__main__":
    bench.main()
