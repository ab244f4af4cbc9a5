# SPDX-License-Identifier: Apache-2.0
"""The second laboratory's oracle: its noise against draws of that laboratory, its ratio against brute force, its names."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np
from scipy import linalg, stats

sys.path.insert(0, str(Path(__file__).resolve().parent))
import second_laboratory as lab  # noqa: E402
import second_oracle as oracle  # noqa: E402

CANDIDATES = ("temperature_rate", "gradient", "g_sensitivity", "step", "sensor_lag")
SLOW = lab.Design(spacing_k=20, dwell_min=12, slow=1.25, placement=0.3, visit=0.4)


def squares_left(columns, values):
    return float(np.sum((values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]) ** 2))


class Noise(unittest.TestCase):
    def test_is_white_once_whitened(self):
        for kind, size in (("gauss_markov", 1.25), ("flicker", 0.75), ("random_walk", 1.0)):
            with self.subTest(kind):
                design = lab.Design(spacing_k=20, dwell_min=12, slow_kind=kind, slow=size, placement=0.3, visit=0.4)
                log = lab.campaign_log(3, design)
                campaign = lab.Campaign(design, log, np.zeros(0), np.zeros(0), {})
                blocks = lab.block_means(log, lab.noise(3, design, log))
                white = oracle.Whitening(campaign)
                offsets = oracle.orthonormal(white(oracle.base_columns(log, None)))
                left = white(blocks)
                left -= offsets @ (offsets.T @ left)
                free = left.size * (1 - offsets.shape[1] / len(left))
                # chi-squared over its degrees of freedom: a standard deviation of sqrt(2 / free)
                self.assertAlmostEqual(np.sum(left**2) / free, 1.0, delta=4 * np.sqrt(2 / free))
                pairs = np.sum(left[1:] * left[:-1]) / free
                self.assertAlmostEqual(pairs, 0.0, delta=4 / np.sqrt(free) + offsets.shape[1] / len(left))


class Names(unittest.TestCase):
    def test_ratio_is_that_of_a_fit_with_the_whole_covariance(self):
        campaign = lab.make(5, SLOW, "temperature_rate", 0.6)
        shapes = oracle.courses(campaign, 5, CANDIDATES, 0.6)
        found = oracle.ratios(*oracle.normal_equations(campaign, 5, shapes))
        log = campaign.log
        first = log.in_blocks[::lab.BLOCK_SAMPLES]
        roots = []
        for run in range(len(log.slices)):
            rows = first[log.run[first] == run]
            roots.append(linalg.cholesky(oracle.covariance(SLOW, log.t_s[rows].astype(float), log.visit[rows], log.stay[rows]), lower=True))
        root = linalg.block_diag(*roots)
        readings = oracle.readings_in_blocks(campaign, 5)
        for name in ("temperature_rate", "g_sensitivity"):
            k = CANDIDATES.index(name)
            sensors = [s for s in range(6) if np.any(shapes[k][:, s])]
            bases = [linalg.solve_triangular(root, oracle.base_columns(log, s - 3 if s > 2 else None), lower=True) for s in sensors]
            base = linalg.block_diag(*[b / np.linalg.norm(b, axis=0).clip(1e-300) for b in bases])
            values = np.concatenate([linalg.solve_triangular(root, readings[:, s], lower=True) for s in sensors])
            course = np.concatenate([linalg.solve_triangular(root, shapes[k][:, s], lower=True) for s in sensors])
            self.assertAlmostEqual(found[k], squares_left(base, values) - squares_left(np.column_stack([base, course]), values), delta=0.01)

    def test_does_not_tell_twins_by_the_sensors_that_they_were_drawn_for(self):
        # The noise alone tells a gradient from a rate then: as often wrong as a likelihood ratio of two known courses is.
        wrong, expected = 0, 0.0
        seeds = range(40, 70)
        for seed in seeds:
            campaign = lab.make(seed, lab.Design(spacing_k=20, dwell_min=12), "gradient", 0.15)
            gram, products = oracle.normal_equations(campaign, seed, oracle.courses(campaign, seed, ("gradient", "temperature_rate"), 0.15))
            found = oracle.ratios(gram, products)
            wrong += bool(found[1] > found[0])
            correlation = gram[0, 1] / np.sqrt(gram[0, 0] * gram[1, 1])
            scale = campaign.truth["scale"]
            expected += stats.norm.sf(scale * np.sqrt(gram[0, 0] * (1 - correlation) / 2))
        self.assertAlmostEqual(wrong, expected, delta=4 * np.sqrt(max(expected, 1.0)))
        self.assertGreater(expected, 0.5)

    def test_threshold_of_one_candidate_is_that_of_chi_squared(self):
        self.assertAlmostEqual(oracle.threshold(np.array([[7.0]]), 1), stats.chi2.isf(oracle.FALSE_NAMES, 1), delta=0.5)

    def test_names_what_is_hidden_and_nothing_where_nothing_is(self):
        for effect in ("temperature_rate", "g_sensitivity", "step", "sensor_lag"):
            self.assertEqual(oracle.named(lab.make(6, SLOW, effect, 1.2), 6, CANDIDATES, 1.2), effect)
        self.assertIsNone(oracle.named(lab.make(6, SLOW), 6, CANDIDATES, 1.2))


if __name__ == "__main__":
    unittest.main()
