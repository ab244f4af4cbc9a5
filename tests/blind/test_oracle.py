# SPDX-License-Identifier: Apache-2.0
"""The oracle: its whitening and its ratio against brute force, its names where the truth is known."""
import unittest

import numpy as np
from scipy import linalg

import oracle
from blocks import BLOCKS_PER_STAY, STAYS_PER_VISIT
from made_campaign import made

NOISE = {"block_sigma": 0.004, "placement_sigma": 0.002, "visit_sigma": 0.003}
# Beyond what chance gives on 11 candidates in one campaign of 1000: chi-squared with one degree of freedom at 1e-4 is 15.1.
THRESHOLD = 15.1


def covariance(visits, noise):
    """Of blocks in order of time, written out."""
    def shared(size, sigma):
        return sigma**2 * linalg.block_diag(*[np.ones((size, size))] * (visits * STAYS_PER_VISIT * BLOCKS_PER_STAY // size))

    stay, visit = BLOCKS_PER_STAY, STAYS_PER_VISIT * BLOCKS_PER_STAY
    return shared(1, noise["block_sigma"]) + shared(stay, noise["placement_sigma"]) + shared(visit, noise["visit_sigma"])


def squares_left(columns, values):
    return float(np.sum((values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]) ** 2))


def ratio_by_brute_force(blocks, truth, chosen):
    """Twice the log likelihood ratio from Cholesky factors and least squares on all sensors at once."""
    values, bases, courses = [], [], []
    for sensor in range(6):
        root = np.linalg.cholesky(covariance(len(blocks.run) // 18, truth["noise"]["gyro" if sensor < 3 else "accel"]))
        candidates = [truth["units"][0]["candidates"][i]["contributions"] for i in chosen]
        values.append(linalg.solve_triangular(root, blocks.readings[:, sensor], lower=True))
        bases.append(linalg.solve_triangular(root, oracle.base_columns(blocks, truth, sensor), lower=True))
        courses.append(linalg.solve_triangular(root, np.array(candidates)[:, :, sensor].T, lower=True))
    base, values = linalg.block_diag(*bases), np.concatenate(values)
    base = base / np.linalg.norm(base, axis=0)
    return squares_left(base, values) - squares_left(np.hstack([base, np.vstack(courses)]), values)


class Oracle(unittest.TestCase):
    def test_whitening_undoes_the_nested_covariance(self):
        count = 2 * STAYS_PER_VISIT * BLOCKS_PER_STAY
        white = oracle.whitened(np.eye(count), NOISE)
        np.testing.assert_allclose(white.T @ white @ covariance(2, NOISE), np.eye(count), atol=1e-9)

    def test_ratio_is_that_of_a_fit_with_the_whole_covariance(self):
        blocks, truth = made("three", ("temperature_rate",), 0.6)
        names, gram, products = oracle.normal_equations(blocks, truth)
        for chosen in ([names.index("temperature_rate")], [names.index("cross_axis")],
                       [names.index("temperature_rate"), names.index("thermal_hysteresis")]):
            self.assertAlmostEqual(oracle.ratio(gram, products, chosen), ratio_by_brute_force(blocks, truth, chosen), delta=0.01)

    def test_names_what_is_hidden_and_strong(self):
        for effect in ("thermal_hysteresis", "sensor_lag", "fixture_tilt", "scale_nonlinearity"):
            found = oracle.most_likely(*made("three", (effect,), 1.2))
            self.assertEqual(oracle.names_beyond(found, THRESHOLD, 1), [effect])

    def test_names_both_of_a_strong_pair(self):
        pair = ("thermal_hysteresis", "g_sensitivity")
        self.assertEqual(oracle.names_beyond(oracle.most_likely(*made("mixed", pair, 1.2)), THRESHOLD, 2), list(pair))

    def test_names_nothing_where_nothing_is_hidden(self):
        for design in ("identical", "mixed", "three", "drift x 3", "dropped visit", "wrong position", "whole degrees"):
            self.assertEqual(oracle.names_beyond(oracle.most_likely(*made(design)), THRESHOLD, 2), [], design)

    def test_prices_every_name(self):
        found = [{"names": ["a"], "ratio": 30.0}, {"names": ["a", "b"], "ratio": 42.0}]
        self.assertEqual(oracle.names_beyond(found, 10.0, 2), ["a", "b"])
        self.assertEqual(oracle.names_beyond(found, 10.0, 1), ["a"])
        self.assertEqual(oracle.names_beyond(found, 13.0, 2), ["a"])
        self.assertEqual(oracle.names_beyond(found, 30.0, 2), [])


if __name__ == "__main__":
    unittest.main()
