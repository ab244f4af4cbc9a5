# SPDX-License-Identifier: Apache-2.0
"""One campaign judged by ours, by the oracle and by quick statistics: a JSON object, a line in the benchmark's file.

{"cell", "table", "design", "effects", "magnitude", "seed": what was planned (cells.py),
 "verdict", "names", "suspects", "residual_structure", "sizes", "p_adjusted": of `soak gap find`,
 "set": the first name and those that it cannot be told from,
 "closed": {sensor of the first name: fraction | null},
 "oracle": [the most likely candidate, the most likely pair: {"names", "ratio"}], "naive": {"name", "log_p"},
 "cpu_s": {"generate", "import", "fit", "find", "judge"}}, the last for oracle and quick statistics;
"error" in the place of what follows the seed where a program failed.
"""
import time

import naive
import oracle
from blind_campaign import Campaign, temporary_folder
from blocks import Blocks, Recording
from cells import DESIGNS


def judged(programs, cell, seed):
    """The record. A program that fails leaves {"error"} in the place of verdicts."""
    record = {"cell": cell.name(), "table": cell.table, "design": cell.design, "effects": list(cell.effects),
              "magnitude": cell.magnitude, "seed": seed}
    programs.cpu_s.clear()
    try:
        with temporary_folder() as folder:
            record.update(verdicts(programs, folder, cell, seed))
    except RuntimeError as error:
        record["error"] = str(error)
    record["cpu_s"] = {stage: round(cpu_s, 3) for stage, cpu_s in programs.cpu_s.items()}
    return record


def verdicts(programs, folder, cell, seed):
    candidates = cell.candidates(seed)
    design = dict(DESIGNS[cell.design], **({"contributions": True} if candidates else {}))
    campaign = Campaign(programs, folder, seed, design, cell.hidden(seed), candidates)
    # Thirteen plateaus of a single run are too few for three rules.
    found = ours(campaign.report(rules=2 if cell.design == "one" else 3))
    if candidates:
        start_s = time.process_time()
        blocks = Blocks(Recording(campaign.csv))
        found["oracle"] = oracle.most_likely(blocks, campaign.truth)
        found["naive"] = naive.quick_name(blocks)
        programs.cpu_s["judge"] = time.process_time() - start_s
    return found


def ours(report):
    """What the tables need of `soak gap find --json`."""
    effects = report["effects"]
    gap = report["gap"]
    first = effects[0]["sensors"] if effects else []
    return {"verdict": report["verdict"], "names": [effect["name"] for effect in effects],
            "set": [name for effect in effects[:1] for name in (effect["name"], *effect["confusable_with"])],
            "suspects": [effect["name"] for effect in report["suspects"]],
            "residual_structure": report["residual_structure"]["axis"] if report["residual_structure"] else None,
            "sizes": [effect["magnitude"] for effect in effects],
            "p_adjusted": [effect["evidence"]["p_adjusted"] for effect in effects],
            "closed": {sensor: gap[sensor]["closed_fraction"] for sensor in first if sensor in gap}}
