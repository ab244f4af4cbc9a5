# SPDX-License-Identifier: Apache-2.0
"""soak plan: what a campaign of so many hours buys, and the procedure that it writes."""
import functools
import os
import pathlib
import random
import shutil
import subprocess
import tempfile
import tomllib
import unittest

from soak_cli import HEADER, SoakTest, long_test

GYROS = ["gyro_x", "gyro_y", "gyro_z"]
UPS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
RUN_SIGMA_DPS = 0.05


def campaign(runs, seed):
    """Rows of `runs`, each a list of (set point, sweep): a bent bias, a level for each power-on, noise."""
    noise = random.Random(seed)
    lines = [HEADER]
    for number, visits in enumerate(runs, 1):
        level = noise.gauss(0, RUN_SIGMA_DPS)
        t_s = 0.0
        for plateau_c, sweep in visits:
            bias = 0.002 * plateau_c + 3e-5 * plateau_c**2 + level
            for label, up in UPS.items():
                for _ in range(8):
                    rates = [bias + noise.gauss(0, 0.004) for _ in range(3)]
                    forces = [9.80665 * u + noise.gauss(0, 0.004) + level / 10 for u in up]
                    numbers = ",".join(f"{x:.6f}" for x in rates + forces)
                    lines.append(f"{t_s:.1f},R{number:02},soak,{sweep},{plateau_c},{label},{plateau_c},{plateau_c + noise.gauss(0, 0.02):.3f},{numbers}")
                    t_s += 2.0
                t_s += 60.0  # the station turns the fixture and waits: nothing is recorded
    return "\n".join(lines) + "\n"


def there_and_back(step_c):
    points = list(range(-20, 61, step_c))
    return [(c, "up") for c in points] + [(c, "down") for c in reversed(points[:-1])]


@functools.cache
def stored_unit():
    """A data folder with a fitted mti-300 of four runs both ways over -20 to 60 degrees."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-plan-"))
    recording = folder / "campaign.csv"
    recording.write_text(campaign([there_and_back(10)] * 4, seed=1), encoding="utf-8")
    for command in (["import", recording, "--unit", "SN1", "--type", "mti-300", "--gravity-mps2", "9.80665"],
                    ["fit", "--unit", "SN1", "--rules", "3"]):
        subprocess.run([os.environ["SOAK_BIN"], *map(str, command), "--data", str(folder / "data")], check=True, capture_output=True)
    return folder


def tearDownModule():
    if stored_unit.cache_info().currsize:
        shutil.rmtree(stored_unit(), ignore_errors=True)


class PlanTest(SoakTest):
    def plan(self, *arguments):
        return self.soak_json("plan", "plan", "--type", "mti-300", "-o", self.folder / "planned.toml", *arguments)

    def check(self):
        return self.soak_json("procedure-check", "procedure", "check", self.folder / "planned.toml", "--type", "mti-300")


class PlanOfStoredUnits(PlanTest):
    def setUp(self):
        super().setUp()
        shutil.copytree(stored_unit() / "data", self.data)

    def test_the_procedure_costs_what_the_plan_says_goes_both_ways_and_visits_both_ends(self):
        document = self.plan()
        chosen = document["options"][document["chosen"]]
        checked = self.check()
        self.assertAlmostEqual(checked["estimate_h"], chosen["hours"], places=9)
        self.assertEqual(checked["runs"], chosen["power_ons"])
        self.assertEqual(chosen["power_ons"], chosen["passes"] * (1 + chosen["power_cycles"]))
        points = checked["set_points_c"]
        self.assertEqual((min(points), max(points)), (-20, 60))
        self.assertEqual((document["picture"]["temp_min_c"], document["picture"]["temp_max_c"]), (-20, 60))
        steps = {b > a for a, b in zip(points, points[1:])}
        self.assertEqual(steps, {True, False})
        self.assertGreaterEqual(chosen["passes"], 3)

    def test_the_picture_is_that_of_the_stored_unit(self):
        picture = self.plan()["picture"]
        self.assertEqual((picture["source"], picture["units"], picture["simulated"]), ("units", ["SN1"], False))
        for name in GYROS:
            sensor = picture["sensors"][name]
            # Four power-ons: their scatter within the 99.9 % interval of chi-squared of three degrees of freedom.
            self.assertTrue(0.08 * RUN_SIGMA_DPS < sensor["run_to_run"] < 2.4 * RUN_SIGMA_DPS, sensor)
            # 48 white samples of 0.004 deg/s in a visit.
            self.assertAlmostEqual(sensor["noise"], 0.004 / 48**0.5, delta=0.3 * 0.004 / 48**0.5)
            self.assertLess(sensor["half_gap"], 0.001)

    @long_test
    def test_power_cycles_are_done_where_the_branches_of_a_loop_meet(self):
        document = self.plan("--accuracy", "gyro_dps=0.02")
        self.assertGreater(document["options"][document["chosen"]]["power_cycles"], 0)
        procedure = tomllib.loads((self.folder / "planned.toml").read_text(encoding="utf-8"))
        self.assertEqual(procedure["power"]["cycle_at_visit"], 0)
        points = procedure["temperatures"]["list_c"]
        self.assertEqual((points[0], points[-1]), (-20, -20))
        self.assertNotIn("reference", procedure)

    @long_test
    def test_options_cost_more_and_buy_more_and_the_cheapest_good_one_is_chosen(self):
        document = self.plan()
        options = document["options"]
        hours = [option["hours"] for option in options]
        self.assertEqual(hours, sorted(hours))
        relative = [option["relative"] for i, option in enumerate(options) if i != document["chosen"]]
        self.assertEqual(relative, sorted(relative, reverse=True))
        self.assertAlmostEqual(document["full"]["relative"], 1.0)
        self.assertEqual((document["full"]["passes"], document["full"]["plateaus"], document["full"]["return_every"]), (20, 21, 0))
        self.assertTrue(document["reached"])
        self.assertFalse([o for o in options[:document["chosen"]] if o["relative"] <= 1.0])

    @long_test
    def test_a_level_that_makes_most_of_the_band_is_had_by_power_cycles_instead_of_passes(self):
        full = self.plan()["full"]
        document = self.plan("--accuracy", f"gyro_dps={max(full['sensors'][name]['curve95'] for name in GYROS)}")
        chosen = document["options"][document["chosen"]]
        self.assertGreater(chosen["power_ons"], 2 * chosen["passes"])
        self.assertLess(chosen["hours"], full["hours"] / 3)

    def test_a_target_is_met_by_the_band_of_the_worst_sensor(self):
        loose = self.plan("--accuracy", "gyro_dps=0.06")
        tight = self.plan("--accuracy", "gyro_dps=0.02,accel_mps2=1")
        for document, target in ((loose, 0.06), (tight, 0.02)):
            chosen = document["options"][document["chosen"]]
            widest = max(chosen["sensors"][name]["curve95"] for name in GYROS)
            self.assertLessEqual(widest, target)
            self.assertAlmostEqual(max(p["curve95"] for name in GYROS for p in document["bands"][name]), widest)
        self.assertLess(loose["options"][loose["chosen"]]["hours"], tight["options"][tight["chosen"]]["hours"])
        self.assertEqual(tight["accuracy"], {"gyro_dps": 0.02, "accel_mps2": 1})

    @long_test
    def test_within_hours_the_best_is_written_and_what_is_not_reached_is_said(self):
        document = self.plan("--hours", "60", "--accuracy", "gyro_dps=0.001")
        chosen = document["options"][document["chosen"]]
        self.assertLessEqual(chosen["hours"], 60)
        self.assertFalse(document["reached"])
        self.assertLessEqual(chosen["relative"], min(o["relative"] for o in document["options"] if o["hours"] <= 60))
        self.assertAlmostEqual(self.check()["estimate_h"], chosen["hours"])
        said = self.soak("plan", "--type", "mti-300", "-o", self.folder / "p.toml", "--hours", "60", "--accuracy", "gyro_dps=0.001")
        self.assertIn("not reached", said.stderr)
        self.assertIn("full campaign", said.stdout)

    def test_what_cannot_be_had_is_refused_and_no_file_is_written(self):
        for arguments, names in ((["--accuracy", "gyro_dps=0.00001"], "--accuracy"), (["--hours", "2"], "--hours"),
                                 (["--accuracy", "gyro_dps=0"], "gyro_dps"), (["--accuracy", "gyro_dps=1,gyro_dps=0.03"], "once"), (["--accuracy", "mag=1"], "accel_mps2")):
            error = self.refusal("plan", "--type", "mti-300", "-o", self.folder / "none.toml", *arguments)
            self.assertIn(names, error["message"] + error["where"])
        self.assertFalse((self.folder / "none.toml").exists())

    def test_a_fit_takes_a_campaign_of_the_planned_procedure(self):
        document = self.plan("--accuracy", "gyro_dps=0.06")
        chosen = document["options"][document["chosen"]]
        points = self.check()["set_points_c"]
        visits = [(points[0], "up")] + [(b, "up" if b > a else "down") for a, b in zip(points, points[1:])]
        runs = ([visits[:1]] * chosen["power_cycles"] + [visits]) * chosen["passes"]
        self.soak("import", self.write("planned.csv", campaign(runs, seed=2)), "--unit", "SN2", "--type", "mti-300", "--gravity-mps2", "9.80665")
        fit = self.soak_json("fit", "fit", "--unit", "SN2", "--rules", "3")
        for name in GYROS:
            sensor = fit["sensors"][name]
            self.assertEqual((sensor["holdout"], len(sensor["runs"])), ("run", chosen["power_ons"]))
            self.assertEqual(len(sensor["checks"]), chosen["passes"])
            self.assertIsNotNone(sensor["check_rmse_shape"])
            self.assertIsNone(sensor["one_way"])
            self.assertAlmostEqual(sensor["temp_max_c"], 60, delta=0.5)


def ramp(seed):
    """One run in six positions, each a ramp up over -20 to 60 degrees: no plateau is named."""
    noise = random.Random(seed)
    lines = [HEADER]
    t_s = 0.0
    for label, up in UPS.items():
        for k in range(400):
            temp_c = -20 + 0.2 * k
            rates = [0.002 * temp_c + noise.gauss(0, 0.004) for _ in range(3)]
            forces = [9.80665 * u + noise.gauss(0, 0.004) for u in up]
            lines.append(f"{t_s:.1f},R01,ramp,up,,{label},{temp_c:.2f},{temp_c:.3f},{','.join(f'{x:.6f}' for x in rates + forces)}")
            t_s += 2.0
    return "\n".join(lines) + "\n"


class PlanOfRamps(PlanTest):
    def test_units_without_plateaus_teach_nothing_and_the_type_stands_in(self):
        self.soak("import", self.write("ramp.csv", ramp(3)), "--unit", "SN3", "--type", "mti-300", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN3", "--rules", "3")
        picture = self.plan()["picture"]
        self.assertEqual((picture["source"], picture["units"]), ("type", []))


class PlanOfUnitsThatShowLittle(PlanTest):
    def setUp(self):
        super().setUp()
        # Gyros alone.
        lines = campaign([there_and_back(20)] * 3, seed=4).splitlines()
        def without_accel(line):
            return ",".join(line.split(",")[:-3] + ["", "", ""])
        text = "\n".join([HEADER] + [without_accel(line) for line in lines[1:]]) + "\n"
        self.soak("import", self.write("little.csv", text), "--unit", "SN4", "--type", "mti-300", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN4", "--rules", "2")

    def test_the_types_limit_stands_in_for_sensors_that_they_do_not_show(self):
        document = self.plan()
        picture = document["picture"]
        self.assertEqual((picture["source"], picture["units"]), ("units", ["SN4"]))
        self.assertTrue([r for r in picture["remarks"] if r.startswith("accel_x: no stored unit shows")], picture["remarks"])
        # The limit is 0.07 m/s2: 95 % of what is wrong, half of the variance over temperature.
        self.assertAlmostEqual(picture["sensors"]["accel_x"]["scale"], 0.07 / 8**0.5)
        self.assertEqual(document["warnings"], [])

    def test_what_a_fit_would_warn_of_the_runs_is_said(self):
        text = (self.folder / "little.csv").read_text(encoding="utf-8").replace(",R0", ",S0")
        self.soak("import", self.write("again.csv", text), "--unit", "SN4", "--campaign", "again", "--gravity-mps2", "9.80665")
        warnings = self.plan()["warnings"]
        self.assertEqual({w["code"] for w in warnings}, {"copied_runs"})
        self.assertTrue(all(w["text"].startswith("SN4: ") for w in warnings), warnings)
        self.assertIn("warning: SN4: ", self.soak("plan", "--type", "mti-300", "-o", self.folder / "p.toml").stderr)

    @long_test
    def test_a_short_dwell_of_the_stored_units_is_said(self):
        remarks = self.plan()["picture"]["remarks"]
        self.assertTrue([r for r in remarks if "dwelt" in r and "600 s" in r], remarks)


class PlanOfATypeAlone(PlanTest):
    def setUp(self):
        super().setUp()
        self.soak("unit", "add", "SN9", "--type", "mti-300")

    def test_limits_of_the_type_stand_in_and_it_is_said(self):
        document = self.plan()
        self.assertEqual((document["picture"]["source"], document["picture"]["units"]), ("type", []))
        self.assertTrue(document["picture"]["remarks"])
        # Rated -40 to 85 degrees, less 2 K of overshoot, in whole steps of 5 K.
        self.assertEqual((document["picture"]["temp_min_c"], document["picture"]["temp_max_c"]), (-35, 80))
        self.assertIn("assumed", self.soak("plan", "--type", "mti-300", "-o", self.folder / "p.toml").stdout)
        self.check()

    def type_rated(self, low_c, high_c, name="rated"):
        """A unit type of the user's, with the limits of a gyro."""
        types = self.folder / "types"
        types.mkdir(exist_ok=True)
        text = "\n".join([f"name = '{name}'", "[rating]", f"temp_min_c = {low_c}", f"temp_max_c = {high_c}", "[limits]", "gyro = 0.5"])
        (types / f"{name}.toml").write_text(text + "\n", encoding="utf-8")
        os.environ["SOAK_UNIT_TYPES"] = str(types)
        self.addCleanup(os.environ.pop, "SOAK_UNIT_TYPES", None)
        return name

    def test_ranges_that_make_no_campaign_are_refused_by_the_name_of_the_type(self):
        for low_c, high_c in ((22, 28), (20, 29), (-60, 20), (70, 120)):
            name = self.type_rated(low_c, high_c)
            error = self.refusal("plan", "--type", name, "-o", self.folder / "none.toml")
            self.assertEqual(error["where"], "--type")
            self.assertIn(f"rated {low_c} to {high_c}", error["message"])
        self.assertFalse((self.folder / "none.toml").exists())

    @long_test
    def test_hot_and_narrow_ranges_make_procedures_and_names_stay_themselves(self):
        for low_c, high_c, name in ((40, 90, "hot"), (15, 32, "narrow"), (-40, 85, 'q"t')):
            self.type_rated(low_c, high_c, name)
            self.soak_json("plan", "plan", "--type", name, "-o", self.folder / "planned.toml")
            checked = self.soak_json("procedure-check", "procedure", "check", self.folder / "planned.toml", "--type", name)
            self.assertEqual(checked["name"], f"planned-{name}")
            points = sorted(set(checked["set_points_c"]))
            self.assertGreater(min(b - a for a, b in zip(points, points[1:])), 1)

    def test_a_type_of_which_nothing_is_known_is_refused(self):
        error = self.refusal("plan", "--type", "vn-200", "-o", self.folder / "p.toml")
        self.assertIn("[limits]", error["message"])
        self.assertIn("rating", self.refusal("plan", "--type", "generic", "-o", self.folder / "p.toml")["message"])


if __name__ == "__main__":
    unittest.main()
