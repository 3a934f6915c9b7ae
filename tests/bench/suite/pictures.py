# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Pictures of docs/performance.md, from what performance.sh measured:

    PYTHONPATH=BUILD/python:docs/charts /usr/bin/python3 pictures.py SUITE.csv FOLDER
"""
import pathlib
import sys
from statistics import median

from frame import round_ticks, ticks
from rows import Rows, some, unique
from totalforce_tools import style

CHAINS = {"aba": ("aba", "-"), "scan": ("scan", "-"), "scan-2": ("scan", "--"),
          "tfa-cr": ("tfa-cr", "-"), "tfa-cr-2": ("tfa-cr", "--"), "tfa-cr+1-2": ("tfa-cr", ":"),
          "cfa-cr-2": ("cfa-cr", "--"), "MuJoCo 2.2.2": ("mujoco", "-")}


def values(rows, **fields):
    """ns a joint by robot"""
    return {r.robot if r.base == "fixed" else f"{r.robot}, floating": r.ns_per_joint
            for r in some(rows, **fields)}


def ratios(slow, fast):
    return [slow[name] / fast[name] for name in fast if name in slow]


def marks(origin, headline, note, series):
    """A line for each robot, a mark for each series; and no bars: a logarithmic axis has no zero"""
    names = unique(name for found in series.values() for name in found)
    figure, axes = style.picture(headline, *origin, size=(style.WIDTH, 1.8 + 0.22 * len(names)),
                                 notes=[note])
    axis = axes[0, 0]
    for (label, found), colour, shape in zip(series.items(), style.SERIES, "osXv^"):
        axis.plot(found.values(), [names.index(name) for name in found], shape, color=colour, ms=6,
                  label=label)
    axis.set(xscale="log", xlabel="ns a joint", yticks=range(len(names)), yticklabels=names,
             ylim=(len(names) - 0.5, -0.5))
    round_ticks(axis.xaxis, *axis.get_xlim())
    style.key(figure, 5)
    return figure


def robots(rows, origin):
    """One state of forward dynamics: the library and its peers"""
    series = {label: values(rows, base="fixed", task="fd", contestant=who) for label, who in
              (("totalforce", "now"), ("MuJoCo 2.2.2", "mujoco"), ("Orocos KDL 1.5.1", "kdl"))}
    own, others = series["totalforce"], ratios(series["MuJoCo 2.2.2"], series["totalforce"])
    headline = (f"MuJoCo takes {min(others):.1f} to {max(others):.1f} times as long as totalforce"
                if others else f"Forward dynamics takes {min(own.values()):.0f} to "
                f"{max(own.values()):.0f} ns a joint")
    return marks(origin, headline, "Forward dynamics of one state, fixed base",
                 {label: found for label, found in series.items() if found})


def batches(rows, origin):
    tasks = {"one state": "fd", "double": "batch-f64", "double, 2 threads": "batch-f64-2",
             "float": "batch-f32", "float, 2 threads": "batch-f32-2"}
    found = {label: values(rows, task=task, contestant="now") for label, task in tasks.items()}
    alone = {name: found["one state"][name] for name in found["double"]}
    double, single = (median(ratios(alone, found[label])) for label in ("double", "float"))
    return marks(origin, f"A batch makes a state {double:.1f} times as fast, in single precision "
                 f"{single:.1f} times", "Forward dynamics of one of 512 states",
                 found | {"one state": alone})


def chains(rows, origin):
    """Time of a body by length and method, on one thread and two"""
    rows = [r for r in some(rows, base="fixed") if r.robot.startswith("chain")]
    lines = {task: [(r.joints, r.ns_per_joint) for r in (
        some(rows, task="fd", contestant="mujoco") if task.startswith("MuJoCo") else
        some(rows, task=task, contestant="now"))] for task in CHAINS}
    (bodies, aba), (_, one), (_, two) = (lines[task][-1] for task in ("aba", "scan", "scan-2"))
    figure, axes = style.picture(
        f"At {bodies} bodies the scan takes {one / aba:.2f} of the time of aba, by two threads "
        f"{two / aba:.2f}", *origin, size=(style.WIDTH, 4.6), notes=[
            "Forward dynamics of one state of a chain; -2: two threads; +1: refined, estimated"])
    axis = axes[0, 0]
    for task, points in lines.items():
        if points:
            shape, colour = style.mark(CHAINS[task][0])
            axis.plot(*zip(*points), CHAINS[task][1], marker=shape, mfc="none", ms=5, color=colour,
                      label=task)
    axis.set(xscale="log", yscale="log", xlabel="bodies", ylabel="ns a body")
    ticks(axis.xaxis, unique(r.joints for r in rows))
    round_ticks(axis.yaxis, *axis.get_ylim())
    style.key(figure, 4)
    return figure


if __name__ == "__main__":
    suite = Rows(pathlib.Path(sys.argv[1]))
    command, date, machine = (": ".join(filter(None, line)) for line in suite.head[:3])
    for draw in (robots, chains, batches):
        style.save(draw(suite, (machine, date, command)), sys.argv[2], draw.__name__, ["svg"])
