# SPDX-License-Identifier: Apache-2.0
"""soak user: accounts and tokens of a data folder."""
import json
import os
import pty
import subprocess
import unittest

from soak_cli import SoakTest

PASSWORD = "a long password"
OWNER = 65534  # some user who is not root


class User(SoakTest):
    def add(self, name, role="viewer", password=PASSWORD, status=0):
        return self.soak("user", "add", name, "--role", role, status=status, input=password + "\n")

    def accounts(self):
        return self.soak_json("user-list", "user", "list")["accounts"]

    def events(self):
        events = self.soak_json("events-list", "events", "list", "--kind", "account")["events"]
        return [(event["subject"], event["text"]) for event in events]

    def test_an_account_is_listed_without_its_password_and_its_changes_are_events(self):
        self.add("eva", "engineer")
        self.soak("user", "password", "eva", input="another password\n")
        self.add("otto", "operator")
        self.assertEqual([(a["name"], a["role"], a["tokens"]) for a in self.accounts()], [("eva", "engineer", []), ("otto", "operator", [])])
        self.assertNotIn("argon2", self.soak("user", "list").stdout)
        self.soak("user", "remove", "eva")
        self.assertEqual([a["name"] for a in self.accounts()], ["otto"])
        self.assertEqual([subject for subject, _ in self.events()], ["eva", "eva", "otto", "eva"])
        stored = (self.data / "soakd.accounts").read_text(encoding="utf-8")
        self.assertNotIn(PASSWORD, stored)
        self.assertTrue(json.loads(stored)["accounts"][0]["password"].startswith("$argon2id$v=19$m=65536,t=2,p=1$"))

    def test_what_is_wrong_is_refused_and_changes_nothing(self):
        self.add("eva")
        before = (self.data / "soakd.accounts").read_bytes()
        for name in ("eva", "", "Eva", "../eva", "<script>", "e v a", "eva\n"):
            self.add(name, status=2)
        for password in ("short", "", "x" * 201, "with a\x07bell"):
            self.add("otto", password=password, status=2)
        self.soak("user", "add", "otto", "--role", "root", status=2)
        self.soak("user", "add", "otto", "--role", "viewer", status=2, stdin=subprocess.DEVNULL)
        for words in (("remove", "otto"), ("password", "otto"), ("token", "otto", "--label", "x"), ("revoke", "eva", "--label", "x")):
            self.soak("user", *words, status=2, input=PASSWORD + "\n")
        self.assertEqual((self.data / "soakd.accounts").read_bytes(), before)

    def test_a_token_is_shown_once_and_may_no_more_than_its_account(self):
        self.add("otto", "operator")
        token = self.soak_json("user-token", "user", "token", "otto", "--label", "nightly", "--role", "engineer")
        self.assertEqual((token["account"], token["role"]), ("otto", "operator"))
        self.soak("user", "token", "otto", "--label", "nightly", status=2)
        self.assertNotIn(token["token"], (self.data / "soakd.accounts").read_text(encoding="utf-8") + self.soak("user", "list").stdout)
        printed = self.soak("user", "token", "otto", "--label", "display", "--role", "viewer").stdout
        self.assertRegex(printed, r"^[0-9a-f]{64}\n$")
        self.assertEqual([(t["label"], t["role"]) for t in self.accounts()[0]["tokens"]], [("nightly", "operator"), ("display", "viewer")])
        self.soak("user", "revoke", "otto", "--label", "nightly")
        self.assertEqual([t["label"] for t in self.accounts()[0]["tokens"]], ["display"])
        self.assertNotIn(token["token"], str(self.events()))

    @unittest.skipUnless(os.geteuid() == 0, "only root gives files away: skipped")
    def test_what_root_writes_belongs_to_the_owner_of_the_data_folder(self):
        self.data.mkdir()
        os.chown(self.data, OWNER, OWNER)
        self.add("eva")
        for name in ("soakd.accounts", "soakd.accounts.lock"):
            status = (self.data / name).stat()
            self.assertEqual((status.st_uid, status.st_gid), (OWNER, OWNER), name)

    @unittest.skipUnless(os.geteuid() == 0, "only root acts as another user: skipped")
    def test_who_is_not_the_owner_of_the_data_folder_is_told_who_is(self):
        self.add("eva")
        self.folder.chmod(0o755)
        for path in (self.data, *self.data.iterdir()):
            path.chmod(0o777 if path.is_dir() else 0o666)
        (self.data / "soakd.accounts").chmod(0o600)
        before = (self.data / "soakd.accounts").read_bytes()
        done = self.soak("user", "remove", "eva", status=2, user=OWNER)
        self.assertIn(f"sudo -u root soak user ... --data {self.data}", done.stderr)
        self.assertEqual((self.data / "soakd.accounts").read_bytes(), before)

    def type(self, *lines):
        """Types at a terminal; (exit status, what the terminal has shown)."""
        ours, theirs = pty.openpty()
        process = subprocess.Popen(self.command("user", "add", "eva", "--role", "viewer"), stdin=theirs, stdout=theirs, stderr=theirs)
        os.close(theirs)
        shown = b""
        for line, prompt in zip(lines, (b"password of eva: ", b"again: ")):
            while not shown.endswith(prompt):
                shown += os.read(ours, 1024)
            os.write(ours, line.encode() + b"\n")
        try:
            while piece := os.read(ours, 1024):
                shown += piece
        except OSError:
            pass  # the other end is closed
        os.close(ours)
        return process.wait(60), shown.decode()

    def test_a_password_that_is_typed_is_not_seen_and_typed_twice(self):
        status, shown = self.type(PASSWORD, "a lone password")
        self.assertEqual(status, 2, shown)
        self.assertEqual(self.accounts(), [])
        status, shown = self.type(PASSWORD, PASSWORD)
        self.assertEqual(status, 0, shown)
        self.assertNotIn(PASSWORD, shown)
        self.assertEqual([a["name"] for a in self.accounts()], ["eva"])


if __name__ == "__main__":
    unittest.main()
