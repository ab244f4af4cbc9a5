# SPDX-License-Identifier: Apache-2.0
"""A test program is run again exactly where something that decides its outcome has changed."""
import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

RUN_ONCE = pathlib.Path(__file__).resolve().parents[2] / "tools" / "run_once.py"


class RunOnce(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.runs = self.folder / "runs"
        self.data = self.folder / "data"
        self.data.mkdir()
        (self.data / "a.csv").write_text("1")
        self.program = self.folder / "program"
        self.write_program(exit_status=0)

    def write_program(self, exit_status):
        self.program.write_text(f'#!/bin/sh\necho run >> "{self.runs}"\necho "1 skipped"\nexit {exit_status}\n')
        self.program.chmod(self.program.stat().st_mode | stat.S_IXUSR)

    def run_it(self, **environment):
        command = [sys.executable, RUN_ONCE, self.folder / "note", self.data, "--", self.program, "--brief"]
        return subprocess.run(command, capture_output=True, text=True, env={**os.environ, "SOAK_TEST_DATA": str(self.folder / "none"), **environment})

    def count(self):
        return len(self.runs.read_text().splitlines())

    def test_what_has_passed_is_not_run_again_and_prints_the_same(self):
        first, second = self.run_it(), self.run_it()
        self.assertEqual((first.returncode, second.returncode, self.count()), (0, 0, 1))
        self.assertTrue(second.stdout.startswith(first.stdout))

    def test_what_has_failed_is_run_again(self):
        self.write_program(exit_status=3)
        self.assertEqual([self.run_it().returncode, self.run_it().returncode], [1, 1])
        self.assertEqual(self.count(), 2)

    def test_another_program_other_data_and_another_part_are_run(self):
        self.run_it()
        self.write_program(exit_status=0)
        self.program.write_text(self.program.read_text() + "# another\n")
        self.run_it()
        self.assertEqual(self.count(), 2)
        (self.data / "a.csv").write_text("2")
        self.run_it()
        self.assertEqual(self.count(), 3)
        (self.data / "b.csv").write_text("")
        self.run_it()
        self.assertEqual(self.count(), 4)
        self.run_it(GTEST_SHARD_INDEX="1")
        self.assertEqual(self.count(), 5)

    def test_a_pass_without_long_tests_is_none_with_them(self):
        self.run_it(SOAK_LONG_TESTS="")
        self.run_it(SOAK_LONG_TESTS="1")
        self.assertEqual(self.count(), 2)
        self.run_it(SOAK_LONG_TESTS="1")
        self.assertEqual(self.count(), 2)

    def test_a_pass_of_something_else_does_not_hide_a_failure(self):
        self.run_it()
        self.write_program(exit_status=1)
        self.assertEqual(self.run_it().returncode, 1)

    def test_a_damaged_note_runs_it(self):
        self.run_it()
        (self.folder / "note").write_text("{")
        self.assertEqual(self.run_it().returncode, 0)
        self.assertEqual(self.count(), 2)


if __name__ == "__main__":
    unittest.main()
