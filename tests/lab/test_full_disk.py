# SPDX-License-Identifier: Apache-2.0
"""The disk fills up in mid-campaign: the campaign waits, and goes on by itself once there is room."""
import subprocess
import time
import unittest

import bench
from bench import LabTest, long_test, short_procedure


class FullDisk(LabTest):
    def mount(self, size):
        """The lab's data folder as a small disk of its own."""
        data = self.folder / "lab" / "data"
        data.mkdir(parents=True)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(data)], capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("no right to mount a small disk: skipped")
        self.addCleanup(subprocess.run, ["umount", "-l", str(data)])
        return data

    def fill(self, data):
        filler = data / "filler"
        with filler.open("wb", buffering=0) as file:
            try:
                while file.write(b"x" * 65536):
                    pass
            except OSError:
                pass
        return filler

    @long_test
    def test_a_full_disk_does_not_hold_a_chamber_that_is_on_its_way_to_the_safe_state(self):
        data = self.mount("160m")
        self.start_lab(rate=50)
        self.start_campaign(short_procedure(set_points=(5,), positions=("+Z",)))
        self.wait_for_step("warm_end")
        filler = self.fill(data)
        # The status tells what was read last: it may be suspended for the end of this step, the chamber off, before that is read.
        self.wait("the chamber off", lambda s: s["chamber"]["running"] is False)
        filler.unlink()
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_safe()

    def test_no_campaign_begins_with_less_room_than_one_needs_to_go_on(self):
        data = self.mount("140m")
        self.start_lab()
        filler = data / "filler"
        filler.write_bytes(bytes(60_000_000))
        procedure = self.write("procedure.toml", short_procedure(set_points=(15,)))
        self.soak_fails(1, "campaign", "start", procedure, "--name", "c")
        filler.unlink()
        self.start_campaign(short_procedure(set_points=(15,)))

    def test_a_full_disk_suspends_the_campaign_until_there_is_room(self):
        data = self.mount("160m")  # more than the 100 MB with which it goes on
        self.start_lab(rate=100)
        self.start_campaign(short_procedure(set_points=(15,), dwell_s=1500))
        self.wait_for_step("record")
        filler = self.fill(data)
        status = self.wait("the suspension", lambda s: s["suspension"] and "disk" in s["suspension"]["causes"])
        self.check_schema(status, "campaign-status")
        self.assertEqual(status["state"], "waiting")
        time.sleep(6)  # a flush is tried meanwhile
        status = self.status()
        self.assertEqual(status["state"], "waiting")
        self.assertTrue(status["chamber"]["connected"])
        self.assertEqual(self.chamber()[0], bench.AUTO, "the chamber holds its set point")
        filler.unlink()
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_safe()
        self.lab.soak("runs", "verify")
        self.assertEqual(self.query("SELECT label, cut_short FROM run"), [("R01", "")])
        self.assertEqual(self.query("SELECT * FROM void WHERE visit IS NULL"), [])
        places = self.query("SELECT DISTINCT visit, position FROM segment ORDER BY position")
        self.assertEqual(places, [(0, "+Z"), (0, "-Z")])


if __name__ == "__main__":
    bench.main()
