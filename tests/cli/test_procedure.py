# SPDX-License-Identifier: Apache-2.0
"""soak procedure check; soak type list, show."""
import os
import re
import unittest

from soak_cli import ROOT, SoakTest

PROCEDURES = ROOT / "procedures"
UNITS = PROCEDURES / "units"
SHORT = """name = "short"
purpose = "diagnosis"
kind = "soak"
[temperatures]
list_c = [0, 80]
[positions]
order = ["+X", "-X"]
dwell_s = 900
[preflight]
position_s = 0
[estimate]
rate_kpmin = 1
settle_s = 600
"""


class ProcedureCheck(SoakTest):
    def test_every_shipped_procedure_is_sound_and_borne_by_the_unit_that_it_is_made_for(self):
        found = sorted(PROCEDURES.glob("*.toml"))
        self.assertGreaterEqual(len(found), 7)
        for path in found:
            document = self.soak_json("procedure-check", "procedure", "check", path, "--type", "mti-300", "--types", UNITS)
            self.assertEqual(document["name"], path.stem)
            self.assertEqual(document["file"], str(path))

    def test_the_plan_has_its_hours(self):
        document = self.soak_json("procedure-check", "procedure", "check", self.write("p.toml", SHORT))
        # 25 to 0 to 80 to 25 degrees is 160 min at 1 K/min; two plateaus of 10 min to settle, 2 x 15 min recorded, two
        # turns of 10 s, 30 s after one of them. It ends warm, and nothing follows the only run.
        self.assertAlmostEqual(document["estimate_h"], (160 * 60 + 2 * (600 + 2 * 900 + 2 * 10 + 30)) / 3600, places=9)
        self.assertEqual((document["runs"], document["visits"], document["set_points_c"]), (1, 2, [0, 80]))

    def test_text_shows_one_line_per_run_and_every_step_on_request(self):
        path = PROCEDURES / "six-position-soak.toml"
        lines = self.soak("procedure", "check", path).stdout.splitlines()
        self.assertLess(len(lines), 30)
        self.assertTrue(any(line.startswith("R20") for line in lines))
        steps = self.soak_json("procedure-check", "procedure", "check", path)["steps"]
        listed = self.soak("procedure", "check", path, "--steps").stdout.splitlines()
        self.assertEqual(sum(": " in line and line[:6].strip().isdigit() for line in listed), steps)
        self.assertTrue(any(re.search(r"R01 visit 21\b.*\+70 °C.*\b600 s\b.* -Z", line) for line in listed))

    def test_a_reference_plateau_is_shown_and_counted(self):
        plain = self.soak_json("procedure-check", "procedure", "check", self.write("p.toml", SHORT))
        self.assertIsNone(plain["reference_c"])
        path = self.write("r.toml", SHORT.replace("[positions]", "[reference]\ntemp_c = 25\n[positions]"))
        document = self.soak_json("procedure-check", "procedure", "check", path)
        self.assertEqual((document["reference_c"], document["visits"]), (25, 4))
        self.assertEqual(document["set_points_c"], [25, 0, 80, 25])
        # Two visits more: 10 min to settle, 2 x 15 min recorded, two turns of 10 s, 30 s after one of them. The way is
        # as before, since each run ends at 25 degrees.
        self.assertAlmostEqual(document["estimate_h"] - plain["estimate_h"], 2 * (600 + 1800 + 20 + 30) / 3600, places=9)
        text = self.soak("procedure", "check", path, "--steps").stdout
        self.assertIn("25 °C", text)
        self.assertRegex(text, r"D01 visit 3\b.*\+25 °C.*\b900 s\b.* -X")
        for name in ("six-position-soak", "six-position-both-ways"):
            shipped = self.soak_json("procedure-check", "procedure", "check", PROCEDURES / f"{name}.toml")
            self.assertEqual(shipped["reference_c"], 25)

    def test_every_mistake_is_named_with_its_line(self):
        path = self.write("bad.toml", SHORT.replace("dwell_s = 900", "dwell_s = -1").replace('"-X"', '"-Q"') + "colour = 3\n")
        message = self.refusal("procedure", "check", path)["message"]
        for line in (7, 8, 14):
            self.assertIn(f"{path}:{line}: ", message)
        text = self.soak("procedure", "check", path, status=2)
        self.assertEqual(text.stdout, "")
        self.assertIn(f"{path}:14: ", text.stderr)
        self.assertIn("'colour'", text.stderr)

    def test_a_single_mistake_and_a_syntax_error_have_their_line_as_place(self):
        path = self.write("p.toml", SHORT.replace('"diagnosis"', '"fun"'))
        self.assertEqual(self.refusal("procedure", "check", path)["where"], f"{path}:2")
        path = self.write("p.toml", SHORT.replace('"diagnosis"', "= 3"))
        self.assertEqual(self.refusal("procedure", "check", path)["where"], f"{path}:2")

    def test_ratings_are_judged_with_overshoot(self):
        types = self.folder / "types"
        types.mkdir()
        for name, limit in (("strong", 82), ("weak", 81.9)):
            self.write(f"types/{name}.toml", f'name = "{name}"\n[rating]\ntemp_min_c = -10\ntemp_max_c = {limit}\n')
        path = self.write("p.toml", SHORT)
        self.soak("procedure", "check", path, "--type", "strong", "--types", types)
        message = self.refusal("procedure", "check", path, "--type", "strong", "--type", "weak", "--types", types)["message"]
        self.assertIn("'weak'", message)
        self.assertNotIn("strong", message)
        self.write("types/other.toml", 'name = "other"\n[rating]\ntemp_min_c = -10\ntemp_max_c = 60\n')
        message = self.refusal("procedure", "check", path, "--type", "weak", "--type", "other", "--types", types)["message"]
        self.assertIn("'weak'", message)
        self.assertIn("'other'", message)
        # Beside other mistakes, each with its line.
        path = self.write("p.toml", SHORT + "colour = 3\n")
        message = self.refusal("procedure", "check", path, "--type", "weak", "--types", types)["message"]
        self.assertIn(f"{path}:5: ", message)
        self.assertIn("'weak'", message)
        self.assertIn(f"{path}:14: ", message)

    def test_without_a_type_it_says_which_types_bear_it_and_refuses_where_none_does(self):
        types = self.folder / "types"
        types.mkdir()
        path = self.write("p.toml", SHORT)
        self.write("types/mystery.toml", 'name = "mystery"\n')
        self.write("types/strong.toml", 'name = "strong"\n[rating]\ntemp_min_c = -10\ntemp_max_c = 90\n')
        self.assertEqual(self.soak_json("procedure-check", "procedure", "check", path, "--types", types)["types"], ["strong"])
        self.write("types/weak.toml", 'name = "weak"\n[rating]\ntemp_min_c = -1\ntemp_max_c = 90\n')
        document = self.soak_json("procedure-check", "procedure", "check", path, "--types", types)
        self.assertEqual((document["types"], document["types_too_weak"]), (["strong"], ["weak"]))
        text = self.soak("procedure", "check", path, "--types", types).stdout
        for part in ("strong", "weak", "-1 to 90 °C"):
            self.assertIn(part, text)
        (types / "strong.toml").unlink()
        error = self.refusal("procedure", "check", path, "--types", types)
        self.assertIn("'weak'", error["message"])
        self.assertEqual(error["where"], f"{path}:5")
        # The types that come with the program are the default.
        hot = self.write("hot.toml", SHORT.replace("80", "180"))
        self.refusal("procedure", "check", hot)

    def test_no_folder_of_types_is_no_mistake_unless_it_was_named(self):
        path = self.write("p.toml", SHORT)
        nowhere = {**os.environ, "SOAK_PROCEDURES": str(self.folder / "absent")}
        self.assertEqual(self.soak_json("procedure-check", "procedure", "check", path, env=nowhere)["types"], [])
        self.refusal("procedure", "check", path, "--types", self.folder / "absent")

    def test_a_type_that_is_not_there_or_states_no_rating_is_refused(self):
        path = self.write("p.toml", SHORT)
        self.refusal("procedure", "check", path, "--type", "x", "--types", UNITS)
        self.refusal("procedure", "check", path, "--type", "generic", "--types", UNITS)


class Types(SoakTest):
    def test_list_shows_what_the_folder_holds(self):
        document = self.soak_json("type-list", "type", "list", "--types", UNITS)
        self.assertEqual([t["name"] for t in document["types"]], sorted(p.stem for p in UNITS.glob("*.toml")))
        self.assertIn("-40 to 85 °C", self.soak("type", "list", "--types", UNITS).stdout)

    def test_the_environment_names_the_folder(self):
        (self.folder / "units").mkdir()
        self.write("units/own.toml", 'name = "own"\n')
        environment = {**os.environ, "SOAK_PROCEDURES": str(self.folder)}
        self.assertIn("own", self.soak("type", "list", env=environment).stdout)

    def test_show_has_every_field(self):
        shown = self.soak_json("type-show", "type", "show", "mti-300", "--types", UNITS)["type"]
        self.assertEqual((shown["temp_min_c"], shown["temp_max_c"]), (-40, 85))
        self.assertEqual((shown["gyro_range_dps"], shown["accel_range_mps2"]), (450, 50))
        self.assertIsNone(shown["axes"])
        self.assertIn("gyro_range_dps", self.soak("type", "show", "mti-300", "--types", UNITS).stdout)

    def test_show_refuses_an_unknown_type_and_a_folder_that_is_not_there(self):
        self.refusal("type", "show", "x", "--types", UNITS)
        absent = self.folder / "absent"
        self.assertEqual(self.refusal("type", "list", "--types", absent)["where"], str(absent))


if __name__ == "__main__":
    unittest.main()
