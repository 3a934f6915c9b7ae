# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Robots and states to measure methods on, their answers in quadruple precision, and the floor: how
far these move when every number of robot and request is rounded as a computation in double rounds
it."""
import math
import re
import statistics
import sys

import numpy as np

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools.command import Failed

GOLDEN = 0x9E3779B97F4A7C15
DENSE_BODIES_MAX = 128  # a dense M of more takes more than a second in quadruple precision
METHODS = {method.name: method for method in tf.methods()}
FORWARD = [name for name, method in METHODS.items()
           if "forward_dynamics" in method.ops and name != "auto"]
RHS = ("qdd", "tau", "gravity")
# arithmetic of the factors, and of the residual of refinement steps
PRECISIONS = {"f64": ("f64", "same"), "f32": ("f32", "same"), "f32+f64": ("f32", "f64"),
              "f64+f128": ("f64", "f128"), "f128": ("f128", "same")}
NO_DIGIT = 0.1  # errors from here on are no answer


class Random:
    """splitmix64, as lib/mechanism has it: the same numbers everywhere."""

    def __init__(self, seed):
        self.state = seed % 2**64

    def bits(self, count):
        z = np.uint64(self.state) + np.arange(1, count + 1, dtype=np.uint64) * np.uint64(GOLDEN)
        self.state = (self.state + count * GOLDEN) % 2**64
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return z ^ (z >> np.uint64(31))

    def uniform(self, low, high, count):
        return low + (high - low) * (self.bits(count) >> np.uint64(11)).astype(float) * 2.0**-53

    def normal(self, count):
        """Mean 0, variance 1: twelve uniform numbers added from the left."""
        total = np.full(count, -6.0)
        for column in self.uniform(0.0, 1.0, 12 * count).reshape(count, 12).T:
            total = total + column
        return total

    def quaternion(self):
        q = self.normal(4)
        return q / math.sqrt(sum(float(x) * float(x) for x in q))

    def moved(self, values):
        """Each number goes to its upper or lower neighbour or stays; 0 stays 0."""
        way = (self.bits(values.size) % np.uint64(3)).reshape(values.shape)
        to = np.where(way == 0, np.inf, np.where(way == 1, -np.inf, values))
        return np.where(values == 0.0, 0.0, np.nextafter(values, to))


def read_method(text, _):
    """An option's value: a method of forward dynamics"""
    if text not in (*FORWARD, "auto"):
        raise ValueError(f"no '{text}' of forward dynamics; `totalforce methods` lists them")
    return text


def read_mechanism(text, _):
    if text not in _totalforce._mechanisms():
        raise ValueError(f"no '{text}'; `totalforce chain --help` lists them")
    return text


def subject_of(error):
    """What an error is about: an argument, a link"""
    return f"{error.field or ''} {error.link or ''}".strip()


def median(values):
    return statistics.median(float(v) for v in values)


def error_of(found, exact):
    """Relative 2-norm, and the largest relative error of one component"""
    change = found - exact
    size = math.sqrt(np.dot(exact, exact))
    error = math.sqrt(np.dot(change, change)) / (size if size > 0.0 else 1.0)
    some = exact != 0.0
    return error, float(np.max(np.abs(change[some] / exact[some]), initial=0.0))


class Case:
    """A model with what its exact answers stand on. `source` is what the peers read: the name of a
    file, or URDF as bytes."""

    TURN_MECHANISM, TURN_ROBOT = 1e-3, 3.0  # mechanisms have their shape at q = 0

    def __init__(self, name, source, seed, turn=None, tip=None, **options):
        self.source, self.random = source, Random(seed)
        self.model = tf.Model(source, **options)
        is_file = not isinstance(source, bytes)
        self.bodies = self.model.summary.bodies
        self.turn = turn or (self.TURN_ROBOT if is_file else self.TURN_MECHANISM)
        # a word of CSV, JSON and file names
        self.name = re.sub("[^A-Za-z0-9._-]", "_", self.model.name) if is_file else name
        moved = self.model._moved(seed ^ GOLDEN)
        self.exact = tf.Workspace(self.model, precision="f128", methods=list(METHODS))
        self.moved = tf.Workspace(moved, precision="f128", round_sincos=True)
        self.tip = tip if tip in self.model.links else deepest(self.model)

    def reach(self, joint):
        """Joint coordinates are drawn within +- this."""
        return 0.1 * self.turn if joint.type == "prismatic" else self.turn

    @staticmethod
    def mechanism(label, bodies, seed, value=None, **options):
        """NAME or NAME:X, X being its mass ratio, taper or radius"""
        name = label.partition(":")[0]
        changed = {"taper": "taper", "thin": "radius"}.get(name, "ratio")
        changes = {changed: value} if value else {}
        source = _totalforce._mechanism(name, bodies, seed=seed, **changes)
        case = Case(label, source, seed, **options)
        case.bodies = bodies
        return case


def depths_of(model):
    """Of each body, how many bodies are on its path to the world"""
    depths = []
    for body in model.bodies:
        depths.append(1 + (depths[body.parent] if body.parent >= 0 else 0))
    return depths


def deepest(model):
    """Link of the body behind most joints"""
    depths = depths_of(model)
    return model.bodies[depths.index(max(depths))].name if depths else model.links[0]


def load_case(file, seed, base, **options):
    """The case of a file; the messages of one that is refused are told."""
    try:
        return Case(None, file, seed, base=base, lock_massless_leaves=True, **options)
    except tf.LoadError as error:
        print(error, file=sys.stderr)
        raise Failed from None


def exact_method(op, bodies):
    if op == "forward_dynamics":
        return "aba"
    return "crba" if bodies <= DENSE_BODIES_MAX else "propagation"


class States:
    """Random states of a case for one op and right-hand side, and the exact answers.

    qdd: torques of a random qdd, computed in quadruple precision and rounded; tau: random torques;
    gravity: at rest. `requests` are arguments of Workspace.compute without the method."""

    def __init__(self, case, op, rhs, count):
        self.case, self.op, self.rhs, self.count = case, op, rhs, count
        model = case.model
        self.floats = model.base_freedoms > 0
        self.q, self.v = np.zeros((count, model.q_count)), np.zeros((count, model.v_count))
        self.tau, self.pose = np.zeros((count, model.v_count)), np.zeros((count, 7))
        self.method = exact_method(op, case.bodies)
        self.exact = [self._draw(s) for s in range(count)]
        self.floor = self._find_floor()

    def _draw(self, s):
        random, n = self.case.random, self.v.shape[1]
        self._draw_coordinates(self.q[s])
        if self.floats:
            self.pose[s, 3:] = random.quaternion()
        if self.rhs != "gravity":
            self.v[s] = random.normal(n)
        if self.rhs == "tau":
            self.tau[s] = random.normal(n)
        if self.rhs == "qdd" and self.op == "forward_dynamics":
            fields = {k: v for k, v in self.request(s).items() if k not in ("tau", "estimate")}
            self.tau[s] = self.case.exact.inverse_dynamics(
                **fields, qdd=random.normal(n), method="rnea").tau
        return self.answer(self.case.exact.compute(self.op, **self.request(s), method=self.method))

    def _draw_coordinates(self, q):
        random, at = self.case.random, 0
        width = np.concatenate([np.zeros(0)] + [
            np.full(j.q_count, self.case.reach(j)) for j in self.case.model.joints])
        for joint in self.case.model.joints:
            if joint.q_count > joint.v_count:  # its quaternion is drawn behind its numbers
                end = joint.q_index + joint.q_count
                q[at:end] = random.uniform(-width[at:end], width[at:end], end - at)
                q[end - 4 : end] = random.quaternion()
                at = end
        q[at:] = random.uniform(-width[at:], width[at:], len(q) - at)

    def _find_floor(self):
        random, kept = self.case.random, (self.q, self.v, self.tau, self.pose)
        self.q, self.v, self.tau, self.pose = (random.moved(a) for a in kept)
        gravity = random.moved(np.array([0.0, 0.0, -9.80665]))
        errors = []
        for s in range(self.count):
            reply = self.case.moved.compute(self.op, **self.request(s), method=self.method,
                                            gravity=gravity)
            errors.append(error_of(self.answer(reply), self.exact[s])[0])
        self.q, self.v, self.tau, self.pose = kept
        return max(median(errors), 2.0**-53)  # and the answer is rounded

    def request(self, s):
        """Arguments of state s; of a batch where s is an array of states"""
        fields = {"q": self.q[s], "estimate": "never"}
        if self.op == "forward_dynamics":
            fields.update(v=self.v[s], tau=self.tau[s])
        else:
            fields["tips"] = [self.case.tip]
        if self.floats:
            fields["base_pose"] = self.pose[s]
        return fields

    def answer(self, reply, s=()):
        """All numbers of an answer; of state s of a batch"""
        if self.op != "forward_dynamics":
            return reply.lambda_inv[s].ravel()
        if self.floats:
            return np.concatenate([reply.qdd[s], reply.base_acceleration[s]])
        return reply.qdd[s]
