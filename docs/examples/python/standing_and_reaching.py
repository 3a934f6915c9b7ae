# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Task torques with constraints: a humanoid stands on two feet, and its left hand accelerates as
asked. First the motion: contacts and the task together, as constraints. Then the torques of that
motion, with the contacts alone, which are what the world really holds.

    python3 standing_and_reaching.py [config/robots/humanoid.urdf]
"""
# %% Robot: two soles welded to the ground, and the task, a point of the hand
import sys

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/humanoid.urdf"
feet, hand = ["left_foot", "right_foot"], "left_palm"
sides = {"left_foot": 0.1, "right_foot": -0.1}  # m
constraints = [
    {"name": foot, "first": {"xyz": [0, y, 0]}, "second": {"link": foot}, "hold": "weld"}
    for foot, y in sides.items()
]
constraints.append({"name": "task", "second": {"link": hand}, "hold": "point"})
model = tf.Model(path, base="floating", constraints=constraints)
robot = tf.Workspace(model)

# %% A posture: knees bent, both soles on the ground, the base above them
bent = {"hip_pitch": -0.3, "knee": 0.6, "ankle_pitch": -0.3, "elbow": -1.0}  # rad
begin = [sum(bent[x] for x in bent if x in name) for name in model.joint_names]
posture = robot.close_loops(
    begin, base_pose=[0, 0, 1, 0, 0, 0, 1], constraints=feet, base_is_free=True
)
q, pose = posture.q, posture.base_pose
print(f"pelvis {pose[2]:.3f} m above the ground, soles off by {posture.position:.1e} m or rad")

# %% Motion: the hand as wanted, the feet still; of all such motions the one nearest, by Gauss's
# principle, to that of the torques that hold the robot: rest
rest = np.zeros(model.v_count)
wanted = np.array([1.0, 0.5, 2.0])  # m/s^2, axes of the world
hold = robot.constrained_inverse_dynamics(q, rest, rest, base_pose=pose, constraints=feet)
motion = robot.constrained_dynamics(
    q, rest, hold.tau, base_pose=pose, constraint_acceleration={"task": [*wanted, 0, 0, 0]}
)

# %% Torques of that motion: legs and arms drive it, the ground gives what the base needs
moving = {"base_pose": pose, "base_acceleration": motion.base_acceleration}
torques = robot.constrained_inverse_dynamics(q, rest, motion.qdd, constraints=feet, **moving)
up = torques.constraint_wrenches.reshape(-1, 6)[:, 2]
print("ground:", *(f"{foot} {f:.1f} N" for foot, f in zip(feet, up)))
unheld = np.abs(torques.base_wrench).max()
print(f"largest torque {np.abs(torques.tau).max():.1f} N m, left to the base {unheld:.1e}")

# %% Check: with these torques and the feet alone the hand accelerates as asked
done = robot.constrained_dynamics(q, rest, torques.tau, base_pose=pose, constraints=feet)
want = ["jacobian", "bias_acceleration"]
tip = robot.kinematics(q, rest, base_pose=pose, tips=hand, rows="point", want=want)
got = tip.jacobian @ np.concatenate([done.base_acceleration, done.qdd]) + tip.bias_acceleration
print("the hand:", np.round(got, 6), "m/s^2")
worst = max(posture.position, unheld, np.abs(got - wanted).max())
print(f"worst of soles, base wrench and task: {worst:.1e}")
