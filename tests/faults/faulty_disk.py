# SPDX-License-Identifier: Apache-2.0
"""`soak` before a disk that fails on purpose or that tells what it was asked ($SOAK_DISK_LAYER, built from disk_layer.c)."""
import errno
import os
import pathlib
import shutil
import subprocess
import sys

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS), str(TESTS / "cli")]
from long_tests import LONG_TESTS  # noqa: E402, F401 (the tests take it from here)
from soak_cli import SoakTest, recording  # noqa: E402

ERRORS = {"ENOSPC": errno.ENOSPC, "EIO": errno.EIO}


class DiskTest(SoakTest):
    def before_disk(self, *arguments, fail_at=None, error="EIO", from_there=False):
        """Runs soak; returns how it ended and what the disk was asked, one list of words for each change."""
        log = self.folder / "disk.log"
        log.unlink(missing_ok=True)
        env = {**os.environ, "LD_PRELOAD": os.environ["SOAK_DISK_LAYER"], "SOAK_DISK_FOLDER": str(self.folder), "SOAK_DISK_LOG": str(log)}
        if fail_at is not None:
            env.update(SOAK_DISK_FAIL_AT=str(fail_at), SOAK_DISK_ERROR=str(ERRORS[error]))
        if from_there:
            env["SOAK_DISK_FROM_THERE"] = "1"
        done = subprocess.run(self.command(*arguments), capture_output=True, text=True, timeout=120, check=False, env=env)
        changes = [line.split(" ") for line in log.read_text(encoding="utf-8").splitlines()] if log.exists() else []
        return done, changes

    def import_arguments(self, name, seed=1):
        path = self.folder / f"{name}.csv"
        if not path.exists():
            self.write(path.name, recording(seed, name, seconds=10))
        return ["import", path, "--unit", "SN1", "--campaign", "c", "--gravity-mps2", "9.80665"]


def sweep_import(test, error, from_there, numbers):
    """Imports a second run with the change of each number failing; returns how many of them were hit. What must hold each time: no
    crash; the run that was sealed before is whole; catalog and files agree; the import succeeds once the disk does."""
    test.soak(*test.import_arguments("r1"))
    before = test.soak_json("runs-list", "runs", "list")["runs"]
    second = test.import_arguments("r2", 2)
    sound = test.folder / "sound"
    shutil.rmtree(sound, ignore_errors=True)
    test.data.rename(sound)
    hit = 0
    for number in numbers:
        shutil.rmtree(test.data, ignore_errors=True)
        shutil.copytree(sound, test.data)
        done, changes = test.before_disk(*second, fail_at=number, error=error, from_there=from_there)
        where = f"change {number}, {error}, from there on: {from_there}: status {done.returncode}\n{done.stderr}"
        if not any(change[0] == "failed" for change in changes):
            test.assertEqual(done.returncode, 0, where)
            break
        hit += 1
        with test.subTest(where):
            test.assertIn(done.returncode, (0, 1))
            test.soak_json("runs-verify", "runs", "verify")
            after = test.soak_json("runs-list", "runs", "list")["runs"]
            test.assertEqual([run for run in after if run["run"] == "r1"], before)
            test.assertEqual(done.returncode == 0, len(after) == 2)
            files = {path.name for path in (test.data / "runs").glob("*.soakrun")}
            test.assertEqual(files, {run["file"] for run in after})
            test.soak(*second)
            test.assertEqual(len(test.soak_json("runs-verify", "runs", "verify")["runs"]), 2)
    shutil.rmtree(test.data, ignore_errors=True)
    return hit
