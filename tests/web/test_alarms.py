# SPDX-License-Identifier: Apache-2.0
"""Alarms that reach a person: a real `soakd` ($SOAK_BIN_FOLDER) before a real mail server and a real webhook, and before dead ones. The
alarm is a data folder that goes away."""
import email
import email.policy
import json
import os
import pathlib
import queue
import socket
import subprocess
import sys
import threading
import time
import unittest
import urllib.error
import urllib.request

from browser import BROWSER, DRIVER, Browser
from guarded_station import GuardedStation
from real_soakd import Soakd, programs

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import check_schema  # noqa: E402

PEERS = pathlib.Path(__file__).with_name("alarm_peers.py")
PATIENCE_S = 60
FROM, TO = "soak@lab.example", "eva@lab.example"


class Peers:
    """Mail server and webhook, in another process."""

    def __init__(self, *options):
        self.process = subprocess.Popen(["/usr/bin/python3", "-B", PEERS, *map(str, options)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True)
        self.lines = {kind: queue.Queue() for kind in ("mail", "webhook", "log-in")}
        ports = json.loads(self.process.stdout.readline())
        self.mail, self.webhook = ports["mail"], ports["webhook"]
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            document = json.loads(line)
            self.lines[document.pop("kind")].put(document)

    def end(self):
        self.process.stdin.close()
        self.process.wait(PATIENCE_S)
        self.reader.join(PATIENCE_S)
        self.process.stdout.close()

    def got(self, kind):
        """The next one of that kind."""
        return self.lines[kind].get(timeout=PATIENCE_S)

    def nothing_came(self):
        return all(line.empty() for line in self.lines.values())


def station_with(settings):
    class Alarmed(Soakd):
        def store_all(self):
            (self.folder / "token").write_text("a token\n", encoding="utf-8")
            (self.folder / "token").chmod(0o600)

        def lose_folder(self):
            self.data.rename(self.folder / "elsewhere")

        def find_folder(self):
            (self.folder / "elsewhere").rename(self.data)

    Alarmed.settings = settings
    return Alarmed()


def message(mail):
    return email.message_from_string(mail["content"], policy=email.policy.default)


def mail_table(port, more='security = "none"', to=(TO,)):
    return f'[alarms.mail]\nhost = "127.0.0.1"\nport = {port}\nfrom = "{FROM}"\nto = {json.dumps(to)}\n{more}\n'


def webhook_table(port, path="/hooks/secret-path", more=""):
    return f'[alarms.webhook]\nurl = "http://127.0.0.1:{port}{path}"\n{more}\n'


class AlarmTest(unittest.TestCase):
    def peers(self, *options):
        peers = Peers(*options)
        self.addCleanup(peers.end)
        return peers

    def station(self, settings):
        station = station_with(settings)
        self.addCleanup(station.close)
        return station

    def post(self, station, path, body):
        request = urllib.request.Request(station.url + "api/v1/" + path, json.dumps(body).encode(), {"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as refusal:
            with refusal:
                return refusal.code, json.load(refusal)

    def wait(self, what, asked):
        end_s = time.monotonic() + PATIENCE_S
        while not (found := asked()):
            self.assertLess(time.monotonic(), end_s, what)
            time.sleep(0.05)
        return found

    def told(self, station):
        """All that the station keeps and shows of its messages."""
        events = self.events(station, "alarm_sent") + self.events(station, "alarm_not_sent")
        return str(events) + (station.folder / "soakd.log").read_text(encoding="utf-8") + json.dumps(station.get("alarms"))

    def events(self, station, kind):
        return [(subject, text, user) for subject, text, user in station.query(f"SELECT subject, text, user FROM event WHERE kind = '{kind}' ORDER BY ordinal")]


class Alarms(AlarmTest):
    """Three stations whose data folders go away at the same time."""

    @classmethod
    def setUpClass(cls):
        cls.both = Peers()
        cls.addClassCleanup(cls.both.end)
        cls.silent = socket.create_server(("127.0.0.1", 0))  # takes connections, and never says a word
        cls.addClassCleanup(cls.silent.close)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            cls.closed = probe.getsockname()[1]
        cls.well = station_with(mail_table(cls.both.mail) + webhook_table(cls.both.webhook, more='token_file = "token"'))
        cls.beside_silence = station_with(mail_table(cls.silent.getsockname()[1]) + webhook_table(cls.both.webhook, "/beside"))
        cls.without_server = station_with(mail_table(cls.closed))
        for station in (cls.well, cls.beside_silence, cls.without_server):
            cls.addClassCleanup(station.close)
            station.lose_folder()

    def is_open(self, connection):
        """Whether soakd still waits at that connection for the silent server's first word."""
        try:
            return connection.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) != b""
        except BlockingIOError:
            return True
        except ConnectionError:
            return False

    def mail_under_way(self):
        """A connection at which soakd waits for the silent server."""
        self.silent.settimeout(PATIENCE_S)
        while True:
            connection, _ = self.silent.accept()
            self.addCleanup(connection.close)
            if self.is_open(connection):
                return connection

    def hooks(self, path):
        """The next request to the webhook with that path."""
        while (hook := self.both.got("webhook"))["path"] != path:
            self.both.lines["webhook"].put(hook)
            time.sleep(0.05)
        check_schema(json.loads(hook["body"]), "alarm-message")
        return hook

    def test_an_alarm_comes_by_mail_and_webhook_when_it_begins_and_when_it_ends_and_is_in_the_log(self):
        mail, hook = self.both.got("mail"), self.hooks("/hooks/secret-path")
        self.assertEqual((mail["sender"], mail["to"]), (FROM, [TO]))
        begun = message(mail)
        self.assertIn("The data folder is gone", begun["Subject"])
        self.assertEqual((begun["From"], begun["To"], begun.defects), (f"Soak <{FROM}>", TO, []))
        self.assertNotIn("=0A", mail["content"], "a line ends as lines of a mail do")
        text = begun.get_body().get_content()
        for part in (str(self.well.data), "Bring it back (is its disk mounted?)"):
            self.assertIn(part, text)
        self.assertEqual((hook["type"], hook["authorization"]), ("application/json", "Bearer a token"))
        document = json.loads(hook["body"])
        self.assertEqual((document["turn"], document["code"], document["level"]), ("began", "data_folder", "alarm"))
        self.well.find_folder()
        self.assertIn("Over: The data folder is gone", message(self.both.got("mail"))["Subject"])
        self.assertEqual(json.loads(self.hooks("/hooks/secret-path")["body"])["turn"], "ended")
        sent = self.wait("four events", lambda: (rows := self.events(self.well, "alarm_sent")) and len(rows) == 4 and rows)
        self.assertEqual(sorted(subject for subject, _, _ in sent), ["mail", "mail", "webhook", "webhook"])
        for secret in ("secret-path", "a token"):
            self.assertNotIn(secret, self.told(self.well))

    def test_a_mail_server_that_is_silent_delays_neither_engine_nor_webhook_nor_the_end(self):
        station = self.beside_silence
        self.assertEqual(json.loads(self.hooks("/beside")["body"])["turn"], "began")

        def turns_beside_a_mail():
            mail = self.mail_under_way()
            before = station.get("alive")["turn"]
            self.wait("the engine turns", lambda: station.get("alive")["turn"] > before + 3)
            return self.is_open(mail)

        self.wait("the engine turns while the mail server is waited for", turns_beside_a_mail)
        self.assertIsNone(next(way for way in station.get("alarms")["ways"] if way["way"] == "mail")["sent_utc_s"])
        station.find_folder()
        self.wait("the folder", lambda: station.get("status")["data"]["trouble"] is None)
        station.process.terminate()
        self.assertEqual(station.process.wait(PATIENCE_S), 0)
        self.assertIn("soakd ends", str(self.events(station, "alarm_not_sent")))

    def test_what_a_server_does_not_take_is_tried_again_at_the_latest_after_another_one_and_is_one_event(self):
        trouble = self.wait("a first try", lambda: self.without_server.get("alarms")["ways"][0]["trouble"])
        self.assertIn("connect", trouble)
        peers = self.peers("--mail-port", self.closed)
        self.without_server.find_folder()
        over = [message(peers.got("mail"))["Subject"].count("Over: ") for _ in range(2)]
        self.assertEqual(sorted(over), [0, 1])
        self.wait("the events", lambda: len(self.events(self.without_server, "alarm_sent")) == 2)
        self.assertEqual(len(self.events(self.without_server, "alarm_not_sent")), 1)


class Ways(AlarmTest):
    def test_a_password_goes_over_tls_to_a_server_that_is_known_and_to_no_other(self):
        guarded = GuardedStation()  # for its certificate of localhost and 127.0.0.1
        self.addCleanup(guarded.close)
        peers = self.peers("--tls", guarded.certificate, guarded.data / "soakd.key")
        config = guarded.folder / "mail.toml"
        (guarded.folder / "password").write_text("correct horse\n", encoding="utf-8")
        (guarded.folder / "password").chmod(0o600)
        text = guarded.config.read_text(encoding="utf-8")

        def send(more, status):
            config.write_text(text + mail_table(peers.mail, 'user = "soak"\npassword_file = "password"\n' + more), encoding="utf-8")
            done = subprocess.run([programs() / "soak", "alarm", "send", "a − b", "--config", config], capture_output=True, text=True, timeout=PATIENCE_S)
            self.assertEqual(done.returncode, status, done.stdout + done.stderr)
            self.assertNotIn("correct horse", done.stdout + done.stderr)
            return done.stderr

        self.assertIn("certificate", send("", 3))
        self.assertTrue(peers.nothing_came(), "not even a log-in")
        send(f'certificate = "{guarded.certificate}"', 0)
        self.assertEqual(peers.got("log-in"), {"right": True, "tls": True})
        mail = peers.got("mail")
        self.assertTrue(mail["tls"] and mail["authenticated"])
        self.assertTrue(message(mail)["Subject"].endswith(": a − b"), message(mail)["Subject"])
        (guarded.folder / "password").chmod(0o644)
        self.assertIn("chmod 600", send("", 2))

    def test_a_mailbox_that_is_gone_silences_no_other(self):
        peers = self.peers()
        station = self.station(mail_table(peers.mail, to=("gone@lab.example", TO)))
        _, answer = self.post(station, "alarms/test", {"user": "eva"})
        self.assertIsNone(answer["ways"][0]["trouble"])
        self.assertEqual(peers.got("mail")["to"], [TO])

    def test_a_token_for_this_machine_goes_to_no_proxy(self):
        peers = self.peers()
        station = self.station(webhook_table(peers.webhook, more='token_file = "token"'))
        with socket.create_server(("127.0.0.1", 0)) as proxy:
            environment = {**os.environ, "http_proxy": f"http://127.0.0.1:{proxy.getsockname()[1]}", "no_proxy": ""}
            done = subprocess.run([programs() / "soak", "alarm", "send", "a note", "--config", station.config], env=environment, capture_output=True,
                                  text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(peers.got("webhook")["authorization"], "Bearer a token")

    def test_a_webhook_that_refuses_is_told_with_its_number_and_without_what_it_says(self):
        peers = self.peers()
        station = self.station(webhook_table(peers.webhook, "/refuses", 'token_file = "token"') + mail_table(peers.mail))
        status, answer = self.post(station, "alarms/test", {"user": "eva"})
        self.assertEqual(status, 200)
        check_schema(answer, "alarm-send")
        self.assertEqual([way["way"] for way in answer["ways"]], ["mail", "webhook"])
        self.assertIsNone(answer["ways"][0]["trouble"])
        self.assertIn("404", answer["ways"][1]["trouble"])
        self.assertIn("A test by eva", message(peers.got("mail"))["Subject"])
        self.wait("the event", lambda: [user for _, _, user in self.events(station, "alarm_sent")] == ["eva"])
        self.wait("its trouble", lambda: self.events(station, "alarm_not_sent"))
        kept = station.get("alarms")
        check_schema(kept, "http-alarms")
        self.assertEqual([(way["test"]["user"], way["test"]["trouble"]) for way in kept["ways"]], [("eva", way["trouble"]) for way in answer["ways"]])
        for secret in ("/refuses", "a token"):
            self.assertNotIn(secret, self.told(station) + json.dumps(answer))

    def test_a_station_that_tells_nobody_says_so(self):
        station = self.station("")
        self.assertEqual(station.get("alarms"), {"ways": []})
        status, answer = self.post(station, "alarms/test", {"user": "eva"})
        self.assertEqual((status, answer["error"]["where"]), (400, "alarms"))

    @unittest.skipUnless(BROWSER and DRIVER, "no Chromium: skipped")
    def test_the_page_says_who_is_told_and_sends_a_test(self):
        peers = self.peers()
        station = self.station(mail_table(peers.mail) + webhook_table(peers.webhook, "/refuses"))
        browser = Browser()
        self.addCleanup(browser.close)
        browser.go(station.url + "#records")
        browser.wait_for_text("#alarms-ways", f"Mail to {TO}: nothing sent since soakd was started")
        browser.type("#user", "Eva")
        browser.click("#alarms-test")
        browser.wait_for_text("#alarms-news", f"The server has taken it: Mail to {TO}")
        browser.wait_for_text("#alarms-failure", "404")
        for state in ("sent", "loaded again"):
            with self.subTest(state=state):
                browser.wait_for_text("#alarms-ways li:nth-child(1)", f"Mail to {TO}: last sent ")
                browser.wait_for_text("#alarms-ways li:nth-child(1)", ", by Eva: the server took it")
                browser.wait_for_text("#alarms-ways li:nth-child(2)", ", by Eva: the server answers 404")
            browser.go(station.url + "#records")
        self.assertIn("A test by Eva", message(peers.got("mail"))["Subject"])
        self.assertEqual(browser.poor_contrast(), [])
        self.assertEqual(browser.console(), [])


if __name__ == "__main__":
    unittest.main()
