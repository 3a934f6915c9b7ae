# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce drift`: energy over simulated time, a line for each method, precision and step."""
import math

import numpy as np

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools import cases, command, drift_integrate
from totalforce_tools.command import Option, each, number, positive, whole, word

ENERGY_LOST = 1e3  # an energy off by this much of its scale ends a line
COLUMNS = ("mechanism,bodies,integrator,step_s,method,precision,refine,floor,time_s,energy_error,"
           "largest_error,status")
HEAD = f"""\
# the robot swings from rest without torques and friction, %g s by %s in double; seed %d
# energy_error: kinetic and potential energy (in f128) less that of the start, over the kinetic \
energy of the start plus the weight of what moves times the distance of its centre of mass from \
the origin; largest_error: of all samples so far
# floor 1: accelerations by aba in f128, rounded to double: the error of integrator and state alone
{COLUMNS}
"""
AFTER = """Integrators:
{}
Errors are relative to the kinetic energy of the start plus the weight of what moves times the \
distance of its centre of mass from the origin."""


def read_steps(text, before):
    steps = [number(entry) for entry in text.split(",")]
    for step in steps:
        if not 0 < step <= 10:
            raise ValueError(f"{step:g}, must be above 0 and at most 10")
    return [*(before or []), *steps]


COMMAND = command.Command(
    "drift",
    "Lets a robot swing freely - no torques, no friction, gravity on - and prints how its energy "
    "drifts: a line for each method, precision and step, and one with accelerations in quadruple "
    "precision, which is the error of the integrator alone.",
    [Option("urdf", None, "FILE", "A robot on a fixed base"),
     Option("mechanism", "m", "MECHANISM", "In place of a robot (random)", cases.read_mechanism,
            "random"),
     Option("bodies", "n", "N", "Of the mechanism (8)", whole(1, 16384), 8),
     Option("methods", "M", "METHOD,...", "Of forward dynamics (aba)", each(cases.read_method, 32)),
     Option("precision", None, "|".join(cases.PRECISIONS) + ",...",
            "Arithmetic of the accelerations (f64)",
            each(word(tuple(cases.PRECISIONS)), len(cases.PRECISIONS))),
     Option("step", None, "S,...", "Steps in seconds (0.001)", read_steps),
     Option("integrator", None, "euler|rk4|gbs8", "(gbs8)",
            word(tuple(drift_integrate.INTEGRATORS)), "gbs8"),
     Option("refine", None, "0|1|2", "Refinement steps (0; mixed: 1)", whole(0, 2), 0),
     Option("seconds", None, "S", "Simulated time (10)", positive(1e6), 10.0),
     Option("samples", None, "N", "Energies of each line (100)", whole(1, 100000), 100),
     Option("turn", None, "X", "Joint angles at the start within +-X rad (1 for mechanisms, 3 for "
            "robots)", positive(1e3)),
     Option("seed", "s", "N", "Of the random numbers (1)", whole(0, 2**64 - 1), 1),
     Option("output", "o", "FOLDER", "Write drift.csv, SVG and PNG there")],
    AFTER.format("".join(f"  {name}: {integrator.__doc__}\n"
                         for name, integrator in drift_integrate.INTEGRATORS.items())),
    words={"METHOD": cases.FORWARD, "MECHANISM": _totalforce._mechanisms()})


class Swing:
    """A robot that swings from a state at rest, and its energy then."""

    def __init__(self, case):
        model = case.model
        if model.base_freedoms or not model.v_count or any(j.q_count != 1 for j in model.joints):
            raise command.Failed(f"{case.name}: only revolute, continuous and prismatic joints on "
                                 "a fixed base move here")
        self.case, self.n = case, model.v_count
        width = np.array([case.reach(joint) for joint in model.joints])
        self.start = case.random.uniform(-width, width, self.n)
        reply = case.exact.kinematics(self.start, np.zeros(self.n), want=["energy", "com"])
        self.energy = float(reply.energy[0] + reply.energy[1])
        squares = [sum(float(x) * float(x) for x in vector)
                   for vector in (model.summary.gravity, reply.com)]
        self.scale = float(reply.energy[0] + reply.mass * math.sqrt(squares[0] * squares[1]))

    def error(self, y):
        energy = self.case.exact.kinematics(y[:self.n], y[self.n:], want=["energy"]).energy
        return float((energy[0] + energy[1] - self.energy) / self.scale)


class Line:
    """Errors of a run, its accelerations by one method; `floor`: in quadruple precision"""

    def __init__(self, method, precision, refine, step, floor=False):
        self.method, self.precision, self.refine = method, precision, refine
        self.step, self.floor, self.status = step, floor, "ok"
        self.times, self.errors = [], []

    @property
    def name(self):
        refined = "" if "+" in self.precision or not self.refine else f"+{self.refine}"
        return f"{self.method}{refined} {self.precision}"

    @property
    def largest(self):
        """Largest error up to each sample"""
        sizes = np.abs(np.array(self.errors, float))
        return np.maximum.accumulate(np.where(np.isfinite(sizes), sizes, np.inf))

    @property
    def last(self):
        return float(self.largest[-1]) if self.errors else 0.0

    def acceleration(self, case):
        """Of q and v, by the line's method"""
        factors, residual = cases.PRECISIONS[self.precision]
        solver = case.exact if self.floor else tf.Workspace(
            case.model, precision=factors, residual=residual, methods=list(cases.METHODS))
        return lambda q, v: solver.forward_dynamics(
            q, v, method=self.method, refine=self.refine, estimate="never").qdd

    @np.errstate(all="ignore")  # a line that is lost may overflow before its next sample
    def run(self, swing, given, accelerate=None):
        """Steps and samples until the end, or until an answer fails"""
        integrate = drift_integrate.INTEGRATORS[given.integrator]
        steps, done = max(1, int(given.seconds / self.step + 0.5)), 0
        y = np.concatenate([swing.start, np.zeros(swing.n)])
        try:
            system = drift_integrate.System(swing.n, accelerate or self.acceleration(swing.case))
            for k in range(1, given.samples + 1):
                for done in range(done + 1, steps * k // given.samples + 1):
                    y = integrate(system, self.step, y)
                error = swing.error(y)
                self.times.append(done * self.step)
                self.errors.append(error)
                if not abs(error) <= ENERGY_LOST:
                    break
        except tf.Error as error:
            self.status = error.status
        return self


def plan(given):
    """Lines of a run: the floor of each step, then all methods and precisions with it."""
    for step in given.step:
        yield Line("aba", "f128", 0, step, floor=True)
        for precision in given.precision:
            for method in given.methods:
                yield Line(method, precision, given.refine or int("+" in precision), step)


def write(out, swing, given, line):
    head = (f"{swing.case.name},{swing.case.bodies},{given.integrator},{line.step:g},{line.method},"
            f"{line.precision},{line.refine},{int(line.floor)},")
    for time, error, largest in zip(line.times, line.errors, line.largest):
        print(f"{head}{time:.6g},{error:.3e},{largest:.3e},ok", file=out)
    if line.status != "ok":
        print(f"{head},,,{line.status}", file=out)
    out.flush()


def sentences(given, lines):
    for line in lines:
        end = line.times[-1] if line.times else 0.0
        if line.floor:
            floor = line
            yield (f"step {line.step:g} s, {given.integrator}: the integrator drifts by "
                   f"{line.last:.1e} in {end:g} s")
        else:
            with np.errstate(all="ignore"):
                ratio = np.float64(line.last) / floor.last
            then = "" if line.status == "ok" else f"; then {line.status}"
            yield (f"  {line.name}: {line.last:.1e} in {end:g} s, {ratio:.2g} times the "
                   f"integrator's{then}")


def open_case(given):
    if given.urdf:
        return cases.load_case(given.urdf, given.seed, "fixed", turn=given.turn or 3.0)
    return cases.Case.mechanism(given.mechanism, given.bodies, given.seed, turn=given.turn or 1.0)


def main(argv):
    given = COMMAND.parse(argv)
    given.step = given.step or [1e-3]
    given.methods, given.precision = given.methods or ["aba"], given.precision or ["f64"]
    for step in given.step:
        if step * given.samples > given.seconds * (1.0 + 1e-9):
            raise command.Usage(f"--step: {step:g} s are less than {given.samples} steps in "
                                f"{given.seconds:g} s; --samples says how many energies")
    swing = Swing(open_case(given))
    lines, out = [], command.open_rows("drift", given.output, False)
    command.print_head(out, given.command)
    out.write(HEAD % (given.seconds, given.integrator, given.seed))
    for line in plan(given):
        lines.append(line.run(swing, given))
        write(out, swing, given, line)
    print("\n".join(f"# {text}" for text in sentences(given, lines)), file=out, flush=True)
    if given.output:
        from totalforce_tools import drift_picture

        out.close()
        print("\n".join(sentences(given, lines)), flush=True)
        drift_picture.draw(swing.case, given, lines)
    return command.GOOD
