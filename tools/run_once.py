#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""run_once.py NOTE PATH... -- PROGRAM ARG...: runs a program whose outcome depends on nothing but itself, its libraries, its arguments, the
files named (folders: all in them), the compilers that it may call, and the recordings in $SOAK_TEST_DATA: tests of rooms that touch no
clock, device or thread. Where the same has passed before, it is not run again: what it printed then is printed again. NOTE: a file that
keeps the key of the last pass and what was printed. A fresh build folder has none, so there everything runs."""
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

SETTINGS = ("ASAN_", "GTEST_", "LANG", "LC_", "PATH", "SOAK_", "UBSAN_")  # variables that begin so
COMPILERS = ("cc", "gcc", "clang", "clang-19")
RECORDINGS = os.environ.get("SOAK_TEST_DATA") or os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "shared", "data")


def files_in(path):
    """The files of a folder in a fixed order; a file itself."""
    if not os.path.isdir(path):
        return [path]
    return sorted(os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names)


def libraries_of(program):
    """The shared libraries that it is linked with; none where it is no such program."""
    listed = subprocess.run(["ldd", program], capture_output=True, text=True)
    return re.findall(r"(/\S+) \(0x", listed.stdout)


def key_of(command, paths):
    """Changes with everything that the program's outcome depends on."""
    key = hashlib.sha256()
    for path in [command[0], *(file for path in paths for file in files_in(path))]:
        key.update(path.encode() + b"\0")
        with open(path, "rb") as file:
            key.update(hashlib.sha256(file.read()).digest())
    for word in [*command, *(f"{name}={value}" for name, value in sorted(os.environ.items()) if name.startswith(SETTINGS))]:
        key.update(word.encode() + b"\0")
    # Of what is large, and not the project's, names, sizes and dates do.
    others = libraries_of(command[0]) + [os.path.realpath(found) for found in map(shutil.which, COMPILERS) if found]
    for file in others + (files_in(RECORDINGS) if os.path.isdir(RECORDINGS) else []):
        state = os.stat(file)
        key.update(f"{file}\0{state.st_size}\0{state.st_mtime_ns}\0".encode())
    return key.hexdigest()


def passed_before(note, key):
    """What was printed when the same passed; None where it has not."""
    try:
        with open(note, encoding="utf-8") as file:
            before = json.load(file)
        return before["printed"] if before["key"] == key else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def main():
    split = sys.argv.index("--")
    note, paths, command = sys.argv[1], sys.argv[2:split], sys.argv[split + 1:]
    key = key_of(command, paths)
    printed = passed_before(note, key)
    if printed is not None:
        print(printed + "passed before: the same program, the same data")
        return 0
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    print(done.stdout, end="")
    if done.returncode == 0:
        with open(note + ".new", "w", encoding="utf-8") as file:
            json.dump({"key": key, "printed": done.stdout}, file)
        os.replace(note + ".new", note)
    return 1 if done.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
