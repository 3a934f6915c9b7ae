# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Operational-space control: the tool of any arm goes to a goal, its pose in another posture, as a
mass on a spring and a damper would; torques in the null space still the elbow. The arm is simulated
at 1 kHz.

    python3 operational_space_control.py [config/robots/arm7.urdf [TOOL]]
"""
# %% Robot and goal
import sys

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/arm7.urdf"
tool = sys.argv[2] if len(sys.argv) > 2 else "tool0"
model = tf.Model(path)
controller = tf.Workspace(model)
simulator = tf.Workspace(model)

q = np.where(np.arange(model.q_count) % 2, 0.6, -0.3)  # rad: bent joints
v = np.zeros(model.v_count)  # rad/s
goal = controller.kinematics(q + 0.1, tips=tool, want="pose").pose[0]  # x y z, quaternion x y z w


# %% Desired acceleration of the tool, linear then angular, in axes of the world
def turn(goal, pose):
    """Rotation vector from the attitude of a pose to that of the goal, rad, for small angles."""
    (a, d), (b, e) = (goal[3:6], goal[6]), (pose[3:6], pose[6])
    vector, real = e * a - d * b + np.cross(b, a), d * e + a @ b
    return 2 * np.copysign(1, real) * vector


def impedance(goal, pose, twist, stiffness=100.0):  # 1/s^2
    damping = 2 * np.sqrt(stiffness)  # 1/s: critical
    offset = np.concatenate([goal[:3] - pose[:3], turn(goal, pose)])
    return stiffness * offset - damping * twist


# %% Torques: those of the task, and posture torques that the tool does not feel. Damping of the
# momentum M v is stable on every arm, damping of v is not where joints are light
def control(q, v):
    here = controller.bias(q, v, tips=tool, want=["pose", "twist", "generalised_momentum"])
    acceleration = impedance(goal, here.pose[0], here.twist[0])
    posture = here.gravity - 5 * here.generalised_momentum  # 1/s
    task = controller.task_torques(
        q, v, {tool: acceleration}, posture_torques=posture, rank_loss="damp"
    )
    return task.tau, here.pose[0]


# %% Three seconds
dt = 1e-3  # s
for step in range(3001):
    tau, pose = control(q, v)
    if step % 500 == 0:
        distance = np.linalg.norm(goal[:3] - pose[:3])
        angle = np.linalg.norm(turn(goal, pose))
        print(f"{step * dt:4.1f} s: {distance * 1e3:8.4f} mm, {np.degrees(angle):7.4f} degrees")
    v = v + dt * simulator.forward_dynamics(q, v, tau).qdd
    q = q + dt * v
print(f"error after 3 s: {distance * 1e3:.2e} mm")
