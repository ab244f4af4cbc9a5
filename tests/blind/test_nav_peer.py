# SPDX-License-Identifier: Apache-2.0
"""A sample of `./run prove nav-peer`: the drive that is made up. Without errors of the unit the peer and Soak come back to it, and the peer learns constant biases; its real drive
is left to the proof."""
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class NavPeer(unittest.TestCase):
    def test_peer_and_soak_come_back_to_a_drive_without_errors(self):
        with tempfile.TemporaryDirectory() as empty:
            done = subprocess.run([ROOT / "tools" / "prove" / "nav-peer", "--soak", os.environ["SOAK_BIN"]], capture_output=True, text=True, check=False,
                                  timeout=250, env={**os.environ, "SOAK_TEST_DATA": empty})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
