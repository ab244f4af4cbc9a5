# SPDX-License-Identifier: Apache-2.0
"""A real `soakd` that others may reach: TLS, accounts, a stored run. And who asks it: Python's own TLS and HTTP, and bare sockets."""
import http.client
import json
import os
import pathlib
import socket
import ssl
import subprocess
import sys
import urllib.parse

from real_soakd import Soakd, programs

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import recording  # noqa: E402

ROLES = {"vera": "viewer", "otto": "operator", "eva": "engineer"}
UNIT = "SN0042"
PATIENCE_S = 60


def password_of(name):
    return f"the password of {name}"


class GuardedStation(Soakd):
    settings = 'allowed_hosts = ["soak.lab.example"]\n'

    def store_all(self):
        os.umask(0o022)
        for name, role in ROLES.items():
            self.user("add", name, "--role", role, password=password_of(name))
        (self.folder / "run.csv").write_text(recording(1, "r1", (0.0,), 10), encoding="utf-8")
        self.soak("import", str(self.folder / "run.csv"), "--unit", UNIT, "--gravity-mps2", "9.80665")

    def user(self, *words, password=None):
        return subprocess.run([programs() / "soak", "user", *words, "--data", self.data], check=True, capture_output=True, text=True,
                              input=None if password is None else password + "\n").stdout

    @property
    def certificate(self):
        return self.data / "soakd.crt"

    @property
    def port(self):
        return urllib.parse.urlparse(self.url).port

    def trust(self):
        """A context of TLS that trusts this station alone, and compares names."""
        return ssl.create_default_context(cafile=str(self.certificate))

    @property
    def origin(self):
        return f"https://localhost:{self.port}"

    def ask(self, method, path, body=None, headers=None, source="127.0.0.1"):
        """(status, headers, body) of one request. `body`: sent as JSON where it is no text."""
        connection = http.client.HTTPSConnection("localhost", self.port, timeout=PATIENCE_S, context=self.trust(), source_address=(source, 0))
        try:
            text = body if body is None or isinstance(body, (str, bytes)) else json.dumps(body)
            connection.request(method, path, text, headers or {})
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read().decode(errors="replace")
        finally:
            connection.close()

    def page_headers(self, cookie=None):
        """What a page of the station sends with a command."""
        headers = {"Content-Type": "application/json", "X-Requested-With": "soak", "Origin": self.origin}
        return {**headers, "Cookie": cookie} if cookie else headers

    def post(self, path, body, cookie=None, source="127.0.0.1"):
        return self.ask("POST", "/api/v1/" + path, body, self.page_headers(cookie), source)

    def log_in(self, name, password=None, source="127.0.0.1"):
        return self.post("login", {"name": name, "password": password or password_of(name)}, source=source)

    def cookie(self, name):
        """That of a new session."""
        status, headers, body = self.log_in(name)
        assert status == 200, body
        return headers["Set-Cookie"].split(";")[0]

    def token(self, name, label, *options):
        return self.user("token", name, "--label", label, *options).strip()

    def bare(self):
        """A connection without TLS."""
        return socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE_S)

    def raw(self, request):
        """The whole answer to bytes that are sent over TLS as they are."""
        with self.trust().wrap_socket(self.bare(), server_hostname="localhost") as wire:
            try:
                wire.sendall(request)
            except OSError:
                pass  # refused before all of it was sent
            return read_all(wire)


def read_all(wire):
    """To the end of a connection, also where it is cut off."""
    text = b""
    try:
        while piece := wire.recv(65536):
            text += piece
    except (ConnectionError, ssl.SSLError):
        pass
    return text
