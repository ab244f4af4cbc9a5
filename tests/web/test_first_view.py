#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the station's page asks for at first, while the longest procedure that is shipped runs: a real `soakd` before a real `soaksim`, in a real
browser. Every answer is weighed as it is before any compression."""
import json
import pathlib
import shutil
import sys
import tempfile
import unittest
import urllib.request

from browser import BROWSER, DRIVER, Browser

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from lab_session import LabSession  # noqa: E402

PROCEDURE = ROOT / "procedures" / "six-position-soak.toml"
MOST_BYTES = 300_000


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class LongCampaign(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-first-view-"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        cls.lab = LabSession(folder, units=2, rate=1)
        cls.lab.__enter__()
        cls.addClassCleanup(cls.lab.__exit__)
        cls.lab.soak("campaign", "start", PROCEDURE, "--name", "long")
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def get(self, path):
        with urllib.request.urlopen(f"{self.lab.page}api/v1/{path}", timeout=30) as answer:
            return json.load(answer)

    def test_the_first_view_weighs_at_most_300_kb_with_all_answers(self):
        plan = self.get("plan")
        self.assertGreater(len(plan["steps"]), 8000)
        self.browser.go(self.lab.page)
        self.browser.wait("return document.querySelector('#step-text').innerText.includes('Pre-flight')")
        self.browser.wait("return document.querySelector('#chart path') && document.querySelectorAll('#log li').length > 0")
        sizes = self.browser.loaded()
        around = [name for name, _ in sizes if "/plan?around=" in name]
        self.assertTrue(around)
        # Plateaus have more steps than the pre-flight.
        longest = max(len(json.dumps(self.get(f"plan?around={step}"), separators=(",", ":"))) for step in range(0, len(plan["steps"]), 97))
        self.assertLessEqual(sum(size for name, size in sizes if name not in around) + longest, MOST_BYTES, (longest, sizes))
        self.assertEqual(self.browser.console(), [])


if __name__ == "__main__":
    unittest.main()
