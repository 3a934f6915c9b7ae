# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Integrators of q'' = a(q, q') with a fixed step h: each makes the next state, q then v, of y.
The extrapolated midpoint rule: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I,
1993, II.9, with 2, 4, 6, 8 substeps."""
import numpy as np


class System:
    """n joints, accelerate(q, v)"""

    def __init__(self, n, accelerate):
        self.n, self.accelerate = n, accelerate

    def derive(self, y):
        v = y[self.n:]
        return np.concatenate([v, self.accelerate(y[:self.n], v)])


def euler(s, h, y):
    """semi-implicit Euler, order 1: new velocities move the joints"""
    q, v = y[:s.n], y[s.n:]
    v = v + h * s.accelerate(q, v)
    return np.concatenate([q + h * v, v])


def rk4(s, h, y):
    """Runge-Kutta, order 4"""
    total, z = 0.0, y
    for weight, after in ((1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)):
        f = s.derive(z)
        total = total + weight * f
        z = y + after * h * f
    return y + h / 6.0 * total


def midpoint(s, h, n, y, f0):
    """Change of y by n substeps of the midpoint rule, smoothed (Gragg); f0: derivative at y."""
    sub = h / n
    before, z = y, y + sub * f0
    for _ in range(n - 1):
        before, z = z, before + 2.0 * sub * s.derive(z)
    return 0.5 * ((z - y) + (before - y) + sub * s.derive(z))


def gbs8(s, h, y):
    """extrapolated midpoint rule of Gragg, Bulirsch and Stoer, order 8"""
    f0, row = s.derive(y), [None] * 4
    for k in range(4):
        row[k] = midpoint(s, h, 2 * (k + 1), y, f0)
        for j in reversed(range(k)): # changes, not states: their rounding is h times smaller
            ratio = (k + 1.0) / (j + 1.0)
            row[j] = row[j + 1] + (row[j + 1] - row[j]) / (ratio * ratio - 1.0)
    return y + row[0]


INTEGRATORS = {"euler": euler, "rk4": rk4, "gbs8": gbs8}
