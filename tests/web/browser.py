# SPDX-License-Identifier: Apache-2.0
"""Headless Chromium through chromedriver: the WebDriver protocol (W3C) as plain HTTP."""
import base64
import http.client
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from long_tests import LONG_TESTS, long_test  # noqa: E402, F401 (the tests take it from here)

DRIVER = shutil.which("chromedriver")
BROWSER = shutil.which("chromium")
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # WebDriver, 11: the web element identifier
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--hide-scrollbars")
KEYS = {"Tab": "\ue004", "Enter": "\ue007", "Escape": "\ue00c", "ArrowLeft": "\ue012", "ArrowRight": "\ue014"}
PATIENCE_S = 60
STARTS = 5
POOR_CONTRAST = """
const luminance = ([r, g, b]) => { const l = (c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  return 0.2126 * l(r) + 0.7152 * l(g) + 0.0722 * l(b); };
const parts = (text) => text.match(/[\\d.]+/g).map(Number);
const behind = (node) => { for (let n = node; n; n = n.parentElement) { const c = parts(getComputedStyle(n).backgroundColor);
  if (c.length < 4 || c[3] === 1) return c; } return [255, 255, 255]; };
const poor = [];
for (const node of document.querySelectorAll("body *")) {
  if (!node.checkVisibility() || node.disabled || ![...node.childNodes].some((n) => n.nodeType === 3 && n.data.trim())) continue;
  const { color, fill } = getComputedStyle(node);
  const [a, b] = [luminance(parts(node instanceof SVGElement ? fill : color)), luminance(behind(node))];
  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (ratio < 4.5) poor.push(`${ratio.toFixed(2)} ${node.outerHTML.slice(0, 120)}`);
}
return poor;"""


class Browser:
    """One browser with a profile of its own."""

    def __init__(self, *flags):
        self.profile = tempfile.mkdtemp(prefix="soak-browser-")
        self.start_driver()
        options = {"binary": BROWSER, "args": [*FLAGS, *flags, f"--user-data-dir={self.profile}"]}
        answer = self.send("POST", "/session", {"capabilities": {"alwaysMatch": {
            "timeouts": {"script": 120_000},  # ms: axe-core takes more than the usual 30 s on a machine that is full
            "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session = "/session/" + answer["sessionId"]
        self.downloads = pathlib.Path(self.profile) / "downloads"
        self.devtools("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.downloads))

    def start_driver(self):
        """It takes a port that is free for IPv4, and ends where another program has it for IPv6: then it is started again."""
        said = []
        for _ in range(STARTS):
            self.driver = subprocess.Popen([DRIVER, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            for line in self.driver.stdout:
                said.append(line)
                found = re.search(r"successfully on port (\d+)", line)
                if found:
                    self.port = int(found.group(1))
                    return
            self.driver.wait(PATIENCE_S)
            self.driver.stdout.close()
        raise RuntimeError("chromedriver does not start: " + "".join(said))

    def close(self):
        try:
            self.send("DELETE", self.session)
        finally:
            self.driver.terminate()
            self.driver.wait(PATIENCE_S)
            self.driver.stdout.close()
            shutil.rmtree(self.profile, ignore_errors=True)

    def send(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=2 * PATIENCE_S)
        text = None if method in ("GET", "DELETE") else json.dumps(body or {})
        connection.request(method, path, text, {"Content-Type": "application/json"})
        value = json.loads(connection.getresponse().read())["value"]
        connection.close()
        if isinstance(value, dict) and "error" in value:
            raise RuntimeError(f"{value['error']}: {value['message']}")
        return value

    def go(self, url):
        self.send("POST", self.session + "/url", {"url": url})

    def run(self, script, *arguments):
        """The value of a JavaScript function body."""
        return self.send("POST", self.session + "/execute/sync", {"script": script, "args": list(arguments)})

    def devtools(self, command, **parameters):
        return self.send("POST", self.session + "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def element(self, selector):
        return self.send("POST", self.session + "/element", {"using": "css selector", "value": selector})[ELEMENT]

    def click(self, selector):
        self.send("POST", f"{self.session}/element/{self.element(selector)}/click")

    def type(self, selector, text):
        self.send("POST", f"{self.session}/element/{self.element(selector)}/value", {"text": text})

    def press(self, key):
        """A key for whatever has the focus."""
        actions = [{"type": kind, "value": KEYS[key]} for kind in ("keyDown", "keyUp")]
        self.send("POST", self.session + "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": actions}]})

    def text(self, selector):
        """What a user sees of the element; "" where it is hidden."""
        return self.send("GET", f"{self.session}/element/{self.element(selector)}/text")

    def wait(self, script, *arguments):
        """Waits until the JavaScript function body returns something true, and returns it."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            value = self.run(script, *arguments)
            if value:
                return value
            time.sleep(0.02)
        raise AssertionError(f"never true: {script} {arguments}\n{self.run('return document.body.innerText')}")

    def wait_for_text(self, selector, text):
        self.wait("return document.querySelector(arguments[0])?.innerText.includes(arguments[1])", selector, text)

    def console(self):
        """Errors and warnings since the last call: scripts that fail, resources that are missing or forbidden."""
        lines = self.send("POST", self.session + "/se/log", {"type": "browser"})
        return [line["message"] for line in lines if line["level"] in ("SEVERE", "WARNING")]

    def new_tab(self):
        handle = self.send("POST", self.session + "/window/new", {"type": "tab"})["handle"]
        self.switch(handle)
        return handle

    def tab(self):
        return self.send("GET", self.session + "/window")

    def switch(self, handle):
        self.send("POST", self.session + "/window", {"handle": handle})

    def close_tab(self):
        self.send("DELETE", self.session + "/window")

    def resize(self, width, height):
        self.devtools("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def colours(self, scheme):
        """"light" or "dark": what the user's system prefers."""
        self.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def poor_contrast(self):
        """Texts that do not stand out from what is behind them as WCAG 2.2, 1.4.3 asks."""
        return self.run(POOR_CONTRAST)

    def loaded(self):
        """[address, bytes without compression] of the page and of all that it has asked for."""
        return self.run("""const all = [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')];
            return all.map(({ name, decodedBodySize }) => [name, decodedBodySize]);""")

    def downloaded(self, name):
        """What is saved under `name`. The browser reserves a name with an empty file and moves the whole content over it."""
        end = time.monotonic() + PATIENCE_S
        file = self.downloads / name
        while not (file.exists() and file.stat().st_size):
            if time.monotonic() > end:
                raise RuntimeError(f"{name} is not saved, but {sorted(self.downloads.glob('*'))}")
            time.sleep(0.02)
        return file.read_bytes()

    def screenshot(self, path, most_px=None):
        """What the screen shows, or with `most_px` the whole page down to there."""
        more = {}
        if most_px is not None:
            width, height = self.run("return [innerWidth, document.documentElement.scrollHeight]")
            more = {"captureBeyondViewport": True, "clip": {"x": 0, "y": 0, "width": width, "height": min(height, most_px), "scale": 1}}
        data = self.devtools("Page.captureScreenshot", optimizeForSpeed=True, **more)["data"]
        pathlib.Path(path).write_bytes(base64.b64decode(data))


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class BrowserTest(unittest.TestCase):
    """Tests of a page in one browser, which begins each with nothing of the one before."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.browser.go("about:blank")
        self.browser.console()
        self.browser.resize(1280, 900)

    def see(self, selector, text):
        self.browser.wait_for_text(selector, text)
