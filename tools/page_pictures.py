#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Takes the pictures of docs/images that show the station's page and a report as they are now: station-page.png, unit-page.png and
report.png. page_pictures.py [FOLDER]; before it ./run build and the target test_page_server of the preset check. Simulated units, a
scripted laboratory, Chromium, and Debian's python3-pil, which makes the files a third as large."""
import base64
import io
import json
import os
import pathlib
import sys
import urllib.request

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "web"))
os.environ.setdefault("SOAK_BIN_FOLDER", str(ROOT / "build" / "release" / "bin"))
os.environ.setdefault("TEST_PAGE_SERVER", str(ROOT / "build" / "check" / "bin" / "test_page_server"))
import test_units  # noqa: E402
from browser import Browser  # noqa: E402
from page_test import Station, soak_history  # noqa: E402
from test_page_station import set_step, soak_plan  # noqa: E402

WIDTH = 1280
COLOURS = 256


def take(browser, path, height):
    """The upper part of the page, so high."""
    clip = {"x": 0, "y": 0, "width": WIDTH, "height": height, "scale": 1}
    data = browser.devtools("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)["data"]
    picture = Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path.name}: {path.stat().st_size} bytes")


def station_page(browser, folder):
    station, plan, history = Station(), soak_plan(), soak_history()
    history["units"] = {"SN0042": history["units"]["SN0042"]}
    station.tell("history " + json.dumps(history))
    station.tell("plan " + json.dumps(plan))
    set_step(station, plan, "record", 1, 1, "+X")
    station.set("/units", [{**json.load(urllib.request.urlopen(station.url + "api/v1/status"))["units"][0], "state": "streaming",
                            "attitude": {"up": "+X", "expected": "+X", "right": True}}])
    for text in ("campaign acceptance started", "run 1 began", "plateau −20 °C reached", "recording +X"):
        station.tell("log " + text)
    browser.go(station.url)
    browser.wait("return document.querySelector('#chart path.unit-0')?.getAttribute('d')")
    browser.wait_for_text("#step-text", "Run 1 of 2")
    take(browser, folder / "station-page.png", 1290)
    browser.go("about:blank")
    station.close()


def unit_page_and_report(browser, folder):
    soakd = test_units.UnitStation()
    serial = test_units.SERIAL
    for job in ({"kind": "fit"}, {"kind": "verify", "campaign": "verification"}, {"kind": "report"}, {"kind": "release"},
                {"kind": "export", "format": "blob", "simulated": True}):
        ended = soakd.ended(soakd.post("jobs", unit=serial, user="Eva", **job))
        assert ended["state"] == "done", ended
    browser.go(f"{soakd.url}#unit={serial}")
    browser.wait("return document.querySelectorAll('#unit-jobs li').length === 5")
    browser.wait("return document.querySelectorAll('#unit-curves .sensor').length === 6")
    browser.wait_for_text("#unit-curves", "Residuals of")  # the points are there
    take(browser, folder / "unit-page.png", 2076)
    report = soakd.folder / "report.html"
    (made,) = (job["id"] for job in soakd.get("jobs")["jobs"] if job["kind"] == "report")
    with urllib.request.urlopen(f"{soakd.url}api/v1/job/file?id={made}") as answer:
        report.write_bytes(answer.read())
    browser.go(report.as_uri())
    take(browser, folder / "report.png", 1640)
    browser.go("about:blank")
    soakd.close()
    test_units.tearDownModule()


def main(folder=ROOT / "docs" / "images"):
    browser = Browser()
    try:
        browser.colours("light")
        browser.resize(WIDTH, 900)
        station_page(browser, pathlib.Path(folder))
        unit_page_and_report(browser, pathlib.Path(folder))
    finally:
        browser.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
