#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The runtime on an emulated Cortex-M4F gives the bits that it gives here; prints instructions per call."""
import os
import shutil
import subprocess
import sys

FILES = ["fis", "whole", "mixed", "table", "couplings", "moving"]
LINES = 1 + 347  # constants; -45 to 85 °C in steps of 3/8
APPLIED, MOVING, BANDS, REMEMBERED = slice(0, 6), slice(18, 24), slice(24, 36), slice(36, 42)  # of the numbers of a line
NAN = "7fc00000"
# soak_apply per sample may cost this many instructions; docs/deployment.md states fewer.
LIMITS = {"fis_apply": 8000, "table_apply": 2000, "table_bias": 150, "hundred_more": 101}


def run(*command):
    result = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert result.returncode == 0, result.stdout[-500:] + result.stderr[-500:]
    return (result.stdout + result.stderr).splitlines()


def on_microcontroller(program):
    """-icount shift=0: one instruction is one nanosecond of the emulated timer, whatever the host does."""
    return run("qemu-system-arm", "-machine", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none",
               "-icount", "shift=0", "-semihosting-config", "enable=on,target=native", "-kernel", program)


def on_host():
    arguments = []
    for name in FILES:
        folder = os.environ["MOVING" if name == "moving" else "GOLDEN"]
        arguments += [name, os.path.join(folder, name + ".soakcal")]
    return run(os.environ["MCU_HOST"], *arguments)


def counts(lines):
    """{name: instructions} of the lines `count NAME n`."""
    return {line.split()[1]: int(line.split()[2]) for line in lines if line.startswith("count ")}


def check_counts(found):
    assert found["hundred_more"] in (100, 101), found  # the counter counts instructions
    for name, limit in LIMITS.items():
        assert found[name] <= limit, (name, found[name])
    # A sample with a reading of the thermometer: at most twice what it costs without a history.
    assert found["history_step"] + found["history_apply"] <= 2 * found["moving_apply"], found


def check_reach(lines):
    """What is compared is there: uncertainties, couplings, and effects that move a sample."""
    numbers = {}
    for line in lines:
        name, temp, *_ = line.split()
        numbers[name, temp] = line.split()[-36:] if temp == "constants" else line.split()[-42:]
    assert set(numbers["couplings", "constants"][0:24]) - {NAN}, "uncertainties of couplings"
    near_25_c = "41c60000"  # 24.75 °C
    assert NAN not in numbers["fis", near_25_c][BANDS], "ci95 and pi95"
    assert numbers["couplings", near_25_c][MOVING] == numbers["couplings", near_25_c][APPLIED], "no effects"
    moved = [a != b for a, b in zip(numbers["moving", near_25_c][MOVING], numbers["moving", near_25_c][APPLIED])]
    assert moved == [True, False, True, True, True, True], moved  # the file has no gyro_y
    assert numbers["couplings", near_25_c][REMEMBERED] == numbers["couplings", near_25_c][APPLIED], "no history"
    remembered = [a != b for a, b in zip(numbers["moving", near_25_c][REMEMBERED], numbers["moving", near_25_c][MOVING])]
    assert remembered == [True, False, True, False, False, False], remembered


def main():
    program = os.environ["MCU_PROGRAM"]
    if not os.path.exists(program) or not shutil.which("qemu-system-arm"):
        print("skipped: needs the Debian packages gcc-arm-none-eabi and qemu-system-arm")
        return 0
    lines = on_microcontroller(program)
    values = [line for line in lines if line.split()[0] in FILES]
    expected = on_host()
    assert len(expected) == LINES * len(FILES), len(expected)
    check_reach(expected)
    assert len(values) == len(expected), lines[-3:]
    different = [(a, b) for a, b in zip(values, expected) if a != b]
    assert not different, different[:2]
    check_counts(counts(lines))
    print(f"{len(values)} lines of 36 or 42 values each: the same bits")
    print("\n".join(line for line in lines if line.startswith(("count ", "load "))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
