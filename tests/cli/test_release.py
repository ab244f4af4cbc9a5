# SPDX-License-Identifier: Apache-2.0
"""From a verdict to the folder that is handed over: what `soak verify` stores, which models `soak release` lets go, how what is not
released is marked, and what the signed manifest promises."""
import contextlib
import hashlib
import json
import os
import pathlib
import signal
import subprocess
import tarfile
import time
import unittest

import ed25519
import test_fit
from blob_reader import Calibration
from run_digest import open_catalog
from soak_cli import check_schema, limit_file_size, long_test, recording
from test_fit import SERIAL, FittedTest, fitted_folder

WIDE = "[limits]\ngyro = 0.2\naccel = 0.2\n"
NARROW = "[limits]\ngyro = 0.0001\naccel = 0.2\n"


def tearDownModule():
    test_fit.tearDownModule()


class ReleaseTest(FittedTest):
    def verify(self, limits=WIDE, *arguments, status=0, what=("--unit", SERIAL)):
        path = self.write("limits.toml", limits)
        done = self.soak("verify", *what, "--campaign", "verification", "--limits", path, *arguments, "--json", status=status)
        document = json.loads(done.stdout)
        check_schema(document, "verify")
        return document

    def released(self):
        self.verify()
        self.soak("release", "--unit", SERIAL, "--user", "eva")

    def shown(self, *arguments):
        return self.soak_json("model-show", "model", "show", "--unit", SERIAL, *arguments)

    def enter(self, statement, *values):
        """Writes into the catalog what the commands would not."""
        with contextlib.closing(open_catalog(self.data / "station.db")) as catalog, catalog:
            catalog.execute(statement, values)

    def enter_record(self, unit, document):
        """A later verification of model 1 that passed."""
        self.enter("INSERT INTO verification VALUES (?, ?, 1, ?, 'ann', 'pass', ?)", f"f{time.monotonic_ns():020d}", unit, time.time(), document)

    def export(self, name, form="blob", *arguments):
        path = self.folder / name
        self.soak_json("export", "export", "--unit", SERIAL, "--format", form, "--simulated", *arguments, "-o", path)
        return path


class Verdicts(ReleaseTest):
    def test_a_pass_makes_a_model_verified_and_a_fail_takes_that_back(self):
        self.assertEqual(self.shown()["state"], "fitted")
        passed = self.verify()
        self.assertEqual((passed["verdict"], passed["stored"], passed["state"]), ("pass", True, "verified"))
        failed = self.verify(NARROW, status=5)
        self.assertEqual((failed["verdict"], failed["stored"], failed["state"]), ("fail", True, "fitted"))
        shown = self.shown()
        self.assertEqual([row["state"] for row in shown["history"]], ["fitted", "verified", "fitted"])
        self.assertEqual([row["verdict"] for row in shown["verifications"]], ["pass", "fail"])

    def test_the_record_holds_limits_runs_and_program(self):
        printed = self.verify()
        stored = self.shown()["verifications"][0]["document"]
        self.assertEqual(stored, {key: value for key, value in printed.items() if key not in ("stored", "state")})
        runs = self.soak_json("runs-list", "runs", "list", "--campaign", "verification")["runs"]
        self.assertEqual([run["run_id"] for run in stored["runs"]], [run["run_id"] for run in runs])
        self.assertEqual(stored["sensors"]["gyro_x"]["limit"], 0.2)
        self.assertIn(stored["software"], self.soak("--version").stdout)

    def test_a_file_is_known_again_whatever_its_mark_and_signature(self):
        self.soak("key", "new", "-o", self.folder / "lab.key")
        file = self.export("marked.soakcal", "blob", "--unreleased", "--sign", self.folder / "lab.key")
        self.assertTrue(self.verify(what=(file,))["stored"])

    def test_what_is_no_whole_model_of_the_folder_is_judged_and_not_stored(self):
        table = self.export("table.soakcal", "blob", "--unreleased", "--table", 64)
        document = self.verify(what=(table,))
        self.assertEqual((document["verdict"], document["stored"], document["state"]), ("pass", False, None))
        self.assertEqual(self.shown()["verifications"], [])

    def test_all_units_of_a_campaign_are_verified(self):
        document = self.soak_json("verify-all", "verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE))
        self.assertEqual([(one["unit"], one["state"]) for one in document["units"]], [(SERIAL, "verified")])
        failed = self.soak("verify", "--all", "--campaign", "verification", "--limits", self.write("n", NARROW), status=5)
        self.assertIn(f"1 of 1 units exceed their limits: {SERIAL}", failed.stderr)

    def second_unit(self, *labs):
        """Of the same recordings."""
        for lab, procedure in labs or (("campaign", "import"), ("verification", "verification")):
            self.soak("import", fitted_folder() / "lab" / lab / f"{SERIAL}.csv", "--unit", "SN1", "--campaign", lab, "--procedure",
                      procedure, "--simulated", "--gravity-mps2", "9.80665")

    def verify_all(self, *more):
        document = self.soak_json("verify-all", "verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE), *more)
        check_schema(document, "verify-all")
        return document

    def test_a_unit_without_a_model_is_left_out_with_a_line_of_its_own(self):
        self.second_unit()
        document = self.verify_all()
        self.assertEqual([one["unit"] for one in document["units"]], [SERIAL])
        self.assertEqual(document["skipped"], [{"unit": "SN1", "message": "it has no model yet"}])
        done = self.soak("verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE))
        self.assertIn("SN1: left out: it has no model yet", done.stderr)

    @long_test
    def test_a_unit_that_was_repaired_since_is_left_out(self):
        self.second_unit()
        self.soak("fit", "--unit", "SN1")
        self.soak("unit", "add", "SN1", "--begin-epoch", "gyro replaced")
        self.assertEqual(self.verify_all()["skipped"], [{"unit": "SN1", "message": "it was repaired or changed after its newest model"}])
        self.soak("unit", "add", SERIAL, "--begin-epoch", "gyro replaced")
        failed = self.soak("verify", "--all", "--campaign", "verification", status=2)
        self.assertIn("no unit of the campaign can be verified", failed.stderr)

    @long_test
    def test_a_unit_that_cannot_be_verified_keeps_no_other_from_it(self):
        self.second_unit()
        self.soak("fit", "--unit", "SN1")
        run = next(one for one in self.soak_json("runs-list", "runs", "list", "--campaign", "verification")["runs"] if one["unit"] == "SN1")
        self.soak("runs", "void", run["run_id"], "--unit", "SN1", "--reason", "door")
        kept = self.folder / "kept"
        done = self.soak("verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE), "--keep", kept, "--json", status=2)
        document = json.loads(done.stdout)
        check_schema(document, "verify-all")
        self.assertEqual([one["unit"] for one in document["units"]], [SERIAL])
        (one,) = document["not_verified"]
        self.assertEqual(one["unit"], "SN1")
        self.assertIn("no usable run", one["message"])
        self.assertIn("1 of 2 units could not be verified", json.loads(done.stderr)["error"]["message"])
        lines = [json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines()]
        self.assertEqual([line for line in lines if "units" in line], [{"units": one} for one in document["units"]])
        self.assertEqual([line for line in lines if "not_verified" in line], [{"not_verified": one} for one in document["not_verified"]])

    @long_test
    def test_one_of_all_that_is_interrupted_prints_what_it_came_to(self):
        self.second_unit()
        self.soak("fit", "--unit", "SN1")
        words = ("verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE), "--json")
        with contextlib.closing(open_catalog(self.data / "station.db")) as catalog:
            catalog.isolation_level = None
            catalog.execute("BEGIN IMMEDIATE")  # the first verdict waits here
            process = subprocess.Popen(self.command(*words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "SOAK_PROGRESS": "1"})
            self.assertIn("verifying: 0 %", process.stderr.readline())
            used = None
            while used != (used := pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]):
                time.sleep(0.3)  # until it does nothing but wait
            process.terminate()
            catalog.execute("ROLLBACK")
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        document = json.loads(out)
        check_schema(document, "verify-all")
        self.assertEqual(len(document["units"]), 1)
        self.assertIn("interrupted", err)


class Marks(ReleaseTest):
    def test_what_is_not_released_is_refused_with_the_way_to_a_release(self):
        error = self.refusal("export", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", self.folder / "x")
        for part in ("fitted, not released", "soak verify", f"soak release --unit {SERIAL}", "--unreleased"):
            self.assertIn(part, error["message"])
        self.assertFalse((self.folder / "x").exists())

    def test_every_format_says_that_it_is_not_released_until_it_is(self):
        for is_released in (False, True):
            if is_released:
                self.released()
            more = () if is_released else ("--unreleased",)
            blob = Calibration.load(self.export("u.soakcal", "blob", *more).read_bytes())
            self.assertEqual(blob.unreleased, not is_released)
            document = json.loads(self.export("u.json", "json", *more).read_text(encoding="utf-8"))
            check_schema(document, "calibration")
            self.assertEqual(document["unreleased"], not is_released)
            for form in ("c", "px4", "ardupilot"):
                text = self.export(f"u.{form}", form, *more).read_text(encoding="utf-8")
                self.assertEqual("NOT RELEASED" in text, not is_released, form)
                self.assertEqual("SOAK_ACCEPT_UNRELEASED" in text, form == "c" and not is_released)

    @long_test
    def test_a_newer_model_does_not_hide_the_released_one(self):
        self.released()
        self.soak("fit", "--unit", SERIAL)
        error = self.refusal("export", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", self.folder / "x")
        self.assertIn("--model 1", error["message"])
        self.assertFalse(Calibration.load(self.export("old.soakcal", "blob", "--model", 1).read_bytes()).unreleased)

    @long_test
    def test_who_looks_at_a_file_is_told_that_it_is_not_released(self):
        self.soak("key", "new", "-o", self.folder / "lab.key")
        for is_released in (False, True):
            if is_released:
                self.released()
            more = () if is_released else ("--unreleased",)
            file = self.export("u.soakcal", "blob", "--sign", self.folder / "lab.key", *more)
            for schema, arguments in (("key-verify", ("key", "verify", file, "--key", self.folder / "lab.key.pub")),
                                      ("eval", ("eval", file, "--temp-c", 25))):
                document = json.loads(subprocess.run([os.environ["SOAK_BIN"], *map(str, arguments), "--json"], capture_output=True, text=True,
                                                     check=True).stdout)
                check_schema(document, schema)
                self.assertEqual((document["simulated"], document["unreleased"]), (True, not is_released))
                printed = subprocess.run([os.environ["SOAK_BIN"], *map(str, arguments)], capture_output=True, text=True, check=True).stdout
                self.assertIn("(SIMULATED)" if is_released else "(SIMULATED, NOT RELEASED)", printed)

    @long_test
    def test_a_released_model_that_breaks_the_rule_now_is_refused_or_marked(self):
        self.released()
        run = self.soak_json("runs-list", "runs", "list", "--campaign", "campaign")["runs"][0]
        self.soak("runs", "void", run["run_id"], "--unit", SERIAL, "--reason", "door")
        error = self.refusal("export", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", self.folder / "x")
        for part in ("does not keep the rule", "withdrawn, whole or in part", "--unreleased"):
            self.assertIn(part, error["message"])
        self.assertTrue(Calibration.load(self.export("marked.soakcal", "blob", "--unreleased").read_bytes()).unreleased)


class Rule(ReleaseTest):
    def refused(self, *parts):
        error = self.refusal("release", "--unit", SERIAL)
        self.assertEqual(error["where"], SERIAL)
        for part in parts:
            self.assertIn(part, error["message"])

    def test_only_what_passed_is_released(self):
        self.refused("never verified", f"soak verify --unit {SERIAL}")
        self.verify(NARROW, status=5)
        self.refused("campaign 'verification'", "says fail")
        self.verify()
        document = self.soak_json("release", "release", "--unit", SERIAL, "--user", "eva")["units"][0]
        self.assertEqual((document["state"], document["expires"], document["obstacles"]), ("released", None, []))
        last = self.shown()["history"][-1]
        self.assertEqual((last["state"], last["user"]), ("released", "eva"))
        kinds = [event["kind"] for event in self.soak_json("events-list", "events", "list", "--user", "eva")["events"]]
        self.assertEqual(kinds, ["model_released"])

    def test_a_release_does_not_outlive_a_verification_that_fails(self):
        self.released()
        self.verify(NARROW, status=5)
        self.refused("says fail")
        self.verify()
        error = self.refusal("export", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", self.folder / "x")
        self.assertIn(f"after its release, said fail: release it again ('soak release --unit {SERIAL}')", error["message"])
        self.assertIn("release it again", self.refusal("export", "--all", "--released", "--out", self.folder / "out", "--sign", self.key(), "--simulated")["message"])
        document = self.soak_json("release", "release", "--unit", SERIAL, "--user", "nora")["units"][0]
        self.assertEqual((document["state"], document["obstacles"]), ("released", []))
        self.assertEqual([row["user"] for row in self.shown()["history"] if row["state"] == "released"], ["eva", "nora"])
        self.export("again.soakcal")
        self.soak("release", "--unit", SERIAL, "--user", "ann")  # it stays as it is
        self.assertEqual(self.shown()["history"][-1]["user"], "nora")

    def key(self):
        self.soak("key", "new", "-o", self.folder / "lab.key")
        return self.folder / "lab.key"

    def interrupted(self, *words):
        """What a command prints that is interrupted where it would enter its first release."""
        with contextlib.closing(open_catalog(self.data / "station.db")) as catalog:
            catalog.isolation_level = None
            catalog.execute("BEGIN IMMEDIATE")  # it waits here
            process = subprocess.Popen(self.command(*words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            caught = 1 << signal.SIGTERM - 1
            while not int(pathlib.Path(f"/proc/{process.pid}/status").read_text().split("SigCgt:")[1].split()[0], 16) & caught:
                self.assertIsNone(process.poll(), "it ended before it could be interrupted")
            process.terminate()
            catalog.execute("ROLLBACK")
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        return out, err

    @long_test
    def test_one_that_is_interrupted_releases_nothing_afterwards(self):
        self.verify()
        out, err = self.interrupted("release", "--all", "--json")
        self.assertEqual(out, "")
        self.assertIn("interrupted", json.loads(err)["error"]["message"])
        self.assertEqual(self.shown()["state"], "verified")

    @long_test
    def test_one_that_is_interrupted_tells_what_it_came_to(self):
        self.released()
        for lab, procedure in (("campaign", "import"), ("verification", "verification")):
            self.soak("import", fitted_folder() / "lab" / lab / f"{SERIAL}.csv", "--unit", "SN1", "--campaign", lab, "--procedure",
                      procedure, "--simulated", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN1")
        self.soak("verify", "--unit", "SN1", "--campaign", "verification", "--limits", self.write("l", WIDE))
        out, err = self.interrupted("release", "--all", "--json")
        document = json.loads(out)
        check_schema(document, "release")
        self.assertEqual([(one["unit"], one["state"]) for one in document["units"]], [(SERIAL, "released")])
        self.assertIn("interrupted", json.loads(err)["error"]["message"])

    def test_without_limits_nothing_is_released(self):
        self.verify("[limits]\ngyro = 0.2\n")
        self.refused("says info", "set limits")

    def test_runs_that_were_withdrawn_or_came_later_are_in_the_way(self):
        self.verify()
        run = self.soak_json("runs-list", "runs", "list", "--campaign", "verification")["runs"][0]
        self.soak("runs", "void", run["run_id"], "--unit", SERIAL, "--visit", 0, "--reason", "door")
        self.refused("campaign 'verification' were withdrawn", "verify it again")
        self.verify()
        used = self.soak_json("runs-list", "runs", "list", "--campaign", "campaign")["runs"][0]
        self.soak("runs", "void", used["run_id"], "--unit", SERIAL, "--visit", 0, "--reason", "door")
        self.refused("withdrawn, whole or in part, after the model was fitted", "fit again")
        self.soak("import", self.write("more.csv", recording(run="later")), "--unit", SERIAL, "--campaign", "more", "--simulated")
        self.refused("not in it: later", "fit again with all")

    @long_test
    def test_runs_count_by_what_they_are_and_not_by_the_times_of_their_records(self):
        self.verify()
        used = self.soak_json("runs-list", "runs", "list", "--campaign", "campaign")["runs"][0]
        self.enter("INSERT INTO void VALUES ('0', ?, ?, NULL, NULL, NULL, 'door', 'ann', 1.0)", used["run_id"], SERIAL)
        self.refused("1 of the runs that it was fitted to are withdrawn", "fit again")

    @long_test
    def test_a_new_version_of_some_of_the_runs_is_not_fresh(self):
        self.soak("import", self.write("more.csv", recording(run="later")), "--unit", SERIAL, "--campaign", "more", "--simulated")
        self.soak("fit", "--unit", SERIAL, "--campaign", "campaign")
        self.verify()
        self.refused("not in it: later", "fit again with all")
        run = self.soak_json("runs-list", "runs", "list", "--campaign", "more")["runs"][0]
        self.soak("runs", "void", run["run_id"], "--unit", SERIAL, "--reason", "not wanted")
        self.soak("release", "--unit", SERIAL)

    @long_test
    def test_a_copy_of_a_run_that_is_in_the_model_is_not_in_the_way(self):
        self.verify()
        copy = fitted_folder() / "lab" / "campaign" / f"{SERIAL}.csv"
        self.soak("import", copy, "--unit", SERIAL, "--campaign", "again", "--simulated", "--gravity-mps2", "9.80665")
        self.soak("release", "--unit", SERIAL)

    def test_a_damaged_record_is_told_and_no_crash(self):
        self.verify()
        for damaged in ('{"campaign": 5}', '{"campaign": "c", "limits": 7, "runs": []}', '{"campaign": "c", "limits": null, "runs": [3]}', "[]"):
            self.enter_record(SERIAL, damaged)
            self.assertIn("verify it again", self.refusal("release", "--unit", SERIAL, status=4)["message"])

    @long_test
    def test_a_repaired_unit_needs_a_new_model(self):
        self.verify()
        self.soak("unit", "add", SERIAL, "--begin-epoch", "board repaired")
        self.refusal("release", "--unit", SERIAL)
        document = self.soak_json("release", "release", "--all")["units"][0]
        self.assertEqual(document["state"], "verified")
        self.assertIn("epoch", document["obstacles"][0])

    def test_a_model_expires_with_the_first_of_its_references(self):
        for kind, due, more in (("gravity", "2098-05-01", ("--correction", "9.80665")), ("level", "2097-03-01", ())):
            self.soak("reference", "add", "--kind", kind, "--name", kind, "--certificate", "C1", "--issued", "2020-01-01", "--due", due,
                      "--uncertainty", "0.0002", *more)
        self.soak("import", fitted_folder() / "lab" / "campaign" / f"{SERIAL}.csv", "--unit", SERIAL, "--campaign", "known", "--simulated",
                  "--references")
        self.soak("fit", "--unit", SERIAL, "--campaign", "known")
        self.verify()
        document = self.soak_json("release", "release", "--unit", SERIAL)["units"][0]
        self.assertEqual((document["state"], document["expires"]), ("released", "2097-03-01"))
        self.soak("reference", "withdraw", "--kind", "level", "--name", "level", "--reason", "wrong")
        obstacles = self.soak_json("release", "release", "--all")["units"][0]["obstacles"]
        self.assertTrue(any("withdrawn" in text and "level" in text for text in obstacles), obstacles)

    def test_who_withdraws_a_model_says_why_and_it_never_comes_back(self):
        self.released()
        self.soak_json("model-retire", "model", "retire", "--unit", SERIAL, "--model", 1, "--reason", "wrong level", "--user", "ann")
        last = self.shown()["history"][-1]
        self.assertEqual((last["state"], last["user"], last["reason"]), ("withdrawn", "ann", "wrong level"))
        self.refused("is withdrawn: fit again")
        self.refusal("model", "retire", "--unit", SERIAL, "--model", 1, "--reason", "again")
        states = [one["state"] for one in self.soak_json("model-list", "model", "list")["models"]]
        self.assertEqual(states, ["withdrawn"])


class MeasuredModels(ReleaseTest):
    """A unit whose data are not marked as simulated."""

    def setUp(self):
        super().setUp()
        self.take("campaign", "import", "campaign")
        self.soak("fit", "--unit", "REAL")

    def take(self, lab, procedure, campaign, *more):
        self.soak("import", fitted_folder() / "lab" / lab / f"{SERIAL}.csv", "--unit", "REAL", "--campaign", campaign, "--procedure",
                  procedure, "--gravity-mps2", "9.80665", *more)

    def runs(self, campaign):
        return [run["run_id"] for run in self.soak_json("runs-list", "runs", "list", "--campaign", campaign)["runs"]]

    def test_simulated_runs_do_not_judge_them(self):
        self.take("verification", "verification", "made", "--simulated")
        error = self.refusal("verify", "--unit", "REAL", "--campaign", "made", "--limits", self.write("l", WIDE))
        for part in ("SIMULATED", "campaign 'made'", "measured"):
            self.assertIn(part, error["message"])
        self.assertEqual(self.soak_json("model-show", "model", "show", "--unit", "REAL")["verifications"], [])

    def test_a_record_that_rests_on_simulated_runs_is_in_the_way_of_release_and_hand_over(self):
        self.take("verification", "verification", "real")
        self.soak("verify", "--unit", "REAL", "--campaign", "real", "--limits", self.write("l", WIDE))
        self.soak("release", "--unit", "REAL")
        self.take("verification", "verification", "made", "--simulated")
        document = self.soak_json("model-show", "model", "show", "--unit", "REAL")["verifications"][0]["document"]
        document["campaign"], document["runs"][0]["run_id"] = "made", self.runs("made")[0]
        self.enter_record("REAL", json.dumps(document))
        self.assertIn("SIMULATED", self.refusal("release", "--unit", "REAL")["message"])
        self.soak("key", "new", "-o", self.folder / "lab.key")
        error = self.refusal("export", "--all", "--released", "--out", self.folder / "out", "--sign", self.folder / "lab.key")
        self.assertIn("'made' are SIMULATED", error["message"])


class HandOver(ReleaseTest):
    def setUp(self):
        super().setUp()
        self.soak("key", "new", "-o", self.folder / "lab.key")
        self.out = self.folder / "released"

    def arguments(self, *more):
        return ("export", "--all", "--released", "--out", self.out, "--sign", self.folder / "lab.key", "--simulated", *more)

    def check(self, status=0):
        return self.soak("key", "verify", self.out / "manifest.json", "--key", self.folder / "lab.key.pub", status=status)

    def test_only_released_models_are_in_the_folder(self):
        self.released()
        self.soak("import", self.write("r.csv", recording(plateaus=(0.0, 20.0, 40.0), seconds=20)), "--unit", "SN1")
        self.soak("fit", "--unit", "SN1")
        document = self.soak_json("export-all", *self.arguments())
        self.assertEqual(sorted(path.name for path in self.out.iterdir()), [f"{SERIAL}.soakcal", "manifest.json", "manifest.json.sig"])
        self.assertEqual([(one["unit"], one["model"]) for one in document["left_out"]], [("SN1", 1)])
        manifest = json.loads((self.out / "manifest.json").read_text(encoding="utf-8"))
        check_schema(manifest, "manifest")
        self.assertEqual(manifest, document["manifest"])
        unit, = manifest["units"]
        content = (self.out / unit["file"]).read_bytes()
        file = Calibration.load(content)
        self.assertEqual((unit["sha256"], unit["bytes"]), (hashlib.sha256(content).hexdigest(), len(content)))
        self.assertEqual((file.serial, file.unreleased, file.simulated), (SERIAL, False, unit["simulated"]))
        self.assertEqual((unit["released_by"], unit["verdict"], unit["campaign"]), ("eva", "pass", "verification"))
        self.assertEqual((unit["temp_min_c"], unit["temp_max_c"]),
                         (max(s["temp_min_c"] for s in self.fit["sensors"].values()), min(s["temp_max_c"] for s in self.fit["sensors"].values())))
        self.soak("key", "verify", self.out / unit["file"], "--key", self.folder / "lab.key.pub")

    def test_the_signature_is_that_of_the_page_of_formats(self):
        self.released()
        self.soak(*self.arguments())
        public = bytes.fromhex((self.folder / "lab.key.pub").read_text(encoding="utf-8").splitlines()[1])
        head, digits = (self.out / "manifest.json.sig").read_text(encoding="utf-8").splitlines()
        message = f"{head}\n".encode() + (self.out / "manifest.json").read_bytes()
        self.assertEqual(head, "soak-manifest-signature-1")
        self.assertTrue(ed25519.verify(public, message, bytes.fromhex(digits)))
        self.assertFalse(ed25519.verify(public, message + b" ", bytes.fromhex(digits)))

    def test_a_change_of_manifest_or_file_is_found(self):
        self.released()
        self.soak(*self.arguments())
        self.assertEqual(self.soak_json("key-verify", "key", "verify", self.out / "manifest.json", "--key", self.folder / "lab.key.pub")["files"], 1)
        for name in ("manifest.json", f"{SERIAL}.soakcal", "manifest.json.sig"):
            path = self.out / name
            content = path.read_bytes()
            path.write_bytes(content.replace(b"1", b"2", 1))
            self.assertIn(name.removesuffix(".sig"), self.check(status=4).stderr)
            path.unlink()
            self.check(status=2 if name == "manifest.json" else 4)
            path.write_bytes(content)
        self.check()

    @long_test
    def test_the_rule_holds_at_the_hand_over_too(self):
        self.released()
        run = self.soak_json("runs-list", "runs", "list", "--campaign", "campaign")["runs"][0]
        self.soak("runs", "void", run["run_id"], "--unit", SERIAL, "--reason", "door")
        message = self.refusal(*self.arguments())["message"]
        self.assertIn(f"{SERIAL}: withdrawn, whole or in part, after the model was fitted", message)
        self.assertFalse(self.out.exists())

    def test_it_mixes_with_nothing_and_simulated_data_are_asked_for(self):
        self.released()
        first = self.refusal(*[one for one in self.arguments() if one != "--simulated"])["message"].split("\n")[0]
        self.assertIn("SIMULATED data; --simulated takes them", first)  # and not that nothing keeps the rule
        self.assertNotIn("soak release", first)
        self.out.mkdir()
        (self.out / "old.soakcal").write_bytes(b"old")
        self.assertEqual(self.refusal(*self.arguments())["where"], str(self.out))
        self.assertEqual((self.out / "old.soakcal").read_bytes(), b"old")
        self.refusal("export", "--unit", SERIAL, "--format", "blob", "--released", "-o", self.folder / "x")
        self.assertEqual(self.refusal(*self.arguments("-o", self.folder / "x"))["where"], "--output")

    @long_test
    def test_no_other_calibration_file_lies_beside_the_manifest(self):
        self.released()
        self.soak(*self.arguments())
        (self.out / "README").write_text("from the laboratory", encoding="utf-8")
        self.check()
        (self.out / "other.SOAKCAL").write_bytes(b"other")
        self.assertIn("other.SOAKCAL: lies beside the manifest", self.check(status=4).stderr)

    def signed(self, manifest):
        """Puts another manifest into the folder, signed with the laboratory's key."""
        seed = bytes.fromhex((self.folder / "lab.key").read_text(encoding="utf-8").splitlines()[1])
        content = json.dumps(manifest).encode()
        prefix = b"soak-manifest-signature-1\n"
        (self.out / "manifest.json").write_bytes(content)
        (self.out / "manifest.json.sig").write_bytes(prefix + ed25519.sign(seed, prefix + content).hex().encode() + b"\n")

    @long_test
    def test_what_has_expired_is_told_by_unit(self):
        self.released()
        manifest = self.soak_json("export-all", *self.arguments())["manifest"]
        arguments = ("key", "verify", self.out / "manifest.json", "--key", self.folder / "lab.key.pub")
        good = self.soak_json("key-verify", *arguments)
        self.assertEqual((good["created_utc"], good["expires"], good["expired"]), (manifest["created_utc"], None, []))
        for expires, status, expired in (("2098-05-01", 0, []), ("2021-05-01", 5, [SERIAL])):
            manifest["units"][0]["expires"] = expires
            self.signed(manifest)
            document = self.soak_json("key-verify", *arguments, status=status)
            self.assertEqual((document["expires"], document["expired"]), (expires, expired))
        done = self.check(status=5)
        self.assertIn(f"made {manifest['created_utc']}, good until 2021-05-01", done.stdout)
        self.assertIn(f"1 of 1 units have expired: {SERIAL}", done.stderr)

    def test_a_malformed_manifest_that_is_signed_is_refused(self):
        self.released()
        manifest = self.soak_json("export-all", *self.arguments())["manifest"]
        unit, = manifest["units"]
        outside = self.folder / "outside.soakcal"
        (self.out / unit["file"]).replace(outside)
        (self.out / unit["file"]).write_bytes(outside.read_bytes())
        wrong = [{"file": 5}, {"file": "../outside.soakcal"}, {"file": str(outside)}, {"file": ".."}, {"sha256": None}, {"unit": []},
                 {"expires": 5}, {"expires": "soon"}]
        for units in ("all", {}, [5], *([unit | members] for members in wrong), [unit, unit]):
            self.signed(manifest | {"units": units})
            self.assertIn("malformed", self.check(status=4).stderr, units)
        self.signed(manifest | {"created_utc": 7})
        self.check(status=4)
        for no_manifest in (5, [manifest], manifest | {"format": 1}, {}):
            self.signed(no_manifest)
            self.check(status=2)
        self.signed(manifest)
        self.check()

    @long_test
    def test_serial_numbers_that_would_have_one_file_name_have_two(self):
        serials = ["sn/1", "SN:1", "manifest", "L" * 90]
        for serial in serials:
            for lab, procedure in (("campaign", "import"), ("verification", "verification")):
                self.soak("import", fitted_folder() / "lab" / lab / f"{SERIAL}.csv", "--unit", serial, "--campaign", lab, "--procedure",
                          procedure, "--simulated", "--gravity-mps2", "9.80665")
        self.soak("fit", "--all")
        self.soak("verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE))
        self.soak("release", "--all")
        units = self.soak_json("export-all", *self.arguments("--format", "json"))["manifest"]["units"]
        names = {unit["unit"]: unit["file"] for unit in units}
        digest = {serial: hashlib.sha256(serial.encode()).hexdigest()[:16] for serial in serials}
        self.assertEqual(names, {SERIAL: f"{SERIAL}.json", "sn/1": f"sn_1-{digest['sn/1']}.json", "SN:1": f"SN_1-{digest['SN:1']}.json",
                                 "manifest": f"manifest-{digest['manifest']}.json", "L" * 90: f"{'L' * 60}-{digest['L' * 90]}.json"})
        self.check()

    @long_test
    def test_a_damaged_record_of_one_unit_is_in_the_way_of_no_other(self):
        for lab, procedure in (("campaign", "import"), ("verification", "verification")):
            self.soak("import", fitted_folder() / "lab" / lab / f"{SERIAL}.csv", "--unit", "SN1", "--campaign", lab, "--procedure",
                      procedure, "--simulated", "--gravity-mps2", "9.80665")
        self.soak("fit", "--unit", "SN1")
        self.soak("verify", "--all", "--campaign", "verification", "--limits", self.write("l", WIDE))
        self.enter_record("SN1", "no document")
        done = self.soak("release", "--all", "--json", status=4)
        document = json.loads(done.stdout)
        check_schema(document, "release")
        self.assertEqual([(one["unit"], one["state"]) for one in document["units"]], [(SERIAL, "released"), ("SN1", "verified")])
        self.assertIn("damaged", document["units"][1]["obstacles"][0])
        self.assertIn("1 of 2 units are damaged, and these were not released: SN1", done.stderr)
        left_out = self.soak_json("export-all", *self.arguments())["left_out"]
        self.assertEqual([one["unit"] for one in left_out], ["SN1"])

    def test_the_archive_holds_a_folder_of_the_name_of_the_one_that_was_written(self):
        self.released()
        archive = self.folder / "x.tar"
        for out, name in ((f"{self.out}/", "released"), (self.folder / ("f" * 90), "f" * 90)):
            with self.subTest(name):
                words = [out if word == self.out else word for word in self.arguments("--archive", archive)]
                self.soak_json("export-all", *words)
                with tarfile.open(archive) as packed:
                    self.assertEqual(sorted(packed.getnames()), sorted(f"{name}/{file}" for file in (f"{SERIAL}.soakcal", "manifest.json", "manifest.json.sig")))

    def test_an_older_archive_stays_where_a_hand_over_fails(self):
        self.released()
        archive = self.folder / "x.tar"
        archive.write_bytes(b"older")
        self.enter("CREATE TRIGGER no_room BEFORE INSERT ON calibration BEGIN SELECT RAISE(ABORT, 'no room'); END")
        self.refusal(*self.arguments("--archive", archive), status=2)
        self.assertEqual(archive.read_bytes(), b"older")
        self.assertEqual([path.name for path in self.folder.glob("x.tar*")], ["x.tar"])
        self.assertFalse(self.out.exists())

    @long_test
    def test_a_full_disk_leaves_nothing_behind(self):
        self.released()
        before = self.state()
        # A calibration file has some thousand bytes.
        self.refusal(*self.arguments(), status=1, preexec_fn=limit_file_size(1000))
        self.assertFalse(self.out.exists())
        self.assertEqual(self.state(), before)


if __name__ == "__main__":
    unittest.main()
