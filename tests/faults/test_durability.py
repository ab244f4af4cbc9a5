#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What must be on the disk before what: a loss of power between any two changes leaves no name without contents, no row without file."""
import unittest

from faulty_disk import DiskTest


def place(changes, *words):
    """The number of the first change that begins with these words."""
    return next(i for i, change in enumerate(changes) if change[:len(words)] == [str(word) for word in words])


class Durability(DiskTest):
    def test_a_run_file_has_its_name_on_the_disk_before_the_catalog_has_its_row(self):
        done, changes = self.before_disk(*self.import_arguments("r1"))
        self.assertEqual(done.returncode, 0, done.stderr)
        run = self.soak_json("runs-list", "runs", "list")["runs"][0]
        final = self.data / "runs" / run["file"]
        renamed = place(changes, "rename", f"{final}.tmp", final)
        written = max(i for i, change in enumerate(changes) if change[0] == "write" and change[1].startswith(f"{final}.tmp"))
        synced = max(i for i, change in enumerate(changes[:renamed]) if change == ["sync", f"{final}.tmp"])
        self.assertLess(written, synced)
        named = renamed + place(changes[renamed:], "sync", self.data / "runs")
        entered = [i for i, change in enumerate(changes) if change[0] == "write" and change[1] == str(self.data / "station.db-wal")]
        # Rows before the run (the schema) may be older than the name; none may come between the name and its sync.
        self.assertTrue(entered[-1] > named, changes)
        self.assertFalse([i for i in entered if renamed <= i <= named], changes)

    def test_a_new_data_folder_has_its_name_on_the_disk(self):
        _, changes = self.before_disk(*self.import_arguments("r1"))
        made = place(changes, "mkdir", self.data)
        self.assertLess(place(changes, "sync", self.folder), place(changes, "create", self.data / "station.db"))
        self.assertLess(made, place(changes, "sync", self.folder))

    def test_a_written_text_file_has_contents_and_name_on_the_disk(self):
        self.soak(*self.import_arguments("r1"))
        target = self.folder / "out" / "r1.csv"
        target.parent.mkdir()
        done, changes = self.before_disk("runs", "export", "r1", "-o", target)
        self.assertEqual(done.returncode, 0, done.stderr)
        renamed = next(i for i, change in enumerate(changes) if change[0] == "rename" and change[2] == str(target))
        temporary = changes[renamed][1]
        self.assertIn(["sync", temporary], changes[:renamed])
        self.assertIn(["sync", str(target.parent)], changes[renamed:])

    def test_a_new_secret_key_has_its_name_on_the_disk(self):
        done, changes = self.before_disk("key", "new", "-o", self.folder / "station.key")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(["sync", str(self.folder)], changes[place(changes, "create", self.folder / "station.key"):])


if __name__ == "__main__":
    unittest.main()
