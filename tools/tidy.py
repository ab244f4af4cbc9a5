#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy-19 over all translation units of a build folder, two at a time.

A unit that passed is remembered by the hash of its preprocessed text and the configuration that applies to it, so only
what changed is checked again. Exit status 1 if any unit has a finding.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CACHE = os.path.join(os.environ.get("XDG_CACHE_HOME", os.path.expanduser("~/.cache")), "soak-tidy")


def configuration_of(source):
    """Text of all .clang-tidy files from the source's folder up to the root."""
    text, folder = "", os.path.dirname(source)
    while True:
        path = os.path.join(folder, ".clang-tidy")
        if os.path.exists(path):
            with open(path, encoding="utf-8") as f:
                text += f.read()
        if folder == ROOT or folder == os.path.dirname(folder):
            return text
        folder = os.path.dirname(folder)


def compiler_arguments(entry):
    """The compilation's arguments without launcher, output and precompiled header."""
    words = shlex.split(entry["command"])
    first = next(i for i, w in enumerate(words) if os.path.basename(w) in ("c++", "cc", "g++", "gcc", "clang++", "clang"))
    kept, skip = [], False
    for word, following in zip(words[first + 1:], words[first + 2:] + [""]):
        if skip:
            skip = False
        elif word in ("-o", "-MF", "-MT", "-c"):
            skip = True
        elif word == "-include" and "cmake_pch" in following:
            skip = True
        elif word not in ("-MD", "-Winvalid-pch", "-Wno-restrict", "-Wno-maybe-uninitialized") and "cmake_pch" not in word:
            kept.append(word)
    return words[first], kept


def check(entry):
    source = entry["file"]
    compiler, arguments = compiler_arguments(entry)
    text = subprocess.run([compiler, *arguments, "-E", "-P", source], cwd=entry["directory"], capture_output=True)
    if text.returncode != 0:
        return source, text.stderr.decode()
    with open(source, "rb") as f:  # comments (NOLINT) are not in the preprocessed text
        key = hashlib.sha256(text.stdout + f.read() + configuration_of(source).encode()).hexdigest()
    mark = os.path.join(CACHE, key)
    if os.path.exists(mark):
        return source, None
    arguments = [a for a in arguments if not a.startswith("-Werror")]
    result = subprocess.run(["clang-tidy-19", "--quiet", source, "--", *arguments], cwd=ROOT, capture_output=True, text=True)
    if result.returncode != 0 or "warning:" in result.stdout or "error:" in result.stdout:
        return source, result.stdout + result.stderr
    open(mark, "w").close()
    return source, None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", required=True, help="build folder with compile_commands.json")
    parser.add_argument("--skip-tests", action="store_true", help="leave out the units of tests/")
    parser.add_argument("paths", nargs="*", help="only units whose path contains one of these")
    options = parser.parse_args()
    os.makedirs(CACHE, exist_ok=True)
    with open(os.path.join(options.build, "compile_commands.json"), encoding="utf-8") as f:
        entries = [e for e in json.load(f) if "cmake_pch" not in e["file"]]
    if options.skip_tests:
        entries = [e for e in entries if not e["file"].startswith(os.path.join(ROOT, "tests") + os.sep)]
    if options.paths:
        entries = [e for e in entries if any(p in e["file"] for p in options.paths)]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", os.cpu_count() or 2))) as pool:
        for source, finding in pool.map(check, entries):
            if finding:
                failed += 1
                print(f"-- {os.path.relpath(source, ROOT)}\n{finding}")
    print(f"clang-tidy: {len(entries)} units, {failed} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
