# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Rows of the CSV files that `totalforce chart`, `atlas` and `drift` and the benchmarks write."""
import csv
import math
from statistics import median_low
from types import SimpleNamespace

KEYS = ("mechanism", "bodies", "rhs", "method", "refine", "precision", "threads", "strategy", "op")


def number(text):
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


class Rows(list):
    """Rows with a field for each column, numbers as such; `head`: pairs "# NAME: TEXT" """

    def __init__(self, path):
        lines = path.read_text(encoding="utf-8").splitlines()
        self.head = [(name, text) for name, _, text in
                     (line[2:].partition(": ") for line in lines if line.startswith("# "))]
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        super().__init__(SimpleNamespace(**{name: number(x) for name, x in row.items()})
                         for row in rows)

    def fact(self, name):
        return dict(reversed(self.head)).get(name, "unknown")


def some(rows, **fields):
    """The rows with these values"""
    return [r for r in rows if all(getattr(r, name) == x for name, x in fields.items())]


def unique(values):
    """In the order of their first appearance"""
    return list(dict.fromkeys(values))


def pairs(rows, field, first, second):
    """Answers with `first` in a field, each with the answer that has `second` there"""
    def key(row, **change):
        return tuple((vars(row) | change)[name] for name in KEYS)

    answers = {key(r): r for r in some(rows, status="ok")}
    firsts = some(answers.values(), **{field: first})
    return [(r, answers[key(r, **{field: second})]) for r in firsts
            if key(r, **{field: second}) in answers]


def digits(ratio):
    return int(math.log10(ratio) + 0.5)


def cost_of_float(chart, strategy):
    """Time of an answer in float over that in double, and the digits lost: medians of the robots"""
    both = pairs(some(chart, strategy=strategy, refine=0), "precision", "f32", "f64")
    return (median_low(f32.time_us / f64.time_us for f32, f64 in both),
            median_low(digits(f32.error / f64.error) for f32, f64 in both))


def table(head, lines):
    """In Markdown; the head is a list, or one text with | between"""
    def row(cells):
        return "| " + " | ".join(map(str, cells)) + " |\n"

    head = head.split("|") if isinstance(head, str) else head
    return row(head) + "|---" * len(head) + "|\n" + "".join(map(row, lines))
