# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce chart`: accuracy against speed."""
import contextlib
import sys
from itertools import product

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools import cases, chart_peers, chart_rows, command
from totalforce_tools.cases import RHS
from totalforce_tools.chart_rows import OPS, OVER_BUDGET, PRECISIONS, STRATEGIES, Row
from totalforce_tools.command import Failed, Option, Usage, each, number, positive, whole, word

ABOUT = ("Charts accuracy against speed: every method on every mechanism, size, right-hand side "
         "and number of refinement steps, against quadruple precision.")
AFTER = """Ops:
  forward_dynamics: accelerations of the joints
  operational_inertia: Lambda^-1 of one link, 6 x 6, in f64 or f128; has no right-hand side

Right-hand sides of forward dynamics:
  qdd: torques of a random qdd, computed in f128 and rounded; moving
  tau: random torques N(0,1) N m; moving
  gravity: no torques, at rest under gravity

Precisions:
  f64: double
  f32: float
  f32+f64: float; refined by residuals in double
  f64+f128: double; refined by residuals in quadruple precision
  f128: quadruple precision

Strategies:
  single: one state a request
  batch: 512 states a request (64 above 128 bodies)
  specialised: one state, by the specialised kernel in --kernels
  specialised-batch: 512 states, by the specialised kernel

Times are CPU times of this thread for one state, medians, taken in turns with aba in f64; with \
more than one thread wall times. The floor is the change of the exact answer when each number of \
the robot and the request changes in its last bit and sines and cosines are rounded to double."""
CASES_MAX = 32
HEAD = f"""\
# error: relative 2-norm error of qdd to aba in f128, or relative Frobenius-norm error of \
Lambda^-1 (6 x 6, linear rows first, m and rad, axes of the world) to the dense J M^-1 J^T in f128 \
(above 128 bodies: to propagation in f128), median over the seeds of the median over the states; \
error_low, error_high: of the least and the worst seed; worst_component: largest relative error of \
one component in any state
# floor: change of the exact answer when every number of the robot and of the request changes in \
the last bit, and sines and cosines are rounded to double; at least 2^-53
# precision: of the factors, and behind + of the residual of refinement steps
# strategy: single: one state a request; batch: 512 (64 above 128 bodies); specialised: by a \
specialised kernel
# time_us: median time for one state: CPU time with one thread, with more wall time; aba_us: that \
of aba in f64 and generic code, in turns; time_ratio: median of neighbours' ratios
# time_low_us, time_high_us: of the fastest and the slowest seed
# status over_budget: a call, here or with fewer bodies, took more than %g ms; too_large, refused: \
of peers
# front: 1 on the Pareto front of its mechanism, size, threads and right-hand side, errors within \
a factor of two, or below the floor, being equal, and 0.1 no answer; same_as: an earlier method \
whose answers are the same to the last bit, with as many steps: such a row has no mark and no \
place on the front
{','.join(chart_rows.COLUMNS)}
"""


def read_target(targets):
    def read(text, _):
        for label in text.split(","):
            name, colon, value = label.partition(":")
            if len(targets) == CASES_MAX:
                raise ValueError(f"more than {CASES_MAX} mechanisms and robots")
            cases.read_mechanism(name, None)
            value = number(value) if colon else None
            if colon and value <= 0:
                raise ValueError(f"{label}: the number must be positive")
            targets.append((label, None, value))

    return read


def read_file(targets):
    def read(text, _):
        if len(targets) == CASES_MAX:
            raise ValueError(f"more than {CASES_MAX} mechanisms and robots")
        targets.append((text, text, None))

    return read


def methods_of(ops):
    """Methods, then the peers of this build, that answer one of the ops"""
    return [name for name in [*cases.METHODS, *chart_peers.TABLE] if name != "auto"
            and any(chart_rows.op_answered(op, name, "f64") for op in ops)]


def read_method(text, _):
    if text not in cases.METHODS and text not in chart_peers.TABLE:
        raise ValueError(f"no '{text}'")
    return text


def options_of(argv):
    targets = []

    def some(words):
        return each(word(words), len(words), twice=True)

    options = command.Command("chart", ABOUT, [
        Option("mechanisms", "m", "MECHANISM[:X],...", "NAME or NAME:X, where X is its mass ratio, "
               "taper or radius (all, unless --urdf is given)", read_target(targets)),
        Option("bodies", "n", "N,...", "Sizes of the mechanisms (8,32,128)",
               each(whole(1, 16384), 16)),
        Option("urdf", None, "FILE", "A robot; may be repeated", read_file(targets)),
        Option("base", None, "fixed|floating", "Of the robots (fixed)", word(("fixed", "floating")),
               "fixed"),
        Option("methods", "M", "METHOD,...", "Methods and peers (all of the ops)",
               each(read_method, 32)),
        Option("op", None, "|".join(OPS) + ",...", "Answers (forward_dynamics)", some(OPS)),
        Option("tip", None, "LINK", "Link of operational_inertia (the one behind most joints)"),
        Option("rhs", None, "|".join(RHS) + ",...", "Right-hand sides (all)", some(RHS)),
        Option("refine", None, "0|1|2,...", "Refinement steps (0,1)", some(("0", "1", "2"))),
        Option("precision", None, "|".join(PRECISIONS) + ",...", "Arithmetic (f64)",
               each(word(tuple(PRECISIONS)), len(PRECISIONS))),
        Option("threads", None, "N,...", "Numbers of threads; more than 1: on a pool (1)",
               each(whole(1, 256), 8)),
        Option("strategies", None, "|".join(STRATEGIES) + ",...",
               "States of a request and code (single; with more than one thread batch)",
               each(word(STRATEGIES), len(STRATEGIES))),
        Option("kernels", None, "FOLDER", "Where `totalforce specialise` put kernels"),
        Option("turn", None, "X", "Joint angles within +-X rad (0.001 for mechanisms, 3 for "
               "robots)", positive(1e3)),
        Option("states", None, "N", "Random states of each seed (3)", whole(2, 16), 3),
        Option("seed", "s", "N", "Of the random numbers (1)", whole(0, 2**64 - 1), 1),
        Option("seeds", None, "N", "Seeds for each row, from --seed on: other mechanisms and "
               "states (3)", whole(1, 16), 3),
        Option("budget-ms", None, "N", "CPU time for timing one row (20)", whole(1, 100000), 20),
        Option("json", None, None, "JSON, one row a line, in place of CSV"),
        Option("html", None, "FILE", "Write a self-contained page there: pictures, numbers under "
               "the pointer"),
        Option("output", "o", "FOLDER", "Write chart.csv, SVG and PNG there"),
    ], AFTER, words={"METHOD": methods_of(OPS), "MECHANISM": _totalforce._mechanisms()}).parse(argv)
    options.targets = targets or [(name, None, None) for name in _totalforce._mechanisms()]
    return complete(options)


def complete(o):
    """Defaults that depend on others; combinations that cannot be charted"""
    o.bodies = o.bodies or [8, 32, 128]
    o.op = [op for op in OPS if op in (o.op or OPS[:1])]
    o.rhs = [rhs for rhs in RHS if rhs in (o.rhs or RHS)]
    o.refine = sorted(int(step) for step in o.refine or ("0", "1"))
    o.precision, o.threads = o.precision or ["f64"], o.threads or [1]
    for precision in o.precision:
        if PRECISIONS[precision][1] != "same" and o.refine == [0]:
            raise Usage(f"--precision {precision} needs --refine 1 or 2")
    for method in o.methods or ():
        if not any(chart_rows.op_answered(op, method, "f64") for op in o.op):
            raise Usage(f"--methods: {method} answers none of --op")
    o.methods = o.methods or methods_of(o.op)
    for strategy in o.strategies or ():
        if strategy.startswith("specialised") and not o.kernels:
            raise Usage(f"--strategies {strategy} needs --kernels FOLDER")
    return o


class Run:
    """All rows of a run; pictures need them together."""

    def __init__(self, options, out):
        self.options, self.out, self.rows = options, out, []
        self.failed, self.unwritten = False, None
        self.over = {}  # the fewest bodies at which a call was too long, by op, method, precision

    def chart_all(self):
        o = self.options
        strategies = o.strategies or [None]
        sizes = [(t, n) for t in o.targets for n in (o.bodies if t[1] is None else [0])]
        progress = command.Progress(len(sizes) * len(o.threads) * len(strategies), "cases")
        self.write(self.write_head)
        for (target, bodies), threads, strategy in product(sizes, o.threads, strategies):
            if o.output:  # otherwise the rows themselves tell
                progress.step(target[0])
            self.chart(target, bodies, threads, strategy or ("batch" if threads > 1 else "single"))
            if self.unwritten:
                break
        progress.clear()

    def write(self, printer):
        """Rows that cannot be written end the run; what was measured is drawn."""
        try:
            printer()
            self.out.flush()
        except OSError as error:
            self.unwritten = error

    def write_head(self):
        o = self.options
        if not o.json:
            command.print_head(self.out, o.command)
            print(f"# states of each row and seed: {o.states}, seeds: {o.seeds} from {o.seed} on",
                  file=self.out)
            self.out.write(HEAD % (OVER_BUDGET * o.budget_ms))

    def chart(self, target, bodies, threads, strategy):
        """The seeds of one target and size, put together. What cannot be charted is told and left
        out."""
        seeds = []
        for k in range(self.options.seeds):
            try:
                seeds.append(self.chart_seed(target, bodies, threads, strategy,
                                             self.options.seed + k))
            except (tf.Error, Failed) as error:
                if error.args:
                    place = f", {bodies} bodies" if bodies else ""
                    print(f"totalforce chart: {target[0]}{place}: {error}", file=sys.stderr)
                self.failed = True
                return
        rows = [chart_rows.combine(same) for same in zip(*seeds)]
        chart_rows.find_same(rows)
        for op, rhs in {(row.op, row.rhs): None for row in rows}:
            chart_rows.mark_front([row for row in rows if (row.op, row.rhs) == (op, rhs)])
        self.rows += rows
        printer = chart_rows.print_json if self.options.json else chart_rows.print_csv
        self.write(lambda: printer(self.out, rows))

    def chart_seed(self, target, bodies, threads, strategy, seed):
        o, (label, file, value) = self.options, target
        if file:
            case = cases.load_case(file, seed, o.base, turn=o.turn, tip=o.tip)
        else:
            case = cases.Case.mechanism(label, bodies, seed, value, turn=o.turn, tip=o.tip)
        solvers = chart_rows.Solvers(case, o, threads, strategy)
        if solvers.why:
            print(f"totalforce chart: {case.name}: no specialised kernel: {solvers.why}",
                  file=sys.stderr)
        rows = []
        with contextlib.closing(solvers):
            for op in o.op:
                for rhs in o.rhs if op == "forward_dynamics" else [None]:
                    # Lambda^-1 has no right-hand side; its states are those of the first
                    states = cases.States(case, op, rhs or "qdd", o.states)
                    rows += self.chart_methods(states, solvers, rhs or "", threads, strategy)
        return rows

    def chart_methods(self, states, solvers, rhs, threads, strategy):
        o, case, rows = self.options, states.case, []
        for precision, method, refine in product(o.precision, o.methods, (0, 1, 2)):
            if refine not in o.refine or not chart_rows.combination_exists(
                    states.op, method, refine, precision, strategy):
                continue
            row = Row(case.name, case.bodies, rhs, method, refine, precision, threads, strategy,
                      states.op, floor=states.floor)
            key = states.op, method, precision
            if case.bodies >= self.over.get(key, case.bodies + 1):
                row.fail("over_budget")
            else:
                chart_rows.measure(row, states, solvers, o.budget_ms, 1e-3 * o.budget_ms / o.seeds)
            if row.status == "over_budget":
                self.over[key] = min(case.bodies, self.over.get(key, case.bodies))
            rows.append(row)
        return rows


def main(argv):
    options = options_of(argv)
    page = open(options.html, "w", encoding="utf-8") if options.html else None
    run = Run(options, command.open_rows("chart", options.output, options.json))
    run.chart_all()
    if run.out is not sys.stdout and not run.unwritten:
        run.out.close()
    if run.rows and (page or options.output and not run.unwritten):
        # here, not above: matplotlib takes a second
        from totalforce_tools import chart_page, chart_pictures
        scatters = [chart_pictures.scatter(options, some)
                    for some in chart_pictures.cases_of(run.rows)]
        if options.output and not run.unwritten:
            chart_pictures.draw(options, run.rows, scatters)
        if page:
            chart_page.write(page, options, run.rows, scatters)
    if page:
        page.close()
    if run.unwritten:
        raise run.unwritten
    return command.FAILED if run.failed else command.GOOD
