# SPDX-License-Identifier: Apache-2.0
"""soak runs list, show, void, verify; soak unit; the frame of the command line."""
import os
import sqlite3
import subprocess
import unittest

from soak_cli import SoakTest, long_test, recording


class Runs(SoakTest):
    def setUp(self):
        super().setUp()
        self.run_id = self.imported("a.csv", recording(run="a", seconds=10))["run_id"]
        self.imported("b.csv", recording(seed=2, run="b", seconds=10), "--campaign", "second", "--simulated")

    def test_list_shows_all_and_filters(self):
        runs = self.soak_json("runs-list", "runs", "list")["runs"]
        self.assertEqual([(r["run"], r["campaign"], r["simulated"], r["sealed"]) for r in runs],
                         [("a", "default", False, True), ("b", "second", True, True)])
        self.assertEqual([r["run"] for r in self.soak_json("runs-list", "runs", "list", "--campaign", "second")["runs"]], ["b"])
        self.assertEqual(self.soak_json("runs-list", "runs", "list", "--unit", "SN2")["runs"], [])
        self.assertIn("SIMULATED", self.soak("runs", "list").stdout)

    def test_a_run_is_named_by_label_id_or_beginning_of_id(self):
        for name in (self.run_id, self.run_id[:23], "a"):
            self.assertEqual(self.soak_json("runs-show", "runs", "show", name)["run"]["run_id"], self.run_id)

    @long_test
    def test_a_label_of_two_runs_is_refused_with_both(self):
        other = self.imported("a2.csv", recording(seed=3, run="a", seconds=10), "--campaign", "third")["run_id"]
        message = self.refusal("runs", "show", "a")["message"]
        self.assertIn(self.run_id, message)
        self.assertIn(other, message)
        self.assertEqual(self.soak_json("runs-show", "runs", "show", "a", "--campaign", "third")["run"]["run_id"], other)

    def test_void_withdraws_a_segment_a_visit_and_a_run_and_keeps_the_record(self):
        def counted():
            return len(self.soak_json("runs-show", "runs", "show", "a")["segments"])
        self.assertEqual(counted(), 12)
        self.soak("runs", "void", "a", "--visit", "0", "--position", "-Y", "--reason", "door was open", "--user", "eva")
        self.assertEqual(counted(), 11)
        self.soak("runs", "void", "a", "--visit", "1", "--reason", "heater")
        self.assertEqual(counted(), 5)
        record = self.soak_json("runs-void", "runs", "void", "a", "--reason", "wrong unit", "--user", "bob")
        self.assertEqual((record["visit"], record["user"], record["segments_withdrawn"], record["segments_before"]), (None, "bob", 5, 5))
        self.refusal("runs", "void", "a", "--reason", "once more")
        shown = self.soak_json("runs-show", "runs", "show", "a")
        self.assertEqual(shown["segments"], [])
        self.assertTrue(shown["run"]["voided"])
        self.assertEqual([(v["visit"], v["position"], v["reason"]) for v in shown["voids"]],
                         [(0, "-Y", "door was open"), (1, None, "heater"), (None, None, "wrong unit")])
        self.assertEqual(shown["voids"][0]["user"], "eva")
        self.assertTrue((self.data / "runs" / shown["run"]["file"]).exists())

    @long_test
    def test_void_refuses_what_is_not_there(self):
        for arguments, words in ((("--visit", "7", "--reason", "x"), "0/+X/0"), (("--position", "+X", "--reason", "x"), "--visit"),
                                 ((), "--reason"), (("--reason", ""), "--reason")):
            done = self.soak("runs", "void", "a", *arguments, status=2)
            self.assertIn(words, done.stderr)
        self.assertFalse(self.soak_json("runs-show", "runs", "show", "a")["voids"])

    def test_verify_is_content_with_sound_files(self):
        document = self.soak_json("runs-verify", "runs", "verify")
        self.assertTrue(document["ok"])
        self.assertEqual([r["run"] for r in document["runs"]], ["a", "b"])

    def test_verify_finds_a_flipped_bit_anywhere_and_names_the_run(self):
        path = self.data / "runs" / f"{self.run_id}.soakrun"
        sound = path.read_bytes()
        for offset in range(40, len(sound), len(sound) // 12):
            damaged = bytearray(sound)
            damaged[offset] ^= 0x10
            path.write_bytes(damaged)
            document = self.soak_json("runs-verify", "runs", "verify", status=4)
            self.assertFalse(document["ok"])
            self.assertEqual([r["ok"] for r in document["runs"]], [False, True])
        done = self.soak("runs", "verify", "a", status=4)
        self.assertIn(self.run_id, done.stderr)
        path.write_bytes(sound)
        self.soak("runs", "verify")

    @long_test
    def test_verify_names_a_missing_file(self):
        (self.data / "runs" / f"{self.run_id}.soakrun").unlink()
        done = self.soak("runs", "verify", status=4)
        self.assertIn("missing", done.stdout)
        self.assertIn(self.run_id, done.stderr)

    def test_export_to_a_folder_that_is_not_there_is_refused(self):
        target = self.folder / "absent" / "x.csv"
        done = self.soak("runs", "export", "a", "-o", target, status=2)
        self.assertIn(str(target), done.stderr)


class Units(SoakTest):
    def test_add_list_show_and_epochs(self):
        self.soak("unit", "add", "SN1", "--type", "mti-300", "--user", "eva")
        self.soak("unit", "add", "SN1", "--user", "bob")  # is there already
        self.assertEqual([(event["subject"], event["text"], event["user"]) for event in self.soak_json("events-list", "events", "list", "--kind", "unit_added")["events"]],
                         [("SN1", "as mti-300", "eva")])
        self.assertEqual(self.soak_json("unit-list", "unit", "list")["units"], [{"unit": "SN1", "type": "mti-300", "epoch": 0, "runs": 0}])
        self.refusal("unit", "add", "SN1", "--type", "generic")
        self.soak("unit", "add", "SN1", "--begin-epoch", "re-flashed", "--user", "eva")
        database = sqlite3.connect(self.data / "station.db")
        self.assertEqual(database.execute("SELECT text FROM event WHERE kind = 'epoch_begun'").fetchall(), [("epoch 1, by eva: re-flashed",)])
        database.close()
        self.imported("a.csv", recording(seconds=10))
        self.assertEqual(self.soak_json("unit-list", "unit", "show", "SN1")["units"], [{"unit": "SN1", "type": "mti-300", "epoch": 1, "runs": 1}])
        self.assertEqual(self.soak_json("runs-list", "runs", "list")["runs"][0]["epoch"], 1)
        self.refusal("unit", "show", "SN9")


    def test_a_type_that_nobody_knows_is_refused_with_those_that_are_known(self):
        path = self.write("a.csv", recording(seconds=10))
        for arguments in (("unit", "add", "Z2", "--type", "nosuch"), ("import", path, "--unit", "Z2", "--type", "nosuch"),
                          ("unit", "add", "Z2", "--type", "../units/generic"), ("unit", "add", "Z2", "--type", "")):
            error = self.refusal(*arguments)
            self.assertEqual(error["where"], "--type")
            self.assertIn("ahrs400, generic, mti-300, vn-200", error["message"])
        if self.data.exists():
            self.assertEqual(self.soak_json("unit-list", "unit", "list")["units"], [])
        self.soak("import", path, "--unit", "Z2", "--type", "vn-200")
        self.assertEqual(self.soak_json("unit-list", "unit", "show", "Z2")["units"][0]["type"], "vn-200")

    @long_test
    def test_a_unit_whose_type_has_lost_its_file_is_told_of(self):
        folder = self.folder / "procedures" / "units"
        folder.mkdir(parents=True)
        (folder / "own.toml").write_text('name = "own"\n', encoding="utf-8")
        own = {**os.environ, "SOAK_PROCEDURES": str(folder.parent)}
        path = self.write("a.csv", recording(plateaus=tuple(float(t) for t in range(-20, 60, 5)), seconds=20))
        self.soak("import", path, "--unit", "SN1", "--type", "own", env=own)
        self.assertNotIn("'own'", self.soak("fit", "--unit", "SN1", "--rules", 2, env=own).stderr)
        self.assertIn("'own'", self.soak("fit", "--unit", "SN1", "--rules", 2).stderr)
        self.assertIn("'own'", self.soak("import", path, "--unit", "SN1", "--campaign", "b").stderr)

    def test_a_serial_number_is_as_long_as_a_calibration_file_carries(self):
        path = self.write("a.csv", recording(plateaus=tuple(float(t) for t in range(-20, 60, 5)), seconds=20))
        for arguments in (("unit", "add", "S" * 256), ("import", path, "--unit", "S" * 256), ("unit", "add", "é" * 128)):
            self.refusal(*arguments)
        self.assertEqual(self.soak_json("unit-list", "unit", "list")["units"], [])
        self.soak("import", path, "--unit", "S" * 255)
        self.soak("fit", "--unit", "S" * 255, "--rules", 2)
        for kind in ("blob", "c", "json"):
            self.soak("export", "--unreleased", "--unit", "S" * 255, "--format", kind, "-o", self.folder / kind)


class Frame(SoakTest):
    def run_bare(self, *arguments, **environment):
        return subprocess.run([os.environ["SOAK_BIN"], *arguments], capture_output=True, text=True, check=False,
                              env={**os.environ, **environment})

    def test_help_and_version(self):
        self.assertRegex(self.run_bare("--version").stdout, r"^soak \d+\.\d+\.\d+\n$")
        for arguments in ((), ("--help",), ("runs",), ("runs", "--help")):
            done = self.run_bare(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("Subcommands:", done.stdout)

    def subcommands(self, *group):
        """All commands below `group`, as the help lists them, each with its own; `group` itself where none is below it."""
        text = self.run_bare(*group, "--help").stdout
        listed = text.partition("Subcommands:\n")[2].partition("\n\n")[0]
        names = [line.split()[0] for line in listed.splitlines() if line.startswith("  ") and line[2] != " "]
        return [found for name in names for found in self.subcommands(*group, name)] or [(group, text)]

    def test_every_command_has_an_example_of_its_own(self):
        commands = self.subcommands()
        self.assertGreater(len(commands), 40)
        for command, text in commands:
            self.assertIn("Example:\n  soak " + " ".join(command), text)
            self.assertIn("--data DIR", text)

    def test_data_folder_comes_from_the_environment(self):
        self.soak("unit", "add", "SN1")
        self.assertIn("SN1", self.run_bare("unit", "list", SOAK_DATA=str(self.data)).stdout)
        home = self.folder / "xdg"
        home.mkdir()
        self.data.rename(home / "soak")
        self.assertIn("SN1", self.run_bare("unit", "list", SOAK_DATA="", XDG_DATA_HOME=str(home)).stdout)


if __name__ == "__main__":
    unittest.main()
