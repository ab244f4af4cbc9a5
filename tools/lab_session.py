# SPDX-License-Identifier: Apache-2.0
"""A station before a simulated laboratory, for the demo, the long proofs and the tests: starts `soaksim` and `soakd` as a
user would, calls `soak`, ends both."""
import json
import os
import shutil
import signal
import socket
import subprocess
import time

# The checkout, or share/soak of what a package has installed.
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
IS_CHECKOUT = os.path.exists(os.path.join(ROOT, "CMakeLists.txt"))
PAGE_PORT = 8088


class ProgramFailed(Exception):
    """A program of ours ended with a status other than 0."""


def bin_folder():
    built = os.path.join(ROOT, "build", "release", "bin") if IS_CHECKOUT else os.path.join(ROOT, "..", "..", "bin")
    return os.environ.get("SOAK_BIN_FOLDER", os.path.normpath(built))


def procedure(name):
    return os.path.join(ROOT, "procedures", name + ".toml")


def call(*words, env=None):
    """Runs a program of ours; returns its standard output."""
    command = [os.path.join(bin_folder(), words[0]), *map(str, words[1:])]
    result = subprocess.run(command, capture_output=True, text=True, env=env)
    if result.returncode != 0:
        raise ProgramFailed(f"{' '.join(command)}\nended with status {result.returncode}:\n{result.stdout}{result.stderr}")
    return result.stdout


def page_address():
    """The usual address of the page where it is free, else any."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", PAGE_PORT))
        except OSError:
            return "127.0.0.1:0"
    return f"127.0.0.1:{PAGE_PORT}"


def first_line(process, log):
    """What the program prints first. It prints nothing where it could not start: then its log says why."""
    line = process.stdout.readline().strip()
    if not line:
        process.wait()
        with open(log, encoding="utf-8") as f:
            raise ProgramFailed(f"{process.args[0]} ended with status {process.returncode}:\n{f.read()}")
    return line


class LabSession:
    """with LabSession(folder) as lab: both programs run. Everything lies in `folder`: station.toml, data, two logs."""

    def __init__(self, folder, seed=1, units=3, rate=2000, listen="127.0.0.1:0"):
        self.folder = str(folder)
        self.data = os.path.join(self.folder, "data")
        self.seed, self.units = seed, units
        self.rate, self.listen = rate, listen
        self.soaksim = self.soakd = None
        self.ports = {}
        self.page = ""

    def __enter__(self):
        os.makedirs(self.folder, exist_ok=True)
        try:
            self.start_soaksim()
            self.start_soakd()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        # soakd first: it wants to leave the chamber in the safe state.
        for process in (self.soakd, self.soaksim):
            end(process)

    def start(self, program, *options):
        log = os.path.join(self.folder, program + ".log")
        with open(log, "a", encoding="utf-8") as log_file:
            process = subprocess.Popen([os.path.join(bin_folder(), program), *map(str, options)], text=True,
                                       stdout=subprocess.PIPE, stderr=log_file, stdin=subprocess.DEVNULL)
        return process, log

    def start_soaksim(self, *options):
        self.soaksim, log = self.start("soaksim", "--out", self.folder, "--seed", self.seed, "--units", self.units,
                                       "--rate", self.rate, "--maps", os.path.join(ROOT, "procedures"), *options)
        self.ports = json.loads(first_line(self.soaksim, log))

    def start_soakd(self, config=None):
        self.soakd, log = self.start("soakd", "--config", config or os.path.join(self.folder, "station.toml"),
                                     "--listen", self.listen, "--data", self.data)
        self.page = first_line(self.soakd, log)

    @property
    def env(self):
        return {**os.environ, "SOAK_DATA": self.data, "SOAK_STATION": self.page.split("//")[-1].rstrip("/")}

    def soak(self, *words):
        return call("soak", *words, env=self.env)

    def soak_json(self, *words):
        return json.loads(self.soak(*words, "--json"))

    def status(self):
        return self.soak_json("campaign", "status")

    def truth(self):
        """What only the simulator knows of its units."""
        return json.loads(call("soaksim-truth", "--seed", self.seed, "--units", self.units))

    def wait_for(self, what, condition, seconds=120.0):
        """Waits until `condition(status)` holds; returns that status."""
        end_s = time.monotonic() + seconds
        while True:
            status = self.status()
            if condition(status):
                return status
            if time.monotonic() > end_s:
                raise ProgramFailed(f"waited {seconds:.0f} s for: {what}\n{json.dumps(status, indent=1)}\n{self.log()}")
            time.sleep(0.02)

    def log(self):
        with open(os.path.join(self.folder, "soakd.log"), encoding="utf-8") as f:
            return f.read()


def end(process):
    """Ends a program, by force where it does not within a minute."""
    if process is None:
        return
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    process.stdout.close()


def fresh_folder(path):
    shutil.rmtree(path, ignore_errors=True)
    os.makedirs(path)
    return path
