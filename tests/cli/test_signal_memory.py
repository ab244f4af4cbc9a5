# SPDX-License-Identifier: Apache-2.0
"""What docs/signal.md says of the memory that soak signal allan takes, in proportion: by the release program."""
import os
import random
import subprocess
import tempfile
import unittest

BLOCK = 4000  # rows


def rows(block, values, times):
    if not times:
        return "\n".join(values) + "\n"
    return "".join(f"{(block * BLOCK + i) / 200.0:.3f},{v}\n" for i, v in enumerate(values))


def peak_bytes(blocks, times):
    """Most memory that the program had at once, with a file of so many blocks of rows at 200 Hz."""
    noise = random.Random(5)
    values = [f"{noise.gauss(0.0, 0.1):.4f}" for _ in range(BLOCK)]
    with tempfile.NamedTemporaryFile("w", suffix=".csv", encoding="utf-8") as file:
        file.write("t_s,gx_dps\n" if times else "gx_dps\n")
        for block in range(blocks):
            file.write(rows(block, values, times))
        file.flush()
        rate = [] if times else ["--rate-hz", "200"]
        # Blocks of memory go back to the system as the large ones of long records do.
        program = subprocess.Popen([os.environ["SOAK_BIN"], "signal", "allan", file.name, "--column", "gx_dps", "--json", *rate],
                                   stdout=subprocess.DEVNULL, env={**os.environ, "MALLOC_MMAP_THRESHOLD_": "262144"})
        _, status, usage = os.wait4(program.pid, 0)
        program.returncode = os.waitstatus_to_exitcode(status)
    if program.returncode != 0:
        raise AssertionError(f"exit status {program.returncode}")
    return 1024 * usage.ru_maxrss


class Memory(unittest.TestCase):
    def test_allan_takes_what_the_page_says_for_each_sample(self):
        # From some two million samples on the rest no longer matters. 1.8, 3.6 and 14.4 million fill the same 86 % of a power of
        # two: arrays that double as they grow are equally full. Measured 24.3 and 35.0 bytes, a tenth more is asked for.
        for times, most in ((False, 27.0), (True, 38.5)):
            few, many = 450, 900
            per_sample = (peak_bytes(many, times) - peak_bytes(few, times)) / ((many - few) * BLOCK)
            self.assertGreater(per_sample, 16.0, "samples and phase alone")
            self.assertLess(per_sample, most)


if __name__ == "__main__":
    unittest.main()
