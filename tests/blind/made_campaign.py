# SPDX-License-Identifier: Apache-2.0
"""For the tests of the judges: one campaign of the simulator, without soak."""
import functools
import os
import pathlib

from blind_campaign import Campaign, Programs, temporary_folder
from blocks import Blocks, Recording
from cells import DESIGNS, EFFECTS

ROOT = pathlib.Path(__file__).resolve().parents[2]


@functools.lru_cache
def made(design, effects=(), magnitude=0.3, seed=1):
    """(Blocks, truth) of a design of cells.DESIGNS with `effects` hidden in it; every effect is a candidate."""
    programs = Programs(pathlib.Path(os.environ["SOAK_SIM_BIN"]).parent, ROOT / "hal" / "sim" / "lab.toml")
    hidden, candidates = ([{"effect": name, "magnitude": magnitude, "seed": seed} for name in names] for names in (effects, EFFECTS))
    with temporary_folder() as folder:
        campaign = Campaign(programs, folder, seed, {**DESIGNS[design], "contributions": True}, hidden, candidates)
        return Blocks(Recording(campaign.csv)), campaign.truth
