# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Forward dynamics of a batch: accelerations of 10,000 states of an arm.

    python3 forward_dynamics_batch.py [config/robots/arm7.urdf]
"""
# %% The robot
import sys
import time

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/arm7.urdf"
model = tf.Model(path)
print(f"{model.name}: {', '.join(model.joint_names)}")
for warning in model.warnings:
    print(warning)

# %% States: an axis of states, then one of joints
count = 10_000
random = np.random.default_rng(0)
q = random.uniform(-np.pi, np.pi, (count, model.q_count))  # rad
v = random.uniform(-1, 1, (count, model.v_count))  # rad/s
tau = random.uniform(-10, 10, (count, model.v_count))  # N m

# %% Accelerations, in one thread and on every core
workspace = tf.Workspace(model)
reply = workspace.forward_dynamics(q, v, tau)  # the first call touches new memory
start = time.perf_counter()
workspace.forward_dynamics(q, v, tau, out=reply)
one = time.perf_counter() - start
with tf.Pool(model) as pool:
    pool.forward_dynamics(q, v, tau)
    start = time.perf_counter()
    spread = pool.forward_dynamics(q, v, tau)
    many = time.perf_counter() - start
    print(
        f"{one / count * 1e9:.0f} ns a state, with {pool.threads} threads {many / count * 1e9:.0f}"
    )
assert (spread.qdd == reply.qdd).all()  # the same bits

# %% Inverse dynamics gives the torques back
back = workspace.inverse_dynamics(q, v, reply.qdd).tau
error = np.abs(back - tau).max() / np.abs(tau).max()
print(f"largest difference from inverse dynamics: {error:.1e}")

# %% One state, with the error of its answer
state = workspace.forward_dynamics(q[0], v[0], tau[0], estimate="always")
print(f"{state.method}: error estimate {state.error_estimate:.1e}")
for name, acceleration in zip(model.joint_names, state.qdd):
    print(f"{name} {acceleration:+.6f} rad/s^2")
