# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Pictures of a chart: a scatter of each case, and an overview of all."""
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from totalforce_tools import chart_rows, command, style

ERROR_MIN, ERROR_MAX = 1e-17, 1e2  # what is beyond is drawn there
NEAR, FAR, LEAST_FLOOR = 10.0, 100.0, 1e-15  # exact, far: so many floors, of at least that
SENTENCES = {"qdd": "qdd: torques of a random qdd", "tau": "tau: random torques",
             "gravity": "gravity: at rest, no torques", "": "Λ⁻¹ of one link"}
LEGEND = ("Left is fast, low is exact. A mark is the median over the seeds, its bars reach from "
          "the least to the largest of them. What is off the grey front is slower or less exact "
          "than a mark on it. Below the dashed line rounded inputs matter more than the method.")


def how(row, file=False):
    """Op, threads and strategy where they are not the usual ones: ", 2 threads, batch" """
    comma, blank = ("-", "-") if file else (", ", " ")
    words = [("lambda" if file else "Λ⁻¹")] if row.op != "forward_dynamics" else []
    words += [f"{row.threads}{blank}threads"] if row.threads > 1 else []
    words += [row.strategy] if row.strategy != "single" else []
    return "".join(comma + word for word in words)


def name_of(row, options, full=False):
    """ "tfa+1", with the precision where there are several; `full`: with threads and strategy """
    name = row.method + (f"+{row.refine}" if row.refine else "")
    if full:
        plain = chart_rows.replace(row, op="forward_dynamics")  # the panel names the op
        return name + (f" {row.precision}" if row.precision != "f64" else "") + how(plain)
    return name + (f" {row.precision}" if len(options.precision) > 1 else "")


def microseconds(us):
    unit, scale = ("µs", 1.0) if us < 1e3 else ("ms", 1e-3) if us < 1e6 else ("s", 1e-6)
    return f"{us * scale:.3g} {unit}"


def is_exact(row):
    return row.error <= NEAR * max(row.floor, LEAST_FLOOR)


def fastest(rows, fits):
    good = (row for row in rows if row.drawn and fits(row))
    return min(good, key=lambda row: row.time_us, default=None)


def grouped_by(rows, *names):
    """Lists of rows that agree in these fields, in the order of their first rows"""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(getattr(row, name) for name in names), []).append(row)
    return list(groups.values())


def panels_of(rows):
    return grouped_by(rows, "mechanism", "bodies", "op", "rhs")


def conclusion(rows, options):
    """The answer that is most often the fastest of those that are exact to rounding, counted over
    the panels of the first op and its first right-hand side"""
    panels = [panel for panel in panels_of(rows)
              if panel[0].op == rows[0].op and panel[0].rhs == rows[0].rhs]
    wins = {}
    for best in filter(None, (fastest(panel, is_exact) for panel in panels)):
        wins.setdefault(name_of(best, options, full=True), []).append(best.time_us)
    if not wins:
        return "No answer is exact to rounding here"
    winner, times = max(wins.items(), key=lambda entry: len(entry[1]))
    low, high = microseconds(min(times)), microseconds(max(times))
    if len(panels) == 1:
        return f"{rows[0].mechanism}: exact to rounding in {low} by {winner}"
    return (f"{winner}: fastest answer exact to rounding on {len(times)} of {len(panels)} charts, "
            f"{low} to {high} a state")


def clip(error):
    return min(max(error, ERROR_MIN), ERROR_MAX)


def time_name(row):
    what = "state in a batch" if chart_rows.is_batch(row.strategy) else "call"
    return f"{'wall' if row.threads > 1 else 'CPU'} time of a {what} (µs)"


def set_axes(panel, times, **errors):
    """Logarithmic axes; tics at parts of a decade where there are few decades of time"""
    panel.set(xscale="log", yscale="log", **errors)
    panel.yaxis.set_minor_locator(NullLocator())
    panel.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"1e{round(np.log10(y))}"))
    axis = panel.xaxis
    low, high = (min(times) / 1.5, max(times) * 1.5) if times else (1.0, 10.0)
    ratio = high / low
    panel.set_xlim(low, high)
    axis.set_minor_locator(NullLocator())
    if ratio <= 1000.0:
        steps = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8) if ratio <= 4 else \
            (1, 1.5, 2, 3, 5, 7) if ratio <= 12 else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=steps, numticks=20))
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))


def legend(axes, methods):
    """The key, in axes of its own"""
    marks = [Line2D([], [], ls="", marker=shape, color=colour, mfc="none", label=method)
             for method in methods for shape, colour in [style.mark(method)]]
    marks.append(Line2D([], [], ls="", marker="o", color="black", label="filled: refined"))
    marks.append(Line2D([], [], color="#bbbbbb", lw=4, label="Pareto front"))
    marks.append(Line2D([], [], color="#888888", ls="--", lw=1, label="floor of the data"))
    axes.axis("off")
    key = axes.legend(handles=marks, loc="upper left", borderaxespad=0, handlelength=1.3)
    key.set_in_layout(False)  # it may be higher than a line of panels


def draw_mark(axes, row, gid=None, size=5):
    shape, colour = style.mark(row.method)
    face = colour if row.refine else "none"
    axes.plot(row.time_us, clip(row.error), shape, color=colour, ms=size, mfc=face, gid=gid)


def draw_bars(axes, rows):
    """From the least to the largest over the seeds"""
    colours = [style.mark(row.method)[1] for row in rows]
    low, high = ([clip(getattr(r, f"error_{end}")) for r in rows] for end in ("low", "high"))
    axes.vlines([r.time_us for r in rows], low, high, colours, lw=0.7)
    axes.hlines([clip(r.error) for r in rows], [r.time_low_us for r in rows],
                [r.time_high_us for r in rows], colours, lw=0.7)


def draw_floor(axes, rows):
    if rows:
        axes.axhline(max(rows[0].floor, ERROR_MIN), color="#888888", ls="--", lw=1)


def front_of(rows):
    return sorted((row for row in rows if row.front), key=lambda row: row.time_us)


def draw_front(axes, front):
    times, errors = [row.time_us for row in front], [clip(row.error) for row in front]
    axes.step(times, errors, where="post", color="#bbbbbb", lw=4, zorder=0.5)
    axes.plot(times, errors, "o", color="#dddddd", ms=12, zorder=0.6)


def grouped(words):
    """{reason: names} as a sentence"""
    return "; ".join(f"{why}: {', '.join(dict.fromkeys(names))}" for why, names in words.items())


def silent_note(rows, options):
    """Methods without an answer, and with another method's answer, by reason"""
    silent = {}
    for row in rows:
        if not row.good:
            name = row.precision if row.about == "precision" else name_of(row, options)
            silent.setdefault(row.silence, []).append(name)
    return "not shown: " + (grouped(silent) or "none")


def same_note(rows, options):
    """ "tfa-cr = cfa-cr" for each mark that stands for several methods """
    pairs = [f"{name_of(chart_rows.replace(row, method=row.same_as), options)} = "
             f"{name_of(row, options)}" for row in rows if row.same_as]
    text = "One mark, the same answers to the last bit: " + "; ".join(dict.fromkeys(pairs))
    return [text] * bool(pairs)


def scatter(options, rows):
    """The picture of one case: a column for each right-hand side, a line for each precision.
    @return figure, name of its file, titles of its marks by gid"""
    sides = list(dict.fromkeys(row.rhs for row in rows))
    lines = options.precision
    drawn = [row for row in rows if row.drawn]
    fronts = {side: front_of(row for row in rows if row.rhs == side) for side in sides}
    notes = [f"front, {side or 'Lambda^-1'}: " + ", ".join(name_of(row, options) for row in front)
             for side, front in fronts.items()]
    subject = f"{rows[0].mechanism}, {rows[0].bodies} bodies{how(rows[0])}"
    found = conclusion(rows, options).removeprefix(f"{rows[0].mechanism}: ")
    figure, axes = style.picture(
        f"{subject}: {found}", command.machine()[0], command.today(),
        options.command, len(lines), len(sides) + 1,
        (2.9 * len(sides) + 2.7, 3.3 * len(lines) + 2.2),
        [*notes, LEGEND, *same_note(rows, options), silent_note(rows, options)],
        gridspec_kw={"width_ratios": [3] * len(sides) + [1.6]})
    titles = {}
    for line, column in np.ndindex(len(lines), len(sides)):
        some = [row for row in drawn if row.rhs == sides[column]]
        panel = axes[line, column]
        set_axes(panel, [t for row in some for t in (row.time_low_us, row.time_high_us)],
                 ylim=error_range(drawn))
        draw_floor(panel, some)
        draw_front(panel, fronts[sides[column]])
        some = [row for row in some if row.precision == lines[line]]
        draw_bars(panel, some)
        for row in some:
            gid = f"mark-{len(titles)}"
            titles[gid] = title_of(row, options)
            draw_mark(panel, row, gid)
        precision = f", {lines[line]}" if len(lines) > 1 else ""
        panel.set_title(SENTENCES[sides[column]] + precision)
        panel.set_xlabel(time_name(rows[0]) if line == len(lines) - 1 else "")
    for line in range(len(lines)):
        norm = "qdd, 2-norm" if rows[0].op == "forward_dynamics" else "Λ⁻¹, Frobenius norm"
        axes[line, 0].set_ylabel(f"relative error of {norm}")
        axes[line, -1].axis("off")
    legend(axes[0, -1], options.methods)
    name = f"{rows[0].mechanism}-{rows[0].bodies}{how(rows[0], file=True)}".replace(":", "-")
    return figure, name, titles


def error_range(rows):
    """Whole decades around errors and floors"""
    low = min((min(clip(r.error_low), max(r.floor, ERROR_MIN)) for r in rows), default=1e-16)
    high = max((max(clip(r.error_high), max(r.floor, ERROR_MIN)) for r in rows), default=1.0)
    return 10.0 ** np.floor(np.log10(low) - 0.2), 10.0 ** np.ceil(np.log10(high) + 0.2)


def title_of(row, options):
    """The numbers of a mark, as in the file"""
    numbers = [f"{name} {chart_rows.cell(row, name)}" for name in (
        "error", "error_low", "error_high", "worst_component", "floor", "estimate", "time_us",
        "time_low_us", "time_high_us", "time_ratio", "samples") if chart_rows.cell(row, name) != ""]
    return "\n".join([name_of(row, options, full=True), *numbers])


def tally(rows, method, refine):
    """Panels, and in how many the method is on the front, far above the floor, silent"""
    some = [row for row in rows if (row.method, row.refine) == (method, refine)]
    good = [row for row in some if row.good]
    far = sum(row.error > FAR * max(row.floor, LEAST_FLOOR) for row in good)
    return len(some), sum(row.front for row in good), far, len(some) - len(good)


def sentences(options, rows):
    """Summary of the rows, counted and not asserted"""
    notes = [f"Counted over all {len(panels_of(rows))} panels, all right-hand sides. Far: error "
             f"more than {FAR:g} times the floor (or 1e-15). Silent: refused, skipped, or fell "
             "back to another method."]
    for refine in options.refine:
        counts = {m: tally(rows, m, refine) for m in options.methods}
        near = [m for m, (panels, _, far, silent) in counts.items() if panels and not far + silent]
        front = [m for m, count in counts.items() if count[1]]
        notes.append(f"With {refine} refinement steps, never far and never silent: "
                     f"{', '.join(near) or 'none'}. On the front somewhere: "
                     f"{', '.join(front) or 'none'}.")
    return notes


def overview(options, rows):
    """All cases at a glance, for one right-hand side. @return figure, name of its file"""
    names = list(dict.fromkeys(row.mechanism for row in rows))
    robots = all(target[1] for target in options.targets)  # they have the sizes they have
    sizes = [None] if robots else list(dict.fromkeys(row.bodies for row in rows))
    side = rows[0].rhs
    what = ("Λ⁻¹, Frobenius norm" if rows[0].op != "forward_dynamics" else
            f"{SENTENCES[side]}; error of qdd, 2-norm")
    figure, axes = style.picture(
        f"{conclusion(rows, options)}{how(rows[0])}", command.machine()[0], command.today(),
        options.command, len(names), len(sizes) + 1,
        (max(style.WIDTH, 2.3 * len(sizes) + 2.6), 1.5 * len(names) + 2.6),
        [f"{what}; up: relative error, right: {time_name(rows[0])}. Open: as solved, filled: "
         "refined; bars: from the least to the largest over the seeds.", *sentences(options, rows)],
        sharey=True, gridspec_kw={"width_ratios": [3] * len(sizes) + [2]})
    for line, column in np.ndindex(len(names), len(sizes)):
        panel = axes[line, column]
        column_rows = [row for row in rows if row.drawn and row.rhs == side
                       and sizes[column] in (None, row.bodies)]
        some = [row for row in column_rows if row.mechanism == names[line]]
        set_axes(panel, [row.time_us for row in column_rows], ylim=(1e-17, 1e2))
        draw_floor(panel, some)
        draw_bars(panel, some)
        for row in some:
            draw_mark(panel, row, size=4)
        panel.set_title(names[line] + (f", {sizes[column]} bodies" if not robots else ""))
    for axis in axes[:, -1]:
        axis.axis("off")
    legend(axes[0, -1], options.methods)
    return figure, "overview" + how(rows[0], file=True)


def cases_of(rows):
    return grouped_by(rows, "mechanism", "bodies", "op", "threads", "strategy")


def draw(options, rows, scatters):
    """All pictures, into the folder"""
    for figure, name, _ in scatters:
        style.save(figure, options.output, name)
    first = [row for row in rows if row.precision == options.precision[0]]
    for some in grouped_by(first, "op", "threads", "strategy"):
        figure, name = overview(options, some)
        style.save(figure, options.output, name)
