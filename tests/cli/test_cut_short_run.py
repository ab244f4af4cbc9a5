# SPDX-License-Identifier: Apache-2.0
"""A run that was cut short and went on as another part: what one part lacks and the other has is not asked for."""
import random
import unittest

from soak_cli import HEADER, SoakTest

SERIAL = "SN1"
PLATEAUS = (-30, -15, 0, 15, 30, 45, 60)
UPS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}


def recording(run, visits):
    """Positions of 30 s; `visits`: (plateau, labels of the positions)."""
    noise = random.Random(run)
    lines, t = [HEADER], 0.0
    for plateau, labels in visits:
        for label in labels:
            for _ in range(60):
                gyro = [noise.gauss(0, 0.01) for _ in range(3)]
                force = [9.80665 * 0.999 * u + noise.gauss(0, 0.002) for u in UPS[label]]
                numbers = ",".join(f"{x:.6f}" for x in gyro + force)
                lines.append(f"{t:.1f},{run},soak,up,{plateau},{label},{plateau},{plateau + noise.gauss(0, 0.02):.3f},{numbers}")
                t += 0.5
    return "\n".join(lines) + "\n"


class CutShort(SoakTest):
    def warnings(self, cut, rest):
        """Of a fit of two whole runs and one that was cut short in its visit at 30 °C after the positions `cut`; `rest`: plateaus of its other part."""
        self.imported("r1.csv", recording("r1", [(plateau, UPS) for plateau in PLATEAUS]), "--gravity-mps2", "9.80665")
        self.imported("r3.csv", recording("r3", [(plateau, UPS) for plateau in PLATEAUS]), "--gravity-mps2", "9.80665")
        self.imported("a.csv", recording("r2", [*((plateau, UPS) for plateau in PLATEAUS[:4]), (30, cut)]), "--gravity-mps2", "9.80665")
        self.imported("b.csv", recording("r2.2", [(plateau, UPS) for plateau in rest]), "--gravity-mps2", "9.80665")
        return [(w["code"], w["text"]) for w in self.soak_json("fit", "fit", "--unit", SERIAL)["warnings"] if w["code"] in ("missing_position", "cut_short_visit")]

    def test_what_the_other_part_has_is_not_asked_for(self):
        self.assertEqual(self.warnings(["+X", "-X"], (30, 45, 60)), [])

    def test_a_bias_that_a_missing_position_has_spoiled_is_told_with_what_to_do(self):
        told = self.warnings(["+Y"], (30, 45, 60))
        self.assertEqual([code for code, _ in told], ["cut_short_visit"])
        self.assertIn("r2: accel_y: the positions do not determine its scale error at 1 of 5 plateau visits (30 °C) (which stays in the bias); another part of this run has them", told[0][1])

    def test_what_no_part_has_is_asked_for(self):
        told = self.warnings(["+X", "-X"], (45, 60))
        self.assertTrue(told)
        self.assertEqual({code for code, _ in told}, {"missing_position"})


if __name__ == "__main__":
    unittest.main()
