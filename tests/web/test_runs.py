# SPDX-License-Identifier: Apache-2.0
"""Stored runs in a real browser before a real `soakd` ($SOAK_BIN_FOLDER): lists, the strip chart down to every sample, what the
gate refused, void. The answers of the interface against their schemas, and against what `soak` exports."""
import csv
import json
import pathlib
import sys
import unittest
import urllib.error
import urllib.parse
import urllib.request

from browser import BrowserTest, long_test
from real_soakd import Soakd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import check_schema, recording  # noqa: E402

HOSTILE = "<img src=x onerror=alert(1)>"
REFUSED = {"visit": 0, "position": "-Y"}  # labelled so, but +Y is up: the gate refuses it


def wrong_face(text):
    """The recording with one segment whose label says -Y where +Y is up."""
    lines = []
    for line in text.splitlines():
        cells = line.split(",")
        if cells[5:6] == [REFUSED["position"]] and cells[4] == "0.0":
            cells[12] = f"{-float(cells[12]):.6f}"
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


PAUSE_S = 600.0  # of the run R05, after its first plateau


def with_pause(text):
    """The recording with a pause before its plateau at 20 °C."""
    lines = [line.split(",") for line in text.splitlines()]
    for cells in lines[1:]:
        if cells[4] == "20.0":
            cells[0] = f"{float(cells[0]) + PAUSE_S:.1f}"
    return "\n".join(",".join(cells) for cells in lines) + "\n"


class StoredRuns(Soakd):
    """A station with stored runs."""

    def store_all(self):
        self.store("spring", "R01", wrong_face(recording(1, "R01", (0.0, 20.0, 40.0), 60)))
        self.store("spring", "R02", recording(2, "R02", (0.0, 20.0, 40.0), 60))
        self.store("paused", "R05", with_pause(recording(5, "R05", (0.0, 20.0), 90)))
        self.store(HOSTILE, "R03", recording(3, "R03", (0.0, 40.0), 10), unit=HOSTILE)

    def store(self, campaign, label, text, unit="SN1"):
        path = self.folder / f"{label}.csv"
        path.write_text(text, encoding="utf-8")
        self.soak("import", path, "--unit", unit, "--campaign", campaign, "--gravity-mps2", "9.80665")


class WithSoakd(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soakd = StoredRuns()
        cls.addClassCleanup(cls.soakd.close)
        cls.runs = {run["run"]: run for run in cls.soakd.get("runs")["runs"]}

    def name(self, label):
        return {"run": self.runs[label]["run_id"], "unit": self.runs[label]["unit"]}

    def exported(self, label):
        """The source's own numbers."""
        path = self.soakd.folder / f"{label}-exported.csv"
        self.soakd.soak("runs", "export", label, "--native", "-o", path)
        with open(path, encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))


class Interface(WithSoakd):
    def test_the_list_is_that_of_soak_with_counts(self):
        answer = self.soakd.get("runs")
        check_schema(answer, "http-runs")
        listed = {run["run_id"]: run for run in self.soakd.soak_json("runs", "list")["runs"]}
        self.assertEqual(set(listed), {run["run_id"] for run in answer["runs"]})
        for run in answer["runs"]:
            self.assertEqual({key: run[key] for key in listed[run["run_id"]]}, listed[run["run_id"]])
        self.assertEqual(self.runs["R01"]["segments"], {"recorded": 18, "withdrawn": 0, "rejected": 1})
        self.assertEqual([run["run"] for run in self.soakd.get("runs", unit=HOSTILE)["runs"]], ["R03"])

    def test_a_run_has_the_segments_of_soak_and_its_channels_with_their_rates(self):
        answer = self.soakd.get("run", **self.name("R01"))
        check_schema(answer, "http-run")
        shown = self.soakd.soak_json("runs", "show", "R01")
        self.assertEqual([{key: value for key, value in segment.items() if key != "void"} for segment in answer["segments"]],
                         shown["segments"])
        stream = answer["streams"][0]
        self.assertEqual(stream["rows"], 18 * 120)
        self.assertAlmostEqual(stream["channels"][0]["rate_hz"], 2.0)
        refused = [s for s in answer["segments"] if any(f["severity"] == "reject" for f in s["findings"])]
        self.assertEqual([{key: s[key] for key in REFUSED} for s in refused], [REFUSED])

    def test_samples_are_those_of_the_native_export_bit_for_bit(self):
        rows = self.exported("R02")
        answer = self.soakd.get("run/series", **self.name("R02"), channel=["gyro_x", "accel_z"], from_s=100, to_s=200, points=500)
        check_schema(answer, "http-series")
        self.assertEqual(answer["kind"], "samples")
        wanted = [row for row in rows if 100 <= float(row["t_s"]) <= 200]
        self.assertEqual(answer["rows"], len(wanted))
        self.assertEqual(answer["t_s"], [float(row["t_s"]) for row in wanted])
        for channel, column in zip(answer["channels"], ("gx_dps", "az_mps2")):
            self.assertEqual(channel["values"], [float(row[column]) for row in wanted])

    def test_buckets_hold_the_exported_samples(self):
        rows = self.exported("R02")
        answer = self.soakd.get("run/series", **self.name("R02"), channel="gyro_y", points=100)
        check_schema(answer, "http-series")
        self.assertEqual(answer["kind"], "buckets")
        values = [float(row["gy_dps"]) for row in rows]
        channel, first = answer["channels"][0], 0
        for count, low, high in zip(channel["count"], channel["minimum"], channel["maximum"]):
            self.assertEqual((low, high), (min(values[first:first + count]), max(values[first:first + count])))
            first += count
        self.assertEqual(first, len(values))

    def test_a_refusal_is_an_error_document(self):
        with self.assertRaises(urllib.error.HTTPError) as refusal:
            self.soakd.get("run/series", **self.name("R02"), channel="nosuch")
        self.assertEqual(refusal.exception.code, 400)
        error = json.load(refusal.exception)
        check_schema(error, "error")
        self.assertEqual(error["error"]["where"], "channel")
        self.assertIn("gyro_x", error["error"]["message"])


class WithBrowser(BrowserTest, WithSoakd):

    def open_list(self):
        self.browser.go(f"{self.soakd.url}#runs")
        self.browser.wait("return document.querySelectorAll('#runs-campaigns .runs tbody tr').length >= 3")

    def open_run(self, label):
        self.browser.go("about:blank")
        self.browser.go(f"{self.soakd.url}#{urllib.parse.urlencode(self.name(label))}")
        self.wait_for_chart()

    def wait_for_chart(self, kind=None):
        self.browser.wait("return document.querySelector('#strip-panels canvas') && document.querySelector('#strip').ariaBusy === 'false' && "
                          "(!arguments[0] || document.querySelector('#strip').dataset.kind === arguments[0])", kind)

    def window(self):
        """[from, to] in the address, which says what is shown once the station has answered."""
        self.browser.wait("return document.querySelector('#strip').getAttribute('aria-busy') === 'false'")
        place = urllib.parse.parse_qs(self.browser.run("return location.hash.slice(1)"))
        return float(place["from"][0]), float(place["to"][0])

    def drag(self, start, end):
        """With the mouse across the chart, from one share of its width to another."""
        box = self.browser.run("const b = document.querySelector('#strip').getBoundingClientRect();"
                               "return [b.left, b.top, b.width, b.height]")
        points = [(round(box[0] + share * box[2]), round(box[1] + box[3] / 2)) for share in (start, (start + end) / 2, end)]
        moves = [{"type": "pointerMove", "duration": 20, "x": x, "y": y} for x, y in points]
        moves.insert(1, {"type": "pointerDown", "button": 0})
        moves.append({"type": "pointerUp", "button": 0})
        self.browser.send("POST", self.browser.session + "/actions", {"actions": [
            {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": moves}]})


# Every rectangle that is drawn into the first panel from now on, with the way across and down of its edges.
RECTANGLES = """
window.rectangles = [];
const fill = CanvasRenderingContext2D.prototype.fillRect;
CanvasRenderingContext2D.prototype.fillRect = function (x, y, w, h) {
  if (this.canvas.closest('.panel') === document.querySelector('#strip-panels .panel') && this.globalAlpha > 0.29 && this.globalAlpha < 0.31) window.rectangles.push([x, y, w, h]);
  fill.call(this, x, y, w, h);
};"""


class Page(WithBrowser):
    def drawn_band(self, label):
        """Rectangles of the band of gyro y of a whole run, from left to right."""
        self.open_run(label)
        self.wait_for_chart("buckets")
        self.browser.run("document.querySelectorAll('#strip-channels input').forEach((box) => { if (box.checked && box.value !== 'imu/gyro_y') box.click(); })")
        self.browser.wait("return document.querySelectorAll('#strip-panels .panel').length === 1 && document.querySelector('#strip').getAttribute('aria-busy') === 'false'")
        self.browser.run(RECTANGLES)
        self.browser.click("#strip-all")
        self.browser.wait("return window.rectangles.length > 100 && document.querySelector('#strip').getAttribute('aria-busy') === 'false'")
        drawn = self.browser.run("return window.rectangles")
        return drawn[max(i for i, (x, *_) in enumerate(drawn) if x == min(x for x, *_ in drawn)):]  # of the last time it was drawn

    def assert_encloses(self, drawn, samples):
        """Each rectangle from the least to the greatest of the samples (time, value) that it stands for. Pixels are an affine function of time
        and value: the ends of the band, its highest and its lowest edge, give both."""
        times, values = zip(*samples)
        left, right = drawn[0][0], drawn[-1][0] + drawn[-1][2]
        top, bottom = min(y for _, y, _, _ in drawn), max(y + height for _, y, _, height in drawn)
        time_at = lambda x: times[0] + (times[-1] - times[0]) * (x - left) / (right - left)
        value_at = lambda y: max(values) - (max(values) - min(values)) * (y - top) / (bottom - top)
        for x, y, width, height in drawn:
            within, around = ([value for t, value in samples if time_at(x - out) <= t <= time_at(x + width + out)] for out in (-3, 3))  # pixels
            for of, edge in ((max, value_at(y)), (min, value_at(y + height))):
                sign = 1 if of is max else -1
                self.assertLessEqual(sign * edge, sign * of(around) + 1e-4)
                if within:
                    self.assertGreaterEqual(sign * edge, sign * of(within) - 1e-4)

    def test_the_band_of_a_line_reaches_its_least_and_greatest_sample_without_a_gap(self):
        drawn = self.drawn_band("R02")
        for (x, _, width, _), (following, *_) in zip(drawn, drawn[1:]):
            self.assertEqual(x + width, following)
        self.assert_encloses(drawn, [(float(row["t_s"]), float(row["gy_dps"])) for row in self.exported("R02")])

    @long_test
    def test_the_band_of_a_line_is_open_while_nothing_was_recorded(self):
        drawn = self.drawn_band("R05")
        samples = [(float(row["t_s"]), float(row["gy_dps"])) for row in self.exported("R05")]
        gaps = [(x + width, following) for (x, _, width, _), (following, *_) in zip(drawn, drawn[1:]) if x + width != following]
        self.assertEqual(len(gaps), 1)
        end, begin = gaps[0]
        pixels_per_s = (drawn[-1][0] + drawn[-1][2] - drawn[0][0]) / (samples[-1][0] - samples[0][0])
        self.assertAlmostEqual((begin - end) / pixels_per_s, PAUSE_S, delta=4 / pixels_per_s)  # pixels: half a stretch at both ends
        self.assert_encloses(drawn, samples)

    def test_a_run_is_asked_for_once_when_its_link_is_pressed(self):
        self.open_list()
        asked = "return performance.getEntriesByType('resource').filter(({ name }) => name.includes('/api/v1/run?')).length"
        link = f"#runs-campaigns a[href*='{self.runs['R02']['run_id']}']"
        self.assertEqual(self.browser.run(asked), 0)
        self.browser.run(f"document.querySelector({json.dumps(link)}).dispatchEvent(new PointerEvent('pointerdown'))")
        self.browser.wait(f"{asked} === 1")
        self.browser.run(f"document.querySelector({json.dumps(link)}).click()")
        self.wait_for_chart()
        self.see("#run-title", "R02")
        self.assertEqual(self.browser.run(asked), 1)
        # What was asked for ahead is taken once: a run that was voided since is read again.
        self.browser.run("history.back()")
        self.browser.wait("return !document.querySelector('#runs-view').hidden")
        self.browser.run("history.forward()")
        self.browser.wait(f"{asked} === 2")

    def test_a_narrow_screen_shows_the_way_to_every_view(self):
        self.open_list()
        self.addCleanup(self.browser.run, "localStorage.removeItem('soak-language')")
        for language in ("en", "de"):
            self.browser.run("localStorage.setItem('soak-language', arguments[0])", language)
            self.browser.go("about:blank")
            self.open_list()
            for width in (320, 390):
                self.browser.resize(width, 844)
                out = self.browser.run("return [...document.querySelectorAll('.top nav a')].filter((link) => {"
                                       " const { left, right, width } = link.getBoundingClientRect(); return width === 0 || left < 0 || right > innerWidth; }).map((link) => link.id)")
                self.assertEqual(out, [], f"{language}, {width}")

    # Where time is simulated fast the chamber is read once a minute, or once in ten: its line lay there in dashes.
    def test_a_line_is_parted_where_its_samples_are_far_rarer_than_they_usually_are(self):
        spacings_s = {"uneven": [1, 2, 9, 1, 3, 12, 2, 1, 8, 1] * 5, "paused": [2] * 30 + [600] + [2] * 30, "few": [5, 5, 90, 5, 5]}
        self.browser.go(self.soakd.url)
        breaks = self.browser.run("""return import('/series.mjs').then(({ linesOf }) => Object.fromEntries(Object.entries(arguments[0]).map(([name, spacings]) => {
            let t = 0;
            const t_s = [0, ...spacings.map((spacing) => t += spacing)];
            const [{ points }] = linesOf({ kind: 'samples', stream: 'chamber', t_s, channels: [{ name: 'chamber_c', unit: 'degC', values: t_s.map(() => 20) }] });
            return [name, points.filter(({ mean }) => Number.isNaN(mean)).map(({ t_s }) => t_s)];
          })))""", spacings_s)
        self.assertEqual(breaks, {"uneven": [], "paused": [360], "few": [55]})

    def test_the_list_is_reached_from_the_station_and_says_what_became_of_each_run(self):
        self.browser.go(self.soakd.url)
        self.browser.click("#to-runs")
        self.see("#runs-campaigns", "R01")
        self.assertEqual(self.browser.run("return document.querySelector('#to-runs').ariaCurrent"), "page")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "runs-title")
        self.see("#runs-campaigns", "18, 1 refused")
        self.see("#runs-campaigns", HOSTILE)
        self.browser.type("#runs-find", "R02 spring")
        self.browser.wait("return document.querySelectorAll('#runs-campaigns tbody tr').length === 1")
        self.browser.click("#runs-campaigns tbody a")
        self.see("#run-title", "R02")
        self.wait_for_chart()
        self.browser.run("history.back()")
        self.browser.wait("return !document.querySelector('#runs-view').hidden")
        self.browser.click("#to-station")
        self.browser.wait("return !document.querySelector('#station-view').hidden")
        self.assertEqual(self.browser.console(), [])

    def test_a_run_is_looked_at_from_the_whole_down_to_every_sample(self):
        self.open_run("R02")
        self.wait_for_chart("buckets")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#strip-panels .panel').length"), 3)
        self.drag(0.4, 0.6)
        self.wait_for_chart("samples")
        first, last = self.window()
        self.assertAlmostEqual((last - first) / 1080, 0.2, delta=0.03)
        expected = self.soakd.get("run/series", **self.name("R02"), channel="gyro_x", from_s=first, to_s=last, points=2000)["rows"]
        self.see("#strip-window", f"every one of {expected:,} samples".replace(",", "\u202f"))
        self.assertEqual(self.browser.console(), [])

    def test_keys_and_buttons_zoom_and_move(self):
        self.open_run("R02")
        self.browser.run("document.querySelector('#strip').focus()")
        self.type_keys("+")
        first, last = self.window()
        self.assertAlmostEqual(last - first, 1079.5 / 2, delta=1)
        self.type_keys("\ue008\ue014")  # Shift and the right arrow
        moved = self.window()
        self.assertAlmostEqual(moved[1] - moved[0], last - first, delta=1e-3)
        self.assertGreater(moved[0], first)
        self.browser.press("ArrowRight")
        self.browser.wait("return document.querySelector('#strip').ariaLabel.includes('gyro')")
        self.browser.wait("return !document.querySelector('.cursor-line').hidden")
        self.type_keys("0")
        self.assertAlmostEqual(self.window()[1], 1079.5, delta=1e-3)
        for button, share in (("#strip-in", 0.5), ("#strip-in", 0.25), ("#strip-out", 0.5), ("#strip-all", 1.0)):
            self.browser.click(button)
            first, last = self.window()
            self.assertAlmostEqual((last - first) / 1079.5, share, delta=0.01)
        self.assertEqual(self.browser.console(), [])

    def type_keys(self, text):
        self.browser.send("POST", f"{self.browser.session}/element/{self.browser.element('#strip')}/value", {"text": text})

    def test_channels_are_chosen(self):
        self.open_run("R02")
        panels = "return document.querySelectorAll('#strip-panels .panel').length === arguments[0]"
        for name in ("gyro x", "gyro y", "gyro z"):
            self.browser.run("for (const label of document.querySelectorAll('#strip-channels label'))"
                             "if (label.innerText.trim() === arguments[0]) label.click()", name)
        self.browser.wait(panels, 2)
        # The chamber, on the unit's own clock, is compared with the unit from the beginning.
        self.browser.wait("return document.querySelector('#strip-panels').innerText.includes('chamber')")
        self.browser.run("for (const label of document.querySelectorAll('#strip-channels label'))"
                         "if (label.innerText.includes('chamber')) label.click()")
        self.browser.wait("return !document.querySelector('#strip-panels').innerText.includes('chamber')")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_run_whose_samples_were_dropped_keeps_its_segments_and_says_who_dropped_them(self):
        self.soakd.store("old", "R04", recording(4, "R04", (0.0, 20.0, 40.0), 10))
        self.soakd.soak("runs", "drop-samples", "R04", "--reason", "older than two years", "--user", "Eva", "--yes")
        run = next(run for run in self.soakd.get("runs")["runs"] if run["run"] == "R04")
        answer = self.soakd.get("run", run=run["run_id"], unit="SN1")
        check_schema(answer, "http-run")
        self.assertEqual((answer["streams"], len(answer["segments"])), ([], 18))
        self.open_run("R02")
        self.browser.go(f"{self.soakd.url}#{urllib.parse.urlencode({'run': run['run_id'], 'unit': 'SN1'})}")
        self.see("#run-dropped", "Eva: older than two years")
        self.see("#segments tbody", "sound")
        self.assertTrue(self.browser.run("return document.querySelector('#strip-card').hidden"))
        self.browser.go(f"{self.soakd.url}#{urllib.parse.urlencode(self.name('R02'))}")
        self.see("#run-title", "R02")
        self.wait_for_chart()
        self.assertFalse(self.browser.run("return document.querySelector('#strip-card').hidden"))
        self.assertTrue(self.browser.run("return document.querySelector('#run-dropped').hidden"))
        self.open_list()
        self.see("#runs-campaigns", "no samples")
        self.assertEqual(self.browser.console(), [])

    @long_test
    def test_a_refused_segment_is_shown_with_the_reason(self):
        self.open_run("R01")
        self.browser.wait("return document.querySelectorAll('#strip-segments .box.refused').length === 1")
        self.browser.click("#segments-refused")
        self.browser.wait("return document.querySelectorAll('#segments tbody tr').length === 1")
        self.see("#segments tbody", "wrong_position")
        self.see("#segments tbody", "−Y")
        self.browser.click("#segments tbody button")
        self.see("#strip-segment", "wrong_position")
        first, last = self.window()
        self.assertLess(last - first, 80)
        self.assertEqual(self.browser.console(), [])

    def test_what_has_no_name_for_a_screen_reader_is_not_there(self):
        self.open_list()
        self.open_run("R01")
        nameless = self.browser.run("""
          return [...document.querySelectorAll("a, button, input, select, [tabindex]")].filter((node) => node.offsetParent)
            .filter((node) => !(node.ariaLabel || node.innerText?.trim() || node.labels?.length || node.getAttribute("aria-labelledby")))
            .map((node) => node.outerHTML)""")
        self.assertEqual(nameless, [])
        ids = self.browser.run("return [...document.querySelectorAll('[id]')].map((node) => node.id)")
        self.assertEqual(len(ids), len(set(ids)), "ids are unique")

    def test_text_stands_out_from_what_is_behind_it(self):
        self.addCleanup(self.browser.colours, "light")
        for scheme in ("light", "dark"):
            self.browser.colours(scheme)
            self.open_list()
            self.assertEqual(self.browser.poor_contrast(), [], f"list, {scheme}")
            self.open_run("R01")
            self.assertEqual(self.browser.poor_contrast(), [], f"run, {scheme}")
            self.browser.click("#run-void")
            self.assertEqual(self.browser.poor_contrast(), [], f"void, {scheme}")
            self.browser.click("#void-cancel")

    def test_nothing_is_wider_than_the_screen(self):
        for width in (390, 768, 1280, 1920):
            self.browser.resize(width, 900)
            self.open_list()
            wide = "return document.documentElement.scrollWidth - innerWidth"
            self.assertLessEqual(self.browser.run(wide), 0, f"list at {width}")
            self.open_run("R01")
            self.assertLessEqual(self.browser.run(wide), 0, f"run at {width}")


class Campaigns(WithBrowser):
    """The heads of campaigns: a station of its own."""

    def answer_with(self, path, change):
        """Opens the page; what the station answers to a path is changed by a function body in JavaScript."""
        self.browser.go("about:blank")
        self.browser.go(self.soakd.url)
        self.browser.run("""const [path, body] = arguments, real = window.fetch;
            const changed = { stored: (document) => ({ ...document, campaigns: [...document.campaigns, body] }), runs: (document) => ({ runs: document.runs.filter(({ campaign }) => campaign === body), not_listed: 3 }) };
            window.fetch = async (...question) => {
              const answer = await real(...question);
              return String(question[0]).endsWith(`/${path}`) ? new Response(JSON.stringify(changed[path](await answer.json()))) : answer;
            };
            location.hash = "runs";""", path, change)

    def test_a_campaign_without_a_run_is_listed_with_its_date_and_why(self):
        self.answer_with("stored", {"name": "ended in its checks", "procedure": "six-position", "state": "failed", "reason": "the chamber does not answer",
                                    "begun_utc_s": 1790000000.0, "runs": 0, "units": []})
        self.see("#runs-campaigns", "ended in its checks")
        self.see("#runs-campaigns", "the chamber does not answer")
        self.see("#runs-campaigns", "No run of it is stored")
        self.see("#runs-campaigns", "begun 2026-09-2")
        self.browser.type("#runs-find", "checks")
        self.browser.wait("return document.querySelectorAll('#runs-campaigns section').length === 1")
        self.see("#runs-nothing", "1 campaign")
        self.assertEqual(self.browser.console(), [])

    def test_runs_that_the_list_leaves_out_are_had_by_what_is_looked_for(self):
        """The page is given those of one campaign alone, as of a station with many."""
        self.answer_with("runs", "paused")
        self.see("#runs-campaigns", "R05")
        self.see("#runs-more", "3 older runs are not shown.")
        self.assertNotIn("R01", self.browser.text("#runs-campaigns"))
        self.see("#runs-campaigns", "older than those shown here")
        self.browser.type("#runs-find", "spring")
        self.see("#runs-campaigns", "R01")
        self.see("#runs-more", "1 older run is not shown.")
        self.assertEqual(self.browser.console(), [])

    def test_the_report_of_a_campaign_is_made_at_a_click_and_can_be_saved(self):
        self.open_list()
        self.browser.click("[data-report='spring']")
        self.see("[data-report-of='spring']", "Download spring.html")
        job = self.soakd.get("job", id=self.soakd.get("jobs")["jobs"][0]["id"])
        check_schema(job, "http-job")
        self.assertEqual((job["kind"], job["unit"], job["campaign"], job["state"]), ("report_campaign", "", "spring", "done"))
        self.assertEqual(job["result"]["units"][0]["unit"], "SN1")
        with urllib.request.urlopen(f"{self.soakd.url}api/v1/job/file?id={job['id']}") as answer:
            self.assertIn("spring", answer.read().decode())
        self.assertEqual(self.browser.text("[data-report-of='paused']"), "")
        self.assertEqual(self.browser.console(), [])


class Void(WithBrowser):
    """Changes the runs: a station of its own."""

    def test_a_segment_and_a_run_become_void_with_reason_and_name(self):
        self.open_run("R01")
        self.browser.click("#segments tbody tr:nth-child(2) button:nth-of-type(2)")
        self.assertTrue(self.browser.run("return document.querySelector('#void-dialog').open"))
        self.browser.click("#void-send")  # without reason and name nothing is sent
        self.assertEqual(self.soakd.query("SELECT count(*) FROM void"), [(0,)])
        self.see("#void-text", "1 of the 18")
        self.browser.click("#void-scope label:last-of-type")
        self.see("#void-text", "18")
        self.browser.click("#void-scope label:first-of-type")
        self.browser.type("#void-reason", "the door was open")
        self.browser.type("#void-user", "Eva")
        self.browser.click("#void-send")
        self.browser.wait("return document.querySelectorAll('#strip-segments .box.void').length === 1")
        self.assertEqual(self.soakd.query("SELECT run_id, unit, visit, position, attempt, reason, user FROM void"),
                         [(self.runs["R01"]["run_id"], "SN1", 0, "-X", 0, "the door was open", "Eva")])
        self.see("#segments tbody tr:nth-child(2)", "the door was open")

        self.browser.run("scrollTo(0, 0)")
        self.browser.click("#run-void")
        self.see("#void-text", "17")
        self.browser.type("#void-reason", "wrong unit")
        self.browser.type("#void-user", "Eva")
        self.browser.click("#void-send")
        self.see("#run-void-record", "wrong unit")
        self.assertTrue(self.browser.run("return document.querySelector('#run-void').disabled"))
        self.assertEqual(self.soakd.query("SELECT visit, reason, user FROM void ORDER BY rowid DESC LIMIT 1"), [(None, "wrong unit", "Eva")])
        events = self.soakd.query("SELECT kind, subject, user, text FROM event ORDER BY ordinal DESC LIMIT 2")
        for kind, subject, user, _ in events:
            self.assertEqual((kind, subject, user), ("voided", self.runs["R01"]["run_id"], "Eva"))
        self.assertIn("wrong unit", events[0][3])
        self.assertTrue(next(run for run in self.soakd.soak_json("runs", "list")["runs"] if run["run"] == "R01")["voided"])
        self.assertTrue(self.soakd.soak_json("events", "verify"))
        self.open_list()
        self.see("#runs-campaigns", "wrong unit")
        self.assertEqual(self.browser.console(), [])


if __name__ == "__main__":
    unittest.main()
