# SPDX-License-Identifier: Apache-2.0
"""docs/examples, copied out of the tree, builds by the commands of docs/library.md against what `cmake --install` puts into an empty
folder, and says what is known from elsewhere: Allan deviations of white noise, the values of a golden calibration file."""
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "tests" / "data" / "golden"
SENSORS = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]


def run(*command, cwd=None):
    done = subprocess.run(list(map(str, command)), cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{command}: status {done.returncode}\n{done.stdout}\n{done.stderr}")
    return done.stdout


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-install-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        prefix, source = cls.folder / "prefix", cls.folder / "examples"
        shutil.copytree(ROOT / "docs" / "examples", source)
        cls.build = cls.folder / "build"
        os.environ |= {"CMAKE_GENERATOR": "Ninja", "CMAKE_BUILD_TYPE": "Release"}
        os.environ.setdefault("CMAKE_BUILD_PARALLEL_LEVEL", os.environ.get("JOBS", "2"))
        page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
        commands = re.findall(r"^    (cmake .*)$", page, re.MULTILINE)
        if len(commands) != 3:
            raise AssertionError(f"install, configure and build were expected: {commands}")
        for command in commands:
            for word, path in (("build/release", os.environ["SOAK_RELEASE_BUILD"]), ("docs/examples", source),
                               ("build-examples", cls.build), ("~/soak", prefix)):
                command = command.replace(word, str(path))
            run(*shlex.split(command))

    def test_nothing_private_is_installed(self):
        installed = [path.relative_to(self.folder) for path in (self.folder / "prefix").rglob("*.h")]
        self.assertGreater(len(installed), 20)
        self.assertEqual([str(path) for path in installed if "detail" in path.parts], [])

    def test_a_curve_is_learned(self):
        self.assertIn("rules", run(self.build / "anfis_curve"))

    def test_allan_deviations_of_white_noise_are_right(self):
        self.assertEqual(len(run(self.build / "allan_deviation").splitlines()), 3)

    def test_a_calibration_file_is_read(self):
        values = json.loads((GOLDEN / "fis.values.json").read_text(encoding="utf-8"))["sensors"]["gyro_x"]
        for point in values[:: len(values) // 5]:
            lines = run(self.build / "read_calibration", GOLDEN / "fis.soakcal", point["temp_c"]).splitlines()
            read = {SENSORS[int(line.split()[0])]: float(line.split()[1]) for line in lines}
            self.assertAlmostEqual(read["gyro_x"], point["bias"], delta=1e-8)  # float32 of 0.013 rad/s


if __name__ == "__main__":
    unittest.main()
