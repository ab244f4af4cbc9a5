# SPDX-License-Identifier: Apache-2.0
"""The quick statistics: right where their assumptions hold, wrong where visits scatter."""
import copy
import unittest

import numpy as np

import naive
from made_campaign import made


def with_readings(blocks, readings):
    other = copy.copy(blocks)
    other.readings = readings
    return other


def cubic_and_white_noise(blocks, seed=5):
    warmth = blocks.temp_c / 50.0
    noise = np.random.default_rng(seed).normal(0.0, 0.004, blocks.readings.shape)
    return (0.1 + 0.2 * warmth - 0.1 * warmth**2 + 0.05 * warmth**3)[:, None] + noise


class Naive(unittest.TestCase):
    def test_is_as_often_wrong_in_a_cubic_with_white_noise_as_its_gate_and_its_library_say(self):
        blocks, _ = made("mixed")
        named = sum(naive.quick_name(with_readings(blocks, cubic_and_white_noise(blocks, seed)))["name"] is not None
                    for seed in range(20))
        # 14 tests at 0.01 in each of 20: 2.8 false names, more than 8 with a chance of 0.002.
        self.assertLessEqual(named, 8)

    def test_names_what_is_added_to_a_cubic_with_white_noise(self):
        blocks, _ = made("mixed")
        readings = cubic_and_white_noise(blocks)
        readings[:, 1] += 0.01 * blocks.up[:, 2]
        self.assertEqual(naive.quick_name(with_readings(blocks, readings))["name"], "g_sensitivity")

    def test_names_a_cause_where_nothing_is_hidden_but_visits_drift(self):
        false = [naive.quick_name(made("drift x 3", seed=seed)[0])["name"] for seed in (1, 2, 3, 4)]
        self.assertGreaterEqual(sum(name is not None for name in false), 3, false)

    def test_memory_of_the_branch_saturates_after_the_width(self):
        temp_c = np.concatenate([np.arange(0.0, 100.0, 0.1), np.arange(100.0, 0.0, -0.1)])
        first = np.arange(len(temp_c)) == 0
        memory = naive.branch_memory(temp_c, first, 10.0)
        # h = 1 - e^(-T/w) on the way up, then from nearly +1: h = -1 + 2 e^(-(100 - T)/w).
        self.assertAlmostEqual(memory[100], 1.0 - np.exp(-1.0), delta=0.01)
        self.assertAlmostEqual(memory[1100], -1.0 + 2.0 * np.exp(-1.0), delta=0.01)

    def test_rate_is_the_slope_of_a_line(self):
        time_s = 30.0 * np.arange(50.0) + 1.7e9
        np.testing.assert_allclose(naive.smoothed_rate(time_s, 0.03 * (time_s - 1.7e9))[5:-5], 0.03, rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
