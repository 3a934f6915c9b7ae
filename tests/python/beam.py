# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce beam`: roots of the literature, closed forms against quadrature, axes, mistakes."""
import contextlib
import io
import json
import math
import pickle
import re
import unittest

import numpy as np
from numpy.polynomial import chebyshev

import totalforce as tf
from support import ROBOTS, main
from totalforce_tools import beam, command

# Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1
ROOTS = (1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839)
FIRST = 1.875104068711961
BAR = ["--link", "boom", "--joint", "tip", "--length", "0.8", "--rectangle", "0.04,0.01",
       "--density", "2700", "--young", "7e10", "--shear", "2.6e10", "--torsion-modes", "2"]
# of config/robots/flexible_arm.yaml
EXAMPLE = ("--length 1 --rectangle 0.005,0.05 --density 2700 --young 7e10 --modes 2,1 "
           "--damping 0.01").split()


def printed(*argv):
    """Text of a command line, and its modes: YAML of flat lines, read as JSON"""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert beam.main(list(argv)) == command.GOOD
    return out.getvalue(), modes_of(out.getvalue())


def modes_of(text):
    return [dict((key, json.loads(value)) for key, value in re.findall(r"([a-z]+): (.*)", entry))
            for entry in re.sub("#.*", "", text).split("      - ")[1:]]


def inertia_of(text):
    """Of the comment: 6 x 6, linear first, about the origin"""
    com = np.array([float(x) for x in re.search('xyz="([^"]*)"', text)[1].split()])
    mass = float(re.search('mass value="([^"]*)"', text)[1])
    moments = [float(re.search(f'{i}="([^"]*)"', text)[1]) for i in ("ixx", "iyy", "izz")]
    cross = np.array([[0, -com[2], com[1]], [com[2], 0, -com[0]], [-com[1], com[0], 0]])
    return np.block([[mass * np.eye(3), -mass * cross],
                     [mass * cross, np.diag(moments) - mass * cross @ cross]])


class Shapes(unittest.TestCase):
    def test_roots(self):
        for k, literature in enumerate(ROOTS, 1):
            self.assertAlmostEqual(beam.root(k), literature, delta=5e-9)
        self.assertAlmostEqual(beam.root(1), FIRST, delta=4e-16)
        for k in range(1, 9):
            x = beam.root(k)
            self.assertLess(abs(math.cos(x) + 1 / math.cosh(x)), 4e-16 * x)

    def test_first_frequency(self):
        """3.516 sqrt(EI / (rho A L^4))"""
        length, mass, stiffness = 1.3, 2.1, 17.0
        mode = beam.bending(1, length, mass, stiffness)
        omega = FIRST**2 * math.sqrt(stiffness / (mass / length * length**4))
        self.assertAlmostEqual(math.sqrt(mode["stiffness"] / mode["mass"]) / omega, 1, delta=1e-15)
        self.assertAlmostEqual(FIRST**2, 3.516, delta=5e-5)

    def test_closed_forms(self):
        """Integrals by Gauss and derivatives by Chebyshev series of the shape itself"""
        xi, weight = np.polynomial.legendre.leggauss(120)
        xi, weight = 0.5 * (xi + 1), 0.5 * weight
        for k in range(1, 13):
            x, sign = beam.root(k), 1 if k % 2 else -1
            psi = np.array([beam.shape(x, at) for at in xi])
            series = chebyshev.Chebyshev.interpolate(
                lambda at, x=x: np.array([beam.shape(x, a) for a in at]), 80, domain=[0, 1])
            mode = beam.bending(k, 1.0, 1.0, 1.0)
            self.assertAlmostEqual(weight @ psi, mode["linear"], delta=1e-13)
            self.assertAlmostEqual(weight @ (xi * psi), mode["angular"], delta=1e-13)
            self.assertAlmostEqual(weight @ psi**2, mode["mass"], delta=1e-13)
            for other in range(1, k):
                product = psi * [beam.shape(beam.root(other), at) for at in xi]
                self.assertAlmostEqual(weight @ product, 0, delta=1e-13)
            self.assertAlmostEqual(beam.shape(x, 1.0), 1, delta=1e-14)
            self.assertAlmostEqual(beam.shape(x, 0.0), 0, delta=1e-14)
            self.assertAlmostEqual(series.deriv()(0.0), 0, delta=1e-7)
            self.assertAlmostEqual(series.deriv()(1.0) / mode["slope"], 1, delta=1e-8)
            bent = weight @ series.deriv(2)(xi)**2
            self.assertAlmostEqual(bent / mode["stiffness"], 1, delta=1e-8)
            turn = beam.torsion(k, 1.0, 1.0, 1.0)
            theta = sign * np.sin(turn["root"] * xi)
            self.assertAlmostEqual(weight @ theta, turn["angular"], delta=1e-13)
            self.assertAlmostEqual(weight @ theta**2, turn["mass"], delta=1e-13)


def frequencies(n, **options):
    """sqrt(omega) of a beam with L = m = EI = 1 on a joint across it, n modes, in a model"""
    text, _ = printed("--link", "b", "--length", "1", "--mass", "1", "--bending", "1", "--modes",
                      f"{n},0")
    found = re.search('origin xyz="(.*?)".*\\n#   (<inertia .*?/>)', text)
    urdf = (f'<robot name="r"><link name="w"/><joint name="j" type="continuous"><parent link="w"/>'
            f'<child link="b"/><axis xyz="0 0 1"/></joint><link name="b"><inertial><origin '
            f'xyz="{found[1]}"/><mass value="1"/>{found[2]}</inertial></link></robot>')
    model = tf.Model.parse(urdf, modes=text.encode(), gravity=[0, 0, 0], **options)
    workspace = tf.Workspace(model)
    rows = [workspace.forward_dynamics([0], [0], [0], modes=1e-6 * e).modes for e in np.eye(n)]
    return np.sort(np.abs(np.linalg.eigvals(1e6 * np.array(rows))))**0.25


class Models(unittest.TestCase):
    def test_frequencies(self):
        """Clamped by a heavy rotor, the beam vibrates as clamped and free; on a free joint as
        pinned and free, whose roots of tan x = tanh x (Blevins) a few modes reach from above."""
        clamped = frequencies(4, armature={"j": 1e12})
        np.testing.assert_allclose(clamped, [beam.root(k) for k in range(1, 5)], rtol=1e-9)
        pinned = frequencies(8)
        np.testing.assert_allclose(pinned[:2], [3.92660231, 7.06858275], rtol=2e-6)

    def test_file(self):
        """The example by its file, and again from a pickle"""
        urdf, modes = ROBOTS / "flexible_arm.urdf", ROBOTS / "flexible_arm.yaml"
        model = tf.Model(urdf, modes=modes)
        self.assertNotEqual(model.hash, tf.Model(urdf).hash)
        self.assertEqual(tf.Model(urdf, modes=[modes.read_bytes()]).hash, model.hash)
        self.assertEqual(pickle.loads(pickle.dumps(model)).hash, model.hash)
        with self.assertRaisesRegex(tf.LoadError, "links: keys are expected here"):
            tf.Model(urdf, modes=b"links: 3")
        with self.assertRaisesRegex(tf.LoadError, "given twice"):
            tf.Model(urdf, modes=[modes, modes])
        with self.assertRaisesRegex(tf.InputTypeError, "modes"):
            tf.Model(urdf, modes=3)


class Files(unittest.TestCase):
    def test_inertia_holds_the_modes(self):
        """[M6 p; p^T M] of the printed inertia is positive semidefinite."""
        for axis in "xyz":
            text, modes = printed(*BAR, "--axis", axis, "--modes", "5")
            self.assertEqual(len(modes), 12)
            p = np.array([mode["momentum"] for mode in modes]).T
            mass = np.diag([mode["mass"] for mode in modes])
            whole = np.block([[inertia_of(text), p], [p.T, mass]])
            scale = np.sqrt(np.diag(whole))
            self.assertGreater(np.linalg.eigvalsh(whole / np.outer(scale, scale))[0], -1e-12)

    def test_axes(self):
        """A beam along another axis is the same one, its axes exchanged; slow modes come first."""
        def turned(six, by):
            return [six[3 * (i // 3) + (i - by) % 3] for i in range(6)]

        _, along_x = printed(*BAR)
        for by, axis in enumerate("xyz"):
            _, modes = printed(*BAR, "--axis", axis)
            for mode, first in zip(modes, along_x, strict=True):
                self.assertEqual(mode["momentum"], turned(first["momentum"], by))
                self.assertEqual(mode["shape"]["tip"], turned(first["shape"]["tip"], by))
                self.assertEqual(mode["stiffness"], first["stiffness"])
        rates = [mode["stiffness"] / mode["mass"] for mode in along_x]
        self.assertEqual(rates, sorted(rates))
        self.assertEqual(along_x[0]["shape"]["tip"][2], 1)  # the thin side bends first

    def test_section_and_numbers_agree(self):
        w, h, density, young = 0.04, 0.01, 2700, 7e10
        given = ["--link", "boom", "--length", "0.8", "--damping", "0.02", "--limit", "0.3"]
        _, a = printed(*given, "--rectangle", f"{w},{h}", "--density", f"{density}", "--young",
                       f"{young}")
        _, b = printed(*given, "--mass", f"{w * h * density * 0.8!r}", "--bending",
                       f"{young * h * w**3 / 12!r},{young * w * h**3 / 12!r}")
        for x, y in zip(a, b, strict=True):
            np.testing.assert_allclose(x["momentum"], y["momentum"], rtol=1e-14)
            self.assertAlmostEqual(x["stiffness"] / y["stiffness"], 1, delta=1e-14)
            self.assertAlmostEqual(x["damping"] / math.sqrt(x["stiffness"] * x["mass"]), 0.04,
                                   delta=1e-15)
            self.assertEqual((x["limit"], x["shape"]), (0.3, {}))
        _, tube = printed(*given, "--tube", "0.02,0.01", "--density", "1", "--young", "1")
        _, hollow = printed(*given, "--tube", "0.02,0.001", "--density", "1", "--young", "1")
        self.assertAlmostEqual(tube[0]["mass"], 0.25 * math.pi * 1e-4 * 0.8, delta=1e-18)
        self.assertGreater(hollow[0]["stiffness"] / hollow[0]["mass"],
                           tube[0]["stiffness"] / tube[0]["mass"])

    def test_the_example_is_of_this_tool(self):
        shipped = (ROBOTS / "flexible_arm.yaml").read_text()
        robot = (ROBOTS / "flexible_arm.urdf").read_text()
        for link, joint in (("upper_beam", "elbow_mount"), ("lower_beam", "tool_mount")):
            text, modes = printed("--link", link, "--joint", joint, *EXAMPLE)
            found = modes_of(shipped[shipped.index(f'"{link}":'):])
            for x, y in zip(modes, found):
                np.testing.assert_allclose(x.pop("shape")[joint], y.pop("shape")[joint], rtol=1e-14)
                for key in x:
                    np.testing.assert_allclose(x[key], y[key], rtol=1e-14)
            for line in re.findall("<(?:mass|inertia) .*?/>", text):
                self.assertEqual(robot.count(line), 2)

    def test_mistakes(self):
        for argv, message in (
                ("", "--link is missing"),
                ("--link a", "--length is missing"),
                ("--link a --length 0", "--length: 0, must be above 0"),
                ("--link a --length 1", "--mass is missing, or --density and a section"),
                ("--link a --length 1 --mass 1", "--bending is missing, or --young and a section"),
                ("--link a --length 1 --mass 1 --bending 1,2,3", "'1,2,3' is not one or two"),
                ("--link a --length 1 --mass 1 --bending 1,0", "--bending: 0, must be above 0"),
                ("--link a --length 1 --mass 1 --bending 1 -n 7", "14 modes, a link has 1 to 12"),
                ("--link a --length 1 --mass 1 --bending 1 -n 0", "0 modes, a link has 1 to 12"),
                ("--link a -n 1,2,3", "'1,2,3' is not one or two whole numbers"),
                ("--link a --length 1 --mass 1 --bending 1 --torsion-modes 1", "--torsion is"),
                ("--link a --length 1 --mass 1 --torsion 1", "'1' is not two numbers"),
                ("--link a --length 1 --rectangle 1,1 --tube 1,1", "a beam has one section"),
                ("--link a --length 1 --tube 1,0.6", "the wall is at most half"),
                ("--link a --damping -1", "--damping: -1, must not be negative"),
                ("--axis w", "--axis: no 'w'; there are x, y, z")):
            with self.assertRaisesRegex(command.Usage, re.escape(message)):
                beam.parse(argv.split())


main()
