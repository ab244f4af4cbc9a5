#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`soak backup`: the copy is whole, a restored folder gives the same fit, and nothing in a backup is ever replaced by something else."""
import hashlib
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import tempfile
import unittest

from soak_cli import SoakTest, long_test, recording


def fitted_numbers(document):
    """A fit without what depends on when and where it was made."""
    return {key: value for key, value in document.items() if key not in ("created_utc_s",)}


def sweep(seed, run):
    return recording(seed, run, (-10.0, 5.0, 20.0, 40.0), 20)


class Backup(SoakTest):
    def setUp(self):
        super().setUp()
        self.imported("a.csv", sweep(1, "r1"), "--campaign", "c")
        self.imported("b.csv", sweep(2, "r2"), "--campaign", "c")
        self.place = self.folder / "backup"

    def back_up(self, status=0):
        return self.soak_json("backup", "backup", self.place, status=status)

    def at(self, folder, *arguments, **options):
        """A command at another data folder."""
        own, self.data = self.data, folder
        try:
            return self.soak(*arguments, **options)
        finally:
            self.data = own

    def files(self, folder):
        return {p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(folder.rglob("*"))
                if p.is_file()}

    def test_it_copies_what_is_new_and_says_what_was_there(self):
        names = sorted(run["file"] for run in self.soak_json("runs-list", "runs", "list")["runs"])
        first = self.back_up()
        self.assertEqual((first["copied"], first["kept"], first["damaged"], first["still_open"]), (names, [], [], []))
        self.imported("c.csv", sweep(3, "r3"), "--campaign", "c")
        again = self.back_up()
        self.assertEqual((len(again["copied"]), again["kept"]), (1, names))
        self.assertGreater(again["events"], first["events"])
        for name in names:
            self.assertEqual((self.place / "runs" / name).read_bytes(), (self.data / "runs" / name).read_bytes())
        self.assertFalse(list(self.place.glob("**/*.tmp")) + list(self.place.glob("backup.new")))

    def test_a_restored_station_opens_verifies_and_fits_the_same(self):
        self.back_up()
        self.assertEqual(self.at(self.place, "runs", "verify").returncode, 0)
        restored = self.folder / "restored"
        shutil.copytree(self.place, restored)
        ours = json.loads(self.soak("fit", "--unit", "SN1", "--json").stdout)
        theirs = json.loads(self.at(restored, "fit", "--unit", "SN1", "--json").stdout)
        self.assertEqual(fitted_numbers(theirs), fitted_numbers(ours))

    @long_test
    def test_it_is_whole_while_another_process_writes(self):
        text = sweep(5, "r5") + "".join(sweep(seed, f"r{seed}").split("\n", 1)[1] for seed in range(6, 10))
        path = self.write("more.csv", text)
        with subprocess.Popen(self.command("import", path, "--unit", "SN1", "--campaign", "c"), stdout=subprocess.DEVNULL) as writer:
            backups = 0
            while writer.poll() is None or backups == 0:
                self.assertEqual(self.back_up()["damaged"], [])
                self.at(self.place, "runs", "verify")
                backups += 1
        self.assertEqual(writer.returncode, 0)

    def test_it_refuses_a_folder_that_is_no_earlier_state_of_the_station(self):
        self.back_up()
        self.at(self.place, "unit", "add", "SN1", "--begin-epoch", "written into the backup")
        before = self.files(self.place)
        self.imported("c.csv", sweep(3, "r3"), "--campaign", "c")
        self.refusal("backup", self.place)
        self.assertEqual(self.files(self.place), before)
        self.refusal("backup", self.data)

    def test_a_damaged_run_file_is_named_and_the_rest_is_copied(self):
        run = self.soak_json("runs-list", "runs", "list")["runs"][0]
        path = self.data / "runs" / run["file"]
        path.chmod(0o644)
        content = bytearray(path.read_bytes())
        content[5000] ^= 1
        path.write_bytes(content)
        summary = self.back_up(status=4)
        self.assertEqual([file["file"] for file in summary["damaged"]], [run["file"]])
        self.assertEqual(len(summary["copied"]), 1)
        self.assertFalse((self.place / "runs" / run["file"]).exists())

    @long_test
    def test_a_run_file_that_cannot_be_read_is_named_and_the_rest_is_copied(self):
        runs = self.soak_json("runs-list", "runs", "list")["runs"]
        path = self.data / "runs" / min(run["file"] for run in runs)
        path.unlink()
        path.mkdir()  # opens, and fails when it is read, as a file on a bad sector does
        summary = self.back_up(status=4)
        self.assertEqual([file["file"] for file in summary["damaged"]], [path.name])
        self.assertEqual(len(summary["copied"]), len(runs) - 1)
        self.assertTrue((self.place / "station.db").exists())

    @long_test
    def test_a_file_damaged_in_the_backup_is_found_and_left(self):
        run = self.soak_json("runs-list", "runs", "list")["runs"][0]
        self.back_up()
        path = self.place / "runs" / run["file"]
        content = bytearray(path.read_bytes())
        content[5000] ^= 1
        path.write_bytes(content)
        self.assertEqual([file["file"] for file in self.back_up(status=4)["damaged"]], [run["file"]])
        self.assertEqual(path.read_bytes(), bytes(content))

    @long_test
    def test_a_run_file_that_is_not_in_the_catalog_is_named_and_left_out(self):
        run = self.soak_json("runs-list", "runs", "list")["runs"][0]
        shutil.copy(self.data / "runs" / run["file"], self.data / "runs" / "open.soakrun")
        self.assertEqual([file["file"] for file in self.back_up()["still_open"]], ["open.soakrun"])
        self.assertFalse((self.place / "runs" / "open.soakrun").exists())

    def test_a_damaged_catalog_does_not_replace_a_good_one(self):
        self.back_up()
        good = (self.place / "station.db").read_bytes()
        with sqlite3.connect(self.data / "station.db") as catalog:
            catalog.execute("UPDATE segment SET gyro_x_mean = gyro_x_mean + 0.05")
        self.refusal("backup", self.place, status=4)
        self.assertEqual((self.place / "station.db").read_bytes(), good)

    def test_on_the_disk_of_the_station_it_is_made_and_warned_of(self):
        self.assertEqual(len(self.back_up()["warnings"]), 1)
        self.assertEqual(self.soak("backup", self.place).stderr.count("\n"), 1)

    @unittest.skipIf(not os.access("/dev/shm", os.W_OK) or os.stat("/dev/shm").st_dev == os.stat(tempfile.gettempdir()).st_dev,
                     "needs a second file system")
    def test_on_another_file_system_there_is_nothing_to_warn_of(self):
        with tempfile.TemporaryDirectory(dir="/dev/shm") as other:
            self.place = pathlib.Path(other) / "backup"
            self.assertEqual(self.back_up()["warnings"], [])

    def test_it_is_in_the_log(self):
        self.back_up()
        event = self.soak_json("events-list", "events", "list", "--kind", "backup_made")["events"][0]
        self.assertEqual(event["subject"], str(self.place))
        self.assertTrue(event["user"])


if __name__ == "__main__":
    unittest.main()
