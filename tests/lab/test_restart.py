# SPDX-License-Identifier: Apache-2.0
"""soakd is killed in mid-campaign: the next one makes the chamber safe, keeps what was complete, and goes on one plateau
before the break. `./run prove kills` does so at many more moments."""
import contextlib
import os
import pathlib
import random
import re
import sqlite3
import struct
import threading
import time
import unittest

import bench
from bench import ENDED, LabTest, long_test, short_procedure
from lab_session import ProgramFailed, end
from modbus_proxy import WRITE_ONE, reads

SET_POINTS_C = (15, 30, 45, 30)
POSITIONS = ("+Z", "-Z")
MOMENTS = int(os.environ.get("SOAK_KILLS", "2"))
SEED = int(os.environ.get("SOAK_KILLS_SEED", "1"))
FIRST_RELAY, FIRST_CONTACT = 0, 16  # registers
SWITCH_ON = struct.pack(">BHH", WRITE_ONE, FIRST_RELAY, 1)


class Restart(LabTest):
    def kill_and_start_again(self):
        self.lab.soakd.kill()
        self.lab.soakd.wait()
        self.lab.soakd.stdout.close()
        self.lab.start_soakd()

    def usable_segments(self, label):
        """(visit, position) of each segment of a run that nothing has withdrawn, in the order of time."""
        return self.query("""SELECT s.visit, s.position, s.plateau_c, s.sweep FROM segment s JOIN run r USING (run_id, unit)
            WHERE r.label = ? AND NOT EXISTS (SELECT 1 FROM void v WHERE v.run_id = s.run_id AND v.unit = s.unit
            AND coalesce(v.visit, s.visit) = s.visit AND coalesce(v.position, s.position) = s.position
            AND coalesce(v.attempt, s.attempt) = s.attempt) ORDER BY s.t_start_s""", label)

    def expect_parts_to_make_up_the_run(self, parts):
        """Every position of every visit stands in one part at least, with the same plateau and sweep in each; each part names
        the kept one before it; a part begins no earlier than one visit before the break."""
        runs = {run["run"]: run for run in self.lab.soak_json("runs", "list")["runs"]}
        before = None
        for label in parts:
            self.assertEqual(runs[label]["continues"], before, label)
            if label == parts[-1]:
                # Killed after its last position, a run has all that it was to have.
                whole = self.usable_segments(label)[-1][:2] == (len(SET_POINTS_C) - 1, POSITIONS[-1])
                self.assertFalse(runs[label]["voided"] or (runs[label]["cut_short"] and not whole), label)
            else:
                self.assertTrue(runs[label]["cut_short"] or runs[label]["voided"], label)
            before = runs[label]["run_id"] if runs[label]["cut_short"] else before
        measured = {}
        last_visit = None
        for label in parts:
            segments = self.usable_segments(label)
            for visit, position, plateau_c, sweep in segments:
                self.assertEqual(measured.setdefault((visit, position), (plateau_c, sweep)), (plateau_c, sweep))
            if segments and last_visit is not None:
                self.assertGreaterEqual(segments[0][0], last_visit - 1, f"{label} begins too far back")
            if segments:
                last_visit = segments[-1][0]
        self.assertEqual({place for place in measured},
                         {(v, p) for v in range(len(SET_POINTS_C)) for p in POSITIONS})
        for (visit, _), (plateau_c, _) in measured.items():
            self.assertEqual(plateau_c, SET_POINTS_C[visit])

    def wait_for_visit(self, number):
        self.wait(f"visit {number}", lambda s: f"visit {number}," in s["campaign"]["step_text"])

    def test_a_killed_campaign_is_made_safe_and_goes_on_one_plateau_before_the_break(self):
        self.start_lab(units=2, rate=200)
        procedure = short_procedure(set_points=SET_POINTS_C, positions=POSITIONS)
        begun = self.start_campaign(procedure)
        self.wait_for_visit(2)
        self.kill_and_start_again()
        self.wait_for_end()
        self.assert_safe()
        cut = [run for run in self.lab.soak_json("runs", "list")["runs"] if run["run"] == "R01"]
        self.assertEqual([run["unit"] for run in cut], ["0380A001", "0380A002"])
        for run in cut:
            self.assertFalse(run["voided"])
            self.assertTrue(run["cut_short"])
            self.assertTrue(run["sealed"])
        self.assertEqual([s[:2] for s in self.usable_segments("R01")[::2]], [(0, "+Z"), (0, "-Z"), (1, "+Z"), (1, "-Z")])
        self.lab.soak("runs", "verify")

        # Still so after one more restart.
        end(self.lab.soakd)
        self.lab.start_soakd()
        self.assertEqual(self.status()["state"], "interrupted")
        self.assertEqual(self.status()["resumable"], "c")
        self.soak_fails(2, "campaign", "start", self.write("procedure.toml", procedure), "--name", "c")
        self.lab.soak("campaign", "resume")
        self.assertIn("R01 goes on with the visit at +30 °C", self.status()["reason"])
        self.wait_for_visit(1)
        self.assertIn("R01 goes on with the visit at +30 °C", self.status()["reason"])
        self.wait_for_visit(2)
        self.assertRegex(self.status()["reason"], "^resumed by [^;]*$", "the visit that it went on with is over")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assert_safe()
        self.assertEqual([s[:2] for s in self.usable_segments("R01.2")[::2]],
                         [(v, p) for v in (1, 2, 3) for p in POSITIONS])
        self.expect_parts_to_make_up_the_run(["R01", "R01.2"])
        runs = {run["run"]: run for run in self.lab.soak_json("runs", "list")["runs"]}
        self.assertEqual(runs["R01.2"]["continues"], runs["R01"]["run_id"])
        self.assertIsNone(runs["R01.2"]["cut_short"])
        done = {index for index, in self.query("SELECT step_index FROM step WHERE outcome = 'done'")}
        self.assertEqual(done, set(range(begun["steps"])))
        self.lab.soak("runs", "verify")

    def test_a_campaign_that_is_killed_at_any_moment_goes_on(self):
        moments = random.Random(SEED)
        folder = self.folder
        for number in range(MOMENTS):
            with self.subTest(number=number):
                self.folder = folder / str(number)
                self.folder.mkdir()
                self.start_lab(units=1, rate=400, seed=number + 1)
                begun = self.start_campaign(short_procedure(set_points=SET_POINTS_C, positions=POSITIONS))
                step = moments.randrange(begun["steps"])
                self.wait(f"step {step}", lambda s: s["state"] == "finished" or s["campaign"]["step"] >= step)
                time.sleep(moments.uniform(0.0, 0.2))
                self.kill_and_start_again()
                # Killed after its end, the campaign is nothing that the next soakd knows of.
                status = self.wait("the end", lambda s: s["state"] in (*ENDED, "idle"), lab_s=60.0)
                self.assert_safe()
                if status["state"] == "interrupted":
                    self.lab.soak("campaign", "resume")
                    status = self.wait_for_end()
                self.assertIn(status["state"], ("finished", "idle"), status["reason"])
                self.assertEqual(self.query("SELECT state FROM journal"), [("finished",)])
                self.assert_safe()
                labels = [label for (label,) in self.query("SELECT DISTINCT label FROM run ORDER BY created_utc_s")]
                self.expect_parts_to_make_up_the_run(labels)
                self.lab.soak("runs", "verify")
                self.stop_lab()

    @long_test
    def test_a_campaign_that_is_killed_after_its_last_step_is_brought_to_its_end(self):
        self.start_lab(rate=400)
        self.start_campaign(short_procedure(set_points=SET_POINTS_C[:1], positions=POSITIONS))
        self.assertEqual(self.wait_for_end()["state"], "finished")
        end(self.lab.soakd)
        # As it stands where soakd is killed before it has written down that the campaign is finished.
        with contextlib.closing(sqlite3.connect(pathlib.Path(self.lab.data) / "station.db")) as catalog, catalog:
            catalog.create_function("soak_seal", -1, lambda seal, *_: seal)  # which leaves this row's seal a false one
            catalog.execute("UPDATE journal SET state = 'running'")
        self.lab.start_soakd()
        self.assertEqual(self.wait_for_end()["state"], "interrupted")
        self.assert_safe()
        self.lab.soak("campaign", "resume")
        self.assertEqual(self.wait_for_end()["state"], "finished")
        self.assert_safe()
        self.assertEqual(self.query("SELECT label FROM run"), [("R01",)])

    @long_test
    def test_a_command_of_a_killed_soakd_that_comes_after_the_safe_end_is_undone(self):
        """It was on its way to the relays when soakd was killed, and gets there once the next one has found the unit off."""
        on_its_way, may_come, is_there = (threading.Event() for _ in range(3))
        requests = []  # of the next soakd

        def at_relay(request):
            if not on_its_way.is_set():
                if request == SWITCH_ON:
                    on_its_way.set()
                    may_come.wait(bench.WAIT_S)
                return
            if reads(request, FIRST_RELAY) or requests:
                requests.append(request)
            if sum(reads(asked, FIRST_CONTACT) for asked in requests) == 2:  # once after the command, then to look again
                may_come.set()
                is_there.wait(bench.WAIT_S)

        def from_relay(request, answer):
            if request == SWITCH_ON:
                is_there.set()
            return answer

        def edit(text):
            text, proxy = self.with_proxy(text, "relay")
            proxy.answer, proxy.change_answer = at_relay, from_relay
            return text

        self.start_lab(rate=200, edit=edit)
        self.start_campaign(short_procedure())
        self.assertTrue(on_its_way.wait(bench.WAIT_S))
        self.kill_and_start_again()
        self.assertEqual(self.wait_for_end()["state"], "interrupted")
        self.assertTrue(is_there.is_set())
        self.assert_event("power", "power", 1)
        self.assert_safe()

    @long_test
    def test_a_run_is_repeated_where_the_procedure_says_so(self):
        self.start_lab(rate=400)
        text = short_procedure(set_points=SET_POINTS_C, positions=POSITIONS).replace("[temperatures]", 'on_break = "repeat_run"\n[temperatures]', 1)
        self.start_campaign(text)
        self.wait_for_visit(2)
        self.kill_and_start_again()
        self.assertEqual(self.wait_for_end()["state"], "interrupted")
        self.lab.soak("campaign", "resume")
        status = self.wait_for_end()
        self.assertEqual(status["state"], "finished", status["reason"])
        self.assertEqual(self.query("SELECT DISTINCT label FROM run JOIN void USING (run_id) WHERE visit IS NULL"), [("R01",)])
        self.assertEqual([s[:2] for s in self.usable_segments("R01.2")],
                         [(v, p) for v in range(4) for p in POSITIONS])

    @long_test
    def test_an_aborted_run_is_void(self):
        self.start_lab(rate=400)
        self.start_campaign(short_procedure(set_points=SET_POINTS_C, positions=POSITIONS))
        self.wait_for_visit(1)
        self.lab.soak("campaign", "abort", "--reason", "wrong unit")
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.assertEqual(self.query("SELECT DISTINCT label FROM run JOIN void USING (run_id) WHERE visit IS NULL"), [("R01",)])

    def test_an_aborted_campaign_stays_one_for_the_next_soakd(self):
        """It may have left units cold: to the page an idle station is one that may be opened by its air alone."""
        self.start_lab(rate=400)
        self.start_campaign(short_procedure(set_points=SET_POINTS_C, positions=POSITIONS))
        self.wait_for_visit(0)
        self.lab.soak("campaign", "abort", "--reason", "wrong unit", "--user", "Eva")
        ended = self.wait_for_end()
        self.assertEqual(ended["state"], "aborted")
        end(self.lab.soakd)
        self.lab.start_soakd()
        status = self.status()
        self.check_schema(status, "campaign-status")
        self.assertEqual((status["state"], status["reason"], status["resumable"]), ("aborted", ended["reason"], None))
        self.soak_fails(2, "campaign", "resume")
        self.start_campaign(short_procedure(set_points=SET_POINTS_C, positions=POSITIONS), name="next")
        self.assertEqual(self.status()["state"], "running")

    @long_test
    def test_the_reason_is_that_of_whoever_resumed_last(self):
        self.start_lab(rate=200)
        self.start_campaign(short_procedure(set_points=SET_POINTS_C, positions=POSITIONS))
        self.wait_for_visit(2)
        end(self.lab.soakd)
        self.lab.start_soakd()
        self.wait_for_end()
        self.lab.soak("campaign", "resume", "--user", "Eva")
        first = self.wait("a visit", lambda s: "visit " in s["campaign"]["step_text"] and not s["campaign"]["on_way_back"])
        visit = int(re.search(r"visit (\d+),", first["campaign"]["step_text"])[1])
        self.lab.soak("campaign", "pause", "--user", "Bob")
        self.lab.soak("campaign", "resume", "--user", "Bob")
        self.assertEqual(self.status()["reason"], "resumed by Bob")
        self.wait_for_visit(visit + 1)
        self.assertEqual(self.status()["reason"], "resumed by Bob")

    def test_a_second_soakd_is_refused_the_data_folder(self):
        self.start_lab()
        first = self.lab.soakd
        with self.assertRaises(ProgramFailed) as refused:
            self.lab.start_soakd()
        self.lab.soakd.stdout.close()
        self.lab.soakd = first
        self.assertIn("status 2", str(refused.exception))
        self.assertIn(str(first.pid), str(refused.exception))
        self.assertEqual(self.status()["state"], "idle")


if __name__ == "__main__":
    bench.main()
