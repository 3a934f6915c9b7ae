# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Options that say how a URDF becomes a model - policies and the scene - and loading it."""
import os
import sys

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools.command import Group, Option, Usage, number, word

SNAP_MAX = 0.01  # rad
FRICTION_VELOCITY_MIN = 1e-9  # rad/s or m/s
POLICIES = {"base": "fixed|floating", "mimic": "free|project|lock",  # in the order of their numbers
            "inertia": "strict|warn|repair|strict-physical"}
PAYLOAD = "LINK:MASS[,X,Y,Z[,IXX,IXY,IXZ,IYY,IYZ,IZZ]]"


def find_kernel(folder, model):
    """The specialised kernel of a robot in this folder. @raises tf.Error: it has none of use"""
    return tf.Specialised(os.path.join(folder, tf.Specialised.file_name(model)), model)


def choice(name, words, what, letter=None, default=None):
    """An option whose value is one of the words "a|b|c"."""
    return Option(name, letter, words, what, word(words.split("|")), default)


def numbers(text, most):
    fields = text.split(",")
    try:
        if len(fields) <= most:
            return [number(field) for field in fields]
    except ValueError:
        pass
    raise ValueError(f"'{text}' is not 1 to {most} finite numbers with commas between")


def vector(text, _):
    values = numbers(text, 3)
    if len(values) != 3:
        raise ValueError(f"'{text}' is not three finite numbers x,y,z")
    return values


def split(text, mark, form):
    """Names may hold the mark, numbers do not."""
    name, found, rest = text.rpartition(mark)
    if not found or not name:
        raise ValueError(f"'{text}' is not {form}")
    return name, rest


def read_lock(text, before):
    joint, values = split(text, "=", "JOINT=VALUE")
    return (before or []) + [(joint, numbers(values, 7))]


def read_payload(text, before):
    link, values = split(text, ":", PAYLOAD)
    n = numbers(values, 10)
    if len(n) not in (1, 4, 10):
        raise Usage(f"--payload {link}: {len(n)} numbers, must be 1, 4 or 10: {PAYLOAD}")
    if n[0] < 0:
        raise Usage(f"--payload {link}: mass {n[0]:g} must not be negative")
    n += [0.0] * (10 - len(n))
    return (before or []) + [{"link": link, "mass": n[0], "com": n[1:4], "inertia": n[4:]}]


def read_root(text, before):
    if before:
        raise ValueError(f"given twice, '{before}' and '{text}'")
    return text


def read_snap(text, _):
    if not 0 <= number(text) <= SNAP_MAX:
        raise ValueError(f"{text} is not an angle from 0 to {SNAP_MAX:g} rad")
    return number(text)


def read_friction_velocity(text, _):
    if not number(text) >= FRICTION_VELOCITY_MIN:
        raise ValueError(f"{text} is no velocity from {FRICTION_VELOCITY_MIN:g} rad/s or m/s on")
    return number(text)


def read_inertia(text, before):
    joint, inertia = split(text, "=", "JOINT=INERTIA")
    return (before or {}) | {joint: number(inertia)}


OPTIONS = [
    Group("How the file becomes a model:"),
    choice("base", POLICIES["base"], "The root link (fixed)"),
    Option("gravity", None, "X,Y,Z", "Gravity in the world, m/s^2 (0,0,-9.80665)", vector),
    choice("mimic", POLICIES["mimic"], "Joints that mimic others are ordinary joints, follow "
           "exactly, or stand still (free)"),
    choice("inertia", POLICIES["inertia"], "An inertia that no body can have: "
           "strict refuses negative eigenvalues, strict-physical a broken triangle inequality, "
           "too; warn uses it as written; repair makes negative eigenvalues 0 (strict)"),
    Option("rotor-inertia", None, None,
           "Apply drake:rotor_inertia of the file (left out unless asked for)"),
    Option("damping", None, None, "Apply the damping of the file (left out unless asked for)"),
    Option("friction", None, None, "Apply the friction of the file (left out unless asked for)"),
    Option("friction-velocity", None, "SPEED", "Below this speed, rad/s or m/s, friction fades to "
           "0 at rest (0.01)", read_friction_velocity),
    Option("lock-massless-leaves", None, None,
           "Lock joints that move nothing with mass (an error unless asked for)"),
    Option("snap", None, "ANGLE", "Rotations within ANGLE rad of right angles become exactly "
           "that; a note says what the largest change was (as in the file)", read_snap),
    Group("Parts of it that are modelled:"),
    Option("lock", None, "JOINT=VALUE", "Joint that stands still at this coordinate (several: "
           "x,y,..), as if it were fixed", read_lock),
    Option("root", None, "LINK", "Only the subtree of this link", read_root),
    Option("tip", None, "LINK", "Only the trees that carry one of these links (fixed base)",
           lambda text, before: (before or []) + [text]),
    Option("payload", None, PAYLOAD, "Load on a link: kg, its centre of mass in m, its inertia "
           "about that in kg m^2", read_payload),
    Option("rotor", None, "JOINT=INERTIA", "Inertia of a motor's rotor, kg m^2, times the square "
           "of the joint's reduction in the file added to its armature", read_inertia),
    Option("armature", None, "JOINT=INERTIA", "Reflected inertia of a joint's rotor, kg m^2 or kg, "
           "in place of the file's armature", read_inertia),
    Option("modes", None, "FILE", "Modes of flexible links, as YAML (`totalforce beam` writes "
           "those of a beam)", lambda text, before: (before or []) + [text]),
    Option("constraints", None, "FILE", "Closed loops, contacts and joints with a motor, as YAML",
           lambda text, before: (before or []) + [text]),
    Group("--lock, --tip, --payload, --rotor, --armature, --modes and --constraints may be given "
          "several times."),
]


def format_message(m):
    """As tfa_report_format"""
    before = m.file or ("line " if m.line else "")
    colon = "" if not m.file else ":" if m.line else ": "
    where = f"{m.line}: " if m.line else ""
    return f"{before}{colon}{where}{m.severity}: {m.text} [{m.code}]"


def check_locks(model, locks):
    """The joints exist, or there were no model."""
    declared = {joint.name: joint for joint in model.declared}
    bad = [(name, len(values), declared[name].coordinates) for name, values in locks
           if len(values) != declared[name].coordinates]
    for name, given, wanted in bad:
        print(f"--lock {name}: {given} numbers; the joint has {wanted} coordinate"
              + ("" if wanted == 1 else "s: x,y,.."), file=sys.stderr)
    if bad:
        raise SystemExit(2)


def load(path, o):
    """The model of a file ("-": of standard input) as the options `o` say. What its report says
    goes to standard error; the program ends without one."""
    locks = o.lock or []
    options = {
        "base": o.base, "gravity": o.gravity, "mimic": o.mimic, "inertia": o.inertia,
        "rotor_inertia": o.rotor_inertia, "damping": o.damping, "friction": o.friction,
        "friction_velocity": o.friction_velocity, "rotors": o.rotor, "armature": o.armature,
        "snap": o.snap, "root": o.root, "lock_massless_leaves": o.lock_massless_leaves,
        "tips": o.tip, "payload": o.payload,
        "modes": o.modes, "constraints": o.constraints,
        # seven numbers are room for any joint
        "locked": [(name, values + [0.0] * (7 - len(values))) for name, values in locks],
    }
    _totalforce._speak_command_line()  # messages name options, not arguments of Model
    try:
        if path == "-":
            model = tf.Model._restore(sys.stdin.buffer.read(), "(standard input)", options)
        else:
            model = tf.Model(path, **options)
    except tf.LoadError as error:
        shown = [m for m in error.messages if m.severity != "note"]
        lines = [format_message(m) for m in shown] or [str(error)]
        print(*lines, sep="\n", file=sys.stderr)
        raise SystemExit(2) from None
    for warning in model.warnings:
        print(warning, file=sys.stderr)
    check_locks(model, locks)
    return model
