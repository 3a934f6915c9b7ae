# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The picture of a map: a column of panels for each method, a line for each mode; in a panel a cell
for each size (right) and value (up), its colour the logarithm of the error."""
import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm

from totalforce_tools import style
from totalforce_tools.atlas_words import Summary, first_failures, of_map, short

SHOWN = {"plain": "alone", "refined": "refined once", "service": "default request"}
BOUNDS = range(-16, 1, 2)  # decades: two a shade, light is exact and dark is wrong
SHADES = colormaps["cividis_r"].resampled(len(BOUNDS) - 1)
NOTE = ("Relative error of qdd, 2-norm, median over seeds and states. Who answered: no mark, the "
        "method; a letter, another one (a: aba, s: scan, c: crba); ? itself, wrong by more than "
        "1e-4 without an estimate; × none, refused by name; = as a method to the left, to the "
        "last bit")


def decades(error):
    return float(np.log10(np.clip(error, 1e-16, 1.0)))


def headline(what, rows):
    s, found = Summary(rows), first_failures(rows, "plain")
    values = {r.point: short(r.value) for r in rows}
    some = [f"{', '.join(found[point])} from {values[point]} on"
            for point in sorted(found.keys() - {None})]
    alone = f"methods fail alone ({'; '.join(some)}), yet" if some else "no method fails alone, and"
    return (f"{what[0].upper()}{what[1:]}: {alone} {s.unsaid} of {sum(s.answers)} default requests "
            "are wrong without an estimate")


def draw_cells(axis, rows, sizes, points, number, mark):
    cells = np.full((points, len(sizes)), np.nan)
    for row in rows:
        x = sizes.index(row.bodies)
        cells[row.point, x] = number(row)
        if mark(row):
            axis.text(x, row.point, mark(row), ha="center", va="center", size=6,
                      color="white" if cells[row.point, x] > -7 else "black")
    axis.grid(False)
    axis.set(xticks=range(len(sizes)), yticks=range(points), xticklabels=sizes)
    axis.tick_params(labelsize=6.5, length=2)
    axis.tick_params(axis="x", labelrotation=90)
    return axis.imshow(cells, SHADES, BoundaryNorm(BOUNDS, SHADES.N), aspect="auto", origin="lower")


def draw_panels(axes, rows, methods, sizes, points):
    for line, mode in enumerate(SHOWN):
        for column, method in enumerate(methods):
            mine = [r for r in rows if r.method == method and r.mode == mode]
            drawn = draw_cells(axes[line, column], mine, sizes, points,
                               lambda r: np.nan if r.is_refused else decades(r.error),
                               lambda r: r.mark)
    mine = [r for r in rows if r.method == methods[0] and r.mode == "plain"]
    draw_cells(axes[2, -1], mine, sizes, points, lambda r: decades(r.floor), lambda r: "")
    return drawn


def draw(folder, name, facts, rows, machine, date, command):
    methods, sizes = [list(dict.fromkeys(getattr(r, key) for r in rows))
                      for key in ("method", "bodies")]
    values = [short(value) for value in dict.fromkeys(r.value for r in rows)]
    figure, axes = style.picture(
        headline(facts.what, rows), machine, date, command, rows=3, columns=len(methods) + 1,
        size=(max(style.WIDTH, 1.05 * len(methods) + 2.6), 8.5), sharex=True, sharey=True,
        notes=[*of_map(rows), NOTE + f"; right-hand side: {rows[0].rhs}"])
    drawn = draw_panels(axes, rows, methods, sizes, len(values))
    for axis, title in zip([*axes[0, :-1], axes[2, -1]], [*methods, "floor of the data"]):
        axis.set_title(title, fontsize=8)
    for axis, words in zip(axes[:, 0], SHOWN.values()):
        axis.set_ylabel(f"{words}\n{facts.axis}", fontsize=7)
    axes[0, 0].set(yticklabels=values)
    axes[2, len(methods) // 2].set_xlabel("moving bodies", fontsize=7)
    for axis in axes[:2, -1]:
        axis.set_axis_off()
    bar = figure.colorbar(drawn, cax=axes[0, -1].inset_axes([0.1, 0.0, 0.2, 1.0]), ticks=BOUNDS)
    bar.ax.set_yticklabels([f"1e{power}" for power in BOUNDS], fontsize=6.5)
    style.save(figure, folder, name)
