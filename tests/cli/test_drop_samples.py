#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`soak runs drop-samples`: only by request and with a record, after a check of all that stays; what stays gives the same numbers."""
import os
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import threading
import unittest

from soak_cli import SoakTest, long_test, recording

PLATEAUS = (-20.0, -5.0, 10.0, 25.0, 40.0)
REASON = ("--reason", "kept for two years", "--user", "eva")
NOT_NUMBERS = ("created_utc_s", "model")


def sweep(seed, run):
    return recording(seed, run, PLATEAUS, 10)


class DropSamples(SoakTest):
    stored = None  # what each test begins with

    def setUp(self):
        super().setUp()
        if self.stored:
            shutil.copytree(self.stored, self.folder, dirs_exist_ok=True)
            return
        for number in (1, 2, 3):
            self.imported(f"{number}.csv", sweep(number, f"r{number}"), "--campaign", "c", "--gravity-mps2", "9.80665")
        type(self).stored = tempfile.mkdtemp(prefix="soak-test-")
        self.addClassCleanup(shutil.rmtree, self.stored, ignore_errors=True)
        shutil.copytree(self.folder, self.stored, dirs_exist_ok=True)

    def files(self):
        return sorted(path.name for path in (self.data / "runs").iterdir())

    def fit(self):
        document = self.soak_json("fit", "fit", "--unit", "SN1", "--rules", 2)
        return {key: value for key, value in document.items() if key not in NOT_NUMBERS}

    def run_row(self, label):
        return self.soak_json("runs-show", "runs", "show", label)["run"]

    def drop(self, *arguments, **options):
        return self.soak_json("runs-drop-samples", "runs", "drop-samples", *arguments, *REASON, "--yes", **options)

    def damage(self, change):
        """Changes the catalog behind the program's back."""
        catalog = sqlite3.connect(self.data / "station.db")
        with catalog:
            catalog.execute(change)
        catalog.close()

    def test_without_yes_it_says_what_it_would_do_and_does_nothing(self):
        before = self.state()
        size = (self.data / "runs" / self.run_row("r1")["file"]).stat().st_size
        said = self.soak_json("runs-drop-samples", "runs", "drop-samples", "r1", *REASON)
        self.assertEqual((said["dropped"], said["bytes"], said["runs"][0]["units"]), (False, size, ["SN1"]))
        self.assertEqual(self.state(), before)

    def test_the_file_goes_and_everything_that_rests_on_it_stays_as_it_was(self):
        fitted = self.fit()
        shown = self.soak_json("runs-show", "runs", "show", "r1")
        names = self.files()
        dropped = self.drop("r1")
        self.assertEqual(self.files(), [name for name in names if name != shown["run"]["file"]])
        self.assertEqual(dropped["runs"][0]["file"], shown["run"]["file"])
        self.assertEqual(self.fit(), fitted)
        after = self.soak_json("runs-show", "runs", "show", "r1")
        self.assertEqual((after["segments"], after["source"], after["channels"]), (shown["segments"], shown["source"], []))
        self.assertEqual((after["run"]["samples_dropped"]["user"], after["run"]["samples_dropped"]["reason"]), ("eva", "kept for two years"))
        self.assertIsNone(self.run_row("r2")["samples_dropped"])
        self.soak("report", "--unit", "SN1", "-o", self.folder / "r.html")
        self.assertIn("1.csv", (self.folder / "r.html").read_text(encoding="utf-8"))

    def test_the_log_and_the_check_of_all_runs_tell_of_it(self):
        self.drop("r1")
        event = self.soak_json("events-list", "events", "list", "--kind", "samples_dropped")["events"][0]
        self.assertEqual(event["user"], "eva")
        self.soak("events", "verify")
        runs = self.soak_json("runs-verify", "runs", "verify")["runs"]
        self.assertEqual([(run["ok"], run["samples_dropped"]) for run in runs], [(True, True), (True, False), (True, False)])

    @long_test
    def test_what_needs_the_samples_is_refused(self):
        self.fit()
        self.drop("r1")
        self.assertIn("eva", self.soak("runs", "export", "r1", status=2).stderr)
        for arguments in (("signal", "allan", "--run", "r1", "--column", "gyro_x"), ("gap", "find", "--unit", "SN1"),
                          ("runs", "drop-samples", "r1", *REASON)):
            self.assertIn("eva", self.refusal(*arguments)["message"], arguments)

    def test_a_whole_campaign_is_dropped_at_once(self):
        self.imported("4.csv", sweep(4, "r4"), "--campaign", "other")
        dropped = self.drop("--campaign", "c")
        self.assertEqual([run["run"] for run in dropped["runs"]], ["r1", "r2", "r3"])
        self.assertEqual(self.files(), [self.run_row("r4")["file"]])
        self.refusal("runs", "drop-samples", "--campaign", "c", *REASON)
        self.refusal("runs", "drop-samples", *REASON)

    @long_test
    def test_nothing_is_dropped_while_anything_is_damaged(self):
        path = self.data / "runs" / self.run_row("r2")["file"]
        bytes_of_file = bytearray(path.read_bytes())
        bytes_of_file[len(bytes_of_file) // 2] ^= 1
        path.chmod(0o644)
        path.write_bytes(bytes_of_file)
        names = self.files()
        self.refusal("runs", "drop-samples", "r1", "r2", *REASON, "--yes", status=4)
        self.assertEqual(self.files(), names)
        self.damage("UPDATE segment SET gyro_x_mean = gyro_x_mean + 0.05 WHERE visit = 1")
        self.refusal("runs", "drop-samples", "r1", *REASON, "--yes", status=4)
        self.assertEqual(self.files(), names)

    @long_test
    def test_samples_that_each_fit_reads_stay(self):
        self.imported("bench.csv", recording(5, "bench", (25.0,), 20), "--campaign", "bench", "--gravity-mps2", "9.80665")
        names = self.files()
        self.refusal("runs", "drop-samples", "bench", *REASON, "--yes")
        self.assertEqual(self.files(), names)
        self.soak("runs", "void", "bench", "--reason", "not wanted")
        self.drop("bench")
        self.assertEqual(len(self.files()), 3)

    @long_test
    def test_a_file_that_is_put_back_counts_again(self):
        name = self.run_row("r1")["file"]
        exported = self.soak("runs", "export", "r1").stdout
        shutil.copy(self.data / "runs" / name, self.folder / "kept")
        self.drop("r1")
        shutil.copy(self.folder / "kept", self.data / "runs" / name)
        self.assertIsNone(self.run_row("r1")["samples_dropped"])
        self.assertEqual(self.soak("runs", "export", "r1").stdout, exported)
        with open(self.data / "runs" / name, "ab") as file:
            file.write(b"x")
        self.soak("runs", "verify", status=4)
        shutil.copy(self.folder / "kept", self.data / "runs" / name)
        self.drop("--campaign", "c")
        self.assertEqual(self.files(), [])
        self.assertEqual(len(self.soak_json("events-list", "events", "list", "--kind", "samples_dropped")["events"]), 4)

    @long_test
    def test_noise_figures_come_from_a_run_that_has_its_samples(self):
        for number, seconds in ((6, 60), (7, 80)):
            self.imported(f"{number}.csv", recording(number, f"long{number}", PLATEAUS, seconds), "--campaign", "long", "--gravity-mps2", "9.80665")
        self.fit()

        def noise():
            return self.soak_json("report", "report", "--unit", "SN1", "-o", self.folder / "r.html")["sections"]["noise"]
        self.assertEqual(noise()["segment"]["run"], "long7")
        self.drop("long7")
        after = noise()
        self.assertEqual(after["segment"]["run"], "long6")
        self.assertGreater(len(after["sensors"]["gyro_x"]["ci95"]), 3)

    @long_test
    def test_ctrl_c_stops_it_before_anything_is_gone(self):
        path = self.data / "runs" / self.run_row("r1")["file"]
        kept, again = self.folder / "kept", self.folder / "again"
        for copy in (kept, again):
            shutil.copy(path, copy)
        path.unlink()
        os.mkfifo(path)  # its hash is waited for
        with subprocess.Popen(self.command("runs", "drop-samples", "--campaign", "c", *REASON, "--yes"), stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as process:
            watchdog = threading.Timer(60, process.kill)
            watchdog.start()
            with open(path, "wb") as writer:
                process.send_signal(signal.SIGINT)
                writer.write(kept.read_bytes())
                os.replace(again, path)
            _, err = process.communicate()
            watchdog.cancel()
        self.assertEqual(process.returncode, 1, err)
        self.assertEqual(len(self.files()), 3)
        self.assertEqual(self.soak_json("events-list", "events", "list", "--kind", "samples_dropped")["events"], [])

    @long_test
    def test_a_recording_whose_samples_were_dropped_is_not_stored_again_unnoticed(self):
        self.drop("r1")
        said = self.soak_json("import", "import", self.folder / "1.csv", "--unit", "SN1", "--campaign", "c", "--gravity-mps2", "9.80665")
        self.assertEqual(said["runs"][0]["status"], "unchanged")
        self.assertTrue(any("r1" in warning for warning in said["warnings"]), said["warnings"])
        self.assertEqual(len(self.files()), 2)

    def test_backups_go_on_and_those_made_before_keep_the_file(self):
        place = self.folder / "backup"
        name = self.run_row("r1")["file"]
        self.soak_json("backup", "backup", place)
        self.drop("r1")
        again = self.soak_json("backup", "backup", place)
        self.assertEqual((again["copied"], again["damaged"], len(again["kept"])), ([], [], 2))
        self.assertTrue((place / "runs" / name).exists())
        fresh = self.folder / "fresh"
        self.assertEqual(len(self.soak_json("backup", "backup", fresh)["copied"]), 2)
        fitted = self.fit()
        shutil.copytree(fresh, self.folder / "restored")
        self.data = self.folder / "restored"
        self.soak("runs", "verify")
        self.assertEqual(self.fit(), fitted)


if __name__ == "__main__":
    unittest.main()
