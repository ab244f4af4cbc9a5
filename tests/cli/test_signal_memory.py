# SPDX-License-Identifier: Apache-2.0
"""What docs/signal.md says of the memory that soak signal allan takes, in proportion: by the release program."""
import os
import random
import subprocess
import tempfile
import unittest

BLOCK = 4000  # rows


def peak_bytes(blocks, times):
    """Most memory that the program had at once, with a file of so many blocks of rows at 200 Hz."""
    noise = random.Random(5)
    values = [f"{noise.gauss(3.0, 0.5):.4f}" for _ in range(BLOCK)]
    with tempfile.NamedTemporaryFile("w", suffix=".csv", encoding="utf-8") as file:
        file.write("t_s,gx_dps\n" if times else "gx_dps\n")
        for block in range(blocks):
            rows = (f"{(block * BLOCK + i) / 200.0:.3f},{v}" for i, v in enumerate(values)) if times else values
            file.write("\n".join(rows) + "\n")
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
    def test_allan_takes_some_forty_bytes_a_sample(self):
        # Both counts, and 14.4 million, fill the same 86 % of a power of two: arrays that double as they grow are equally full.
        for times in (False, True):
            few, many = 56, 224
            per_sample = (peak_bytes(many, times) - peak_bytes(few, times)) / ((many - few) * BLOCK)
            self.assertGreater(per_sample, 8.0, "not even the samples")
            self.assertLess(per_sample, 44.0, times)


if __name__ == "__main__":
    unittest.main()
