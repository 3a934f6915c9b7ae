# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Sessions that `totalforce latency --save` wrote: their histograms, and the comparison of two."""
import json
import math

import numpy as np

FORMAT = "totalforce latency 2"
BITS = 8
BUCKETS = (1 << BITS) + (63 - BITS) * (1 << BITS - 1)  # of times below 2^63 ns
# Shares as the report of `latency` names them.
QUANTILES = {"50": 0.5, "90": 0.9, "99": 0.99, "99.9": 0.999, "99.99": 0.9999,
             "99.999": 0.99999, "99.9999": 0.999999}
PARTS = ("round_trip", "client", "request", "queue", "compute", "reply")
# Tenths of a run that must support a percentile for their range to tell its noise
SLICES_WANTED = 5
# Standard deviations of a rank that its interval extends to each side: 95 %
RANK_DEVIATIONS = 1.96
# Ratios of the tenths that spread further and include 1 allow no verdict
SPREAD = 1.5
SAME = ("via", "load", "robot", "wait", "batch", "model", "version", "kernel", "processor",
        "ended_early")


class Histogram:
    """Log-linear buckets as of totalforce/histogram.h: tops of the full ones, and their counts."""

    def __init__(self, saved):
        pairs = np.array(saved["buckets"], np.int64).reshape(-1, 2)
        linear, half = 1 << BITS, 1 << BITS - 1
        buckets, self.counts = pairs[np.argsort(pairs[:, 0])].T
        shift = np.maximum((buckets - linear) // half + 1, 0)
        top = np.where(shift, ((buckets - linear) % half + half + 1 << shift) - 1, buckets)
        self.lowest, self.highest = saved["lowest"], saved["highest"]
        self.count, self.tops = int(self.counts.sum()), np.minimum(top, self.highest)
        if self.count != saved["count"] or (pairs < 0).any() or (buckets >= BUCKETS).any():
            raise ValueError("a histogram that does not add up")

    def quantile(self, share):
        """The value that this share of the values does not exceed, by nearest rank"""
        wanted = max(math.ceil(share * self.count), 1)
        index = np.searchsorted(np.cumsum(self.counts), wanted)
        return int(self.tops[index]) if index < len(self.tops) else self.highest

    def supports(self, share):
        """With fewer than ten values beyond it a quantile is noise."""
        return (1.0 - share) * self.count >= 10 * (1.0 - 1e-9)


class Run:
    """One run of a session; what the report has of it is `facts`"""

    def __init__(self, facts):
        self.facts = facts
        self.name = " ".join(filter(None, (facts["via"], facts.get("swept"))))
        self.trip = Histogram(facts["round_trip"])
        self.slices = [Histogram(tenth) for tenth in facts["slices"]]

    def range_of(self, share):
        """Values between which a percentile lies, and whether ranks say so, for want of tenths"""
        values = [h.quantile(share) for h in self.slices if h.supports(share)]
        if len(values) >= SLICES_WANTED:
            return min(values), max(values), False
        off = RANK_DEVIATIONS * math.sqrt(share * (1 - share) / max(self.trip.count, 1))
        return (self.trip.quantile(max(share - off, 0)), self.trip.quantile(min(share + off, 1)),
                True)


class Session:
    """A file of `latency --save`"""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            self.facts = json.load(file)
        if not isinstance(self.facts, dict) or self.facts.get("format") != FORMAT:
            raise ValueError("not a session that `totalforce latency --save` of this version wrote")
        self.path = path
        self.busy = self.facts["busy"]
        self.environment = self.facts["environment"]
        self.pingpong = Histogram(self.facts["pingpong"])
        self.runs = [Run(facts) for facts in self.facts["runs"]]
        if not self.runs:
            raise ValueError("it has no runs")


def duration(ns):
    """ "20 ns", "0.5 µs", "3 ms" """
    value, unit = ((ns, "ns") if ns < 99.5 else (ns / 1e3, "µs") if ns < 995e3 else
                   (ns / 1e6, "ms") if ns < 995e6 else (ns / 1e9, "s"))
    return f"{value:.2g} {unit}" if value < 99.5 else f"{value:.0f} {unit}"


def headline(session):
    run = session.runs[0]
    h = run.trip
    tail = next((name for name in ("99.9", "99") if h.supports(QUANTILES[name])), "90")
    busy = run.facts["busy"]["busy"] or session.busy["busy"]
    ended = run.facts["ended_early"]
    within = lambda share: duration(h.quantile(share))
    return (f"{run.facts['robot']} over {run.name}: half of {h.count} round trips within "
            f"{within(0.5)}, {tail} % within {within(QUANTILES[tail])}, all within {within(1.0)}"
            f"{'; the machine was busy' if busy else ''}"
            f"{f'; ended early: {ended}' if ended else ''}")


def differences(before, after):
    text = lambda facts, key: json.dumps(facts[key]) if facts.get(key) is not None else "none"
    return [f"  not the same {key}: {text(before, key)}, {text(after, key)}" for key in SAME
            if before.get(key) != after.get(key)]


def compare_quantile(before, after, name):
    share = QUANTILES[name]
    old, new = before.trip.quantile(share), after.trip.quantile(share)
    (low, high, a), (least, most, b) = before.range_of(share), after.range_of(share)
    least, most = least / high, most / low
    verdict = ("slower" if least > 1 else "faster" if most < 1 else
               "too noisy to tell" if most > SPREAD * least else "within noise")
    return (f"  p{name:<10} {old / 1e3:10.3f} {new / 1e3:10.3f} {new / old:7.3f}  {least:.3f} to "
            f"{most:.3f} {verdict}{' (by ranks)' if a or b else ''}")


def compare_runs(before, after):
    facts = after.facts
    yield (f"\n{facts['via']}, robot {facts['robot']}, batch {facts['batch']}, wait "
           f"{facts['wait']}, {facts['load']}")
    yield from differences(before.facts, facts)
    yield (f"  {'us':<11} {'before':>10} {'after':>10} {'ratio':>7}  ratios of the tenths of the "
           "runs")
    for name, share in QUANTILES.items():
        if before.trip.supports(share) and after.trip.supports(share):
            yield compare_quantile(before, after, name)
    yield f"  {'max':<11} {before.trip.highest / 1e3:10.3f} {after.trip.highest / 1e3:10.3f}"


def compare(before, after):
    """Lines: ratios of the percentiles of two sessions, runs paired by their order"""
    for name, session in (("before", before), ("after", after)):
        busy = ", busy machine" if session.busy["busy"] else ""
        yield f"{name}: {session.path}, {session.facts['date']}{busy}: {session.facts['command']}"
    yield from differences(before.environment, after.environment)
    for pair in zip(before.runs, after.runs):
        yield from compare_runs(*pair)
    if len(before.runs) != len(after.runs):
        yield f"\nnot as many runs: {len(before.runs)}, {len(after.runs)}"
