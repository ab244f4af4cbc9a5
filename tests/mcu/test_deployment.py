#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every line of C in docs/deployment.md stands in docs/examples/deploy.c, which compiles and does what the page says."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE = os.environ["SOAK_SOURCE"]
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror"]


def read(*path, mode="r"):
    with open(os.path.join(SOURCE, *path), mode) as file:
        return file.read()


def check_page():
    blocks = re.findall(r"```c\n(.*?)```", read("docs", "deployment.md"), re.DOTALL)
    assert len(blocks) >= 5, len(blocks)
    program = read("docs", "examples", "deploy.c")
    for block in blocks:
        for part in block.strip().split("\n\n"):
            assert part.strip("\n") in program, "not in docs/examples/deploy.c:\n" + part


def write_header(folder):
    """The golden file in the form of `soak export --format c`."""
    data = read("tests", "data", "golden", "fis.soakcal", mode="rb")
    with open(os.path.join(folder, "SN-0001.h"), "w", encoding="ascii") as file:
        file.write('#include "soak_runtime.h"\n')
        file.write("static const uint8_t soak_calibration_SN_0001[] = {" + ",".join(map(str, data)) + "};\n")


def write_signed(folder):
    """The signed golden file behind 16 free bytes, and the public key of RFC 8032 section 7.1."""
    data = bytes(16) + read("tests", "data", "golden", "signed.soakcal", mode="rb")
    key = bytes.fromhex("d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a")
    with open(os.path.join(folder, "signed.h"), "w", encoding="ascii") as file:
        file.write("static uint8_t room[] = {" + ",".join(map(str, data)) + "};\n")
        file.write("static const uint8_t key[32] = {" + ",".join(map(str, key)) + "};\n")


def compile_with(compiler, folder, *options, libraries=()):
    command = [compiler, "-std=c99", "-O2", "-ffp-contract=off", *WARNINGS, "-I", folder,
               "-I", os.path.join(SOURCE, "calib", "runtime"), *options,
               os.path.join(SOURCE, "docs", "examples", "deploy.c"), *libraries]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def main():
    check_page()
    with tempfile.TemporaryDirectory() as folder:
        write_header(folder)
        write_signed(folder)
        program = os.path.join(folder, "deploy")
        for options, libraries in (((), ()), (("-DDEPLOY_WITH_SODIUM",), ("-lsodium",))):
            compile_with("gcc", folder, *options, "-o", program, libraries=libraries)
            assert subprocess.run([program], check=False).returncode == 0
        for compiler, options in (("clang-19", []), ("arm-none-eabi-gcc", ["-mcpu=cortex-m4", "-ffreestanding"])):
            if shutil.which(compiler):
                compile_with(compiler, folder, *options, "-c", "-o", os.path.join(folder, "deploy.o"))
    print("the page's code is the example's, which compiles and runs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
