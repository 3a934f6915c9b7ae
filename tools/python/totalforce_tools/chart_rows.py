# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Rows of a chart: one method on one case, its errors and times; rows of several seeds put
together, rows with the same answers, the Pareto front; CSV and JSON."""
import csv
import math
import time
from dataclasses import dataclass, field, replace

import numpy as np

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools import cases, chart_peers, command, scene
from totalforce_tools.cases import NO_DIGIT, PRECISIONS, error_of, median, subject_of

OPS = ("forward_dynamics", "operational_inertia")
STRATEGIES = ("single", "batch", "specialised", "specialised-batch")
# a call longer than this many budgets is not repeated, and not made for any larger robot
OVER_BUDGET = 20.0
NAN = math.nan


@dataclass
class Row:
    """One measurement. status: "" where there is an answer, otherwise why not; `why` says it in
    words, `about` of what. same_as: an earlier method whose answers have the same bits."""

    mechanism: str
    bodies: int
    rhs: str
    method: str
    refine: int
    precision: str
    threads: int
    strategy: str
    op: str
    status: str = ""
    about: str = ""
    why: str = ""
    answered_by: str = ""
    error: float = NAN
    worst_component: float = NAN
    floor: float = NAN
    estimate: float = NAN
    time_us: float = NAN
    aba_us: float = NAN
    time_ratio: float = NAN
    samples: int = 0
    front: int = 0
    error_low: float = NAN
    error_high: float = NAN
    time_low_us: float = NAN
    time_high_us: float = NAN
    same_as: str = ""
    bits: tuple = field(default=(), repr=False)

    @property
    def own(self):
        """Answered by the method itself, not by a fallback"""
        return self.method in ("auto", self.answered_by)

    @property
    def good(self):
        return not self.status and self.own and math.isfinite(self.error)

    @property
    def drawn(self):
        return self.good and not self.same_as

    @property
    def word(self):
        return self.status or ("ok" if self.own else "fallback")

    @property
    def silence(self):
        """Why the row is in no picture"""
        return self.why or self.status or "fell back to another method"

    def fail(self, status, about="", why=""):
        self.status, self.about, self.why = status, about, why


def is_batch(strategy):
    return strategy.endswith("batch")


def op_answered(op, method, precision):
    lambda_inv = op == "operational_inertia"
    if lambda_inv and (precision not in ("f64", "f128") or method == "aba"):
        return False  # the library answers it in double; that of aba is propagation
    if method in cases.METHODS:
        return op in cases.METHODS[method].ops
    return not lambda_inv or chart_peers.has_lambda(method)


def combination_exists(op, method, refine, precision, strategy):
    if not op_answered(op, method, precision):
        return False
    if method not in cases.METHODS:
        return refine == 0 and precision == "f64" and strategy == "single"
    if strategy.startswith("specialised") and (refine > 0 or method != "auto"):
        return False  # a specialised kernel is its robot's choice, and leaves refinement alone
    return refine > 0 or PRECISIONS[precision][1] == "same"


class Solvers:
    """What computes the rows of a case: by precision a workspace, or a pool of several threads."""

    def __init__(self, case, options, threads, strategy):
        self.case, self.threads, self.kernel, self.errors = case, threads, None, {}
        self.specialised = strategy.startswith("specialised")
        self.of, self.why = {}, None
        # one for all: the idle threads of another would spin on the same processors
        self.thread_pool = tf.ThreadPool(threads) if threads > 1 else None
        if self.specialised:
            try:
                self.kernel = scene.find_kernel(options.kernels, case.model)
            except tf.Error as error:
                self.why = error
        for precision in options.precision if self.kernel or not self.specialised else ():
            try:
                self.of[precision] = self._make(precision, self.kernel)
            except tf.Error as error:
                self.errors[precision] = error
        self.baseline = self._make("f64", None)
        self.peers = chart_peers.Peers(case, options.methods, threads)

    def _make(self, precision, kernel):
        factors, residual = PRECISIONS[precision]
        options = {"precision": factors, "residual": residual, "methods": list(cases.METHODS),
                   "specialised": kernel}
        if self.threads > 1:
            return tf.Pool(self.case.model, thread_pool=self.thread_pool, **options)
        return tf.Workspace(self.case.model, **options)

    def close(self):
        if self.threads > 1:
            for pool in [*self.of.values(), self.baseline, self.thread_pool]:
                pool.close()
        self.peers.close()


def refuse(row, error, about=None):
    """The row of an answer that there is not"""
    row.fail(error.status, about or subject_of(error), error.summary)


def find_refusal(row, solvers):
    """Facts that are known without a request"""
    if row.method not in cases.METHODS:
        row.fail(*solvers.peers.refusal(row.method))
    elif solvers.specialised and not solvers.kernel:
        row.fail("E_UNSUPPORTED", "kernel", "not supported")
    elif row.precision in solvers.errors:
        refuse(row, solvers.errors[row.precision], "precision")
    return row.status


def batch_of(states):
    """Requests of many states as one: the states over and over"""
    count = 512 if states.case.bodies <= 128 else 64
    return states.request(np.arange(count) % states.count)


def batch_answers(row, states, solvers):
    """Numbers, method, flags and estimate of each state, from one request"""
    reply = solvers.of[row.precision].compute(states.op, **batch_of(states), method=row.method,
                                              refine=row.refine)
    flags, estimates = reply.answers["flags"], reply.answers["error_estimate"]
    return [(states.answer(reply, s), reply.method[s], flags[s], estimates[s])
            for s in range(states.count)]


def single_answers(row, states, solvers):
    """The same, state after state"""
    for s in range(states.count):
        if row.method not in cases.METHODS:
            yield solvers.peers.answer(row.method, states, s), row.method, 0, NAN
            continue
        reply = solvers.of[row.precision].compute(states.op, **states.request(s), method=row.method,
                                                  refine=row.refine)
        yield states.answer(reply), reply.method, reply.flags, reply.error_estimate


def measure_errors(row, states, solvers, budget_ms):
    """Errors of all states, unless the first takes too long"""
    errors, worst, estimates, bits = [], [], [], []
    of_factors = PRECISIONS[row.precision][1] == "same"
    answers = (batch_answers if is_batch(row.strategy) else single_answers)(row, states, solvers)
    start = time.thread_time()  # a batch is there already: it has no budget
    for s, (found, method, flags, estimate) in enumerate(answers):
        fell = flags & tf.ANSWER_FALLBACK
        if of_factors and flags & tf.ANSWER_RESIDUAL_PRECISION and not fell:
            return row.fail("E_UNSUPPORTED", "precision", "not supported")  # an answer of double
        if s == 0 and time.thread_time() - start > 1e-3 * OVER_BUDGET * budget_ms:
            return row.fail("over_budget")
        if s == 0 or fell:
            row.answered_by = method
        error, component = error_of(found, states.exact[s])
        errors.append(error)
        worst.append(component)
        estimates.append(estimate)
        bits.append(found.tobytes())
    row.error = row.error_low = row.error_high = median(errors)
    row.worst_component, row.estimate, row.bits = max(worst), median(estimates), tuple(bits)
    return None


def measure_times(row, states, solvers, seconds):
    """The choice and aba in turns; one thread by its own clock, several by wall time"""
    batch = [batch_of(states)] if is_batch(row.strategy) else None
    per_call = len(batch[0]["q"]) if batch else 1
    requests = batch or [states.request(s) for s in range(states.count)]

    def contestant(solver, method, refine):
        return solver, states.op, [{**r, "method": method, "refine": refine} for r in requests]

    if row.method in cases.METHODS:
        who = contestant(solvers.of[row.precision], row.method, row.refine)
    else:
        who = solvers.peers.contestant(row.method, states)
    clock = "monotonic" if solvers.threads > 1 else "thread"
    samples = _totalforce._race(who, contestant(solvers.baseline, "aba", 0), seconds, clock=clock)
    times, aba = 1e6 / per_call * samples
    row.samples = len(times)
    row.time_us = row.time_low_us = row.time_high_us = median(times)
    row.aba_us = median(aba)
    with np.errstate(divide="ignore", invalid="ignore"):
        row.time_ratio = median(times / aba)


def measure(row, states, solvers, budget_ms, seconds):
    row.floor = states.floor
    if find_refusal(row, solvers):
        return
    try:
        measure_errors(row, states, solvers, budget_ms)
        if not row.status:
            measure_times(row, states, solvers, seconds)
    except tf.Error as error:
        refuse(row, error)


MEDIANS = ("error", "floor", "estimate", "time_us", "aba_us", "time_ratio")


def combine(rows):
    """One row of the rows of the seeds: medians, and the least and the largest. A row that is not
    good for one of the seeds stands for all."""
    bad = next((row for row in rows if not row.good), None)
    if bad:
        return bad
    return replace(
        rows[0],
        **{name: median(getattr(row, name) for row in rows) for name in MEDIANS},
        worst_component=max(row.worst_component for row in rows),
        error_low=min(row.error_low for row in rows),
        error_high=max(row.error_high for row in rows),
        time_low_us=min(row.time_low_us for row in rows),
        time_high_us=max(row.time_high_us for row in rows),
        samples=sum(row.samples for row in rows),
        bits=tuple(row.bits for row in rows))


def find_same(rows):
    """Sets same_as, of one state at a time on one thread. Answers that are exact are the same
    whatever the code, and Lambda^-1 by propagation and pv-osimr is the same by different code. The
    choice of auto and its method are two marks."""
    seen = {}
    for row in rows:
        if (row.good and row.op == "forward_dynamics" and row.threads == 1
                and row.strategy == "single" and row.precision in ("f64", "f32")):
            first = seen.setdefault((row.rhs, row.refine, row.precision, row.bits), row.method)
            row.same_as = first if first not in ("auto", row.method) else ""


def mark_front(rows):
    """The front among rows of one op and right-hand side. Errors below the floor count as the
    floor, errors within a factor of two as equal: those of few states tell digits, not percents."""
    drawn = [row for row in rows if row.drawn]
    for row in rows:
        error = max(row.error, row.floor)
        row.front = int(row.drawn and row.error < NO_DIGIT and not any(
            other.time_us < row.time_us and max(other.error, other.floor) <= 2.0 * error
            for other in drawn))


COLUMNS = ("mechanism", "bodies", "rhs", "method", "refine", "precision", "threads", "status",
           "about", "answered_by", "error", "worst_component", "floor", "estimate", "time_us",
           "aba_us", "time_ratio", "samples", "front", "error_low", "error_high", "time_low_us",
           "time_high_us", "same_as", "strategy", "op")
KEYS = (*COLUMNS[:7], "strategy", *COLUMNS[7:-2], "op")


def cell(row, name):
    value = row.word if name == "status" else getattr(row, name)
    if isinstance(value, float):
        is_time = "time" in name or name == "aba_us"
        return f"{value:{'.4g' if is_time else '.3e'}}" if math.isfinite(value) else ""
    return value


def print_csv(out, rows):
    csv.writer(out, lineterminator="\n").writerows([cell(row, c) for c in COLUMNS] for row in rows)


def json_value(row, name):
    value = row.word if name == "status" else getattr(row, name)
    if name == "front":
        return bool(value)
    return None if value == "" and name in ("answered_by", "same_as") else value


def print_json(out, rows):
    for row in rows:
        print(command.json_line({key: json_value(row, key) for key in KEYS}), file=out)
