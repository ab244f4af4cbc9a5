# SPDX-License-Identifier: Apache-2.0
"""One campaign of the second laboratory, through find and accept, and what that closes on runs that no fit has seen."""
from __future__ import annotations

import json
import os
import pathlib

from blind_campaign import Programs, UNIT, temporary_folder
from second_laboratory import Design, make

ROOT = pathlib.Path(__file__).resolve().parents[2]
FITTED = 6
DESIGN = Design(positions="permuted", ramps="two", slow=0.4, runs=FITTED + 2)
COLUMNS = {"gx": "gyro_x", "gy": "gyro_y", "gz": "gyro_z", "ax": "accel_x", "ay": "accel_y", "az": "accel_z"}


def parts_of(text: str) -> tuple[str, str]:
    """The recording's first FITTED runs, and the others."""
    head, *rows = text.splitlines(keepends=True)
    run = head.split(",").index("run")
    seen = [int(row.split(",")[run].removeprefix("run")) <= FITTED for row in rows]
    return (head + "".join(row for row, fitted in zip(rows, seen) if fitted),
            head + "".join(row for row, fitted in zip(rows, seen) if not fitted))


def accepted_and_closed(programs_folder: pathlib.Path, seed: int, effect: str, size: float,
                        design: Design = DESIGN) -> tuple[list[str], dict[str, float]]:
    """Names that were accepted (none: nothing was named), and for the sensors that the effect acts on, where the gap is large
    enough to be told, the share of it that is closed on the fresh runs."""
    campaign = make(seed, design, effect, size)
    programs = Programs(programs_folder, ROOT / "hal" / "sim" / "lab.toml")
    with temporary_folder() as name:
        folder = pathlib.Path(name)
        for part, text in zip(("fitted", "fresh"), parts_of(campaign.csv)):
            (folder / f"{part}.csv").write_text(text, encoding="utf-8")
        env = dict(os.environ, SOAK_DATA=str(folder / "data"))
        place = ("--unit", UNIT, "--gravity-mps2", "9.80665")
        programs.run("soak", "import", folder / "fitted.csv", *place, env=env)
        programs.run("soak", "import", folder / "fresh.csv", *place, "--procedure", "verification", "--campaign", "fresh", env=env)
        programs.run("soak", "fit", "--unit", UNIT, "--rules", 2, "--jobs", 1, env=env)
        try:
            terms = json.loads(programs.run("soak", "gap", "accept", "--unit", UNIT, "--json", env=env))["terms"]
        except RuntimeError as error:
            if "nothing to accept" not in str(error):
                raise
            return [], {}
        shown = json.loads(programs.run("soak", "gap", "show", "--unit", UNIT, "--json", env=env))["sensors"]
    acts_on = [COLUMNS[column] for column in campaign.truth["sensors"]]
    fractions = {sensor: shown[sensor]["fresh"]["closed_fraction"] for sensor in acts_on}
    return [term["name"] for term in terms], {sensor: closed for sensor, closed in fractions.items() if closed is not None}
