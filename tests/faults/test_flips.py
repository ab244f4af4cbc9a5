#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bits and values of a data folder that change by themselves: `soak runs verify` finds each, or a fit gives what it gave before."""
import contextlib
import json
import math
import os
import random
import shutil
import sqlite3
import subprocess
import unittest

from faulty_disk import LONG_TESTS, DiskTest, recording

BITS = int(os.environ.get("SOAK_FLIPS", "200" if LONG_TESTS else "40"))
VALUES = BITS // 2


class Flips(DiskTest):
    """SOAK_FLIPS=N: so many bits of the catalog, half as many bits of a run file and values of rows; 200 where long tests are wanted."""
    def setUp(self):
        super().setUp()
        for number in (1, 2, 3):
            self.soak("import", self.write(f"{number}.csv", recording(number, f"r{number}", (-20.0, -5.0, 10.0, 25.0, 40.0), 10)), "--unit", "SN1",
                      "--campaign", "c", "--gravity-mps2", "9.80665")
        self.soak("runs", "void", "r2", "--visit", "1", "--reason", "door")
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog:
            catalog.execute("PRAGMA journal_mode = DELETE")
        self.sound = self.folder / "sound"
        shutil.copytree(self.data, self.sound)
        self.expected = self.fit()
        self.assertIsNotNone(self.expected)
        self.found = 0

    def restore(self):
        shutil.rmtree(self.data)
        shutil.copytree(self.sound, self.data)

    def run_soak(self, *arguments):
        return subprocess.run(self.command(*arguments), capture_output=True, text=True, timeout=120, check=False)

    def fit(self):
        """What a fit gives but for its time; None where it refuses."""
        done = self.run_soak("fit", "--unit", "SN1", "--rules", 2, "--json")
        if done.returncode != 0:
            self.assertIn(done.returncode, (1, 2, 4), done.stderr)
            return None
        document = json.loads(done.stdout)
        document.pop("created_utc_s", None)
        return document

    def judge(self, what):
        done = self.run_soak("runs", "verify")
        self.assertIn(done.returncode, (0, 1, 2, 4), f"{what}\n{done.stderr}")
        if done.returncode != 0:
            self.found += 1
            return
        self.assertEqual(self.fit(), self.expected, what)

    def flip_bits(self, name, count, seed):
        chance = random.Random(seed)
        size = (self.sound / name).stat().st_size
        for _ in range(count):
            self.restore()
            place, bit = chance.randrange(size), chance.randrange(8)
            path = self.data / name
            path.chmod(0o644)
            with path.open("r+b") as file:
                file.seek(place)
                byte = file.read(1)[0] ^ 1 << bit
                file.seek(place)
                file.write(bytes([byte]))
            self.judge(f"bit {bit} of byte {place} of {name}")
        print(f"{name}: {self.found} of {count} flipped bits found, the others change no fit")

    def test_bits_of_the_catalog(self):
        self.flip_bits("station.db", BITS, 1)
        self.assertGreater(self.found, BITS // 4)

    def test_bits_of_a_run_file(self):
        name = next((self.sound / "runs").glob("*.soakrun")).relative_to(self.sound)
        self.flip_bits(name, VALUES, 2)
        self.assertEqual(self.found, VALUES)  # its hash covers every bit

    def test_values_of_rows(self):
        """Of any table, by a hand that leaves indexes and triggers right but does not know the seals: each is found."""
        chance = random.Random(3)
        for _ in range(VALUES):
            self.restore()
            with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog, catalog:
                triggers = catalog.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger' ORDER BY rowid").fetchall()
                for name, _ in triggers:
                    catalog.execute(f"DROP TRIGGER {name}")
                what = self.change_a_value(catalog, chance)
                for _, text in triggers:
                    catalog.execute(text)
            before = self.found
            self.judge(what)
            self.assertEqual(self.found, before + 1, what)

    def change_a_value(self, catalog, chance):
        tables = [row[0] for row in catalog.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")]
        tables = [table for table in tables if catalog.execute(f"SELECT count(*) FROM {table}").fetchone()[0]]
        while True:
            table = chance.choice(tables)
            columns = [row[1] for row in catalog.execute(f"PRAGMA table_info({table})")]
            column = chance.choice(columns)
            rows = catalog.execute(f"SELECT {', '.join(columns)} FROM {table}").fetchall()
            row = chance.choice(rows)
            value = row[columns.index(column)]
            new = self.other_value(value, chance)
            where = " AND ".join(f"{name} IS ?" for name in columns)
            try:
                if catalog.execute(f"UPDATE {table} SET {column} = ? WHERE {where}", (new, *row)).rowcount == 1:
                    return f"{table}.{column}: {value!r} to {new!r}"
            except sqlite3.IntegrityError:
                continue  # a value that the schema refuses does not come about by itself

    @staticmethod
    def other_value(value, chance):
        if value is None:
            return 1.0
        if isinstance(value, int):
            return value ^ 1 << chance.randrange(8)
        if isinstance(value, float):
            return math.nextafter(value, math.inf)
        place = chance.randrange(len(value) + 1)
        return value[:place] + chr(ord("a") + chance.randrange(26)) + value[place:]


if __name__ == "__main__":
    unittest.main()
