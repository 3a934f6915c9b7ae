# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What an atlas says in sentences: counted and not asserted."""
import math

from totalforce_tools.atlas_rows import FAILED, ROUNDING, UNDERESTIMATE_MAX


def short(value):
    """ "1e6": two digits, and no more of an exponent than it needs"""
    if value == 0 or 0.01 <= value < 99.5:
        return f"{value:.2g}"
    digits, exponent = f"{value:.1e}".split("e")
    return f"{digits.removesuffix('.0')}e{int(exponent)}"


def over_floor(row):
    return row.worst / row.floor if row.worst > ROUNDING else 0.0


def seed_spread(row):
    """How many times the worst seed is the least, of a method alone that fails"""
    counts = row.mode == "plain" and not row.refused and row.error_high > FAILED
    return row.error_high / row.error_low if counts and row.error_low > 0 else 0.0


def largest(rows, key, least=0.0):
    """The first of the largest; None: none is above the least"""
    best = max(rows, key=key, default=None)
    return best if best and key(best) > least else None


class Summary:
    """Of all rows, or of those of one map"""

    def __init__(self, rows):
        service = [r for r in rows if r.mode == "service"]
        estimated = [r for r in rows if r.mode == "estimated"]
        answered = [r for r in service if r.answered]
        self.answers = [sum(getattr(r, name) for r in service)
                        for name in ("own", "fallback", "refused")]
        self.unsaid = sum(r.unsaid for r in service)
        self.silent = sum(r.silent for r in rows)
        self.estimates = sum(r.estimated for r in estimated)
        self.broken = sum(r.over > UNDERESTIMATE_MAX for r in estimated)
        self.over = largest([r for r in rows if r.mode in ("service", "estimated")],
                            lambda r: r.over)
        self.spread = largest(rows, seed_spread)
        self.worst = largest(answered, lambda r: r.worst, -1.0)
        self.far = largest(answered, over_floor)

    @property
    def kept(self):
        return not self.silent and (not self.over or self.over.over <= UNDERESTIMATE_MAX)


def broken_promises(rows):
    for row in rows:
        if row.silent or row.over > UNDERESTIMATE_MAX:
            yield (f"{row.map} {short(row.value)}, {row.bodies} bodies, {row.method}, {row.mode}: "
                   + (f"{row.silent} errors above 1e-6 are estimated below 1e-7" if row.silent
                      else f"an estimate is 1/{row.over:.2g} of the error"))


def place(row):
    by = f", answered by {row.worst_by}" if row.worst_by and row.worst_by != row.method else ""
    return f" ({row.method} at {row.map} {short(row.value)}, {row.bodies} bodies{by})"


def first_failures(rows, mode):
    """Methods by the first point along the axis at which they fail at any size; None: nowhere"""
    methods = dict.fromkeys(r.method for r in rows)
    found = {}
    for method in methods:
        points = [r.point for r in rows if r.method == method and r.mode == mode and r.failed]
        found.setdefault(min(points, default=None), []).append(method)
    return found


def failures(rows, mode):
    found, values = first_failures(rows, mode), {r.point: r.value for r in rows}
    never = found.pop(None, [])
    if not found:
        return "none."
    return "; ".join(f"from {short(values[point])} on {', '.join(found[point])}"
                     for point in sorted(found)) + "." + (
        f" Never: {', '.join(never)}." if never else "")


def of_estimates(s):
    if not s.over:
        least = "none is below the true error"
    elif s.over.over > 1.0:
        least = f"the least is 1/{s.over.over:.2g} of the true error{place(s.over)}"
    else:
        least = f"the least is {1.0 / s.over.over:.2g} times the true error{place(s.over)}"
    return (f"Of {s.estimates} estimates {least}, promised 1/{UNDERESTIMATE_MAX:g}, broken in "
            f"{s.broken} cells; errors above 1e-6 estimated below 1e-7: {s.silent}.")


def of_service(s):
    yield ("The service: {} answers by the method asked for, {} by another one that the reply "
           "names, {} refused by name; {} are wrong by more than 1e-4 and have no estimate.".format(
               *s.answers, s.unsaid))
    if s.worst:
        far = (f"; the farthest from the floor is {over_floor(s.far):.1e} times that{place(s.far)}"
               if s.far else "")
        yield f"Its largest error is {s.worst.worst:.1e}{place(s.worst)}{far}."


def of_map(rows):
    """Sentences about one map"""
    s = Summary(rows)
    yield ("Alone, wrong by more than 1e-4 and 100 times the floor, at some size: "
           + failures(rows, "plain"))
    yield "Refined once, still: " + failures(rows, "refined")
    hopeless = [r for r in rows if r.floor > FAILED]
    if hopeless:
        first = min(hopeless, key=lambda r: r.point)
        yield (f"From {short(first.value)} on, at some size, the floor is above 1e-4: the last "
               "bits of the robot's numbers and the request's change the exact answer by more, and "
               "no method can help.")
    if s.spread:
        spread = seed_spread(s.spread)
        yield ("Largest error of a seed / least, of a method alone that fails: "
               + (f"{spread:.0f}" if math.isfinite(spread) else "inf") + place(s.spread) + ".")
    yield from of_service(s)
    yield of_estimates(s)
