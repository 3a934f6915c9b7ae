# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""An arm that holds its posture is pushed: a momentum observer sees it without a sensor, and says
where the push comes from at the tool.

    python3 collision_detection.py [arm.urdf [tip]]
"""
# %% Robot and observer: time constant 1 / gain = 20 ms
import sys

import numpy as np

import totalforce as tf

model = tf.Model(sys.argv[1] if len(sys.argv) > 1 else "config/robots/arm7.urdf")
tip = sys.argv[2] if len(sys.argv) > 2 else "tool0"
arm = tf.Workspace(model)
gain, dt = 50.0, 1e-3  # 1/s, s
observer = tf.Observer(arm, gain)

# %% Simulation in place of the robot: 1 kHz, a push at the tool from 0.2 s on, by some 4 m/s^2
hold = np.linspace(0.4, -0.8, model.q_count)  # rad
at_rest = arm.kinematics(hold, tips=tip, want="jacobian")
mass = 3 / np.trace(arm.operational_inertia(hold, tips=tip).lambda_inv[:3, :3])  # kg
push = 4 * mass * np.array([0.8, -0.3, 0.5, 0, 0, 0])  # N, axes of the world, at the tip's origin
stiffness, damping = 400.0, 40.0


def torques(q, v):
    """Gravity, and a stiff hold of the posture in the metric of the mass matrix."""
    reply = arm.inverse_dynamics(q, v, stiffness * (hold - q) - damping * v)
    return reply.tau


def step(q, v, tau, wrench):
    """One millisecond by the classical Runge-Kutta method."""

    def rate(x):
        a = arm.forward_dynamics(x[0], x[1], tau, wrench={tip: wrench}).qdd
        return np.array([x[1], a])

    x = np.array([q, v])
    k1 = rate(x)
    k2 = rate(x + dt / 2 * k1)
    k3 = rate(x + dt / 2 * k2)
    k4 = rate(x + dt * k3)
    return x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


# %% What the program of a robot does in each cycle: update, compare with a threshold
threshold = 0.1 * np.abs(at_rest.jacobian.T @ push).max()  # N m; of a real arm: above its noise
q, v = hold.copy(), np.zeros(model.v_count)
detected = None
for k in range(500):
    time = k * dt
    tau = torques(q, v)
    observer.update(time, q, v, tau)
    if detected is None and np.abs(observer.torques).max() > threshold:
        detected = time
    q, v = step(q, v, tau, push if time >= 0.2 else 0 * push)

# %% Result: ten time constants later
found = observer.wrench(tip, q, rank_loss="truncate")  # of a tip behind less than six joints
true = arm.kinematics(q, tips=tip, want="jacobian").jacobian.T @ push
print("detected", "never" if detected is None else f"{1e3 * (detected - 0.2):.0f} ms after the push")
print("external torques, N m:", np.round(observer.torques, 3))
print("wrench at the tip, N and N m:", np.round(found, 3))
error = np.abs(observer.torques - true).max() / np.abs(true).max()
print(f"pushed by {np.round(push[:3], 3)} N; error of the torques: {error:.1e}")
print(f"worst of detection and errors: {max(detected - 0.2, error):.1e}")
