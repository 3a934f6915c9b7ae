# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The tables of accuracy.md, methods.md and which-method.md, from the files that make.py measures:

    /usr/bin/python3 docs/charts/tables.py WORK ONE    ONE: bodies of the tables of one size

Every method of Tables without an underscore makes the text WORK/blocks/NAME.
"""
import os
import pathlib
import re
import sys
import textwrap
from math import exp, log
from statistics import median, median_low

import test_tables
from rows import Rows, cost_of_float, pairs, some, table, unique

SIDES = ("qdd", "tau", "gravity")
EXTREME = ("alternating", "light-heavy", "heavy-tip", "thin")  # masses and radii
QUESTIONS = """\
fastest for my arm?|hero.svg|`auto`: {call} a call, {kernel} by a specialised kernel, {batch} in a \
batch; MuJoCo {mujoco}
exact on my chain?|bodies.svg|`aba`, `scan`: {aba} on {one} random bodies, the floor of the data; \
`tfa` {tfa}
how many cores?|cores.svg|a second makes batches {faster:.1f} times as fast, one answer {single}
single precision?|single.svg|for batches: {part:.2f} of the time for {lost} digits; one call takes \
{slower:.1f} times as long
which method fails?|atlas.png|`tfa`, `cfa`, `dca` beside light or thin links: `tfa` {thin_tfa} on \
{one} thin rods, `aba` {thin_aba}"""


def errors(rows, method):
    """By mechanism, bodies and right-hand side: those of a method alone"""
    return {(r.mechanism, r.bodies, r.rhs): r.error
            for r in some(rows, method=method, refine=0, status="ok")}


class Tables:
    def __init__(self, work, one):
        self._work, self._one = work, one
        self._charts = {file.parent.name: Rows(file) for file in work.glob("*/chart.csv")}
        self._atlas = {side: Rows(work / f"atlas-{side}/atlas.csv") for side in SIDES}
        self._rows = self._charts["mechanisms"]
        self._good = some(self._rows, status="ok")
        self._methods = unique(r.method for r in self._rows)
        self._sizes = unique(r.bodies for r in self._rows)

    def measured(self):
        fact = self._rows.fact
        states, seeds = re.findall(r"\d+", fact("states of each row and seed"))[:2]
        return textwrap.fill(
            f"Measured on {fact('processor')}, {os.sysconf('SC_NPROCESSORS_ONLN')} processors, "
            f"kernels for `{fact('client_kernels')}`, {fact('date')}, version {fact('version')}; "
            f"{states} states of each of {seeds} seeds.", 99, break_on_hyphens=False) + "\n"

    def runs(self):
        lines = (line.split("|") for line in (self._work / "runs").read_text().splitlines())
        return table("run|command|seconds", (
            (f"`{name}`", f"`totalforce {line}`", seconds) for name, line, seconds in lines))

    def _hero(self, method, strategy):
        found = some(self._charts["hero"], mechanism="arm7", method=method, strategy=strategy,
                     precision="f64", threads=1, refine=0, status="ok")
        return f"{found[0].time_us:.2g} µs" if found else "(not measured)"

    def _off(self, method, mechanism):
        error = errors(self._rows, method).get((mechanism, self._one, "qdd"))
        return "(not measured)" if error is None else f"{error:.0e}"

    def questions(self):
        cores = {s: [(one.time_us / two.time_us, one.bodies) for one, two in pairs(
            some(self._charts["cores"], strategy=s), "threads", 1, 2)] for s in ("batch", "single")}
        best, longest = max(cores["single"])
        part, lost = cost_of_float(self._charts["single"], "batch")
        slower, _ = cost_of_float(self._charts["single"], "single")
        text = QUESTIONS.format(
            call=self._hero("auto", "single"), kernel=self._hero("auto", "specialised"),
            batch=self._hero("auto", "batch"), mujoco=self._hero("mujoco", "single"),
            aba=self._off("aba", "random"), one=self._one, tfa=self._off("tfa", "random"),
            faster=median_low(cores["batch"])[0],
            single="no faster" if best < 1.1 else f"up to {best:.1f} times ({longest} bodies)",
            part=part, slower=slower, lost=lost,
            thin_tfa=self._off("tfa", "thin"), thin_aba=self._off("aba", "thin"))
        text = re.sub(r"\|((\w+)\.\w+)\|", r"|[\2](pictures/\1)|", text)
        return table("question|picture|answer", (line.split("|") for line in text.splitlines()))

    def published(self):
        """Errors of the mechanisms of the accuracy study, alone; the worst over the floor, refined"""
        rows = some(self._charts["published"], status="ok")
        methods = unique(r.method for r in rows)

        def line(mechanism, bodies):
            same = some(rows, mechanism=mechanism, bodies=bodies)
            alone = {r.method: f"{r.error:.1e}" for r in some(same, refine=0)}
            refined = max(r.error / r.floor for r in some(same, refine=1))
            return (f"`{mechanism}` {bodies}", f"{same[0].floor:.1e}",
                    *(alone.get(m, "-") for m in methods), f"{refined:.2g}")

        return table(["bodies", "floor", *(f"`{m}`" for m in methods), "refined / floor"],
                     (line(*panel) for panel in unique((r.mechanism, r.bodies) for r in rows)))

    def _depth(self, chart):
        """Operations by method"""
        for method in unique(r.method for r in chart):
            rows = {(r.bodies, r.processors): r for r in some(chart, method=method)}
            small, large = rows[64, 1], rows[128, 1]
            yield (f"`{method}`", *(f"{(getattr(large, word) - getattr(small, word)) / 64:.0f}"
                                    for word in ("multiplications", "additions")),
                   *(rows[n, n].steps if (n, n) in rows else "" for n in (16, 64, 256, 1024, 4096)),
                   f"{rows[1024, 1].steps / rows[1024, 2].steps:.2f}" if (1024, 1) in rows else "")

    def depth(self):
        file = self._work / "depth/depth.csv"
        return file.exists() and table(
            "method|multiplications|additions|N = 16|64|256|1024|4096|two of 1024",
            self._depth(Rows(file)))

    def fronts(self):
        """On how many fronts a method is, alone or refined, by size"""
        def count(**fields):
            panels = {(r.bodies, r.mechanism, r.rhs) for r in some(self._rows, **fields)}
            return [sum(panel[0] == size for panel in panels) for size in self._sizes]

        lines = [(f"`{m}`", *count(method=m, front=1)) for m in self._methods]
        return table(["on the front", *self._sizes],
                     [line for line in lines if any(line[1:])] + [("panels", *count())])

    def times(self):
        """Time over that of aba on random chains, alone: median over the right-hand sides"""
        def cell(method, size):
            mine = some(self._rows, mechanism="random", refine=0, method=method, bodies=size)
            good = some(mine, status="ok")
            if not good:
                return mine[-1].status if mine else ""
            if method == "aba":
                return f"{median(r.time_us for r in good):.3g}"
            same = [f" ({r.same_as})" for r in mine if r.same_as]
            return f"{median(r.time_ratio for r in good):.2g}" + "".join(same[-1:])

        methods = sorted(self._methods, key=lambda m: m != "aba")
        return table(["time over `aba`", *self._sizes], (
            (f"`{m}`" + ", µs" * (m == "aba"), *(cell(m, size) for size in self._sizes))
            for m in methods))

    def near(self):
        """Panels near the floor and far from it"""
        def cells(method, refine):
            rows = [r for r in some(self._rows, method=method, refine=refine)
                    if r.status not in ("too_large", "over_budget")]
            good = [(r, r.error / max(r.floor, 1e-15)) for r in some(rows, status="ok")]
            if not good or refine and method in ("mujoco", "kdl"):
                return "-----"
            spread = max(r.error_high / r.error_low for r, _ in good if r.error_low)
            return (len(good), sum(ratio <= 10 for _, ratio in good),
                    sum(ratio > 100 for _, ratio in good), len(rows) - len(good), f"{spread:.2g}")

        return table("method|alone: answers|near|far|refused|spread|refined: answers|near|far|"
                     "refused|spread", ((f"`{m}`", *cells(m, 0), *cells(m, 1))
                                        for m in self._methods))

    def scan(self):
        """The scans beside aba"""
        lines, aba = [], errors(self._rows, "aba")
        for method in ("scan", "scan-two-pass"):
            ratios = {key: error / max(aba[key], 1e-14)
                      for key, error in errors(self._rows, method).items() if key in aba}
            where = max(ratios, key=ratios.get)
            lines.append((f"`{method}`", len(ratios), sum(x > 5 for x in ratios.values()),
                          f"{ratios[where]:.2g}", "`{}`, {} bodies, `{}`".format(*where)))
        return table("method|cells|above five times `aba`|most|where", lines)

    def floor(self):
        """aba refined once, the best that double gives, over the floor"""
        panels = {}
        for r in some(self._good, method="aba", refine=1):
            panels.setdefault((r.rhs, r.bodies), {})[r.mechanism] = r.error / r.floor
        return table("right-hand side|bodies|mechanisms|within 3 floors|most|where", (
            (*key, len(ratios), sum(x <= 3 for x in ratios.values()),
             f"{max(ratios.values()):.2g}", f"`{max(ratios, key=ratios.get)}`")
            for key, ratios in sorted(panels.items())))

    def peers(self):
        """Peers beside crba, where both answered: geometric mean of the ratio of errors"""
        lines = []
        for peer, name in (("kdl", "mechanisms"), ("kdl", "robots"), ("mujoco", "mechanisms"),
                           ("mujoco", "robots")):
            crba, own = (errors(self._charts[name], method) for method in ("crba", peer))
            keys = [key for key in own if crba.get(key, 0) > 0 < own[key]]
            if keys:
                mean = exp(sum(log(own[key] / crba[key]) for key in keys) / len(keys))
                lines.append((peer, f"`{name}`", len(keys), f"{mean:.2g}",
                              f"{max(own[key] for key in keys):.1e}"))
        return table("peer|run|cells|error over that of `crba`|largest error", lines)

    def order(self):
        """The order that the paper states: error of tfa over that of others, median of the
        mechanisms without extreme masses and radii"""
        tfa = {key: error for key, error in errors(self._rows, "tfa").items()
               if key[0] not in EXTREME and error > 0}

        def cell(method, size, side):
            own = errors(self._rows, method)
            ratios = [tfa[key] / own[key] for key in tfa
                      if key[1:] == (size, side) and own.get(key, 0) > 0]
            return "-" if not ratios else f"{median(ratios):.2g}" if median(ratios) < 10 else \
                f"{median(ratios):.0f}"

        sizes = sorted({size for _, size, _ in tfa})
        lines = [[f"`{m}`", *(" ".join(cell(m, size, side) for size in sizes)
                              for side in ("qdd", "tau"))]
                 for m in ("cfa", "dca", "scan", "aba", "crba")]
        return table(["`tfa` over", "`qdd`", "`tau`"],
                     [("bodies", *[" ".join(map(str, sizes))] * 2), *lines])

    def precision(self):
        """Precisions of two methods"""
        rows = [r for r in self._charts["precision"] if r.method in ("aba", "tfa")
                and re.match("ok$|fallback$|E_", r.status)]

        def cell(**fields):
            found = some(rows, **fields)
            return "-" if not found else found[-1].status if found[-1].status != "ok" else \
                f"{found[-1].error:.0e}"

        return table("precision|method|qdd: 0 steps|1 step|2 steps|tau: 0 steps|1 step|2 steps", (
            (p, f"`{m}`", *(cell(precision=p, method=m, rhs=side, refine=steps)
                            for side in ("qdd", "tau") for steps in range(3)))
            for p, m in unique((r.precision, r.method) for r in rows)))

    def estimates(self):
        form = r"Of (\d+) estimates the least is (\S+) times.* broken in (\d+) cells.*: (\d+)\."
        return table("right-hand side|estimates|least over the true error|below 1/30 of it|"
                     "errors above 1e-6 estimated below 1e-7", (
                         (side, *re.fullmatch(form, atlas.fact("all maps")).groups())
                         for side, atlas in self._atlas.items()))

    def _failures(self):
        """Of each map: its axis, from where on methods fail alone, and refined once"""
        head = self._atlas["qdd"].head
        for name, axis in ((name, text.partition("; value: ")[2]) for name, text in head):
            if axis:
                yield axis, *(re.sub(r"^.*?: |\. Never: .*|(?<=none)\.", "", text)
                              for other, text in head if other == name
                              and re.match("Alone,|Refined once, still:", text))

    def fails_alone(self):
        return table("axis|alone|refined once", self._failures())

    def fails(self):
        return table("axis|refined once, from", (
            (axis, re.sub(r"from (\S+) on", r"\1:", refined))
            for axis, _, refined in self._failures()))

    def _services(self):
        for side, atlas in self._atlas.items():
            counts = [sum(getattr(r, name) for r in some(atlas, mode="service"))
                      for name in ("own", "fallback", "refused", "unsaid")]
            yield side, sum(counts[:3]), *counts

    def service_table(self):
        return table("right-hand side|requests|answered by the method asked for|by another one|"
                     "refused by name|wrong by more than 1e-4 without an estimate",
                     self._services())

    def service(self):
        return ("Of {} default requests {} were answered by the method asked for, {} by another "
                "one,\n{} refused by name; {} were wrong by more than 1e-4 without an estimate.\n"
                ).format(*map(sum, list(zip(*self._services()))[1:]))


def maps(atlas):
    """Sentences of the atlas: a list for each map and right-hand side"""
    form = re.compile("Alone|Refined once|From|Largest|The service|Its largest")
    for side in SIDES:
        head = [(name, text) for name, text in atlas[side].head if form.match(text)]
        for name in unique(name for name, _ in head):
            yield f"{name}-{side}", "".join(f"* {text}\n" for other, text in head if other == name)


def write(work, one):
    tables = Tables(work, one)
    blocks = {name.replace("_", "-"): getattr(tables, name)()
              for name in vars(Tables) if not name.startswith("_")}
    blocks |= dict(maps(tables._atlas)) | test_tables.make(work)
    for name, text in blocks.items():
        if text:
            (work / "blocks" / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]), int(sys.argv[2]))
