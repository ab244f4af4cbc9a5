# SPDX-License-Identifier: Apache-2.0
"""A short sample of tools/prove/parameters: what the fit states against what was simulated."""
import math
import unittest

from simulated_truth import MAY_BE_WIDE, Coverage, clopper_pearson, coverage_of, fewest_inside, upper_tail


class Statistics(unittest.TestCase):
    def test_exact_bounds_are_those_of_the_tables(self):
        # Clopper and Pearson 1934; values by scipy.stats.beta.ppf.
        for n, k, low, high in ((20, 18, 0.6830173, 0.9876515), (10, 10, 0.6915029, 1.0), (30, 0, 0.0, 0.1157033)):
            bounds = clopper_pearson(n, k)
            self.assertAlmostEqual(bounds[0], low, places=6)
            self.assertAlmostEqual(bounds[1], high, places=6)
        self.assertAlmostEqual(upper_tail(3, 2, 0.5), 0.5)
        # P(X <= 74 of 84) is 0.92 %, P(X <= 75) 2.5 %; P(X <= 8 of 12) is 0.22 %, P(X <= 9) 2.0 %, summed in fractions.
        self.assertEqual((fewest_inside(84), fewest_inside(12)), (75, 9))


class Truth(unittest.TestCase):
    def test_intervals_hold_the_truth_about_as_often_as_they_say(self):
        total = Coverage()
        for seed in (101, 102):
            total.merge(coverage_of(seed, runs=4, units=2))
        self.assertEqual(len(total.seen), 8)
        for kind, (inside, count, _) in total.seen.items():
            if kind in MAY_BE_WIDE:
                continue  # drawn by chance which of the two: 12 in all
            self.assertEqual(count, 12, kind)
        inside = sum(i for i, _, _ in total.seen.values())
        count = sum(c for _, c, _ in total.seen.values())
        self.assertEqual(count, 12 * 7)
        # Intervals of one sensor share its rows, so this is not quite a binomial; the seeds are fixed, and a chance of one
        # in a hundred is that of the choice of seeds. tools/prove/parameters counts enough to judge each kind by itself.
        self.assertGreaterEqual(inside, fewest_inside(count), total.seen)
        for kind, (inside, count, _) in total.seen.items():
            self.assertGreaterEqual(inside, fewest_inside(count, chance=0.01 / len(total.seen)), (kind, total.seen))
        # Nor far too wide: error over half-width of a right interval is normal, root mean square 1/1.96 = 0.51, known to
        # 1 in sqrt(2 n) from n of them: three of these. Intervals half as wide again (0.34) are caught.
        squares, count = (sum(seen[k] for kind, seen in total.seen.items() if kind not in MAY_BE_WIDE) for k in (2, 1))
        self.assertGreater(math.sqrt(squares / count), 0.51 * (1.0 - 3.0 / math.sqrt(2.0 * count)), total.seen)


if __name__ == "__main__":
    unittest.main()
