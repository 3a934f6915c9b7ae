# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Rows of an atlas: one method in one cell and mode, over all states and seeds."""
import csv
import math
from dataclasses import dataclass, field

import numpy as np

import totalforce as tf
from totalforce_tools import command
from totalforce_tools.cases import error_of, median, subject_of

MODES = {"plain": "the method alone: no refinement, no estimate, no fallback",
         "refined": "after one refinement step, whatever becomes of it",
         "service": "the answer to a request with default refinement and estimate",
         "estimated": "the same with estimate always"}
ROUNDING = 1e-13  # below it the estimate is rounding, too
# The promise: an estimate is never less than a thirtieth of the error.
UNDERESTIMATE_MAX = 30.0
# A larger error is a failure, unless the data themselves allow no better: the threshold of the
# library's own fallback.
FAILED = 1e-4
FAR_FROM_FLOOR = 100.0  # times the floor
NAN = math.nan


@dataclass
class Row:
    """Numbers of states, and the error: relative 2-norm, median over the states, infinite where
    there is none"""

    map: str
    point: int
    value: float
    bodies: int
    rhs: str
    method: str
    mode: str
    own: int = 0
    fallback: int = 0
    refused: int = 0
    status: str = ""  # of the first state that was not answered, and its subject
    about: str = ""
    answered_by: str = ""
    reason: str = ""  # of the first fallback
    error: float = math.inf
    worst: float = 0.0  # largest over the states that were answered, and its method
    worst_by: str = ""
    estimate: float = NAN  # median; NaN: none
    over: float = 0.0  # largest error / estimate among errors above ROUNDING; 0: none
    estimated: int = 0
    silent: int = 0  # states whose error is above 1e-6 and estimated below 1e-7
    floor: float = NAN
    error_low: float = math.inf  # least and largest of the seeds' errors
    error_high: float = math.inf
    unsaid: int = 0  # states wrong by more than FAILED, without an estimate
    same_as: str = ""  # an earlier method that gave the same answers by itself, to the last bit
    bits: tuple = field(default=(), repr=False)

    @property
    def answered(self):
        return self.own + self.fallback

    @property
    def word(self):
        return self.status if self.refused else "fallback" if self.fallback else "ok"

    @property
    def fell_back(self):
        """Most states were not answered by the method asked for"""
        return not self.is_refused and self.fallback >= self.own

    @property
    def is_refused(self):
        return self.refused > self.answered

    @property
    def failed(self):
        """Wrong by more than FAILED although the data allow better, or not finite"""
        if not self.answered:
            return self.status == "E_NOT_COMPUTED"
        return self.error > FAILED and self.error > FAR_FROM_FLOOR * self.floor

    @property
    def mark(self):
        """Who answered: nothing for the method itself, a question mark if it is wrong and has no
        estimate, the first letter of another one, a cross for none. Alone: an equals sign for the
        same answers."""
        if self.is_refused:
            return "×"
        if self.mode == "service" and not self.fell_back and 2 * self.unsaid >= self.own:
            return "?"
        if self.mode == "plain" and self.same_as:
            return "="
        return self.answered_by[0] if self.fell_back else ""


def refine_by_hand(solver, request, method, qdd):
    """dx = M^-1 (tau - RNEA(qdd)), qdd += dx, by requests of their own: refinement asked for in one
    request ends in a fallback where it fails, and here the failure is what is wanted."""
    q, v, tau = request["q"], request["v"], request["tau"]
    residual = tau - solver.inverse_dynamics(q, v, qdd=qdd).tau
    return solver.forward_dynamics(q, tau=residual, gravity=(0.0, 0.0, 0.0), method=method,
                                   refine=0, estimate="never").qdd + qdd


def count_answer(row, reply, error):
    if error >= row.worst:
        row.worst, row.worst_by = error, reply.method
    if reply.flags & tf.ANSWER_FALLBACK:
        if not row.fallback:
            row.answered_by, row.reason = reply.method, reply.fallback
        row.fallback += 1
    else:
        row.own += 1
    if not reply.flags & tf.ANSWER_ESTIMATED:
        row.unsaid += error > FAILED
        return NAN
    estimate = float(reply.error_estimate)
    row.estimated += 1
    if error > ROUNDING:
        row.over = max(row.over, error / estimate if estimate else math.inf)
    row.silent += error > 1e-6 and estimate < 1e-7
    return estimate


def measure(row, states, solver):
    """Fills in a row whose map, value, method and mode are set."""
    row.answered_by, row.floor = row.method, states.floor
    how = {"method": row.method, "refine": 0}
    if row.mode in ("service", "estimated"):
        how = {"method": row.method, "estimate": "default" if row.mode == "service" else "always"}
    errors, estimates, bits = [], [], []
    for s in range(states.count):
        request = states.request(s)
        errors.append(math.inf)
        estimates.append(NAN)
        try:
            reply = solver.forward_dynamics(**{**request, **how})
            found = reply.qdd
            if row.mode == "refined":
                found = refine_by_hand(solver, request, row.method, found)
        except tf.Error as error:
            if not row.refused:
                row.status, row.about = error.status, subject_of(error)
            row.refused += 1
            continue
        with np.errstate(all="ignore"):
            errors[-1] = error_of(found, states.exact[s])[0]
        estimates[-1] = count_answer(row, reply, errors[-1])
        bits.append(found.tobytes())
    row.error = row.error_low = row.error_high = median(errors)
    row.estimate = NAN if math.isnan(estimates[0]) else median(estimates)
    row.bits = tuple(bits)
    return row


def combine(rows):
    """The rows of several seeds in one: sums of states, medians of errors, estimates and floors,
    and the worst of the worst"""
    row, estimates = rows[0], [r.estimate for r in rows if not math.isnan(r.estimate)]
    row.error, row.floor = median(r.error for r in rows), median(r.floor for r in rows)
    row.estimate = median(estimates) if estimates else NAN
    fell = next((r for r in rows if r.fallback), row)
    row.answered_by, row.reason = fell.answered_by, fell.reason
    none = next((r for r in rows if r.refused), row)
    row.status, row.about = none.status, none.about
    worst = max(rows, key=lambda r: r.worst)
    row.worst, row.worst_by = worst.worst, worst.worst_by
    row.bits = tuple(r.bits for r in rows)
    for name in ("own", "fallback", "refused", "estimated", "unsaid", "silent"):
        setattr(row, name, sum(getattr(r, name) for r in rows))
    row.over = max(r.over for r in rows)
    row.error_low = min(r.error_low for r in rows)
    row.error_high = max(r.error_high for r in rows)
    return row


def find_same(rows):
    """Sets same_as in the rows of one cell."""
    seen = {}
    for row in rows:
        if row.own and not row.fallback and not row.refused:
            first = seen.setdefault((row.mode, row.bits), row.method)
            row.same_as = "" if first == row.method else first


FIELDS = {  # of a row of CSV and JSON: its value
    "map": lambda r: r.map, "value": lambda r: r.value, "bodies": lambda r: r.bodies,
    "rhs": lambda r: r.rhs, "method": lambda r: r.method, "mode": lambda r: r.mode,
    "own": lambda r: r.own, "fallback": lambda r: r.fallback, "refused": lambda r: r.refused,
    "status": lambda r: r.word, "about": lambda r: r.about,
    "answered_by": lambda r: r.answered_by if r.answered else "", "reason": lambda r: r.reason,
    "error": lambda r: r.error, "worst": lambda r: r.worst if r.answered else NAN,
    "estimate": lambda r: r.estimate, "error_over_estimate": lambda r: r.over or NAN,
    "silent": lambda r: r.silent, "floor": lambda r: r.floor, "error_low": lambda r: r.error_low,
    "error_high": lambda r: r.error_high, "unsaid": lambda r: r.unsaid,
    "same_as": lambda r: r.same_as}


def cell(row, name):
    value = FIELDS[name](row)
    if not isinstance(value, float):
        return value
    return "" if not math.isfinite(value) else f"{value:.6g}" if name == "value" else f"{value:.2e}"


def print_csv(out, rows):
    csv.writer(out, lineterminator="\n").writerows([cell(r, name) for name in FIELDS] for r in rows)


def print_json(out, rows):
    for row in rows:
        values = {name: value(row) for name, value in FIELDS.items()}
        values["same_as"] = values["same_as"] or None
        print(command.json_line(values), file=out)
