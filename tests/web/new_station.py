# SPDX-License-Identifier: Apache-2.0
"""A `soakd` ($SOAK_BIN_FOLDER) that has no configuration yet, before a simulated laboratory."""
import json
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from lab_session import LabSession, bin_folder, end  # noqa: E402

PATIENCE_S = 60


def unused_port():
    """A port at which nobody answers."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Laboratory:
    """Chamber, fixture and two units, in real time."""

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-lab-"))
        self.session = LabSession(self.folder, units=2, rate=1)
        self.session.start_soaksim()
        self.ports = self.session.ports

    def close(self):
        end(self.session.soaksim)
        shutil.rmtree(self.folder, ignore_errors=True)


def ask(url, path, body=None, **headers):
    """(status, document) of GET, or with a body of POST, of the station at that address."""
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"{url}api/v1/{path}", data, {"Content-Type": "application/json", **headers} if body is not None else headers)
    try:
        with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
            return answer.status, json.load(answer)
    except urllib.error.HTTPError as refusal:
        with refusal:
            return refusal.code, json.load(refusal)


class NewStation:
    def __init__(self, *options):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-new-"))
        self.data = self.folder / "data"
        self.file = self.data / "station.toml"
        self.log = open(self.folder / "soakd.log", "w", encoding="utf-8")
        self.process = None
        self.start(*options)

    def start(self, *options):
        command = [pathlib.Path(bin_folder()) / "soakd", "--data", self.data, "--listen", "127.0.0.1:0", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.log, text=True)
        self.url = self.process.stdout.readline().strip()
        assert self.url, self.said()

    def said(self):
        return (self.folder / "soakd.log").read_text(encoding="utf-8")

    def stop(self):
        """Asks it to end; its exit status."""
        self.process.terminate()
        status = self.process.wait(PATIENCE_S)
        self.process.stdout.close()
        return status

    def ask(self, path, body=None, **headers):
        return ask(self.url, path, body, **headers)

    def events(self):
        done = subprocess.run([pathlib.Path(bin_folder()) / "soak", "events", "list", "--json", "--data", self.data], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)["events"]

    def close(self):
        if self.process.poll() is None:
            self.stop()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)
