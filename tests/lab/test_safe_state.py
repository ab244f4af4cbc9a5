# SPDX-License-Identifier: Apache-2.0
"""Whatever dies at whatever step: the chamber's own registers say that it is warm and off, and the event log says why.
Here each fault has a kind of step, two where long tests are wanted; `./run prove safe-states` takes all of them."""
import os
import signal
import time
import unittest

import bench
from bench import OFF, LabTest, long_test, short_procedure

STEPS = ("power_on", "move", "set_temperature", "wait_stable", "record", "check", "warm_end", "power_off")
ALL = os.environ.get("SOAK_ALL_STEPS") == "1"


def at_steps(first, *others):
    """Makes one test for each kind of step out of a function of it; those of `others` are long."""
    def decorate(function):
        function.steps = {kind: not ALL and kind != first for kind in (STEPS if ALL else (first, *others))}
        return function
    return decorate


def spread_over_steps(cls):
    for name, function in list(vars(cls).items()):
        for kind, is_long in getattr(function, "steps", {}).items():
            def test(self, f=function, k=kind):
                return f(self, k)
            setattr(cls, f"test_{name}_at_{kind}", long_test(test) if is_long else test)
    return cls


@spread_over_steps
class SafeState(LabTest):
    def campaign_at(self, kind, cut=(), units=1):
        """A lab whose campaign has come to a step of that kind."""
        self.start_lab(units=units, cut=cut)
        # The check takes no time: the fault comes while the last recording before it is made.
        preflight_s = 30 if kind == "check" else 0
        self.start_campaign(short_procedure(preflight_s=preflight_s, extra="[suspend]\ngive_up_h = 1.0\n"))
        if kind == "check":
            self.wait("the end of the pre-flight", lambda s: s["campaign"]["step_kind"] == "record" and "-Z" in s["campaign"]["step_text"])
        else:
            self.wait_for_step(kind)

    def expect_safe_end(self, *data):
        """The campaign ends safely: finished, where the rest did not need what had died; else with `data` in the reason."""
        status = self.wait_for_end()
        self.assert_safe()
        if status["state"] == "finished":
            return status
        self.assertEqual(status["state"], "failed", status["reason"])
        for part in data:
            self.assertIn(part, status["reason"])
        self.assert_event("campaign", "c", status["reason"])
        # The pre-flight may have come to its end before.
        # What is complete is kept and marked; a run without any of it is void.
        runs = self.query("""SELECT label, cut_short <> '', EXISTS (SELECT 1 FROM void v WHERE v.run_id = r.run_id
            AND v.unit = r.unit AND v.visit IS NULL) FROM run r WHERE label <> 'P00'""")
        for label, cut_short, void in runs:
            self.assertNotEqual(cut_short, void, f"{label}: cut short {cut_short}, void {void}")
        return status

    @at_steps("move", "set_temperature")
    def fixture_dies(self, kind):
        self.campaign_at(kind, ["fixture"])
        self.proxies["fixture"].cut()
        status = self.expect_safe_end(f"127.0.0.1:{self.proxies['fixture'].port}")
        # After the last turn nobody needs the fixture.
        if kind in ("power_on", "move", "set_temperature"):
            self.assertEqual(status["state"], "failed")

    @at_steps("record", "wait_stable")
    def only_unit_dies(self, kind):
        self.campaign_at(kind, ["unit1"])
        self.proxies["unit1"].cut()
        status = self.expect_safe_end()
        if kind in ("power_on", "set_temperature", "wait_stable"):
            self.assertEqual(status["state"], "failed")

    @long_test
    def test_one_unit_of_two_falls_silent_and_the_other_is_calibrated(self):
        self.start_lab(units=2, cut=["unit2"])
        self.start_campaign(short_procedure(runs=2))
        self.wait_for_step("wait_stable")
        self.proxies["unit2"].silence()
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()
        self.assert_event("unit", "0380A002")
        rows = dict(self.query("SELECT unit, count(*) FROM segment GROUP BY unit"))
        self.assertEqual(rows["0380A001"], 8)
        self.assertLess(rows.get("0380A002", 0), 8)
        # What it gave until then is kept, and no fit takes it; the next run does without the unit.
        self.assertEqual(self.query("SELECT DISTINCT unit FROM void"), [("0380A002",)])
        self.assertIn("0380A002 in R01, 0380A002 in R02", self.status()["reason"])

    @at_steps("set_temperature", "record")
    def chamber_link_dies_and_comes_back(self, kind):
        self.campaign_at(kind, ["chamber"])
        self.proxies["chamber"].cut()
        self.wait("holding", lambda s: s["state"] in ("waiting", "finished") and not s["chamber"]["connected"])
        self.proxies["chamber"].mend()
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()
        if kind != "power_off":
            self.assert_event("device", "chamber")

    @at_steps("wait_stable")
    def chamber_link_stays_dead(self, kind):
        self.campaign_at(kind, ["chamber"])
        self.proxies["chamber"].silence()
        status = self.wait("giving up", lambda s: s["state"] in ("stopping", "finished"))
        if status["state"] == "stopping":
            self.assertFalse(status["chamber"]["connected"])
            # It cannot be made safe while it does not answer: the station keeps trying.
            time.sleep(2)
            self.assertEqual(self.status()["state"], "stopping")
        self.proxies["chamber"].mend()
        self.expect_safe_end()

    @at_steps("set_temperature", "power_on")
    def sigterm(self, kind):
        self.campaign_at(kind)
        self.lab.soakd.send_signal(signal.SIGTERM)
        self.assertEqual(self.lab.soakd.wait(180), 0)
        self.assert_safe()
        self.assert_event("campaign", "c", "interrupted")
        self.assertEqual(self.query("SELECT state FROM journal"), [("interrupted",)])

    def test_an_over_temperature_alarm_switches_the_outputs_off_at_once(self):
        self.campaign_at("wait_stable")
        client = self.modbus("chamber")
        client.write_registers(1334, self.words_f32(self.read_f32(client, 2820) - 10.0), 1)
        status = self.wait_for_end()
        self.assertEqual(status["state"], "failed")
        self.assertIn("alarm 1", status["reason"])
        mode, output, set_point_c, air_c = self.chamber()
        self.assertEqual((mode, output), (OFF, 0.0))
        # It was not driven anywhere any more.
        self.assertEqual(set_point_c, 15.0)
        self.assertLess(air_c, 22.0)
        self.assert_event("campaign", "c", "alarm 1")


if __name__ == "__main__":
    bench.main(first=("test_one_unit_of_two_falls_silent_and_the_other_is_calibrated", "test_chamber_link_stays_dead_at_wait_stable"))
