# SPDX-License-Identifier: Apache-2.0
"""Recordings of a simulated unit whose sensing elements lag behind its thermometer."""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from lab_session import bin_folder  # noqa: E402

LAGGING = "SN0042"
HIDDEN = '\n[[hidden]]\neffect = "sensor_lag"\nmagnitude = 2.4\nseed = 31\n'


def simulate(folder, *words):
    """soaksim-campaign into `folder`."""
    simulator = os.environ.get("SOAK_SIM_BIN", f"{bin_folder()}/soaksim-campaign")
    subprocess.run([simulator, "--out", folder, *map(str, words)], check=True, capture_output=True)


def lagging_recordings(folder):
    """Two files: five runs of the unit to be fitted, and a sixth that no fit sees."""
    config = folder / "lagging.toml"
    config.write_text((ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8") + HIDDEN, encoding="utf-8")
    simulate(folder / "lagging", "--seed", 31, "--units", 1, "--design", "identical", "--config", config, "--truth", folder / "truth.json")
    head, *rows = next((folder / "lagging" / "campaign").glob("*.csv")).read_text(encoding="utf-8").splitlines(keepends=True)
    run = head.rstrip().split(",").index("run")
    files = folder / "five.csv", folder / "sixth.csv"
    for path, is_sixth in zip(files, (False, True)):
        path.write_text(head + "".join(row for row in rows if (row.split(",")[run] == "R06") == is_sixth), encoding="utf-8")
    return files
