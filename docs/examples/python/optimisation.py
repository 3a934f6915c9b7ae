# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Trajectory optimisation by iLQR: a double pendulum swings up, an arm reaches a point.

    python3 optimisation.py [config/robots/arm7.urdf]
"""
# %% iLQR: sum dt/2 (effort tau M^-1 tau + speed v v) + goal/2 residual(q_N)^2 + rest/2 v_N^2
import sys
import time

import numpy as np

import totalforce as tf

ALPHAS = 0.5 ** np.arange(8)  # lengths of a step, tried as one batch


class Ilqr:
    """Of a fixed base and joints of one freedom; residual(q) of a batch: values, Jacobians"""

    def __init__(self, model, residual, steps, dt=0.01, effort=1e-3, speed=1e-2, goal=1e3, rest=100):
        self.model, self.workspace, self.residual, self.dt = model, tf.Workspace(model), residual, dt
        self.effort, self.speed, self.steps = effort * dt, speed * dt, steps
        self.goal, self.rest = goal, rest

    def roll_out(self, q0, alphas, q=None, v=None, k=None, K=None):
        """Trajectories (steps + 1, alphas, n) with tau + alpha k + K (x - x of before)"""
        many, n = len(alphas), self.model.v_count
        Q, V, U = [np.tile(q0, (many, 1))], [np.zeros((many, n))], []
        for t, tau in enumerate(self.tau):
            U.append(np.tile(tau, (many, 1)))
            if q is not None:
                dx = np.hstack((self.model.difference(q[t], Q[-1]).v, V[-1] - v[t]))
                U[-1] += alphas[:, None] * k[t] + dx @ K[t].T
            qdd = self.workspace.forward_dynamics(Q[-1], V[-1], U[-1]).qdd
            V.append(np.clip(V[-1] + self.dt * qdd, -100, 100))  # diverging ones stay finite
            Q.append(self.model.integrate(Q[-1], V[-1], dt=self.dt).q)
        Q, V, U = np.array(Q), np.array(V), np.array(U)
        cost = np.einsum("tai,ij,taj->a", U, self.R, U) / 2 + self.speed / 2 * (V**2).sum((0, 2))
        cost += self.rest / 2 * (V[-1] ** 2).sum(1)
        return Q, V, U, cost + self.goal / 2 * (self.residual(Q[-1])[0] ** 2).sum(1)

    def gains(self, q, v, damping):
        """Riccati sweep over derivatives of all steps, which are one batch"""
        n, dt, one = self.model.v_count, self.dt, np.eye(self.model.v_count)
        d = self.workspace.derivatives(q[:-1], v[:-1], self.tau)
        next_v = np.concatenate((dt * d.dqdd_dq, one + dt * d.dqdd_dv, dt * d.dqdd_dtau), axis=2)
        next_q = dt * next_v + np.concatenate((one, 0 * one, 0 * one), axis=1)
        AB = np.concatenate((next_q, next_v), axis=1)
        (e,), (J,) = self.residual(q[-1:])
        g = np.concatenate((self.goal * J.T @ e, self.rest * v[-1]))
        H = np.block([[self.goal * J.T @ J, 0 * one], [0 * one, self.rest * one]])
        k, K, x = np.empty((len(AB), n)), np.empty((len(AB), n, 2 * n)), slice(2 * n)
        for t in reversed(range(len(AB))):
            Q, G = AB[t].T @ H @ AB[t], AB[t].T @ g
            Q[2 * n :, 2 * n :] += (1 + damping) * self.R
            G[2 * n :] += self.R @ self.tau[t]
            Q[n : 2 * n, n : 2 * n] += self.speed * one
            G[n : 2 * n] += self.speed * v[t]
            k[t] = -np.linalg.solve(Q[2 * n :, 2 * n :], G[2 * n :])
            K[t] = -np.linalg.solve(Q[2 * n :, 2 * n :], Q[2 * n :, x])
            g, H = G[x] + Q[x, 2 * n :] @ k[t], Q[x, x] + Q[x, 2 * n :] @ K[t]
            H = (H + H.T) / 2
        return k, K

    def solve(self, q0, iterations=200, tolerance=1e-6):
        damping = 1.0
        self.R = self.effort * np.linalg.inv(self.workspace.mass_matrix(q0).M)
        self.tau = np.tile(self.workspace.bias(q0).gravity, (self.steps, 1))
        q, v, _, costs = self.roll_out(q0, [0])
        q, v, cost = q[:, 0], v[:, 0], costs[0]
        for iteration in range(iterations):
            Q, V, U, costs = self.roll_out(q0, ALPHAS, q, v, *self.gains(q, v, damping))
            best, before = np.argmin(costs), cost
            damping = max(1e-6, damping * (0.2 if costs[best] < cost else 20))
            if costs[best] < cost:
                q, v, self.tau, cost = Q[:, best], V[:, best], U[:, best], costs[best]
            if 0 < before - cost < tolerance * cost or damping > 1e6:
                break
        return q, v, iteration + 1


def report(name, control, q0):
    start = time.perf_counter()
    q, v, iterations = control.solve(q0)
    error = np.linalg.norm(control.residual(q[-1:])[0])
    print(
        f"{name}: {iterations} iterations, {time.perf_counter() - start:.1f} s, error {error:.1e}, "
        f"largest torque {np.abs(control.tau).max():.1f} N m"
    )
    return error


# %% A double pendulum swings up, in 2 s
LINK = (
    '<link name="{0}"><inertial><mass value="1"/><origin xyz="0 0 -0.5"/><inertia ixx="0.083" '
    'ixy="0" ixz="0" iyy="0.083" iyz="0" izz="0.001"/></inertial></link>'
)
JOINT = (
    '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{0}_link"/>'
    '<origin xyz="0 0 {2}"/><axis xyz="0 1 0"/></joint>'
)
PENDULUM = (
    '<robot name="pendulum"><link name="base"/>'
    + LINK.format("shoulder_link")
    + LINK.format("elbow_link")
    + JOINT.format("shoulder", "base", 0)
    + JOINT.format("elbow", "shoulder_link", -1)
    + "</robot>"
)
up = np.array([np.pi, 0])  # rad
pendulum = Ilqr(tf.Model(PENDULUM), lambda q: (q - up, np.tile(np.eye(2), (len(q), 1, 1))), 200)
swing = report("double pendulum", pendulum, np.zeros(2))

# %% An arm reaches a point with its tip, in 1 s
path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/arm7.urdf"
model = tf.Model(path)
workspace, tip = tf.Workspace(model), model.links[-1]
start, end = model.random_configuration(1, count=2).q


def place(q):
    return workspace.kinematics(q, tips=tip, rows="point", want=["pose", "jacobian"])


target = place(end).pose[0, :3]
reach = report(
    model.name,
    Ilqr(model, lambda q: ((r := place(q)).pose[:, 0, :3] - target, r.jacobian), 100),
    start,
)
print(f"worst of swing-up (rad) and reach (m): {max(swing, reach):.1e}")
