# SPDX-License-Identifier: Apache-2.0
"""An attacker at a station that others may reach, before a real `soakd` ($SOAK_BIN_FOLDER): without an account, with somebody else's
role, cookie or page, with many passwords, with slow or wrong TLS, with names that are meant to do harm."""
import contextlib
import hashlib
import json
import pathlib
import re
import socket
import ssl
import subprocess
import sys
import time
import unittest

import yaml

from guarded_station import ROLES, UNIT, GuardedStation, password_of, read_all
from run_digest import open_catalog
from soak_cli import check_schema, recording

PATHS = yaml.safe_load((pathlib.Path(__file__).resolve().parents[2] / "docs" / "openapi.yaml").read_text(encoding="utf-8"))["paths"]
API = "/api/v1/"
# What is told to all, and what is there only before the station is set up.
OPEN = {"GET": ["alive"], "POST": ["login"]}


def operations(method):
    """The paths of the interface that ask who one is, without their beginning."""
    return [path[len(API):] for path, item in PATHS.items() if path.startswith(API) and method.lower() in item
            and item[method.lower()]["tags"] != ["setup"] and path[len(API):] not in OPEN[method]]


READS, COMMANDS = operations("GET"), operations("POST")
# Commands for which a log-in of any role is enough, and those of operators; whatever else there is needs an engineer.
ANYBODYS = {"logout"}
OPERATORS = {path for path in COMMANDS if path.startswith("campaign/")} | {"unit/add", "jobs/cancel", "procedures/new"}
OPERATORS_JOBS = {"fit", "fit_all", "verify", "verify_all", "report", "report_campaign", "gap_find", "gap_show"}
JOB_KINDS = PATHS[API + "jobs"]["post"]["requestBody"]["content"]["application/json"]["schema"]["properties"]["kind"]["enum"]
ABORT = {"reason": "smoke"}
SLOW = 200


class Attacker(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.station = GuardedStation()
        cls.addClassCleanup(cls.station.close)
        cls.stalled = cls.station.bare()  # begins a handshake and never goes on
        cls.stalled.sendall(b"\x16")

    def setUp(self):
        self.open = []  # event streams
        self.addCleanup(self.leave_streams)

    def abort(self, **headers):
        """What an abort is answered; no campaign runs, so one that is carried out is told so (409)."""
        return self.station.ask("POST", "/api/v1/campaign/abort", ABORT, {"Content-Type": "application/json", **headers})[0]

    def test_without_an_account_nothing_is_told_and_nothing_done(self):
        self.assertGreater(min(len(READS), len(COMMANDS)), 15)
        for path in [API + path for path in READS] + ["/metrics", "/", "/index.html", "/nowhere"]:
            status, headers, body = self.station.ask("GET", path)
            self.assertEqual((status, json.loads(body)["error"]["where"]), (401, "account"), path)
            self.assertNotIn(UNIT, body)
        for command in COMMANDS:
            self.assertEqual(self.station.post(command, {"user": "eva", **ABORT})[0], 401, command)

    def test_a_browser_without_an_account_is_led_to_the_log_in(self):
        status, headers, _ = self.station.ask("GET", "/", headers={"Accept": "text/html"})
        self.assertEqual((status, headers["Location"]), (303, "/login.html"))
        status, headers, body = self.station.ask("GET", "/login.html")
        self.assertEqual(status, 200)
        self.assertIn("default-src 'self'", headers["Content-Security-Policy"])
        self.assertNotRegex(body, r"<script(?![^>]*\bsrc=)|\son\w+=|\sstyle=|<style")

    def test_the_sign_of_life_tells_nothing_else(self):
        status, _, body = self.station.ask("GET", "/api/v1/alive")
        self.assertEqual((status, sorted(json.loads(body))), (200, ["chamber_connected", "turn"]))

    def test_a_cookie_that_was_never_given_out_is_nothing(self):
        name, genuine = self.station.cookie("vera").split("=")
        self.assertEqual(self.station.ask("GET", "/api/v1/status", headers={"Cookie": f"a=b; {name}={genuine}"})[0], 200)
        forged = genuine[:-1] + ("0" if genuine[-1] != "0" else "1")
        for cookie in (f"{name}={forged}", f"{name}=", name, f"soak={genuine}", f"x{name}={genuine}", f"__Host-soak-1={genuine}",
                       f"{name}={hashlib.sha256(genuine.encode()).hexdigest()}", f"{name}={'a' * 4000}", "=;=;;", "vera"):
            self.assertEqual(self.station.ask("GET", "/api/v1/status", headers={"Cookie": cookie})[0], 401, cookie[:80])
            self.assertEqual(self.station.post("campaign/abort", ABORT, cookie)[0], 401, cookie[:80])

    def test_the_cookie_is_out_of_reach_of_scripts_neighbours_and_other_sites(self):
        _, headers, _ = self.station.log_in("vera")
        name, *rules = headers["Set-Cookie"].split("; ")
        self.assertRegex(name, rf"^__Host-soak-{self.station.port}=[0-9a-f]{{64}}$")
        self.assertEqual(sorted(rules), ["HttpOnly", "Path=/", "SameSite=Strict", "Secure"])

    def test_each_role_does_what_it_may_and_no_more(self):
        void = {"run": json.loads(self.station.soak("runs", "list", "--json"))["runs"][0]["run_id"], "unit": UNIT, "visit": 99, "reason": "x"}
        export = {"kind": "export", "unit": UNIT, "format": "json"}
        done = {"vera": (403, 403, 403), "otto": (409, 403, 403), "eva": (409, 400, 200)}  # 400, 409: by what is asked for
        for name, expected in done.items():
            cookie = self.station.cookie(name)
            self.assertEqual(self.station.ask("GET", "/api/v1/units", headers={"Cookie": cookie})[0], 200)
            session = json.loads(self.station.ask("GET", "/api/v1/session", headers={"Cookie": cookie})[2])
            check_schema(session, "http-session")
            self.assertEqual(session, {"accounts": True, "name": name, "role": ROLES[name]})
            answers = [self.station.post(path, body, cookie) for path, body in (("campaign/abort", ABORT), ("run/void", void), ("jobs", export))]
            self.assertEqual(tuple(answer[0] for answer in answers), expected, [answer[2] for answer in answers])
        repair = {"unit": UNIT, "reason": "board repaired"}
        for path, body in (("jobs", {"kind": "release", "unit": UNIT}), ("jobs", {"kind": "release_all"}), ("jobs", {"kind": "export_all", "format": "blob"}), ("unit/epoch", repair),
                           ("model/withdraw", {"unit": UNIT, "model": 1, "reason": "wrong reference"})):
            status, _, body = self.station.post(path, body, self.station.cookie("otto"))
            self.assertEqual(status, 403)
            self.assertIn("needs the role engineer", body)
        for path, body in (("jobs", {"kind": "fit_all"}), ("jobs", {"kind": "verify_all", "campaign": "none"}), ("jobs", {"kind": "report_campaign", "campaign": "none"})):
            self.assertIn("needs the role operator", self.station.post(path, body, self.station.cookie("vera"))[2])
        self.assertEqual(self.station.post("jobs", {"kind": "verify_all", "campaign": "none"}, self.station.cookie("otto"))[0], 400)
        status, _, body = self.station.post("unit/epoch", repair, self.station.cookie("eva"))
        self.assertEqual((status, json.loads(body)["unit"]), (200, UNIT))
        self.assertIn(', by eva: board repaired', self.station.query("SELECT text FROM event WHERE kind = 'epoch_begun'")[0][0])
        self.assertIn("needs the role operator", self.station.post("campaign/abort", ABORT, self.station.cookie("vera"))[2])

    def test_every_command_has_its_role_and_is_refused_below_it(self):
        asked = [(path, {}, path in OPERATORS) for path in COMMANDS if path not in ANYBODYS | {"jobs"}]
        asked += [("jobs", {"kind": kind}, kind in OPERATORS_JOBS) for kind in JOB_KINDS]
        self.assertGreater(len(asked), 25)
        vera, otto = self.station.cookie("vera"), self.station.cookie("otto")
        for path, body, is_operators in asked:
            with self.subTest(path=path, body=body):
                self.assertEqual(self.station.post(path, body, vera)[0], 403)
                status, _, text = self.station.post(path, {**body, "no_such": 1}, otto)
                # A member that no command knows: whoever may give the command is told of that instead.
                self.assertEqual((status, "needs the role" in text), (400, False) if is_operators else (403, True), text)

    def test_who_may_not_begin_a_job_may_not_end_it_either(self):
        eva, otto = self.station.cookie("eva"), self.station.cookie("otto")
        job = json.loads(self.station.post("jobs", {"kind": "release_all"}, eva)[2])
        status, _, body = self.station.post("jobs/cancel", {"id": job["id"]}, otto)
        self.assertEqual(status, 403)
        self.assertIn("needs the role engineer", body)
        self.assertEqual(self.station.post("jobs/cancel", {"id": 10 ** 6}, otto)[0], 400, "there is no such job")
        self.wait_for_job(job["id"])
        own = json.loads(self.station.post("jobs", {"kind": "fit_all"}, otto)[2])
        self.assertIn(self.station.post("jobs/cancel", {"id": own["id"]}, otto)[0], (200, 409), "over already, perhaps")
        self.wait_for_job(own["id"])

    def wait_for_job(self, number):
        end_s = time.monotonic() + 60
        token = self.station.token("vera", f"job {number}")
        while json.loads(self.station.ask("GET", f"/api/v1/job?id={number}", headers={"Authorization": f"Bearer {token}"})[2])["state"] == "running":
            self.assertLess(time.monotonic(), end_s)
            time.sleep(0.2)

    def test_a_command_is_signed_with_the_account_whatever_the_body_says(self):
        run = json.loads(self.station.soak("runs", "list", "--json"))["runs"][0]["run_id"]
        void = {"run": run, "unit": UNIT, "visit": 0, "position": "+X", "reason": "knock", "user": "mallory"}
        status, _, body = self.station.post("run/void", void, self.station.cookie("eva"))
        self.assertEqual(status, 200, body)
        self.assertEqual(self.station.query("SELECT user FROM event WHERE kind = 'voided'"), [("eva",)])

    def test_who_has_the_file_of_a_released_model_first_is_in_the_event_log(self):
        station = GuardedStation()
        self.addCleanup(station.close)
        (station.folder / "more.csv").write_text(recording(plateaus=(0.0, 20.0, 40.0), seconds=20), encoding="utf-8")
        station.soak("import", str(station.folder / "more.csv"), "--unit", "SN7", "--gravity-mps2", "9.80665")
        station.soak("fit", "--unit", "SN7")
        with contextlib.closing(open_catalog(station.data / "station.db")) as catalog, catalog:  # as if it had passed and been released
            document = json.dumps({"campaign": "check", "limits": "limits.toml", "runs": []})
            catalog.execute("INSERT INTO verification VALUES (?, 'SN7', 1, ?, 'eva', 'pass', ?)", ("f" * 20, time.time(), document))
            for state in ("verified", "released"):
                catalog.execute("INSERT INTO model_state (model_state_id, unit, model_version, state, reason, user, utc_s) VALUES (?, 'SN7', 1, ?, 'test', 'eva', ?)",
                                (f"{state:x<20}", state, time.time()))
        for name in ("vera", "otto", "vera"):
            status, _, body = station.ask("GET", "/api/v1/unit/file?unit=SN7&format=json", headers={"Cookie": station.cookie(name)})
            self.assertEqual(status, 200, body)
        self.assertEqual(station.query("SELECT user FROM event WHERE kind = 'calibration_exported'"), [("vera",)])

    def test_a_page_of_another_site_cannot_use_the_cookie_of_whoever_looks_at_it(self):
        own = self.station.page_headers(self.station.cookie("eva"))
        self.assertEqual(self.station.ask("POST", "/api/v1/campaign/abort", ABORT, own)[0], 409)
        http_origin = self.station.origin.replace("https", "http")
        for changed in ({"Origin": "https://evil.example"}, {"Origin": "null"}, {"Origin": None}, {"X-Requested-With": None},
                        {"Origin": "https://localhost:1"}, {"Origin": http_origin}, {"X-Requested-With": "XMLHttpRequest"}):
            headers = {name: value for name, value in {**own, **changed}.items() if value is not None}
            status, answered, _ = self.station.ask("POST", "/api/v1/campaign/abort", ABORT, headers)
            self.assertEqual(status, 403, changed)
            self.assertNotIn("Access-Control-Allow-Origin", answered)
        for kind, status in (("text/plain", 415), ("application/x-www-form-urlencoded", 415), ("multipart/form-data", 400)):
            self.assertEqual(self.station.ask("POST", "/api/v1/campaign/abort", ABORT, {**own, "Content-Type": kind})[0], status, kind)
        preflight = {"Origin": "https://evil.example", "Access-Control-Request-Method": "POST"}
        status, answered, _ = self.station.ask("OPTIONS", "/api/v1/campaign/abort", headers=preflight)
        self.assertEqual((status, [name for name in answered if name.startswith("Access-Control")]), (403, []))

    def test_a_cookie_is_worth_nothing_after_log_out_and_open_streams_end(self):
        cookie = self.station.cookie("otto")
        with self.station.trust().wrap_socket(self.station.bare(), server_hostname="localhost") as stream:
            stream.sendall(f"GET /api/v1/events HTTP/1.1\r\nHost: localhost:{self.station.port}\r\nCookie: {cookie}\r\n\r\n".encode())
            self.assertIn(b"200 OK", stream.recv(65536))
            self.assertEqual(self.station.post("logout", {}, cookie)[0], 200)
            read_all(stream)  # ends; a stream that goes on runs into the time-out
        self.assertEqual(self.station.ask("GET", "/api/v1/status", headers={"Cookie": cookie})[0], 401)
        self.assertEqual(self.station.post("campaign/abort", ABORT, cookie)[0], 401)

    def leave_streams(self):
        while self.open:
            self.open.pop().close()

    def take_streams(self, count, cookie, sources):
        """Those of a test before may still be on their way out."""
        end_s = time.monotonic() + 60
        while count > 0:
            self.assertLess(time.monotonic(), end_s)
            count -= self.watch(cookie, sources[count % len(sources)]) == 200

    def watch(self, cookie, source="127.0.0.1"):
        """Asks for an event stream; the status of the answer."""
        bare = socket.create_connection(("127.0.0.1", self.station.port), timeout=60, source_address=(source, 0))
        stream = self.station.trust().wrap_socket(bare, server_hostname="localhost")
        self.open.append(stream)
        stream.sendall(f"GET /api/v1/events HTTP/1.1\r\nHost: localhost:{self.station.port}\r\nCookie: {cookie}\r\n\r\n".encode())
        return int(stream.recv(65536).split()[1])

    def test_one_account_does_not_take_all_event_streams_from_many_addresses_and_sessions(self):
        first, second = self.station.cookie("vera"), self.station.cookie("vera")
        many = [f"127.0.0.{20 + i}" for i in range(20)]
        self.take_streams(10, first, many)
        self.take_streams(10, second, many)
        self.assertEqual({self.watch(cookie, source) for cookie in (first, second) for source in ("127.0.0.1", "127.0.0.60")}, {429})
        token = self.station.token("vera", "streams")
        status, _, body = self.station.ask("GET", "/api/v1/events", headers={"Authorization": f"Bearer {token}"})
        self.assertEqual((status, json.loads(body)["error"]["where"]), (429, "streams"))
        self.assertEqual(self.watch(self.station.cookie("eva")), 200, "others still watch")
        self.leave_streams()
        self.take_streams(1, first, many)

    def test_one_address_does_not_take_all_event_streams_with_many_accounts(self):
        vera = self.station.cookie("vera")
        for name in ("otto", "eva"):
            self.take_streams(20, self.station.cookie(name), ["127.0.0.9"])
        self.assertEqual(self.watch(vera, "127.0.0.9"), 429)
        self.take_streams(1, vera, ["127.0.0.10"])

    def test_a_new_log_in_ends_the_session_of_before_in_the_same_browser(self):
        before = self.station.cookie("otto")
        body = {"name": "vera", "password": password_of("vera")}
        status, headers, _ = self.station.post("login", body, before)
        self.assertEqual(status, 200)
        self.assertEqual(self.station.ask("GET", "/api/v1/status", headers={"Cookie": before})[0], 401)
        after = headers["Set-Cookie"].split(";")[0]
        self.assertEqual(self.station.ask("GET", "/api/v1/status", headers={"Cookie": after})[0], 200)

    def test_an_answer_is_whole_whatever_parts_of_it_are_asked_for(self):
        whole = self.station.ask("GET", "/login.html")[2]
        for parts in ("bytes=0-9", "bytes=-1", "bytes=0-0,2-3", "bytes=" + ",".join(["0-"] * 500)):
            status, headers, body = self.station.ask("GET", "/login.html", headers={"Range": parts})
            self.assertEqual((status, body, headers["Content-Range"]), (200, whole, None), parts[:20])
            status, _, body = self.station.ask("GET", "/api/v1/status", headers={"Range": parts})
            self.assertEqual((status, json.loads(body)["error"]["where"]), (401, "account"), parts[:20])

    def test_whoever_tries_passwords_is_stopped_and_keeps_nobody_else_out(self):
        unknown = self.station.log_in("nobody", "some password", source="127.0.0.9")
        for _ in range(60):  # more than ten where the machine is slow: tries come back with time
            status, _, body = self.station.log_in("eva", "some password", source="127.0.0.9")
            if status != 429:
                self.assertEqual((status, body), (401, unknown[2]))
            elif int(re.search(r"(\d+) s$", json.loads(body)["error"]["message"])[1]) > 5:
                break
        self.assertEqual(self.station.log_in("eva", source="127.0.0.9")[0], 429, "the right password, after too many wrong ones")
        self.assertEqual(self.station.log_in("eva", source="127.0.0.10")[0], 200)

    def test_a_token_opens_what_its_role_may_until_it_is_revoked(self):
        may, looks = self.station.token("otto", "script"), self.station.token("otto", "display", "--role", "viewer")
        self.assertEqual(self.abort(Authorization=f"Bearer {may}"), 409)
        self.assertEqual(self.abort(Authorization=f"Bearer {looks}"), 403)
        for wrong in (f"Bearer {may[:-1]}", f"Bearer {may.upper()}x", "Bearer ", f"Basic {may}", may):
            self.assertIn(self.abort(Authorization=wrong), (401, 403), wrong)  # 403: as for a page that is not ours
        self.assertEqual(self.station.ask("GET", f"/api/v1/status?token={may}")[0], 401)
        self.assertNotIn(may, (self.station.data / "soakd.accounts").read_text(encoding="utf-8"))
        self.station.user("revoke", "otto", "--label", "script")
        self.assertEqual(self.abort(Authorization=f"Bearer {may}"), 401)
        self.assertEqual(self.abort(Authorization=f"Bearer {looks}"), 403)

    def test_the_client_of_the_docs_comes_in_with_a_token_and_trusts_the_stations_certificate(self):
        client = pathlib.Path(__file__).resolve().parents[2] / "docs" / "examples" / "client.py"
        token = self.station.folder / "client.token"
        token.write_text(self.station.token("vera", "client"), encoding="utf-8")

        def ask(*words):
            return subprocess.run([sys.executable, "-B", client, self.station.origin, UNIT, *words], cwd=self.station.folder, capture_output=True, text=True)
        certificate = ("--certificate", self.station.certificate)
        seen = ask("--token-file", token, *certificate)
        self.assertRegex(seen.stdout, r"^Soak \S+, idle\n$")
        self.assertIn("it needs the role operator", seen.stderr)
        self.assertIn("log in, or show a token", ask(*certificate).stderr)
        self.assertIn("certificate verify failed", ask("--token-file", token).stderr)

    def test_a_new_password_and_a_removed_account_end_sessions_and_tokens(self):
        self.station.user("add", "ida", "--role", "viewer", password=password_of("ida"))
        cookie, token = self.station.cookie("ida"), self.station.token("ida", "x")

        def asked(headers):
            return self.station.ask("GET", "/api/v1/status", headers=headers)[0]
        self.assertEqual(asked({"Cookie": cookie}), 200)
        self.station.user("password", "ida", password=" änother \"password\" ")
        self.assertEqual(asked({"Cookie": cookie}), 401)
        self.assertEqual(self.station.log_in("ida")[0], 401)
        self.assertEqual(self.station.log_in("ida", " änother \"password\" ")[0], 200)
        self.station.user("remove", "ida")
        self.assertEqual(asked({"Authorization": f"Bearer {token}"}), 401)

    def test_no_path_leads_out_of_the_pages(self):
        token = self.station.token("eva", "paths")
        secret = (self.station.data / "soakd.key").read_bytes()[30:60]
        for path in ("/../../../../etc/passwd", "/..%2f..%2f..%2fetc%2fpasswd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/.\\..\\etc",
                     "/soakd.accounts", "/soakd.key", "/login.html/../soakd.key", "/login.html%00.key", "/api/v1/../../soakd.key",
                     "/api/v1/job/file?id=../../soakd.key", "/api/v1/job/file?id=1%00", f"/api/v1/run?run=../../x&unit={UNIT}"):
            for headers in ("", f"Authorization: Bearer {token}\r\n"):
                answer = self.station.raw(f"GET {path} HTTP/1.1\r\nHost: localhost:{self.station.port}\r\n{headers}\r\n".encode())
                self.assertRegex(answer, rb"^HTTP/1.1 4\d\d ", path)
                self.assertNotIn(b"root:", answer)
                self.assertNotIn(secret, answer)

    def test_bodies_that_are_large_packed_or_endless_are_refused_before_anybody_is_known(self):
        self.assertEqual(self.station.ask("POST", "/api/v1/login", b"x" * (2 << 20), self.station.page_headers())[0], 413)
        for name, value, status in (("Transfer-Encoding", "chunked", 411), ("Content-Encoding", "br", 415)):
            self.assertEqual(self.station.ask("POST", "/api/v1/login", "{}", {**self.station.page_headers(), name: value})[0], status, name)
        for body in ({"name": "x" * 100000, "password": "y"}, {"name": "eva", "password": "y" * 100000}, {"name": ["eva"], "password": "y"},
                     {"name": "eva\nlog-in of root", "password": "y"}, {"name": "eva"}, {"name": "eva", "password": "y", "role": "engineer"}):
            self.assertEqual(self.station.post("login", body)[0], 400, str(body)[:60])

    def test_names_that_are_meant_to_do_harm_reach_neither_log_nor_page(self):
        for name in ("<img src=x onerror=alert(1)>", "../eva", "__proto__", "' or 1=1 --"):
            status, _, body = self.station.log_in(name, "some password", source="127.0.0.11")
            self.assertEqual(status, 401)
            self.assertNotIn(name, body)
        log = (self.station.folder / "soakd.log").read_text(encoding="utf-8")
        self.assertIn("login_refused: unknown account: refused from 127.0.0.11", log)
        self.assertIsNone(re.search(r"onerror|__proto__|or 1=1", log), log)

    def test_log_ins_are_events_with_their_account(self):
        cookie = self.station.cookie("otto")
        self.assertEqual(self.station.log_in("otto", "some password", source="127.0.0.12")[0], 401)
        self.assertEqual(self.station.post("logout", {}, cookie)[0], 200)
        token = self.station.token("vera", "auditor")
        end_s = time.monotonic() + 30  # the log is written beside the answer
        while True:
            _, _, body = self.station.ask("GET", "/api/v1/audit?subject=otto", headers={"Authorization": f"Bearer {token}"})
            events = {(event["kind"], event["user"], event["text"]) for event in json.loads(body)["events"]}
            if ("logged_out", "otto", "logged out from 127.0.0.1") in events:
                break
            self.assertLess(time.monotonic(), end_s, events)
        self.assertIn(("logged_in", "otto", "logged in from 127.0.0.1, operator"), events)
        self.assertIn(("login_refused", None, "refused from 127.0.0.12: wrong password"), events)

    def test_other_hosts_are_refused_also_with_a_token(self):
        token = self.station.token("eva", "hosts")
        for host, status in (("soak.lab.example", 200), ("soak.lab.example:443", 200), ("evil.example", 403), ("", 403)):
            self.assertEqual(self.station.ask("GET", "/api/v1/status", headers={"Authorization": f"Bearer {token}", "Host": host})[0], status, host)

    def test_whoever_speaks_http_to_it_is_told_to_speak_https(self):
        with self.station.bare() as wire:
            wire.sendall(b"POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\n{}\n")
            answer = read_all(wire)
        self.assertTrue(answer.startswith(b"HTTP/1.1 400 "), answer)
        self.assertIn(b"https://", answer)
        for noise in (b"\x00" * 100, b"\xff\xfe", b"SSH-2.0-x\r\n", b"\x16\x03\x01\xff\xff" + b"x" * 70000):
            with self.station.bare() as wire:
                try:
                    wire.sendall(noise)
                except OSError:
                    pass  # cut off before it was sent
                self.assertNotIn(b"200", read_all(wire))

    def test_nobody_trusts_it_who_does_not_know_its_certificate(self):
        with self.assertRaises(ssl.SSLCertVerificationError):
            ssl.create_default_context().wrap_socket(self.station.bare(), server_hostname="localhost")
        with self.station.trust().wrap_socket(self.station.bare(), server_hostname="soak.lab.example") as wire:
            self.assertIn(wire.version(), ("TLSv1.2", "TLSv1.3"))

    def test_an_abort_passes_beside_hundreds_of_handshakes_and_requests_that_never_end(self):
        token = self.station.token("otto", "siege")
        waiting = []
        for i in range(SLOW):
            wire = self.station.bare()
            self.addCleanup(wire.close)
            wire.sendall(b"\x16\x03\x01\x02\x00\x01"[:1 + i % 6])
            waiting.append(wire)
        self.assertEqual(self.abort(Authorization=f"Bearer {token}"), 409)

    def test_a_handshake_that_stalls_is_cut_off(self):
        self.assertEqual(read_all(self.stalled), b"")
        self.stalled.close()


if __name__ == "__main__":
    unittest.main()
