# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Payload and joint friction of an arm from 50 states: torques are linear in the ten parameters of
the load and in damping and friction of each joint, so that one least-squares problem finds all.

    python3 identification.py [arm.urdf [tip]]
"""
# %% Robot as the file has it, and the real one: a load at the tool, damping and friction
import sys

import numpy as np

import totalforce as tf

file = sys.argv[1] if len(sys.argv) > 1 else "config/robots/arm7.urdf"
tip = sys.argv[2] if len(sys.argv) > 2 else "tool0"
model = tf.Model(file)
arm = tf.Workspace(model)
load = {"link": tip, "mass": 1.7, "com": [0.02, -0.03, 0.08], "inertia": [4e-3, 1e-4, 0, 5e-3, 0, 3e-3]}
n = model.v_count
damping, friction = np.linspace(1.5, 0.3, n), np.linspace(2.0, 0.5, n)  # N m s, N m

# %% 50 states with their accelerations, and the torques that the real arm takes for them
random = np.random.default_rng(4)
q, v, qdd = (scale * random.uniform(-1, 1, (50, n)) for scale in (2.0, 1.5, 5.0))
reply = arm.regressor(q, v, qdd, tips=tip)
_, speed, sign = np.moveaxis(reply.joint_regressor, 2, 0)
measured = arm.inverse_dynamics(q, v, qdd, payload=load).tau + damping * speed + friction * sign

# %% Least squares: columns of the load, then of damping and of friction
diagonal = np.eye(n)
columns = [reply.regressor, diagonal * speed[:, None, :], diagonal * sign[:, None, :]]
Y = np.concatenate(columns, axis=2).reshape(50 * n, -1)


def identify(tau):
    """Mass, centre of mass, inertia about it, damping, friction."""
    rest = tau - arm.inverse_dynamics(q, v, qdd).tau
    p = np.linalg.lstsq(Y, rest.ravel(), rcond=1e-10)[0]
    mass, com = p[0], p[1:4] / p[0]
    xx, xy, xz, yy, yz, zz = p[4:10]
    about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    inertia = about_origin - mass * (com @ com * np.eye(3) - np.outer(com, com))
    return mass, com, inertia[np.triu_indices(3)], p[10 : 10 + n], p[10 + n :]


# %% Without noise every digit comes back; with it, the error of each
true = (load["mass"], load["com"], load["inertia"], damping, friction)
found = identify(measured)
worst = max(np.abs(np.subtract(x, y)).max() for x, y in zip(found, true))
noisy = identify(measured + 0.05 * random.standard_normal(measured.shape))  # N m
for name, unit, x, y in zip(
    ("mass", "centre", "inertia", "damping", "friction"), ("kg", "m", "kg m^2", "N m s", "N m"), noisy, true
):
    print(f"{name:9} {np.round(x, 4)} {unit}, error {np.abs(np.subtract(x, y)).max():.1e}")
rank = np.linalg.matrix_rank(Y, 1e-10 * np.linalg.norm(Y))
if rank < Y.shape[1]:
    print(f"{rank} of {Y.shape[1]} parameters: the tip's motion does not tell the load's ten apart")
    worst = max(np.abs(np.subtract(x, y)).max() for x, y in zip(found[3:], true[3:]))
print(f"largest error without noise: {worst:.1e}")
