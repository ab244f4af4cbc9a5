# SPDX-License-Identifier: Apache-2.0
"""One blind campaign: made up by soaksim-campaign, seen by soak only as CSV, judged by `soak gap find --json`.

The truth file lies outside of the data folder and is read here, never by soak.
"""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

UNIT = "BLIND"


class Programs:
    """The programs under test, and the magnitudes that the simulator starts from."""

    def __init__(self, bin_folder, lab_toml):
        self.bin = pathlib.Path(bin_folder)
        self.lab = pathlib.Path(lab_toml).read_text(encoding="utf-8")

    def run(self, name, *arguments, env=None):
        done = subprocess.run([str(self.bin / name), *map(str, arguments)], capture_output=True, text=True, env=env,
                              check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{name} {' '.join(map(str, arguments))}: status {done.returncode}: {done.stderr}")
        return done.stdout


def configuration(lab, design, hidden):
    """lab.toml with the design's keys and one [[hidden]] table per effect."""
    text = lab
    if design:
        text += "\n[design]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in design.items())
    for effect in hidden:
        text += "\n[[hidden]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in effect.items())
    return text


def judge(programs, seed, design, hidden, rules=3):
    """What `soak gap find --json` says of a campaign of that seed, and what was hidden in it."""
    with tempfile.TemporaryDirectory(prefix="soak-blind-") as name:
        folder = pathlib.Path(name)
        config = folder / "lab.toml"
        config.write_text(configuration(programs.lab, design, hidden), encoding="utf-8")
        programs.run("soaksim-campaign", "--out", folder / "csv", "--seed", seed, "--units", 1, "--config", config,
                     "--truth", folder / "truth.json")
        env = dict(os.environ, SOAK_DATA=str(folder / "data"))
        csv = next((folder / "csv" / "campaign").glob("*.csv"))
        programs.run("soak", "import", csv, "--unit", UNIT, "--gravity-mps2", "9.80665", env=env)
        shutil.rmtree(folder / "csv")
        programs.run("soak", "fit", "--unit", UNIT, "--rules", rules, "--jobs", 1, env=env)
        report = json.loads(programs.run("soak", "gap", "find", "--unit", UNIT, "--json", env=env))
        truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    return report, truth
