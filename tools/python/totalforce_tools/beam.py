# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce beam`: the modes of a uniform clamped beam as the side file of a URDF.

Bending is that of Euler and Bernoulli, clamped at x = 0 and free at x = L. With xi = x / L and the
roots lambda of cos lambda cosh lambda = -1, the shapes are

    cosh lambda xi - cos lambda xi - sigma (sinh lambda xi - sin lambda xi),
    sigma = (cosh lambda + cos lambda) / (sinh lambda + sin lambda)

(Meirovitch, Fundamentals of Vibrations, 2001, 8.4), here divided by their value at the tip, which
is 2 with alternating sign. Torsion: sin((k - 1/2) pi xi).
"""
import json
import math

from totalforce_tools import command
from totalforce_tools.command import Option, number, positive, whole, word

MODES_MAX = 12  # TFA_MAX_LINK_MODES


def root(k):
    """The k-th root of cos x cosh x = -1, k from 1"""
    x = (k - 0.5) * math.pi
    for _ in range(8):  # of cos x + 1 / cosh x, whose slope is not small anywhere near
        c = math.exp(-x) * 2.0 / (1.0 + math.exp(-2.0 * x))
        x -= (math.cos(x) + c) / (-math.sin(x) - c * math.tanh(x))
    return x


def defect(x):
    """(1 - sigma) exp(x) / 2: finite where sigma rounds to 1"""
    e = math.exp(-x)
    return (math.sin(x) - math.cos(x) - e) / (1.0 - e * e + 2.0 * e * math.sin(x))


def sigma(x):
    return 1.0 - 2.0 * math.exp(-x) * defect(x)


def shape(x, xi):
    """The mode of the root x at xi, 1 at the tip"""
    grown = defect(x) * math.exp(x * (xi - 1.0)) * (1.0 - math.exp(-2.0 * x * xi))
    value = math.exp(-x * xi) + grown - math.cos(x * xi) + sigma(x) * math.sin(x * xi)
    return value / math.copysign(2.0, math.sin(x))


def bending(k, length, mass, stiffness):
    """Mode k of a beam: its root, integrals of psi and x psi over the mass, modal mass and
    stiffness, slope of the tip. In closed form; the coordinate is the deflection of the tip, m."""
    x, sign = root(k), 1.0 if k % 2 else -1.0
    return {"root": x, "linear": mass * sign * sigma(x) / x, "angular": mass * length * sign / x**2,
            "mass": 0.25 * mass, "stiffness": 0.25 * x**4 * stiffness / length**3,
            "slope": x * sigma(x) / length}


def torsion(k, length, polar, stiffness):
    """The same of torsion; `polar`: moment of inertia of the beam about its axis. The coordinate
    is the rotation of the tip, rad."""
    x, sign = (k - 0.5) * math.pi, 1.0 if k % 2 else -1.0
    return {"root": x, "linear": 0.0, "angular": sign * polar / x, "mass": 0.5 * polar,
            "stiffness": 0.5 * x**2 * stiffness / length, "slope": 1.0}


def pair(text, _):
    """Two numbers above 0, or one for both"""
    values = [positive()(field, None) for field in text.split(",")]
    if len(values) > 2:
        raise ValueError(f"'{text}' is not one or two numbers")
    return values * (3 - len(values))


def two(text, _):
    values = [positive()(field, None) for field in text.split(",")]
    if len(values) != 2:
        raise ValueError(f"'{text}' is not two numbers")
    return values


def counts(text, _):
    """Two counts, or one for both"""
    values = [whole(0, MODES_MAX)(field, None) for field in text.split(",")]
    if len(values) > 2:
        raise ValueError(f"'{text}' is not one or two whole numbers")
    return values * (3 - len(values))


def not_negative(text, _):
    if number(text) < 0:
        raise ValueError(f"{text}, must not be negative")
    return number(text)


COMMAND = command.Command(
    "beam",
    "Writes the modes of a uniform beam, clamped at its root and free at its tip, as the file that "
    "--modes, the key 'modes' of a scene and modes= of Python take; in a comment the <inertial> "
    "that belongs to them. SI units.",
    [Option("link", None, "NAME", "The link, clamped at its frame, which the beam leaves along the "
            "axis"),
     Option("joint", None, "NAME", "Child joint at the tip (none)"),
     Option("axis", None, "x|y|z", "Of the beam in the link (x)", word(("x", "y", "z")), "x"),
     Option("length", None, "M", "Length", positive()),
     Option("mass", None, "KG", "Mass; or by --density and a section", positive()),
     Option("bending", None, "EI[,EI]", "Bending stiffness, N m^2, for deflections along the two "
            "axes that follow --axis (of x: y and z); or by --young and a section", pair),
     Option("torsion", None, "GJ,J", "Torsional stiffness, N m^2, and moment of inertia of a metre "
            "about the axis, kg m; or by --shear, --density and a section", two),
     Option("rectangle", None, "W,H", "Section: widths along the two axes that follow --axis", two),
     Option("tube", None, "D,T", "Section: outer diameter and wall; a round bar has T = D/2", two),
     Option("density", None, "RHO", "kg/m^3", positive()),
     Option("young", None, "E", "Young's modulus, N/m^2", positive()),
     Option("shear", None, "G", "Shear modulus, N/m^2", positive()),
     Option("modes", "n", "N[,N]", "Bending modes along the two axes (2)", counts, [2, 2]),
     Option("torsion-modes", None, "N", "(0)", whole(0, MODES_MAX), 0),
     Option("damping", None, "RATIO", "Of critical, of every mode (0)", not_negative, 0.0),
     Option("limit", None, "X", "Bound of each coordinate, m or rad (a tenth of the length, 0.1 "
            "rad)", positive())],
    "A coordinate is the deflection of the tip in m, of torsion its rotation in rad.")


def section(o):
    """Area, second moments for deflections along the two axes, torsion constant; m, None: none"""
    if o.rectangle and o.tube:
        raise command.Usage("--rectangle and --tube: a beam has one section")
    if o.rectangle:
        w, h = o.rectangle
        a, b = max(w, h), min(w, h)
        # within 0.5 % (Young and Budynas, Roark's Formulas for Stress and Strain, 2002, 10.7)
        constant = a * b**3 * (1 / 3 - 0.21 * b / a * (1 - b**4 / (12 * a**4)))
        return w * h, [h * w**3 / 12, w * h**3 / 12], constant
    if o.tube:
        outer, inner = o.tube[0], o.tube[0] - 2 * o.tube[1]
        if inner < 0:
            raise command.Usage("--tube: the wall is at most half of the diameter")
        moment = math.pi / 64 * (outer**4 - inner**4)
        return math.pi / 4 * (outer**2 - inner**2), [moment, moment], 2 * moment
    return None


def read(o):
    """Fills mass, bending and torsion from the section; `rotary`: moments of inertia of a metre
    about the second and first axis across, and about the beam's."""
    cut = section(o)
    o.rotary = [0.0, 0.0, o.torsion[1] if o.torsion else 0.0]
    if cut and o.density:
        o.mass = o.mass or cut[0] * o.density * o.length
        o.rotary = [o.density * cut[1][0], o.density * cut[1][1], o.density * sum(cut[1])]
        if o.torsion:
            o.rotary[2] = o.torsion[1]
        elif o.shear:
            o.torsion = [o.shear * cut[2], o.rotary[2]]
    if cut and o.young:
        o.bending = o.bending or [o.young * moment for moment in cut[1]]


def parse(argv):
    o = COMMAND.parse(argv)
    for name in ("link", "length"):
        if not getattr(o, name):
            raise command.Usage(f"--{name} is missing")
    read(o)
    if not o.mass:
        raise command.Usage("--mass is missing, or --density and a section")
    if any(o.modes) and not o.bending:
        raise command.Usage("--bending is missing, or --young and a section")
    if o.torsion_modes and not o.torsion:
        raise command.Usage("--torsion is missing, or --shear, --density and a section")
    count = sum(o.modes) + o.torsion_modes
    if not 1 <= count <= MODES_MAX:
        raise command.Usage(f"--modes, --torsion-modes: {count} modes, a link has 1 to {MODES_MAX}")
    return o


def axes_of(o):
    """Unit vectors: along the beam, and the two that follow"""
    first = "xyz".index(o.axis)
    return [[float(k == (first + i) % 3) for k in range(3)] for i in range(3)]


def six(linear, d, angular, t):
    return [linear * x + 0.0 for x in d] + [angular * x + 0.0 for x in t]


def modes_of(o):
    """(what it is, unit of its coordinate, mode, direction d, rotation axis t), slowest first"""
    along, first, second = axes_of(o)
    rows = [("torsion", "rad", torsion(k, o.length, o.torsion[1] * o.length, o.torsion[0]),
             [0.0] * 3, along) for k in range(1, o.torsion_modes + 1)]
    # t = axis x d: a deflection along the first axis turns about the second, along the second
    # about minus the first
    for i, d, t in ((0, first, second), (1, second, [-x for x in first])):
        name = "bending along " + "xyz"[d.index(1.0)]
        rows += [(name, "m", bending(k, o.length, o.mass, o.bending[i]), d, t)
                 for k in range(1, o.modes[i] + 1)]
    return sorted(rows, key=lambda row: row[2]["stiffness"] / row[2]["mass"])


def inertial(o):
    """Centre of mass and the moments of inertia about it, by axes of the link"""
    along = "xyz".index(o.axis)
    com, moments = [0.0] * 3, [0.0] * 3
    com[along] = 0.5 * o.length
    moments[along] = o.rotary[2] * o.length
    for i in (1, 2):  # about the axis i, which deflections along the other one turn about
        moments[(along + i) % 3] = o.mass * o.length**2 / 12 + o.rotary[2 - i] * o.length
    return com, moments


def print_modes(o):
    com, moments = inertial(o)
    print(f"# {o.command}")
    print(f"# mass {o.mass!r} kg; coordinates: deflection (m) or rotation (rad) of the tip")
    print('# <inertial><origin xyz="{!r} {!r} {!r}"/>'.format(*com) + f'<mass value="{o.mass!r}"/>')
    print('#   <inertia ixx="{!r}" ixy="0" ixz="0" iyy="{!r}" iyz="0" izz="{!r}"/></inertial>'
          .format(*moments))
    print(f"links:\n  {json.dumps(o.link, ensure_ascii=False)}:\n    modes:")
    for name, unit, mode, d, t in modes_of(o):
        omega = math.sqrt(mode["stiffness"] / mode["mass"])
        tip = six(float(unit == "m"), d, mode["slope"], t)
        limit = o.limit or (0.1 * o.length if unit == "m" else 0.1)
        print(f"      # {name}, {omega / (2 * math.pi):.6g} Hz, coordinate in {unit}")
        print(f"      - momentum: {six(mode['linear'], d, mode['angular'], t)}")
        print(f"        mass: {mode['mass']!r}\n        stiffness: {mode['stiffness']!r}")
        print(f"        damping: {2 * o.damping * omega * mode['mass']!r}")
        print(f"        limit: {limit!r}")
        joint = f"{json.dumps(o.joint, ensure_ascii=False)}: {tip}" if o.joint else ""
        print(f"        shape: {{{joint}}}")


def main(argv):
    print_modes(parse(argv))
    return command.GOOD
