# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Error against time of one answer by every method, bare and refined, in three precisions, by one
thread and two: robots, and chains that are benign and ill-conditioned."""
from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter

from frame import COMMAND, decades
from rows import pairs, some, unique
from totalforce_tools import style
from totalforce_tools.chart_pictures import clip, draw_floor, is_exact

SCENES = {"arm7": "7-joint arm", "random": "chain of {}", "humanoid": "47-joint humanoid",
          "thin": "thin rods, chain of {}"}
INVERTING = ("tfa", "cfa", "dca", "hessenberg")
WORDS = {"f64": "", "f32": " float", "f32+f64": " mixed"}


def worth_drawing(rows):
    """Without answers that a second thread makes no faster"""
    slower = {id(two) for two, one in pairs(rows, "threads", 2, 1)
              if two.time_us > 0.9 * one.time_us}
    return [row for row in some(rows, status="ok") if id(row) not in slower]


def front(rows):
    """The fastest answers of each error; below the floor of the data all are alike."""
    best, found = float("inf"), []
    for row in sorted(rows, key=lambda r: (r.time_us, r.error)):
        if max(row.error, row.floor) < best:
            best = max(row.error, row.floor)
            found.append(row)
    return found


def label(row):
    return (row.method + "+1" * (row.refine > 0) + WORDS[row.precision]
            + ", 2 threads" * (row.threads > 1))


def headline(panels):
    """Whose answers are on the fronts, and what exact answers by inverted body inertias cost"""
    leaders = unique(row.method for rows in panels for row in front(rows))
    slower = []
    for rows in panels:
        exact = [row for row in rows if is_exact(row)]
        inverting = [r.time_us for r in exact if r.method in INVERTING]
        if inverting:
            slower.append(min(inverting) / min(r.time_us for r in exact))
    lost = len(panels) - len(slower)
    return (f"On the fronts: {', '.join(leaders)}. Methods that invert body inertias are exact "
            f"{min(slower):.1f} to {max(slower):.1f} times as late"
            + f", or never ({lost} of {len(panels)} scenes)" * (lost > 0))


def draw_panel(axis, rows, title):
    best = front(rows)
    for row in rows:
        shape, colour = style.mark(row.method)
        axis.plot(1e-6 * row.time_us, clip(row.error), shape, color=colour, ms=4.5,
                  mfc=colour if row.refine else "none", alpha=1 if row in best else 0.3,
                  zorder=3 if row in best else 2)
    axis.step([1e-6 * r.time_us for r in best], [clip(r.error) for r in best], where="post",
              color="#bbbbbb", lw=4, zorder=1)
    for row in best:
        axis.annotate(label(row), (1e-6 * row.time_us, clip(row.error)), (-4, -9), size=7,
                      textcoords="offset points", zorder=4)
    draw_floor(axis, rows)
    axis.set(title=title, xscale="log", xlabel="time of an answer")
    low, high = axis.get_xlim()
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 3) if high / low < 300 else (1,)))
    axis.xaxis.set_major_formatter(EngFormatter("s"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    decades(axis.yaxis, 1e-16, 1e3)


def fronts(chart):
    scenes = [worth_drawing(some(chart, mechanism=name, bodies=size))
              for name in SCENES for size in unique(r.bodies for r in some(chart, mechanism=name))]
    figure, axes = style.picture(
        headline(scenes), chart.fact("processor"), chart.fact("date"), COMMAND, 2,
        -(-len(scenes) // 2), (style.WIDTH, 7.4), [
            "Forward dynamics, one state a call, torques of a random acceleration: relative error "
            "against quadruple precision. Open: as solved; filled, +1: refined once; mixed: float, "
            "refined in double; two threads where they are faster. Faint: slower or less exact "
            "than a mark of the grey front. Dashed: what rounding the inputs costs every method"],
        sharey=True)
    for axis, rows in zip(axes.flat, scenes):
        draw_panel(axis, rows, SCENES[rows[0].mechanism].format(rows[0].bodies))
    for axis in axes[:, 0]:
        axis.set_ylabel("relative error")
    for method in unique(r.method for rows in scenes for r in rows):
        shape, colour = style.mark(method)
        axes[0, 0].plot([], [], shape, color=colour, ms=4.5, mfc="none", label=method)
    style.key(figure, 7)
    return figure
