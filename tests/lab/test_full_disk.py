# SPDX-License-Identifier: Apache-2.0
"""The disk fills up in mid-campaign: the chamber becomes safe, and with room on the disk the campaign goes on."""
import subprocess
import time
import unittest

import bench
from bench import LabTest, short_procedure


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

    def test_a_full_disk_ends_the_campaign_safely_and_resume_goes_on(self):
        data = self.mount("64m")
        self.start_lab(rate=100)
        self.start_campaign(short_procedure(set_points=(15,)))
        self.wait_for_step("wait_stable")
        time.sleep(6)  # what was recorded is flushed every five seconds
        filler = data / "filler"
        with filler.open("wb", buffering=0) as file:
            try:
                while file.write(b"x" * 4096):
                    pass
            except OSError:
                pass
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assert_safe()
        filler.unlink()
        self.wait("the journal", lambda s: self.query("SELECT state FROM journal") == [("failed",)])
        self.lab.soak("campaign", "resume")
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()
        self.lab.soak("runs", "verify")
        # Both are there: what was recorded until the disk was full, and the run that goes on from there.
        runs = self.query("""SELECT label, cut_short <> '' OR EXISTS (SELECT 1 FROM void v WHERE v.run_id = r.run_id
            AND v.visit IS NULL) FROM run r ORDER BY created_utc_s""")
        self.assertEqual(runs, [("R01", 1), ("R01.2", 0)])


if __name__ == "__main__":
    bench.main()
