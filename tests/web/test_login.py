# SPDX-License-Identifier: Apache-2.0
"""A station that others may reach, as its people use it, before a real `soakd` ($SOAK_BIN_FOLDER): when it starts, its certificate,
`soak campaign` with a token, and the page with its log-in in a real browser."""
import hashlib
import os
import ssl
import subprocess
import unittest

from test_accessibility import AXE, serious  # first: see there
from browser import BROWSER, DRIVER, Browser
from guarded_station import GuardedStation, password_of
from real_soakd import programs


class Station(unittest.TestCase):
    """One that each test starts as it likes."""

    def setUp(self):
        self.station = GuardedStation()
        self.addCleanup(self.station.close)

    def restart(self, status=0, listen="127.0.0.1:0"):
        """Ends the station and starts it again; its message where it refuses."""
        self.station.process.terminate()
        self.station.process.wait(60)
        if status == 0:
            self.station.start()
            return ""
        done = subprocess.run([programs() / "soakd", "--config", self.station.config, "--data", self.station.data, "--listen", listen],
                              capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stdout, "")
        return done.stderr

    def edit(self, before, after):
        text = self.station.config.read_text(encoding="utf-8")
        self.assertIn(before, text)
        self.station.config.write_text(text.replace(before, after), encoding="utf-8")

    def campaign(self, *words, status=0, **environment):
        done = subprocess.run([programs() / "soak", "campaign", *map(str, words)], capture_output=True, text=True, timeout=60, check=False,
                              env={**os.environ, **environment})
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done.stdout + done.stderr


class Start(Station):
    def test_without_accounts_it_does_not_start_where_others_may_reach_it(self):
        (self.station.data / "soakd.accounts").unlink()
        self.assertIn("soak user add", self.restart(2))
        self.edit('allowed_hosts = ["soak.lab.example"]', "")
        self.assertIn("soak user add", self.restart(2, "0.0.0.0:0"))
        self.restart()
        self.assertTrue(self.station.url.startswith("http://127.0.0.1:"), self.station.url)

    def test_accounts_that_others_can_read_are_refused(self):
        accounts = self.station.data / "soakd.accounts"
        accounts.chmod(0o640)
        self.assertIn("chmod 600", self.restart(2))

    def test_its_certificate_lasts_and_is_made_anew_for_another_name(self):
        first = self.station.certificate.read_bytes()
        self.assertEqual((self.station.data / "soakd.key").stat().st_mode & 0o777, 0o600)
        self.restart()
        self.assertEqual(self.station.certificate.read_bytes(), first)
        with self.assertRaises(ssl.SSLCertVerificationError):
            self.station.trust().wrap_socket(self.station.bare(), server_hostname="other.lab.example")
        self.edit('"soak.lab.example"', '"soak.lab.example", "other.lab.example"')
        self.restart()
        with self.station.trust().wrap_socket(self.station.bare(), server_hostname="other.lab.example") as wire:
            shown = hashlib.sha256(wire.getpeercert(binary_form=True)).hexdigest().upper()
        log = (self.station.folder / "soakd.log").read_text(encoding="utf-8")
        self.assertIn(":".join(shown[i:i + 2] for i in range(0, 64, 2)), log)

    def test_a_certificate_that_cannot_be_written_leaves_the_pair_of_before_whole(self):
        pair = [self.station.certificate, self.station.data / "soakd.key"]
        before = [path.read_bytes() for path in pair]
        (self.station.data / "soakd.crt.tmp" / "in the way").mkdir(parents=True)
        self.edit('"soak.lab.example"', '"soak.lab.example", "other.lab.example"')
        self.restart()  # with that pair
        self.assertEqual([path.read_bytes() for path in pair], before)
        self.assertFalse((self.station.data / "soakd.key.tmp").exists())

    def test_a_certificate_of_the_laboratory_is_shown_and_must_fit_its_key(self):
        for name in ("crt", "key"):
            (self.station.folder / f"lab.{name}").write_bytes((self.station.data / f"soakd.{name}").read_bytes())
        (self.station.folder / "lab.key").chmod(0o600)
        self.station.certificate.unlink()
        self.edit("[chamber]", '[tls]\ncertificate = "lab.crt"\nkey = "lab.key"\n\n[chamber]')
        self.restart()
        self.assertFalse(self.station.certificate.exists())
        context = ssl.create_default_context(cafile=str(self.station.folder / "lab.crt"))
        context.wrap_socket(self.station.bare(), server_hostname="localhost").close()
        (self.station.folder / "lab.key").chmod(0o644)
        self.assertIn("lab.key", self.restart(2))
        (self.station.folder / "lab.key").chmod(0o600)
        (self.station.folder / "lab.key").write_text("no key", encoding="utf-8")
        self.assertIn("lab.key", self.restart(2))


class Script(Station):
    def test_campaign_commands_come_in_with_certificate_and_token(self):
        token = self.station.folder / "token"
        token.write_text(self.station.token("vera", "script") + "\n", encoding="utf-8")
        station = f"https://127.0.0.1:{self.station.port}"
        options = ["--station", station, "--certificate", self.station.certificate]
        self.assertIn("state      idle", self.campaign("status", *options, "--token-file", token))
        environment = {"SOAK_STATION": station + "/", "SOAK_CERTIFICATE": str(self.station.certificate), "SOAK_TOKEN_FILE": str(token)}
        self.assertIn("state      idle", self.campaign("status", **environment))
        self.assertIn("needs the role operator", self.campaign("abort", "--reason", "x", status=2, **environment))
        self.assertIn("soak user token", self.campaign("status", *options, status=2))
        self.assertIn("--certificate", self.campaign("status", "--station", station, "--token-file", token, status=3))
        self.assertIn("https://", self.campaign("status", "--station", station.removeprefix("https://"), status=2))
        self.assertIn("over TLS only", self.campaign("status", "--station", f"127.0.0.1:{self.station.port}", "--token-file", token, status=2))

    def test_a_watch_over_tls_that_leaves_the_stream_ends_as_in_the_clear(self):
        token = self.station.folder / "token"
        token.write_text(self.station.token("vera", "script"), encoding="utf-8")
        message = self.campaign("watch", "--station", f"https://127.0.0.1:{self.station.port}", "--certificate", self.station.certificate,
                                "--token-file", token, status=2)
        self.assertIn("no campaign is running", message)

    def test_a_station_with_another_certificate_gets_no_token(self):
        other = GuardedStation()
        self.addCleanup(other.close)
        token = self.station.folder / "token"
        token.write_text(self.station.token("vera", "script"), encoding="utf-8")
        message = self.campaign("status", "--station", f"https://127.0.0.1:{other.port}", "--certificate", self.station.certificate,
                                "--token-file", token, status=3)
        self.assertIn("certificate", message)


@unittest.skipUnless(BROWSER and DRIVER, "no Chromium: skipped")
class Page(Station):
    def setUp(self):
        super().setUp()
        self.browser = Browser("--ignore-certificate-errors")
        self.addCleanup(self.browser.close)

    def log_in(self, name, password):
        self.browser.run("document.getElementById('name').value = ''")
        self.browser.type("#name", name)
        self.browser.type("#password", password)
        self.browser.press("Enter")

    def test_log_in_by_keyboard_then_work_then_log_out(self):
        browser = self.browser
        browser.go(self.station.url + "#units")
        browser.wait_for_text("h1", "Log in")
        self.assertEqual(browser.poor_contrast(), [])
        self.assertEqual(browser.console(), [])
        self.log_in("eva", "some password")
        browser.wait_for_text("#failure", "not known")
        self.assertEqual(browser.run("return document.activeElement.id"), "password")
        self.log_in("eva", password_of("eva"))
        browser.wait_for_text("#units-view", "SN0042")
        browser.wait("return document.getElementById('user').value === 'eva' && document.getElementById('user').readOnly")
        self.assertEqual(browser.run("return document.cookie"), "")
        self.assertEqual([line for line in browser.console() if "401" not in line], [])
        browser.click("#log-out")
        browser.wait_for_text("h1", "Log in")
        browser.go(self.station.url)
        browser.wait_for_text("h1", "Log in")

    @unittest.skipUnless(AXE.exists(), "skipped: axe-core is not there; npm ci --ignore-scripts --prefix tests/web brings it")
    def test_nothing_serious_is_found_at_the_door(self):
        self.browser.go(self.station.url)
        self.browser.wait_for_text("h1", "Log in")
        self.assertEqual(serious(self.browser), [])
        self.log_in("eva", "some password")
        self.browser.wait_for_text("#failure", "not known")
        self.assertEqual(serious(self.browser), [])

    def buttons(self):
        """Names of the buttons that are seen in any view of the page."""
        names = set()
        for view in ("station", "runs", f"run={self.run_id}&unit=SN0042", "units", "unit=SN0042", "fleet", "events", "records"):
            self.browser.run("location.hash = arguments[0]", view)
            self.browser.wait("return document.querySelector(`#${arguments[0]}-view`).offsetParent !== null", view.split("=")[0])
            if view.startswith("run="):
                self.browser.wait_for_text("#segments", "+X")
            if view.startswith("unit="):
                self.browser.wait("return document.querySelector('#unit-work').offsetParent !== null")
            if view == "records":
                self.browser.wait("return document.querySelector('#alarms-none').offsetParent !== null")  # what is read last
            names |= set(self.browser.run("return [...document.querySelectorAll('button')].filter((b) => b.offsetParent).map((b) => b.id || b.textContent)"))
        return names

    def test_a_role_sees_what_it_may_do_and_nothing_that_would_be_refused(self):
        harmless = {"sound", "log-out", "strip-back", "strip-on", "strip-in", "strip-out", "strip-all", "audit-send", "audit-clear", "chain-check", "Look"}
        self.run_id = self.station.soak_json("runs", "list")["runs"][0]["run_id"]
        seen = {}
        for name in ("vera", "otto", "eva"):
            self.browser.go(self.station.url)
            self.browser.wait_for_text("h1", "Log in")
            self.log_in(name, password_of(name))
            self.browser.wait("return document.querySelector('#role')?.hidden === false")
            self.browser.wait("return document.querySelector('#state').innerText.toLowerCase() === 'idle'")
            seen[name] = {button for button in self.buttons() if button not in harmless}
            self.browser.click("#log-out")
            self.browser.wait_for_text("h1", "Log in")
        self.assertEqual(seen["vera"], set())
        self.assertLessEqual({"unit-fit", "start-send"}, seen["otto"])
        self.assertFalse(seen["otto"] & {"unit-export", "run-void", "Make the key"}, seen["otto"])
        self.assertLessEqual(seen["otto"] | {"run-void", "Make the key"}, seen["eva"])

    def test_what_goes_into_a_record_is_in_the_name_of_the_account(self):
        self.browser.go(self.station.url + "#records")
        self.browser.wait_for_text("h1", "Log in")
        self.log_in("eva", password_of("eva"))
        self.browser.wait("return document.querySelector('#user')?.readOnly && document.querySelector('#types tbody tr')")
        names = "return ['reference-user', 'retire-user', 'void-user'].map((id) => [document.getElementById(id).value, document.getElementById(id).readOnly])"
        self.assertEqual(self.browser.run(names), [["eva", True]] * 3)
        self.browser.run("""document.querySelector('#reference-form').closest('details').open = true; document.querySelector('#reference-kind').value = 'level';
            for (const [name, value] of Object.entries({name: 'level 1', certificate: 'L-7', issued: '2026-01-01', due: '2099-01-01', uncertainty: '0.01'}))
              document.querySelector(`#reference-${name}`).value = value;
            document.querySelector('#reference-form').requestSubmit();""")
        self.browser.wait_for_text("#references", "level 1")
        self.assertEqual([entry["user"] for entry in self.station.soak_json("reference", "list")["references"]], ["eva"])
        self.assertEqual(self.browser.run(names), [["eva", True]] * 3)

    def test_a_page_whose_session_has_ended_asks_for_the_password(self):
        self.browser.go(self.station.url)
        self.browser.wait_for_text("h1", "Log in")
        self.log_in("otto", password_of("otto"))
        self.browser.wait_for_text("#state", "idle")
        self.station.user("password", "otto", password="another password")
        self.browser.wait_for_text("h1", "Log in")


if __name__ == "__main__":
    unittest.main()
