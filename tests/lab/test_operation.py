#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What an operator has of a running station: metrics for Prometheus with a dashboard, a backup while it records, a configuration to
begin with."""
import json
import os
import pathlib
import re
import signal
import subprocess
import unittest
import urllib.request
from unittest import mock

import bench
from bench import ROOT, LabTest, short_procedure
from lab_session import bin_folder

# Measured: 23 to 41 kB a campaign, of the log of events and of SQLite's pages, which are bounded. The three units of one hold 0.9 MB.
GROWTH_PER_CAMPAIGN_BYTES = 120e3

NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"
LABEL = r'[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\["\\n])*"'
SAMPLE = re.compile(rf"({NAME})(?:\{{({LABEL}(?:,{LABEL})*)\}})? (-?[0-9.]+(?:e[+-]?[0-9]+)?|NaN|[+-]Inf)")


def parsed(text):
    """{metric: {labels: value}} of a page in Prometheus' text format 0.0.4; fails where the format is broken: a sample without its
    HELP and TYPE before it, samples of one name that do not stand together, a metric or sample twice."""
    metrics, types, current = {}, {}, None
    if not text.endswith("\n"):
        raise ValueError("the last line has no end")
    for line in text.splitlines():
        if match := re.fullmatch(rf"# HELP ({NAME}) (.+)", line):
            current = match.group(1)
            if current in metrics:
                raise ValueError(f"twice: {current}")
            metrics[current] = {}
        elif match := re.fullmatch(rf"# TYPE ({NAME}) (gauge|counter)", line):
            if match.group(1) != current or metrics[current]:
                raise ValueError(line)
            types[current] = match.group(2)
        elif match := SAMPLE.fullmatch(line):
            name, labels, value = match.groups()
            if name != current or name not in types or labels in metrics[name]:
                raise ValueError(line)
            if types[name] == "counter" and not name.endswith("_total"):
                raise ValueError(line)
            metrics[name][labels] = float(value)
        else:
            raise ValueError(line)
    return metrics


def dashboard_metrics():
    document = json.loads((ROOT / "packaging" / "grafana" / "soak.json").read_text(encoding="utf-8"))
    text = json.dumps([panel["targets"] for panel in document["panels"]] + document["templating"]["list"])
    return set(re.findall(r"soak_[a-z_]+", text))


def documented_metrics():
    """Those of docs/operations.md; a name that begins with _ goes on as the one before it."""
    found = set()
    for line in (ROOT / "docs" / "operations.md").read_text(encoding="utf-8").splitlines():
        if not line.startswith("| `soak_"):
            continue
        names = re.findall(r"`(_?[a-z_]+)(?:\{[^}]*\})?`", line.split("|")[1])
        stem = "_".join(names[0].split("_")[:2])
        found |= {stem + name if name.startswith("_") else name for name in names}
    return found


class Operation(LabTest):
    def metrics(self):
        with urllib.request.urlopen(self.lab.page + "metrics", timeout=30) as answer:
            self.assertEqual(answer.headers["Content-Type"], "text/plain; version=0.0.4; charset=utf-8")
            return parsed(answer.read().decode())

    def test_metrics_say_what_the_status_says(self):
        self.start_lab(units=2)
        idle = self.metrics()
        self.assertEqual(idle["soak_state"]['state="idle"'], 1)
        self.assertEqual(sum(idle["soak_state"].values()), 1)
        self.start_campaign(short_procedure())
        self.wait_for_step("record")
        metrics = self.metrics()
        status = self.status()
        self.assertEqual(len(metrics["soak_unit_temperature_celsius"]), 2)
        for unit in status["units"]:
            labels = f'slot="{unit["slot"]}",serial="{unit["serial"]}"'
            self.assertEqual(metrics["soak_unit_streaming"][labels], 1)
            self.assertLess(abs(metrics["soak_unit_temperature_celsius"][labels] - unit["temp_c"]), 2.0)
            self.assertLessEqual(metrics["soak_unit_samples_total"][labels], unit["samples"])
        self.assertEqual(metrics["soak_campaign_steps"][None], status["campaign"]["steps"])
        self.assertEqual(metrics["soak_chamber_connected"][None], 1)
        self.assertEqual((sum(metrics["soak_suspended"].values()), metrics["soak_queue_campaigns"][None]), (0, 0))
        self.assertGreater(metrics["soak_disk_free_bytes"][None], 0)
        # Of a supply or a humidity sensor that the simulated laboratory lacks nothing is told.
        absent = {"soak_unit_supply_volts", "soak_unit_supply_amperes", "soak_chamber_humidity_percent"}
        self.assertLessEqual(set(metrics), documented_metrics())
        self.assertLessEqual(documented_metrics() - absent, set(metrics))
        self.assertLessEqual(dashboard_metrics(), documented_metrics())

    def test_memory_in_use_does_not_grow_from_campaign_to_campaign(self):
        """Not the resident memory, which depends on the heap: what is allocated and not given back."""
        self.start_lab(units=3, rate=2000)
        procedure = self.write("procedure.toml", short_procedure(set_points=(25,), positions=("+Z",)))
        for _ in range(640):  # each of the server's threads keeps a little once it has answered
            self.metrics()

        def heap_after(campaigns):
            for name in campaigns:
                self.lab.soak("campaign", "start", procedure, "--name", name)
                self.assertEqual(self.wait_for_end()["state"], "finished")
            return self.metrics()["soak_heap_bytes"][None]

        before = heap_after(f"a{i}" for i in range(5))
        self.assertGreater(before, 1e6)
        self.assertLess(heap_after(f"b{i}" for i in range(5)) - before, 5 * GROWTH_PER_CAMPAIGN_BYTES)

    def test_a_watch_over_tls_that_is_interrupted_says_that_the_campaign_goes_on(self):
        def for_others(text):
            subprocess.run([bin_folder() + "/soak", "user", "add", "eva", "--role", "engineer", "--data", self.lab.data], check=True,
                           input="a long password\n", text=True, capture_output=True)
            return 'allowed_hosts = ["soak.lab.example"]\n' + text
        self.start_lab(edit=for_others)
        token = self.write("token", self.lab.soak("user", "token", "eva", "--label", "watch"))
        environment = {**self.lab.env, "SOAK_STATION": self.lab.page, "SOAK_CERTIFICATE": self.lab.data + "/soakd.crt",
                       "SOAK_TOKEN_FILE": str(token)}
        campaign = [bin_folder() + "/soak", "campaign"]
        endless = self.write("procedure.toml", short_procedure(set_points=(60,), positions=("+Z",), dwell_s=100000))
        subprocess.run([*campaign, "start", str(endless), "--name", "c"], env=environment, check=True, capture_output=True)
        with subprocess.Popen([*campaign, "watch"], env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as watch:
            self.assertTrue(watch.stdout.readline())
            watch.send_signal(signal.SIGINT)
            _, message = watch.communicate(timeout=bench.WAIT_S)
        self.assertEqual(watch.returncode, 1, message)
        self.assertIn("stopped watching; the campaign continues", message)

    def test_a_backup_is_made_while_a_run_is_recorded(self):
        self.start_lab()
        self.start_campaign(short_procedure(set_points=(15, 20, 30), runs=2))
        self.wait_for_step("record", "R02")
        place = self.folder / "backup"
        summary = self.lab.soak_json("backup", place)
        self.check_schema(summary, "backup")
        self.assertEqual(summary["damaged"], [])
        open_files = {file["file"] for file in summary["still_open"]}
        on_disk = {path.name for path in (pathlib.Path(self.lab.data) / "runs").glob("*.soakrun")}
        self.assertEqual(open_files | set(summary["copied"]), on_disk)
        self.assertTrue(open_files)
        done = subprocess.run([bin_folder() + "/soak", "runs", "verify", "--data", str(place)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.wait_for_end()
        again = self.lab.soak_json("backup", place)
        self.assertEqual((again["still_open"], set(again["kept"])), ([], set(summary["copied"])))
        self.assertLessEqual(open_files, set(again["copied"]))

    def test_a_sealed_run_file_is_on_the_disk_with_its_name(self):
        """The catalog's row holds the hash of the sealed file, which is taken after that."""
        log = self.folder / "disk.log"
        layer = {"LD_PRELOAD": os.environ["SOAK_DISK_LAYER"], "SOAK_DISK_FOLDER": str(self.folder), "SOAK_DISK_LOG": str(log)}
        with mock.patch.dict(os.environ, layer):
            self.start_lab()
        self.start_campaign(short_procedure())
        self.assertEqual(self.wait_for_end()["state"], "finished")
        changes = [line.split(" ") for line in log.read_text(encoding="utf-8").splitlines()]
        for (name,) in self.query("SELECT DISTINCT file_name FROM run"):
            path = pathlib.Path(self.lab.data) / "runs" / name
            created = changes.index(["create", str(path)])
            self.assertIn(["sync", str(path.parent)], changes[created:])
            last = max(i for i, change in enumerate(changes) if change[0] in ("write", "truncate") and change[1] == str(path))
            synced = [i for i, change in enumerate(changes) if change == ["sync", str(path)] and i > last]
            self.assertTrue(synced, changes[last:])
            self.assertIn(["sync", str(path.parent)], changes[synced[0]:])
            self.assertTrue([c for c in changes[synced[0]:] if c[0] == "write" and c[1].endswith("station.db-wal")])

    def test_the_configuration_to_begin_with_is_one(self):
        done = subprocess.run([bin_folder() + "/soakd", "--write-config"], capture_output=True, text=True, check=True)
        template = self.write("template.toml", done.stdout)
        # With every suggestion taken, and with none: only devices are missing.
        everything = re.sub(r"(?m)^# (\[+[a-z.]+\]+|[a-z_]+ = .*)$", r"\1", done.stdout)
        self.assertGreater(everything.count("\n["), done.stdout.count("\n[") + 3)
        for drop in ("host", "from", "power_output"):
            everything = re.sub(rf"(?m)^{drop} = .*\n", "", everything, count=0 if drop == "power_output" else 1)
        for path in (template, self.write("everything.toml", everything)):
            checked = subprocess.run([bin_folder() + "/soak", "doctor", "--config", str(path), "--data", str(self.folder / "data"), "--json"],
                                     capture_output=True, text=True, env={**os.environ})
            checks = {check["subject"]: check for check in json.loads(checked.stdout)["checks"]}
            self.assertNotIn("configuration", checks, path.name)
            self.assertIn("slot 1", checks)
        keys = set(re.findall(r"(?m)^(?:# )?([a-z_]+) = ", done.stdout))
        documented = set(re.findall(r"`([a-z_]+)`", (ROOT / "docs" / "station-config.md").read_text(encoding="utf-8")))
        self.assertLessEqual(keys, documented)


if __name__ == "__main__":
    bench.main()
