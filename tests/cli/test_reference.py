# SPDX-License-Identifier: Apache-2.0
"""soak reference: the register, waivers, and their way with a campaign through fit and export. Waivers are verified here
from docs/records.md alone, with an Ed25519 of our own (ed25519.py)."""
import datetime
import json
import math
import pathlib
import sqlite3
import struct
import unittest

import ed25519
from blob_reader import Calibration, crc32c
from run_digest import open_catalog
from soak_cli import ROOT, SoakTest, check_schema, long_test
from soak_cli import recording as recording_of

GOLDEN = ROOT / "tests" / "data" / "golden"
DAY_S = 86400


def day(offset):
    return (datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(days=offset)).strftime("%Y-%m-%d")


def with_crc(content):
    """A calibration file whose content was changed, with the checksum that fits it."""
    return bytes(content[:-4]) + struct.pack("<I", crc32c(bytes(content[:-4])))


# What is told of one or two runs that only heat, whatever they were measured with.
OF_BANDS = ("few_runs", "one_run", "one_way")


def of_waivers(said):
    """The lines on standard error that are about waivers."""
    return "".join(line for line in said.splitlines(keepends=True) if "measured with" in line)


def recording(**options):
    """Enough temperatures for a fit."""
    return recording_of(plateaus=tuple(float(t) for t in range(-20, 60, 5)), seconds=40, **options)


class ReferenceTest(SoakTest):
    def add(self, kind="chamber_probe", name="probe 3", certificate="D-K-15048", issued=-400, due=100, uncertainty=0.05, *more):
        return self.soak_json("reference-list", "reference", "add", "--kind", kind, "--name", name, "--certificate", certificate,
                              "--issued", day(issued), "--due", day(due), "--uncertainty", uncertainty, *more)["references"][0]

    def entries(self, *arguments):
        return self.soak_json("reference-list", "reference", *arguments)["references"]

    def key(self, name="head.key"):
        self.soak("key", "new", "-o", self.folder / name)
        return self.folder / name

    def waive(self, key, *more, kind="chamber_probe", name="probe 3"):
        return self.soak_json("reference-list", "reference", "waive", "--kind", kind, "--name", name, "--reason",
                              "the new one is ordered", "--signer", "Ann Example", "--key", key, *more)["references"][0]

    def execute(self, sql):
        database = open_catalog(self.data / "station.db")
        with database:
            database.execute(sql)
        database.close()


class Register(ReferenceTest):
    def test_an_entry_comes_back_in_the_units_of_people(self):
        entry = self.add("fixture_squareness", "cube", "7/2026", -10, 355, 0.02, "--user", "bob")
        self.assertEqual((entry["unit"], entry["user"], entry["standing"]), ("deg", "bob", "valid"))
        self.assertAlmostEqual(entry["standard_uncertainty"], 0.01, delta=1e-15)
        self.assertEqual((entry["issued"], entry["due"]), (day(-10), day(355)))
        self.assertIn(entry["days_left"], (354, 355))  # midnight may pass
        probe = self.add("chamber_probe", "probe 3", "D-K", -10, 355, 0.06, "--k", 3, "--correction", "-0.02")
        self.assertAlmostEqual(probe["standard_uncertainty"], 0.02, delta=1e-15)
        self.assertEqual(probe["correction"], -0.02)
        self.assertEqual(self.entries("list"), [probe, entry])
        self.assertIn("0.01 deg", self.soak("reference", "list").stdout)

    def test_the_catalog_holds_si(self):
        self.add("level", "level 1", "L-1", -10, 355, 0.1, "--correction", 0.5)
        database = sqlite3.connect(self.data / "station.db")
        uncertainty, correction = database.execute("SELECT standard_uncertainty, correction FROM reference").fetchone()
        database.close()
        self.assertAlmostEqual(uncertainty, math.radians(0.05), delta=1e-17)
        self.assertAlmostEqual(correction, math.radians(0.5), delta=1e-16)

    def test_list_shows_one_line_per_reference_and_what_is_due(self):
        self.add(name="old", due=-3)
        self.add(name="soon", due=20)
        self.add(name="good", due=200)
        self.add(name="good", certificate="older", issued=-800, due=-500)
        self.add(name="lost")
        self.soak("reference", "retire", "--kind", "chamber_probe", "--name", "lost", "--reason", "lost")
        standing = {e["name"]: (e["standing"], e["certificate"]) for e in self.entries("list")}
        self.assertEqual(standing, {"old": ("expired", "D-K-15048"), "soon": ("due_soon", "D-K-15048"),
                                    "good": ("valid", "D-K-15048"), "lost": ("retired", "D-K-15048")})
        text = self.soak("reference", "list").stdout
        self.assertEqual(len(text.splitlines()), 5)

    def test_show_gives_the_history(self):
        self.add(certificate="A", issued=-800, due=-400)
        self.add(certificate="B", issued=-420, due=20)
        self.assertEqual([(e["certificate"], e["standing"]) for e in self.entries("show", "--kind", "chamber_probe", "--name", "probe 3")],
                         [("B", "due_soon"), ("A", "superseded")])
        self.refusal("reference", "show", "--kind", "level", "--name", "probe 3")

    def test_retire_keeps_reason_and_user(self):
        self.add()
        arguments = ("reference", "retire", "--kind", "chamber_probe", "--name", "probe 3", "--reason", "dropped", "--user", "bob")
        entry = self.soak_json("reference-list", *arguments)["references"][0]
        self.assertEqual((entry["retired"]["reason"], entry["retired"]["user"]), ("dropped", "bob"))
        self.refusal(*arguments)

    @long_test
    def test_a_wrong_entry_is_withdrawn_and_the_certificate_entered_again(self):
        self.add(certificate="C", issued=-10, due=-3)
        name = ("--kind", "chamber_probe", "--name", "probe 3")
        self.add(certificate="C", issued=-100, due=100)
        self.assertEqual(self.entries("list")[0]["standing"], "expired")  # the later day of issue counts
        entry = self.soak_json("reference-list", "reference", "withdraw", *name, "--reason", "day of issue mistyped",
                               "--user", "bob")["references"][0]
        self.assertEqual((entry["standing"], entry["withdrawn"]["user"], entry["withdrawn"]["reason"]),
                         ("withdrawn", "bob", "day of issue mistyped"))
        self.assertEqual([(e["issued"], e["standing"]) for e in self.entries("show", *name)],
                         [(day(-100), "valid"), (day(-10), "withdrawn")])
        self.assertEqual([e["standing"] for e in self.entries("list")], ["valid"])
        self.assertRegex(self.soak("reference", "show", *name).stdout, rf"withdrawn.*{day(0)[:4]}")
        self.refusal("reference", "withdraw", *name, "--certificate", "Z", "--reason", "x")
        self.refusal("reference", "withdraw", *name, "--reason", "a\u2029b")

    @long_test
    def test_an_entry_after_the_retirement_brings_the_reference_back(self):
        self.add()
        name = ("--kind", "chamber_probe", "--name", "probe 3")
        self.soak("reference", "retire", *name, "--reason", "lost")
        self.assertEqual(self.entries("list")[0]["standing"], "retired")
        self.add()
        self.assertEqual([e["standing"] for e in self.entries("show", *name)], ["valid", "retired"])
        self.assertEqual(self.entries("list")[0]["standing"], "valid")

    def test_the_due_day_itself_has_expired(self):
        self.add(name="yesterday", due=-1)
        self.add(name="today", due=0)
        self.add(name="tomorrow", due=1)
        self.assertEqual({e["name"]: (e["days_left"], e["standing"]) for e in self.entries("list")},
                         {"yesterday": (-1, "expired"), "today": (0, "expired"), "tomorrow": (1, "due_soon")})
        self.assertEqual(len(self.soak("reference", "list").stdout.splitlines()), 4)

    def test_nonsense_is_refused_and_leaves_nothing(self):
        good = {"--kind": "chamber_probe", "--name": "p", "--certificate": "c", "--issued": day(-10), "--due": day(300),
                "--uncertainty": "0.1"}
        cases = [("--kind", "hourglass"), ("--name", " "), ("--name", "a\nb"), ("--name", "a\u2028b"), ("--name", "a\u202eb"),
                 ("--certificate", "a\u0085b"), ("--name", "\udcff"), ("--certificate", "x" * 256), ("--issued", "yesterday"),
                 ("--issued", "2026-02-30"), ("--issued", day(3)), ("--due", day(-10)), ("--due", ""), ("--uncertainty", "0"),
                 ("--uncertainty", "-1"), ("--uncertainty", "nan"), ("--uncertainty", "50"), ("--k", "0.5"), ("--k", "nan"),
                 ("--correction", "300"), ("--correction", "inf"), ("--user", "a\nb")]
        for option, value in cases:
            with self.subTest(option=option, value=value):
                arguments = [x for pair in {**good, option: value}.items() for x in pair]
                self.assertEqual(self.refusal("reference", "add", *arguments)["where"], option)
        for kind, more in (("gravity", []), ("gravity", ["--correction", "9.2"]), ("fixture_squareness", ["--correction", "0"])):
            arguments = [x for pair in {**good, "--kind": kind}.items() for x in pair]
            self.assertEqual(self.refusal("reference", "add", *arguments, *more)["where"], "--correction")
        self.refusal("reference", "add", "--kind", "level")
        self.assertIsNone(self.state(), "not even a data folder")

    @long_test
    def test_the_same_entry_twice_is_refused(self):
        self.add()
        arguments = ("--kind", "chamber_probe", "--name", "probe 3", "--certificate", "D-K-15048", "--issued", day(-400), "--due", day(100))
        self.refusal("reference", "add", *arguments, "--uncertainty", 0.05)
        self.soak("reference", "add", *arguments, "--uncertainty", 0.06)

    def test_an_expired_certificate_may_be_entered_and_is_remarked_upon(self):
        done = self.soak("reference", "add", "--kind", "level", "--name", "l", "--certificate", "c", "--issued", day(-500), "--due", day(-1),
                         "--uncertainty", 0.1)
        self.assertIn("warning: ", done.stderr)


class Waivers(ReferenceTest):
    def test_a_waiver_is_what_the_documentation_says(self):
        key = self.key()
        entry = self.add(due=-3)
        entry = self.waive(key)
        waiver = entry["waivers"][0]
        self.assertTrue(waiver["good"])
        self.assertEqual(waiver["utc_s"], int(waiver["utc_s"]))
        signed = datetime.datetime.fromtimestamp(waiver["utc_s"], datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
        text = (f"soak-waiver-1\nwaiver {waiver['waiver_id']}\nreference {entry['record_id']}\nkind chamber_probe\nname probe 3\n"
                f"certificate D-K-15048\ndue {entry['due']}T00:00:00Z\nreason the new one is ordered\nsigner Ann Example\nsigned {signed}\n")
        public = bytes.fromhex(pathlib.Path(f"{key}.pub").read_text(encoding="utf-8").splitlines()[1])
        self.assertEqual(waiver["public_key"], public.hex())
        self.assertTrue(ed25519.verify(public, text.encode(), bytes.fromhex(waiver["signature"])))
        self.assertIn("Ann Example", self.soak("reference", "list").stdout)

    def test_the_waiver_in_the_golden_file_is_signed(self):
        first, second = Calibration.load((GOLDEN / "referenced.soakcal").read_bytes()).references
        self.assertEqual((first.kind, first.name, first.standard_uncertainty, first.correction, first.waiver),
                         ("chamber_probe", "probe 3", 0.025, -0.02, None))
        self.assertEqual((second.kind, second.correction, second.waiver.signer), ("fixture_squareness", None, "Ann Example"))
        self.assertTrue(ed25519.verify(second.waiver.public_key, second.waiver_text(), second.waiver.signature))
        self.assertFalse(ed25519.verify(second.waiver.public_key, second.waiver_text() + b" ", second.waiver.signature))

    def test_what_needs_none_gets_none(self):
        key = self.key()
        self.add(due=100)
        arguments = ("reference", "waive", "--kind", "chamber_probe", "--name", "probe 3", "--reason", "x", "--key", key)
        self.refusal(*arguments)
        self.refusal(*arguments, "--certificate", "Z")
        self.add(certificate="old", issued=-900, due=-500)
        self.assertEqual(self.waive(key, "--certificate", "old")["certificate"], "old")
        self.soak("reference", "retire", "--kind", "chamber_probe", "--name", "probe 3", "--reason", "lost")
        self.refusal(*arguments)

    def test_it_takes_a_secret_key_and_a_reason(self):
        key = self.key()
        self.add(due=-3)
        arguments = ("reference", "waive", "--kind", "chamber_probe", "--name", "probe 3")
        self.refusal(*arguments, "--reason", "x", "--key", f"{key}.pub")
        self.refusal(*arguments, "--reason", " ", "--key", key)
        self.refusal(*arguments, "--reason", "two\nlines", "--key", key)
        self.refusal(*arguments, "--key", key)
        self.assertEqual(self.entries("list")[0]["waivers"], [])

    def test_a_damaged_one_is_shown_as_such(self):
        self.add(due=-3)
        self.waive(self.key())
        self.execute("DROP TRIGGER waiver_keeps_rows")
        self.execute("UPDATE waiver SET reason = 'because'")
        self.assertFalse(self.entries("list")[0]["waivers"][0]["good"])
        self.assertIn("DAMAGED", self.soak("reference", "list").stdout)


class OnTheWayToTheFile(ReferenceTest):
    def fitted(self):
        return self.soak_json("fit", "fit", "--unit", "SN1", "--rules", 2)

    def exported(self, *arguments):
        path = self.folder / "SN1.soakcal"
        done = self.soak("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", path, *arguments)
        return path, done.stderr

    def test_an_import_takes_references_only_when_asked(self):
        self.add()
        self.imported("a.csv", recording())
        self.assertEqual(self.fitted()["references"], [])
        path, _ = self.exported()
        self.assertEqual(Calibration.load(path.read_bytes()).references, [])
        again = self.soak_json("import", "import", self.folder / "a.csv", "--unit", "SN1", "--references")
        self.assertEqual(again["runs"][0]["status"], "unchanged")
        self.assertEqual([r["name"] for r in again["references"]], ["probe 3"])
        self.assertEqual(self.entries("list")[0]["campaigns"], ["default"])
        self.assertEqual([r["certificate"] for r in self.fitted()["references"]], ["D-K-15048"])

    def test_an_expired_one_blocks_the_import_unless_somebody_signs(self):
        self.add(due=-3)
        path = self.write("a.csv", recording())
        error = self.refusal("import", path, "--unit", "SN1", "--references")
        for part in ("probe 3", "D-K-15048", day(-3), "soak reference add", "soak reference waive"):
            self.assertIn(part, error["message"])
        self.assertEqual(list((self.data / "runs").glob("*")), [])
        self.waive(self.key())
        document = self.soak_json("import", "import", path, "--unit", "SN1", "--references")
        self.assertEqual(document["references"][0]["waiver"]["signer"], "Ann Example")
        self.assertTrue(any("Ann Example" in w for w in document["warnings"]))

    @long_test
    def test_the_time_of_the_measurement_decides_where_the_file_knows_it(self):
        self.add(issued=-800, due=-400)
        lines = recording().splitlines()
        start = datetime.datetime.now(datetime.timezone.utc).timestamp() - 500 * DAY_S
        rows = [lines[0] + ",utc_s"] + [f"{line},{start + float(line.split(',')[0]):.3f}" for line in lines[1:]]
        path = self.write("old.csv", "\n".join(rows) + "\n")
        self.refusal("import", self.write("now.csv", recording()), "--unit", "SN1", "--references")
        document = self.soak_json("import", "import", path, "--unit", "SN1", "--references")
        self.assertEqual([(r["name"], r["waiver"]) for r in document["references"]], [("probe 3", None)])

    def test_the_file_carries_them_and_says_so(self):
        self.add()
        self.add("fixture_squareness", "cube", "7/2025", -400, -3, 0.02)
        key = self.key()
        self.waive(key, kind="fixture_squareness", name="cube")
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        document = self.fitted()
        path, said = self.exported()
        said = of_waivers(said)
        self.assertEqual(said.count("\n"), 1)
        for part in ("warning", "cube", day(-3), "Ann Example", "the new one is ordered"):
            self.assertIn(part, said)
        for arguments in (("eval", path, "--temp-c", "20"), ("eval", path, "--temp-c", "20", "--json")):
            self.assertEqual(of_waivers(self.soak(*arguments).stderr), said)
        probe, cube = Calibration.load(path.read_bytes()).references
        self.assertEqual((probe.kind, probe.certificate, probe.waiver), ("chamber_probe", "D-K-15048", None))
        self.assertAlmostEqual(cube.standard_uncertainty, math.radians(0.01), delta=1e-17)
        self.assertTrue(ed25519.verify(cube.waiver.public_key, cube.waiver_text(), cube.waiver.signature))
        self.soak("export", "--unreleased", "--unit", "SN1", "--format", "json", "-o", self.folder / "SN1.json")
        calibration = json.loads((self.folder / "SN1.json").read_text(encoding="utf-8"))
        check_schema(calibration, "calibration")
        self.assertEqual(calibration["references"], document["references"])
        self.soak("key", "sign", path, "--key", key)
        self.assertIn(said, self.soak("key", "verify", path, "--key", f"{key}.pub").stderr)
        self.assertEqual(len(Calibration.load(path.read_bytes()).references), 2)

    def test_a_damaged_waiver_stops_the_fit(self):
        self.add(due=-3)
        self.waive(self.key())
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        self.execute("DROP TRIGGER waiver_keeps_rows")
        self.execute("UPDATE waiver SET signer = 'Bob'")
        self.refusal("fit", "--unit", "SN1", "--rules", 2, status=4)
        self.refusal("import", self.write("b.csv", recording(seed=2, run="r2")), "--unit", "SN1", "--references", status=4)

    @long_test
    def test_a_waiver_that_is_gone_stops_the_fit(self):
        self.add(due=-3)
        self.waive(self.key())
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        self.execute("PRAGMA foreign_keys = OFF")
        self.execute("DROP TRIGGER waiver_keeps_all")
        self.execute("DELETE FROM waiver")
        self.refusal("fit", "--unit", "SN1", "--rules", 2, status=4)

    @long_test
    def test_a_new_waiver_heals_what_a_damaged_one_stopped(self):
        self.add(due=-3)
        self.waive(self.key())
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        self.execute("DROP TRIGGER waiver_keeps_rows")
        self.execute("UPDATE waiver SET signer = 'Bob'")
        self.refusal("fit", "--unit", "SN1", "--rules", 2, status=4)
        self.waive(self.key("other.key"))
        self.assertEqual(self.fitted()["references"][0]["waiver"]["signer"], "Ann Example")

    @long_test
    def test_a_waiver_in_the_file_whose_signature_does_not_fit_is_told(self):
        self.add(due=-3)
        self.waive(self.key())
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        self.soak("import", self.write("v.csv", recording(seed=9, run="v")), "--unit", "SN1", "--campaign", "v",
                  "--procedure", "verification")
        self.fitted()
        path, _ = self.exported()
        good = self.soak_json("eval", "eval", path, "--temp-c", "20")
        self.assertEqual([w for w in good["warnings"] if w["code"] not in OF_BANDS], [])
        content = bytearray(path.read_bytes())
        at = content.index(b"the new one is ordered")
        content[at:at + 3] = b"THE"
        path.write_bytes(with_crc(content))
        for name, arguments in (("eval", ("eval", path, "--temp-c", "20")), ("verify", ("verify", path, "--campaign", "v"))):
            done = self.soak(*arguments, "--json")
            document = json.loads(done.stdout)
            check_schema(document, name)
            warning, = [w for w in document["warnings"] if w["code"] == "waiver_signature"]
            self.assertIn("Ann Example", warning["text"])
            self.assertEqual(done.stderr.count(warning["text"]), 1)
            self.assertEqual(self.soak(*arguments).stderr.count(warning["text"]), 1)

    def test_each_run_of_a_file_is_judged_by_the_certificate_of_its_own_time(self):
        self.add(certificate="A", issued=-800, due=-400)
        self.add(certificate="B", issued=-390, due=100)
        now = datetime.datetime.now(datetime.timezone.utc).timestamp()
        rows = []
        for label, offset in (("r1", -500), ("r2", -300)):
            lines = recording(seed=offset, run=label).splitlines()
            rows = rows or [lines[0] + ",utc_s"]
            rows += [f"{line},{now + offset * DAY_S + float(line.split(',')[0]):.3f}" for line in lines[1:]]
        document = self.soak_json("import", "import", self.write("two.csv", "\n".join(rows) + "\n"), "--unit", "SN1", "--references")
        self.assertEqual([r["certificate"] for r in document["references"]], ["A", "B"])

    @long_test
    def test_a_retired_or_withdrawn_reference_of_an_old_campaign_is_told_with_its_status(self):
        self.add()
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        self.soak("reference", "retire", "--kind", "chamber_probe", "--name", "probe 3", "--reason", "dropped in May")
        document = self.fitted()
        self.assertEqual([r["certificate"] for r in document["references"]], ["D-K-15048"])
        warning, = [w for w in document["warnings"] if w["code"] == "reference_retired"]
        self.assertIn("dropped in May", warning["text"])
        page = self.folder / "page.html"
        report = self.soak_json("report", "report", "--unit", "SN1", "-o", page)
        reference, = report["sections"]["records"]["references"]
        self.assertRegex(reference["since"], "^retired on .* dropped in May$")
        self.assertIn("dropped in May", page.read_text(encoding="utf-8"))

    @long_test
    def test_a_later_certificate_changes_nothing_of_an_older_campaign(self):
        self.add(certificate="A")
        self.soak("import", self.write("a.csv", recording()), "--unit", "SN1", "--references")
        self.add(certificate="B", issued=-1)
        self.assertEqual([r["certificate"] for r in self.fitted()["references"]], ["A"])
        self.soak("import", self.write("b.csv", recording(seed=2, run="r2")), "--unit", "SN1", "--references", "--campaign", "second")
        self.assertEqual([r["certificate"] for r in self.fitted()["references"]], ["A", "B"])


class WithdrawnSince(ReferenceTest):
    """A model and a file that rest on what was withdrawn after the fit."""

    def setUp(self):
        super().setUp()
        self.add("level", "level 1", "L-1")
        for seed in (1, 2):
            self.soak("import", self.write(f"{seed}.csv", recording(seed=seed, run=f"r{seed}")), "--unit", "SN1", "--references")
        self.soak("import", self.write("v.csv", recording(seed=9, run="v")), "--unit", "SN1", "--campaign", "check",
                  "--procedure", "verification")
        self.soak("runs", "void", "r2", "--visit", 3, "--reason", "known before the fit")
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        self.blob = self.folder / "before.soakcal"
        self.assertEqual(self.told("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", self.blob), {})

    def told(self, command, *arguments):
        """The warnings of a command by their codes, without those of the bands; on standard error all, each once."""
        document = self.soak_json(command, command, *arguments)
        warnings = {w["code"]: w["text"] for w in document["warnings"]}
        said = self.soak(command, *arguments).stderr
        for text in warnings.values():
            self.assertEqual(said.count(text), 1, said)
        return {code: text for code, text in warnings.items() if code not in OF_BANDS}

    def export(self):
        return self.told("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", self.folder / "x.soakcal")

    def verify(self):
        told = self.told("verify", self.blob, "--campaign", "check")
        return {code: text for code, text in told.items() if code.endswith("_since") or code.startswith("reference")}

    def test_runs_are_named_by_export_and_by_verify_of_the_file(self):
        self.assertEqual(self.verify(), {})
        self.soak("runs", "void", "r1", "--reason", "fixture was loose")
        self.assertEqual(list(self.export()), ["voided_since"])
        self.assertIn("r1", self.export()["voided_since"])
        self.assertNotIn("r2", self.export()["voided_since"])
        self.soak("runs", "void", "r2", "--visit", 5, "--position", "+X", "--reason", "door opened")
        self.assertIn("r1, r2", self.verify()["voided_since"])
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        self.assertEqual(self.export(), {}, "the new model does without them")
        self.assertIn("r1, r2", self.verify()["voided_since"], "the old file does not")
        self.assertIn("r1", self.told("export", "--unreleased", "--unit", "SN1", "--model", 1, "--format", "c", "-o", self.folder / "x.h")["voided_since"])

    @long_test
    def test_a_run_that_was_imported_anew_in_the_place_of_a_void_one_is_the_models(self):
        self.soak("runs", "void", "r1", "--reason", "gravity was forgotten")
        self.soak("import", self.folder / "1.csv", "--unit", "SN1", "--campaign", "anew", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        self.assertEqual(self.export(), {})
        report = self.soak_json("report", "report", "--unit", "SN1", "-o", self.folder / "page.html")
        use = {(r["campaign"], r["label"]): r["use"] for r in report["sections"]["provenance"]["runs"]}
        self.assertEqual((use["default", "r1"], use["anew", "r1"]), ("voided", "fitted"))
        self.soak("runs", "void", "r1", "--campaign", "anew", "--reason", "fixture was loose")
        self.assertIn("r1", self.export()["voided_since"])

    @long_test
    def test_references_are_named_though_the_fresh_campaign_has_none(self):
        self.soak("reference", "withdraw", "--kind", "level", "--name", "level 1", "--reason", "mistyped")
        for told in (self.export(), self.verify()):
            self.assertEqual(list(told), ["reference_withdrawn"])
            self.assertIn("mistyped", told["reference_withdrawn"])
        self.add("level", "level 1", "L-1", -300)
        self.assertEqual(list(self.export()), ["reference_withdrawn"])
        self.soak("fit", "--unit", "SN1", "--rules", 2)
        self.assertEqual(self.export(), {})

    @long_test
    def test_an_expired_reference_is_named_until_a_newer_certificate_is_there(self):
        for trigger in ("keeps_rows", "keeps_all"):
            self.execute(f"DROP TRIGGER reference_{trigger}")
        yesterday = datetime.datetime.now(datetime.timezone.utc).timestamp() - DAY_S
        self.execute(f"UPDATE reference SET due_utc_s = {yesterday}")
        for told in (self.export(), self.verify()):
            self.assertEqual(list(told), ["reference_expired"])
            self.assertIn("level 1", told["reference_expired"])
        self.add("level", "level 1", "L-2", -1)
        self.assertEqual((self.export(), self.verify()), ({}, {}))


class EpochsAndVoids(ReferenceTest):
    """What else decides which runs a fit takes (docs/records.md)."""

    def labels(self, document):
        return sorted({label for sensor in document["sensors"].values() for label in sensor["runs"]})

    def fitted(self):
        return self.soak_json("fit", "fit", "--unit", "SN1", "--rules", 2)

    def test_a_fit_takes_the_runs_of_the_present_epoch_that_nobody_withdrew(self):
        for seed in (1, 2):
            self.imported(f"{seed}.csv", recording(seed=seed, run=f"r{seed}"))
        self.assertEqual(self.labels(self.fitted()), ["r1", "r2"])
        self.soak("runs", "void", "r1", "--reason", "fixture was loose")
        self.assertEqual(self.labels(self.fitted()), ["r2"])
        self.soak("unit", "add", "SN1", "--begin-epoch", "gyro replaced")
        self.refusal("fit", "--unit", "SN1")
        export = ("export", "--unreleased", "--unit", "SN1", "--format", "blob", "-o", self.folder / "x.soakcal")
        self.refusal(*export)
        self.imported("3.csv", recording(seed=3, run="r3"))
        self.assertEqual(self.labels(self.fitted()), ["r3"])
        self.soak(*export)


if __name__ == "__main__":
    unittest.main()
