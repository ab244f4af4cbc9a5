# SPDX-License-Identifier: Apache-2.0
"""A real `soakd` ($SOAK_BIN_FOLDER) in a folder of its own."""
import contextlib
import json
import os
import pathlib
import shutil
import socket
import sqlite3
import subprocess
import tempfile
import urllib.parse
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
SLOTS = """
[chamber]
map = "{procedures}/chambers/watlow-f4t.toml"
host = "127.0.0.1"
port = {port}

[[slot]]
name = "1"
host = "127.0.0.1"
port = {unit_port}
decoder = "xsens"
"""


def programs():
    return pathlib.Path(os.environ.get("SOAK_BIN_FOLDER", ROOT / "build" / "release" / "bin"))


def unused_ports(count):
    """Ports at which nothing answers."""
    with contextlib.ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]


class Soakd:
    """A station with nobody at its devices; what it has stored its test says in store_all()."""
    settings = ""  # before the tables of its configuration

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-station-"))
        self.data = self.folder / "data"
        self.store_all()
        port, unit_port = unused_ports(2)
        self.config = self.folder / "station.toml"
        self.config.write_text(self.settings + SLOTS.format(procedures=ROOT / "procedures", port=port, unit_port=unit_port), encoding="utf-8")
        self.log = open(self.folder / "soakd.log", "w", encoding="utf-8")
        self.process = None
        self.start()

    def start(self):
        """Also after the one before has ended."""
        if self.process:
            self.process.stdout.close()
        command = [programs() / "soakd", "--config", self.config, "--data", self.data, "--listen", "127.0.0.1:0"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.log, text=True)
        self.url = self.process.stdout.readline().strip()
        assert self.url, (self.folder / "soakd.log").read_text(encoding="utf-8")

    def soak(self, *words):
        return subprocess.run([programs() / "soak", *words, "--data", self.data], check=True, capture_output=True, text=True).stdout

    def soak_json(self, *words):
        return json.loads(self.soak(*words, "--json"))

    def get(self, path, **parameters):
        question = urllib.parse.urlencode(parameters, doseq=True)
        with urllib.request.urlopen(f"{self.url}api/v1/{path}?{question}", timeout=30) as answer:
            return json.load(answer)

    def query(self, sql):
        with contextlib.closing(sqlite3.connect(self.data / "station.db")) as catalog:
            return catalog.execute(sql).fetchall()

    def close(self):
        self.process.terminate()
        self.process.wait(30)
        self.process.stdout.close()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)
