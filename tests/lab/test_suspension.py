# SPDX-License-Identifier: Apache-2.0
"""What a campaign waits for instead of failing: a catalog that another process has locked, a chamber whose link is dead, a
unit that stands in the wrong slot, a soakd that was killed. Nothing that was recorded is voided."""
import contextlib
import json
import re
import signal
import sqlite3
import struct
import subprocess
import sys
import time
import unittest
import urllib.request

import bench
from bench import LabTest, long_test, short_procedure
from lab_session import ProgramFailed, end
from modbus_proxy import WRITE_ONE, ModbusProxy, with_read_f32

BUSY_TIMEOUT_S = 10.0  # for which soakd's own connection waits at one try (docs/architecture.md)
HOLD_LOCK = """import sqlite3, sys
db = sqlite3.connect(sys.argv[1], isolation_level=None)
db.execute("BEGIN IMMEDIATE")
print("locked", flush=True)
sys.stdin.read()
"""
SET_POINT, CONTROL_MODE, AIR, HIGH_SET_POINT = 2782, 2730, 2820, 1334  # registers of the controller; of its first alarm
TURN_OVER = struct.pack(">BHH", WRITE_ONE, 0, 6)  # request of the fixture: to -Z
SETTLE_S = 60.0  # process time for which a chamber must have answered
OVER = ("finished", "failed", "aborted")
GOES_ON = 'on_restart = "resume"\n'


class Suspension(LabTest):
    @contextlib.contextmanager
    def locked_catalog(self):
        """Another process holds the write lock, as an import that was stopped with Ctrl-Z does."""
        holder = subprocess.Popen([sys.executable, "-c", HOLD_LOCK, f"{self.lab.data}/station.db"], stdin=subprocess.PIPE,
                                  stdout=subprocess.PIPE, text=True)
        self.addCleanup(holder.wait)
        self.addCleanup(holder.kill)
        self.assertEqual(holder.stdout.readline(), "locked\n")
        try:
            yield
        finally:
            holder.communicate("")

    @contextlib.contextmanager
    def write_catalog(self):
        """Writes behind the program's back. The seals stay as they are: what is added here is taken away again."""
        with contextlib.closing(sqlite3.connect(f"{self.lab.data}/station.db", timeout=30)) as catalog, catalog:
            catalog.create_function("soak_seal", -1, lambda seal, *values: seal)
            yield catalog

    def whole_runs_void(self):
        return self.query("SELECT run_id FROM void WHERE visit IS NULL")

    def labels(self):
        return [label for (label,) in self.query("SELECT DISTINCT label FROM run")]

    def attempts(self, kind):
        """How often each step of that kind came to its end."""
        with urllib.request.urlopen(self.lab.page + "api/v1/plan", timeout=30) as answer:
            steps = json.load(answer)["steps"]
        ended = [index for (index,) in self.query("SELECT step_index FROM step WHERE outcome = 'done'")]
        return [ended.count(index) for index, step in enumerate(steps) if step["kind"] == kind]

    @long_test
    def test_a_locked_catalog_delays_the_journal_and_nothing_else(self):
        self.start_lab(rate=200)
        begun = self.start_campaign(short_procedure(positions=("+Z", "-Z")))
        self.wait_for_step("wait_stable")
        with self.locked_catalog():
            locked_s = time.monotonic()
            status = self.wait("the journal", lambda s: s["state"] == "waiting", seconds=60)
            self.check_schema(status, "campaign-status")
            self.assertGreaterEqual(status["journal"]["queued"], 1)
            index = status["campaign"]["step"]
            while not (status := self.status())["journal"]["trouble"]:
                # It is watched meanwhile: the chamber is read, and nothing begins.
                self.assertEqual((status["state"], status["campaign"]["step"]), ("waiting", index))
                self.assertLess(status["chamber"]["age_s"], 2.0)
                self.assertLess(time.monotonic() - locked_s, 6 * BUSY_TIMEOUT_S)
                time.sleep(0.2)
            # A step that ends while the lock is held would have failed the campaign by then.
            self.assertGreater(time.monotonic() - locked_s, BUSY_TIMEOUT_S)
            self.assertEqual((status["state"], status["campaign"]["step"]), ("waiting", index))
            self.assertTrue(status["reason"])
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(status["journal"], {"queued": 0, "discarded": 0, "trouble": None})
        done = self.query("SELECT step_index, attempt FROM step ORDER BY ordinal")
        self.assertEqual(done, [(index, 0) for index in range(begun["steps"])])
        self.assertEqual(self.labels(), ["R01"])
        self.assertEqual(self.query("SELECT * FROM void"), [])
        self.assert_safe()

    def test_a_step_that_the_catalog_refuses_suspends_until_it_is_taken(self):
        self.start_lab(rate=200)
        self.start_campaign(short_procedure(set_points=(15,)))
        index = self.wait_for_step("wait_stable")["campaign"]["step"]
        with self.write_catalog() as catalog:
            catalog.execute("INSERT INTO step SELECT max(ordinal) + 1, campaign, ?, 0, 0, 0, 'failed', '', '' FROM step", (index,))
        status = self.wait("the suspension", lambda s: s["suspension"] or s["state"] in bench.ENDED)
        self.check_schema(status, "campaign-status")
        self.assertEqual((status["state"], status["campaign"]["step"]), ("waiting", index), status["reason"])
        self.assertEqual(status["suspension"]["causes"], ["catalog"])
        self.assertEqual(self.chamber()[0], bench.AUTO, "the chamber holds its set point")
        with self.write_catalog() as catalog:
            catalog.execute("DELETE FROM step WHERE step_index = ?", (index,))
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual([attempt for (attempt,) in self.query("SELECT attempt FROM step")].count(0), status["campaign"]["steps"])
        self.assertEqual(self.attempts("record"), [1, 1], "nothing was lost by waiting")
        self.assert_safe()

    @long_test
    def test_an_abort_reaches_the_chamber_at_once_though_the_catalog_is_locked(self):
        self.start_lab(rate=50)
        self.start_campaign(short_procedure(dwell_s=2000))
        self.wait_for_step("record")
        chamber = self.modbus("chamber")
        self.assertEqual(self.read_f32(chamber, SET_POINT), 15.0)
        with self.locked_catalog():
            asked_s = time.monotonic()
            self.lab.soak("campaign", "abort", "--reason", "test")
            while self.read_f32(chamber, SET_POINT) < 25.0:
                self.assertLess(time.monotonic() - asked_s, BUSY_TIMEOUT_S / 2)
            status = self.wait("the way to the safe state", lambda s: s["ending"])
            self.check_schema(status, "campaign-status")
            self.assertEqual(status["ending"]["outcome"], "aborted")
            # What waited for the lock would have come after the busy time-out at the earliest.
            self.assertLess(time.monotonic() - asked_s, BUSY_TIMEOUT_S / 2)
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.wait("the journal", lambda s: s["journal"]["queued"] == 0)
        self.assertEqual(self.query("SELECT state FROM journal"), [("aborted",)])
        self.assert_event("segment", "0380A001", "+Z")
        self.assert_safe()

    def test_a_chamber_that_is_silent_for_20_minutes_costs_one_visit(self):
        self.start_lab(rate=200, cut=["chamber"])
        self.start_campaign(short_procedure(dwell_s=200))
        self.wait("the second visit", lambda s: "visit 1," in s["campaign"]["step_text"] and s["campaign"]["step_kind"] == "record")
        first = self.query("SELECT run_id FROM step ORDER BY ordinal DESC LIMIT 1")
        self.proxies["chamber"].cut()
        status = self.wait("the suspension", lambda s: s["suspension"])
        self.check_schema(status, "campaign-status")
        self.assertEqual((status["state"], status["suspension"]["causes"]), ("waiting", ["chamber"]))
        with urllib.request.urlopen(self.lab.page + "metrics", timeout=30) as answer:
            self.assertIn('soak_suspended{cause="chamber"} 1\n', answer.read().decode())
        silent_s = status["clock"]["process_s"]
        status = self.wait("20 minutes", lambda s: s["clock"]["process_s"] > silent_s + 1200)
        self.assertEqual(status["state"], "waiting")
        self.assertEqual([unit["state"] for unit in status["units"]], ["streaming"])
        self.proxies["chamber"].mend()
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.labels(), ["R01"])
        self.assertEqual(self.whole_runs_void(), [])
        self.assertEqual({run for (run,) in self.query("SELECT DISTINCT run_id FROM step WHERE run_id <> ''")}, {first[0][0]})
        self.assertEqual(self.attempts("power_on"), [1], "the units kept their power")
        self.assertEqual(self.attempts("set_temperature"), [1, 2], "the second visit was begun again")
        places = self.query("SELECT DISTINCT visit, position FROM segment ORDER BY visit, position")
        self.assertEqual(places, [(0, "+Z"), (0, "-Z"), (1, "+Z"), (1, "-Z")])
        self.assert_safe()

    def suspend(self):
        """The chamber falls silent until the campaign waits for it; that status."""
        self.proxies["chamber"].cut()
        suspended = self.wait("the suspension", lambda s: s["suspension"])
        self.assertEqual(suspended["suspension"]["causes"], ["chamber"])
        return suspended

    @long_test
    def test_what_is_left_stands_still_while_a_question_is_suspended(self):
        def by_hand(text):
            begin, end_ = text.index("[fixture]"), text.index("[power]")
            return text[:begin] + text[end_:]

        self.start_lab(rate=200, cut=["chamber"], edit=by_hand)
        self.start_campaign(short_procedure(set_points=(15,), positions=("+Z",)))
        asked = self.wait("the question", lambda s: s["prompt"] and s["campaign"]["step_kind"] == "move" and s["campaign"]["run_label"] == "R01")
        suspended = self.suspend()
        self.assertEqual(suspended["campaign"]["step"], asked["campaign"]["step"])
        self.hold(suspended)
        self.lab.soak("campaign", "abort", "--reason", "test")
        self.proxies["chamber"].mend()
        self.assertEqual(self.wait_for_end()["state"], "aborted")

    @long_test
    def test_what_is_left_stands_still_while_the_warm_end_is_suspended(self):
        self.start_lab(rate=100, cut=["chamber"])
        self.start_campaign(short_procedure(set_points=(0,), positions=("+Z",)))
        self.wait_for_step("warm_end")
        suspended = self.suspend()
        self.assertEqual(suspended["campaign"]["step_kind"], "warm_end")
        self.hold(suspended)
        self.proxies["chamber"].mend()
        self.come_nearer(suspended)
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()

    @long_test
    def test_a_suspension_ends_safely_after_the_limit_of_the_procedure(self):
        self.start_lab(rate=400, cut=["chamber"])
        self.start_campaign(short_procedure(extra="[suspend]\ngive_up_h = 1.0\n"))
        self.wait_for_step("wait_stable")
        self.proxies["chamber"].cut()
        begun_s = self.wait("the suspension", lambda s: s["suspension"])["clock"]["process_s"]
        status = self.wait("giving up", lambda s: s["state"] == "stopping")
        self.assertGreater(status["clock"]["process_s"], begun_s + 3500)
        self.assertLess(status["clock"]["process_s"], begun_s + 5400)
        self.proxies["chamber"].mend()
        self.assertEqual(self.wait_for_end()["state"], "failed")
        self.assert_safe()

    def test_a_wrong_unit_is_a_question_that_names_what_is_there(self):
        self.start_lab(rate=200)
        procedure = self.write("procedure.toml", short_procedure())
        self.lab.soak("campaign", "start", procedure, "--name", "c", "--unit", "1=0380A009")
        status = self.wait("the question", lambda s: s["prompt"] or s["state"] in bench.ENDED)
        self.assertEqual(status["state"], "waiting", status["reason"])
        for word in ("0380A001", "0380A009", "--unit 1=0380A001"):
            self.assertIn(word, status["prompt"]["text"])
        self.check_schema(status, "campaign-status")
        self.assertEqual(self.chamber()[0], bench.OFF, "nothing has moved")
        asked = status["prompt"]["id"]
        self.lab.soak("campaign", "confirm")
        status = self.wait("the same question again", lambda s: s["prompt"] and s["prompt"]["id"] != asked)
        self.lab.soak("campaign", "abort", "--reason", "the other unit")
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.wait("the journal", lambda s: s["journal"]["queued"] == 0)  # who starts before that is told to try again
        self.lab.soak("campaign", "start", procedure, "--name", "d", "--unit", "1=0380A001")
        self.wait_for_step("record")
        self.assert_event("unit", "0380A001", "MTi")

    def test_a_killed_campaign_goes_on_by_itself_where_the_procedure_says_so(self):
        self.start_campaign_that_goes_on(rate=400)
        self.kill_soakd()
        self.lab.start_soakd()
        status = self.wait("the end", lambda s: s["state"] in OVER)
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.labels(), ["R01", "R01.2"])
        self.assertEqual(self.whole_runs_void(), [])
        self.assert_safe()

    def start_campaign_that_goes_on(self, rate, cut=(), set_points=(15, 30, 45)):
        """A campaign that a new soakd may resume, at its second visit."""
        self.start_lab(rate=rate, cut=cut)
        self.start_campaign(short_procedure(set_points=set_points).replace("[temperatures]", GOES_ON + "[temperatures]", 1))
        return self.wait("the second visit", lambda s: "visit 1," in s["campaign"]["step_text"])

    def kill_soakd(self):
        self.lab.soakd.kill()
        self.lab.soakd.wait()
        self.lab.soakd.stdout.close()

    def assert_waits_for_somebody(self, state):
        """The safe state is reached, and nothing begins in it."""
        status = self.wait("the safe state", lambda s: s["state"] in bench.ENDED)
        self.assertEqual(status["state"], state, status["reason"])
        self.assertFalse(status["resumes_by_itself"])
        begun_s = status["clock"]["process_s"]
        self.wait("ten minutes", lambda s: s["clock"]["process_s"] > begun_s + 600 or s["state"] != state)
        self.assertEqual(self.status()["state"], state)
        self.assert_safe()

    @long_test
    def test_an_abort_stays_one_though_soakd_is_killed_on_the_way_and_the_catalog_never_had_it(self):
        self.start_campaign_that_goes_on(rate=100)
        with self.locked_catalog():
            self.lab.soak("campaign", "abort", "--reason", "smoke")
            self.assertEqual(self.status()["state"], "stopping")
            self.kill_soakd()
        self.assertEqual(self.query("SELECT state FROM journal"), [("running",)])
        self.lab.start_soakd()
        self.assert_waits_for_somebody("aborted")
        self.assertIsNone(self.status()["resumable"])

    def test_a_paused_campaign_waits_for_somebody_though_soakd_was_restarted(self):
        self.start_campaign_that_goes_on(rate=400)
        self.lab.soak("campaign", "pause")
        end(self.lab.soakd)
        self.lab.start_soakd()
        self.assert_waits_for_somebody("interrupted")
        self.lab.soak("campaign", "resume")
        self.wait("the way back", lambda s: s["state"] == "running")
        self.kill_soakd()
        self.lab.start_soakd()
        self.assert_waits_for_somebody("interrupted")

    @long_test
    def test_a_resume_that_the_catalog_does_not_take_switches_nothing_on(self):
        """A soakd that is killed right after it began to move would leave a catalog that says interrupted: the next one would take the
        laboratory for safe, and leave the units on."""
        self.start_campaign_that_goes_on(rate=400)
        self.lab.soak("campaign", "pause")
        end(self.lab.soakd)
        self.lab.start_soakd()
        self.wait("the safe state", lambda s: s["state"] == "interrupted")
        with self.write_catalog() as catalog:
            catalog.execute("CREATE TRIGGER refuse BEFORE UPDATE ON journal WHEN NEW.state = 'running' "
                            "BEGIN SELECT RAISE(ABORT, 'refused by the test'); END")
        with self.assertRaises(ProgramFailed) as refused:
            self.lab.soak("campaign", "resume")
        self.assertIn("refused by the test", str(refused.exception))
        self.assert_waits_for_somebody("interrupted")
        with self.write_catalog() as catalog:
            catalog.execute("DROP TRIGGER refuse")
        self.lab.soak("campaign", "resume")
        self.assertEqual(self.wait_for_end()["state"], "finished")

    @long_test
    def test_a_campaign_that_comes_no_further_is_resumed_once(self):
        self.start_campaign_that_goes_on(rate=200)
        self.kill_soakd()
        self.lab.start_soakd()
        # The way back repeats steps that had ended before.
        self.wait("a visit", lambda s: s["state"] == "running" and s["campaign"]["step_kind"] == "wait_stable")
        self.kill_soakd()
        self.lab.start_soakd()
        self.assert_waits_for_somebody("interrupted")

    @long_test
    def test_what_would_resume_by_itself_can_be_aborted_before(self):
        self.start_campaign_that_goes_on(rate=20, set_points=(40, 45, 50))
        self.kill_soakd()
        self.lab.start_soakd()
        status = self.wait("the way to the safe state", lambda s: s["state"] == "stopping")
        self.check_schema(status, "campaign-status")
        self.assertTrue(status["resumes_by_itself"])
        self.assertIn("soak campaign abort", self.lab.soak("campaign", "status"))
        self.lab.soak("campaign", "abort", "--reason", "somebody is there")
        status = self.status()
        self.assertEqual((status["ending"]["outcome"], status["resumes_by_itself"]), ("aborted", False))
        self.assert_waits_for_somebody("aborted")

    @long_test
    def test_nothing_goes_on_after_an_alarm_on_the_way_to_the_safe_state(self):
        self.start_campaign_that_goes_on(rate=20, set_points=(40, 45, 50))
        self.kill_soakd()
        self.lab.start_soakd()
        self.wait("the way to the safe state", lambda s: s["state"] == "stopping" and s["resumes_by_itself"])
        chamber = self.modbus("chamber")
        chamber.write_registers(HIGH_SET_POINT, self.words_f32(20.0), 1)
        self.wait("the end", lambda s: s["state"] in bench.ENDED)
        chamber.write_registers(HIGH_SET_POINT, self.words_f32(400.0), 1)
        self.assert_waits_for_somebody("failed")

    def test_nothing_goes_on_in_a_chamber_that_somebody_uses_meanwhile(self):
        self.start_campaign_that_goes_on(rate=400)
        end(self.lab.soakd)
        self.modbus("chamber").write_registers(CONTROL_MODE, [bench.AUTO], 1)
        self.lab.start_soakd()
        self.wait("the refusal", lambda s: not s["resumes_by_itself"])
        status = self.status()
        self.assertEqual((status["state"], status["resumable"]), ("interrupted", "c"))
        self.assertEqual(self.chamber()[0], bench.AUTO, "it is theirs")

    @long_test
    def test_nothing_goes_on_after_a_break_of_more_than_twelve_hours(self):
        self.start_campaign_that_goes_on(rate=400)
        end(self.lab.soakd)
        path = next(self.folder.rglob("soakd.campaign"))
        note = json.loads(path.read_text())
        self.assertTrue(note["goes_on"])
        path.write_text(json.dumps(dict(note, noted_utc_s=note["noted_utc_s"] - 13 * 3600)))
        self.lab.start_soakd()
        self.wait("the refusal", lambda s: not s["resumes_by_itself"])
        self.assert_waits_for_somebody("interrupted")

    @long_test
    def test_what_an_aborted_campaign_recorded_is_void_though_soakd_was_killed(self):
        self.start_campaign_that_goes_on(rate=100)
        self.lab.soak("campaign", "abort", "--reason", "smoke")
        self.kill_soakd()
        self.lab.start_soakd()
        self.assert_waits_for_somebody("aborted")
        self.assertEqual(len(self.whole_runs_void()), 1)

    @long_test
    def test_a_suspended_campaign_goes_on_with_a_new_soakd(self):
        for how in ("killed", "stopped"):
            with self.subTest(how):
                self.folder = self.folder / how
                self.folder.mkdir()
                self.start_campaign_that_goes_on(rate=400, cut=["chamber"])
                self.proxies["chamber"].cut()
                self.wait("the suspension", lambda s: s["suspension"])
                if how == "stopped":
                    self.lab.soakd.send_signal(signal.SIGTERM)
                    self.wait("the way to the safe state", lambda s: s["state"] == "stopping")
                self.kill_soakd()
                self.proxies["chamber"].mend()
                self.lab.start_soakd()
                status = self.wait("the end", lambda s: s["state"] in OVER)
                self.assertEqual(status["state"], "finished", status["reason"])
                self.assert_safe()
                self.stop_lab()

    @long_test
    def test_a_chamber_that_comes_back_switched_off_is_left_alone_for_the_settling_time(self):
        self.start_lab(rate=20, cut=["chamber"])
        self.start_campaign(short_procedure(set_points=(35,)))
        self.wait_for_step("wait_stable")
        self.cut_and_switch_off_the_chamber()
        self.proxies["chamber"].mend()
        answers_s = self.wait("an answer", lambda s: s["chamber"]["connected"])["clock"]["process_s"]
        status = self.wait("heating", lambda s: s["chamber"]["running"] or s["state"] in bench.ENDED)
        self.assertTrue(status["chamber"]["running"], status["reason"])
        self.assertGreater(status["clock"]["process_s"], answers_s + 0.8 * SETTLE_S)
        self.assertEqual(self.wait_for_end()["state"], "finished")

    @long_test
    def test_of_a_paused_campaign_it_is_left_alone_until_somebody_resumes(self):
        self.start_lab(rate=50, cut=["chamber"])
        self.start_campaign(short_procedure(set_points=(35,)))
        self.wait_for_step("wait_stable")
        self.lab.soak("campaign", "pause")
        self.cut_and_switch_off_the_chamber()
        time.sleep(75)  # host time: a link is dead after some seconds, the chamber missing a minute later
        self.proxies["chamber"].mend()
        answers_s = self.wait("an answer", lambda s: s["chamber"]["connected"])["clock"]["process_s"]
        self.wait("ten minutes", lambda s: s["clock"]["process_s"] > answers_s + 600)
        self.assertEqual(self.status()["state"], "paused")
        self.assertEqual(self.chamber()[0], bench.OFF)
        self.lab.soak("campaign", "resume")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])

    def cut_and_switch_off_the_chamber(self):
        """As a power dip does."""
        self.proxies["chamber"].cut()
        if self.status()["state"] != "paused":
            self.wait("the suspension", lambda s: s["suspension"])
        self.modbus("chamber").write_registers(CONTROL_MODE, [bench.OFF], 1)

    def start_with_air(self, procedure):
        """A chamber whose thermometer reads `self.off_k` too much: within what one reading may leap."""
        self.off_k = 0.0

        def edit(text):
            port = self.lab.ports["chamber"]
            proxy = ModbusProxy(port)
            self.addCleanup(proxy.close)
            proxy.change_answer = with_read_f32(AIR, lambda air_c: air_c + self.off_k)
            return re.sub(rf"^port = {port}$", f"port = {proxy.port}", text, flags=re.M)
        self.start_lab(rate=200, edit=edit)
        self.start_campaign(procedure)

    def test_air_that_leaves_the_plateau_suspends_a_recording_until_it_is_back(self):
        self.start_with_air(short_procedure(set_points=(30,), dwell_s=2000))
        self.wait_for_step("record")
        self.off_k = 4.0
        status = self.wait("the suspension", lambda s: s["suspension"] or s["state"] in bench.ENDED)
        self.assertEqual((status["state"], status["suspension"]["causes"]), ("waiting", ["air"]))
        begun_s = status["clock"]["process_s"]
        self.wait("ten minutes", lambda s: s["clock"]["process_s"] > begun_s + 600)
        self.assertEqual(self.status()["suspension"]["causes"], ["air"])
        self.off_k = 0.0
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.attempts("record"), [1, 1])

    @long_test
    def test_units_that_do_not_settle_have_the_time_out_of_the_procedure(self):
        procedure = short_procedure(set_points=(30,)).replace("timeout_s = 200000", 'timeout_s = 3000\non_timeout = "skip_plateau"')
        self.start_with_air(procedure)
        self.wait_for_step("wait_stable")
        self.off_k = 4.0
        seen = []
        status = self.wait("the end", lambda s: seen.append(s["suspension"]) or s["state"] in bench.ENDED)
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual([suspension for suspension in seen if suspension], [])
        self.assertIn("skipped", [outcome for (outcome,) in self.query("SELECT outcome FROM step")])

    @long_test
    def test_a_question_is_asked_again_after_a_suspension(self):
        self.start_lab(rate=200, cut=["chamber"])
        self.lab.soak("campaign", "start", self.write("procedure.toml", short_procedure()), "--name", "c", "--unit", "1=0380A009")
        asked = self.wait("the question", lambda s: s["prompt"])["prompt"]["id"]
        self.proxies["chamber"].cut()
        status = self.wait("the suspension", lambda s: s["suspension"])
        self.assertIsNone(status["prompt"], "an answer would be lost")
        self.proxies["chamber"].mend()
        status = self.wait("the question again", lambda s: s["prompt"] or s["state"] in bench.ENDED)
        self.assertNotEqual(status["prompt"]["id"], asked)
        self.lab.soak("campaign", "abort", "--reason", "test")
        self.assertEqual(self.wait_for_end()["state"], "aborted")

    @long_test
    def test_a_visit_that_begins_again_is_used_once(self):
        def edit(text):
            text, fixture = self.with_proxy(text, "fixture")
            fixture.answer = at_fixture
            return text

        turned = []

        def at_fixture(request):
            if request == TURN_OVER and not turned:
                turned.append(request)
                self.proxies["chamber"].cut()  # here: whoever looks from outside may be late

        self.start_lab(rate=200, cut=["chamber"], edit=edit)
        self.start_campaign(short_procedure(set_points=(30,), positions=("+Z", "-Z"), dwell_s=200))
        self.wait("the suspension", lambda s: s["suspension"])
        self.lab.soak("campaign", "pause")
        self.proxies["chamber"].mend()
        self.wait("the chamber", lambda s: s["chamber"]["connected"])
        self.assertEqual(self.status()["state"], "paused")
        self.lab.soak("campaign", "resume")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.attempts("record"), [2, 1])
        usable = self.query("""SELECT s.position, s.attempt FROM segment s WHERE NOT EXISTS (SELECT 1 FROM void v
            WHERE v.run_id = s.run_id AND v.unit = s.unit AND coalesce(v.visit, s.visit) = s.visit
            AND coalesce(v.position, s.position) = s.position AND coalesce(v.attempt, s.attempt) = s.attempt)""")
        self.assertEqual(sorted(position for position, _ in usable), ["+Z", "-Z"])
        self.assertEqual(dict(usable)["+Z"], 1, "the one that was recorded after the suspension")


if __name__ == "__main__":
    # They mostly wait for a link that must be dead for a minute.
    bench.main(first=("test_a_suspended_campaign_goes_on_with_a_new_soakd",), at_once=8)
