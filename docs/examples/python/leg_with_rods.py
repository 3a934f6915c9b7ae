# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A leg with rods, as Cassie's: encoders measure six of its eleven joints, the loops give the rest;
then torques that hold it, and accelerations under the constraints.

    python3 leg_with_rods.py [config/robots/rod_leg.urdf]
"""
# %% Robot: the loop joints of the file are its constraints
import sys
import warnings

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/rod_leg.urdf"
motors = ["hip_roll", "hip_yaw", "hip_pitch", "knee", "toe_crank"]
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # that the file has loops, which we know
    model = tf.Model(path, actuated=motors + ["shin_spring"])
leg = tf.Workspace(model)
names = [joint.name for joint in model.joints]

# %% Measured: the motors and the spring; the others begin at 0
measured = {"hip_roll": 0.05, "hip_pitch": 0.3, "knee": -0.4, "toe_crank": 0.2}
measured["shin_spring"] = 0.02
rates = {"hip_pitch": 0.5, "knee": -1.0, "toe_crank": 0.7}
q = np.array([measured.get(name, 0) for name in names])  # rad
v = np.array([rates.get(name, 0) for name in names])  # rad/s
closed = leg.close_loops(q, v, locked=motors + ["shin_spring"])
for name, angle, rate in zip(names, closed.q, closed.v):
    print(f"{name:15} {angle:8.4f} rad {rate:8.4f} rad/s")
print(f"{closed.iterations} iterations; loops open by {closed.position:.1e} m")
print(f"{closed.velocity:.1e} m/s; {closed.lost} of {closed.rank + closed.lost} rows is redundant")

# %% Torques that hold it at rest: the rods carry what has no motor
rest = np.zeros(model.v_count)
hold = leg.constrained_inverse_dynamics(closed.q, rest, rest)
for name in motors + ["shin_spring"]:
    print(f"{name:15} {hold.tau[names.index(name)]:8.3f} N m")
left = [abs(tau) for name, tau in zip(names, hold.tau) if name not in motors + ["shin_spring"]]
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
