# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce plot`: pictures, page and comparison of what `totalforce latency --save` wrote."""
import os

from totalforce_tools import command
from totalforce_tools.plot_sessions import PARTS, QUANTILES, Session, compare, headline

COMMAND = command.Command(
    "plot",
    "Draws a session that `totalforce latency --save` wrote, or prints the ratios of the "
    "percentiles of two, with their range over the tenths of both.",
    [command.Option("html", None, "FILE", "Write a self-contained page: percentiles, histogram, "
                    "parts, numbers under the pointer, tables"),
     command.Option("output", "o", "FOLDER", "Write the pictures there, as SVG and PNG")],
    after="Page and pictures show the last SESSION. Without them a single one is told in a line.",
    arguments="SESSION [SESSION]")

COUNTERS = {"sent": "sent", "misses": "misses", "late": "late", "lost": "lost",
            "rejected": "rejected", "longest run": "longest_run", "no room": "full",
            "twice": "duplicates", "reordered": "reordered", "given up": "stale",
            "reconnects": "reconnects", "daemon, processors": "daemon_cpu",
            "tool, processors": "tool_cpu"}
THREADS = {"process": "process", "name": "name", "policy": "policy", "priority": "priority",
           "voluntary": "voluntary_switches", "involuntary": "involuntary_switches",
           "minor faults": "minor_faults", "major faults": "major_faults",
           "allocations": "allocations"}
BASELINE = {"ping-pong": "pingpong", "ping-pong of the same size": "same_size",
            "solve in process": "solve", "timer wake-up": "timer",
            "gaps of a spinning thread": "gaps"}


def read(path):
    try:
        return Session(path)
    except (KeyError, TypeError, AttributeError, ArithmeticError, ValueError) as error:
        raise command.Failed(f"{path}: no session: {error}") from None


def times(page, rows):
    """A table of pairs: name, and times as the report has them"""
    def cells(h):
        shares = [h["percentiles"].get(name) for name in QUANTILES]
        return ["-" if ns is None else f"{ns / 1e3:.3f}"
                for ns in (h["min"], *shares, h["max"], h["mean"])] + [h["count"]]

    return page.table(["µs", "min", *(f"p{name}" for name in QUANTILES), "max", "mean", "of"],
                      [[name, *cells(h)] for name, h in rows if h])


def tables(page, session):
    runs = [(run.name, run.facts) for run in session.runs]
    yield page.heading("Percentiles")
    yield times(page, [(f"{name} {part}", facts["ns"][part]) for name, facts in runs
                       for part in PARTS if part != "client" or facts["loop"] == "open"])
    yield page.heading("The machine, without the daemon")
    yield times(page, [(name, session.facts["baseline_ns"][key]) for name, key in BASELINE.items()])
    yield page.text(session.busy["reason"] or "The machine was quiet.")
    yield page.heading("Requests")
    yield page.table(["run", *COUNTERS], [[name, *(facts[key] for key in COUNTERS.values())]
                                          for name, facts in runs])
    yield page.heading("Clients")
    yield times(page, [(f"{name}, client {k}", client["round_trip_ns"]) for name, facts in runs
                       for k, client in enumerate(facts["per_client"])])
    yield page.heading("Threads while measuring: context switches, page faults, allocations")
    yield page.table(["run", *THREADS], [[name, *(thread[key] for key in THREADS.values())]
                                         for name, facts in runs for thread in facts["threads"]])
    yield page.heading("Environment")
    yield page.table(["fact", "value"], [[key, "not told" if value is None else value]
                                         for key, value in session.environment.items()])


def draw(session, given):
    """matplotlib is loaded only for this."""
    from totalforce_tools import page, plot_pictures, style

    machine = session.environment.get("processor") or "unknown"
    origin = (machine, session.facts["date"][:10], session.facts["command"])
    picture = lambda headline, **more: style.picture(headline, *origin, **more)
    drawn = {"latency": plot_pictures.percentiles(session, picture)}
    for run in session.runs:
        if run.trip.count:
            drawn[f"latency-{run.name.replace(' ', '-')}"] = plot_pictures.details(run, picture)
    if given.output:
        os.makedirs(given.output, exist_ok=True)
        for name, (figure, _) in drawn.items():
            style.save(figure, given.output, name)
    if given.html:
        with open(given.html, "w", encoding="utf-8") as out:
            facts = session.runs[0].facts
            lead = (f"Forward dynamics of {facts['v_count']} freedoms by {facts['method'] or '-'}, "
                    f"batch {facts['batch']}, {facts['load']}. Ping-pong: the same exchange "
                    "between two processes without a solve. Parts: means of the round trips "
                    "within 3 % of a percentile.")
            pictures = [page.figure(figure, titles) for figure, titles in drawn.values()]
            page.write(out, headline(session), *origin,
                       [page.text(lead), *pictures, *tables(page, session)])


def main(argv):
    given = COMMAND.parse(argv, most=2)
    if not given.arguments:
        raise command.Usage("which session?")
    sessions = [read(path) for path in given.arguments]
    if len(sessions) == 2:
        print("\n".join(compare(*sessions)), flush=True)
    if given.html or given.output:
        draw(sessions[-1], given)
    elif len(sessions) == 1:
        print(headline(sessions[0]))
    return command.GOOD
