#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the 20 slowest tests of a JUnit file that ctest wrote, and the sum of all."""
import sys
import xml.etree.ElementTree as ElementTree


def main():
    cases = [(float(case.get("time") or 0), case.get("name")) for case in ElementTree.parse(sys.argv[1]).iter("testcase")]
    print(f"== {len(cases)} tests, {sum(seconds for seconds, _ in cases):.0f} s if run one after the other; the slowest:")
    for seconds, name in sorted(cases, reverse=True)[:20]:
        print(f"{seconds:7.1f} s  {name}")


if __name__ == "__main__":
    main()
