# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The demonstration's pictures, SVG and PNG, of what it wrote into FOLDER:

    PYTHONPATH=build/release/python:docs/charts /usr/bin/python3 tools/demo.d/pictures.py FOLDER
"""
import pathlib
import sys

import numpy as np

from pictures_arm import ellipsoid
from totalforce_tools import command, style

ORIGIN = command.machine()[0], command.today(), "tools/demo"
STEP = 0.1  # s between figures; every fifth is drawn


def joints(folder):
    """Angles of the arm over time"""
    motion = np.loadtxt(folder / "arm_motion.dat")
    time, angles = motion[:, 0], motion[:, 3:]
    swing = np.ptp(angles, axis=0).max()
    figure, axes = style.picture(
        f"Torques at 1 kHz swing the arm's joints through up to {swing:.1f} rad", *ORIGIN,
        size=(style.WIDTH, 4.6))
    for k, (angle, colour) in enumerate(zip(angles.T, style.SERIES)):
        axes[0, 0].plot(time, angle, ["-", "--"][k % 2], color=colour, label=f"joint {k + 1}")
    axes[0, 0].set(xlabel="time (s)", ylabel="joint angle (rad)")
    style.key(figure, 7)
    return figure


def motion(folder, robot):
    """Stick figures from the side and from the front"""
    text = (folder / f"{robot}_figures.dat").read_text().strip()
    figures = [[np.fromstring(bone, sep=" ").reshape(-1, 3) for bone in some.split("\n\n")]
               for some in text.split("\n\n\n")]
    picture, axes = style.picture(
        f"Torques at 1 kHz move the {robot} for {STEP * len(figures):.0f} s", *ORIGIN, columns=2,
        size=(style.WIDTH, 5.4), sharey=True,
        notes=[f"A figure every {5 * STEP} s, later ones darker, the last one blue"])
    last = len(figures) - 1
    for axis, side, words in zip(axes[0], (0, 1), ("x (m), from the side",
                                                   "y (m), from the front")):
        for k in [*range(0, last, 5), last]:
            colour = style.SERIES[0] if k == last else str(0.82 - 0.6 * k / last)
            for bone in figures[k]:
                axis.plot(bone[:, side], bone[:, 2], "o-", color=colour, ms=3 * (k == last), lw=2)
        axis.set(aspect="equal", adjustable="datalim", xlabel=words)
    axes[0, 0].set_ylabel("z (m)")
    return picture


if __name__ == "__main__":
    output = pathlib.Path(sys.argv[1])
    for name, drawn in (("arm_joints", joints(output)), ("arm_motion", motion(output, "arm")),
                        ("humanoid_motion", motion(output, "humanoid")),
                        ("ellipsoid", ellipsoid(*ORIGIN))):
        style.save(drawn, output, name)
