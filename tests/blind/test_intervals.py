# SPDX-License-Identifier: Apache-2.0
"""The exact intervals against printed tables, closed forms and the definition."""
import unittest

from scipy import stats

from intervals import lower, share, upper

# k, n, 95 % limits: as printed to four decimals in tables of the exact binomial interval.
TABLE = ((1, 10, 0.0025, 0.4450), (5, 10, 0.1871, 0.8129), (2, 20, 0.0123, 0.3170), (10, 100, 0.0490, 0.1762))


class Intervals(unittest.TestCase):
    def test_agree_with_printed_tables(self):
        for k, n, low, high in TABLE:
            self.assertAlmostEqual(lower(k, n), low, delta=5.1e-5)
            self.assertAlmostEqual(upper(k, n), high, delta=5.1e-5)

    def test_have_their_closed_form_at_the_ends(self):
        for n in (1, 7, 500, 5000):
            self.assertEqual((lower(0, n), upper(n, n)), (0.0, 1.0))
            self.assertAlmostEqual(upper(0, n), 1.0 - 0.025 ** (1.0 / n), places=12)
            self.assertAlmostEqual(lower(n, n), 0.025 ** (1.0 / n), places=12)

    def test_leave_a_fortieth_beyond_each_end_also_for_many_trials(self):
        for k, n in ((3, 40), (2, 1031), (1200, 5000), (4999, 5000)):
            self.assertAlmostEqual(stats.binom.sf(k - 1, n, lower(k, n)), 0.025, places=9)
            self.assertAlmostEqual(stats.binom.cdf(k, n, upper(k, n)), 0.025, places=9)

    def test_are_printed_with_the_share(self):
        self.assertEqual(share(5, 10), "5/10 = 50.0 % (18.7..81.3)")
        self.assertEqual(share(0, 0), "-")


if __name__ == "__main__":
    unittest.main()
