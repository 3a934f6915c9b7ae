# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Cost of the Python module over C, in one run: a batch of 512 states, and single calls.

    PYTHONPATH=build/release/python python3 tests/bench/python.py [--rounds N] [--bound RATIO]

C is the same request, computed in a loop of the module's private function _time. Rounds alternate
between both; medians. --bound: exit 1 if a batch takes longer than RATIO times C.
"""
import argparse
import pathlib
import platform
import statistics
import subprocess
import sys
import time

import numpy as np

import totalforce as tf

ROBOTS = pathlib.Path(__file__).resolve().parents[2] / "config" / "robots"
COUNT = 512
CASES = [("arm7", "fixed"), ("quadruped", "floating"), ("humanoid", "floating"),
         ("snake64", "fixed")]


def states(model, count):
    random = np.random.default_rng(1)
    fields = {"q": random.uniform(-1, 1, (count, model.q_count)),
              "v": random.uniform(-1, 1, (count, model.v_count)),
              "tau": random.uniform(-1, 1, (count, model.v_count))}
    if model.base_freedoms:
        fields["base_pose"] = np.tile([0, 0, 0, 0, 0, 0, 1.0], (count, 1))
    return fields


def of_python(function, repetitions, fields):
    """ns of one call, processor time of this thread: other programs do not count"""
    start = time.thread_time_ns()
    for _ in range(repetitions):
        function(**fields)
    return (time.thread_time_ns() - start) / repetitions


def compare(solver, op, fields, rounds, seconds=0.002):
    """Medians of C, of Python, and of the ratio and difference within a round."""
    function = getattr(solver, op)
    repetitions = max(1, int(seconds / (solver._time(3, op, **fields) * 1e-9)))
    pairs = []
    for _ in range(rounds):
        c = solver._time(repetitions, op, **fields)
        pairs.append((c, of_python(function, repetitions, fields)))
    return (statistics.median(c for c, _ in pairs), statistics.median(p for _, p in pairs),
            statistics.median(p / c for c, p in pairs), statistics.median(p - c for c, p in pairs))


def processor():
    """Model name as lscpu prints it"""
    lines = subprocess.run(["lscpu"], capture_output=True, text=True, check=False).stdout
    names = [line.split(":", 1)[1].strip() for line in lines.splitlines() if "Model name" in line]
    return names[0] if names else platform.machine()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=101)
    parser.add_argument("--bound", type=float)
    options = parser.parse_args()
    print(f"{processor()}, {tf.isa()}, Python {platform.python_version()}, numpy {np.__version__}")
    print(f"{'robot':10} {'task':34} {'C ns':>10} {'Python ns':>10} {'ratio':>7} {'over ns':>8}")
    worst = 0.0
    for name, base in CASES:
        model = tf.Model(ROBOTS / f"{name}.urdf", base=base)
        workspace = tf.Workspace(model)
        batch = states(model, COUNT)
        one = {field: numbers[0] for field, numbers in batch.items()}
        reply = workspace.forward_dynamics(**batch)
        of_state = {f: one[f] for f in one if f not in ("v", "tau")}
        tasks = [
            (f"forward_dynamics, {COUNT} states", "forward_dynamics", batch, True),
            ("the same, out=", "forward_dynamics", {**batch, "out": reply}, True),
            ("forward_dynamics", "forward_dynamics", one, False),
            ("mass_matrix", "mass_matrix", of_state, False),
            ("operational_inertia of a tip", "operational_inertia",
             {**of_state, "tips": [model.links[-1]]}, False),
        ]  # fmt: skip
        for text, op, fields, is_batch in tasks:
            c, python, ratio, over = compare(workspace, op, fields, options.rounds)
            worst = max(worst, ratio) if is_batch else worst
            print(f"{name:10} {text:34} {c:10.0f} {python:10.0f} {ratio:7.3f} {over:8.0f}")
    print(f"worst ratio of a batch: {worst:.3f}")
    return 1 if options.bound and worst > options.bound else 0


if __name__ == "__main__":
    sys.exit(main())
