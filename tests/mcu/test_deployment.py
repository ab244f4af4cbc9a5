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


def compile_with(compiler, folder, *options):
    command = [compiler, "-std=c99", "-O2", "-ffp-contract=off", *WARNINGS, "-I", folder,
               "-I", os.path.join(SOURCE, "calib", "runtime"), *options,
               os.path.join(SOURCE, "docs", "examples", "deploy.c")]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def main():
    check_page()
    with tempfile.TemporaryDirectory() as folder:
        write_header(folder)
        program = os.path.join(folder, "deploy")
        compile_with("gcc", folder, "-o", program)
        assert subprocess.run([program], check=False).returncode == 0
        for compiler, options in (("clang-19", []), ("arm-none-eabi-gcc", ["-mcpu=cortex-m4", "-ffreestanding"])):
            if shutil.which(compiler):
                compile_with(compiler, folder, *options, "-c", "-o", os.path.join(folder, "deploy.o"))
    print("the page's code is the example's, which compiles and runs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
