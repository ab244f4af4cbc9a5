# SPDX-License-Identifier: Apache-2.0
"""Units fitted by several tasks into result shards, which the station joins: the models are those of one machine."""
import contextlib
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest

from one_way_campaign import Unit
from soak_cli import ROOT, SoakTest, check_schema, limit_file_size

BOTH_WAYS = ("SN1", "SN2", "SN3", "SN4", "SN5")
ONE_WAY = "A1"  # takes what the others show
UNITS = (ONE_WAY, *BOTH_WAYS)


class Shards(SoakTest):
    @classmethod
    def setUpClass(cls):
        cls.store = pathlib.Path(tempfile.mkdtemp(prefix="soak-shards-"))
        cls.addClassCleanup(shutil.rmtree, cls.store, ignore_errors=True)
        units = cls.store / "procedures" / "units"
        units.mkdir(parents=True)
        (units / "silent.toml").write_text('name = "silent"\n', encoding="utf-8")
        cls.procedures = cls.store / "procedures"
        for n, serial in enumerate(UNITS):
            ways = ("up",) if serial == ONE_WAY else ("up", "down")
            for k in range(2):
                cls.import_run(cls.store / "data", serial, f"R{k}", Unit(40 + n).run(f"R{k}", ways))
        cls.run_soak(cls.store / "data", "backup", cls.store / "copy")

    @classmethod
    def run_soak(cls, data, *arguments, status=0, **environment):
        done = subprocess.run([os.environ["SOAK_BIN"], *map(str, arguments), "--data", str(data)], capture_output=True, text=True,
                              env={**os.environ, "SOAK_PROCEDURES": str(cls.procedures), **environment}, check=False)
        if done.returncode != status:
            raise AssertionError(f"{arguments}\n{done.returncode}\n{done.stdout}\n{done.stderr}")
        return done

    @classmethod
    def import_run(cls, data, serial, label, text):
        path = cls.store / f"{serial}-{label}.csv"
        path.write_text(text, encoding="utf-8")
        cls.run_soak(data, "import", path, "--unit", serial, "--type", "silent", "--campaign", "c", "--gravity-mps2", "9.81")

    def setUp(self):
        super().setUp()
        self.data = pathlib.Path(shutil.copytree(self.store / "data", self.folder / "data"))

    def fit_shard(self, part, name, copy=None, **environment):
        file = self.folder / name
        done = self.run_soak(copy or self.store / "copy", "fit", "--all", "--shard", part, "-o", file, "--json", **environment)
        document = json.loads(done.stdout)
        check_schema(document, "fit-shard")
        return file, document

    def merge(self, *files, status=0, data=None):
        done = self.run_soak(data or self.data, "merge", *files, "--json", status=status)
        document = json.loads(done.stdout)
        check_schema(document, "merge")
        return document["shards"]

    def refused(self, code, file, names=""):
        """The file is not merged, the reason names that, and the catalog stays as it is."""
        before = self.state()
        shard, = self.merge(file, status=code)
        self.assertEqual((shard["ok"], shard["code"]), (False, code))
        self.assertIn(names, shard["reason"])
        self.assertEqual(self.state(), before)

    @staticmethod
    def models(data):
        """Documents as they are stored, but for the time of the fit, with the digest of what the fit took."""
        with contextlib.closing(sqlite3.connect(data / "station.db")) as db:
            rows = db.execute("SELECT unit, version, epoch, document, software, inputs_sha256 FROM model "
                              "JOIN model_origin USING (unit, version) ORDER BY unit, version").fetchall()
        return [(*row[:3], re.sub(r'"created_utc_s":[0-9.e+]+', "", row[3]), *row[4:]) for row in rows]

    def one_machine(self):
        data = pathlib.Path(shutil.copytree(self.store / "data", self.folder / "one"))
        self.run_soak(data, "fit", "--all")
        return self.models(data)

    def kill_in_the_middle(self, part, file):
        """A task that is killed after it has begun its shard."""
        task = subprocess.Popen([os.environ["SOAK_BIN"], "fit", "--all", "--shard", part, "-o", str(file), "--data",
                                 str(self.store / "copy")], env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)},
                                stdout=subprocess.DEVNULL)
        while not list(self.folder.glob(file.name + ".tmp-*")) and task.poll() is None:
            time.sleep(0.001)
        task.send_signal(signal.SIGKILL)
        return task.wait()

    def test_shards_of_tasks_one_of_which_was_killed_give_the_models_of_one_machine(self):
        self.assertEqual(self.kill_in_the_middle("1/2", self.folder / "1"), -signal.SIGKILL)
        self.assertFalse((self.folder / "1").exists())
        files = [self.fit_shard(f"{shard}/2", str(shard))[0] for shard in (2, 1)]
        shards = self.merge(*files)
        self.assertEqual([unit for shard in shards for unit in shard["waiting"]], [ONE_WAY])
        self.assertEqual(sorted(model["unit"] for shard in shards for model in shard["merged"]), sorted(BOTH_WAYS))
        self.run_soak(self.data, "fit", "--all")
        whole = self.one_machine()
        self.assertEqual(len(whole), len(UNITS))
        self.assertEqual(self.models(self.data), whole)
        self.run_soak(self.data, "events", "verify")

    def test_the_next_shards_leave_alone_what_has_not_changed(self):
        self.merge(self.fit_shard("1/1", "first")[0])
        self.run_soak(self.data, "fit", "--all")
        self.run_soak(self.data, "backup", self.folder / "copy")
        _, document = self.fit_shard("1/1", "second", copy=self.folder / "copy")
        results = {unit["unit"]: unit["result"] for unit in document["units"]}
        self.assertEqual(results, {ONE_WAY: "waits_for_fleet", **{serial: "up_to_date" for serial in BOTH_WAYS}})
        before = self.models(self.data)
        self.merge(self.folder / "second")
        self.run_soak(self.data, "fit", "--all")
        self.assertEqual(self.models(self.data), before)

    def test_each_unit_is_in_one_shard_whatever_other_units_there_are(self):
        self.run_soak(self.data, "fit", "--all")
        self.run_soak(self.data, "backup", self.folder / "copy")

        def parts(of):
            return [{unit["unit"] for unit in self.fit_shard(f"{i}/{of}", "s", copy=self.folder / "copy")[1]["units"]}
                    for i in range(1, of + 1)]

        for of in (1, 2, 3, 7):
            shares = parts(of)
            self.assertEqual(sorted(unit for share in shares for unit in share), sorted(UNITS))
            if of == 3:
                before = shares
        # one more unit moves none of the others; as it has no runs, its task fails
        self.run_soak(self.data, "unit", "add", "SN0")
        self.run_soak(self.data, "backup", self.folder / "copy")
        for i, share in enumerate(before, 1):
            done = subprocess.run([os.environ["SOAK_BIN"], "fit", "--all", "--shard", f"{i}/3", "-o", str(self.folder / "s"), "--json",
                                   "--data", str(self.folder / "copy")], capture_output=True, text=True, check=False,
                                  env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)})
            units = {unit["unit"]: unit["result"] for unit in json.loads(done.stdout)["units"]}
            self.assertEqual((done.returncode, units.pop("SN0", None)), (2, "failed") if "SN0" in done.stdout else (0, None))
            self.assertEqual(set(units), share)

    def test_a_task_of_a_job_array_takes_its_part(self):
        array = {"SLURM_ARRAY_TASK_COUNT": "2", "SLURM_ARRAY_TASK_MIN": "0", "SLURM_ARRAY_TASK_MAX": "1"}
        for task in (0, 1):
            _, document = self.fit_shard("slurm", "task", SLURM_ARRAY_TASK_ID=str(task), **array)
            self.assertEqual((document["shard"], document["of"]), (task + 1, 2))
            self.assertEqual(document["units"], self.fit_shard(f"{task + 1}/2", "same")[1]["units"])
        # one task of eight that is run again alone would take all units, or those of another shard
        gaps = {**array, "SLURM_ARRAY_TASK_MAX": "6", "SLURM_ARRAY_TASK_ID": "6"}
        for environment in ({}, gaps):
            done = self.run_soak(self.store / "copy", "fit", "--all", "--shard", "slurm", "-o", self.folder / "task", status=2,
                                 **environment)
            self.assertIn("array", done.stderr)

    def test_the_batch_file_fits_the_part_of_its_task(self):
        task = {"SLURM_ARRAY_TASK_COUNT": "2", "SLURM_ARRAY_TASK_MIN": "1", "SLURM_ARRAY_TASK_MAX": "2", "SLURM_ARRAY_TASK_ID": "2"}
        alone = {"SLURM_ARRAY_TASK_COUNT": "1", "SLURM_ARRAY_TASK_MIN": "2", "SLURM_ARRAY_TASK_MAX": "2", "SLURM_ARRAY_TASK_ID": "2"}
        for environment, more in ((task, []), (alone, ["2"])):
            subprocess.run(["bash", str(ROOT / "procedures" / "refit.sbatch"), str(self.store / "copy"), str(self.folder / "out"), *more],
                           check=True, stdout=subprocess.DEVNULL, env={
                               **os.environ, **environment, "SOAK_PROCEDURES": str(self.procedures),
                               "PATH": f"{pathlib.Path(os.environ['SOAK_BIN']).parent}:{os.environ['PATH']}"})
            head = json.loads((self.folder / "out" / "2.soakshard").read_text(encoding="utf-8").splitlines()[0])
            self.assertEqual((head["shard"], head["of"]), (2, 2))

    def test_a_shard_that_is_merged_already_changes_nothing(self):
        file, _ = self.fit_shard("1/1", "all")
        first, = self.merge(file)
        before = self.state()
        again, = self.merge(file)
        self.assertEqual((again["merged"], again["already"]), ([], first["merged"]))
        self.assertEqual(self.state(), before)

    def test_a_damaged_shard_is_refused(self):
        whole = self.fit_shard("1/1", "all")[0].read_bytes()
        bad = self.folder / "bad"
        for place in range(100, len(whole), len(whole) // 7):
            bad.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1:])
            self.refused(4, bad)
        for length in [i + 1 for i, byte in enumerate(whole[:-1]) if byte == 10] + [len(whole) - 20]:
            bad.write_bytes(whole[:length])
            self.refused(4, bad)
        bad.write_bytes(whole + whole)
        self.refused(4, bad)
        bad.write_text("t_s,run\n0,1\n")
        self.refused(2, bad)

    def rewritten(self, file, change):
        """A shard whose lines were changed by somebody who knows its format."""
        lines = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()[:-1]]
        change(lines)
        text = "".join(json.dumps(line) + "\n" for line in lines)
        bad = self.folder / "rewritten"
        bad.write_text(text + json.dumps({"entries": len(lines) - 1, "sha256": hashlib.sha256(text.encode()).hexdigest()}) + "\n", encoding="utf-8")
        return bad

    def test_a_head_that_no_task_writes_is_refused(self):
        file, _ = self.fit_shard("1/1", "all")
        for shard, of in ((-9, -5), (0, 1), (2, 1), (1, 2147483647), (1, 300000000)):
            self.refused(4, self.rewritten(file, lambda lines, part={"shard": shard, "of": of}: lines[0].update(part)), f"{shard} of {of}")
        self.refused(2, self.rewritten(file, lambda lines: lines[0].update(format=1)), "no result shard")

    def test_text_that_would_write_over_the_terminal_is_refused(self):
        file, _ = self.fit_shard("1/1", "all")
        for entry in ({"unit": "SN\x1b[31m", "result": "up_to_date"}, {"unit": "SN1", "result": "failed", "failure": "a\nb\x1b[2J"}):
            self.refused(4, self.rewritten(file, lambda lines, entry=entry: lines.append(entry)), "plain text")

    def test_of_many_missing_shards_a_few_are_named(self):
        file, _ = self.fit_shard("1/1", "all")
        many = self.rewritten(file, lambda lines: lines[0].update(shard=3, of=100000))
        remarks = json.loads(self.run_soak(self.data, "merge", many, "--json").stdout)["remarks"]
        self.assertIn("of 100000 shards these were not given: 1, 2, 4, 5, 6, 7, 8, 9, 10, 11 and 99989 others", remarks)

    def test_what_changes_while_a_merge_waits_for_the_catalog_is_seen(self):
        file, _ = self.fit_shard("1/1", "all")
        procedures = pathlib.Path(shutil.copytree(self.procedures, self.folder / "procedures"))
        with contextlib.closing(sqlite3.connect(self.data / "station.db", isolation_level=None)) as db:
            db.execute("BEGIN IMMEDIATE")
            with subprocess.Popen([os.environ["SOAK_BIN"], "merge", str(file), "--data", str(self.data)], stderr=subprocess.PIPE, text=True,
                                  env={**os.environ, "SOAK_PROCEDURES": str(procedures)}) as merge:
                time.sleep(0.5)  # it reads until it must write, and waits; should it come later than that, the change counts as well
                with (procedures / "units" / "silent.toml").open("a", encoding="utf-8") as unit_type:
                    unit_type.write("[gyro]\nhysteresis_dps = 0.5\n")
                db.execute("ROLLBACK")
                message = merge.communicate()[1]
        self.assertEqual(merge.returncode, 2)
        self.assertIn("would take something else", message)
        self.assertEqual(self.models(self.data), [])

    def test_strangers_are_refused_and_take_the_rest_of_their_shard_with_them(self):
        other = self.folder / "other"
        shutil.copytree(self.data, other)
        self.import_run(other, "SN9", "R0", Unit(70).run("R0", ("up", "down")))
        self.run_soak(other, "backup", self.folder / "with-unit")
        self.refused(2, self.fit_shard("1/1", "unit", self.folder / "with-unit")[0], "SN9")
        other = self.folder / "other2"
        shutil.copytree(self.data, other)
        self.import_run(other, "SN3", "R7", Unit(71).run("R7", ("up", "down")))
        self.run_soak(other, "backup", self.folder / "with-run")
        self.refused(2, self.fit_shard("1/1", "run", self.folder / "with-run")[0], "SN3")

    def test_what_a_fit_here_would_not_give_is_refused(self):
        file, _ = self.fit_shard("1/1", "all")
        self.run_soak(self.data, "runs", "void", "R1", "--unit", "SN2", "--reason", "test")
        self.refused(2, file, "SN2")

    def test_a_model_that_was_fitted_meanwhile_is_not_doubled(self):
        file, _ = self.fit_shard("1/1", "all")
        self.run_soak(self.data, "fit", "--unit", "SN2", "--rules", "3")
        self.refused(2, file, "SN2")
        newer = self.fit_shard("1/1", "newer", copy=self.copy_after_fit())[0]
        self.data = pathlib.Path(shutil.copytree(self.store / "data", self.folder / "before"))
        self.refused(2, newer)

    def copy_after_fit(self):
        self.run_soak(self.data, "backup", self.folder / "after")
        return self.folder / "after"

    def test_one_bad_shard_does_not_hold_the_others(self):
        files = [self.fit_shard(f"{i}/2", f"s{i}")[0] for i in (1, 2)]
        files[0].write_bytes(files[0].read_bytes()[:-1500])
        bad, good = self.merge(*files, status=4)
        self.assertEqual((bad["ok"], good["ok"]), (False, True))
        self.assertEqual({row[0] for row in self.models(self.data)}, {model["unit"] for model in good["merged"]})

    def test_a_data_folder_that_is_being_written_is_not_fitted_from(self):
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as station:
            station.execute("PRAGMA journal_mode = WAL")
            station.execute("CREATE TABLE IF NOT EXISTS held (x)")
            station.commit()
            done = self.run_soak(self.data, "fit", "--all", "--shard", "1/1", "-o", self.folder / "s", status=2)
        self.assertIn("soak backup", done.stderr)
        self.assertFalse((self.folder / "s").exists())

    def test_a_full_disk_leaves_no_shard_and_the_earlier_one_stays(self):
        file, _ = self.fit_shard("1/1", "shard")
        before = file.read_bytes()
        done = subprocess.run([os.environ["SOAK_BIN"], "fit", "--all", "--shard", "1/1", "-o", str(file), "--data", str(self.store / "copy")],
                              env={**os.environ, "SOAK_PROCEDURES": str(self.procedures)}, capture_output=True, check=False,
                              preexec_fn=limit_file_size(60000))
        self.assertEqual(done.returncode, 1)
        self.assertEqual((file.read_bytes(), [path.name for path in self.folder.glob("shard*")]), (before, ["shard"]))

    def test_a_shard_needs_its_options(self):
        for options in (["--all", "--shard", "1/2"], ["--all", "-o", "s"], ["--unit", "SN1", "--shard", "1/2", "-o", "s"],
                        ["--all", "--shard", "3/2", "-o", "s"], ["--all", "--shard", "0/2", "-o", "s"], ["--all", "--shard", "1", "-o", "s"]):
            self.run_soak(self.store / "copy", "fit", *options, status=2)


if __name__ == "__main__":
    unittest.main()
