# SPDX-License-Identifier: Apache-2.0
"""A whole campaign as a user runs it: what it leaves behind, and what others see of it meanwhile."""
import json
import re
import subprocess
import tomllib
import unittest
import urllib.error
import urllib.request

import bench
from bench import AUTO, ROOT, LabTest, long_test, short_procedure
from lab_session import end


class Campaign(LabTest):
    def test_leaves_sealed_runs_a_full_journal_and_models_all_marked_simulated(self):
        self.start_lab(units=2, rate=2000)
        begun = self.start_campaign(short_procedure(set_points=(10, 25, 40), runs=2, preflight_s=10,
                                                    positions=("+X", "-X", "+Y", "-Y", "+Z", "-Z")))
        self.assertEqual((begun["campaign"], begun["runs"]), ("c", 3))
        self.check_schema(begun, "campaign-start")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertTrue(status["simulated"])
        self.assert_safe()

        runs = self.lab.soak_json("runs", "list")["runs"]
        self.assertEqual([(r["run"], r["unit"]) for r in runs], [(run, unit) for run in ("P00", "R01", "R02")
                                                                 for unit in ("0380A001", "0380A002")])
        for run in runs:
            self.assertTrue(run["sealed"] and run["simulated"])
            self.assertEqual(run["purpose"], "diagnosis" if run["run"] == "P00" else "calibration")
        self.lab.soak("runs", "verify")
        self.assertEqual(self.query("SELECT state FROM journal"), [("finished",)])
        done = self.query("SELECT step_index, outcome FROM step ORDER BY ordinal")
        self.assertEqual(done, [(i, "done") for i in range(begun["steps"])])
        # Two runs, three plateaus, six positions.
        self.assertEqual(self.query("SELECT unit, count(*) FROM segment JOIN run USING (run_id, unit) WHERE purpose = "
                                    "'calibration' GROUP BY unit"), [("0380A001", 36), ("0380A002", 36)])
        self.check_positions()
        self.check_noise()
        self.check_models()

    def check_positions(self):
        """Each unit is mounted in its own way; in every segment gravity stands where its label says."""
        rows = self.query("SELECT unit, position, accel_x_mean, accel_y_mean, accel_z_mean FROM segment")
        self.assertGreaterEqual(len(rows), 72)
        for unit, position, *force in rows:
            expected = [(1 if position[0] == "+" else -1) * 9.81 if axis == position[1] else 0.0 for axis in "XYZ"]
            for value, right in zip(force, expected):
                self.assertAlmostEqual(value, right, delta=0.5, msg=f"{unit} {position}")

    def check_noise(self):
        """The deviations of the last run at 1 s are the white noise that the simulated laboratory is told to have."""
        told = tomllib.loads((ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8"))["lab_noise"]
        # One unit of random walk per square root of an hour is 1/60 of it per second, averaged over 1 s.
        expected = {"gyro": told["gyro_angle_random_walk_deg_per_sqrt_h"] / 60,
                    "accel": told["accel_velocity_random_walk_mps_per_sqrt_h"] / 60}
        shown = self.wait("noise", lambda s: all(unit["noise"]["gyro_dps"] for unit in s["units"]))
        self.check_schema(shown, "campaign-status")
        for unit in shown["units"]:
            noise = self.noise(unit["serial"])
            # 18 positions of 30 s at 10 Hz, less the one row that stays between two.
            self.assertAlmostEqual(noise["samples"], 18 * 300, delta=36)
            at = noise["tau_s"].index(1.0)
            self.assertEqual(unit["noise"]["tau_s"], 1.0)
            for sensor, values in noise["sensors"].items():
                kind, axis = sensor.split("_")
                # 18 times 1.5 * 30 - 2 degrees of freedom (NIST SP 1065, table 5): 1 / sqrt(2 * 774) = 2.5 %; slow
                # noise and the output step add less.
                self.assertAlmostEqual(values["oadev"][at] / expected[kind], 1.0, delta=0.2, msg=f"{unit['serial']} {sensor}")
                in_status = unit["noise"]["gyro_dps" if kind == "gyro" else "accel_mps2"]
                self.assertAlmostEqual(in_status["xyz".index(axis)] / expected[kind], 1.0, delta=0.2)
        self.check_schema(noise, "http-noise")
        for path in ("plan", "history", "log?after=-20", "stored"):
            with urllib.request.urlopen(f"{self.lab.page}api/v1/{path}", timeout=30) as answer:
                self.check_schema(json.load(answer), f"http-{path.partition('?')[0]}")
        with self.assertRaises(urllib.error.HTTPError) as refused:
            self.noise("nobody")
        self.assertEqual(refused.exception.code, 400)
        error = json.load(refused.exception)["error"]
        self.assertEqual((error["code"], error["where"]), (2, "unit"))
        self.assertIn("0380A001, 0380A002", error["message"])

    def noise(self, serial):
        with urllib.request.urlopen(f"{self.lab.page}api/v1/noise?unit={serial}", timeout=30) as answer:
            return json.load(answer)

    def check_models(self):
        truth = {u["unit"]: u["sensors"] for u in self.lab.truth()["units"]}
        for serial in ("0380A001", "0380A002"):
            fit = self.lab.soak_json("fit", "--unit", serial)
            self.assertTrue(fit["simulated"])
            self.assertEqual(len(fit["sensors"]["gyro_x"]["runs"]), 2, "the pre-flight is no run to fit")
            blob = self.folder / f"{serial}.soakcal"
            self.soak_fails(2, "export", "--unreleased", "--unit", serial, "--format", "blob", "-o", blob)
            self.lab.soak("export", "--unreleased", "--unit", serial, "--format", "blob", "--simulated", "-o", blob)
            shown = self.lab.soak_json("eval", blob, "--temp-c", "25")
            for sensor, spread in (("gyro_x", 0.06), ("accel_z", 0.03)):
                curve = dict(zip(self.lab.truth()["temp_c"], truth[serial][sensor]["bias"]))
                self.assertAlmostEqual(shown["points"][0]["bias"][sensor], curve[25.0], delta=spread)

    def test_others_read_from_the_devices_what_the_page_shows(self):
        self.start_lab(rate=50)
        self.check_schema(self.status(), "campaign-status")
        self.start_campaign(short_procedure(set_points=(40,)))
        self.wait_for_step("set_temperature")
        self.wait("on the way", lambda s: s["chamber"]["set_point_c"] == 40.0)
        self.check_schema(self.lab.soak_json("campaign", "status"), "campaign-status")
        shown = self.status()["chamber"]
        port = self.lab.ports["chamber"]
        poll = subprocess.run(["mbpoll", "-m", "tcp", "-p", str(port), "-a", "1", "-0", "-r", "2782", "-t", "4:float", "-c", "1",
                               "-1", "127.0.0.1"], capture_output=True, text=True, check=True).stdout
        self.assertIn("[2782]: \t40", poll)
        mode, _, set_point_c, air_c = self.chamber()
        later = self.status()["chamber"]
        self.assertEqual((mode == AUTO, set_point_c), (shown["running"], shown["set_point_c"]))
        low, high = sorted((shown["air_c"], later["air_c"]))
        self.assertLess(low - 1.0, air_c)
        self.assertGreater(high + 1.0, air_c)
        fixture = self.modbus("fixture").read_holding_registers(1, 1, 1).registers[0]
        self.assertEqual(("+X", "-X", "+Y", "-Y", "+Z", "-Z")[fixture - 1], self.status()["fixture"]["position"])
        self.assertEqual(self.modbus("relay").read_holding_registers(16, 1, 1).registers, [1])
        self.assertTrue(self.status()["units"][0]["powered"])

    def test_a_silent_chamber_stops_the_countdown(self):
        self.start_lab(cut=["chamber"])
        self.start_campaign(short_procedure())
        self.wait_for_step("record")
        self.proxies["chamber"].cut()
        silent = self.wait("the chamber is missed", lambda s: s["state"] == "waiting" and not s["chamber"]["connected"])
        self.hold(silent)
        self.proxies["chamber"].mend()
        self.come_nearer(silent)
        self.assertEqual(self.wait_for_end()["state"], "finished")

    def test_pause_holds_the_chamber_and_resume_goes_on(self):
        self.start_lab()
        self.start_campaign(short_procedure())
        self.wait_for_step("record")
        self.check_schema(self.lab.soak_json("campaign", "pause"), "campaign-state")
        paused = self.status()
        self.assertEqual(paused["state"], "paused")
        self.hold(paused)
        mode, _, set_point_c, _ = self.chamber()
        self.assertEqual((mode, set_point_c), (AUTO, paused["chamber"]["set_point_c"]))
        self.lab.soak("campaign", "resume")
        self.come_nearer(paused)
        self.assertEqual(self.wait_for_end()["state"], "finished")
        # The recording that was broken is withdrawn, not used and not lost.
        self.assertEqual(self.query("SELECT count(*) FROM segment")[0][0] - self.query("SELECT count(*) FROM void")[0][0], 4)

    def test_abort_ends_in_the_safe_state(self):
        self.start_lab()
        self.start_campaign(short_procedure())
        self.wait_for_step("set_temperature")
        self.soak_fails(2, "campaign", "resume")
        self.lab.soak("campaign", "abort", "--reason", "smell of smoke", "--user", "ann")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "aborted")
        # On the way to the safe state, at its end and in the journal; what the station did by itself names nobody.
        asked = self.query("SELECT user FROM event WHERE kind LIKE 'campaign%' AND text LIKE '%smell of smoke%'")
        self.assertEqual(asked, [("ann",)] * 3)
        self.assertIn(("",), self.query("SELECT DISTINCT user FROM event"))
        self.assertIn("smell of smoke", status["reason"])
        self.assert_safe()
        self.assertEqual(self.query("SELECT state FROM journal"), [("aborted",)])

    def expect_of_a_unit_that_never_settles(self, outcome, state, segments, skipped):
        never = short_procedure(set_points=(20, 25)).replace("slope_kpmin = 0.05", "slope_kpmin = 0.0001")
        self.start_lab(rate=2000)
        self.start_campaign(never.replace("timeout_s = 200000", f'timeout_s = 600\non_timeout = "{outcome}"'))
        status = self.wait_for_end()
        self.assertEqual(status["state"], state, status["reason"])
        self.assert_safe()
        self.assertEqual(self.query("SELECT count(*) FROM segment"), [(segments,)])
        self.assertEqual(self.query("SELECT count(*) FROM step WHERE outcome = 'skipped'"), [(skipped,)])
        self.assert_event("step", "R01 visit 0", "600 s", "0380A001")

    def test_a_plateau_at_which_a_unit_never_settles_is_skipped(self):
        self.expect_of_a_unit_that_never_settles("skip_plateau", "finished", segments=0, skipped=2)

    @long_test
    def test_a_plateau_at_which_a_unit_never_settles_is_recorded_all_the_same(self):
        self.expect_of_a_unit_that_never_settles("record", "finished", segments=4, skipped=0)

    @long_test
    def test_a_unit_that_never_settles_ends_the_campaign(self):
        self.expect_of_a_unit_that_never_settles("abort", "failed", segments=0, skipped=0)

    @long_test
    def test_a_set_point_that_was_changed_at_the_controller_is_commanded_again(self):
        self.start_lab()
        self.start_campaign(short_procedure())
        self.wait_for_step("wait_stable")
        self.modbus("chamber").write_registers(2782, self.words_f32(35.0), 1)
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_event("device", "chamber", "+35.0 °C", "+15.0 °C")
        plateaus = dict(self.query("SELECT visit, avg(temp_c) FROM segment GROUP BY visit"))
        self.assertAlmostEqual(plateaus[0], 15.0, delta=2.0)

    @long_test
    def test_a_set_point_that_the_controller_refuses_ends_the_campaign(self):
        self.start_lab()
        self.start_campaign(short_procedure())
        self.wait_for_step("wait_stable")
        client = self.modbus("chamber")
        client.write_registers(2774, self.words_f32(20.0), 1)  # the controller's own lower limit, above the set point
        client.write_registers(2782, self.words_f32(25.0), 1)
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        for part in ("+25.0 °C", "+15.0 °C", "5 times"):
            self.assertIn(part, status["reason"])
        self.assertLess(len(self.events()), 40)
        self.assert_safe()

    def test_a_whole_degree_thermometer_is_waited_for_until_it_must_have_moved(self):
        config = (ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8")
        coarse = self.write("lab.toml", re.sub(r"thermometer_lsb_c = \S+", "thermometer_lsb_c = 1.0", config))
        self.start_lab(rate=2000, soaksim_options=["--config", coarse])
        self.start_campaign(short_procedure(set_points=(30,)))
        self.assertEqual(self.wait_for_end()["state"], "finished")
        # At 0.05 K/min one degree takes 20 minutes. The unit's clock began when it was switched on.
        (count, begin_s), = self.query("SELECT count(*), min(t_start_s) FROM segment")
        self.assertEqual(count, 2)
        self.assertGreater(begin_s, 1200)

    def test_a_fixture_turned_by_hand_asks_and_waits(self):
        self.start_lab()
        end(self.lab.soakd)
        text = self.config.read_text(encoding="utf-8")
        begin, end_ = text.index("[fixture]"), text.index("[power]")
        by_hand = self.write("by-hand.toml", text[:begin] + text[end_:])
        self.lab.start_soakd(by_hand)
        self.start_campaign(short_procedure(set_points=(25,)))
        fixture = self.modbus("fixture")
        for up in ("+Z", "-Z"):
            status = self.wait("a prompt", lambda s: s["prompt"] and up in s["prompt"]["text"])
            self.check_schema(status, "campaign-status")
            self.assertEqual(status["state"], "waiting")
            self.soak_fails(2, "campaign", "confirm", "--prompt", status["prompt"]["id"] + 1000)
            fixture.write_register(0, 1 + ("+X", "-X", "+Y", "-Y", "+Z", "-Z").index(up), 1)
            self.lab.soak("campaign", "confirm")
        self.assertEqual(self.wait_for_end()["state"], "finished")


if __name__ == "__main__":
    bench.main(at_once=2)  # fast clocks: they compute more than they wait
