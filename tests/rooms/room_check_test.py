# SPDX-License-Identifier: Apache-2.0
"""A forbidden include of each kind must fail the compilation; an allowed one must pass."""
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FLAGS = ["-std=c++20", "-I", ROOT, "-isystem", "/usr/include/eigen3"]


def compile_in_room(room, text):
    """Compiles `text` as a file of `room` through the launcher; returns (status, messages, object exists)."""
    with tempfile.TemporaryDirectory(dir=os.path.join(ROOT, room), prefix=".check-") as folder:
        source, target = os.path.join(folder, "probe.cpp"), os.path.join(folder, "probe.o")
        with open(source, "w", encoding="utf-8") as f:
            f.write(text)
        result = subprocess.run(
            [sys.executable, os.path.join(ROOT, "tools", "room_check.py"), "--room", room, "--", "g++", *FLAGS, "-MD",
             "-MT", target, "-MF", target + ".d", "-o", target, "-c", source], capture_output=True, text=True)
        return result.returncode, result.stderr, os.path.exists(target)


def includes_below(folder):
    """(source, what it includes) of every quoted or angled include of C and C++ files below `folder`."""
    for path, _, names in os.walk(os.path.join(ROOT, folder)):
        for name in sorted(names):
            if name.endswith((".h", ".hpp", ".c", ".cpp")):
                source = os.path.join(path, name)
                with open(source, encoding="utf-8") as f:
                    for include in re.findall(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', f.read(), re.M):
                        yield os.path.relpath(source, ROOT), include


class RoomCheck(unittest.TestCase):
    def refuse(self, room, include, reason):
        status, messages, exists = compile_in_room(room, f"#include {include}\n")
        self.assertEqual(status, 1, messages)
        self.assertIn(reason, messages)
        self.assertFalse(exists, "the object of a refused compilation must not stay")

    def accept(self, room, include):
        status, messages, exists = compile_in_room(room, f"#include {include}\n")
        self.assertEqual(status, 0, messages)
        self.assertTrue(exists)

    def test_room_that_is_not_allowed(self):
        self.refuse("base", '"calib/vocabulary/sensor.h"', "does not depend on 'calib'")
        self.refuse("anfis", '"calib/vocabulary/sensor.h"', "does not depend on 'calib'")
        self.refuse("calib", '"db/run/sample.h"', "does not depend on 'db'")
        self.refuse("station", '"hal/sim/unit/thermal_curve.h"', "does not depend on 'hal/sim'")

    def test_library_that_is_not_allowed(self):
        self.refuse("base", "<Eigen/Core>", "library 'eigen'")
        self.refuse("calib", "<sqlite3.h>", "library 'sqlite'")
        self.refuse("hal/sim", "<nlohmann/json.hpp>", "library 'json'")

    def test_more_than_the_vocabulary(self):
        self.refuse("db", '"calib/estimate/six_position.h"', "only the vocabulary of 'calib'")
        self.refuse("hal/sim", '"calib/curve/curve_fit.h"', "only the vocabulary of 'calib'")

    def test_simulation_and_estimation_share_nothing_but_the_vocabulary(self):
        with open(os.path.join(ROOT, "cmake", "rooms.toml"), "rb") as f:
            table = tomllib.load(f)
        self.assertEqual(set(table["room"]["hal/sim"]["rooms"]), {"base", "settings", "calib:vocabulary"})
        for folder, foreign, allowed in (("hal/sim", ("calib/", "anfis/", "nav/"), table["vocabulary"]),
                                         ("calib", ("hal/",), ()), ("anfis", ("hal/",), ())):
            for source, include in includes_below(folder):
                self.assertTrue(not include.startswith(foreign) or (allowed and include.startswith(allowed)), f"{source} includes {include}")
        self.refuse("calib", '"hal/sim/effects/conditions.h"', "does not depend on 'hal/sim'")
        self.refuse("hal/sim", '"calib/estimate/six_position.h"', "only the vocabulary of 'calib'")

    def test_a_stage_includes_only_stages_before_it(self):
        with open(os.path.join(ROOT, "cmake", "rooms.toml"), "rb") as f:
            rooms = tomllib.load(f)["room"]
        for room, stages in ((name, entry["stages"]) for name, entry in rooms.items() if "stages" in entry):
            seen = set()
            for source, include in includes_below(room):
                stage, other = (path[len(room) + 1:].split("/")[0] for path in (source, include))
                if not include.startswith(room + "/") or stage not in stages or other not in stages:
                    continue
                seen |= {stage, other}
                self.assertLessEqual(stages.index(other), stages.index(stage), f"{source} includes {include}")
            self.assertEqual(seen, set(stages), room)

    def test_private_part_of_another_room(self):
        self.refuse("station", '"calib/curve/detail/curve_budget.h"', "private part of 'calib'")

    def test_file_or_clock_in_a_pure_room(self):
        self.refuse("calib", "<fstream>", "pure")
        self.refuse("anfis", "<chrono>", "pure")

    def test_allowed_includes_pass(self):
        self.accept("db", '"calib/vocabulary/segment.h"')
        self.accept("calib", '"anfis/linear/least_squares.h"')

    def test_table_names_every_room_of_the_tree(self):
        with open(os.path.join(ROOT, "cmake", "rooms.toml"), "rb") as f:
            rooms = tomllib.load(f)["room"]
        for folder in ("base", "anfis", "calib", "db", "station", "hal/sim"):
            self.assertIn(folder, rooms)


if __name__ == "__main__":
    unittest.main()
