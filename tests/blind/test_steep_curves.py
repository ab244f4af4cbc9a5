# SPDX-License-Identifier: Apache-2.0
"""A sample of `./run prove steep-curves`: steep curves are given no name, a resonance is named where it is."""
import os
import pathlib
import unittest

import numpy as np
import steep_curves
from blind_campaign import Programs, report_of, temporary_folder
from steep_curves import Bump, make_curves, random_places, write_campaign

ROOT = pathlib.Path(__file__).resolve().parents[2]


def report(seed, kind, bump=None, runs=3, **options):
    with temporary_folder() as folder:
        csv = pathlib.Path(folder) / "unit.csv"
        write_campaign(csv, seed, kind, bump, runs, **options)
        return report_of(Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml"), folder, csv,
                         rules=2)


class SteepCurves(unittest.TestCase):
    def test_places_keep_their_distance(self):
        random = np.random.default_rng(1)
        for _ in range(100):
            places = random_places(random, 9, -34.0, 74.0, 8.0)
            self.assertGreaterEqual(np.diff(places).min(), 8.0)
            self.assertTrue(places[0] >= -34.0 and places[-1] <= 74.0)

    def test_a_bump_is_as_high_as_it_says_in_its_sensors_only(self):
        bump = Bump(15.0, 4.0, 25.0, (1,))
        added = make_curves(3, "tanh", bump)(np.array([25.0, 27.0, 60.0])) - make_curves(3, "tanh")(np.array([25.0, 27.0, 60.0]))
        np.testing.assert_allclose(added[:, 1], [0.06, 0.03, 0.0], atol=1e-6)
        self.assertEqual(np.abs(np.delete(added, 1, axis=1)).max(), 0.0)

    def test_steep_curves_are_given_no_name(self):
        for kind in steep_curves.KINDS:
            found = report(1, kind)
            self.assertEqual((found["verdict"], found["effects"]), ("none", []), kind)

    def test_nor_where_plateaus_say_little_of_how_steep_they_are(self):
        for kind in ("tanh", "spline"):
            found = report(1, kind, plateaus_c=steep_curves.COARSE_C)
            self.assertEqual((found["verdict"], found["effects"]), ("none", []), kind)

    def test_kinks_are_no_lag(self):
        # The base read at lagged temperatures once fitted the noise of the visits: sensor_lag, p 7e-12.
        found = report(90166, "kinks", runs=6)
        self.assertEqual((found["verdict"], found["effects"]), ("none", []))

    def test_a_resonance_is_named_where_it_is(self):
        # Where a sensor's own curve turns near the resonance, the plateaus cannot tell the two apart: it is not named then.
        hidden = ["gyro_x", "gyro_y", "gyro_z"]
        for seed, least in ((2, 1), (4, 3)):
            found = report(seed, "tanh", Bump(30.0, 4.0, 45.0, (0, 1, 2)))
            self.assertEqual([effect["name"] for effect in found["effects"]], ["narrow_bump"])
            self.assertAlmostEqual(float(found["effects"][0]["shape"].split()[1]), 45.0, delta=0.5)
            named = found["effects"][0]["sensors"]
            self.assertTrue(len(named) >= least and set(named) <= set(hidden), named)


if __name__ == "__main__":
    unittest.main()
