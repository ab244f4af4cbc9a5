#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy-19 over all translation units of build folders, two at a time; batches of sources (unity builds) as such: the
headers, which take most of the time, are read once for all of them.

What passed is known twice. On this machine by the hash of the preprocessed text and the configuration that applies to
it. In the tree (tidy_passed.txt) by the hash of the unit, of all headers of the tree that it includes, and of the
configuration: so that a fresh checkout checks what changed since that was written. --full asks clang-tidy whatever the
tree says, --record writes down what passed. Exit status 1 if any unit has a finding.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RECORD = os.path.join(ROOT, "tools", "tidy_passed.txt")
CACHE = os.path.join(os.environ.get("XDG_CACHE_HOME", os.path.expanduser("~/.cache")), "soak-tidy")


def is_test(source):
    """A source of tests/, or a batch of such."""
    return source.startswith(os.path.join(ROOT, "tests") + os.sep) or "/tests/CMakeFiles/" in source


def configuration_of(source):
    """Text of all .clang-tidy files from the source's folder, for a batch of tests from theirs, up to the root."""
    text, folder = "", os.path.join(ROOT, "tests") if is_test(source) and is_batch(source) else os.path.dirname(source)
    while True:
        path = os.path.join(folder, ".clang-tidy")
        if os.path.exists(path):
            with open(path, encoding="utf-8") as f:
                text += f.read()
        if folder == ROOT or folder == os.path.dirname(folder):
            return text
        folder = os.path.dirname(folder)


def included(source, found):
    """The unit and all headers of the tree that it includes, directly or not."""
    if source in found or not os.path.isfile(source):
        return
    with open(source, "rb") as f:
        found[source] = f.read().replace(ROOT.encode() + b"/", b"")  # a batch names its sources by absolute paths
    for name in re.findall(rb'^\s*#\s*include\s*"([^"]+)"', found[source], re.M):
        for folder in (ROOT, os.path.dirname(source)):
            included(os.path.normpath(os.path.join(folder, name.decode())), found)


def key_in_tree(source):
    found = {}
    included(source, found)
    key = hashlib.sha256(("clang-tidy-19" + configuration_of(source)).encode())
    for path in sorted(found):
        key.update(os.path.relpath(path, ROOT).encode() + b"\0" + found[path] + b"\0")
    return key.hexdigest()


def passed_in_tree():
    if not os.path.exists(RECORD):
        return set()
    with open(RECORD, encoding="utf-8") as f:
        return {line.split()[0] for line in f}


def record(sources):
    lines = sorted(f"{key_in_tree(source)} {os.path.relpath(source, ROOT)}\n" for source in sources)
    with open(RECORD, "w", encoding="utf-8") as f:
        f.writelines(sorted(lines, key=lambda line: line.split()[1]))


def is_batch(source):
    return "/Unity/" in source


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
        elif word.startswith("--param"):  # only g++ knows them
            continue
        elif word not in ("-MD", "-Winvalid-pch", "-Wno-restrict", "-Wno-maybe-uninitialized",
                          "-Wno-subobject-linkage") and "cmake_pch" not in word:
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
    batch = ["--checks=-bugprone-suspicious-include"] if is_batch(source) else []
    if batch and is_test(source):
        batch += [f"--config-file={os.path.join(ROOT, 'tests', '.clang-tidy')}", "--header-filter=.*/tests/.*"]
    result = subprocess.run(["clang-tidy-19", "--quiet", *batch, source, "--", *arguments], cwd=ROOT, capture_output=True, text=True)
    if result.returncode != 0 or "warning:" in result.stdout or "error:" in result.stdout:
        return source, result.stdout + result.stderr
    open(mark, "w").close()
    return source, None


def units_of(builds):
    """Compilations of sources of the tree and of batches of them; not of what a build generates."""
    entries, batches = {}, set()
    for build in builds:
        with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as f:
            for entry in json.load(f):
                source = entry["file"]
                key = source.split("/CMakeFiles/")[-1]  # a batch has the same name in each build
                generated = source.startswith(os.path.join(ROOT, "build") + os.sep) and not is_batch(source)
                if not generated and key not in batches:
                    batches.add(key)
                    entries[source] = entry
    return list(entries.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", required=True, action="append", help="build folder with compile_commands.json; of several, each source "
                        "counts once, in the first that has it")
    parser.add_argument("--skip-tests", action="store_true", help="leave out the units of tests/")
    parser.add_argument("--full", action="store_true", help="also what the tree says has passed")
    parser.add_argument("--record", action="store_true", help="write what passed into the tree")
    parser.add_argument("paths", nargs="*", help="only units whose path contains one of these")
    options = parser.parse_args()
    os.makedirs(CACHE, exist_ok=True)
    entries = units_of(options.build)
    if options.skip_tests:
        entries = [e for e in entries if not is_test(e["file"])]
    if options.paths:
        entries = [e for e in entries if any(p in e["file"] for p in options.paths)]
    known = set() if options.full else passed_in_tree()
    passed = [e["file"] for e in entries if known and key_in_tree(e["file"]) in known]
    entries = [e for e in entries if e["file"] not in set(passed)]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", os.cpu_count() or 2))) as pool:
        for source, finding in pool.map(check, entries):
            if finding:
                failed += 1
                print(f"-- {os.path.relpath(source, ROOT)}\n{finding}")
            else:
                passed.append(source)
    if options.record:
        record(passed)
    print(f"clang-tidy: {len(entries)} units, {failed} with findings; {len(passed) - len(entries) + failed} as they were")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
