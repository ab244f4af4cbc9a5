#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""slowest_tests.py CTEST.xml FOLDER: prints the 20 slowest tests of a run of ctest. Programs that run in parts wrote their single
tests into FOLDER; other tests count as ctest timed them."""
import glob
import os
import sys
import xml.etree.ElementTree as ElementTree


def cases(path, parts=frozenset()):
    for case in ElementTree.parse(path).iter("testcase"):
        group, name = case.get("classname") or "", case.get("name")
        if name not in parts:
            yield float(case.get("time") or 0), name if group in ("", name) else f"{group}.{name}"


def main():
    results = glob.glob(os.path.join(sys.argv[2], "*.xml"))
    parts = {os.path.splitext(os.path.basename(path))[0] for path in results}
    found = list(cases(sys.argv[1], parts))
    for path in results:
        found += cases(path)
    print(f"== {len(found)} tests, {sum(seconds for seconds, _ in found):.0f} s if run one after the other; the slowest:")
    for seconds, name in sorted(found, reverse=True)[:20]:
        print(f"{seconds:7.1f} s  {name}")


if __name__ == "__main__":
    main()
