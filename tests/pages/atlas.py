# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce atlas --html`: cells, numbers under the pointer, filters, maps without scripts.

    atlas.py BIN
"""
import pathlib
import subprocess
import sys
import tempfile

from webdriver import Browser, Check, near, rows_of

BIN = pathlib.Path(sys.argv[1])
DATA = pathlib.Path(__file__).parent / "data" / "atlas.csv"
METHODS = ["aba", "tfa", "dca"]
PLACE = """const e = document.querySelector(arguments[0]); e.scrollIntoView({block: 'center'});
const box = e.getBoundingClientRect();
return [box.left + box.width / 2, box.top + box.height / 2];"""
TIP = "const tip = document.getElementById('tip'); return tip.hidden ? '' : tip.innerText;"
PANELS = """return [...document.querySelectorAll('.panel')].filter(e => e.getClientRects().length)
    .map(e => e.closest('.group').querySelector('h3').textContent + ': ' +
        e.querySelector('b').textContent);"""
BOX = """const box = [...document.querySelectorAll('.filters input')].find(e =>
    e.dataset.column === arguments[0] && e.value === arguments[1]);
box.click(); return box.checked;"""
ALONE, SERVICE = "Methods alone", "As the service answers a default request"


def check_cells(check, browser, rows):
    cells = browser.run("""return [...document.querySelectorAll('.panel rect[data-r]')]
        .map(e => [Number(e.dataset.r), e.getAttribute('class'), e.dataset.also])""")
    floors = sum(row["method"] == "aba" and row["mode"] == "plain" for row in rows)
    check(len(cells) == len(rows) + floors, "cells:", len(cells))
    for index, shade, also in cells:
        error = rows[index]["error"]
        wanted = "none" if not error else f"q{min(7, max(0, int((16 + exponent(error)) // 2)))}"
        of_floor = rows[index]["method"] == "aba" and rows[index]["mode"] == "plain"
        same = also is None or [rows[int(also)][name] for name in ("mode", "map", "value", "bodies",
            "method")] == ["service"] + [rows[index][name] for name in ("map", "value", "bodies", "method")]
        check(same, f"row {index}: not the service's answer there: {also}")
        check(shade == wanted or of_floor, f"row {index}: error {error} is {shade}")
    check(len({shade for _, shade, _ in cells}) > 4, "one colour")


def exponent(text):
    """Of a number, rounded down"""
    return int(text.split("e")[1]) if float(text) else -16


def check_numbers(check, browser, rows):
    wanted = next(k for k, row in enumerate(rows) if row["map"] == "thin" and row["method"] == "tfa" and
                  row["mode"] == "plain" and row["bodies"] == "16" and float(row["value"]) < 1e-5)
    browser.point(*browser.run(PLACE, f'rect[data-r="{wanted}"]'))
    tip, service = browser.run(TIP), rows[wanted + 2]
    for name in ("error", "floor", "bodies"):
        check(f"{name}\n{rows[wanted][name]}\n" in tip, f"{name}: {rows[wanted][name]} not in", tip)
    check(service["mode"] == "service" and
          f"error\n{service['error']}\n" in tip[tip.index("default request"):], "service:", tip)
    check(f"answered_by\n{service['answered_by']}" in tip, "who answered:", tip)


def check_filters(check, browser):
    first = [f"{ALONE}: {name}" for name in METHODS + ["floor of the data"]] + \
        [f"{SERVICE}: {name}" for name in METHODS]
    check(browser.run(PANELS) == 2 * first, "panels:", browser.run(PANELS))
    browser.run(BOX, "map", "curl")
    browser.run(BOX, "mode", "service")
    browser.run(BOX, "method", "dca")
    left = [f"{ALONE}: {name}" for name in ("aba", "tfa", "floor of the data")]
    check(browser.run(PANELS) == left, "filtered:", browser.run(PANELS))
    browser.run(BOX, "map", "curl")
    browser.run(BOX, "mode", "service")
    browser.run(BOX, "method", "dca")
    check(browser.run(PANELS) == 2 * first, "filters do not come back")


SHADES = """return Object.fromEntries([...document.querySelectorAll('.panel:nth-child(2) rect')]
    .map(e => [e.getAttribute('class'), getComputedStyle(e).fill]))"""


def check_pixels(check, browser, shades, when):
    found = browser.colours("section .panel:nth-child(2) svg")
    for name, colour in shades.items():
        check(near(found, colour, 2) >= 50, f"{when}: {name}: {near(found, colour, 2)} pixels")


def main():
    check = Check()
    with tempfile.TemporaryDirectory() as name, Browser() as browser:
        page = pathlib.Path(name) / "atlas.html"
        subprocess.run([BIN / "draw_atlas", DATA, page], check=True)
        rows = rows_of(DATA)
        browser.size(1000, 900)
        browser.open(page)
        check_cells(check, browser, rows)
        check_numbers(check, browser, rows)
        check_filters(check, browser)
        for width in (390, 830):
            check.fits(browser, width)
        shades = browser.run(SHADES)
        check(len(shades) >= 5, "shades of tfa on thin rods:", shades)
        check_pixels(check, browser, shades, "with scripts")
        check.quiet(browser, page)
        browser.devtools("Emulation.setScriptExecutionDisabled", value=True)
        browser.open(page)
        shades = browser.run(SHADES)
        check(len(shades) >= 5, "shades of tfa on thin rods:", shades)
        check_pixels(check, browser, shades, "without scripts")
    check.finish()


main()
