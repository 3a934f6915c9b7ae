# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Two hands hold a bar: a weld between the palms, the bar a load on one of them. Torques that hold
it, torques that squeeze it and move nothing, and what the hands carry while the arms swing.

    python3 two_arms_hold_a_bar.py [config/robots/humanoid.urdf]
"""
# %% Robot: the palms are 0.3 m apart along their y
import sys

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/humanoid.urdf"
left, right, length = "left_palm", "right_palm", 0.3  # m
grip = {
    "name": "bar",
    "first": {"link": left},
    "second": {"link": right, "xyz": [0, length, 0]},  # the left palm, as the right one has it
    "hold": "weld",
}
inertia = [0.015, 0, 0, 4e-4, 0, 0.015]  # kg m^2: thin, along y
bar = {"link": left, "mass": 2.0, "com": [0, -length / 2, 0], "inertia": inertia}
model = tf.Model(path, tips=[left, right], constraints=grip, payload=bar)
robot = tf.Workspace(model)

# %% A posture in which the palms are as the bar wants, near bent elbows; the waist stays
bent = {"shoulder_pitch": -0.3, "elbow": -1.2}  # rad
begin = [sum(bent[x] for x in bent if x in name) for name in model.joint_names]
waist = [name for name in model.joint_names if name.startswith("waist")]
closed = robot.close_loops(begin, locked=waist)
print(f"{closed.iterations} iterations, {closed.position:.1e} m or rad open")

# %% Torques at rest: the smallest ones, which decide how the hands share the bar
rest = np.zeros(model.v_count)
hold = robot.constrained_inverse_dynamics(closed.q, rest, rest)
print(f"holds with at most {np.abs(hold.tau).max():.2f} N m; the right hand carries", end=" ")
print(np.round(hold.constraint_wrenches[:3], 2), "N")

# %% Squeeze: a force between the palms is internal: motors and bar feel it, nothing moves
palms = robot.kinematics(closed.q, tips=[left, right], rows="point", want=["jacobian", "pose"])
along = palms.pose[0][:3] - palms.pose[1][:3]
force = 20.0 * along / np.linalg.norm(along)  # N, on the right palm; the opposite on the left one
tau = hold.tau + palms.jacobian[3:].T @ force - palms.jacobian[:3].T @ force
squeezed = robot.constrained_dynamics(closed.q, rest, tau)
more = squeezed.constraint_wrenches - hold.constraint_wrenches
print(f"squeezed with 20 N: the bar pushes back with {np.linalg.norm(more[:3]):.6f} N")
print(f"largest acceleration: {np.abs(squeezed.qdd).max():.1e} rad/s^2")

# %% Swing: velocities that the bar admits, nearest to those of one elbow; free fall of both arms
v = np.zeros(model.v_count)
v[model.joint_names.index("left_elbow_joint")] = 2.0  # rad/s
moving = robot.close_loops(closed.q, v, locked=[])
fall = robot.constrained_dynamics(moving.q, moving.v, rest)
elbows = [moving.v[model.joint_names.index(side + "_elbow_joint")] for side in ("left", "right")]
print("elbows", np.round(elbows, 3), "rad/s; the right hand carries", end=" ")
print(np.round(fall.constraint_wrenches[:3], 2), "N")
worst = max(
    closed.position,
    moving.velocity,
    abs(np.linalg.norm(more[:3]) - 20),
    np.abs(squeezed.qdd).max(),
    np.abs(fall.constraint_residual).max(),
)
print(f"worst of closure, squeeze, rest and residual: {worst:.1e}")
