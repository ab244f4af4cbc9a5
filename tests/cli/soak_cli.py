# SPDX-License-Identifier: Apache-2.0
"""What the tests of the command line share: running `soak` ($SOAK_BIN) in a data folder of its own."""
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from long_tests import long_test  # noqa: E402, F401 (the tests take it from here)

SCHEMAS = ROOT / "docs" / "schema"
HEADER = "t_s,run,phase,sweep,plateau_c,position,chamber_c,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2"


def shared_data(folder):
    """Path of a recording that is not part of the project, or None where it is absent."""
    base = os.environ.get("SOAK_TEST_DATA")
    path = (pathlib.Path(base) if base else ROOT.parent / "shared" / "data") / folder
    return path if path.is_dir() else None


def check_schema(document, name):
    schema = json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(document)


def recording(seed=1, run="r1", plateaus=(0.0, 40.0), seconds=90):
    """A small recording in six positions at each plateau, 2 Hz, bias of gx 0.1 + 0.01 T deg/s, noise 0.01."""
    noise = random.Random(seed)
    lines = [HEADER]
    t = 0.0
    ups = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
    for plateau in plateaus:
        for label, up in ups.items():
            for _ in range(2 * seconds):
                gyro = [0.1 + 0.01 * plateau + noise.gauss(0, 0.01), *(noise.gauss(0, 0.01) for _ in range(2))]
                force = [9.80665 * u + noise.gauss(0, 0.005) for u in up]
                numbers = ",".join(f"{x:.6f}" for x in gyro + force)
                lines.append(f"{t:.1f},{run},soak,up,{plateau},{label},{plateau + 0.5},{plateau + noise.gauss(0, 0.05):.3f},{numbers}")
                t += 0.5
    return "\n".join(lines) + "\n"


class SoakTest(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.mkdtemp(prefix="soak-test-")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        self.folder = pathlib.Path(folder)
        self.data = self.folder / "data"

    def write(self, name, text):
        path = self.folder / name
        if isinstance(text, bytes):
            path.write_bytes(text)
        else:
            path.write_text(text, encoding="utf-8", newline="")
        return path

    def command(self, *arguments):
        return [os.environ["SOAK_BIN"], *map(str, arguments), "--data", str(self.data)]

    def soak(self, *arguments, status=0, **options):
        """Runs soak and demands the exit status."""
        done = subprocess.run(self.command(*arguments), capture_output=True, text=True, timeout=120, check=False, **options)
        self.assertEqual(done.returncode, status, f"{arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def soak_json(self, schema, *arguments, status=0, **options):
        """Runs soak with --json and checks the document that it prints."""
        document = json.loads(self.soak(*arguments, "--json", status=status, **options).stdout)
        check_schema(document, schema)
        return document

    def refusal(self, *arguments, status=2, **options):
        """Runs soak with --json, demands that it fails and prints nothing but the error; returns that."""
        done = self.soak(*arguments, "--json", status=status, **options)
        self.assertEqual(done.stdout, "")
        document = json.loads(done.stderr)
        check_schema(document, "error")
        self.assertEqual(document["error"]["code"], status)
        return document["error"]

    def imported(self, name, text, *arguments):
        """Imports a CSV file and returns what was stored of its first run."""
        path = self.write(name, text)
        return self.soak_json("import", "import", path, "--unit", "SN1", *arguments)["runs"][0]

    def state(self):
        """Everything that the data folder holds: rows of the catalog, hashes of the run files."""
        if not self.data.exists():
            return None
        files = {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted((self.data / "runs").glob("*"))}
        catalog = self.data / "station.db"
        if not catalog.exists():
            return files, None
        # A copy: SQLite itself writes beside a database in WAL mode, even to read it.
        with tempfile.TemporaryDirectory() as copy:
            for path in self.data.glob("station.db*"):
                shutil.copy(path, copy)
            database = sqlite3.connect(pathlib.Path(copy) / "station.db")
            dump = list(database.iterdump())
            database.close()
        return files, dump


def limit_file_size(size):
    """A preexec_fn: every write beyond `size` bytes of a file fails with EFBIG, as if the disk were full."""
    import resource

    def set_limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return set_limit
