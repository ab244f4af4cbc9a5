# SPDX-License-Identifier: Apache-2.0
"""One blind campaign: made up by soaksim-campaign, seen by soak only as CSV, judged by `soak gap find --json`.

The truth file lies outside of the data folder and is read here, never by soak.
"""
import contextlib
import json
import os
import pathlib
import resource
import subprocess
import tempfile

UNIT = "BLIND"


class Programs:
    """The programs under test, the magnitudes that the simulator starts from, and the CPU time that each program took."""

    def __init__(self, bin_folder, lab_toml):
        self.bin = pathlib.Path(bin_folder)
        self.lab = pathlib.Path(lab_toml).read_text(encoding="utf-8")
        self.cpu_s = {}

    def run(self, name, *arguments, env=None, stage=None):
        """Standard output of a program. Its CPU time, with that of other children of this process that end meanwhile, is
        kept under `stage`."""
        before_s = children_cpu_s()
        done = subprocess.run([str(self.bin / name), *map(str, arguments)], capture_output=True, text=True, env=env,
                              check=False)
        self.cpu_s[stage or name] = self.cpu_s.get(stage or name, 0.0) + children_cpu_s() - before_s
        if done.returncode != 0:
            raise RuntimeError(f"{name} {' '.join(map(str, arguments))}: status {done.returncode}: {done.stderr}")
        return done.stdout


def children_cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def configuration(lab, design, hidden, candidates):
    """lab.toml with the design's keys and one table per effect."""
    text = lab
    if design:
        text += "\n[design]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in design.items())
    for table, effects in (("hidden", hidden), ("candidate", candidates)):
        for effect in effects:
            text += f"\n[[{table}]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in effect.items())
    return text


class Campaign:
    """A campaign in a folder of its own: the recording `csv` (a path) and the truth, as it was read."""

    def __init__(self, programs, folder, seed, design, hidden, candidates=()):
        self.programs, self.folder = programs, pathlib.Path(folder)
        config = self.folder / "lab.toml"
        config.write_text(configuration(programs.lab, design, hidden, candidates), encoding="utf-8")
        programs.run("soaksim-campaign", "--out", self.folder / "csv", "--seed", seed, "--units", 1, "--config", config,
                     "--truth", self.folder / "truth.json", stage="generate")
        self.csv = next((self.folder / "csv" / "campaign").glob("*.csv"))
        self.truth = json.loads((self.folder / "truth.json").read_text(encoding="utf-8"))

    def report(self, rules=3):
        """What `soak gap find --json` says of the recording."""
        return report_of(self.programs, self.folder, self.csv, rules)


def report_of(programs, folder, csv, rules=3, options=()):
    """What `soak gap find --json` says of a recording, with a data folder in `folder`. `options`: more of the import."""
    env = dict(os.environ, SOAK_DATA=str(pathlib.Path(folder) / "data"))
    programs.run("soak", "import", csv, "--unit", UNIT, "--gravity-mps2", "9.80665", *options, env=env, stage="import")
    programs.run("soak", "fit", "--unit", UNIT, "--rules", rules, "--jobs", 1, env=env, stage="fit")
    return json.loads(programs.run("soak", "gap", "find", "--unit", UNIT, "--json", env=env, stage="find"))


@contextlib.contextmanager
def temporary_folder():
    """In memory where the system has a place for that and TMPDIR does not say otherwise: sealing waits for the disk."""
    memory = pathlib.Path("/dev/shm")
    in_memory = "TMPDIR" not in os.environ and memory.is_dir() and os.access(memory, os.W_OK)
    with tempfile.TemporaryDirectory(prefix="soak-blind-", dir=memory if in_memory else None) as name:
        yield name


def judge(programs, seed, design, hidden, rules=3):
    """What `soak gap find --json` says of a campaign of that seed, and what was hidden in it."""
    with temporary_folder() as folder:
        campaign = Campaign(programs, folder, seed, design, hidden)
        return campaign.report(rules), campaign.truth
