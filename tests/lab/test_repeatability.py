# SPDX-License-Identifier: Apache-2.0
"""The same seed gives the same calibration, however fast the machine is and whatever else it does: the numbers differ by
the noise of other samples only. `./run prove demo-twice` does it with the demo's campaign and its fits."""
import math
import multiprocessing
import unittest

import bench
from bench import LabTest, short_procedure

PROCEDURE = short_procedure(set_points=(10, 40), positions=("+X", "-X", "+Y", "-Y", "+Z", "-Z"))
SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def burn():
    while True:
        pass


class Repeatability(LabTest):
    def segments(self, rate):
        self.start_lab(rate=rate, seed=5)
        self.start_campaign(PROCEDURE)
        self.assertEqual(self.wait_for_end()["state"], "finished")
        columns = ", ".join(f"{s}_mean, {s}_se" for s in SENSORS)
        rows = {(visit, position): values for visit, position, *values in
                self.query(f"SELECT visit, position, {columns} FROM segment")}
        self.doCleanups()
        self.setUp()
        return rows

    def test_two_campaigns_with_one_seed_agree_on_a_busy_machine_too(self):
        quiet = self.segments(rate=2000)
        load = [multiprocessing.Process(target=burn, daemon=True) for _ in range(4)]
        for process in load:
            process.start()
        try:
            busy = self.segments(rate=500)
        finally:
            for process in load:
                process.kill()
        self.assertEqual(quiet.keys(), busy.keys())
        self.assertEqual(len(quiet), 12)
        for key, values in quiet.items():
            for i, sensor in enumerate(SENSORS):
                (mean, se), (other, other_se) = values[2 * i:2 * i + 2], busy[key][2 * i:2 * i + 2]
                # Six sigma, and what 0.2 K do to a curve of some 0.01 °/s and 0.01 m/s2 per kelvin.
                slope = 0.02 * math.pi / 180 if sensor.startswith("gyro") else 0.01
                self.assertLess(abs(mean - other), 6 * math.hypot(se, other_se) + 0.2 * slope, f"{key} {sensor}")


if __name__ == "__main__":
    bench.main()
