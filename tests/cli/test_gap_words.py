# SPDX-License-Identifier: Apache-2.0
"""What `soak gap` says first: three sentences of plain result, judged by what they name, not by their wording. What was found, with its
size and unit, in which sensors; how sure that is and what it cannot be told from; the command or the run that comes next."""
import html
import math
import os
import pathlib
import random
import re
import sys
import unittest

from soak_cli import ROOT, SoakTest, long_test

sys.path.insert(0, str(ROOT / "tests" / "blind"))
import second_laboratory  # noqa: E402
from blind_campaign import Campaign, Programs  # noqa: E402

SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
FIND = "soak gap find --unit SN1"


class Words(SoakTest):
    def campaign(self, seed, effect=None, kind="identical", magnitude=2.4, effect_seed=3, fresh=()):
        """A campaign of the simulator, fitted to all runs but those that are to be fresh."""
        programs = Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
        hidden = [] if effect is None else [{"effect": effect, "magnitude": magnitude, "seed": effect_seed}]
        path = Campaign(programs, self.folder, seed, {"kind": kind}, hidden).csv
        head, *rows = path.read_text(encoding="utf-8").splitlines(keepends=True)
        run = head.rstrip().split(",").index("run")
        for name, wanted, options in (("fit.csv", False, ()), ("fresh.csv", True, ("--procedure", "verification", "--campaign", "fresh"))):
            kept = [row for row in rows if (row.split(",")[run] in fresh) == wanted]
            if kept:
                self.soak("import", self.write(name, "".join([head, *kept])), "--unit", "SN1", "--gravity-mps2", "9.80665", *options)
        self.soak("fit", "--unit", "SN1", "--rules", 2)

    def found(self):
        """The document of a search, and the lines of its text."""
        document = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        return document, self.soak("gap", "find", "--unit", "SN1").stdout.splitlines()

    def first_three(self, lines):
        """Whole sentences, then an empty line."""
        for line in lines[:3]:
            self.assertTrue(line.endswith("."), line)
            self.assertNotRegex(line, r"\bp = |\bp_adjusted|e-\d", "figures of evidence come later")
        self.assertEqual(lines[3], "")
        return lines[:3]

    def assert_holds(self, line, *objects):
        for wanted in objects:
            self.assertIn(wanted, line)

    def test_of_a_name_they_hold_size_sensors_and_the_command_that_accepts_it(self):
        self.campaign(505, "sensor_lag")
        document, lines = self.found()
        what, sure, following = self.first_three(lines)
        effect, = document["effects"]
        self.assertEqual((effect["name"], effect["confusable_with"], effect["next_experiment"]), ("sensor_lag", [], None))
        self.assert_holds(what, "SN1", "model 1", "thermometer", "sensor_lag", f"{effect['magnitude']['value']:.3g} s", "all sensors")
        self.assert_holds(sure, "no other known effect")
        self.assert_holds(following, "soak gap accept --unit SN1", "soak gap show --unit SN1")

        accepted = self.first_three(self.soak("gap", "accept", "--unit", "SN1").stdout.splitlines())
        self.assert_holds(accepted[0], "SN1", "model 2", "sensor_lag", f"{effect['magnitude']['value']:.3g} s", "all sensors")
        self.assert_holds(accepted[2], "verification", "soak gap show --unit SN1")

        shown = self.first_three(self.soak("gap", "show", "--unit", "SN1").stdout.splitlines())
        self.assert_holds(shown[0], "SN1", "model 2", "model 1", "sensor_lag")
        self.assert_holds(shown[2], "verification", "soak gap show --unit SN1")

    def test_of_a_comparison_with_fresh_runs_they_hold_what_is_closed_and_what_comes_next(self):
        self.campaign(505, "sensor_lag", fresh=("R05", "R06"))
        self.soak("gap", "accept", "--unit", "SN1")
        page = self.folder / "gap.html"
        lines = self.soak("gap", "show", "--unit", "SN1", "-o", page).stdout.splitlines()
        what, closed, following = self.first_three(lines)
        document = self.soak_json("gap-show", "gap", "show", "--unit", "SN1")
        named = next(sensor for sensor in SENSORS if sensor in closed)
        figures = document["sensors"][named]["fresh"]
        self.assert_holds(closed, f"{figures['before_rms']:.3g}", f"{figures['after_rms']:.3g}", document["sensors"][named]["unit"], "2 runs")
        self.assert_holds(following, "soak verify --unit SN1 --campaign")
        text = html.unescape(page.read_text(encoding="utf-8"))
        at = [text.index(sentence) for sentence in (what, closed, following)]
        self.assertEqual(at, sorted(at))
        self.assertLess(at[2], text.index("<table"))

    @long_test
    def test_of_an_effect_that_the_model_has_already_they_hold_how_to_take_it_out(self):
        self.campaign(81, "g_sensitivity")
        self.soak("gap", "accept", "--unit", "SN1")
        again = self.folder / "again"
        again.mkdir()
        more = Campaign(Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml"), again, 81, {"kind": "identical"},
                        [{"effect": "g_sensitivity", "magnitude": 6.0, "seed": 3}])
        self.soak("import", more.csv, "--unit", "SN1", "--gravity-mps2", "9.80665", "--campaign", "again")
        document = self.soak_json("gap-find", "gap", "find", "--unit", "SN1", "--campaign", "again")
        lines = self.soak("gap", "find", "--unit", "SN1", "--campaign", "again").stdout.splitlines()
        self.assertEqual([effect["name"] for effect in document["effects"]], ["g_sensitivity"], document["reason"])
        following = self.first_three(lines)[2]
        self.assert_holds(following, "soak gap withdraw --unit SN1 --effect g_sensitivity", "already")
        self.assertNotIn("soak gap accept", following)
        withdrawn = self.first_three(self.soak("gap", "withdraw", "--unit", "SN1", "--effect", "g_sensitivity", "--reason", "more of it").stdout.splitlines())
        self.assert_holds(withdrawn[0], "SN1", "model 3", "g_sensitivity")
        self.assert_holds(withdrawn[1], "model 2")
        self.assert_holds(withdrawn[2], FIND)

    @long_test
    def test_of_an_effect_that_harms_they_hold_that_one_and_the_command_that_takes_it_out(self):
        """Fitted to runs with two effects; of those that follow one has gone, and the other has stayed."""
        programs = Programs(pathlib.Path(os.environ["SOAK_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
        lag = {"effect": "sensor_lag", "magnitude": 2.4, "seed": 3}
        felt = {"effect": "g_sensitivity", "magnitude": 2.4, "seed": 3}
        for name, hidden, options in (("both", [lag, felt], ()), ("one", [lag], ("--procedure", "verification", "--campaign", "fresh"))):
            (self.folder / name).mkdir()
            made = Campaign(programs, self.folder / name, 81, {"kind": "identical"}, hidden)
            self.soak("import", made.csv, "--unit", "SN1", "--gravity-mps2", "9.80665", *options)
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        accepted = self.soak_json("gap-accept", "gap", "accept", "--unit", "SN1")
        self.assertEqual({term["name"] for term in accepted["terms"]}, {"sensor_lag", "g_sensitivity"})
        following = self.first_three(self.soak("gap", "show", "--unit", "SN1").stdout.splitlines())[2]
        self.assert_holds(following, "soak gap withdraw --unit SN1 --effect g_sensitivity")

    @long_test
    def test_of_a_name_with_a_rival_they_hold_the_rival_and_the_run_that_decides(self):
        self.campaign(511, "thermal_hysteresis", magnitude=0.3)
        document, lines = self.found()
        what, sure, following = self.first_three(lines)
        effect = document["effects"][0]
        self.assertTrue(effect["confusable_with"], effect)
        self.assertGreater(max(effect["odds"].values()), 1e-6)
        self.assert_holds(what, effect["name"], effect["magnitude"]["unit"])
        self.assert_holds(sure, effect["name"], *effect["confusable_with"])
        self.assert_holds(following, effect["next_experiment"], FIND)

    def test_of_a_name_whose_rivals_are_out_they_advise_to_accept(self):
        self.campaign(508, "g_sensitivity", magnitude=2.4)
        document, lines = self.found()
        what, sure, following = self.first_three(lines)
        effect = document["effects"][0]
        self.assertTrue(effect["confusable_with"], effect)
        self.assertLess(max(effect["odds"].values()), 1e-6)
        self.assert_holds(sure, effect["name"], *effect["confusable_with"])
        self.assert_holds(following, "soak gap accept --unit SN1")

    def test_of_nothing_they_hold_what_could_be_there_unseen(self):
        self.campaign(700)
        document, lines = self.found()
        self.assertEqual(document["verdict"], "none")
        what, seen, following = self.first_three(lines)
        self.assert_holds(what, "SN1", "model 1")
        gyros = [limit for sensor, limit in document["detection_limit"].items() if sensor.startswith("gyro")]
        self.assert_holds(seen, f"{min(gyros):.2g}", f"{max(gyros):.2g} deg/s", "m/s2")
        self.assert_holds(following, "soak verify --unit SN1")

    def test_of_one_run_they_hold_why_and_what_to_record(self):
        self.campaign(800, "thermal_hysteresis", "one")
        document, lines = self.found()
        self.assertEqual(document["verdict"], "cannot_judge")
        what, why, following = self.first_three(lines)
        self.assert_holds(what, "SN1", "model 1")
        self.assert_holds(why, document["reason"])
        self.assert_holds(following, "second run", "soak runs void", FIND)

    def unknown(self, number, effect, kind):
        self.campaign(900 + number, effect, effect_seed=5 + number)
        document, lines = self.found()
        structure = document["residual_structure"]
        self.assertLessEqual({"kind", "usual", "look", "closer_plateaus_k", "runs", "steps"}, structure.keys())
        self.assertIn("slow_noise", document)
        self.assertEqual((document["verdict"], structure["kind"], structure["runs"]), ("unknown", kind, 6), document["reason"])
        what, usual, following = self.first_three(lines)
        self.assert_holds(what, "SN1", "model 1", "deg/s" if any(s.startswith("gyro") for s in structure["sensors"]) else "m/s2")
        self.assertTrue(any(sensor in what for sensor in (*structure["sensors"], "all sensors")), what)
        self.assert_holds(usual, structure["usual"])
        self.assert_holds(following, structure["look"], FIND)
        return structure, what

    @long_test
    def test_of_a_daily_wave_they_hold_where_to_look(self):
        structure, what = self.unknown(0, "daily_wave", "daily_wave")
        self.assert_holds(what, structure["axis"])
        self.assertEqual(structure["steps"], [])

    @long_test
    def test_of_telegraph_noise_they_hold_where_to_look(self):
        self.unknown(1, "telegraph_noise", "telegraph_noise")

    @long_test
    def test_of_steps_they_hold_run_sensor_and_size(self):
        structure, what = self.unknown(2, "bias_step", "jumps")
        self.assertTrue(structure["steps"])
        self.assertTrue(any(step["run"] in what and step["sensor"] in what and f"{step['size']:.2g} {step['unit']}" in what
                            for step in structure["steps"]), what)
        self.assert_holds(what, "after its first reading at a plateau")
        for step in structure["steps"]:
            self.assertLess(step["last_before_s"], step["since_start_s"], step)


class SlowNoise(SoakTest):
    def wandering_unit(self):
        """Six runs of the second laboratory with a bias that wanders, and twenty hours of its rest: white noise of 0.01 deg/s at 1/s and a
        walk, whose Allan deviation is least between them."""
        recording = self.write("unit.csv", second_laboratory.make(501, second_laboratory.Design(slow=1.25)).csv)
        self.soak("import", recording, "--unit", "SN1", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN1", "--rules", 2)

    def rest(self):
        noise, walk, lines = random.Random(5), 0.0, ["t_s,temp_c,gx_dps"]
        for second in range(72000):
            walk += noise.gauss(0, 2e-5)
            lines.append(f"{second},25.0,{walk + noise.gauss(0, 0.01):.6f}")
        rest = self.write("rest.csv", "\n".join(lines) + "\n")
        self.soak("import", rest, "--unit", "SN1", "--campaign", "rest", "--procedure", "verification", "--gravity-mps2", "9.80665")

    def test_slow_noise_is_listed_beside_the_bias_instability_at_rest(self):
        self.wandering_unit()
        before = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual({entry["sensor"] for entry in before["slow_noise"]}, set(SENSORS))
        self.assertEqual({entry["bias_instability"] for entry in before["slow_noise"]}, {None})
        for entry in before["slow_noise"]:
            # Of processes of 6 minutes, an hour and ten hours, alike in size: a run of some ten hours holds less of the slowest.
            self.assertTrue(0.05 < entry["share_minutes"] < 0.95, entry)
            block = 0.004 if entry["sensor"].startswith("gyro") else 0.002
            # 1.25 blocks in all; about the mean of a run less, by what outlasts it.
            self.assertTrue(0.5 * block < entry["within_run"] < 1.9 * block, entry)
        self.rest()
        found = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual((found["verdict"], found["gap"]), (before["verdict"], before["gap"]))
        of_rest = {entry["sensor"]: entry["bias_instability"] for entry in found["slow_noise"]}
        self.assertEqual([sensor for sensor in SENSORS if of_rest[sensor] is not None], ["gyro_x"])
        stated = of_rest["gyro_x"]
        # Allan variance N²/τ + K²τ/3 with N = 0.01, K = 2e-5: least at τ = √3 N/K, 2 N K/√3; over 0.664.
        truth = math.sqrt(2 * 0.01 * 2e-5 / math.sqrt(3)) / 0.664
        self.assertTrue(stated["ci95"][0] < truth < stated["ci95"][1], stated)
        self.assertEqual((stated["campaign"], stated["run"]), ("rest", "rest"))
        text = self.soak("gap", "find", "--unit", "SN1").stdout
        row = next(line for line in text.splitlines() if re.match(r"gyro_x .*%.*%.* at ", line))
        entry = next(entry for entry in found["slow_noise"] if entry["sensor"] == "gyro_x")
        for number in (entry["within_run"], stated["value"], *stated["ci95"]):
            self.assertIn(f"{number:.2g}", row)
        page = self.folder / "gap.html"
        self.soak("gap", "show", "--unit", "SN1", "-o", page)
        self.assertIn('id="slow-noise"', page.read_text(encoding="utf-8"))
        shown = self.soak_json("gap-show", "gap", "show", "--unit", "SN1")
        self.assertEqual([entry["sensor"] for entry in shown["slow_noise"]], [entry["sensor"] for entry in found["slow_noise"]])

    @long_test
    def test_a_rest_that_cannot_be_read_is_a_warning(self):
        self.wandering_unit()
        of_runs = set((self.data / "runs").iterdir())
        self.rest()
        path, = set((self.data / "runs").iterdir()) - of_runs
        path.chmod(0o644)
        path.write_bytes(path.read_bytes()[:1000])
        done = self.soak("gap", "find", "--unit", "SN1")
        self.assertIn("'rest'", done.stderr)
        self.assertIn("bias instability", done.stderr)
        found = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual(({entry["sensor"] for entry in found["slow_noise"]}, {entry["bias_instability"] for entry in found["slow_noise"]}), (set(SENSORS), {None}))

    @long_test
    def test_without_slow_noise_the_list_is_empty(self):
        recording = self.write("unit.csv", second_laboratory.make(11, second_laboratory.Design()).csv)
        self.soak("import", recording, "--unit", "SN1", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        found = self.soak_json("gap-find", "gap", "find", "--unit", "SN1")
        self.assertEqual((found["verdict"], found["slow_noise"]), ("none", []))


if __name__ == "__main__":
    unittest.main()
