# SPDX-License-Identifier: Apache-2.0
"""Stations that push their runs into one archive, and one that pulls them: what arrives is what was recorded, to the last bit."""
import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import sqlite3
import struct
import subprocess
import tempfile
import unittest

from soak_cli import SoakTest, limit_file_size, long_test, recording

NO_RUN = "01900000-0000-7000-8000-000000000000"
PLATEAUS = (-20.0, 0.0, 20.0, 40.0)
TABLES = ("run", "segment", "block", "finding")


def digest(tables):
    """The digest of a run (docs/file-formats.md), from a record's tables."""
    data = b""
    for table in tables:
        data += table["name"].encode()
        for row in table["rows"]:
            for value in row:
                if isinstance(value, str):
                    data += b"t" + struct.pack("<q", len(value.encode())) + value.encode()
                else:
                    kind = {type(None): "n", int: "i", float: "f"}[type(value)]
                    data += kind.encode() + struct.pack("<d" if kind == "f" else "<q", value or 0)
            data += b"r" + bytes(8)
    return hashlib.sha256(data).hexdigest()


class Archive(SoakTest):
    @classmethod
    def setUpClass(cls):
        """Two stations: SN1 was recorded at both, SN2 and SN3 at one of them; a third one has a unit of its own."""
        cls.store = pathlib.Path(tempfile.mkdtemp(prefix="soak-archive-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.store, ignore_errors=True)
        for n, (station, serial, run) in enumerate((("a", "SN1", "R1"), ("a", "SN2", "R1"), ("b", "SN1", "R2"), ("b", "SN3", "R2"))):
            csv = cls.store / f"{serial}-{run}.csv"
            csv.write_text(recording(n, run, PLATEAUS, seconds=35), encoding="utf-8")
            cls.import_csv(cls.store / station, csv, serial, station)
        cls.import_csv(cls.store / "third", cls.store / "SN2-R1.csv", "OWN", "own")

    @staticmethod
    def import_csv(data, csv, serial, campaign):
        subprocess.run([os.environ["SOAK_BIN"], "import", csv, "--unit", serial, "--campaign", campaign, "--gravity-mps2", "9.80665", "--data",
                        data], check=True, capture_output=True)

    def setUp(self):
        super().setUp()
        self.archive = self.folder / "archive"
        self.a, self.b, self.third = (pathlib.Path(shutil.copytree(self.store / name, self.folder / name)) for name in ("a", "b", "third"))
        self.data = self.third

    def archive_of(self, data, what, place=None, status=0, **options):
        self.data = data
        return self.soak_json(f"archive-{what}", "archive", what, place or self.archive, status=status, **options)

    def push_both(self):
        return [self.archive_of(data, "push") for data in (self.a, self.b)]

    @staticmethod
    def rows(data, campaign):
        """All that the catalog holds of the runs of a campaign."""
        with contextlib.closing(sqlite3.connect(data / "station.db")) as db:
            return {table: db.execute(f"SELECT {table}.* FROM {table} WHERE run_id IN (SELECT run_id FROM run WHERE campaign = ?) "
                                      "ORDER BY 1, 2, 3, 4, 5, 6", (campaign,)).fetchall() for table in TABLES}

    @staticmethod
    def run_files(data):
        return {path.name: path.read_bytes() for path in (data / "runs").glob("*")}

    def fitted(self, data, serial):
        self.data = data
        return self.soak_json("fit", "fit", "--unit", serial)["sensors"]

    def test_two_stations_come_together_at_a_third(self):
        for pushed in self.push_both():
            self.assertEqual((len(pushed["pushed"]), pushed["records"]), (2, 2))
        pulled = self.archive_of(self.third, "pull")
        self.assertEqual(sorted(pulled["pulled"]), ["a/R1", "a/R1", "b/R2", "b/R2"])
        for data, campaign in ((self.a, "a"), (self.b, "b")):
            rows = self.rows(data, campaign)
            self.assertTrue(all(rows[table] for table in ("run", "segment", "block")))
            self.assertEqual(self.rows(self.third, campaign), rows)
            self.assertLessEqual(self.run_files(data).items(), self.run_files(self.third).items())
        self.soak("runs", "verify")
        self.soak("events", "verify")
        # a fit there takes both stations' runs, as a station does that recorded them all
        one = self.folder / "one"
        for run, campaign in (("R1", "a"), ("R2", "b")):
            self.import_csv(one, self.store / f"SN1-{run}.csv", "SN1", campaign)
        self.assertEqual(self.fitted(self.third, "SN1"), self.fitted(one, "SN1"))
        self.assertEqual(self.fitted(self.third, "SN1")["accel_x"]["runs"], ["R1", "R2"])

    def test_what_is_there_is_not_brought_again(self):
        self.push_both()
        again = self.archive_of(self.a, "push")
        self.assertEqual((again["pushed"], again["were_there"], again["records"]), ([], 2, 0))
        self.archive_of(self.third, "pull")
        before = self.state()
        again = self.archive_of(self.third, "pull")
        self.assertEqual((again["pulled"], again["were_there"]), ([], 4))
        self.assertEqual(self.state(), before)

    @long_test
    def test_a_station_that_pulls_its_own_runs_has_nothing_new(self):
        self.push_both()
        before = self.rows(self.a, "a")
        pulled = self.archive_of(self.a, "pull")
        self.assertEqual((pulled["pulled"], pulled["were_there"]), (["b/R2", "b/R2"], 2))
        self.assertEqual(self.rows(self.a, "a"), before)

    def test_what_was_cut_off_goes_on(self):
        self.push_both()
        gone = sorted((self.archive / "files").iterdir())[0]
        gone.unlink()
        (self.archive / "files" / (gone.name + ".tmp-x")).write_bytes(b"half a file")
        self.assertEqual(sum(len(pushed["pushed"]) for pushed in self.push_both()), 1)
        self.data = self.third
        self.soak("archive", "pull", self.archive, status=1, preexec_fn=limit_file_size(40000))
        self.assertEqual([path for path in (self.third / "runs").iterdir() if path.suffix != ".soakrun"], [])
        self.soak("runs", "verify")
        self.archive_of(self.third, "pull")
        self.assertEqual(len(self.run_files(self.third)), 5)
        self.soak("runs", "verify")

    def known_files(self, data):
        with contextlib.closing(sqlite3.connect(data / "station.db")) as db:
            return {name for name, in db.execute("SELECT file_name FROM run")}

    @long_test
    def test_a_disk_that_is_full_when_the_rows_are_stored_leaves_no_run_file_without_rows(self):
        self.push_both()
        catalog = (self.third / "station.db").stat().st_size
        largest = max(file.stat().st_size for file in (self.archive / "files").iterdir())
        self.assertLess(largest, catalog)
        for room in (0, 4096, 16384):
            data = self.data = pathlib.Path(shutil.copytree(self.third, self.folder / f"full-{room}"))
            self.soak("archive", "pull", self.archive, status=1, preexec_fn=limit_file_size(catalog + room))
            self.assertEqual(set(self.run_files(data)), self.known_files(data))
        self.archive_of(data, "pull")
        self.assertEqual(len(self.known_files(data)), 5)

    @long_test
    def test_a_file_that_a_killed_pull_left_is_taken(self):
        """Killed between the file's name and the end of the transaction."""
        self.push_both()
        before = self.run_files(self.a)
        (self.third / "runs" / min(before)).write_bytes(before[min(before)])
        self.assertEqual(len(self.archive_of(self.third, "pull")["pulled"]), 4)
        self.assertLessEqual(before.items(), self.run_files(self.third).items())
        self.soak("runs", "verify")

    def test_no_file_that_is_there_is_replaced(self):
        self.data = self.a
        self.soak("runs", "void", "R1", "--unit", "SN1", "--reason", "door open")
        self.push_both()
        mine = self.third / "runs" / min(self.run_files(self.a))
        mine.write_bytes(b"of another recording")
        pulled = self.archive_of(self.third, "pull", status=2)
        self.assertEqual(([trouble["name"] for trouble in pulled["troubles"]], len(pulled["pulled"]), pulled["voids"]), (["a/R1"], 3, 0))
        self.assertEqual(mine.read_bytes(), b"of another recording")

    def test_what_is_voided_later_follows(self):
        self.push_both()
        self.archive_of(self.third, "pull")
        self.data = self.a
        self.soak("runs", "void", "R1", "--unit", "SN1", "--visit", "1", "--reason", "door open", "--user", "anna")
        pushed = self.archive_of(self.a, "push")
        self.assertEqual((pushed["pushed"], pushed["records"]), ([], 1))
        for data, voids in ((self.third, 1), (self.third, 0), (self.folder / "fresh", None)):
            if voids is None:
                shutil.copytree(self.b, data)
                voids = 1
            self.assertEqual(self.archive_of(data, "pull")["voids"], voids)
            with contextlib.closing(sqlite3.connect(data / "station.db")) as db:
                self.assertEqual(db.execute("SELECT unit, visit, reason, user FROM void").fetchall(), [("SN1", 1, "door open", "anna")])
        listed = self.archive_of(self.third, "list")["runs"]
        self.assertEqual([(run["campaign"], run["units"], run["voids"]) for run in listed],
                         [("a", ["SN1"], 1), ("a", ["SN2"], 0), ("b", ["SN1"], 0), ("b", ["SN3"], 0)])

    @long_test
    def test_samples_that_are_dropped_after_the_push_stay_in_the_archive(self):
        self.push_both()
        before = self.archive_of(self.a, "list")
        self.soak("runs", "drop-samples", "--campaign", "a", "--reason", "room", "--yes")
        pushed = self.archive_of(self.a, "push")
        self.assertEqual((pushed["pushed"], pushed["were_there"], pushed["records"], pushed["dropped"]), ([], 2, 0, []))
        self.assertEqual(self.archive_of(self.a, "list"), before)
        self.assertEqual(len(self.archive_of(self.third, "pull")["pulled"]), 4)
        shutil.rmtree(self.archive)
        self.assertEqual(len(self.archive_of(self.a, "push")["dropped"]), 2)

    @long_test
    def test_the_epoch_of_a_unit_is_the_higher_one(self):
        self.data = self.a
        self.soak("unit", "add", "SN1", "--begin-epoch", "repaired")
        self.push_both()
        self.archive_of(self.third, "pull")
        with contextlib.closing(sqlite3.connect(self.third / "station.db")) as db:
            self.assertEqual(dict(db.execute("SELECT serial, epoch FROM unit")), {"OWN": 0, "SN1": 1, "SN2": 0, "SN3": 0})

    @long_test
    def test_an_epoch_that_begins_later_follows(self):
        self.push_both()
        self.archive_of(self.third, "pull")
        self.data = self.a
        self.soak("unit", "add", "SN2", "--begin-epoch", "repaired")
        self.assertEqual(self.archive_of(self.a, "push")["records"], 1)
        for _ in range(2):
            self.assertEqual(self.archive_of(self.third, "pull")["pulled"], [])
            with contextlib.closing(sqlite3.connect(self.third / "station.db")) as db:
                self.assertEqual(dict(db.execute("SELECT serial, epoch FROM unit")), {"OWN": 0, "SN1": 0, "SN2": 1, "SN3": 0})

    def test_damage_in_the_archive_is_found_and_does_not_hold_the_others(self):
        self.push_both()
        self.assertTrue(self.archive_of(self.third, "verify")["ok"])
        file = sorted((self.archive / "files").iterdir())[1]
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
        record = sorted((self.archive / "records").iterdir())[0]
        record.write_bytes(record.read_bytes().replace(b'"campaign":"', b'"campaign":"x'))
        check = self.archive_of(self.third, "verify", status=4)
        self.assertEqual((check["ok"], {trouble["name"] for trouble in check["troubles"]}), (False, {file.name, record.name}))
        pulled = self.archive_of(self.third, "pull", status=4)
        self.assertEqual({trouble["code"] for trouble in pulled["troubles"]}, {4})
        # the damaged file and the damaged record may be of one run
        self.assertIn(len(pulled["pulled"]), (2, 3))
        self.soak("runs", "verify")

    def forged(self, change, with_digest=False):
        """The archive of station a with one record changed, under the name that its new content has."""
        shutil.rmtree(self.archive, ignore_errors=True)
        self.archive_of(self.a, "push")
        record = sorted((self.archive / "records").iterdir())[0]
        document = json.loads(record.read_text(encoding="utf-8"))
        change(document)
        if with_digest:
            document["runs"][0]["numbers_sha256"] = digest(document["runs"][0]["tables"])
        text = json.dumps(document).encode()
        record.unlink()
        (record.parent / f"{hashlib.sha256(text).hexdigest()}.json").write_bytes(text)

    @long_test
    def test_a_record_that_its_hash_does_not_betray_is_held_against_the_digest_and_the_catalog(self):
        def table(document, name):
            return next(table for table in document["runs"][0]["tables"] if table["name"] == name)

        def set_in_run(document, column, value):
            run = table(document, "run")
            run["rows"][0][run["columns"].index(column)] = value

        def number(document):
            row = table(document, "segment")["rows"][3]
            row[table(document, "segment")["columns"].index("temp_c")] += 1e-9

        def missing_row(document):
            table(document, "block")["rows"].pop()

        def other_run(document):
            table(document, "segment")["rows"][0][0] = NO_RUN

        def other_columns(document):
            table(document, "segment")["columns"][8] = "plateau_c; DROP TABLE run"

        def other_file(document):
            document["file"] = "../station.soakrun"

        def other_format(document):
            document["format"] = 1

        def many_epochs(document):
            document["units"][0]["epoch"] = 300000

        def no_voids(document):
            del document["voids"]

        def own_file(document):
            document["file"] = min(self.run_files(self.third))
            set_in_run(document, "file_name", document["file"])

        def other_label(document):
            set_in_run(document, "label", "R1\x1b[31mX")

        def other_campaign(document):
            set_in_run(document, "campaign", "own")

        faults = [(change, code, False) for change, code in ((number, 4), (missing_row, 4), (other_run, 4), (other_columns, 2), (other_file, 4),
                                                             (no_voids, 4), (other_format, 4), (many_epochs, 4))]
        for change, code, with_digest in (*faults, (own_file, 4, True), (other_label, 4, True), (other_campaign, 4, True)):
            with self.subTest(change.__name__):
                data = pathlib.Path(shutil.copytree(self.third, self.folder / change.__name__))
                self.forged(change, with_digest)
                pulled = self.archive_of(data, "pull", status=code)
                self.assertEqual(([trouble["code"] for trouble in pulled["troubles"]], len(pulled["pulled"])), ([code], 1))
                self.assertEqual((len(self.run_files(data)), self.run_files(data).items() >= self.run_files(self.third).items()), (2, True))
                self.soak("runs", "verify")

    def test_the_digest_that_these_tests_compute_is_that_of_the_catalog(self):
        self.forged(lambda document: None, with_digest=True)
        self.assertEqual(len(self.archive_of(self.third, "pull")["pulled"]), 2)

    @long_test
    def test_the_warning_of_references_does_not_depend_on_which_record_is_read_first(self):
        """A station that has a run from the archive has no certificates of it, and pushes a record that says so."""
        for order in (min, max):
            self.forged(lambda document: None)
            for record in list((self.archive / "records").iterdir()):
                document = {**json.loads(record.read_text(encoding="utf-8")), "references": 2}
                texts = [json.dumps(document).encode() + b" " * n for n in range(20)]
                name, text = order((hashlib.sha256(text).hexdigest(), text) for text in texts)
                (record.parent / f"{name}.json").write_bytes(text)
            data = pathlib.Path(shutil.copytree(self.third, self.folder / order.__name__))
            warning, = self.archive_of(data, "pull")["warnings"]
            self.assertIn("2 references", warning)

    def test_a_missing_file_and_one_without_record_are_told(self):
        self.push_both()
        file = sorted((self.archive / "files").iterdir())[0]
        record = next(path for path in (self.archive / "records").iterdir() if json.loads(path.read_text())["file_sha256"] != file.stem)
        stray = json.loads(record.read_text())["file_sha256"] + ".soakrun"
        record.unlink()
        file.unlink()
        check = self.archive_of(self.third, "verify", status=4)
        self.assertEqual(([trouble["name"] for trouble in check["troubles"]], check["without_record"]), ([file.name], [stray]))

    @long_test
    def test_where_no_archive_is_only_a_push_begins_one(self):
        self.data = self.third
        (self.folder / "empty").mkdir()
        for place in ("nowhere", "empty"):
            for command in ("pull", "list", "verify"):
                self.assertIn("no archive", self.refusal("archive", command, self.folder / place)["message"])
        self.archive_of(self.third, "push")
        self.assertEqual(len(self.archive_of(self.third, "list")["runs"]), 1)

    def strangers(self):
        """What a file server and a push that is under way leave in an archive."""
        record = min((self.archive / "records").iterdir())
        (self.archive / "records" / f"{record.name}.tmp-x").write_bytes(b"{")
        for folder in ("records", "files"):
            (self.archive / folder / "@eaDir").mkdir()
            (self.archive / folder / "Thumbs.db").write_bytes(b"x")

    @long_test
    def test_what_is_no_archived_file_is_left_alone(self):
        self.push_both()
        self.strangers()
        self.assertEqual(len(self.archive_of(self.third, "list")["runs"]), 4)
        check = self.archive_of(self.third, "verify")
        self.assertEqual((check["records"], check["files"]), (4, 4))
        self.assertEqual(len(self.archive_of(self.third, "pull")["pulled"]), 4)

    @long_test
    def test_a_folder_may_have_a_colon_in_its_name(self):
        self.archive = self.folder / "lab:2"
        without_rclone = {**os.environ, "PATH": str(self.folder)}
        self.archive_of(self.a, "push", env=without_rclone)
        self.assertEqual(len(self.archive_of(self.third, "list", env=without_rclone)["runs"]), 2)

    @long_test
    def test_without_a_place_for_temporary_files_the_error_says_so(self):
        self.push_both()
        self.data = self.third
        error = self.refusal("archive", "pull", self.archive, status=1, env={**os.environ, "TMPDIR": str(self.folder / "nowhere")})
        self.assertIn("TMPDIR", error["message"])

    def test_run_files_of_a_folder_are_verified_where_they_lie(self):
        """A small /tmp holds no run file."""
        self.push_both()
        largest = min((self.archive / "files").iterdir(), key=lambda file: -file.stat().st_size)
        content = largest.read_bytes() + bytes(1 << 20)
        (self.archive / "files" / f"{hashlib.sha256(content).hexdigest()}.soakrun").write_bytes(content)
        self.assertEqual(self.archive_of(self.third, "verify", preexec_fn=limit_file_size(len(content) - 1))["files"], 5)

    @long_test
    def test_a_run_that_is_damaged_here_is_not_pushed(self):
        file = sorted((self.a / "runs").iterdir())[0]
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
        pushed = self.archive_of(self.a, "push", status=4)
        self.assertEqual(([trouble["name"] for trouble in pushed["troubles"]], len(pushed["pushed"])), ([file.name], 1))
        self.assertTrue(self.archive_of(self.a, "verify")["ok"])

    @long_test
    def test_what_is_at_odds_with_this_catalog_is_left_out(self):
        """Another run of that campaign, unit and label; a campaign of another procedure; a unit of another type."""
        self.push_both()
        other = self.write("other.csv", recording(9, "R1", (0.0, 20.0), seconds=35))
        self.data = self.third
        self.soak("import", other, "--unit", "SN1", "--campaign", "a", "--gravity-mps2", "9.80665")
        self.soak("unit", "add", "SN3", "--type", "mti-300")
        before = self.rows(self.third, "a")
        pulled = self.archive_of(self.third, "pull", status=2)
        self.assertEqual((sorted(trouble["name"] for trouble in pulled["troubles"]), sorted(pulled["pulled"])),
                         (["a/R1", "b/R2"], ["a/R1", "b/R2"]))
        self.assertLessEqual(set(before["run"]), set(self.rows(self.third, "a")["run"]))
        self.soak("runs", "verify")
        elsewhere = self.folder / "elsewhere"
        self.data = elsewhere
        self.soak("import", other, "--unit", "SN7", "--campaign", "b", "--procedure", "verification", "--gravity-mps2", "9.80665")
        pulled = self.archive_of(elsewhere, "pull", status=2)
        self.assertEqual(({trouble["name"] for trouble in pulled["troubles"]}, pulled["pulled"]), ({"b/R2"}, ["a/R1", "a/R1"]))

    @unittest.skipUnless(shutil.which("rclone"), "rclone is not installed")
    def test_a_remote_of_rclone_is_an_archive(self):
        remote = {**os.environ, "RCLONE_CONFIG_STORE_TYPE": "alias", "RCLONE_CONFIG_STORE_REMOTE": str(self.folder)}
        for data in (self.a, self.b):
            self.archive_of(data, "push", "store:archive", env=remote)
        self.assertEqual(self.archive_of(self.a, "push", "store:archive", env=remote)["were_there"], 2)
        self.assertTrue(self.archive_of(self.a, "verify")["ok"])
        self.assertEqual(len(self.archive_of(self.third, "pull", "store:archive", env=remote)["pulled"]), 4)
        self.soak("runs", "verify")
        self.soak("archive", "list", "nowhere:archive", status=1)
        self.refusal("archive", "list", "store:nowhere", env=remote)
        # rclone takes files of the same size and time for the same
        records = list((self.archive / "records").iterdir())
        size = max(record.stat().st_size for record in records) + 1
        for record in records:
            text = record.read_bytes().ljust(size)
            record.unlink()
            (record.parent / f"{hashlib.sha256(text).hexdigest()}.json").write_bytes(text)
        for file in self.archive.glob("*/*"):
            os.utime(file, (1.8e9, 1.8e9))
        self.strangers()
        self.assertEqual(len(self.archive_of(self.third, "list", "store:archive", env=remote)["runs"]), 4)

    def test_a_remote_without_rclone_is_refused(self):
        self.data = self.a
        self.refusal("archive", "push", "store:archive", env={**os.environ, "PATH": str(self.folder)})


if __name__ == "__main__":
    unittest.main()
