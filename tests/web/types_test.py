# SPDX-License-Identifier: Apache-2.0
"""The page's modules fit the types in their comments, those of the interface's documents among them, and a slip is found."""
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
WEB = ROOT / "web"
SCHEMAS = ROOT / "docs" / "schema"
# Types of web/documents.mjs and kept_documents.mjs and what they describe: a schema, and the way to it.
DESCRIBED = {"Status": ("campaign-status", ""), "LiveUnit": ("campaign-status", "units/items"), "Campaign": ("campaign-status", "campaign"),
             "Alarm": ("campaign-status", "alarms/items"),
             "Job": ("http-job", ""), "Unit": ("http-unit", ""), "Model": ("http-unit", "model"), "UnitDrives": ("http-impact", "impact/drives"), "Term": ("http-unit", "model/terms/items"),
             "Warning": ("http-unit", "warnings/items"), "UnitLine": ("http-units", "units/items"), "RunDetail": ("http-run", ""),
             "StoredCampaign": ("http-stored", "campaigns/items"), "Fleet": ("http-fleet", ""), "FleetUnit": ("http-fleet", "units/items"),
             "FleetCurve": ("http-fleet", "$defs/curve"), "FleetLine": ("http-fleet", "$defs/curve/units/items"), "Audit": ("http-audit", ""),
             "Event": ("http-audit", "events/items"), "Chain": ("events-verify", ""), "UnitType": ("http-types", "types/items"),
             "Procedure": ("http-procedures", "procedures/items"), "Reference": ("reference-list", "$defs/entry"),
             "CampaignCheck": ("http-campaign-check", ""), "SlotFinding": ("http-campaign-look", "slots/items"), "GapFind": ("gap-find", ""),
             "Structure": ("gap-find", "residual_structure"), "BiasStep": ("gap-find", "residual_structure/steps/items"), "SlowNoise": ("gap-find", "slow_noise/items"), "Session": ("http-session", ""), "AlarmWay": ("http-alarms", "ways/items"), "StationKey": ("http-key", "key"),
             "SetupChoices": ("http-setup", ""), "SetupMap": ("http-setup", "chambers/items"), "SetupCheck": ("http-setup-check", ""), "StationSettings": ("http-station", ""), "Survey": ("chamber-probe", ""),
             "ModelRows": ("http-model-rows", ""), "RowColumns": ("http-model-rows", "$defs/rows"), "UnitNoise": ("http-unit-noise", "")}


def object_in(node):
    """A node itself, or the object among its alternatives."""
    others = node.get("anyOf", node.get("oneOf", []))
    return next((other for other in others if "properties" in other), node)


def members_of(name, text):
    """Names of the properties of a type: what stands behind the closing brace of each."""
    block = re.search(rf"@typedef {{object}} {name}\b.*?\*/", text, re.S).group()
    names = set()
    for part in block.split("@property {")[1:]:
        depth, at = 1, 0
        while depth:
            depth += {"{": 1, "}": -1}.get(part[at], 0)
            at += 1
        names.add(part[at:].split()[0].strip("[]"))
    return names


@unittest.skipUnless(shutil.which("tsc"), "skipped: node-typescript is not installed")
class Types(unittest.TestCase):
    def test_nothing_is_found_but_a_slip_that_is_put_in(self):
        with tempfile.TemporaryDirectory() as folder:
            for module in WEB.iterdir():
                shutil.copy(module, folder)
            path = pathlib.Path(folder) / "words.mjs"
            text = path.read_text(encoding="utf-8")
            self.assertEqual(text.count("status.clock.utc_s"), 1)
            path.write_text(text.replace("status.clock.utc_s", "status.clock.utc"), encoding="utf-8")
            done = subprocess.run(["tsc", "--project", folder], capture_output=True, text=True)
        errors = (done.stdout + done.stderr).splitlines()
        self.assertEqual(len(errors), 1, errors)
        self.assertRegex(errors[0], r"words\.mjs\(\d+,\d+\): error TS\d+: Property 'utc' does not exist")


class Documents(unittest.TestCase):
    def test_types_have_the_members_of_the_schemas(self):
        text = "".join((WEB / name).read_text(encoding="utf-8") for name in ("documents.mjs", "kept_documents.mjs"))
        for name, (schema, way) in DESCRIBED.items():
            node = json.loads((SCHEMAS / f"{schema}.schema.json").read_text(encoding="utf-8"))
            for step in filter(None, way.split("/")):
                if step == "$defs":
                    node = {"properties": node[step]}
                else:
                    node = object_in(node["items"] if step == "items" else node["properties"][step])
            with self.subTest(type=name):
                self.assertEqual(members_of(name, text), set(node["properties"]))


if __name__ == "__main__":
    unittest.main()
