# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""How pictures look: each has a headline that states the conclusion, machine, date, command."""
import io
import os
import textwrap

import matplotlib

matplotlib.use("Agg")
# pylint: disable=wrong-import-position
from matplotlib.figure import Figure

matplotlib.rcParams.update({
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "svg.fonttype": "none",  # text stays text: it is searched, and read aloud
    "svg.hashsalt": "totalforce",  # the same numbers give the same file
})

PIXELS = 96  # of an inch, as browsers count
WIDTH = 830 / PIXELS  # the width of a page of the documentation

# One mark and colour for each method, dark for the first of a family and light for the second, so
# that print in grey keeps them apart. Open: as solved; filled: refined.
METHODS = {
    "auto": ("o", "#0B3C8C"),
    "aba": ("o", "#000000"),
    "crba": ("s", "#000000"),
    "propagation": ("o", "#0072B2"),
    "efpa": ("o", "#66A61E"),
    "pv-osimr": ("o", "#D55E00"),
    "tfa": ("^", "#08306B"),
    "tfa-one-sided": ("^", "#009E73"),
    "tfa-cr": ("^", "#56B4E9"),
    "hessenberg": ("s", "#E69F00"),
    "cfa": ("D", "#8C2D04"),
    "cfa-cr": ("D", "#F4A582"),
    "dca": ("p", "#7B3294"),
    "scan": ("v", "#00441B"),
    "scan-two-pass": ("v", "#66C2A4"),
    "hybrid": ("v", "#A6761D"),
}
PEER = ("X", "#CC3311")
SERIES = ["#0B3C8C", "#D55E00", "#009E73", "#E69F00", "#7B3294", "#56B4E9", "#8C2D04", "#000000"]


def mark(method):
    """Mark and colour of a method, or of a peer"""
    return METHODS.get(method, PEER)


def picture(headline, machine, date, command, rows=1, columns=1, size=(WIDTH, 5.0), notes=(),
            **subplots):
    """A figure and its axes (an array of rows x columns) below the headline; machine, date, command
    and further lines of notes stand at the foot."""
    figure = Figure(figsize=size, layout="constrained")
    wide = int(size[0] * 15)  # characters of a line of the foot
    head = textwrap.wrap(headline, int(size[0] * 9))
    foot = [line for note in notes for line in textwrap.wrap(note, wide)]
    foot += textwrap.wrap(f"{machine}, {date}: {command}", wide)
    above, below = (0.24 * len(head) + 0.08) / size[1], (0.16 * len(foot) + 0.1) / size[1]
    figure.get_layout_engine().set(rect=(0, below, 1, 1 - above - below))
    figure.text(0.01, 1 - 0.06 / size[1], "\n".join(head), size=13, va="top", weight="bold",
                parse_math=False)
    figure.text(0.01, 0.06 / size[1], "\n".join(foot), size=7.5, va="bottom", color="#555555",
                linespacing=1.4, parse_math=False)
    return figure, figure.subplots(rows, columns, squeeze=False, **subplots)


def key(figure, columns):
    """One key for the lines of all axes, above the foot"""
    labels = {label: handle for axis in figure.axes
              for handle, label in zip(*axis.get_legend_handles_labels())}
    layout = figure.get_layout_engine()
    left, below, width, height = layout.get()["rect"]
    room = (0.2 * -(-len(labels) // columns) + 0.1) / figure.get_figheight()
    layout.set(rect=(left, below + room, width, height - room))
    figure.legend(labels.values(), labels, ncols=columns, loc="lower center",
                  bbox_to_anchor=(0.5, below), borderaxespad=0)


def settle(figure):
    """Finds the places of the axes, which takes longer than to draw them, once for all files."""
    if figure.get_layout_engine().colorbar_gridspec is not None:
        figure.draw_without_rendering()
        figure.set_layout_engine("none")


def svg(figure):
    """The picture as text, for a page"""
    settle(figure)
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    return text[text.index("<svg"):]


def save(figure, folder, name, kinds=("svg", "png"), dpi=PIXELS):
    """Writes NAME.svg and NAME.png into the folder."""
    settle(figure)
    for kind in kinds:
        figure.savefig(os.path.join(folder, f"{name}.{kind}"), dpi=dpi,
                       metadata={"Date": None, "Creator": None} if kind == "svg" else None)
