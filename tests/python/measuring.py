# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What charts stand on: races that are timed in C, test mechanisms, models moved by a last bit."""
import copy
import ctypes
import subprocess

import numpy as np

import support
import totalforce as tf
from support import Case, load, state
from totalforce import _totalforce


class Races(Case):
    def setUp(self):
        self.model = load("arm7")
        rng = np.random.default_rng(3)
        self.states = [{**state(self.model, rng), "method": "aba"} for _ in range(3)]
        self.one, self.other = tf.Workspace(self.model), tf.Workspace(self.model)

    def race(self, first, second, **options):
        return _totalforce._race(first, second, 1e-4, **options)

    def test_times(self):
        slow = [{**s, "method": "crba", "refine": 2} for s in self.states]
        for clock in ("thread", "monotonic"):
            times = self.race((self.one, "forward_dynamics", slow),
                              (self.other, "forward_dynamics", self.states), clock=clock)
            self.assertEqual(times.shape[0], 2)
            self.assertTrue(3 <= times.shape[1] <= 101)
            self.assertTrue((times > 0).all() and (times < 10).all())

    def test_solvers_of_all_kinds(self):
        batch = [state(self.model, np.random.default_rng(1), 16)]
        with tf.Pool(self.model) as pool:
            self.race((pool, "forward_dynamics", batch), (self.one, "forward_dynamics", batch))
        tips = [{"q": s["q"], "tips": ["tool0"]} for s in self.states]
        self.race((self.one, "operational_inertia", tips),
                  (self.other, "forward_dynamics", self.states))

    def test_functions_of_others(self):
        """A peer's forward dynamics gets state after state, its Lambda^-1 the link as well."""
        doubles, n, seen = ctypes.POINTER(ctypes.c_double), len(self.states[0]["q"]), []

        @ctypes.CFUNCTYPE(None, ctypes.c_void_p, doubles, doubles, doubles, doubles)
        def forward(robot, q, v, tau, _):
            seen.append((robot, q[0], v[n - 1], tau[n - 1]))

        @ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, doubles, ctypes.c_char_p, doubles)
        def lambda_inv(robot, q, link, _):
            seen.append((robot, q[0], link))
            return 0

        numbers = np.array([[s["q"], s["v"], s["tau"]] for s in self.states])
        ours = (self.one, "forward_dynamics", self.states)
        for function, link, of_state in (
            (forward, None, lambda s: (7, s["q"][0], s["v"][-1], s["tau"][-1])),
            (lambda_inv, "tool0", lambda s: (7, s["q"][0], b"tool0")),
        ):
            seen.clear()
            address = ctypes.cast(function, ctypes.c_void_p).value
            self.race((address, 7, numbers, link), ours)
            self.assertEqual(seen[:4], [of_state(self.states[k % 3]) for k in range(4)])
        with self.fails(tf.InputTypeError, "states must be"):
            self.race((address, 7, numbers[0], None), ours)

    def test_faults(self):
        good = (self.one, "forward_dynamics", self.states)
        wrong = {**self.states[0], "q": [1.0]}
        with self.fails(tf.InputError, "q: shape (1,)"):
            self.race(good, (self.other, "forward_dynamics", [*self.states, wrong]))
        with self.fails(tf.InputError, "forward_dinamics"):
            self.race(good, (self.other, "forward_dinamics", self.states))
        with self.fails(tf.InputTypeError, "none"):
            self.race(good, (self.other, "forward_dynamics", []))
        with self.fails(tf.BusyError):
            self.race(good, good)
        with self.fails(tf.InputError, "clock"):
            self.race(good, (self.other, "forward_dynamics", self.states), clock="sun")
        # a request that is refused while it races
        with self.fails(tf.Error, "method"):
            self.race(good, (self.other, "forward_dynamics",
                             [{**self.states[0], "method": "propagation"}]))
        # and all are free again
        self.race(good, (self.other, "forward_dynamics", self.states))


class Mechanisms(Case):
    def test_as_the_command_writes_them(self):
        for name, words, options in (
            ("helix", [], {}),
            ("taper", ["--taper", "0.5", "--seed", "7"], {"taper": 0.5, "seed": 7}),
            ("thin", ["--radius", "1e-3", "--curl", "0.5"], {"radius": 1e-3, "curl": 0.5}),
            ("heavy-tip", ["--mass-ratio", "100"], {"ratio": 100}),
        ):
            written = subprocess.run([support.TOOL, "chain", name, "--bodies", "9", *words],
                                     capture_output=True, check=True).stdout
            self.assertEqual(_totalforce._mechanism(name, 9, **options), written, name)
        self.assertIn("side-branches", _totalforce._mechanisms())

    def test_faults(self):
        for wrong, message in ((("helx", 3), "helx"), (("helix", 0), "bodies: 0")):
            with self.fails(tf.InputError, message):
                _totalforce._mechanism(*wrong)
        with self.fails(tf.InputError, "curl: 2"):
            _totalforce._mechanism("helix", 3, curl=2)


class Moved(Case):
    def test_by_a_last_bit(self):
        for robot, base in (("arm7", "fixed"), ("quadruped", "floating")):
            model = load(robot, base)
            fields = state(model, np.random.default_rng(2))
            exact = tf.Workspace(model, precision="f128").forward_dynamics(**fields).qdd
            seen = []
            for seed in (1, 2):
                moved = model._moved(seed)
                self.assertEqual(moved.joint_names, model.joint_names)
                qdd = tf.Workspace(moved, precision="f128").forward_dynamics(**fields).qdd
                change = np.linalg.norm(qdd - exact) / np.linalg.norm(exact)
                self.assertTrue(0 < change < 1e-12, f"{robot}: {change}")
                again = tf.Workspace(model._moved(seed), precision="f128")
                self.same_bits(again.forward_dynamics(**fields).qdd, qdd, "the same seed")
                seen.append(qdd.tobytes())
            self.assertNotEqual(*seen)

    def test_only_of_urdf(self):
        model = load("arm7")
        with self.assertRaises(TypeError):
            model.derive(gravity=[0, 0, 0])._moved(1)
        with self.assertRaises(TypeError):
            copy.copy(model._moved(1))


class RoundedCosines(Case):
    def test_each_on_its_own(self):
        """One rod of 1 kg and 1 m on a revolute joint about x; gravity along y, so that the cosine of
        q counts. The torque balances the weight but for rounding, so that the rounding of the cosine
        is what is left."""
        model = tf.Model(_totalforce._mechanism("straight", 1))
        inertia, q = 1 / 12 + 0.25 * 0.01 + 0.25, np.longdouble(1e-3)
        weight = np.longdouble(0.5) * np.longdouble(9.80665)
        tau, found = -float(weight * np.cos(q)), []
        for rounded, cosine in ((False, np.cos(q)), (True, np.longdouble(float(np.cos(q))))):
            exact = tf.Workspace(model, precision="f128", round_sincos=rounded)
            found.append(float(exact.forward_dynamics(
                [float(q)], tau=[tau], gravity=[0.0, -9.80665, 0.0], method="aba").qdd[0]))
            wanted = float((tau + weight * cosine) / inertia)
            self.assertLess(abs(found[-1] - wanted), 1e-2 * abs(wanted) + 1e-19)
        self.assertGreater(abs(found[0] - found[1]), 1e-18)


support.main()
