# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Pictures of a session of `totalforce latency`. Each is a headline and a figure, with the texts of
its marks by their gid."""
import numpy as np
from matplotlib.ticker import FuncFormatter, NullLocator

from totalforce_tools import style
from totalforce_tools.plot_sessions import PARTS, duration, headline

STEPS = 10  # points of a decade of 1 / (1 - percentile)
BINS = 60
SHOWN = 0.999  # slower ones would leave the others no room
COLOURS = dict(zip(PARTS[1:], ("#D55E00", "#56B4E9", "#E69F00", "#009E73", "#7B3294")))


def largest_part(parts):
    name = max(PARTS[1:], key=parts.get)
    return f"{100 * parts[name] / max(parts['round_trip'], 1):.0f} % {name}"


def headline_of_run(run):
    parts = run.facts["breakdown_ns"]
    typical = f"a median round trip is {largest_part(parts['50'])}, " if "50" in parts else ""
    return f"{run.name}: {typical}the slowest {largest_part(parts['max'])}"


class Marks:
    """Artists that have a text under the pointer"""

    def __init__(self):
        self.titles = {}

    def add(self, artist, text):
        gid = f"mark{len(self.titles)}"
        artist.set(gid=gid, in_layout=False)  # the layout need not look at hundreds of marks
        self.titles[gid] = text

    def line(self, axis, points, label, colour):
        """A curve through (x, y, text)"""
        x, y, texts = zip(*points)
        axis.plot(x, y, color=colour, label=label)
        for artist, text in zip(axis.plot([x], [y], "o", color=colour, markersize=2.5), texts):
            self.add(artist, text)


def labels(axis, text):
    axis.set_major_formatter(FuncFormatter(lambda value, _: text(value)))
    axis.set_minor_locator(NullLocator())


def curve(h, name):
    """Percentiles up to the one that a single round trip exceeds, then that"""
    for step in range(int(STEPS * np.log10(h.count)) + 1):
        at = 10 ** (step / STEPS)
        share = 1 - 1 / at
        ns = h.quantile(share)
        yield at, ns, f"{name}: {100 * share:.6g} % within {ns / 1e3:.4g} µs"
    yield h.count, h.highest, f"{name}: all {h.count} within {h.highest / 1e3:.4g} µs"


def percentiles(session, picture):
    marks = Marks()
    figure, axes = picture(headline(session))
    axis = axes[0, 0]
    for run, colour in zip(session.runs, style.SERIES * len(session.runs)):
        if run.trip.count:
            marks.line(axis, [*curve(run.trip, run.name)], run.name, colour)
    if session.pingpong.count:
        marks.line(axis, [*curve(session.pingpong, "ping-pong")], "ping-pong", "#888888")
    axis.set(xscale="log", yscale="log", ylabel="round trip",
             xlabel="share of round trips that were faster")
    labels(axis.xaxis, lambda at: f"{100 * (1 - 1 / at):.6g} %")
    labels(axis.yaxis, duration)
    axis.legend()
    return figure, marks.titles


def histogram(axis, run, marks):
    h = run.trip
    high = h.quantile(SHOWN) + 1
    low = max(h.lowest, 1)
    count = min(BINS, max(1, int(np.ceil(np.log(high / low) / np.log(1.02)))))  # buckets have 0.8 %
    edges = np.geomspace(low, high, count + 1)
    bars = np.histogram(h.tops, edges, weights=h.counts)[0].astype(int)
    full = np.flatnonzero(bars)
    patches = axis.bar(edges[full], bars[full], np.diff(edges)[full], align="edge",
                       color=style.SERIES[0])
    for patch, k in zip(patches, full):
        marks.add(patch, f"{edges[k] / 1e3:.4g} to {edges[k + 1] / 1e3:.4g} µs: {bars[k]} round "
                         "trips")
    axis.set(xscale="log", xlabel="round trip", ylabel="round trips",
             title=f"Durations; {h.count - bars.sum()} slower ones, up to {duration(h.highest)}")
    axis.grid(axis="x", visible=False)
    labels(axis.xaxis, duration)


def breakdown(axis, run, marks):
    """Parts of one percentile as shares of their sum, from zero"""
    rows = {("slowest" if name == "max" else f"p{name}"): parts
            for name, parts in run.facts["breakdown_ns"].items()}
    for at, (name, parts) in enumerate(rows.items()):
        left = 0.0
        for part in PARTS[1:]:
            share = parts[part] / max(parts["round_trip"], 1)
            if share > 0:
                artist = axis.barh(at, share, left=left, height=0.65, color=COLOURS[part])[0]
                marks.add(artist, f"{name}: {part} {parts[part] / 1e3:.4g} of "
                                  f"{parts['round_trip'] / 1e3:.4g} µs, of {parts['count']}")
                left += share
        axis.text(1.02, at, duration(parts["round_trip"]), va="center")
    axis.set(yticks=range(len(rows)), yticklabels=rows, xlim=(0, 1), xlabel="share of a round trip",
             title="Parts at the percentiles")
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    handles = [axis.barh(0, 0, color=COLOURS[part]) for part in PARTS[1:]]
    axis.legend(handles, PARTS[1:], ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.2),
                columnspacing=1, handlelength=1)


def tenths(axis, run, marks):
    tenth = run.facts["seconds"] / len(run.slices)
    for label, share, colour in (("p50", 0.5, 0), ("p99", 0.99, 3), ("slowest", 1.0, 1)):
        points = [(tenth * (k + 0.5), h.quantile(share),
                   f"{label} of {h.count}: {h.quantile(share) / 1e3:.4g} µs")
                  for k, h in enumerate(run.slices) if h.count]
        marks.line(axis, points, label, style.SERIES[colour])
    axis.set(yscale="log", title="Tenths of the run", xlabel="seconds after the start")
    labels(axis.yaxis, duration)
    axis.legend()


def details(run, picture):
    """Parts, histogram and tenths of one run"""
    marks = Marks()
    figure, axes = picture(headline_of_run(run), columns=3, size=(style.WIDTH * 1.3, 4.0))
    for axis, draw in zip(axes[0], (breakdown, histogram, tenths)):
        draw(axis, run, marks)
    return figure, marks.titles
