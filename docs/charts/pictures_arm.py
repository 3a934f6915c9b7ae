# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Pictures of arms, computed here: torques beside singularities, the ellipsoid of Lambda^-1."""
import pathlib

import numpy as np

import totalforce as tf
from totalforce_tools import style
from totalforce_tools.web_robot import Figure

ROBOTS = pathlib.Path(__file__).resolve().parents[2] / "config/robots"
DISTANCES = 10 ** np.linspace(-8, -0.3, 241)
PATHS = {"wrist": (4, 0.0), "elbow": (2, 0.0),
         "shoulder": (1, 0.94845039650633328)}  # the wrist is above the first axis


def largest_torques(path, rank_loss):
    """Of a task on arm6, along a path of one joint that begins in a singularity"""
    solver = tf.Workspace(tf.Model(ROBOTS / "arm6.urdf"))
    joint, start = PATHS[path]
    for distance in DISTANCES:
        q = [0.2, -0.9, 1.1, 0.35, 0.9, -0.15]
        q[joint] = start + distance
        yield abs(solver.task_torques(q, acceleration={"tool0": [0.3, -0.2, 1, 0.5, -1, 0.7]},
                                      rank_loss=rank_loss).tau).max()


def singular(*origin):
    torques = {(path, policy): list(largest_torques(path, policy))
               for policy in ("default", "truncate") for path in PATHS}
    damped, cut = (max(max(torques[path, policy]) for path in PATHS)
                   for policy in ("default", "truncate"))
    figure, axes = style.picture(
        f"Damped torques stay below {np.ceil(damped):.0f} N m through singularities, the "
        f"pseudoinverse reaches {cut:.0e} N m", *origin, size=(style.WIDTH, 4.2),
        notes=["Largest joint torque of one task (1 m/s², 1 rad/s²) on arm6"])
    axis = axes[0, 0]
    for (path, policy), values in torques.items():
        axis.plot(DISTANCES, values, {"wrist": "-", "elbow": "--", "shoulder": ":"}[path],
                  color="#CC3311" if policy == "truncate" else "#1B9E77",
                  label=f"{path}, {'default: damp' if policy == 'default' else policy}")
    axis.set(xscale="log", yscale="log", xlim=(1e-8, 0.5),
             xlabel="distance from the singularity (rad)", ylabel="torque (N m)")
    axis.legend()
    return figure


POSTURES = {"folded": [0, -0.2, 0, -2.2, 0, 2.0, 0], "bent": [0, 0.5, 0, -1.4, 0, 1.2, 0],
            "reaching": [0, 1.0, 0, -0.25, 0, 0.2, 0]}
SCALE = 0.18  # m for 1/kg
AZIMUTH, ELEVATION = np.radians([-60, 20])
VIEW = np.array([[-np.sin(AZIMUTH), np.cos(AZIMUTH), 0],
                 [-np.cos(AZIMUTH) * np.sin(ELEVATION), -np.sin(AZIMUTH) * np.sin(ELEVATION),
                  np.cos(ELEVATION)]])


def draw_posture(axis, figure, motion):
    """Bones, the ellipsoid of accelerations by all forces of 1 N at the tip, its axes"""
    points, tip = motion["positions"].reshape(-1, 3) @ VIEW.T, motion["tips"][0]
    for frame, parent in enumerate(figure.parents):
        if parent >= 0:
            axis.plot(*points[[parent, frame]].T, "o-", color="#555555", lw=4, ms=6)
    centre = points[tip["frame"]]
    across, sizes, _ = np.linalg.svd(VIEW @ tip["lambda_inv"].reshape(3, 3))
    turn = np.linspace(0, 2 * np.pi, 73)
    outline = centre + SCALE * (np.array([np.cos(turn), np.sin(turn)]).T * sizes) @ across.T
    axis.fill(*outline.T, fc="#56B4E960", ec=style.SERIES[0], zorder=3)
    for size, vector in zip(tip["values"], tip["vectors"].reshape(3, 3)):
        end = SCALE * size * VIEW @ vector
        axis.plot(*zip(centre - end, centre + end), lw=1, color=style.SERIES[1], zorder=4)


def ellipsoid(*origin):
    figure = Figure(tf.Model(ROBOTS / "arm7.urdf"))
    motions = [figure.motion({"q": np.array(q, float)}) for q in POSTURES.values()]
    masses = [(1 / m["tips"][0]["values"][0], 1 / m["tips"][0]["values"][2]) for m in motions]
    picture, axes = style.picture(
        "Pushed at its tool, the reaching arm weighs {:.1f} kg one way and {:.0f} kg another"
        .format(*masses[-1]), *origin, columns=3, size=(style.WIDTH, 3.6), notes=[
            "Λ⁻¹, linear block: acceleration of the tool by a force of 1 N in every direction; "
            "mass along an axis: 1 / half axis. Orthographic view: azimuth -60, elevation 20 "
            f"degrees; {SCALE} m for 1/kg"])
    for axis, name, motion, mass in zip(axes[0], POSTURES, motions, masses):
        draw_posture(axis, figure, motion)
        axis.set_title(f"{name}: {mass[0]:.1f} to {mass[1]:.1f} kg", loc="center")
        axis.set(aspect="equal", xlim=(-0.15, 0.95), ylim=(-0.04, 0.72))
        axis.axis("off")
    return picture
