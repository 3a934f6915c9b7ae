# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce sweep`: one operation of one robot for many states. Blocks of states are the unit of
work, of the resume file and of what threads, ranks and parts share; _totalforce._Sweep computes
one.

Statistics are printed on standard output, the same for any split; rate and missing blocks on
standard error.
"""
import sys

import numpy as np

import totalforce_tools.sweep_statistics as statistics
from totalforce_tools import sweep_ranks, sweep_run
from totalforce_tools.command import FAILED, GOOD, UNMET, USAGE, Usage, explain
from totalforce_tools.sweep_options import parse
from totalforce_tools.sweep_plan import Plan
from totalforce_tools.sweep_ranks import tell

TIMES = ("states", "dynamics", "statistics", "reference", "output")


def run_json(r, ranks):
    total = float(r.seconds.sum())
    shares = {name: float(s) / total for name, s in zip(TIMES, r.seconds) if total > 0}
    return {"ranks": ranks, "threads": r.threads, "computed": r.states, "blocks_found": r.found,
            "seconds": r.elapsed,
            "states_per_second": r.states / r.elapsed if r.elapsed > 0 else 0.0, "shares": shares}


def print_result(plan, r, ranks):
    if plan.o.json:
        print(statistics.dump({"sweep": plan.identity,
                               "statistics": statistics.as_json(r.statistics),
                               "run": run_json(r, ranks)}))
    else:
        print(f"# {plan.identity}")
        statistics.print_table(r.statistics)
    sys.stdout.flush()


def print_rate(r, ranks):
    total = float(r.seconds.sum())
    if r.states == 0 or total <= 0:
        return
    shares = ", ".join(f"{name} {100 * s / total:.1f} %" for name, s in zip(TIMES, r.seconds)
                       if s >= 0.001 * total)
    tell(f"{r.states} states in {r.elapsed:.3g} s: {r.states / r.elapsed:.3g} states/s, "
         f"{r.threads} thread{'s' * (r.threads != 1)}, {ranks} rank{'s' * (ranks != 1)}; {shares}")


def ranges_of(numbers, most):
    """At most `most` ranges of ascending numbers: "0..3, 7\""""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    texts = [f"{run[0]}" + f"..{run[-1]}" * (len(run) > 1) for run in runs[:most]]
    return ", ".join(texts + ["..."] * (len(runs) > most))


def print_missing(plan, r):
    again = (f"): run again with --resume {plan.o.resume}" if plan.o.resume is not None else
             "), and nothing was kept: run again with --resume FILE")
    tell(f"{'interrupted: ' if r.interrupted else ''}{r.missing()} of {plan.blocks} blocks are "
         f"missing ({ranges_of(np.flatnonzero(~r.done), 8)}{again}")


def meets_expectation(o, s):
    """--expect-error against the true errors, where there are some, else against the estimates"""
    if o.expect_error is None:
        return True
    errors = statistics.series_of(s, "error" if o.reference else "error_estimate")
    largest = statistics.number_at(errors, statistics.MAX)
    failed = int(s[0]) - int(s[statistics.STATUS])
    if failed:
        tell(f"{failed} states failed, --expect-error {o.expect_error:g}")
    if largest > o.expect_error:
        tell(f"state {errors[statistics.MAX_AT]}: error {largest:g}, "
             f"--expect-error {o.expect_error:g}")
    return not failed and not largest > o.expect_error


def part_result(plan, r):
    """A part prints nothing: its blocks are no statistics yet."""
    part, parts = plan.o.part
    if not r.done[part - 1 :: parts].all():
        print_missing(plan, r)
        return UNMET
    if not plan.o.quiet:
        tell(f"part {part}/{parts} is complete; after all parts: the same with --merge in place of "
             "--part")
    return GOOD


def report(plan, r, ranks):
    if not plan.o.quiet:
        print_rate(r, ranks)
    if plan.o.part:
        return part_result(plan, r)
    if r.missing():
        print_missing(plan, r)
        return UNMET
    print_result(plan, r, ranks)
    return GOOD if meets_expectation(plan.o, r.statistics) else UNMET


def main(argv):
    try:
        o = parse(argv)
    except Usage as error:
        if sweep_ranks.launched_ranks() == 1:
            raise
        # wrong on every rank: rank 0 says so before the first end of a rank ends the job
        with sweep_ranks.started() as ranks:
            if ranks.rank == 0:
                explain("sweep", error)
            ranks.agree(False)
        return USAGE
    with sweep_ranks.started() as ranks:
        plan = Plan(o, ranks)
        results, good = sweep_run.run(plan, ranks)
        reported = report(plan, results, ranks.size) if ranks.rank == 0 else GOOD
    return reported if good else FAILED
