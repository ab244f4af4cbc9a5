# SPDX-License-Identifier: Apache-2.0
"""The same campaign before three controllers over three wire protocols: Watlow F4T over Modbus TCP, Eurotherm 2400 over
Modbus RTU, ESPEC P300 over lines of text. What the chamber did is read beside soakd, over its F4T's registers."""
import unittest

import bench
from bench import LabTest, short_procedure

SET_POINTS = (12, 32)


class ThreeChambers(LabTest):
    def run_campaign(self, kind, wire):
        """A campaign from start to safe end on the controller `kind`; the plateaus that were recorded."""
        self.start_lab(rate=400, soaksim_options=["--chamber", kind])
        self.assertIn(wire, self.config.read_text(encoding="utf-8"))
        self.start_campaign(short_procedure(set_points=SET_POINTS))
        self.wait_for_step("wait_stable")
        _, _, set_point_c, _ = self.chamber()
        self.assertEqual(set_point_c, SET_POINTS[0], "the controller holds what was asked for over the wire")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_safe()
        self.lab.soak("runs", "verify")
        return self.query("SELECT plateau_c, position, avg(temp_c) FROM segment GROUP BY plateau_c, position ORDER BY 1, 2")

    def check(self, kind, wire):
        rows = self.run_campaign(kind, wire)
        self.assertEqual([row[:2] for row in rows], [(c, p) for c in SET_POINTS for p in ("+Z", "-Z")])
        for plateau_c, position, temp_c in rows:
            # A unit that is on is up to 1.2 K above the air; a plateau counts as reached within the controller's band.
            self.assertAlmostEqual(temp_c, plateau_c, delta=2.0, msg=position)

    def test_f4t_over_modbus_tcp(self):
        self.check("f4t", "watlow-f4t.toml")

    def test_eurotherm_over_modbus_rtu(self):
        self.check("eurotherm-2400", "eurotherm-2400.toml")

    def test_espec_over_lines_of_text(self):
        self.check("espec-p300", "espec-p300.toml")

    def test_the_page_shows_what_the_controller_can_say(self):
        """An ESPEC tells no output: that is null, not a number."""
        self.start_lab(rate=50, soaksim_options=["--chamber", "espec-p300"])
        status = self.wait("the chamber", lambda s: s["chamber"]["air_c"] is not None)
        self.check_schema(status, "campaign-status")
        self.assertIsNone(status["chamber"]["output_percent"])
        self.assertFalse(status["chamber"]["running"])


if __name__ == "__main__":
    bench.main()
