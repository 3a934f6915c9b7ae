# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The page of a chart: pictures whose marks show numbers, which answer to use, all numbers."""
from totalforce_tools import chart_pictures, chart_rows, command, page
from totalforce_tools.cases import NO_DIGIT
from totalforce_tools.chart_pictures import fastest, is_exact, microseconds, name_of, panels_of

NUMBERS = ("error", "error_high", "floor", "time_us", "time_high_us")


def lead(options):
    words = {"forward_dynamics": "Forward dynamics", "operational_inertia": "Λ⁻¹ of a link"}
    subject = ", ".join(words[op] for op in options.op)
    return (f"{subject}: relative error against quadruple precision, and time of one state; left "
            "is fast, low is exact. Grey: no other answer is both faster and as exact. Filled: "
            f"refined. Bars: seeds ({options.seeds}). Dashed: floor of the data. Times are CPU "
            "times, with several threads wall times. The numbers of a mark show under the pointer.")


def choice(row, options):
    if not row:
        return "none"
    name = name_of(row, options, full=True)
    return f"{name} in {microseconds(row.time_us)}, error {row.error:.1e}"


def failures(rows):
    """Methods without an answer of their own, or without a correct digit"""
    silent = {row.method: "no digit" if row.good else row.word for row in reversed(rows)
              if row.refine == 0 and not (row.good and row.error < NO_DIGIT)}
    return ", ".join(f"{name} ({why})" for name, why in reversed(silent.items())) or "none"


def choices(options, rows):
    """Which answer to use, for each panel"""
    def one_call(row):
        return is_exact(row) and row.threads == 1 and not chart_rows.is_batch(row.strategy)

    head = ("robot", "exact, one call", "exact, least time", "least time of all", "fails alone")
    lines = []
    for panel in panels_of(rows):
        name, bodies, rhs = panel[0].mechanism, panel[0].bodies, panel[0].rhs
        best = [choice(fastest(panel, fits), options)
                for fits in (one_call, is_exact, lambda row: row.error < NO_DIGIT)]
        robot = f"{name}, {bodies} {'body' if bodies == 1 else 'bodies'}, {rhs or 'Λ⁻¹'}"
        lines.append((robot, *best, failures(panel)))
    return page.table(head, lines)


def numbers(options, rows):
    head = ("robot", "bodies", "rhs", "answer", "error", "worst seed", "floor", "time (µs)",
            "slowest seed", "status")
    return page.table(head, [
        (row.mechanism, row.bodies, row.rhs, name_of(row, options, full=True),
         *(chart_rows.cell(row, name) for name in NUMBERS),
         f"{row.word} {row.about if row.status else ''}".strip()) for row in rows])


def write(out, options, rows, scatters):
    parts = [page.text(lead(options))]
    for figure, name, titles in scatters:
        about = f"Error against time: {name}; the numbers are in the table below"
        parts.append(page.figure(figure, titles, about))
    parts += [page.heading("Which answer to use"),
              page.text("Exact: error at most ten times the floor of the data."),
              choices(options, rows), page.folded("Table of the numbers", numbers(options, rows))]
    page.write(out, chart_pictures.conclusion(rows, options), command.machine()[0], command.today(),
               options.command, parts)
