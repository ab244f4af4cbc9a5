# SPDX-License-Identifier: Apache-2.0
"""A report in a real browser: it shows, asks the network for nothing, runs no script, and fits screen and paper."""
import functools
import http.server
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

from browser import BROWSER, DRIVER, Browser

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import recording  # noqa: E402

SERIAL = "<img src=http://127.0.0.1:9/x onerror=alert(1)>"
A4_PIXELS = 703  # 186 mm between the margins at 96 dpi


def make_report(folder):
    """A report of a small made-up campaign, of a unit with a hostile name."""
    data = ["--data", str(folder / "data")]
    for seed, run in enumerate(("R01", "R02", "R03")):
        csv = folder / f"{run}.csv"
        csv.write_text(recording(seed, run, (-20.0, -5.0, 10.0, 25.0, 40.0, 55.0, 70.0), 30), encoding="utf-8")
        soak("import", str(csv), "--unit", SERIAL, "--simulated", *data)
    soak("fit", "--unit", SERIAL, *data)
    soak("report", "--unit", SERIAL, "-o", str(folder / "report.html"), *data)


def soak(*arguments):
    subprocess.run([os.environ["SOAK_BIN"], *arguments], check=True, capture_output=True)


class Witness(http.server.SimpleHTTPRequestHandler):
    """Serves a folder and remembers what was asked for."""

    asked = []

    def do_GET(self):
        self.asked.append(self.path)
        super().do_GET()

    def log_message(self, *arguments):
        pass


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-report-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        make_report(cls.folder)
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Witness, directory=cls.folder))
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()
        cls.addClassCleanup(cls.server.server_close)
        cls.addClassCleanup(cls.server.shutdown)
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def open(self, width=1280, height=900):
        self.browser.console()
        self.browser.resize(width, height)
        self.browser.go((self.folder / "report.html").as_uri())

    def test_asks_for_nothing_and_complains_of_nothing(self):
        Witness.asked.clear()
        self.browser.console()
        self.browser.go(f"http://127.0.0.1:{self.server.server_port}/report.html")
        self.assertEqual(self.browser.run("return performance.getEntriesByType('resource').map(e => e.name)"), [])
        self.assertEqual(Witness.asked, ["/report.html"])
        self.assertEqual(self.browser.console(), [])
        self.assertEqual(self.browser.run("return document.images.length + document.scripts.length"), 0)
        self.assertIn(SERIAL, self.browser.run("return document.querySelector('h1').innerText"))

    def test_drawings_have_a_size_and_hold_their_text(self):
        self.open()
        drawings = self.browser.run("""
          return [...document.querySelectorAll('svg')].map(svg => {
            const box = svg.getBoundingClientRect();
            const out = [...svg.querySelectorAll('text, path, line')].map(n => n.getBoundingClientRect()).filter(
              b => b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1);
            return {id: svg.getAttribute('aria-labelledby'), width: box.width, height: box.height,
                    marks: svg.querySelectorAll('path').length, outside: out.length};
          })""")
        self.assertGreaterEqual(len(drawings), 15)
        for drawing in drawings:
            self.assertGreater(drawing["width"], 300, drawing)
            self.assertGreater(drawing["height"], 150, drawing)
            self.assertGreater(drawing["marks"], 0, drawing)
            self.assertEqual(drawing["outside"], 0, drawing)

    def test_shows_the_simulated_banner_and_the_verdict_first(self):
        self.open()
        banner, verdict = (self.browser.run(f"return document.querySelector('{s}').getBoundingClientRect().bottom")
                           for s in (".simulated-bar", ".verdict"))
        self.assertTrue(0 < banner < verdict < 500, (banner, verdict))

    def test_fits_a_telephone_a_desk_and_paper(self):
        for width in (360, 1280):
            self.open(width)
            self.assertEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
        self.open(A4_PIXELS)
        self.browser.devtools("Emulation.setEmulatedMedia", media="print")
        self.addCleanup(self.browser.devtools, "Emulation.setEmulatedMedia", media="")
        self.assertEqual(self.browser.run("return getComputedStyle(document.querySelector('.watermark')).display"), "block")
        wide = self.browser.run("""return [...document.querySelectorAll('table, figure')].filter(
            e => e.getBoundingClientRect().right > innerWidth + 1).map(e => e.querySelector('caption, b').innerText)""")
        self.assertEqual(wide, [])

    def test_is_dark_where_the_user_wants_it(self):
        backs = []
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            self.open()
            backs.append(self.browser.run("return getComputedStyle(document.body).backgroundColor"))
        self.assertEqual(backs, ["rgb(242, 245, 246)", "rgb(15, 21, 25)"])
        self.browser.colours("light")


if __name__ == "__main__":
    unittest.main()
