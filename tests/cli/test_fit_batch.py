# SPDX-License-Identifier: Apache-2.0
"""All units of a data folder fitted at once: on any number of threads, killed and begun again, only what has changed."""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest

from one_way_campaign import Unit
from soak_cli import SoakTest, check_schema, limit_file_size, long_test, recording

BOTH_WAYS = ("SN1", "SN2", "SN3")
ONE_WAY = "A1"  # comes first, and takes what the others show
STUCK = "Z9"


def soak(data, procedures, *arguments, status=0):
    done = subprocess.run([os.environ["SOAK_BIN"], *map(str, arguments), "--data", str(data)], capture_output=True, text=True,
                          env={**os.environ, "SOAK_PROCEDURES": str(procedures)}, check=False)
    if done.returncode != status:
        raise AssertionError(f"{arguments}\n{done.stdout}\n{done.stderr}")
    return done


class Batch(SoakTest):
    @classmethod
    def setUpClass(cls):
        cls.store = pathlib.Path(tempfile.mkdtemp(prefix="soak-batch-"))
        cls.addClassCleanup(shutil.rmtree, cls.store, ignore_errors=True)
        units = cls.store / "procedures" / "units"
        units.mkdir(parents=True)
        (units / "silent.toml").write_text('name = "silent"\n', encoding="utf-8")
        for n, serial in enumerate((ONE_WAY, *BOTH_WAYS)):
            unit, ways = Unit(20 + n), ("up",) if serial == ONE_WAY else ("up", "down")
            for k in range(3):
                path = cls.store / f"{serial}-{k}.csv"
                path.write_text(unit.run(f"R{k}", ways), encoding="utf-8")
                if k < 2:
                    cls.import_run(cls.store / "data", cls.store / "procedures", path, serial)

    @staticmethod
    def import_run(data, procedures, path, serial):
        soak(data, procedures, "import", path, "--unit", serial, "--type", "silent", "--campaign", "c", "--gravity-mps2", "9.81")

    def setUp(self):
        super().setUp()
        self.procedures = self.folder / "procedures"
        shutil.copytree(self.store / "procedures", self.procedures)
        self.data = self.copy_of_data("data")

    def copy_of_data(self, name):
        return pathlib.Path(shutil.copytree(self.store / "data", self.folder / name))

    def fit_all(self, *options, data=None, status=0):
        """Units in the order of serials, as printed."""
        done = soak(data or self.data, self.procedures, "fit", "--all", "--json", *options, status=status)
        document = json.loads(done.stdout)
        check_schema(document, "fit-all")
        return {unit["unit"]: unit for unit in document["units"]}

    def versions(self, data=None):
        with contextlib.closing(sqlite3.connect((data or self.data) / "station.db")) as db:
            return dict(db.execute("SELECT unit, max(version) FROM model GROUP BY unit ORDER BY unit"))

    def test_models_depend_neither_on_threads_nor_on_what_was_fitted_before(self):
        one = self.fit_all("--jobs", "1")
        many = self.fit_all("--jobs", "5", data=self.copy_of_data("many"))
        self.assertEqual(list(one), sorted([ONE_WAY, *BOTH_WAYS]))
        self.assertEqual(one, many)
        # one that was recorded one way comes last: it takes what the models of this very batch show
        self.assertEqual(one[ONE_WAY]["sensors"]["gyro_x"]["one_way"]["source"], "fleet")
        halves = [one[serial]["sensors"]["gyro_x"]["sweeps"]["half_rms"] for serial in BOTH_WAYS]
        mean = (sum(half**2 for half in halves) / len(halves))**0.5
        self.assertAlmostEqual(one[ONE_WAY]["sensors"]["gyro_x"]["one_way"]["half_gap"], mean, 12)
        alone = self.copy_of_data("alone")
        for serial in (*BOTH_WAYS, ONE_WAY):
            printed = json.loads(soak(alone, self.procedures, "fit", "--unit", serial, "--json").stdout)
            self.assertEqual(printed, one[serial])

    def test_what_has_not_changed_is_not_fitted_again(self):
        first = self.fit_all()
        self.assertEqual(self.fit_all("--jobs", "3"), first)
        self.assertEqual(set(self.versions().values()), {1})
        self.assertIn("up to date", soak(self.data, self.procedures, "fit", "--all").stdout)
        # a new run of one unit changes its model, and what the fleet shows
        self.import_run(self.data, self.procedures, self.store / "SN2-2.csv", "SN2")
        self.assertEqual(self.fit_all()["SN2"]["sensors"]["gyro_x"]["runs"], ["R0", "R1", "R2"])
        self.assertEqual(self.versions(), {"A1": 2, "SN1": 1, "SN2": 2, "SN3": 1})
        soak(self.data, self.procedures, "runs", "void", "R2", "--unit", "SN2", "--reason", "test")
        self.assertEqual(self.fit_all()["SN2"]["sensors"]["gyro_x"]["runs"], ["R0", "R1"])
        self.assertEqual(self.versions(), {"A1": 3, "SN1": 1, "SN2": 3, "SN3": 1})
        self.fit_all("--rules", "3")
        self.assertEqual(self.versions(), {"A1": 4, "SN1": 2, "SN2": 4, "SN3": 2})
        (self.procedures / "units" / "silent.toml").write_text('name = "silent"\n[thermometers]\nrepeatability_c = 0.1\n')
        self.fit_all("--rules", "3")
        self.assertEqual(self.versions(), {"A1": 5, "SN1": 3, "SN2": 5, "SN3": 3})

    def kill_in_the_middle(self):
        """The times of the models that a batch stored before it was killed; none where it was too fast for that."""
        batch = subprocess.Popen([os.environ["SOAK_BIN"], "fit", "--all", "--jobs", "1", "--data", str(self.data)],
                                 env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)}, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL)
        while not self.versions() and batch.poll() is None:
            time.sleep(0.002)
        batch.send_signal(signal.SIGKILL)
        batch.wait()
        return self.times() if len(self.versions()) < len(BOTH_WAYS) + 1 else None

    def times(self):
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as db:
            return dict(db.execute("SELECT unit, created_utc_s FROM model"))

    def test_a_batch_that_was_killed_goes_on_where_it_stopped(self):
        whole = self.fit_all(data=self.copy_of_data("whole"))
        for attempt in range(10):
            if stored := self.kill_in_the_middle():
                break
            self.data = self.copy_of_data(f"again{attempt}")
        self.assertTrue(stored)
        self.assertEqual(self.fit_all(), whole)
        self.assertEqual(set(self.versions().values()), {1})
        after = self.times()
        self.assertEqual({unit: after[unit] for unit in stored}, stored)

    def test_one_unit_is_fitted_as_all_are(self):
        """Also where its fleet holds one that went both ways with some sensors only, and where its own model went both ways."""
        lines = [line.split(",") for line in Unit(30).run("R0", ("up", "down")).splitlines()]
        mixed = [",".join([*lines[0], "gy_dps"])]
        mixed += [",".join([*cells, cells[-1] if cells[3] == "up" else ""]) for cells in lines[1:]]
        self.import_run(self.data, self.procedures, self.write("mixed.csv", "\n".join(mixed) + "\n"), "M1")
        self.import_run(self.data, self.procedures, self.write("both.csv", Unit(31).run("R0", ("up", "down"))), "B1")
        self.import_run(self.data, self.procedures, self.write("up.csv", Unit(31).run("R1", ("up",))), "B1")
        self.fit_all()
        soak(self.data, self.procedures, "runs", "void", "R0", "--unit", "B1", "--reason", "test")
        of_all = self.fit_all()
        before = self.versions()
        for serial in (ONE_WAY, "B1", "B1"):
            alone = json.loads(soak(self.data, self.procedures, "fit", "--unit", serial, "--json").stdout)
            self.assertEqual(alone["sensors"], of_all[serial]["sensors"])
        self.fit_all()
        self.assertEqual(self.versions(), {**before, ONE_WAY: before[ONE_WAY] + 1, "B1": before["B1"] + 2})

    @long_test
    def test_a_type_file_that_is_no_text_is_the_failure_of_its_units(self):
        (self.procedures / "units" / "silent.toml").write_bytes(b'name = "silent"\n# Ger\xe4t\n')
        done = soak(self.data, self.procedures, "fit", "--all", "--json", status=2)
        message = json.loads(done.stderr)["error"]["message"]
        for serial in (ONE_WAY, *BOTH_WAYS):
            self.assertIn(f"unit {serial}: ", message)

    @long_test
    def test_where_no_model_can_be_stored_the_batch_ends(self):
        done = subprocess.run([os.environ["SOAK_BIN"], "fit", "--all", "--jobs", "1", "--json", "--data", str(self.data)],
                              env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)}, capture_output=True, text=True,
                              preexec_fn=limit_file_size(40000), check=False)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertNotIn("could not be fitted", done.stderr)
        self.assertEqual(self.versions(), {})

    @long_test
    def test_what_the_user_interrupts_has_not_failed(self):
        batch = subprocess.Popen([os.environ["SOAK_BIN"], "fit", "--all", "--jobs", "4", "--data", str(self.data)], text=True,
                                 env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)}, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE)
        while not self.versions() and batch.poll() is None:
            time.sleep(0.002)
        batch.send_signal(signal.SIGINT)
        out, err = batch.communicate(timeout=60)
        self.assertNotIn("could not be fitted", err)
        if len(self.versions()) < len(BOTH_WAYS) + 1:
            self.assertEqual((out, batch.returncode), ("", 1))

    def test_what_was_fitted_before_an_interrupt_is_listed(self):
        batch = subprocess.Popen([os.environ["SOAK_BIN"], "fit", "--all", "--brief", "--json", "--jobs", "1", "--data", str(self.data)], text=True,
                                 env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        while not self.versions() and batch.poll() is None:
            time.sleep(0.002)
        batch.send_signal(signal.SIGTERM)
        out, err = batch.communicate(timeout=60)
        document = json.loads(out)
        check_schema(document, "fit-brief")
        self.assertEqual({unit["unit"]: unit["model"] for unit in document["units"]}, self.versions())
        self.assertEqual({unit["result"] for unit in document["units"]}, {"fitted"})
        if len(self.versions()) < len(BOTH_WAYS) + 1:
            self.assertEqual(batch.returncode, 1)
            self.assertIn("interrupted", json.loads(err)["error"]["message"])

    def test_a_unit_that_cannot_be_fitted_does_not_hold_the_others(self):
        header, *rows = recording(plateaus=(-20.0, 0.0, 20.0, 40.0), seconds=20).splitlines()
        column = header.split(",").index("gy_dps")
        stuck = self.write("stuck.csv", "\n".join([header, *(",".join("0.25" if i == column else cell for i, cell in enumerate(
            row.split(","))) for row in rows)]) + "\n")
        soak(self.data, self.procedures, "import", stuck, "--unit", STUCK, "--campaign", "stuck", "--gravity-mps2", "9.81")
        done = soak(self.data, self.procedures, "fit", "--all", "--json", status=2)
        self.assertEqual([unit["unit"] for unit in json.loads(done.stdout)["units"]], sorted([ONE_WAY, *BOTH_WAYS]))
        self.assertIn(f"unit {STUCK}: ", json.loads(done.stderr)["error"]["message"])
        done = soak(self.data, self.procedures, "fit", "--all", "--brief", "--json", status=2)
        brief = json.loads(done.stdout)
        check_schema(brief, "fit-brief")
        self.assertEqual([(unit["unit"], unit["result"], unit["model"]) for unit in brief["units"]],
                         [(serial, "failed", None) if serial == STUCK else (serial, "up_to_date", 1) for serial in sorted([ONE_WAY, STUCK, *BOTH_WAYS])])
        self.assertIn(next(unit["message"] for unit in brief["units"] if unit["unit"] == STUCK), json.loads(done.stderr)["error"]["message"])

    def test_a_unit_without_a_run_is_left_out_and_is_no_failure(self):
        soak(self.data, self.procedures, "unit", "add", "NEW", "--type", "silent")
        done = soak(self.data, self.procedures, "fit", "--all", "--rules", "2", "--brief", "--json")
        document = json.loads(done.stdout)
        check_schema(document, "fit-brief")
        results = {unit["unit"]: unit for unit in document["units"]}
        self.assertEqual({serial: unit["result"] for serial, unit in results.items()}, {**dict.fromkeys((ONE_WAY, *BOTH_WAYS), "fitted"), "NEW": "skipped"})
        self.assertIn("unit NEW has no run; import or record one first", results["NEW"]["message"])
        empty = self.folder / "empty"
        soak(empty, self.procedures, "unit", "add", "NEW", "--type", "silent")
        refused = soak(empty, self.procedures, "fit", "--all", status=2)
        self.assertIn("no unit has a run for a fit", refused.stderr)

    def test_a_program_that_listens_is_told_how_far_it_is(self):
        done = subprocess.run([os.environ["SOAK_BIN"], "fit", "--all", "--jobs", "1", "--json", "--data", str(self.data)],
                              env={**os.environ, "SOAK_PROCEDURES": str(self.procedures), "SOAK_PROGRESS": "1"}, capture_output=True, text=True, check=True)
        check_schema(json.loads(done.stdout), "fit-all")
        said = [int(line.removeprefix("soak: fitting: ").removesuffix(" %")) for line in done.stderr.splitlines()]
        self.assertEqual(said, sorted(set(said)))
        self.assertEqual(said[-1], 100)


if __name__ == "__main__":
    unittest.main()
