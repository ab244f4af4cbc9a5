# SPDX-License-Identifier: Apache-2.0
"""`soak verify`: limits of a file or of the unit's type, what was not measured, the band that a file states."""
import json
import os
import struct
import unittest

import test_fit
from blob_reader import crc32c
from soak_cli import ROOT, check_schema, long_test
from test_fit import SENSORS, SERIAL, FittedTest, fitted_folder

TYPE = "name = \"generic\"\n[limits]\ngyro = 0.2\naccel = 0.2\n"


def tearDownModule():
    test_fit.tearDownModule()


def with_crc(content):
    """A calibration file whose content was changed, with the checksum that fits it."""
    return bytes(content[:-4]) + struct.pack("<I", crc32c(bytes(content[:-4])))


class Verify(FittedTest):
    def setUp(self):
        super().setUp()
        # A folder of unit types of our own: the unit was imported as "generic".
        units = self.folder / "procedures" / "units"
        units.mkdir(parents=True)
        self.type_file = units / "generic.toml"
        os.environ["SOAK_PROCEDURES"] = str(units.parent)
        self.addCleanup(os.environ.pop, "SOAK_PROCEDURES")

    def limits(self, text):
        return self.write("limits.toml", "[limits]\n" + text)

    def verify(self, *arguments, status=0, campaign="verification"):
        done = self.soak("verify", self.blob(), "--campaign", campaign, *arguments, "--json", status=status)
        document = json.loads(done.stdout)
        check_schema(document, "verify")
        return document

    def partial_campaign(self, keep, name):
        """The verification recording, cells changed by `keep(cells, header)`, as a campaign of its own."""
        lines = (fitted_folder() / "lab" / "verification" / f"{SERIAL}.csv").read_text(encoding="utf-8").splitlines()
        header = lines[0].split(",")
        rows = [keep(dict(zip(header, line.split(",")))) for line in lines[1:]]
        text = "\n".join([lines[0]] + [",".join(row.values()) for row in rows if row]) + "\n"
        self.soak("import", self.write(f"{name}.csv", text), "--unit", SERIAL, "--campaign", name, "--procedure", "verification",
                  "--simulated", "--gravity-mps2", "9.80665")

    def test_references_of_the_fresh_campaign_are_in_the_guard_band(self):
        before = self.verify()["sensors"]["accel_x"]["scale"]["guard"]
        self.soak("reference", "add", "--kind", "gravity", "--name", "pillar", "--certificate", "C1", "--issued", "2020-01-01",
                  "--due", "2099-01-01", "--correction", "9.80665", "--uncertainty", "0.02", "--k", "2")
        path = fitted_folder() / "lab" / "verification" / f"{SERIAL}.csv"
        self.soak("import", path, "--unit", SERIAL, "--campaign", "known", "--procedure", "verification", "--simulated",
                  "--references")
        after = self.verify(campaign="known")["sensors"]["accel_x"]["scale"]["guard"]
        # u(g)/g = 0.01/9.80665, 1020 ppm, beside the rows' own.
        self.assertAlmostEqual(after, (before**2 + (1.96 * 1e6 * 0.01 / 9.80665) ** 2) ** 0.5, delta=20)

    def test_the_document_says_in_metres_what_the_file_buys(self):
        """Beside what soak nav impact finds from the stored model: the file carries its curves to single precision."""
        impact = self.verify()["impact"]
        of_model = self.soak_json("nav-impact", "nav", "impact", "--unit", SERIAL)
        self.assertEqual([one["sensor"] for one in impact["free_inertial"]], [one["sensor"] for one in of_model["free_inertial"]])
        for one, other in zip(impact["free_inertial"], of_model["free_inertial"]):
            for which in ("without", "with"):
                metres, expected = one["after_60_s_m"][which], other["after_60_s_m"][which]
                self.assertGreater(metres, 0.0)
                self.assertAlmostEqual(metres, expected, delta=0.01 * expected)
        # There each outage begins at the start of the drive, here one filter goes through it.
        drives, pipelines = impact["drives"], {one["name"]: one for one in of_model["drive"]["pipelines"]}
        self.assertEqual(drives["outages"], len(of_model["drive"]["outages"]))
        for which, name in (("without", "raw"), ("with", "calibrated")):
            for measure in ("horizontal_final_m", "horizontal_rmse_m"):
                metres, expected = drives[which][measure], pipelines[name][measure]
                for one, other in zip([metres["value"], *metres["ci95"]], [expected["value"], *expected["ci95"]], strict=True):
                    self.assertAlmostEqual(one, other, delta=0.01 * other)
        self.assertAlmostEqual(drives["gain"]["value"], pipelines["calibrated"]["gain"]["value"], delta=0.01)

    def test_limits_of_the_unit_type_hold_and_a_file_replaces_them(self):
        self.type_file.write_text(TYPE, encoding="utf-8")
        document = self.verify()
        self.assertEqual((document["verdict"], document["limits"]), ("pass", "unit type generic"))
        path = self.limits("gyro = 0.2\n")
        document = self.verify("--limits", path)
        self.assertEqual((document["verdict"], document["limits"]), ("info", str(path)))
        self.assertIsNone(document["sensors"]["accel_x"]["limit"])
        shown = self.soak_json("type-show", "type", "show", "generic")["type"]["limits"]
        self.assertEqual(set(shown), set(SENSORS))
        self.assertAlmostEqual(shown["gyro_y"], 0.2)

    def test_mistakes_in_the_limits_of_a_type_name_their_lines(self):
        self.type_file.write_text(TYPE + "gyro_w = 1\naccel_x = 0\n", encoding="utf-8")
        message = self.refusal("verify", self.blob(), "--campaign", "verification")["message"]
        self.assertIn("generic.toml:5: ", message)
        self.assertIn("'gyro_w'", message)
        self.assertIn("generic.toml:6: ", message)

    @long_test
    def test_a_sensor_with_a_limit_and_no_rows_is_not_measured(self):
        self.partial_campaign(lambda row: {**row, "gy_dps": ""}, "without")
        document = self.verify("--limits", self.limits("gyro = 0.2\naccel = 0.2\n"), campaign="without")
        sensor = document["sensors"]["gyro_y"]
        self.assertEqual((sensor["verdict"], sensor["rows"], sensor["worst_abs"]), ("not_measured", 0, None))
        self.assertEqual(document["sensors"]["gyro_x"]["verdict"], "pass")
        self.assertEqual(document["verdict"], "info")

    @long_test
    def test_half_the_range_is_not_measured_but_may_fail(self):
        self.partial_campaign(lambda row: row if float(row["plateau_c"]) < 20 else None, "cold")
        document = self.verify("--limits", self.limits("gyro = 0.2\naccel = 0.2\n"), campaign="cold")
        self.assertEqual({s["verdict"] for s in document["sensors"].values()}, {"not_measured"})
        self.assertEqual(document["verdict"], "info")
        document = self.verify("--limits", self.limits("gyro = 0.0001\naccel = 0.2\n"), campaign="cold", status=5)
        self.assertEqual(document["verdict"], "fail")
        self.assertEqual(document["sensors"]["accel_x"]["verdict"], "not_measured")

    def test_the_rule_holds_on_the_figures_that_are_printed(self):
        first = self.verify()["sensors"]["gyro_x"]
        # Both sides of the guard band of the worst estimate; its U is at most the largest one.
        for limit, verdicts in ((first["worst_abs"] + 1.001 * first["guard"], {"pass"}), (first["worst_abs"], {"marginal"}),
                                (first["worst_abs"] - 1.001 * first["guard"], {"fail"})):
            text = f"gyro_x = {limit!r}\n"
            document = self.verify("--limits", self.limits(text), status=5 if verdicts == {"fail"} else 0)
            self.assertIn(document["sensors"]["gyro_x"]["verdict"], verdicts, limit)
        self.assertEqual(document["decision_rule"]["guard_coverage"], 0.95)
        self.assertGreater(first["guard_factor"], 1.959)
        self.assertLess(first["guard_factor"], 4.4)  # two degrees of freedom
        self.assertEqual(document["decision_rule"]["false_acceptance_max"], 0.025)

    @long_test
    def test_the_rule_promises_its_risk_only_where_u_leaves_nothing_out(self):
        rule = self.verify()["decision_rule"]["text"]
        self.assertIn("(fixture, gravity)", rule)
        for kind, name, uncertainty, more in (("fixture_squareness", "cube", "0.02", ()),
                                              ("gravity", "pillar", "0.0002", ("--correction", "9.80665"))):
            self.soak("reference", "add", "--kind", kind, "--name", name, "--certificate", "C", "--issued", "2020-01-01", "--due",
                      "2099-01-01", "--uncertainty", uncertainty, *more)
        path = fitted_folder() / "lab" / "verification" / f"{SERIAL}.csv"
        self.soak("import", path, "--unit", SERIAL, "--campaign", "known", "--procedure", "verification", "--simulated",
                  "--references")
        document = self.verify(campaign="known")
        self.assertEqual({what for sensor in document["sensors"].values() for what in sensor["not_stated"]}, set())
        self.assertTrue(document["decision_rule"]["text"].endswith(" 2.5 %"), document["decision_rule"])

    def test_a_campaign_that_does_not_exist_is_said_to(self):
        message = self.refusal("verify", self.blob(), "--campaign", "chekc")["message"]
        for name in ("'chekc'", "campaign, verification"):
            self.assertIn(name, message)
        self.refusal("verify", self.other_units_blob(), "--campaign", "verification")

    def other_units_blob(self):
        """A file of a unit that was in no campaign of this folder."""
        path = self.folder / "other.soakcal"
        path.write_bytes((ROOT / "tests" / "data" / "golden" / "fis.soakcal").read_bytes())
        return path

    def test_what_is_no_whole_calibration_file_is_refused_by_what_it_is(self):
        whole = self.blob().read_bytes()
        for name, content, status in (("empty", b"", 2), ("png", b"\x89PNG\r\n\x1a\n" * 9, 2), ("cut", whole[:5], 4),
                                      ("half", whole[:900], 4), ("newer", with_crc(whole[:8] + b"\x02\x00" + whole[10:]), 2)):
            path = self.write(name, content)
            self.assertIn(str(path), self.refusal("verify", path, "--campaign", "verification", status=status)["where"], name)

    def test_scale_has_limits_of_its_own(self):
        document = self.verify("--limits", self.limits("gyro = 0.2\naccel = 0.2\naccel_scale_ppm = 5000\n"))
        self.assertEqual(document["verdict"], "pass")
        for name in SENSORS[3:]:
            self.assertEqual(document["sensors"][name]["scale"]["verdict"], "pass")
            self.assertGreater(document["sensors"][name]["scale"]["rmse_abs"], 0)
        narrow = "gyro = 0.2\naccel = 0.2\naccel_y_scale_ppm = 1\n"
        document = self.verify("--limits", self.limits(narrow), status=5)
        self.assertEqual(document["sensors"]["accel_y"]["bias_verdict"], "pass")
        self.assertEqual(document["sensors"]["accel_y"]["verdict"], "fail")
        document = self.verify("--limits", self.limits("gyro = 0.2\naccel = 0.2\ngyro_scale_ppm = 1000\n"))
        self.assertEqual(document["sensors"]["gyro_z"]["scale"]["verdict"], "not_measured", "a gyro at rest shows none")
        self.assertEqual(document["verdict"], "info")

    @long_test
    def test_it_says_at_which_temperatures(self):
        document = self.verify()
        temps = document["sensors"]["gyro_x"]["temps_c"]
        # Middles of the plateaus; a visit settles 0.22 K from its set point at most and drifts by 0.03.
        self.assertEqual(len(temps), 20)
        for i, temp_c in enumerate(temps):
            self.assertAlmostEqual(temp_c, -27.5 + 5 * i, delta=0.3)
        text = self.soak("verify", self.blob(), "--campaign", "verification").stdout
        self.assertRegex(text, r"-27\b")
        self.assertIn(document["decision_rule"]["text"], text)

    def test_an_honest_file_keeps_its_bands_and_a_shifted_run_breaks_them(self):
        document = self.verify()
        self.assertNotIn("band_too_narrow", [warning["code"] for warning in document["warnings"]])
        for sensor in document["sensors"].values():
            self.assertGreater(sensor["fresh_against_pi95"]["inside"], 0.5)
        # Two degrees per second: 100 times what this unit does from power-on to power-on. Of fifteen comparisons three runs
        # in the file allow each 38.7/4.3 times pi95, which is about 5 of these sigmas.
        self.partial_campaign(lambda row: {**row, "gx_dps": repr(float(row["gx_dps"]) + 2.0)} if row["gx_dps"] else row, "shifted")
        document = self.verify(campaign="shifted")
        self.assertTrue(document["sensors"]["gyro_x"]["fresh_against_pi95"]["too_narrow"])
        self.assertFalse(document["sensors"]["gyro_x"]["shape_against_ci95"]["too_narrow"])
        self.assertIn("band_too_narrow", [warning["code"] for warning in document["warnings"]])
        self.assertEqual(document["verdict"], "info")


if __name__ == "__main__":
    unittest.main()
