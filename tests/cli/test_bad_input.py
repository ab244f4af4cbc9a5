# SPDX-License-Identifier: Apache-2.0
"""Bad input and bad surroundings: the error names the place and the user's own text, the exit status is right, nothing changes."""
import os
import pathlib
import signal
import sqlite3
import subprocess
import threading
import unittest

from soak_cli import SoakTest, limit_file_size, long_test, recording

HEAD = "t_s,run,temp_c,position,gx_dps\n0,bad,25,+X,1\n"


class BadRecording(SoakTest):
    def setUp(self):
        super().setUp()
        self.imported("good.csv", recording(run="good", seconds=10))

    def refused(self, text, place, *named, arguments=(), status=2):
        """Demands a refusal at `place`; `named`: what the message quotes of the file, or names of options."""
        path = self.write("bad.csv", text)
        before = self.state()
        error = self.refusal("import", path, "--unit", "SN1", *arguments, status=status)
        self.assertEqual(error["where"], str(path) + place)
        for words in named:
            self.assertIn(words, error["message"])
        self.assertEqual(self.state(), before)
        plain = self.soak("import", path, "--unit", "SN1", *arguments, status=status)
        self.assertEqual(plain.stdout, "")
        self.assertIn(error["message"], plain.stderr)

    def test_arguments_and_run_labels_that_are_not_utf8_are_refused(self):
        done = subprocess.run([os.environ["SOAK_BIN"].encode(), b"unit", b"add", b"x\x9b", b"--data", str(self.data).encode()],
                              capture_output=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn(b"argument 3", done.stderr)
        path = self.folder / "label.csv"
        path.write_bytes(b"t_s,run,temp_c,gx_dps\n0,R\xe9,20,1\n1,R\xe9,20,2\n")
        self.refusal("import", path, "--unit", "U")

    def test_truncated_line(self):
        self.refused(HEAD + "1,bad,25", ", line 3", "--skip-bad")

    def test_nan_and_infinity(self):
        self.refused(HEAD + "1,bad,25,+X,nan\n", ", line 3, column 'gx_dps'", "'nan'", "--skip-bad")
        self.refused(HEAD + "1,bad,-inf,+X,1\n", ", line 3, column 'temp_c'", "'-inf'")

    def test_text_where_a_number_belongs(self):
        self.refused(HEAD + "1,bad,25,+X,1;5\n", ", line 3, column 'gx_dps'", "'1;5'")

    def test_falling_and_standing_time(self):
        for time in ("-1", "0"):
            for arguments in ((), ("--skip-bad",)):
                self.refused(HEAD + f"{time},bad,25,+X,1\n", ", line 3, column 't_s'", "'run'", arguments=arguments)

    def test_unknown_position(self):
        self.refused(HEAD + "1,bad,25,up,1\n", ", line 3, column 'position'", "'up'", "+X, -X, +Y, -Y, +Z, -Z", "[positions]")

    def test_run_in_two_places(self):
        self.refused(HEAD + "0,other,25,+X,1\n1,bad,25,+X,1\n", ", line 4, column 'run'", "'bad'")

    def test_sensor_without_unit(self):
        self.refused("t_s,temp_c,gx\n0,25,1\n", ", line 1", "'gx'", "gx_dps", "gx_rps", "gx_degph", "--columns")

    def test_one_quantity_twice(self):
        self.refused("t_s,temp_c,gx_dps,gx_rps\n0,25,1,1\n", ", line 1", "'gx_dps'", "'gx_rps'")

    def test_missing_columns(self):
        self.refused("time,temp_c,gx_dps\n0,25,1\n", ", line 1", "t_s", "time, temp_c, gx_dps", "--columns")

    def test_files_that_are_no_csv(self):
        self.refused("", "")
        self.refused("t_s,temp_c,gx_dps\n0,25,1\n".encode("utf-16"), "", "UTF-16", "UTF-8")
        self.refused(b"SQLite format 3\0" + bytes(100), "")
        self.refused("t_s,temp_c,gx_dps\r0,25,1\r", "")
        self.refused("t_s,temp_c,gx_dps\n0,25,\"1\n", ", line 2")

    def test_good_run_beside_a_bad_one_is_not_stored(self):
        self.refused(recording(run="first", seconds=10) + "0,second,soak,up,0,+X,0,25,1,1,1,1,1,nan\n",
                     ", line 242, column 'az_mps2'", "'nan'")

    def test_same_label_with_other_samples(self):
        path = self.write("good.csv", recording(run="new", seconds=10) + recording(seed=9, run="good", seconds=10).split("\n", 1)[1])
        before = self.state()
        error = self.refusal("import", path, "--unit", "SN1")
        stored = self.soak_json("runs-list", "runs", "list")["runs"][0]
        for words in ("'good'", stored["run_id"], "'SN1'", "'default'", "--campaign", "runs void"):
            self.assertIn(words, error["message"])
        self.assertEqual(self.state(), before, "not even the new run of the file is stored")
        self.assertEqual(self.imported("ok.csv", path.read_text(), "--campaign", "other")["status"], "imported")

    @long_test
    def test_same_samples_with_another_site(self):
        path = self.write("good.csv", recording(run="good", seconds=10))
        before = self.state()
        for option in (("--latitude-deg", "48"), ("--simulated",)):
            self.assertEqual(self.refusal("import", path, "--unit", "SN1", *option)["where"], str(path))
        self.assertEqual(self.state(), before)

    def test_mistakes_in_a_columns_map_come_all_at_once(self):
        columns = self.write("map.toml", "separator = 3\n[columns]\na = \"gx\"\nb = { as = \"temp_c\", type = \"i7\" }\n")
        before = self.state()
        error = self.refusal("import", self.folder / "good.csv", "--unit", "SN1", "--columns", columns)
        self.assertEqual(error["where"], str(columns))
        for line in (1, 3, 4):
            self.assertIn(f"{columns}:{line}: ", error["message"])
        self.assertEqual(self.state(), before)

    def test_wrong_usage(self):
        good = self.folder / "good.csv"
        for arguments, words in ((("import", good), "--unit"),
                                 (("import", good, "--unit", "SN1", "--latitude-deg", "nan"), "--latitude-deg"),
                                 (("import", good, "--unit", "SN1", "--latitude-deg", "91"), "--latitude-deg"),
                                 (("import", good, "--unit", ""), "--unit"),
                                 (("import", good, "--unit", "SN1", "--type", "other"), "generic"),
                                 (("import", self.folder / "absent.csv", "--unit", "SN1"), "absent.csv"),
                                 (("import", self.folder, "--unit", "SN1"), str(self.folder)),
                                 (("runs", "show", "nothing"), "runs list"),
                                 (("frobnicate",), "frobnicate")):
            error = self.refusal(*arguments)
            self.assertIn(words, error["message"] + error["where"], arguments)


class BadSurroundings(SoakTest):
    def test_a_bad_file_does_not_even_make_the_data_folder(self):
        path = self.write("bad.csv", "t_s,temp_c,gx_dps\n0,25,nan\n")
        self.refusal("import", path, "--unit", "SN1")
        self.assertFalse(self.data.exists())

    def test_a_mistyped_data_folder_is_not_an_empty_one(self):
        for arguments in (("runs", "list"), ("unit", "list"), ("runs", "verify")):
            error = self.refusal(*arguments)
            self.assertIn("--data", error["message"])
        self.assertFalse(self.data.exists())

    def test_catalog_of_a_newer_version(self):
        self.imported("good.csv", recording(run="good", seconds=10))
        with sqlite3.connect(self.data / "station.db") as database:
            database.execute("PRAGMA user_version = 99")
        database.close()
        before = self.state()
        path = self.write("next.csv", recording(run="next", seconds=10))
        for arguments in (("import", path, "--unit", "SN1"), ("runs", "list")):
            error = self.refusal(*arguments)
            self.assertIn("99", error["message"])
            self.assertEqual(error["where"], str(self.data / "station.db"))
        self.assertEqual(self.state(), before)

    def mount(self, options):
        """A small file system of its own at the data folder; False where that is not permitted."""
        self.data.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(self.data)], capture_output=True, check=False)
        if done.returncode == 0:
            self.addCleanup(subprocess.run, ["umount", "-l", str(self.data)], check=False)
        return done.returncode == 0

    def test_read_only_data_folder(self):
        if self.mount("size=8m"):
            self.imported("good.csv", recording(run="good", plateaus=(0.0, 15.0, 30.0, 45.0), seconds=10))
            self.soak("fit", "--unit", "SN1")
            subprocess.run(["mount", "-o", "remount,ro", str(self.data)], check=True)
        elif os.geteuid() != 0:
            self.imported("good.csv", recording(run="good", plateaus=(0.0, 15.0, 30.0, 45.0), seconds=10))
            self.soak("fit", "--unit", "SN1")
            for path in (self.data, self.data / "runs", self.data / "station.db"):
                path.chmod(0o555)
            self.addCleanup(lambda: [p.chmod(0o755) for p in (self.data, self.data / "runs")])
        else:
            self.skipTest("neither may mount a file system nor is bound by permissions")
        before = self.state()
        path = self.write("next.csv", recording(run="next", seconds=10))
        error = self.refusal("import", path, "--unit", "SN1", status=1)
        self.assertIn(str(self.data), error["where"])
        self.assertRegex(error["message"].lower(), "read-only|readonly|permission")
        self.assertEqual(self.state(), before)
        # An archive: all that only reads works.
        self.assertEqual([run["run"] for run in self.soak_json("runs-list", "runs", "list")["runs"]], ["good"])
        self.assertTrue(self.soak_json("runs-verify", "runs", "verify")["ok"])
        rows = self.soak("runs", "export", "good", "--native", "-o", self.folder / "again.csv")
        self.assertEqual(rows.returncode, 0)
        page = self.folder / "report.html"
        self.assertEqual(self.soak_json("report", "report", "--unit", "SN1", "-o", page)["model"], 1)
        self.assertIn("SN1", page.read_text(encoding="utf-8"))
        self.assertTrue(self.soak_json("events-verify", "events", "verify")["ok"])
        self.assertEqual(len(self.soak_json("backup", "backup", self.folder / "backup")["copied"]), 1)
        self.refusal("runs", "void", "good", "--reason", "r", "--user", "u", status=1)
        self.assertEqual(self.state(), before)

    def test_full_disk(self):
        if not self.mount("size=1m"):
            self.skipTest("may not mount a file system (see test_disk_that_fills_up_at_any_point)")
        self.imported("good.csv", recording(run="good", seconds=10))
        before = self.state()
        path = self.write("next.csv", recording(run="next", seconds=1500))
        error = self.refusal("import", path, "--unit", "SN1", status=1)
        self.assertIn(str(self.data), error["where"])
        self.assertRegex(error["message"].lower(), "full|space")
        self.assertEqual(self.state(), before)
        self.assertEqual(self.imported("small.csv", recording(run="small", seconds=10))["status"], "imported")

    @long_test
    def test_disk_that_fills_up_at_any_point(self):
        self.imported("good.csv", recording(run="good", seconds=10))
        before = self.state()
        # Two runs of a new unit: several rows of several tables, all or nothing.
        two_runs = recording(run="next", seconds=20) + recording(run="more", seconds=20, seed=2).split("\n", 1)[1]
        path = self.write("next.csv", two_runs)
        refused = 0
        for kilobytes in (*range(0, 100, 8), *range(100, 400, 20)):
            done = subprocess.run(self.command("import", path, "--unit", "SN2"), capture_output=True, text=True, timeout=60,
                                  check=False, restore_signals=False, preexec_fn=limit_file_size(1024 * kilobytes))
            if done.returncode == 0:
                break
            refused += 1
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(str(self.data), done.stderr)
            self.assertTrue(self.state() == before, f"changed with room for {kilobytes} kB: {done.stderr}")
        self.assertGreater(refused, 3)
        self.assertEqual(done.returncode, 0, "in the end there was room")

    @long_test
    def test_ctrl_c_leaves_everything_as_it_was(self):
        self.imported("good.csv", recording(run="good", seconds=10))
        before = self.state()
        pipe = self.folder / "pipe.csv"
        os.mkfifo(pipe)
        with subprocess.Popen(self.command("import", pipe, "--unit", "SN1"), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True) as process:
            watchdog = threading.Timer(60, process.kill)
            watchdog.start()
            with open(pipe, "w", encoding="utf-8") as writer:  # opens once soak reads, so its handlers are in place
                process.send_signal(signal.SIGINT)
                writer.write(recording(run="next", seconds=10))
            _, err = process.communicate()
            watchdog.cancel()
        self.assertEqual(process.returncode, 1, err)  # by a way of its own: the signal alone would give a negative status
        self.assertIn("import", err)
        self.assertEqual(self.state(), before)

    def test_results_that_cannot_be_written_are_an_error(self):
        if not pathlib.Path("/dev/full").exists():
            self.skipTest("no /dev/full")
        self.imported("good.csv", recording(run="good", seconds=10))
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run(self.command("runs", "list"), stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("standard output", done.stderr)


if __name__ == "__main__":
    unittest.main()
