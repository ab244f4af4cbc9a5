# SPDX-License-Identifier: Apache-2.0
"""`soak gap find` on campaigns with a hidden effect, seen as CSV: a short blind benchmark, with bounds that a namer which
guesses, or finds nothing, or always finds something, cannot pass. `./run bench gap` prints the tables."""
import os
import pathlib
import sys
import unittest

from soak_cli import ROOT, SoakTest, check_schema, long_test

sys.path.insert(0, str(ROOT / "tests" / "blind"))
from blind_campaign import Programs, judge  # noqa: E402

EFFECTS = ("thermal_hysteresis", "temperature_rate", "sensor_lag", "warmup_transient", "g_sensitivity", "earth_rate", "cross_axis",
           "fixture_tilt", "scale_nonlinearity", "vibration_rectification", "supply_sensitivity")


def programs():
    return Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")


def names(report):
    return [effect["name"] for effect in report["effects"]]


class Blind(unittest.TestCase):
    def test_each_effect_is_named(self):
        right = 0
        for number, effect in enumerate(EFFECTS):
            magnitude = 0.6 if effect == "earth_rate" else 1.2  # the Earth does not turn faster
            report, truth = judge(programs(), 500 + number, {}, [{"effect": effect, "magnitude": magnitude, "seed": number}])
            check_schema(report, "gap-find")
            hidden = truth["units"][0]["effects"][0]
            self.assertEqual(hidden["name"], effect)
            if report["verdict"] == "named" and names(report)[0] == effect:
                right += 1
                self.assertLess(report["effects"][0]["evidence"]["p_adjusted"], 0.003)
            else:
                print(f"{effect}: {report['verdict']} {names(report)}: {report['reason']}", file=sys.stderr)
        self.assertGreaterEqual(right, len(EFFECTS) - 1)

    def test_nothing_is_named_where_nothing_is_hidden(self):
        for number, kind in enumerate(("identical", "mixed", "three", "missing_logs", "identical", "mixed")):
            report, truth = judge(programs(), 700 + number, {"kind": kind}, [])
            check_schema(report, "gap-find")
            self.assertEqual(truth["units"][0]["effects"], [])
            self.assertEqual((report["verdict"], names(report)), ("none", []), kind)

    def test_one_run_cannot_be_judged(self):
        report, _ = judge(programs(), 800, {"kind": "one"}, [{"effect": "thermal_hysteresis", "magnitude": 2.4, "seed": 1}], rules=2)
        check_schema(report, "gap-find")
        self.assertEqual((report["verdict"], names(report)), ("cannot_judge", []))
        self.assertTrue(report["reason"])

    @long_test
    def test_what_the_library_does_not_have_is_unknown(self):
        for number, effect in enumerate(("daily_wave", "telegraph_noise", "bias_step")):
            report, _ = judge(programs(), 900 + number, {}, [{"effect": effect, "magnitude": 2.4, "seed": 5 + number}])
            check_schema(report, "gap-find")
            self.assertEqual((report["verdict"], names(report)), ("unknown", []), effect)

    @long_test
    def test_water_that_the_simulator_makes_by_other_equations_is_named(self):
        report, _ = judge(programs(), 903, {}, [{"effect": "moisture", "magnitude": 2.4, "seed": 8}])
        check_schema(report, "gap-find")
        self.assertEqual((report["verdict"], names(report)), ("named", ["moisture"]))


class Find(SoakTest):
    def test_a_unit_without_model_is_refused(self):
        csv = "t_s,temp_c,gx_dps\n" + "".join(f"{i},25,{i % 7}\n" for i in range(100))
        self.soak("import", self.write("a.csv", csv), "--unit", "SN1")
        self.assertIn("soak fit", self.refusal("gap", "find", "--unit", "SN1")["message"])
        error = self.refusal("gap", "find", "--unit", "SN2")
        self.assertIn("SN2", error["message"])


if __name__ == "__main__":
    unittest.main()
