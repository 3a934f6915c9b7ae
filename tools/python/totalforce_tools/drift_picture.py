# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The picture of a drift: a panel for each step, a line for each method and precision."""
import numpy as np

from totalforce_tools import command, style

DASHES = {"f32": "--", "f32+f64": "-.", "f64+f128": ":"}
ERROR_MIN, ERROR_MAX = 1e-17, 1e3


def headline(case, given, lines):
    """The best and the worst line of the last step, beside the integrator"""
    floor = next(line for line in reversed(lines) if line.floor)
    others = sorted(lines[lines.index(floor) + 1:], key=lambda line: line.last)

    def told(line):
        if line.status != "ok" or line.last > 1.0:
            return f"{line.name} fails"
        return f"{line.name} {line.last / max(floor.last, ERROR_MIN):.2g} times as far"

    some = dict.fromkeys(told(line) for line in (others[0], others[-1]))
    return (f"{case.name}, {case.bodies} bodies, steps of {floor.step:g} s: the integrator alone "
            f"drifts by {floor.last:.1e}, {', '.join(some)}")


def draw_line(axis, line):
    """A line that ends early ends with a cross."""
    y = np.clip(line.largest, ERROR_MIN, ERROR_MAX)
    if line.floor:
        axis.plot(line.times, y, color="#BBBBBB", linewidth=5, label="integrator alone")
        return
    colour = style.mark(line.method)[1]
    axis.plot(line.times, y, DASHES.get(line.precision, "-"), color=colour, label=line.name)
    if line.status != "ok" and line.times:
        axis.plot(line.times[-1:], y[-1:], "x", color=colour)


def draw(case, given, lines):
    processor, _ = command.machine()
    figure, axes = style.picture(
        headline(case, given, lines), processor, command.today(), given.command,
        columns=len(given.step), size=(max(style.WIDTH, 2.8 * len(given.step)), 4.8), sharey=True,
        notes=[f"Free swinging by {given.integrator}: largest energy error so far; grey: "
               "accelerations in quadruple precision; x: the method has no answer from there on"])
    for axis, step in zip(axes[0], given.step):
        for line in lines:
            if line.step == step:
                draw_line(axis, line)
        axis.set(yscale="log", xlim=(0, given.seconds), title=f"step {step:g} s",
                 xlabel="simulated time (s)")
    axes[0, -1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes[0, 0].set_ylabel("largest energy error so far, relative")
    style.save(figure, given.output, "drift")
