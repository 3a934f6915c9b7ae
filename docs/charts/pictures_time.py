# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Pictures of times: the README's, Lambda^-1, a second core, single precision."""
from statistics import geometric_mean, median_low

import numpy as np
from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter

from frame import OTHER, OWN, picture, round_ticks, ticks
from rows import cost_of_float, pairs, some, unique
from totalforce_tools.chart_pictures import is_exact

ROBOTS = {"arm7": "7-joint arm", "quadruped": "12-joint quadruped",
          "humanoid": "47-joint humanoid"}
PEERS = {"mujoco": "MuJoCo", "kdl": "Orocos KDL"}


def collect(rows, name_of):
    """Answers by robot or chain, and by name"""
    panels = {}
    for row in some(rows, status="ok"):
        if name_of(row):
            where = ROBOTS.get(row.mechanism, f"chain of {row.bodies}")
            panels.setdefault(where, {})[name_of(row)] = row
    return panels


def by_speed(panels):
    """Names, by the mean of their times over the fastest of each panel"""
    slower = {}
    for panel in panels.values():
        best = min(row.time_us for row in panel.values())
        for name, row in panel.items():
            slower.setdefault(name, []).append(row.time_us / best)
    return sorted(slower, key=lambda name: geometric_mean(slower[name]))


def dots(chart, panels, headline, note):
    """A line for each name, in each panel a dot at its time with its error beside it"""
    names = by_speed(panels)
    figure, axes = picture(
        chart, headline, f"{note}: time, beside it the relative error against quadruple precision; "
        "orange: more than ten times the floor of the data", len(panels), 1.6 + 0.23 * len(names),
        sharey=True)
    for axis, (title, panel) in zip(axes, panels.items()):
        for name, row in panel.items():
            colour, at = OWN if is_exact(row) else OTHER, (1e-6 * row.time_us, names.index(name))
            axis.plot(*at, "X" if row.method in PEERS else "o", color=colour, ms=5)
            axis.annotate(f"{row.error:.0e}", at, (6, 0), va="center", size=7, color=colour,
                          textcoords="offset points")
        axis.set_xscale("log")
        low, high = axis.get_xlim()
        axis.set_xlim(low, high * (high / low)**0.25)  # room for the last error
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 3) if high / low < 40 else (1,)))
        axis.xaxis.set_major_formatter(EngFormatter("s"))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_title(title, loc="center")
        axis.set(yticks=range(len(names)), yticklabels=names, ylim=(len(names) - 0.4, -0.6))
    return figure


def strategy_of(row):
    """Batches in all ways, calls in double by one thread"""
    if "batch" not in row.strategy and (row.threads > 1 or row.precision != "f64"):
        return ""
    words = {"single": "one call", "specialised": "specialised kernel"}
    name = words.get(row.strategy, row.strategy.replace("-", " "))
    return PEERS.get(row.method, name) + ", float" * (row.precision == "f32") + (
        f", {row.threads} threads" if row.threads > 1 else "")


def hero(chart):
    """Time of an answer by strategy"""
    panels = collect(chart, strategy_of)
    own = [row for panel in panels.values() for row in panel.values()
           if row.method == "auto" and row.precision == "f64"]
    exact = sum(map(is_exact, own))
    told = "every strategy is" if exact == len(own) else f"{exact} of {len(own)} answers are"
    arm = [1e3 * row.time_us for row in own if row.mechanism == "arm7"]
    return dots(chart, panels, f"In double precision {told} exact to rounding: choose by time, on "
                f"the arm {min(arm):.0f} to {max(arm):.0f} ns", "Forward dynamics")


def lambda_inv(chart):
    """Time of the Lambda^-1 of one link by method"""
    def name_of(row):
        if row.strategy == "specialised":
            return "specialised kernel"
        return PEERS.get(row.method, row.method) if row.strategy == "single" else ""

    panels = collect([r for r in some(chart, op="operational_inertia", threads=1)
                      if r.strategy == "specialised" or r.method != "auto"], name_of)
    first = by_speed(panels)[:3]
    exact = all(is_exact(row) for panel in panels.values() for name, row in panel.items()
                if name in first)
    return dots(chart, panels, f"Λ⁻¹ of a tool: {first[0]}, {first[1]} and {first[2]} lead"
                + ", exact to rounding" * exact, "One call, one thread")


def single(chart):
    """aba in double, single and mixed precision"""
    def name_of(row):
        word = {"f64": "double", "f32": "float", "f32+f64": "mixed"}[row.precision]
        return f"{word}, {row.strategy.replace('single', 'call')}"

    part, lost = cost_of_float(chart, "batch")
    rows = [row for row in chart if row.refine == ("+" in row.precision)]
    return dots(chart, collect(rows, name_of),
                f"Single precision saves {1 - part:.0%} of a batch's time and costs {lost} digits",
                "Forward dynamics by aba (mixed: float, refined once in double)")


def cores(chart):
    """Speed-up by a second thread, and time of an answer over the number of bodies"""
    runs = {strategy: pairs(some(chart, strategy=strategy), "threads", 1, 2)
            for strategy in ("batch", "single")}
    batch, best = (pick(one.time_us / two.time_us for one, two in both)
                   for pick, both in zip((median_low, max), runs.values()))
    figure, axes = picture(
        chart, f"A second core makes batches {batch:.1f} times as fast, single answers "
        + ("no faster" if best < 1.1 else f"of long chains up to {best:.1f} times"),
        "Forward dynamics of chains by the default method; a batch: 512 states, 64 above 128 "
        "bodies; request after request", 2)
    left, right = axes
    left.axhline(1, color="#999999", ls="--", lw=1)
    for both, mark, colour, word in zip(runs.values(), "os", (OWN, OTHER), ("batch", "one state")):
        n, one, two = np.array([(a.bodies, a.time_us, b.time_us) for a, b in both]).T
        left.plot(n, one / two, mark + "-", color=colour, ms=4, label=word)
        right.plot(n, 1e3 * one / n, mark + "-", color=colour, ms=4, label=f"{word}, 1 thread")
        right.plot(n, 1e3 * two / n, mark + "--", color=colour, ms=4, label=f"{word}, 2 threads")
    left.set(title="times as fast with a second thread", ylim=(0, None))
    right.set(title="ns of an answer for each body", yscale="log")
    round_ticks(right.yaxis, *right.get_ylim())
    sizes = unique(row.bodies for row in chart)
    for axis in axes:
        axis.set(xscale="log", xlabel="bodies of the chain")
        ticks(axis.xaxis, sizes[::(len(sizes) + 3) // 4])
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return figure
