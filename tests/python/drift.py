# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce drift`: the integrators have their orders, a pendulum its period and its energy, the
line of aba in double lies on that of quadruple precision, and a sign that is wrong shows."""
import math
import unittest
from types import SimpleNamespace

import numpy as np

import totalforce as tf
from support import main
from totalforce_tools import cases, drift
from totalforce_tools.drift_integrate import INTEGRATORS, System

# A rod of 1 kg and 1 m, radius 0.1 m, on a joint across it: E = I w^2 / 2 + m g cos(q) / 2.
WEIGHT, INERTIA = 9.80665, 1 / 3 + 0.25 * 0.01


def oscillation(integrator, steps):
    """Error of cos t after 2 s"""
    y, system = np.array([1.0, 0.0]), System(1, lambda q, v: -q)
    for _ in range(steps):
        y = INTEGRATORS[integrator](system, 2.0 / steps, y)
    return math.hypot(y[0] - math.cos(2.0), y[1] + math.sin(2.0))


def swing_of(mechanism, bodies):
    return drift.Swing(cases.Case.mechanism(mechanism, bodies, 3, turn=1.0))


def run(swing, method="aba", integrator="gbs8", step=1e-3, seconds=1.0, samples=10, floor=False,
        accelerate=None):
    given = SimpleNamespace(integrator=integrator, seconds=seconds, samples=samples)
    line = drift.Line(method, "f128" if floor else "f64", 0, step, floor)
    return line.run(swing, given, accelerate)


class Integrators(unittest.TestCase):
    def test_orders(self):
        for name, order in (("euler", 1), ("rk4", 4), ("gbs8", 8)):
            steps = 4 if name == "gbs8" else 32
            found = math.log2(oscillation(name, steps) / oscillation(name, 2 * steps))
            self.assertAlmostEqual(found, order, delta=0.5, msg=name)


class Pendulum(unittest.TestCase):
    def setUp(self):
        self.swing = swing_of("straight", 1)

    def test_energy(self):
        q, v = 0.7, -1.3
        kinetic, potential = self.swing.case.exact.kinematics([q], [v], want=["energy"]).energy
        self.assertAlmostEqual(kinetic, 0.5 * INERTIA * v * v, delta=1e-14)
        self.assertAlmostEqual(potential, 0.5 * WEIGHT * math.cos(q), delta=1e-14)
        self.assertAlmostEqual(self.swing.scale, 0.5 * WEIGHT, delta=1e-14)

    def test_period(self):
        """Released at an angle of 1 from straight down: T = 2 pi / (w0 agm(1, cos(1 / 2))), Gauss"""
        a, b = 1.0, math.cos(0.5)
        for _ in range(6):
            a, b = 0.5 * (a + b), math.sqrt(a * b)
        period = 2 * math.pi / (math.sqrt(0.5 * WEIGHT / INERTIA) * a)
        self.swing.start = np.array([math.pi - 1.0])
        self.swing.energy = 0.5 * WEIGHT * math.cos(self.swing.start[0])
        line = run(self.swing, step=period / 1000, seconds=period, samples=2)
        self.assertEqual(len(line.errors), 2)
        self.assertLess(line.last, 1e-14)


class Lines(unittest.TestCase):
    def test_aba_in_double_drifts_as_the_integrator(self):
        swing = swing_of("random", 4)
        aba, floor = (run(swing, integrator="rk4", floor=f).last for f in (False, True))
        self.assertGreater(floor, 1e-14)
        self.assertAlmostEqual(aba / floor, 1.0, delta=0.01)
        aba, floor = (run(swing, floor=f).last for f in (False, True))
        self.assertLess(floor, 1e-13)
        self.assertLess(aba, 10 * floor + 1e-14)

    def test_a_wrong_sign_shows(self):
        """Velocity products of a joint that turns the other way"""
        swing = swing_of("random", 4)
        solver = tf.Workspace(swing.case.model)
        reverse = np.array([-1.0, 1.0, 1.0, 1.0])
        line = run(swing, accelerate=lambda q, v: solver.forward_dynamics(
            q, v * reverse, method="aba").qdd)
        self.assertGreater(line.last, 1e-3)

    def test_a_method_that_fails_ends_its_line(self):
        line = run(swing_of("rank-deficient", 5), "tfa", "rk4", seconds=0.1)
        self.assertEqual((line.status, line.errors, line.last), ("E_SINGULAR", [], 0.0))

    def test_an_energy_that_is_lost_ends_a_line(self):
        swing = swing_of("random", 2)
        line = run(swing, "aba", "euler", accelerate=lambda q, v: 300.0 * v + 1.0)
        self.assertEqual(line.status, "ok")
        self.assertEqual(len(line.errors), 1)


main()
