# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""All pictures of docs/accuracy.md and of the README, from the files that make.py measures:

    PYTHONPATH=BUILD/python /usr/bin/python3 docs/charts/pictures.py WORK FOLDER BODIES

BODIES: of the chains of atlas.png. Other arguments: pictures to draw, in place of all.
"""
import pathlib
import sys

import pictures_arm
import pictures_depth
import pictures_error
import pictures_front
import pictures_time
from frame import COMMAND
from rows import Rows
from totalforce_tools import command, style


def draw(work, folder, bodies, names=()):
    def rows(name):
        return Rows(next((work / name).glob("*.csv")))

    origin = command.machine()[0], command.today(), COMMAND
    makers = {
        "hero": lambda: pictures_time.hero(rows("hero")),
        "lambda": lambda: pictures_time.lambda_inv(rows("lambda")),
        "cores": lambda: pictures_time.cores(rows("cores")),
        "front": lambda: pictures_front.fronts(rows("front")),
        "single": lambda: pictures_time.single(rows("single")),
        "drift": lambda: pictures_error.drift(rows("drift-arm"), rows("drift-thin")),
        "singular": lambda: pictures_arm.singular(*origin),
        "ellipsoid": lambda: pictures_arm.ellipsoid(*origin),
        "bodies": lambda: pictures_error.bodies(rows("mechanisms")),
        "atlas": lambda: pictures_error.atlas(rows("atlas-qdd"), bodies),
    }
    if (work / "depth").exists():
        makers["depth"] = lambda: pictures_depth.depth(rows("depth"))
    for name in names or makers:
        kind = "png" if name == "atlas" else "svg"
        style.save(makers[name](), folder, name, [kind], dpi=192)


if __name__ == "__main__":
    draw(*map(pathlib.Path, sys.argv[1:3]), int(sys.argv[3]), sys.argv[4:])
