# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce chart --html`: marks, numbers under the pointer, filters, the picture without scripts.

    chart.py BIN
"""
import pathlib
import subprocess
import sys
import tempfile

from webdriver import Browser, Check, near, rows_of

BIN = pathlib.Path(sys.argv[1])
# of an arm and a robot whose names are HTML; with equal times on a front, and points below it
DATA = pathlib.Path(__file__).parent / "data" / "chart.csv"
PLACE = """const e = document.querySelector(arguments[0]); e.scrollIntoView({block: 'center'});
const box = (e.querySelector('path:last-child') || e).getBoundingClientRect();
return [box.left + box.width / 2, box.top + box.height / 2];"""
TIP = "const tip = document.getElementById('tip'); return tip.hidden ? '' : tip.innerText;"
MARKS = """return [...document.querySelectorAll('.m[data-r]')].filter(e => e.getClientRects().length)
    .map(e => Number(e.dataset.r));"""
BOX = """const box = [...document.querySelectorAll('.filters input')].find(e =>
    e.dataset.column === arguments[0] && e.value === arguments[1]);
box.click(); return box.checked;"""
FRONT = """return [...document.querySelectorAll('.panel:not([hidden])')].map(panel => [
    panel.querySelector('.front path').getAttribute('d').match(/[0-9.]+/g).map(Number),
    [...panel.querySelectorAll('.labels text')].map(e => e.textContent)]);"""


def check_marks(check, browser, rows):
    drawn = [k for k, row in enumerate(rows) if row["status"] == "ok" and not row["same_as"]]
    first = [k for k in drawn if rows[k]["rhs"] in ("qdd", "")]
    check(sorted(browser.run(MARKS)) == first, "marks:", len(browser.run(MARKS)), "not", len(first))
    total = browser.run("return document.querySelectorAll('.m[data-r]').length")
    check(total == len(drawn), "marks of all right-hand sides:", total, "not", len(drawn))
    return first


def check_numbers(check, browser, rows, marks):
    for mark in (marks[0], marks[len(marks) // 2], marks[-1]):
        browser.point(*browser.run(PLACE, f'.m[data-r="{mark}"]'))
        tip, row = browser.run(TIP), rows[mark]
        # of marks that lie on one another another one may be the nearest
        chosen = browser.run("return Number(document.querySelector('.m.on').dataset.r)")
        row = rows[chosen]
        for name in ("error", "time_us", "floor"):
            check(f"{name}\n{row[name]}\n" in tip, f"{name} of row {chosen}: {row[name]} not in", tip)
    browser.point(2, 2)
    check(browser.run(TIP) == "", "numbers stay when the pointer goes")
    browser.point(*browser.run(PLACE, f'.m[data-r="{marks[0]}"]'), kind="touch")
    check("time_us" in browser.run(TIP), "no numbers by touch")
    browser.run("document.querySelector('.panel svg').focus()")
    browser.press("\ue014")
    one = browser.run(TIP)
    browser.press("\ue014")
    check("time_us" in one and browser.run(TIP) != one, "no numbers by keyboard")


def check_filters(check, browser, rows, first):
    before = browser.run(FRONT)
    check(browser.run(BOX, "method", "crba") is False, "no filter of methods")
    left = [k for k in first if rows[k]["method"] != "crba"]
    check(sorted(browser.run(MARKS)) == left, "crba is not hidden")
    browser.run(BOX, "method", "crba")
    after = browser.run(FRONT)
    check(len(before) == 4 and len(before[0][1]) > 0, "no labels on the front")
    for was, now in zip(before, after):
        check(was[1] == now[1] and len(was[0]) == len(now[0]) and
              all(abs(a - b) < 0.1 for a, b in zip(was[0], now[0])), "front:", was, now)
    browser.run(BOX, "method", "aba")
    labels = [text for _, texts in browser.run(FRONT) for text in texts]
    check(labels and not any(text.startswith("aba") for text in labels), "no new front:", labels)
    browser.run(BOX, "method", "aba")
    browser.run(BOX, "threads", "1")
    check({rows[k]["threads"] for k in browser.run(MARKS)} == {"2"}, "threads are not filtered")
    browser.run(BOX, "threads", "2")
    check(browser.run("return document.querySelectorAll('.panel:not([hidden])').length") == 0,
          "panels without marks stay")
    browser.run(BOX, "threads", "1")
    browser.run(BOX, "threads", "2")
    browser.run(BOX, "rhs", "tau")
    check(browser.run("return document.querySelectorAll('.panel:not([hidden])').length") == 6,
          "no panels of the other right-hand side")
    browser.run(BOX, "rhs", "tau")
    browser.run(BOX, "op", "operational_inertia")
    check({rows[k]["op"] for k in browser.run(MARKS)} == {"forward_dynamics"}, "ops are not filtered")
    browser.run(BOX, "op", "operational_inertia")
    check(sorted(browser.run(MARKS)) == first, "filters do not come back")


def check_names(check, browser):
    check(browser.run("return window.hit") is None, "a robot's name runs as a script")
    check(browser.run("return document.scripts.length") == 1, "a script that is not ours")
    check("</pre><script>" in browser.run("return document.getElementById('rows').textContent"),
          "the link's name is not there as it is")


def check_dark(check, browser):
    browser.devtools("Emulation.setEmulatedMedia",
                     features=[{"name": "prefers-color-scheme", "value": "dark"}])
    back = browser.run("return getComputedStyle(document.body).backgroundColor")
    check(back == "rgb(20, 23, 26)", "no dark colours:", back)
    browser.devtools("Emulation.setEmulatedMedia", features=[])


def check_pixels(check, browser, colours, when):
    found = browser.colours(".panel svg")
    for name, colour in colours.items():
        check(near(found, colour) >= 12, f"{when}: {name}, {colour}: {near(found, colour)} pixels")


def check_files(check):
    """A page that cannot be written is told, and the exit status says so."""
    for file in ("/dev/full", "/absent/page.html"):
        done = subprocess.run([BIN / "totalforce", "chart", "--mechanisms", "random", "--bodies", "2",
                               "--methods", "aba", "--rhs", "qdd", "--budget-ms", "1", "--html", file],
                              capture_output=True, text=True, check=False)
        check(done.returncode == 2 and "totalforce chart: " in done.stderr, file, done)


def main():
    check = Check()
    check_files(check)
    with tempfile.TemporaryDirectory() as name, Browser() as browser:
        page = pathlib.Path(name) / "chart.html"
        subprocess.run([BIN / "draw_chart", DATA, page], check=True)
        rows = rows_of(DATA)
        browser.size(1000, 900)
        browser.open(page)
        first = check_marks(check, browser, rows)
        check_numbers(check, browser, rows, first)
        check_filters(check, browser, rows, first)
        check_names(check, browser)
        check_dark(check, browser)
        for width in (390, 830):
            check.fits(browser, width)
        colours = browser.run("""return Object.fromEntries([...document.querySelectorAll(
            '.legend [data-v]')].map(e => [e.dataset.v, getComputedStyle(e.firstChild).color]));""")
        check(len(set(colours.values())) == 4, "colours:", colours)
        check_pixels(check, browser, colours, "with scripts")
        check.quiet(browser, page)
        browser.devtools("Emulation.setScriptExecutionDisabled", value=True)
        browser.open(page)
        check_pixels(check, browser, colours, "without scripts")
    check.finish()


main()
