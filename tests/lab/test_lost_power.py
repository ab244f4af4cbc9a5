# SPDX-License-Identifier: Apache-2.0
"""Power is lost in mid-campaign: what soakd had asked of the disk is recorded, and what a disk may hold at any moment is made of it
(tests/faults/power_cut.py). What was told to anybody is there, every file is whole, and the next soakd makes the chamber safe and
keeps what was complete. `./run prove lost-power` does so at many more moments."""
import contextlib
import json
import os
import pathlib
import random
import shutil
import sqlite3
import sys
import unittest.mock

import bench
from bench import LabTest, short_procedure
from lab_session import end

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "faults"))
import power_cut  # noqa: E402

MOMENTS = int(os.environ.get("SOAK_POWER_CUTS", "5"))
SEED = int(os.environ.get("SOAK_POWER_CUTS_SEED", "1"))
USABLE = """SELECT s.run_id, count(*) FROM segment s WHERE NOT EXISTS (SELECT 1 FROM void v WHERE v.run_id = s.run_id AND v.unit = s.unit
    AND coalesce(v.visit, s.visit) = s.visit AND coalesce(v.position, s.position) = s.position
    AND coalesce(v.attempt, s.attempt) = s.attempt) GROUP BY s.run_id"""


def told(data):
    """What a catalog says of runs and of steps that ended; nothing where there is none yet."""
    try:
        with contextlib.closing(sqlite3.connect(f"file:{data}/station.db?mode=ro", uri=True, timeout=30)) as db:
            return {"runs": set(db.execute("SELECT run_id, unit, label, file_sha256 FROM run WHERE sealed = 1")),
                    "steps": set(db.execute("SELECT step_index, attempt, outcome, run_id FROM step"))}
    except sqlite3.OperationalError:
        return {"runs": set(), "steps": set()}


class LostPower(LabTest):
    def setUp(self):
        super().setUp()
        self.clients = {}

    def modbus(self, device):
        """One connection for all moments: the simulated controller takes only so many."""
        if device not in self.clients:
            self.clients[device] = super().modbus(device)
        return self.clients[device]

    def record_campaign(self):
        """Begins and ends a campaign; notes after how many bytes of the record what was told."""
        self.record = self.folder / "disk.record"
        data = self.folder / "lab" / "data"
        layer = {"LD_PRELOAD": os.environ["SOAK_DISK_LAYER"], "SOAK_DISK_FOLDER": str(data), "SOAK_DISK_RECORD": str(self.record)}
        with unittest.mock.patch.dict(os.environ, layer):
            self.start_lab(rate=400)
        self.start_campaign(short_procedure(set_points=(15, 30), runs=2))
        plan = json.loads(self.get("plan"))
        self.recorded_steps = {index for index, step in enumerate(plan["steps"]) if step["kind"] == "record"}
        notes = []

        def take_note(status):
            known = told(data)
            notes.append((os.path.getsize(self.record), known))
            return status["state"] == "finished"
        self.wait("the end", take_note)
        end(self.lab.soakd)
        self.assertEqual(len({run for run, *_ in notes[-1][1]["runs"]}), 2)
        return notes

    def get(self, path):
        with bench.urllib.request.urlopen(self.lab.page + "api/v1/" + path, timeout=30) as answer:
            return answer.read()

    def test_what_was_told_is_on_the_disk_wherever_power_is_lost(self):
        notes = self.record_campaign()
        changes = list(power_cut.entries(self.record))
        self.assertGreater(len(changes), 200)
        moments = random.Random(SEED)
        cuts = sorted(moments.randrange(len(changes)) + 1 for _ in range(MOMENTS))
        disk = power_cut.Disk(self.lab.data)
        done = 0
        for cut in cuts:
            for change in changes[done:cut]:
                disk.apply(*change[:5])
            done = cut
            known = [note for size, note in notes if size <= changes[cut - 1][5]]
            with self.subTest(change=cut, of=len(changes)):
                self.lab.data = str(self.folder / "left" / "data")
                disk.after_loss_of_power(moments, self.lab.data)
                try:
                    self.judge(known[-1] if known else told(self.folder / "nothing"))
                finally:
                    end(self.lab.soakd)  # also where it was judged wrong
            shutil.rmtree(self.folder / "left")

    def judge(self, known):
        self.assertTrue(known["runs"] <= told(self.lab.data)["runs"])
        if known["steps"]:
            self.lab.soak("runs", "verify")
        self.lab.start_soakd()
        status = self.wait("the safe state", lambda s: s["state"] in (*bench.ENDED, "idle"))
        if known["steps"]:
            self.assertIn(status["state"], ("interrupted", "finished", "idle"), status["reason"])
        if status["state"] != "idle":
            self.assert_safe()
        end(self.lab.soakd)
        self.lab.soak("runs", "verify")
        self.lab.soak("events", "verify")
        after = told(self.lab.data)
        self.assertTrue(known["runs"] <= after["runs"])
        self.assertTrue(known["steps"] <= after["steps"])
        self.assertEqual(self.query("PRAGMA integrity_check"), [("ok",)])
        usable = dict(self.query(USABLE))
        for run in {run for *_, run in known["steps"] if run}:
            complete = [step for step, _, outcome, of in known["steps"] if of == run and outcome == "done" and step in self.recorded_steps]
            self.assertGreaterEqual(usable.get(run, 0), len(complete), f"segments of {run}")


if __name__ == "__main__":
    bench.main()
