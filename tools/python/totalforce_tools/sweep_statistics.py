# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Statistics of a sweep as 64-bit words, laid out as `statistics` in lib/python/sweep: merged,
evaluated, printed.

Merging is exact, associative and commutative, so that any split into blocks, threads and ranks
gives the same bits. Digits of exact sums have 32 bits in a block; as long as fewer than 2^32 blocks
are merged their sums fit 64 bits, and `exact_sum` carries.
"""
import json
import math

import numpy as np

import totalforce as tf
from totalforce_tools.cases import METHODS

GROUP = 512  # states whose values are added up before the exact sum gets them
COUNTS = ("states", "fallbacks", "sentinels", "residual_precision", "references",
          "references_failed")
SERIES = {
    "answer": "2-norm of the answer",
    "error_estimate": "relative error as the reply estimates it",
    "error": "relative error against quadruple precision",
    "error_over_estimate": "error / estimate, of states that have both",
}
NUMBERS, DIGITS, BINS, LOWEST_EXPONENT = 32, 68, 130, -64
STATUS = len(COUNTS)
METHOD = STATUS + NUMBERS
FIRST = METHOD + NUMBERS  # word of the first series: count, min, max, min_at, max_at, sum, bins
MIN, MAX, MIN_AT, MAX_AT, SUM = 1, 2, 3, 4, 5
BIN = SUM + DIGITS
LENGTH = BIN + BINS
WORDS = FIRST + len(SERIES) * LENGTH


def empty():
    return np.zeros(WORDS, np.uint64)


def words_of(data):
    """Of the bytes of a block"""
    return np.frombuffer(data, np.uint64)


def merge(statistics):
    """The statistics of all of a list. Extremes of equal value belong to the first state. The bits
    of numbers that are not negative are in the order of the numbers."""
    rows = np.array(statistics, np.uint64).reshape(-1, WORDS)
    total = rows.sum(axis=0, dtype=np.uint64)
    for start in range(FIRST, WORDS, LENGTH):
        seen = rows[rows[:, start] > 0, start : start + LENGTH]
        total[start + MIN : start + SUM] = 0
        if len(seen):
            low = seen[np.lexsort((seen[:, MIN_AT], seen[:, MIN]))[0]]
            high = seen[np.lexsort((seen[:, MAX_AT], ~seen[:, MAX]))[0]]
            total[start + np.array((MIN, MIN_AT))] = low[[MIN, MIN_AT]]
            total[start + np.array((MAX, MAX_AT))] = high[[MAX, MAX_AT]]
    return total


def series_of(statistics, name):
    start = FIRST + list(SERIES).index(name) * LENGTH
    return statistics[start : start + LENGTH]


def number_at(series, word):
    return float(series[word : word + 1].view(np.float64)[0])


def exact_sum(series):
    """The sum in units of 2^-1074"""
    return sum(int(digit) << 32 * k for k, digit in enumerate(series[SUM:BIN]))


def series_mean(series):
    """The sum is rounded once: division of whole numbers is exact but for that."""
    try:
        return exact_sum(series) / (1 << 1074) / int(series[0])
    except OverflowError:
        return math.inf


def bin_bound(k):
    """Lower bound of a bin; each is a factor of two, the first is below 2^-64."""
    return 0.0 if k == 0 else math.inf if k >= BINS else math.ldexp(1.0, k - 1 + LOWEST_EXPONENT)


def series_quantile(series, quantile):
    """Upper bound of the bin that has the value which a share `quantile` (0 to 1) does not exceed,
    or the maximum if that is less."""
    wanted = max(1, math.ceil(quantile * float(series[0])))
    k = int(np.searchsorted(np.cumsum(series[BIN:]), wanted))
    return min(bin_bound(k + 1), number_at(series, MAX))


def full_bins(series):
    return [(bin_bound(int(k)), bin_bound(int(k) + 1), int(series[BIN + k]))
            for k in np.flatnonzero(series[BIN:])]


def print_series(name, s):
    print(f"\n{name}: {SERIES[name]}\n  states {s[0]}")
    print("  min    %-24.17g state %d" % (number_at(s, MIN), s[MIN_AT]))
    print("  mean   %-24.17g" % series_mean(s))
    print("  max    %-24.17g state %d" % (number_at(s, MAX), s[MAX_AT]))
    print("  50 %% below %.3g, 99 %% below %.3g, 99.99 %% below %.3g"
          % tuple(series_quantile(s, share) for share in (0.5, 0.99, 0.9999)))
    for row in full_bins(s):
        print("  %10.4g .. %-10.4g %d" % row)


def named(statistics, first, names):
    """Those that are not zero, by name"""
    return {name: int(statistics[first + k]) for k, name in enumerate(names)
            if statistics[first + k]}


def print_table(statistics):
    for name, count in zip(COUNTS, statistics):
        print(f"{name:<20} {count}")
    for name, count in named(statistics, STATUS, tf.STATUSES).items():
        print(f"status {name:<13} {count}")
    for name, count in named(statistics, METHOD, METHODS).items():
        print(f"method {name:<13} {count}")
    for name in SERIES:
        if series_of(statistics, name)[0]:
            print_series(name, series_of(statistics, name))


def finite(value):
    return value if math.isfinite(value) else None


def series_json(s):
    return {
        "count": int(s[0]),
        "min": finite(number_at(s, MIN)), "min_state": int(s[MIN_AT]),
        "mean": finite(series_mean(s)),
        "max": finite(number_at(s, MAX)), "max_state": int(s[MAX_AT]),
        "histogram": [{"from": low, "below": finite(below), "count": count}
                 for low, below, count in full_bins(s)],
    }


def as_json(statistics):
    counts = {name: int(count) for name, count in zip(COUNTS, statistics)}
    series = {name: series_json(series_of(statistics, name)) for name in SERIES
              if series_of(statistics, name)[0]}
    return {**counts, "status": named(statistics, STATUS, tf.STATUSES),
            "method": named(statistics, METHOD, METHODS), **series}


def dump(value):
    return json.dumps(value, separators=(",", ":"))
