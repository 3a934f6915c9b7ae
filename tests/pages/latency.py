# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce latency --html`: curves, bars from zero, numbers under the pointer, filters, pictures
without scripts.

    latency.py BIN
"""
import csv
import pathlib
import re
import subprocess
import sys
import tempfile

from webdriver import Browser, Check, near, rows_of

BIN = pathlib.Path(sys.argv[1])
EVIL = "<script>window.hit=1<"  # in the command line
BOTTOM, LEFT = 226, 46  # of the pictures, in user units
PLACE = """const e = document.querySelector(`[data-r="${arguments[0]}"]`);
e.scrollIntoView({block: 'center'}); const box = e.getBoundingClientRect();
return [box.left + box.width / 2, box.top + box.height / 2];"""
TIP = "const tip = document.getElementById('tip'); return tip.hidden ? '' : tip.innerText;"
BOX = """const box = [...document.querySelectorAll('.filters input')].find(e =>
    e.dataset.column === arguments[0] && e.value === arguments[1]);
box.click(); return box.checked;"""
SHOWN = """return [...document.querySelectorAll('.panel [data-r]')].filter(e =>
    e.getClientRects().length).map(e => Number(e.dataset.r));"""


def draw(folder):
    """Page and table of two ways to one robot"""
    subprocess.run([BIN / "draw_latency", f"totalforce latency arm --table {EVIL}",
                    folder / "table.csv", folder / "latency.html"], check=True)
    return rows_of(folder / "table.csv")


def check_pictures(check, browser, rows, table):
    count = browser.run("""return [document.querySelectorAll('.panel .m').length,
        document.querySelectorAll('.panel rect[data-r]').length];""")
    points = [row for row in rows if row["figure"] in ("percentiles", "time")]
    check(count == [len(points), len(rows) - len(points)], "points and bars:", count, len(points))
    check(len(points) > 100, "only", len(points), "points")
    bars = browser.run("""return [...document.querySelectorAll('rect[data-r]')].map(e => [
        Number(e.dataset.r), e.x.baseVal.value, e.y.baseVal.value + e.height.baseVal.value]);""")
    for run in table:
        name = run["via"]
        ends = [end for row, _, end in bars if rows[row]["run"] == name and
                rows[row]["figure"] == "histogram"]
        check(ends and all(abs(end - BOTTOM) < 0.2 for end in ends), name, "bars do not start at 0")
        first = {}
        for row, x, _ in bars:
            if rows[row]["run"] == name and rows[row]["figure"] == "parts":
                first.setdefault(rows[row]["percentile"], x)
        check(first and all(x == LEFT for x in first.values()), name, "stacks:", first)
        seen = sum(int(row["count"]) for row in rows if row["run"] == name and
                   row["figure"] == "histogram")
        texts = " ".join(browser.run("return [...document.querySelectorAll('svg text')]"
                                     ".map(e => e.textContent)"))
        beyond = [int(word) for word in re.findall(r"(\d+) slower ones", texts)]
        check(any(seen + more == int(run["answered"]) for more in beyond), name, seen, "+", beyond)


def check_numbers(check, browser, rows, table):
    for run in table:
        for name in ("50", "90", "99"):
            wanted = f"{int(run[f'p{name}_ns']) / 1e3:.4g}"
            index = next((k for k, row in enumerate(rows) if row["run"] == run["via"] and
                          row["figure"] == "percentiles" and row["percentile"] == name), None)
            if name == "50": # between two points of the curve
                index = next(k for k, row in enumerate(rows) if row["run"] == run["via"] and
                             row["figure"] == "percentiles")
                wanted = rows[index]["us"]
            check(rows[index]["us"] == wanted, "p" + name, rows[index]["us"], "not", wanted)
            browser.point(*browser.run(PLACE, index))
            chosen = int(browser.run("return document.querySelector('.on').dataset.r"))
            for column in ("percentile", "us"):
                check(f"{column}\n{rows[chosen][column]}" in browser.run(TIP), column, "of", chosen)


def check_filter(check, browser, rows):
    browser.run(BOX, "run", "socket")
    left = [k for k, row in enumerate(rows) if row["run"] != "socket"]
    check(sorted(browser.run(SHOWN)) == left, "socket is not hidden")
    browser.run(BOX, "run", "socket")
    check(len(browser.run(SHOWN)) == len(rows), "the filter does not come back")


def check_pixels(check, browser, colours, when):
    found = browser.colours(".panel svg")
    for name, colour in colours.items():
        check(near(found, colour) >= 60, f"{when}: {name}, {colour}: {near(found, colour)} pixels")


def main():
    check = Check()
    with tempfile.TemporaryDirectory() as name, Browser() as browser:
        folder = pathlib.Path(name)
        table = draw(folder)
        page = folder / "latency.html"
        browser.size(1000, 900)
        browser.open(page)
        text = browser.run("return document.getElementById('rows').textContent")
        rows = list(csv.DictReader(text.splitlines()))
        check([run["via"] for run in table] == ["shm", "socket"], "runs:", table)
        check_pictures(check, browser, rows, table)
        check_numbers(check, browser, rows, table)
        check_filter(check, browser, rows)
        check(browser.run("return window.hit") is None, "a file's name runs as a script")
        check(EVIL in browser.run("return document.querySelector('footer').textContent"), "command")
        for width in (390, 830):
            check.fits(browser, width)
        colours = browser.run("""return Object.fromEntries([...document.querySelectorAll(
            '.panel .curve[data-f]')].map(e => [e.dataset.f, getComputedStyle(e).stroke]));""")
        check(len(set(colours.values())) >= 2, "curves:", colours)
        check_pixels(check, browser, colours, "with scripts")
        check.quiet(browser, page)
        browser.devtools("Emulation.setScriptExecutionDisabled", value=True)
        browser.open(page)
        check_pixels(check, browser, colours, "without scripts")
    check.finish()


main()
