# SPDX-License-Identifier: Apache-2.0
"""The reference plateau from the procedure to the control chart of a check standard."""
import math
import unittest

import bench
from bench import LabTest, short_procedure

UNIT = "0380A001"


class ReferencePlateau(LabTest):
    def test_each_run_is_recorded_at_25_degrees_at_both_ends_and_the_chart_has_its_drift(self):
        self.start_lab(rate=2000)
        self.start_campaign(short_procedure(set_points=(5, 45), positions=("+X", "-X", "+Y", "-Y", "+Z", "-Z"),
                                            extra="[reference]\ntemp_c = 25.0\n"))
        self.assertEqual(self.wait_for_end()["state"], "finished")
        visits = self.query("SELECT visit, plateau_c, sweep, count(*) FROM segment GROUP BY visit ORDER BY visit")
        # The laboratory's room has 25 degrees: no change of the set point brought the first visit about.
        self.assertEqual(visits, [(0, 25.0, "unknown", 6), (1, 5.0, "down", 6), (2, 45.0, "up", 6), (3, 25.0, "down", 6)])

        self.lab.soak("check", "declare", UNIT, "--reason", "test")
        chart = self.lab.soak_json("check", "chart", "--unit", UNIT)
        self.check_schema(chart, "check-chart")
        campaign, = chart["units"][0]["campaigns"]
        self.assertEqual((campaign["verdict"], campaign["simulated"]), ("not_established", True))
        run, = campaign["runs"]
        self.assertEqual((run["at_both_ends"], run["visits"]), (True, [0, 3]))
        # Half the sum of a gyro's readings up and down is its bias; a look at the segments themselves.
        readings = dict(self.query("SELECT visit || position, gyro_x_mean FROM segment WHERE position LIKE '_X'"))
        first, last = (math.degrees((readings[f"{visit}+X"] + readings[f"{visit}-X"]) / 2) for visit in (0, 3))
        sensor = run["sensors"]["gyro_x"]
        # The estimate weighs all positions, corrects drift within the visit and carries by tenths of a kelvin.
        self.assertAlmostEqual(sensor["first"], first, delta=0.02)
        self.assertAlmostEqual(sensor["last"], last, delta=0.02)
        self.assertAlmostEqual(sensor["drift"], last - first, delta=0.02)


if __name__ == "__main__":
    bench.main()
