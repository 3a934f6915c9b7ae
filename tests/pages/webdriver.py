# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A headless Chromium for tests of pages: WebDriver and DevTools commands through chromedriver."""
import base64
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import guard
from wait import WAIT

SKIPPED = 77
ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             "--disable-dev-shm-usage", "--force-color-profile=srgb", "about:blank"]


class Browser:
    """One window with one page; `with` ends driver and browser."""

    def __init__(self):
        driver = shutil.which("chromedriver")
        if not driver:
            print("skipped: no chromedriver (package chromium-driver)")
            sys.exit(SKIPPED)
        self.profile = tempfile.mkdtemp()
        self.session = None
        # The port that a driver gets for IPv6 another program may have for IPv4: then it ends.
        for _ in range(20):
            # the browser is in the driver's process group
            self.driver = guard.start([driver, "--port=0"], stdout=subprocess.PIPE, text=True,
                                      stderr=subprocess.DEVNULL)
            try:
                if self._listens():
                    self._start()
                    return
            except BaseException:
                self.close()
                raise
            guard.end(self.driver)
            self.driver.stdout.close()
        raise RuntimeError("chromedriver does not start")

    def _listens(self):
        for line in self.driver.stdout:
            if "started successfully on port" in line:
                self.address = f"http://127.0.0.1:{line.split()[-1].rstrip('.')}"
                return True
        return False

    def _start(self):
        options = {"args": ARGUMENTS + [f"--user-data-dir={self.profile}"],
                   "perfLoggingPrefs": {"enableNetwork": True}}
        wanted = {"goog:chromeOptions": options,
                  "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        answer = self._ask("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self.session = f"/session/{answer['sessionId']}"
        browser = answer["capabilities"]["goog:processID"]
        assert os.getpgid(browser) == self.driver.pid, "a browser that nobody would end"

    def _ask(self, verb, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.address + path, data=data, method=verb,
                                         headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=WAIT) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(f"{path}: {json.load(error)['value']['message']}") from None

    def post(self, path, **body):
        return self._ask("POST", self.session + path, body)

    def devtools(self, command, **parameters):
        return self.post("/goog/cdp/execute", cmd=command, params=parameters)

    def close(self):
        """Ends the session, then whatever is left of driver and browser."""
        try:
            if self.session:
                self._ask("DELETE", self.session)
        except (OSError, RuntimeError):
            pass
        guard.end(self.driver, signal.SIGKILL)
        self.driver.stdout.close()
        shutil.rmtree(self.profile, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # ---- the page
    def size(self, width, height):
        self.devtools("Emulation.setDeviceMetricsOverride", width=width, height=height,
                      deviceScaleFactor=1, mobile=False)

    def open(self, file):
        for kind in ("browser", "performance"):
            self.log(kind)
        self.post("/url", url=pathlib.Path(file).resolve().as_uri())

    def run(self, script, *arguments):
        """The value that the script returns."""
        return self.post("/execute/sync", script=script, args=list(arguments))

    def log(self, kind):
        return self.post("/se/log", type=kind)

    def requests(self):
        """Addresses that the browser asked for since the last call, data: and the page included"""
        found = []
        for entry in self.log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                found.append(message["params"]["request"]["url"])
        return found

    def point(self, x, y, kind="mouse"):
        """Moves the pointer, or touches, at a place of the window."""
        actions = [{"type": "pointerMove", "x": round(x), "y": round(y), "duration": 0}]
        if kind == "touch":
            actions += [{"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}]
        self.post("/actions", actions=[{"type": "pointer", "id": kind, "actions": actions,
                                        "parameters": {"pointerType": kind}}])

    def press(self, key):
        self.post("/actions", actions=[{"type": "key", "id": "keys", "actions": [
            {"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]}])

    def colours(self, selector):
        """Pixels of the first such element on the screen: how many of each colour"""
        root = self.devtools("DOM.getDocument")["root"]["nodeId"]
        node = self.devtools("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        box = self.devtools("DOM.getBoxModel", nodeId=node)["model"]["border"]
        window = self.devtools("Page.getLayoutMetrics")["cssVisualViewport"]
        clip = {"x": box[0] + window["pageX"], "y": box[1] + window["pageY"], "width": box[2] - box[0], "height": box[5] - box[1],
                "scale": 1} # in the page
        shot = self.devtools("Page.captureScreenshot", format="png", clip=clip,
                             captureBeyondViewport=True)
        return count_colours(base64.b64decode(shot["data"]))


def count_colours(png):
    """{(red, green, blue): pixels} of a PNG of eight bits a channel"""
    width, height, depth, kind = struct.unpack(">IIBB", png[16:26])
    channels = {2: 3, 6: 4}[kind]
    assert depth == 8
    data, at = b"", 8
    while at < len(png):
        length, name = struct.unpack(">I4s", png[at:at + 8])
        if name == b"IDAT":
            data += png[at + 8:at + 8 + length]
        at += 12 + length
    data = zlib.decompress(data)
    found, above, stride = {}, bytearray(width * channels), width * channels
    for y in range(height):
        filtered = data[y * (stride + 1)]
        line = bytearray(data[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        unfilter(line, above, filtered, channels)
        for x in range(0, stride, channels):
            colour = (line[x], line[x + 1], line[x + 2])
            found[colour] = found.get(colour, 0) + 1
        above = line
    return found


def unfilter(line, above, kind, channels):
    for x in range(len(line) if kind else 0):
        left = line[x - channels] if x >= channels else 0
        corner = above[x - channels] if x >= channels else 0
        up = above[x]
        if kind == 4:
            guess = left + up - corner
            guess = min((left, up, corner), key=lambda value: abs(guess - value))
        else:
            guess = (0, left, up, (left + up) // 2)[kind]
        line[x] = (line[x] + guess) & 255


def near(colours, wanted, reach=40):
    """Pixels of about that colour, "rgb(1, 2, 3)" """
    rgb = [int(word) for word in wanted[wanted.index("(") + 1:-1].split(",")[:3]]
    return sum(count for colour, count in colours.items()
               if all(abs(a - b) <= reach for a, b in zip(colour, rgb)))


class Check:
    """Counts failures: `check(condition, text)`."""

    def __init__(self):
        self.failures = 0
        self.begin = time.monotonic()

    def __call__(self, good, *text):
        if not good:
            print("FAILED:", *text)
            self.failures += 1
        return good

    def quiet(self, browser, file):
        """No message of the console, no address but the page's own"""
        entries = [entry["message"] for entry in browser.log("browser")]
        self(not entries, "console:", entries)
        others = [url for url in browser.requests()
                  if not url.startswith("data:") and url != pathlib.Path(file).resolve().as_uri()]
        self(not others, "requests:", others)

    def fits(self, browser, width):
        """Nothing to scroll sideways"""
        browser.size(width, 900)
        found = browser.run("return document.documentElement.scrollWidth")
        self(found <= width, f"{found} px wide in a window of {width} px")

    def finish(self):
        print("all good" if not self.failures else f"{self.failures} failures",
              f"({time.monotonic() - self.begin:.1f} s)")
        sys.exit(self.failures > 0)


def rows_of(csv):
    """The rows of a CSV file as dictionaries"""
    import csv as reader
    with open(csv, newline="", encoding="utf-8") as file:
        return list(reader.DictReader(line for line in file if not line.startswith("#")))
