# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The page of an atlas: for each map, mode and method a table of coloured cells, which tell their
numbers under the pointer."""
import html

from matplotlib.colors import to_hex

from totalforce_tools import page
from totalforce_tools.atlas_pictures import BOUNDS, NOTE, SHADES, decades
from totalforce_tools.atlas_rows import cell
from totalforce_tools.atlas_words import Summary, of_map, short

MODES = {"plain": "Methods alone", "refined": "Refined once",
         "service": "As the service answers a default request",
         "estimated": "The same with estimate always"}
TOLD = ("error", "error_high", "floor", "estimate", "answered_by", "reason", "own", "fallback",
        "refused", "about", "same_as")
TABLE = 'style="display: inline-block; margin: 0 1em 1em 0; font-size: 0.72em"'
HEAD = '<th style="padding: 0 0.3em">{}</th>'


def colour(error):
    shade = min(int((decades(error) + 16) // 2), SHADES.N - 1)
    return to_hex(SHADES(shade)), "#fff" if shade > 4 else "#000"


def told(row):
    return ", ".join(f"{name} {cell(row, name)}" for name in TOLD if cell(row, name) != "")


def written_cell(row, service, floor):
    error = row.floor if floor else row.error
    back, front = ("#fff", "#555") if row.is_refused and not floor else colour(error)
    words = f"{row.method} at {short(row.value)}, {row.bodies} bodies: {told(row)}"
    if service is not row:
        words += f"; default request: {told(service)}"
    return (f'<td style="background: {back}; color: {front}; padding: 0; width: 1.4em; '
            f'height: 1.2em; text-align: center" title="{html.escape(words)}">'
            f'{"" if floor else row.mark}</td>')


def panel(title, rows, service, floor=False):
    """A line for each value, the last one on top, a column for each size"""
    sizes = list(dict.fromkeys(r.bodies for r in rows))
    at = {(r.point, r.bodies): written_cell(r, service[r.method, r.point, r.bodies], floor)
          for r in rows}
    values = dict(sorted({r.point: r.value for r in rows}.items(), reverse=True))
    lines = "\n".join("".join(["<tr>", HEAD.format(short(value)),
                               *(at[point, size] for size in sizes), "</tr>"])
                      for point, value in values.items())
    foot = "".join(HEAD.format(size) for size in ("", *sizes))
    return (f"<table {TABLE}><caption>{html.escape(title)}</caption>\n{lines}\n"
            f"<tr>{foot}</tr></table>")


def of_mode(rows, mode, service):
    mine = [r for r in rows if r.mode == mode]
    yield f"<h3>{MODES[mode]}</h3>"
    for method in dict.fromkeys(r.method for r in rows):
        yield panel(method, [r for r in mine if r.method == method], service)
    if mode == "plain":
        yield panel("floor of the data", [r for r in mine if r.method == rows[0].method], service,
                    floor=True)


def of_one_map(name, facts, rows):
    service = {(r.method, r.point, r.bodies): r for r in rows if r.mode == "service"}
    yield page.heading(f"{name}: {facts.what}")
    yield page.text(f"Up: {facts.axis}. Right: moving bodies.")
    for mode in MODES:
        of_this = "\n".join(of_mode(rows, mode, service))
        yield of_this if mode in ("plain", "service") else page.folded(MODES[mode], of_this)
    yield from map(page.text, of_map(rows))


def key():
    shades = "".join(f'<td style="background: {to_hex(SHADES(k))}; width: 3em">&nbsp;</td>'
                     for k in range(SHADES.N))
    ends = "".join(f"<td>1e{power}</td>" for power in BOUNDS[:-1])
    return f"<table><tr>{shades}</tr><tr>{ends}</tr></table>"


def write(out, maps, *origin):
    s = Summary([row for _, _, rows in maps for row in rows])
    title = (f"{s.unsaid} of {sum(s.answers)} default requests are wrong by more than 1e-4 without "
             "an estimate: where a method fails, another one answers")
    parts = [page.text("Relative error of forward dynamics against quadruple precision, over the "
                       "cause of failures and the number of bodies. Light is exact, dark is "
                       "wrong."),
             key(), page.text(NOTE + ".")]
    for entry in maps:
        parts += of_one_map(*entry)
    page.write(out, title, *origin, parts)
