# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A leg with rods, as Cassie's: encoders measure six of its eleven joints, the loops give the rest;
then torques that hold it, and accelerations under the constraints.

    python3 leg_with_rods.py [config/robots/loops/rod_leg.urdf config/robots/loops/rod_leg.yaml]
"""
# %% Robot: a file beside the URDF has the loops and the motors
import sys

import numpy as np

import totalforce as tf

files = sys.argv[1:] or ["config/robots/loops/rod_leg.urdf", "config/robots/loops/rod_leg.yaml"]
model = tf.Model(files[0], constraints=files[1])
leg = tf.Workspace(model)
names = [joint.name for joint in model.joints]

# %% Measured: the motors and the spring; the others begin at 0
encoders = ["hip_roll", "hip_yaw", "hip_pitch", "knee", "toe_crank", "shin_spring"]
measured = {"hip_roll": 0.05, "hip_pitch": 0.3, "knee": -0.4, "toe_crank": 0.2}
measured["shin_spring"] = 0.02
rates = {"hip_pitch": 0.5, "knee": -1.0, "toe_crank": 0.7}
q = np.array([measured.get(name, 0) for name in names])  # rad
v = np.array([rates.get(name, 0) for name in names])  # rad/s
closed = leg.close_loops(q, v, locked=encoders)
for name, angle, rate in zip(names, closed.q, closed.v):
    print(f"{name:15} {angle:8.4f} rad {rate:8.4f} rad/s")
print(f"{closed.iterations} iterations; loops open by {closed.position:.1e} m")
print(f"{closed.velocity:.1e} m/s; {closed.lost} of {closed.rank + closed.lost} rows is redundant")

# %% Torques that hold it at rest: the rods carry what has no motor
rest = np.zeros(model.v_count)
hold = leg.constrained_inverse_dynamics(closed.q, rest, rest)
for name in encoders:
    print(f"{name:15} {hold.tau[names.index(name)]:8.3f} N m")
left = [abs(tau) for name, tau in zip(names, hold.tau) if name not in encoders]
print(f"left to joints without motor: {max(left):.1e} N m")

# %% With these torques it stays; with more at the knee the loops move as one, the spring stiff
still = leg.constrained_dynamics(closed.q, rest, hold.tau)
tau = hold.tau.copy()
tau[names.index("knee")] += 10  # N m
moved = leg.constrained_dynamics(closed.q, closed.v, tau, locked="shin_spring")
knee, ankle = moved.qdd[names.index("knee")], moved.qdd[names.index("ankle")]
force = np.linalg.norm(moved.constraint_wrenches[:3])  # of the first constraint, N
print(f"knee {knee:.2f} rad/s^2, ankle {ankle:.2f} rad/s^2, Achilles rod {force:.1f} N")
worst = max(closed.position, np.abs(still.qdd).max(), np.abs(moved.constraint_residual).max())
print(f"worst of closure, rest and residual: {worst:.1e}")
