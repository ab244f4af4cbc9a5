# SPDX-License-Identifier: Apache-2.0
"""The register of references before a campaign: what is in force is noted for it, what has expired blocks it unless
somebody has signed."""
import datetime
import json
import sqlite3
import sys
import unittest

import bench
from bench import LabTest, short_procedure

sys.path.insert(0, str(bench.ROOT / "tests" / "cli"))
from run_digest import open_catalog  # noqa: E402


def day(offset):
    return (datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(days=offset)).strftime("%Y-%m-%d")


class References(LabTest):
    def add(self, name, due, kind="chamber_probe"):
        self.lab.soak("reference", "add", "--kind", kind, "--name", name, "--certificate", f"cert of {name}", "--issued", day(-400),
                      "--due", day(due), "--uncertainty", "0.05")

    def start(self, name="c"):
        document = self.start_campaign(short_procedure(), name)
        self.check_schema(document, "campaign-start")
        return document

    def noted(self):
        return self.query("SELECT campaign, name, waiver_id IS NOT NULL FROM campaign_reference JOIN reference USING (record_id) "
                          "ORDER BY ordinal")

    def abort(self):
        self.lab.soak("campaign", "abort", "--reason", "seen enough")
        self.wait_for_end()

    def test_a_station_without_a_register_starts_and_says_so(self):
        self.start_lab()
        document = self.start()
        self.assertEqual(len(document["notes"]), 1)
        journal = json.loads(self.query("SELECT document FROM journal")[0][0])
        self.assertEqual(journal["notes"], document["notes"])
        self.assertEqual(self.noted(), [])
        self.assertIn(("reference", "c", document["notes"][0]), self.events())
        self.abort()

    def test_an_expired_reference_blocks_until_it_is_renewed_or_signed_for(self):
        self.start_lab()
        self.add("probe 3", 200)
        self.add("level 1", -3, "level")
        procedure = self.write("procedure.toml", short_procedure())
        message = self.soak_fails(2, "campaign", "start", procedure, "--name", "c")
        for part in ("level 1", "cert of level 1", day(-3), "soak reference add", "soak reference waive"):
            self.assertIn(part, message)
        self.assertNotIn("probe 3", message)
        self.assertEqual(self.query("SELECT * FROM journal"), [])
        self.assertEqual(self.noted(), [])

        key = self.folder / "head.key"
        self.lab.soak("key", "new", "-o", key)
        self.lab.soak("reference", "waive", "--kind", "level", "--name", "level 1", "--reason", "compared", "--key", key, "--signer", "Ann")
        document = self.start()
        self.assertEqual(len(document["notes"]), 1)
        for part in ("level 1", "Ann", "compared"):
            self.assertIn(part, document["notes"][0])
        self.assertEqual(self.noted(), [("c", "probe 3", 0), ("c", "level 1", 1)])
        self.abort()

        database = open_catalog(f"{self.lab.data}/station.db")
        with database:
            database.execute("DROP TRIGGER waiver_keeps_rows")
            database.execute("UPDATE waiver SET reason = 'because'")
        database.close()
        self.soak_fails(4, "campaign", "start", procedure, "--name", "d")

        self.lab.soak("reference", "add", "--kind", "level", "--name", "level 1", "--certificate", "new", "--issued", day(0), "--due",
                      day(365), "--uncertainty", "0.05")
        self.assertEqual(self.start("e")["notes"], [])
        self.assertEqual(self.noted()[2:], [("e", "probe 3", 0), ("e", "level 1", 0)])
        self.abort()

    def test_a_campaign_without_the_check_standard_of_the_station_is_noted(self):
        self.start_lab()
        self.add("probe 3", 200)
        self.lab.soak("unit", "add", "CS1")
        self.lab.soak("check", "declare", "CS1", "--reason", "test")
        document = self.start()
        note, = document["notes"]
        self.assertIn(("check_standard", "c", note), self.events())
        self.abort()

    def test_one_that_expires_before_the_end_is_noted_and_used(self):
        self.start_lab(rate=1)  # the estimate counts the clock of the host
        self.add("probe 3", 1)
        hours = (datetime.datetime.now(datetime.timezone.utc).replace(hour=0, minute=0, second=0, microsecond=0)
                 + datetime.timedelta(days=1) - datetime.datetime.now(datetime.timezone.utc)).total_seconds() / 3600
        document = self.start_campaign(short_procedure(runs=60), "c")
        self.assertGreater(document["estimate_s"] / 3600, hours, "the procedure must reach beyond the due day")
        self.assertEqual(len(document["notes"]), 1)
        for part in ("probe 3", day(1)):
            self.assertIn(part, document["notes"][0])
        self.assertEqual(self.noted(), [("c", "probe 3", 0)])


if __name__ == "__main__":
    bench.main()
