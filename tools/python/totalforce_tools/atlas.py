# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce atlas`: failures of methods, and the answers of the service there."""
import sys
from itertools import groupby, product
from typing import NamedTuple

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools import atlas_rows, atlas_words, cases, command
from totalforce_tools.command import Option, each, whole, word


class Map(NamedTuple):
    """A mechanism of which one option varies. Values are evenly spaced in their logarithm; on an
    axis that begins at 0 they are the squares of equal steps, close together where the chain is
    straight."""

    mechanism: str
    option: str
    first: float
    last: float
    axis: str
    what: str

    def value(self, point, points):
        way = point / (points - 1)
        if self.first == 0.0:
            return self.last * way * way
        return self.first * (self.last / self.first) ** way


MAPS = {
    "ratio": Map("alternating", "ratio", 1.0, 1e12, "mass ratio of neighbours",
                 "every second body is heavier"),
    "heavy-tip": Map("heavy-tip", "ratio", 1.0, 1e12, "mass of the tip / mass of a body",
                     "the last body is heavier"),
    "light-heavy": Map("light-heavy", "ratio", 1.0, 1e12, "mass ratio of the halves",
                       "the outboard half is heavier"),
    "thin": Map("thin", "radius", 1.0, 1e-6, "radius of the rods / length", "thin rods"),
    "taper": Map("taper", "taper", 1.0, 1e-12, "mass of the tip / mass of the root",
                 "masses fall from root to tip"),
    "curl": Map("helix", "curl", 0.0, 1.0, "bend (1: 21° a joint)", "from straight to a helix"),
}
HEAD = f"""\
# states of each cell and seed: %d, seeds: %d from %d on
# error: relative 2-norm error of qdd to aba in f128, median over the seeds of the median over the \
states; error_low, error_high: of the least and the worst seed; worst: largest of all
# own, fallback, refused: states answered by the method, by answered_by, by status
# estimate: as replied, median; error_over_estimate: largest among errors above \
{atlas_rows.ROUNDING:g}; silent: states with an error above 1e-6 estimated below 1e-7; unsaid: \
states wrong by more than {atlas_rows.FAILED:g} without an estimate; same_as: an earlier method \
with the same answers, to the last bit
# floor: change of the exact answer when every number of the robot and of the request changes in \
the last bit, and sines and cosines are rounded to double; at least 2^-53
""" + "".join(f"# mode {name}: {what}\n" for name, what in atlas_rows.MODES.items())
AFTER = ("Maps:\n" + "".join(f"  {name}: {m.what}; {m.axis}\n" for name, m in MAPS.items())
         + "\nModes, a row of each for every cell:\n"
         + "".join(f"  {name}: {what}\n" for name, what in atlas_rows.MODES.items())
         + "\nExit status 1: an estimate was below a thirtieth of the true error, or an error "
         "above 1e-6 was estimated below 1e-7.")


def read_sizes(text, before):
    sizes = each(whole(1, 16384), 16)(text, before)
    for smaller, size in zip(sizes, sizes[1:]):
        if size <= smaller:
            raise ValueError(f"'{size}' is not larger than the size before it")
    return sizes


COMMAND = command.Command(
    "atlas",
    "Maps the error of every method over the cause of its failures, and over the number of bodies, "
    "against articulated bodies in quadruple precision.",
    [Option("maps", None, "MAP,...", "Maps (all)", each(word(tuple(MAPS)), len(MAPS), twice=True)),
     Option("points", None, "N", "Values along the axis (13)", whole(2, 25), 13),
     Option("bodies", "n", "N,...", "Sizes (2,4,8,16,32,64,128,256)", read_sizes),
     Option("methods", "M", "METHOD,...", "Methods (all of forward dynamics)",
            each(cases.read_method, 32)),
     Option("rhs", None, "qdd|tau|gravity", "Right-hand side (qdd)",
            word(cases.RHS), "qdd"),
     Option("states", None, "N", "Random states of each seed (3)", whole(1, 16), 3),
     Option("seed", "s", "N", "Of the random numbers (1)", whole(0, 2**64 - 1), 1),
     Option("seeds", None, "N", "Seeds in each cell, from --seed on: other mechanisms and states "
            "(3)", whole(1, 16), 3),
     Option("json", None, None, "JSON, one row a line, in place of CSV"),
     Option("html", None, "FILE", "Write a self-contained page there: all maps, numbers under the "
            "pointer"),
     Option("output", "o", "FOLDER", "Write atlas.csv, SVG and PNG there")],
    AFTER, words={"MAP": list(MAPS), "METHOD": cases.FORWARD})


def measure_seed(given, name, point, bodies, seed):
    """All methods and modes of a cell, for one seed"""
    row = (name, point, MAPS[name].value(point, given.points), bodies, given.rhs)
    changes = {MAPS[name].option: row[2]}
    source = _totalforce._mechanism(MAPS[name].mechanism, bodies, seed=seed, **changes)
    case = cases.Case(name, source, seed)
    case.bodies = bodies
    solver = tf.Workspace(case.model, precision="f64", methods=list(cases.METHODS))
    states = cases.States(case, "forward_dynamics", given.rhs, given.states)
    return [atlas_rows.measure(atlas_rows.Row(*row, method, mode), states, solver)
            for method, mode in product(given.methods, atlas_rows.MODES)]


def measure_all(given):
    """@return rows, and whether all cells have theirs. Cells that cannot be mapped are told and
    left out."""
    rows, whole_atlas = [], True
    progress = command.Progress(len(given.maps) * len(given.bodies) * given.points, "cells")
    for name, bodies, point in product(given.maps, given.bodies, range(given.points)):
        progress.step(name)
        try:
            seeds = [measure_seed(given, name, point, bodies, given.seed + k)
                     for k in range(given.seeds)]
        except tf.Error as error:
            print(f"totalforce atlas: {name} {MAPS[name].value(point, given.points):g}, {bodies} "
                  f"bodies: exact answer: {error}", file=sys.stderr)
            whole_atlas = False
            continue
        cell = [atlas_rows.combine(same) for same in zip(*seeds)]
        atlas_rows.find_same(cell)
        rows += cell
    progress.clear()
    return rows, whole_atlas


def by_map(rows):
    return [(name, list(some)) for name, some in groupby(rows, key=lambda row: row.map)]


def print_head(out, given, rows):
    command.print_head(out, given.command)
    out.write(HEAD % (given.states, given.seeds, given.seed))
    for name, some in by_map(rows):
        print(f"# {name}: {MAPS[name].what}; value: {MAPS[name].axis}", file=out)
        for sentence in atlas_words.of_map(some):
            print(f"# {name}: {sentence}", file=out)
    print("# all maps:", atlas_words.of_estimates(atlas_words.Summary(rows)), file=out)
    print(",".join(atlas_rows.FIELDS), file=out)


def write_rows(out, given, rows):
    if given.json:
        atlas_rows.print_json(out, rows)
    else:
        print_head(out, given, rows)
        atlas_rows.print_csv(out, rows)
    out.flush()
    if given.output:
        out.close()


def draw(given, rows, page):
    """matplotlib is loaded only for pictures."""
    origin = (command.machine()[0], command.today(), given.command)
    maps = [(name, MAPS[name], some) for name, some in by_map(rows)]
    if given.output and rows:
        from totalforce_tools import atlas_pictures

        for entry in maps:
            atlas_pictures.draw(given.output, *entry, *origin)
    if page:
        from totalforce_tools import atlas_page

        with page:
            atlas_page.write(page, maps, *origin)


def main(argv):
    given = COMMAND.parse(argv)
    given.maps = [name for name in MAPS if name in (given.maps or MAPS)]
    given.bodies = given.bodies or [2**k for k in range(1, 9)]
    given.methods = given.methods or cases.FORWARD
    page = open(given.html, "w", encoding="utf-8") if given.html else None
    out = command.open_rows("atlas", given.output, given.json)
    rows, whole_atlas = measure_all(given)
    write_rows(out, given, rows)
    draw(given, rows, page)
    if not whole_atlas:
        return command.FAILED
    if atlas_words.Summary(rows).kept:
        return command.GOOD
    print("totalforce atlas: a promise about estimates is broken", file=sys.stderr)
    for text in atlas_words.broken_promises(rows):
        print(f"totalforce atlas: {text}", file=sys.stderr)
    return command.UNMET
