# SPDX-License-Identifier: Apache-2.0
"""Tests that `./run test` leaves to `./run prove long-tests`: each has a sibling that shows the main of it."""
import os
import unittest

LONG_TESTS = bool(os.environ.get("SOAK_LONG_TESTS"))
REASON = "long: ./run prove long-tests"
long_test = unittest.skipUnless(LONG_TESTS, REASON)
