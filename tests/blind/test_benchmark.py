# SPDX-License-Identifier: Apache-2.0
"""The program itself, on a handful of campaigns through soak."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(__file__).with_name("benchmark.py")
SMALL = ["--nulls", "1", "--seeds", "1", "--stress-seeds", "0", "--pair-seeds", "0", "--unknown-seeds", "0", "--magnitudes", "1.2",
         "--first", "40", "--jobs", "1"]


def run(*arguments):
    bin_folder = pathlib.Path(os.environ["SOAK_BIN"]).parent
    return subprocess.run([sys.executable, "-B", str(PROGRAM), "--bin", str(bin_folder), *map(str, arguments)],
                          capture_output=True, text=True, check=False)


class Benchmark(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="soak-blind-test-")
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "verdicts.jsonl"

    def records(self):
        return [json.loads(line) for line in self.file.read_text(encoding="utf-8").splitlines()]

    def judge(self, cells, *more):
        done = run(*SMALL, "--cells", cells, "-o", self.file, *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_keeps_a_line_per_campaign_and_goes_on_where_it_stopped(self):
        self.judge("^null/three$")
        first, = self.records()
        self.assertEqual((first["cell"], first["verdict"], first["names"]), ("null/three", "none", []))
        self.assertEqual(len(first["oracle"]), 2)
        self.assertEqual(set(first["cpu_s"]), {"generate", "import", "fit", "find", "judge"})
        with open(self.file, "a", encoding="utf-8") as file:
            file.write('{"cell": "null/th')  # a run that was killed while it wrote
        tables = self.judge("^null/three$|^named/three/fixture_tilt", "--resume")
        lines = self.file.read_text(encoding="utf-8").splitlines()
        self.assertEqual([len(lines), json.loads(lines[0]), json.loads(lines[2])["cell"]], [3, first, "named/three/fixture_tilt/1.2"])
        self.assertEqual(run("--tables", self.file).stdout, tables)
        self.assertIn("2 campaigns", tables)

    def test_refuses_to_add_to_a_file_unasked(self):
        self.file.write_text("", encoding="utf-8")
        done = run(*SMALL, "--cells", "^null/three$", "-o", self.file)
        self.assertEqual(done.returncode, 1)
        self.assertIn("--resume goes on with it", done.stderr)

    def test_seeds_do_not_depend_on_what_is_left_out(self):
        self.judge("^one/one$")
        record, = self.records()
        self.assertEqual(record["verdict"], "cannot_judge")
        cells = run(*SMALL, "--list").stdout.splitlines()
        self.assertEqual(record["seed"], 40 + [line.split()[1] for line in cells].index("one/one"))


if __name__ == "__main__":
    unittest.main()
