# SPDX-License-Identifier: Apache-2.0
"""A report in a real browser: it shows, asks the network for nothing, draws itself, and fits screen and paper."""
import functools
import hashlib
import http.server
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

from browser import BROWSER, DRIVER, Browser, long_test

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from drive_files import write_drive  # noqa: E402
from run_digest import open_catalog  # noqa: E402
from soak_cli import recording  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
SERIAL = "<img src=http://127.0.0.1:9/x onerror=alert(1)>"
SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
A4_PIXELS = 703  # 186 mm between the margins at 96 dpi
A4_HEIGHT_PIXELS = 1024  # 271 mm


def make_report(folder):
    """A report of a small made-up campaign, of a unit with a hostile name."""
    data = ["--data", str(folder / "data")]
    for seed, run in enumerate(("R01", "R02", "R03")):
        csv = folder / f"{run}.csv"
        csv.write_text(recording(seed, run, (-20.0, -5.0, 10.0, 25.0, 40.0, 55.0, 70.0), 30), encoding="utf-8")
        soak("import", str(csv), "--unit", SERIAL, "--simulated", *data)
    soak("fit", "--unit", SERIAL, *data)
    soak("report", "--unit", SERIAL, "-o", str(folder / "report.html"), *data)


def warn_much(path):
    """Twenty warnings that ask for something and as many that do not, each of many words, in the stored model."""
    database = open_catalog(path)
    ((text,),) = database.execute("SELECT document FROM model").fetchall()
    model = json.loads(text)
    for code, name in (("hysteresis", "trouble"), ("spike", "spikes")):
        model["fit"]["warnings"] += [{"code": code, "text": f"{'größer als gedacht ' * 40}: {name} {i} to its end"} for i in range(20)]
    changed = json.dumps(model)
    database.execute("UPDATE model SET document = ?, sha256 = ?", (changed, hashlib.sha256(changed.encode()).hexdigest()))
    database.commit()
    database.close()


def soak(*arguments):
    return subprocess.run([os.environ["SOAK_BIN"], *arguments], check=True, capture_output=True)


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
        self.assertEqual(self.browser.run("return document.images.length"), 0)
        self.assertEqual(self.browser.run("return document.scripts.length"), 2)  # its data and its own
        self.assertIn(SERIAL, self.browser.run("return document.querySelector('h1').innerText"))

    def test_drawings_have_a_size_and_hold_their_text(self):
        self.open()
        drawings = self.browser.run("""
          return [...document.querySelectorAll('svg')].map(svg => {
            const box = svg.getBoundingClientRect();
            const out = [...svg.querySelectorAll('text, path, line')].map(n => n.getBoundingClientRect()).filter(
              b => b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1);
            return {id: svg.getAttribute('aria-label'), width: box.width, height: box.height,
                    marks: svg.querySelectorAll('path').length, outside: out.length};
          })""")
        self.assertGreaterEqual(len(drawings), 15)
        for drawing in drawings:
            self.assertGreater(drawing["width"], 300, drawing)
            self.assertGreater(drawing["height"], 150, drawing)
            self.assertGreater(drawing["marks"], 0, drawing)
            self.assertEqual(drawing["outside"], 0, drawing)

    def test_every_figure_is_drawn_with_numbers_and_a_legend(self):
        self.open()
        figures = self.browser.run("""
          return [...document.querySelectorAll('figure')].map(figure => ({
            chart: figure.dataset.chart, name: figure.querySelector('svg')?.getAttribute('aria-label') ?? '',
            legend: figure.querySelectorAll('.legend li').length,
            numbers: [...figure.querySelectorAll('.grid text')].map(n => n.textContent).filter(t => /^−?[0-9.]+$/.test(t))}))""")
        self.assertLessEqual({"curve", "residuals", "scale", "allan"}, {figure["chart"] for figure in figures})
        for figure in figures:
            self.assertGreater(len(figure["name"]), 20, figure)
            self.assertGreaterEqual(len(figure["numbers"]), 6, figure)
            self.assertEqual(figure["chart"] != "residuals", figure["legend"] > 0, figure)  # no fresh run, no limit

    def test_without_its_script_texts_and_tables_remain(self):
        self.browser.devtools("Emulation.setScriptExecutionDisabled", value=True)
        self.addCleanup(self.browser.devtools, "Emulation.setScriptExecutionDisabled", value=False)
        self.open()
        remains = self.browser.run("""
          return {note: document.querySelector('noscript').innerText.length, tables: document.querySelectorAll('table').length,
                  captions: [...document.querySelectorAll('figure[data-chart=curve]')].map(figure => figure.innerText),
                  drawings: document.querySelectorAll('svg').length}""")
        self.assertGreater(remains["note"], 20)
        self.assertEqual(remains["drawings"], 0)
        self.assertGreaterEqual(remains["tables"], 12)
        self.assertEqual(len(remains["captions"]), 6)
        for sensor, caption in zip(SENSORS, remains["captions"]):
            self.assertIn(sensor, caption)
            self.assertRegex(caption, r"°/s.*°C|m/s².*°C")

    @long_test
    def test_axes_have_round_numbers_inside(self):
        for module in (ROOT / "web").glob("*.mjs"):
            shutil.copy(module, self.folder)
        (self.folder / "bare.html").write_text("<title>axes</title>", encoding="utf-8")
        self.browser.go(f"http://127.0.0.1:{self.server.server_port}/bare.html")
        found = self.browser.run("""
          return import('./axes.mjs').then(({ Axis, LogAxis }) => ({
            tens: new Axis(-30, 70).ticks(400, 40).map(tick => tick.text),
            spans: [1e-6, 0.37, 12, 9e4].map(span => new Axis(-0.3 * span, 0.7 * span).ticks(300, 40).map(tick => tick.value / span)),
            edges: [5, -5, 50].map(new Axis(0, 10).scale(100, 200)),
            decades: new LogAxis(0.01, 100).ticks().map(tick => tick.text),
            middle: new LogAxis(0.01, 100).scale(0, 400)(1)}))""")
        self.assertEqual(found["tens"], ["−30", "−20", "−10", "0", "10", "20", "30", "40", "50", "60", "70"])
        for values in found["spans"]:
            self.assertTrue(3 <= len(values) <= 12, values)
            self.assertTrue(-0.3 * (1 + 1e-9) <= values[0] < values[-1] <= 0.7 * (1 + 1e-9), values)
        self.assertEqual(found["edges"], [150, 100, 200])
        self.assertEqual(found["decades"], ["0.01", "0.1", "1", "10", "100"])
        self.assertAlmostEqual(found["middle"], 200)

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

    def test_verdicts_are_in_sight_on_a_telephone_a_small_screen_and_paper(self):
        for width, media in ((390, ""), (800, ""), (A4_PIXELS, "print")):
            self.open(width)
            self.browser.devtools("Emulation.setEmulatedMedia", media=media)
            self.addCleanup(self.browser.devtools, "Emulation.setEmulatedMedia", media="")
            cells = self.browser.run("""
              return [...document.querySelectorAll('.certificate tbody :is(th, td)')].map(cell => cell.getBoundingClientRect()).map(
                box => [box.left, box.right, box.height])""")
            self.assertGreaterEqual(len(cells), 42)
            for left, right, height in cells:
                self.assertTrue(0 <= left < right <= width and height > 0, (width, left, right, height))

    def test_the_certificate_is_one_printed_page_and_the_details_begin_on_the_next(self):
        self.open(A4_PIXELS)
        self.browser.devtools("Emulation.setEmulatedMedia", media="print")
        self.addCleanup(self.browser.devtools, "Emulation.setEmulatedMedia", media="")
        height, after = self.browser.run("""const certificate = document.querySelector('.certificate');
          return [certificate.getBoundingClientRect().bottom, getComputedStyle(certificate).breakAfter]""")
        self.assertLess(height, A4_HEIGHT_PIXELS)
        self.assertEqual(after, "page")

    @long_test
    def test_the_certificate_is_one_printed_page_with_many_long_warnings_and_the_rest_comes_behind(self):
        folder = self.folder / "warned"
        shutil.copytree(self.folder / "data", folder / "data")
        warn_much(folder / "data" / "station.db")
        for words, name in ((("--unit", SERIAL), "report.html"), (("--campaign", "default"), "campaign.html")):
            soak("report", *words, "-o", str(folder / name), "--data", str(folder / "data"))
            self.browser.resize(A4_PIXELS, 900)
            self.browser.go((folder / name).as_uri())
            self.browser.devtools("Emulation.setEmulatedMedia", media="print")
            self.addCleanup(self.browser.devtools, "Emulation.setEmulatedMedia", media="")
            certificate = self.browser.run("""const box = [...document.querySelectorAll('.certificate')].at(-1);
              return {height: box.getBoundingClientRect().height, text: box.textContent, lines: box.querySelectorAll('.warnings li').length}""")
            self.assertLess(certificate["height"], A4_HEIGHT_PIXELS, name)
            self.assertEqual(certificate["lines"], 6)
            self.assertNotIn("trouble 0 to its end", certificate["text"])
            self.browser.devtools("Emulation.setEmulatedMedia", media="")
        self.browser.go((folder / "report.html").as_uri())
        rest = self.browser.run("return document.querySelector('#warnings').innerText")
        for trouble in ("trouble 0 to its end", "trouble 19 to its end", "spikes 0 to its end", "spikes 19 to its end", "many of them point at the cable"):
            self.assertIn(trouble, rest)

    def test_the_name_of_a_figure_stands_above_it(self):
        self.open()
        names = self.browser.run("""return [...document.querySelectorAll('figure')].map(figure =>
          [figure.querySelector('figcaption').getBoundingClientRect().bottom, figure.querySelector('svg').getBoundingClientRect().top])""")
        self.assertGreaterEqual(len(names), 15)
        for bottom, top in names:
            self.assertLessEqual(bottom, top + 1)

    @long_test
    def test_is_dark_where_the_user_wants_it(self):
        backs = []
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            self.open()
            backs.append(self.browser.run("return getComputedStyle(document.body).backgroundColor"))
        self.assertEqual(backs, ["rgb(242, 245, 246)", "rgb(15, 21, 25)"])
        self.browser.colours("light")


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class OutagesPage(unittest.TestCase):
    """The page of a recorded drive that goes straight north at 10 m/s, by plain formulas."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="soak-outages-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        drive = write_drive(cls.folder)
        drive.write_text(drive.read_text(encoding="utf-8").replace('"straight"', f"'{SERIAL}'"), encoding="utf-8")
        done = soak("nav", "outages", str(drive), "--number", "2", "-o", str(cls.folder / "outages.html"), "--json")
        cls.document = json.loads(done.stdout)
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)
        cls.browser.console()
        cls.browser.go((cls.folder / "outages.html").as_uri())

    def drawn(self, chart, of, style):
        """The first and the last point of a line in the units of its axes, and the pixels of one such unit on both axes."""
        ticks, path = self.browser.run("""
          const figure = document.querySelector(`figure[data-chart="${arguments[0]}"][data-of="${arguments[1]}"]`);
          const ticks = ['middle', 'end'].map((anchor, i) => [...figure.querySelectorAll(`.grid text[text-anchor=${anchor}]`)].map(
            n => [n.textContent.replace('−', '-'), Number(n.getAttribute('xy'[i]))]).filter(([text]) => isFinite(text)));
          return [ticks, figure.querySelector(`path.line.${arguments[2]}`).getAttribute('d')]""", chart, of, style)
        ends = [[float(x) for x in part.split()] for part in path[1:].split("L")]
        points, scales = [[], []], []
        for axis, labels in enumerate(ticks):
            (low, low_pixel), (high, high_pixel) = labels[0], labels[-1]
            scale = (high_pixel - low_pixel) / (float(high) - float(low))
            scales.append(abs(scale))
            text_below_line = 4 if axis == 1 else 0
            for i, end in enumerate((ends[0], ends[-1])):
                points[i].append(float(low) + (end[axis] + text_below_line - low_pixel) / scale)
        return points, scales

    def test_complains_of_nothing_and_draws_each_outage_twice(self):
        self.assertEqual(self.browser.console(), [])
        charts = self.browser.run("return [...document.querySelectorAll('figure:has(svg)')].map(f => f.dataset.chart)")
        self.assertEqual(charts, ["error", "track", "error", "track", "error"])
        self.assertIn(SERIAL, self.browser.run("return document.body.innerText"))
        self.assertEqual(self.browser.run("return document.images.length"), 0)

    def test_the_track_is_that_of_the_drive_and_a_metre_is_as_long_on_both_axes(self):
        (begin, end), (east, north) = self.drawn("track", 0, "curve")
        self.assertAlmostEqual(east, north, delta=0.01 * north)
        for value, truth in zip([*begin, *end], [0, 0, 0, self.document["outages"][0]["distance_m"]]):
            self.assertAlmostEqual(value, truth, delta=1.5)
        self.assertAlmostEqual(end[1], 290, delta=11)

    def test_the_mean_error_ends_where_the_document_says(self):
        for i, pipeline in enumerate(self.document["pipelines"]):
            (begin, end), (_, pixels_per_metre) = self.drawn("error", "mean", f"unit-{i}")
            self.assertAlmostEqual(begin[0], 1, delta=0.3)
            self.assertAlmostEqual(end[0], 30, delta=0.3)
            self.assertAlmostEqual(end[1], pipeline["horizontal_final_m"]["value"], delta=1 / pixels_per_metre)


if __name__ == "__main__":
    unittest.main()
