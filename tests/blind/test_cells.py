# SPDX-License-Identifier: Apache-2.0
"""The plan of the benchmark."""
import collections
import unittest

from cells import Counts, cells, plan

COUNTS = Counts(nulls=12, seeds=3, stress_seeds=2, pair_seeds=1, unknown_seeds=4, magnitudes=(0.3, 1.2), pair_magnitude=0.6)


class Cells(unittest.TestCase):
    def test_no_seed_serves_twice_and_every_cell_has_its_count(self):
        campaigns = plan(COUNTS, 500)
        self.assertEqual(sorted(seed for _, seed in campaigns), list(range(500, 500 + len(campaigns))))
        counted = collections.Counter(cell for cell, _ in campaigns)
        self.assertEqual(counted, {cell: cell.count for cell in cells(COUNTS)})
        names = [cell.name() for cell in counted]
        self.assertEqual(len(names), len(set(names)))

    def test_every_pair_is_there_in_three_designs(self):
        pairs = [cell for cell in cells(COUNTS) if cell.table == "pair"]
        self.assertEqual(len(pairs), 3 * 11 * 10 // 2)
        self.assertEqual(len({(cell.design, frozenset(cell.effects)) for cell in pairs}), len(pairs))

    def test_a_run_that_stops_half_way_is_half_way_in_every_cell(self):
        campaigns = plan(COUNTS, 0)
        half = collections.Counter(cell for cell, _ in campaigns[:len(campaigns) // 2])
        for cell in cells(COUNTS):
            if cell.table == "null":
                self.assertAlmostEqual(half[cell], cell.count / 2, delta=2.5)

    def test_what_only_missing_logs_could_tell_is_not_asked_for(self):
        asked = {cell.effects[0] for cell in cells(COUNTS) if (cell.table, cell.design) == ("named", "missing_logs")}
        self.assertEqual(len(asked), 8)
        beside = {cell.effects[0] for cell in cells(COUNTS) if cell.table == "unlogged"}
        self.assertEqual(beside, {"sensor_lag", "vibration_rectification", "supply_sensitivity"})

    def test_the_rotation_of_the_earth_is_not_made_larger_than_it_is(self):
        sizes = {cell.magnitude for cell in cells(COUNTS) if cell.effects == ("earth_rate",)}
        self.assertEqual(sizes, {0.3})

    def test_the_oracle_is_told_of_every_effect_with_the_shape_of_the_hidden_one(self):
        cell = next(cell for cell in cells(COUNTS) if cell.name() == "named/mixed/sensor_lag/1.2")
        self.assertIn(cell.hidden(7)[0], cell.candidates(7))
        self.assertEqual(len(cell.candidates(7)), 11)


if __name__ == "__main__":
    unittest.main()
