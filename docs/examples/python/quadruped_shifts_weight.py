# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A quadruped stands on four points, moves its trunk over three of them and lifts the fourth foot:
torques at rest, with motors in the legs and none at the base, and the forces of the ground.

    python3 quadruped_shifts_weight.py [config/robots/quadruped.urdf]
"""
# %% Robot: each foot a point on the ground, which can only push
import sys

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/quadruped.urdf"
ground = {"FL": [0.2, 0.14], "FR": [0.2, -0.14], "RL": [-0.2, 0.14], "RR": [-0.2, -0.14]}  # m
contacts = [
    {
        "name": foot,
        "first": {"xyz": [*place, 0]},  # in the world
        "second": {"link": foot + "_foot"},
        "hold": "point",
        "unilateral": True,
    }
    for foot, place in ground.items()
]
model = tf.Model(path, base="floating", constraints=contacts)
robot = tf.Workspace(model)
weight = model.summary.total_mass * 9.80665  # N


# %% A posture with all feet on the ground and the trunk there: legs from trunk and feet
def stand(x, y, z=0.3):
    pose = np.array([x, y, z, 0, 0, 0, 1])
    bent = np.tile([0, 0.8, -1.6], 4)  # rad: hip roll, hip pitch, knee; where the search begins
    return robot.close_loops(bent, base_pose=pose)


def hold(posture, feet):
    """Torques at rest, and the vertical forces of the ground."""
    rest = np.zeros(model.v_count)
    reply = robot.constrained_inverse_dynamics(
        posture.q, rest, rest, base_pose=posture.base_pose, constraints=feet
    )
    return reply, reply.constraint_wrenches.reshape(-1, 6)[:, 2]


# %% Weight on four feet: the ground gives what the base, without motor, needs
worst = 0.0
for x, y in [(0, 0), (-0.03, 0.03), (-0.06, 0.04)]:
    posture = stand(x, y)
    reply, up = hold(posture, list(ground))
    print(f"trunk at {x:5.2f} {y:5.2f} m:", *(f"{foot} {f:6.1f} N" for foot, f in zip(ground, up)))
    worst = max(worst, posture.position, abs(up.sum() - weight), np.abs(reply.base_wrench).max())

# %% Three feet: possible once the centre of mass is above their triangle
lifted = [foot for foot in ground if foot != "FR"]
for x, y in [(0, 0), (-0.06, 0.04)]:
    posture = stand(x, y)
    reply, up = hold(posture, lifted)
    pulls = bool(reply.flags & tf.ANSWER_PULLS)
    print(f"trunk at {x:5.2f} {y:5.2f} m:", *(f"{foot} {f:6.1f} N" for foot, f in zip(lifted, up)))
    print("  a foot would pull" if pulls else f"  at most {np.abs(reply.tau).max():.1f} N m")
    worst = max(worst, abs(up.sum() - weight), np.abs(reply.base_wrench).max())

# %% With these torques the robot stays, lifted foot and all
still = robot.constrained_dynamics(
    posture.q, np.zeros(model.v_count), reply.tau, base_pose=posture.base_pose, constraints=lifted
)
worst = max(worst, np.abs(still.qdd).max(), np.abs(still.base_acceleration).max())
print(f"worst of weight, base wrench and acceleration: {worst:.1e}")
