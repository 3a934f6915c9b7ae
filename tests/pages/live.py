# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The live page of `totalforce web`: the figure moves, rates and percentiles, robots, the end of the
daemon and its return, names that are HTML, the numbers without scripts.

    live.py BIN ROBOTS
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "tools"))
from http_daemon import Client, Daemon, until, wait_for
from webdriver import Browser, Check, near

BIN, ROBOTS = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
EVIL = "<img src=x onerror=window.hit=1>"
TEXT = "const e = document.getElementById(arguments[0]); return e.hidden ? '' : e.innerText;"
GATEWAY = """state.clients = [{...state.clients[0], kind: "dds", process: state.process}];
showClients(); return byId("clients").innerText;"""
COLOUR = "return getComputedStyle(document.documentElement).getPropertyValue(arguments[0]);"
NUMBERS = """return [...document.querySelectorAll(arguments[0])].map(
    e => parseFloat(e.textContent.replace(',', '')));"""


def open_page(browser, daemon):
    for kind in ("browser", "performance"):
        browser.log(kind)
    browser.post("/url", url=f"http://127.0.0.1:{daemon.port}/")


def rgb(text):
    return f"rgb({int(text[1:3], 16)}, {int(text[3:5], 16)}, {int(text[5:7], 16)})"


def colour(browser, name):
    text = browser.run(COLOUR, name).strip()
    return rgb(text if len(text) == 7 else "#" + "".join(2 * c for c in text[1:]))


def status(browser):
    return browser.run(TEXT, "status")


def check_figure(check, browser):
    check(until(lambda: status(browser) == "Live."), "status:", status(browser))
    link, tip = colour(browser, "--link"), colour(browser, "--tip")
    places = browser.run("return motion.positions")
    grid = colour(browser, "--grid")
    pixels = lambda *of: near(browser.colours("canvas"), *of)
    check(until(lambda: pixels(link) >= 300), "links:", pixels(link), "pixels")
    check(until(lambda: pixels(tip) >= 60), "ellipsoid:", pixels(tip), "pixels")
    check(until(lambda: pixels(grid, 6) >= 300), "ground:", pixels(grid, 6), "pixels")
    first = browser.colours("canvas")
    # the robot, not only the view of it
    check(until(lambda: browser.run("return motion.positions") != places), "no link moves")
    check(until(lambda: browser.colours("canvas") != first), "the figure does not move")
    check(until(lambda: "tool0" in browser.run(TEXT, "tip")), "no tip")
    text = browser.run(TEXT, "tip")
    values = [float(word) for word in text.split("tool0")[1].split("\t")[1].split("·")]
    check(len(values) == 3 and values[0] >= values[1] >= values[2] > 0, "eigenvalues:", text)


# A robot is chosen while a state of another one is on its way.
CHOOSE_MEANWHILE = """
const fetched = window.fetch;
window.fetch = async (path, ...more) => {
  const answer = await fetched(path, ...more);
  if (path.startsWith("/state")) {
    window.fetch = fetched;
    document.getElementById("robot").value = "still";
    document.getElementById("robot").dispatchEvent(new Event("change"));
  }
  return answer;
};"""


def check_view(check, browser):
    """By keys, of a robot that stands still."""
    browser.run(CHOOSE_MEANWHILE)
    check(until(lambda: "No request yet" in status(browser)), "status:", status(browser))
    check(until(lambda: browser.run("return document.title") == "still – totalforced"), "no robot")
    check(until(lambda: same_twice(browser)), "it does not stand still")
    before = browser.colours("canvas")
    browser.run("document.getElementById('figure').focus()")
    for _ in range(4):
        browser.press("\ue014")
    check(until(lambda: browser.colours("canvas") != before), "arrow keys do not turn the view")
    browser.run("document.getElementById('robot').value = 'arm';"
                "document.getElementById('robot').dispatchEvent(new Event('change'));")
    check(until(lambda: status(browser) == "Live."), "status:", status(browser))


def same_twice(browser):
    first = browser.colours("canvas")
    time.sleep(0.3)
    return browser.colours("canvas") == first


def check_numbers(check, browser, client):
    rate = lambda: (browser.run(NUMBERS, ".tile b") or [0])[0] or 0
    check(until(lambda: rate() > 0), "rate:", rate())
    check(until(lambda: "M" in (browser.run("return document.querySelector('#times .c1')?."
                                            "getAttribute('d')") or "")), "no percentiles")
    times = lambda: browser.run(NUMBERS, "#time-keys b") # none while nobody asks
    check(until(lambda: len(now := times()) == 3 and all(now)), "percentiles:", times())
    now = times()
    check(not all(now) or 0 < now[0] <= now[1] <= now[2], "percentiles:", now)
    curve = colour(browser, "--c1")
    check(until(lambda: near(browser.colours("#rates"), curve) >= 10), "no curve of rates")
    clients = browser.run(TEXT, "clients")
    check(f"shm {client.process.pid}" in clients, "clients:", clients)
    check("gateway dds" in (text := browser.run(GATEWAY)), "a gateway's row:", text)
    check("aba" in browser.run(TEXT, "methods"), "no methods")


def check_quiet(check, browser, daemon):
    entries = [entry["message"] for entry in browser.log("browser")]
    check(not entries, "console:", entries)
    own = f"http://127.0.0.1:{daemon.port}/"
    others = [url for url in browser.requests() if not url.startswith(("data:", own))]
    check(not others, "requests:", others)
    check(browser.run("return window.hit") is None, "a name runs as a script")


def check_names(check, browser):
    choose = ("document.getElementById('robot').value = arguments[0];"
              "document.getElementById('robot').dispatchEvent(new Event('change'));")
    browser.run(choose, "evil")
    check(until(lambda: EVIL in browser.run(TEXT, "tip")), "tips:", browser.run(TEXT, "tip"))
    check(browser.run("return document.images.length") == 0, "a name became an element")
    browser.run(choose, "arm")
    check(until(lambda: status(browser) == "Live."), "status:", status(browser))


def check_dark(check, browser):
    browser.devtools("Emulation.setEmulatedMedia",
                     features=[{"name": "prefers-color-scheme", "value": "dark"}])
    check(browser.run("return getComputedStyle(document.body).backgroundColor") ==
          "rgb(20, 23, 26)", "no dark colours")
    link = colour(browser, "--link")
    check(until(lambda: near(browser.colours("canvas"), link) >= 300), "no figure in the dark")
    browser.devtools("Emulation.setEmulatedMedia", features=[])


def check_gone(check, browser, daemon):
    """A daemon that ends, and another in its place; the same of the page's server"""
    daemon.end_daemon()
    check(until(lambda: "The daemon is gone" in status(browser)), "status:", status(browser))
    daemon.start_daemon()
    check(until(lambda: "No request yet" in status(browser)), "status:", status(browser))
    daemon.end_web()
    check(until(lambda: "The daemon is gone" in status(browser)), "status:", status(browser))
    daemon.start_web(daemon.port)
    check(until(lambda: "No request yet" in status(browser)), "status:", status(browser))


def check_plain(check, browser, daemon):
    asked = lambda: [c["requests"] for c in json.loads(daemon.tool("status", "--json"))["clients"]]
    wait_for(lambda: max(asked()) > 100, "no requests")
    browser.devtools("Emulation.setScriptExecutionDisabled", value=True)
    browser.post("/url", url=f"http://127.0.0.1:{daemon.port}/")
    text = browser.post("/element", using="css selector", value="body")
    text = browser._ask("GET", f"{browser.session}/element/{list(text.values())[0]}/text")
    for wanted in ("The live picture needs scripts", "Requests/s", "arm", "still", "evil"):
        check(wanted in text, f"without scripts: no '{wanted}' in", text)
    row = next((line.split() for line in text.splitlines() if line.startswith("arm ")), [])
    check(len(row) == 8 and int(row[5]) > 100, "without scripts:", row)
    browser.devtools("Emulation.setScriptExecutionDisabled", value=False)


def write_evil(folder):
    chain = subprocess.run([BIN / "totalforce", "chain", "rank-deficient", "--bodies", "5"],
                           check=True, capture_output=True, text=True).stdout
    name = EVIL.replace("<", "&lt;").replace(">", "&gt;")
    (folder / "evil.urdf").write_text(chain.replace('"link', f'"{name}link'), encoding="utf-8")
    return folder / "evil.urdf"


def main():
    check = Check()
    with tempfile.TemporaryDirectory() as name, Browser() as browser:
        folder = pathlib.Path(name)
        robots = [("arm", ROBOTS / "arm7.urdf", ""), ("evil", write_evil(folder), ""),
                  ("still", ROBOTS / "quadruped.urdf", ", base: floating")]
        browser.size(1000, 900)
        with Daemon(BIN, folder, robots) as daemon:
            with Client(daemon, "arm", 7) as client:
                open_page(browser, daemon)
                check_figure(check, browser)
                check_numbers(check, browser, client)
                check_view(check, browser)
                check_names(check, browser)
                check_dark(check, browser)
                for width in (390, 830):
                    check.fits(browser, width)
                check_quiet(check, browser, daemon)
                check_plain(check, browser, daemon)
            open_page(browser, daemon)
            check_gone(check, browser, daemon)
    check.finish()


main()
