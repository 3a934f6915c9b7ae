# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What the pictures of the documentation have in common."""
from matplotlib.ticker import NullLocator

from totalforce_tools import style
from totalforce_tools.atlas_words import short

COMMAND = "docs/charts/make.py build/peers"
OWN, OTHER = style.SERIES[:2]


def picture(chart, headline, note, columns=1, height=4.3, **subplots):
    """Figure and axes in a line; processor and date of the file of rows"""
    figure, axes = style.picture(headline, chart.fact("processor"), chart.fact("date"), COMMAND, 1,
                                 columns, (style.WIDTH, height), [note], **subplots)
    return figure, axes[0]


def ticks(axis, values, text="{:g}".format):
    """Of a logarithmic axis"""
    axis.set_ticks(values, map(text, values))
    axis.set_minor_locator(NullLocator())


def round_ticks(axis, low, high):
    ticks(axis, [x for k in range(6) for x in (10**k, 2 * 10**k, 5 * 10**k) if low < x < high])


def decades(axis, low, high):
    """A logarithmic axis of errors"""
    axis.axes.set(yscale="log", ylim=(low, high))
    ticks(axis, [10.0**k for k in range(-15, 6, 5) if low <= 10.0**k <= high], short)
