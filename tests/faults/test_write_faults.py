#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`soak import` before a disk whose N-th change fails: every seventh of a sweep; tools/prove/write-faults does all of it."""
import unittest

from faulty_disk import DiskTest, sweep_import

EVERY = 7


class WriteFaults(DiskTest):
    def test_a_full_disk_leaves_catalog_and_files_whole(self):
        self.assertGreater(sweep_import(self, "ENOSPC", True, range(1, 10000, EVERY)), 5)

    def test_an_error_of_one_change_leaves_catalog_and_files_whole(self):
        self.assertGreater(sweep_import(self, "EIO", False, range(3, 10000, EVERY)), 5)


if __name__ == "__main__":
    unittest.main()
