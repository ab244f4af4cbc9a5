# SPDX-License-Identifier: Apache-2.0
"""One campaign with units of three families side by side, each over its own protocol: Xsens, Crossbow AHRS400, VectorNav.
What was recorded is judged against what is true of the simulated units."""
import json
import math
import subprocess
import unittest

import bench
import numpy as np
from bench import LabTest, short_procedure
from lab_session import bin_folder

SET_POINTS = (15, 35)
# As the units tell it: the device identifications 0380A001, 0380A002, 0380A003.
SERIALS = ("0380A001", "58761218", "0058761219")
# Samples in 30 s: two that were asked for 50 a second, and one with a rate of its own, 63 a second.
SAMPLES = (1500, 1895, 1500)
# Six sigma of the mean of two stays of half a minute: white noise of 2.25 deg/sqrt(h) and 0.003 deg/s of slow noise.
GYRO_DELTA_DPS = 6 * math.hypot(2.25 / 60 / math.sqrt(60), 0.003)


class ThreeDecoders(LabTest):
    def truth(self, sensor, number, temp_c):
        """Bias in the first power-on of unit `number`, deg/s."""
        document = json.loads(subprocess.run([bin_folder() + "/soaksim-truth", "--seed", "1", "--units", "3"],
                                             capture_output=True, text=True, check=True).stdout)
        true = document["units"][number]["sensors"][sensor]
        return np.interp(temp_c, document["temp_c"], true["bias"]) + true["power_on_offset"][0]

    def check_unit(self, number, serial):
        rows = self.query("SELECT plateau_c, avg(temp_c), count(*), min(gyro_x_count), max(gyro_x_count), avg(gyro_x_mean), "
                          "avg(gyro_y_mean), avg(gyro_z_mean), min(accel_x_mean * accel_x_mean + accel_y_mean * accel_y_mean + "
                          "accel_z_mean * accel_z_mean) FROM segment WHERE unit = ? GROUP BY plateau_c ORDER BY 1", serial)
        self.assertEqual([row[0] for row in rows], list(SET_POINTS), serial)
        for plateau_c, temp_c, stays, fewest, most, *gyros, force2 in rows:
            self.assertEqual(stays, 2)
            self.assertAlmostEqual(fewest, SAMPLES[number], delta=10)
            self.assertAlmostEqual(most, SAMPLES[number], delta=10)
            self.assertAlmostEqual(temp_c, plateau_c, delta=2.0)
            self.assertAlmostEqual(math.sqrt(force2), 9.8, delta=0.3)
            # In opposite positions what follows gravity cancels.
            for axis, rate_rps in zip("xyz", gyros):
                self.assertAlmostEqual(math.degrees(rate_rps), self.truth(f"gyro_{axis}", number, temp_c),
                                       delta=GYRO_DELTA_DPS, msg=f"{serial} gyro_{axis} at {plateau_c}")

    def test_units_of_three_families_in_one_campaign(self):
        self.start_lab(units=3, rate=160, soaksim_options=["--decoder", "xsens", "ahrs400", "vectornav"])
        self.start_campaign(short_procedure(set_points=SET_POINTS).replace("rate_hz = 10\n", "rate_hz = 50\n"))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.query("SELECT DISTINCT unit FROM segment ORDER BY 1"), sorted((serial,) for serial in SERIALS))
        self.lab.soak("runs", "verify")
        for number, serial in enumerate(SERIALS):
            self.check_unit(number, serial)


if __name__ == "__main__":
    bench.main()
