#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The event log and the seals of the catalog's tables, judged by digests written from docs/file-formats.md (run_digest.py)."""
import contextlib
import datetime
import os
import sqlite3
import unittest

from run_digest import chain_of, open_catalog, seal_of
from soak_cli import SoakTest, long_test, recording


class EventTest(SoakTest):
    def setUp(self):
        super().setUp()
        env = {**os.environ, "USER": "cid"}
        self.soak("import", self.write("a.csv", recording(run="r1", plateaus=(-10.0, 5.0, 20.0, 40.0), seconds=20)), "--unit", "SN1", "--campaign", "c", env=env)
        self.soak("runs", "void", "r1", "--visit", "1", "--reason", "door was open", "--user", "ann")
        self.soak("fit", "--unit", "SN1", env={**os.environ, "USER": "dan"})

    def change(self, *statements):
        """Changes the catalog behind the program's back: no trigger notices."""
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog, catalog:
            triggers = catalog.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger' ORDER BY rowid").fetchall()
            for name, _ in triggers:
                catalog.execute(f"DROP TRIGGER {name}")
            for statement in statements:
                self.assertGreater(catalog.execute(statement).rowcount, 0, statement)
            for _, text in triggers:
                catalog.execute(text)


class Log(EventTest):
    def test_it_says_who_did_what(self):
        events = self.soak_json("events-list", "events", "list")["events"]
        by = {event["kind"]: event["user"] for event in events}
        self.assertEqual((by["run_added"], by["voided"], by["model_added"]), ("cid", "ann", "dan"))
        self.assertEqual([event["number"] for event in events], list(range(1, len(events) + 1)))
        ann = self.soak_json("events-list", "events", "list", "--user", "ann")["events"]
        self.assertEqual([event["kind"] for event in ann], ["voided"])
        self.assertEqual(self.soak_json("events-list", "events", "list", "--last", 2)["events"], events[-2:])
        self.assertEqual(len(self.soak_json("events-list", "events", "list", "--subject", "SN1", "--kind", "model_added")["events"]), 1)

    def test_a_name_that_would_forge_a_line_of_the_log_is_refused(self):
        name = "eva\x1b[31m\n2 forged"
        for words in (("unit", "add", "SN2"), ("runs", "void", "r1", "--reason", "x"), ("gap", "accept", "--unit", "SN1")):
            self.assertIn("--user", self.refusal(*words, "--user", name)["message"], words)
        self.refusal("unit", "add", "SN2", "--user", "  ")

    @long_test
    def test_each_event_has_its_full_date(self):
        event = self.soak_json("events-list", "events", "list", "--last", 1)["events"][0]
        date = datetime.datetime.fromtimestamp(int(event["utc_s"]), datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
        self.assertEqual(event["utc"], date)
        self.assertIn(date, self.soak("events", "list", "--last", 1).stdout)

    def test_a_kind_that_no_event_has_is_refused_and_one_without_events_is_not(self):
        self.refusal("events", "list", "--kind", "void")
        self.assertEqual(self.soak_json("events-list", "events", "list", "--kind", "samples_dropped")["events"], [])

    @long_test
    def test_a_kind_that_another_version_has_entered_is_found(self):
        self.change("UPDATE event SET kind = 'of_another_version' WHERE ordinal = 1")
        self.assertEqual(len(self.soak_json("events-list", "events", "list", "--kind", "of_another_version")["events"]), 1)

    def test_its_chain_is_that_of_the_description(self):
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog:
            chain = chain_of(catalog)
            self.assertEqual(catalog.execute("SELECT row_count, sha256 FROM seal WHERE name = 'event'").fetchone(), (len(chain), chain[-1]))
        self.assertEqual([event["chain_sha256"] for event in self.soak_json("events-list", "events", "list")["events"]], chain)
        verified = self.soak_json("events-verify", "events", "verify")
        self.assertEqual((verified["ok"], verified["events"], verified["chain_sha256"]), (True, len(chain), chain[-1]))
        self.soak("events", "verify", "--contains", chain[0])
        self.soak("events", "verify", "--contains", "0" * 64, status=4)

    def test_changed_and_missing_events_are_found(self):
        count = self.soak_json("events-verify", "events", "verify")["events"]
        for number, statement in ((2, "UPDATE event SET user = 'bob' WHERE ordinal = 2"), (1, "UPDATE event SET utc_s = utc_s + 1 WHERE ordinal = 1"),
                                  (2, "DELETE FROM event WHERE ordinal = 2"), (count, f"DELETE FROM event WHERE ordinal = {count}")):
            with self.subTest(statement):
                kept = (self.data / "station.db").read_bytes()
                self.change(statement)
                found = self.soak_json("events-verify", "events", "verify", status=4)
                self.assertEqual((found["ok"], found["where"]), (False, f"event {number}"))
                self.soak_json("runs-verify", "runs", "verify", status=4)
                (self.data / "station.db").write_bytes(kept)

    @long_test
    def test_what_is_cut_off_stays_missing_after_the_next_event(self):
        count = self.soak_json("events-verify", "events", "verify")["events"]
        self.change(f"DELETE FROM event WHERE ordinal = {count}")
        self.soak("unit", "add", "SN1", "--begin-epoch", "gyro replaced")
        self.assertEqual(self.soak_json("events-verify", "events", "verify", status=4)["where"], f"event {count}")


class Seals(EventTest):
    def test_they_are_those_of_the_description(self):
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog:
            seals = {name: (count, seal) for name, count, seal in catalog.execute("SELECT name, row_count, sha256 FROM seal") if name != "event"}
            tables = {row[0] for row in catalog.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
            self.assertEqual(set(seals), tables - {"seal", "event", "segment", "block", "finding"})
            self.assertEqual(seals, {table: seal_of(catalog, table) for table in seals})

    def test_rows_that_were_changed_are_found(self):
        for statement in ("UPDATE void SET visit = 0", "DELETE FROM void", "UPDATE unit SET epoch = 1", "UPDATE model SET created_utc_s = 1.5",
                          "UPDATE campaign SET procedure = 'ramp'", "UPDATE seal SET row_count = 9 WHERE name = 'unit'",
                          "DELETE FROM seal WHERE name = 'waiver'", "INSERT INTO unit_type VALUES ('x')"):
            with self.subTest(statement):
                kept = (self.data / "station.db").read_bytes()
                self.change(statement)
                self.assertFalse(self.soak_json("runs-verify", "runs", "verify", status=4)["catalog"]["ok"])
                (self.data / "station.db").write_bytes(kept)

    def test_a_void_record_that_was_taken_away_stops_the_fit(self):
        self.change("DELETE FROM void")
        self.soak("fit", "--unit", "SN1", status=4)

    @long_test
    def test_a_schema_that_was_changed_is_found(self):
        with contextlib.closing(open_catalog(self.data / "station.db")) as catalog, catalog:
            catalog.execute("DROP TRIGGER void_keeps_all")
        self.assertFalse(self.soak_json("runs-verify", "runs", "verify", status=4)["catalog"]["ok"])


if __name__ == "__main__":
    unittest.main()
