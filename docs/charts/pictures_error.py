# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Pictures of errors: over the number of bodies, the cause of failures, time."""
import math
import textwrap

from frame import decades, picture, ticks
from rows import some, unique
from totalforce_tools import style
from totalforce_tools.atlas import MAPS
from totalforce_tools.atlas_words import short
from totalforce_tools.drift import Line
from totalforce_tools.drift_picture import draw_line


def draw_methods(axis, rows, methods, x):
    """Error over the field x, and the floor of aba"""
    for method in methods:
        found = some(rows, method=method)
        if found:
            shape, colour = style.mark(method)
            axis.plot([getattr(r, x) for r in found], [r.error for r in found], shape + "-",
                      color=colour, ms=4, mfc="none", label=method)
    aba = some(rows, method="aba")
    axis.plot([getattr(r, x) for r in aba], [r.floor for r in aba], "--", color="#888888", zorder=3,
              label="floor of the data")
    axis.set(xscale="log")


CHAINS = {"random": "random", "thin": "thin: radius 0.1 mm",
          "taper": "taper: tip 0.01 of the root"}


def bodies(chart):
    """A line for each method, three mechanisms"""
    rows = [r for r in some(chart, rhs="qdd", refine=0, status="ok") if r.mechanism in CHAINS]
    best = max(r.error / r.floor for r in rows if r.method in ("aba", "scan"))
    lost = max(math.log10(min(r.error, 1) / r.floor) for r in some(rows, method="tfa"))
    figure, axes = picture(
        chart, f"aba and scan stay {'at' if best < 3 else f'within {math.ceil(best)} times'} the "
        f"floor of the data; methods that invert body inertias lose up to {lost:.0f} digits",
        "Relative error of forward dynamics against the number of bodies of a chain, unrefined",
        3, 4.6, sharex=True, sharey=True)
    for axis, mechanism in zip(axes, CHAINS):
        draw_methods(axis, some(rows, mechanism=mechanism), (
            "tfa", "hessenberg", "dca", "crba", "mujoco", "scan", "aba"), "bodies")
        axis.set(title=CHAINS[mechanism], xlabel="bodies")
        ticks(axis.xaxis, unique(r.bodies for r in rows))
        decades(axis.yaxis, 1e-16, 1e5)
    style.key(figure, 4)
    return figure


ALONE = ("tfa", "cfa", "dca", "hessenberg", "crba", "aba")


def atlas_headline(plain, service):
    """A method loses digits where the data has some."""
    wrong = {r.method for r in plain if r.error >= 1 > 1e4 * r.floor}
    return (f"Ill-conditioned chains: {', '.join(m for m in ALONE if m in wrong) or 'no method'} "
            "lose every digit, a default request errs by at most "
            f"{max(r.error for r in service):.0e} or is refused")


def atlas(chart, size):
    """Error of methods alone, of the default request, and the floor: five maps, one size"""
    rows = [r for r in some(chart, bodies=size) if r.map != "curl" and r.error != ""]
    plain, service = some(rows, mode="plain"), some(rows, mode="service")
    figure, axes = picture(
        chart, atlas_headline(plain, service), "Relative error of forward dynamics against "
        f"quadruple precision, chains of {size} bodies; methods alone, unrefined, and the default "
        "request", 5, 4.6, sharey=True)
    for axis, name in zip(axes, unique(r.map for r in rows)):
        mine = some(plain, map=name)
        draw_methods(axis, mine, ALONE, "value")
        worst = {}
        for r in some(service, map=name):
            worst[r.value] = max(worst.get(r.value, 0), r.error)
        axis.plot(worst.keys(), worst.values(), color=style.PEER[1], lw=3.5,
                  label="default request, worst method")
        values = unique(r.value for r in mine)
        axis.set(xlabel=textwrap.fill(MAPS[name].axis, 18))
        ticks(axis.xaxis, [values[k * (len(values) - 1) // 3] for k in range(3)], short)
        decades(axis.yaxis, 1e-16, 1e4)
        if values[0] > values[-1]:
            axis.invert_xaxis()
    style.key(figure, 4)
    return figure


def lines_of(rows):
    """As `totalforce drift` has them"""
    lines = {}
    for row in rows:
        key = row.step_s, row.floor, row.method, row.precision
        line = lines.setdefault(key, Line(row.method, row.precision, row.refine, row.step_s,
                                          row.floor))
        line.status = row.status
        if row.status == "ok":
            line.times.append(row.time_s)
            line.errors.append(row.energy_error)
    return list(lines.values())


def drift_headline(arm, thin):
    """Of the last step of the arm, and of the methods that invert body inertias"""
    def far(lines, *methods):
        floor = [line.last for line in lines if line.floor][-1]
        return min([x.last for x in lines if x.precision == "f64" and x.method == m][-1] / floor
                   for m in methods)

    own = far(arm, "aba")
    return (f"Energy tells digits apart: aba in double at {1e3 * arm[-1].step:g} ms drifts "
            + ("as the integrator does" if own < 3 else f"{own:.0f} times as far as the integrator")
            + ", tfa, cfa and dca on thin rods at least "
            f"{short(far(thin, 'tfa', 'cfa', 'dca'))} times as far")


def drift(arm, thin):
    """Energy error of robots that swing freely"""
    lines = lines_of(arm), lines_of(thin)
    panels = [(f"7-joint arm, step {1e3 * step:g} ms", [x for x in lines[0] if x.step == step])
              for step in unique(line.step for line in lines[0])]
    panels.append((f"8 thin rods, step {1e3 * lines[1][0].step:g} ms", lines[1]))
    figure, axes = picture(
        arm, drift_headline(*lines), "Free swinging by an integrator of order 8: largest energy "
        "error so far, relative; grey: accelerations in quadruple precision; x: no answer from "
        "there on", len(panels), 4.8, sharey=True)
    for axis, (title, some_lines) in zip(axes, panels):
        for line in some_lines:
            draw_line(axis, line)
        axis.set(title=title, xlabel="simulated time (s)", xlim=(0, None))
        axis.locator_params(axis="x", nbins=5)
        axis.xaxis.set_major_formatter("{x:g}")
        decades(axis.yaxis, 1e-17, 1e4)
    style.key(figure, 5)
    return figure
