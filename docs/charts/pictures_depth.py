# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""O(log N), counted: steps of each method on as many processors as a chain has bodies."""
from frame import COMMAND, round_ticks, ticks
from rows import some, unique
from totalforce_tools import command, style

LOGARITHMIC = ("tfa-cr", "cfa-cr", "dca", "scan-tree")


def on_all(chart, method):
    """On N processors: numbers of bodies, steps"""
    rows = [r for r in some(chart, method=method) if r.processors == r.bodies]
    return [r.bodies for r in rows], [r.steps for r in rows]


def added(chart, method):
    """Steps that the last doubling of the chain adds"""
    steps = on_all(chart, method)[1]
    return steps[-1] - steps[-2]


def draw(axis, chart, methods, **settings):
    for method in methods:
        shape, colour = ("v", "#CC3311") if method == "scan-tree" else style.mark(method)
        axis.plot(*on_all(chart, method), shape + "-", color=colour, ms=4, mfc="none", label=method)
    axis.set(xscale="log", xlabel="bodies of the chain = processors", **settings)
    ticks(axis.xaxis, unique(r.bodies for r in chart)[::2])


def depth(chart):
    """All methods, and those of logarithmic time alone, where each doubling adds as much"""
    least, most = (pick(added(chart, m) for m in LOGARITHMIC) for pick in (min, max))
    figure, ((left, right),) = style.picture(
        f"O(log N): twice the bodies on twice the processors take {least} to {most} operations "
        "more time; recursions along the chain twice the time",
        "operations counted, the same on every machine", command.today(), COMMAND, 1, 2,
        (style.WIDTH, 4.6), ["Factors and solve of a moving chain of revolute joints, level by "
                             "level; poses and velocities given; moving numbers takes no time"])
    draw(left, chart, unique(r.method for r in chart), yscale="log",
         title="operations one after the other")
    round_ticks(left.yaxis, *left.get_ylim())
    draw(right, chart, LOGARITHMIC, title="those of logarithmic time", ylim=(0, None))
    style.key(figure, 6)
    return figure
