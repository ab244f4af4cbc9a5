# SPDX-License-Identifier: Apache-2.0
"""From a verdict to the folder that is handed over: what `soak verify` stores, which models `soak release` lets go, how what is not
released is marked, and what the signed manifest promises."""
import hashlib
import json
import unittest

import ed25519
import test_fit
from blob_reader import Calibration
from soak_cli import check_schema, limit_file_size, recording
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

    def test_a_newer_model_does_not_hide_the_released_one(self):
        self.released()
        self.soak("fit", "--unit", SERIAL)
        error = self.refusal("export", "--unit", SERIAL, "--format", "blob", "--simulated", "-o", self.folder / "x")
        self.assertIn("--model 1", error["message"])
        self.assertFalse(Calibration.load(self.export("old.soakcal", "blob", "--model", 1).read_bytes()).unreleased)


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
        self.refused("entered after it was fitted")

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

    def test_the_rule_holds_at_the_hand_over_too(self):
        self.released()
        run = self.soak_json("runs-list", "runs", "list", "--campaign", "campaign")["runs"][0]
        self.soak("runs", "void", run["run_id"], "--unit", SERIAL, "--reason", "door")
        message = self.refusal(*self.arguments())["message"]
        self.assertIn(f"{SERIAL}: withdrawn, whole or in part, after the model was fitted", message)
        self.assertFalse(self.out.exists())

    def test_it_mixes_with_nothing_and_simulated_data_are_asked_for(self):
        self.released()
        self.assertIn("SIMULATED", self.refusal(*[one for one in self.arguments() if one != "--simulated"])["message"])
        self.out.mkdir()
        (self.out / "old.soakcal").write_bytes(b"old")
        self.assertEqual(self.refusal(*self.arguments())["where"], str(self.out))
        self.assertEqual((self.out / "old.soakcal").read_bytes(), b"old")
        self.refusal("export", "--unit", SERIAL, "--format", "blob", "--released", "-o", self.folder / "x")
        self.assertEqual(self.refusal(*self.arguments("-o", self.folder / "x"))["where"], "--output")

    def test_a_full_disk_leaves_nothing_behind(self):
        self.released()
        before = self.state()
        # A calibration file has some thousand bytes.
        self.refusal(*self.arguments(), status=1, preexec_fn=limit_file_size(1000))
        self.assertFalse(self.out.exists())
        self.assertEqual(self.state(), before)


if __name__ == "__main__":
    unittest.main()
