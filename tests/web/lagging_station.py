# SPDX-License-Identifier: Apache-2.0
"""A real `soakd` with all that its pages can show: a unit whose elements lag among others of its type, a run with a refused segment, references."""
import os
import shutil

from test_runs import wrong_face  # first: others put a folder in front that has a module of this name, too
from lagging_unit import LAGGING, ROOT, lagging_recordings, simulate
from test_units import LIMITS, UnitStation, recording

REFUSED_RUN = "R09"  # with a segment that the data gate refuses
OTHERS = 3  # units of the same type


class LaggingStation(UnitStation):
    """With the procedures and types that are shipped."""

    def store_all(self):
        shutil.copytree(ROOT / "procedures", self.types, dirs_exist_ok=True)
        self.limits(LIMITS)
        os.environ["SOAK_PROCEDURES"] = str(self.types)  # reports judge by the same limits as the page; close() takes it back
        five, sixth = lagging_recordings(self.folder)
        self.store(five, LAGGING, "--campaign", "spring")
        self.store(sixth, LAGGING, "--campaign", "check", "--procedure", "verification")
        refused = self.folder / f"{REFUSED_RUN}.csv"
        refused.write_text(wrong_face(recording(1, REFUSED_RUN, (0.0, 20.0, 40.0), 60)), encoding="utf-8")
        self.store(refused, "SN0050", "--campaign", "autumn")
        simulate(self.folder / "others", "--seed", 7, "--units", OTHERS, "--runs", 2, "--rows-per-position", 4)
        for path in sorted((self.folder / "others" / "campaign").glob("*.csv")):
            self.store(path, path.stem, "--campaign", path.stem)
            self.soak("fit", "--unit", path.stem)

    def store(self, path, unit, *words):
        self.soak("import", path, "--unit", unit, "--type", "generic", "--gravity-mps2", "9.80665", "--simulated", *words)

    def work_through(self):
        """What somebody at the page would have done by now: the unit fitted, verified and searched for what its model lacks; certificates."""
        for job in ({"kind": "fit"}, {"kind": "verify", "campaign": "check"}, {"kind": "gap_find"}):
            assert self.ended(self.post("jobs", unit=LAGGING, user="Eva", **job))["state"] == "done"
        for kind, name, due, value in (("gravity", "Pillar 1", "2099-03-02", 9.8123), ("level", "Granite table", "2025-03-02", 0.0125)):
            self.post("references/add", kind=kind, name=name, certificate="K-17", issued="2024-03-01", due=due, uncertainty=0.002, k=2, correction=value, user="Eva")

    def names(self):
        """What stands in addresses of the page."""
        run = next(run for run in self.get("runs")["runs"] if run["run"] == REFUSED_RUN)
        return {"run": run["run_id"], "run_unit": run["unit"], "unit": LAGGING}
