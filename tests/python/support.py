# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What the tests of the Python module share: robots, states, the command line, a daemon.

Every test is a program: python3 TEST.py SOURCE_FOLDER BIN_FOLDER.
"""
import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import totalforce as tf

SOURCE = pathlib.Path(sys.argv[1])
BIN = pathlib.Path(sys.argv[2])
sys.path.append(str(SOURCE / "tests" / "support"))
import guard
from wait import WAIT, waiting

ROBOTS = SOURCE / "config" / "robots"
TOOL = str(BIN / "totalforce")
DAEMON = str(BIN / "totalforced")

# file, base, a tip or two
ROBOT_LIST = [("arm6", "fixed", ["tool0"]), ("arm7", "fixed", ["tool0", "link_4"]),
              ("humanoid", "fixed", None), ("humanoid", "floating", None),
              ("quadruped", "floating", ["FL_foot", "HR_foot"]), ("snake64", "fixed", None)]


def load(name, base="fixed", **options):
    return tf.Model(ROBOTS / f"{name}.urdf", base=base, **options)


def tips_of(model, tips):
    links = [t for t in tips or () if t in model.links]
    return links or [model.links[-1], model.links[len(model.links) // 2]]


def state(model, rng, count=None):
    """q, v, tau and the fields of a floating base of one state or of `count` states."""
    lead = () if count is None else (count,)
    q = rng.uniform(-1.5, 1.5, lead + (model.q_count,))
    for joint in model.joints:
        if joint.type == "floating":
            part = q[..., joint.q_index + 3 : joint.q_index + 7]
            part /= np.linalg.norm(part, axis=-1, keepdims=True)
    fields = {"q": q, "v": rng.uniform(-1, 1, lead + (model.v_count,)),
              "tau": rng.uniform(-5, 5, lead + (model.v_count,))}
    if model.base_freedoms:
        pose = rng.uniform(-1, 1, lead + (7,))
        pose[..., 3:] /= np.linalg.norm(pose[..., 3:], axis=-1, keepdims=True)
        fields["base_pose"] = pose
        fields["base_twist"] = rng.uniform(-1, 1, lead + (6,))
        fields["base_wrench"] = rng.uniform(-5, 5, lead + (6,))
    return fields


def json_value(value):
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {key: json_value(entry) for key, entry in value.items()}
    return value


def json_line(op, fields):
    return json.dumps({"op": op, **{name: json_value(v) for name, v in fields.items()}})


def run_tool(arguments, lines):
    done = subprocess.run([TOOL, *arguments], input="\n".join(lines) + "\n", capture_output=True,
                          text=True, timeout=5 * WAIT)
    if done.returncode:
        raise AssertionError(done.stderr)
    # "-0" is a number with a sign
    return [json.loads(line, parse_int=float) for line in done.stdout.splitlines()]


def side_by_side(numbers):
    """Those of an object of constraints, in its order."""
    return sum(numbers.values(), []) if isinstance(numbers, dict) else numbers


def json_arrays(model_or_client, answer):
    """Arrays of a JSON answer under the names of Reply."""
    arrays = {}
    for key, value in answer.items():
        if key == "poses":
            value = [value[link] for link in model_or_client.links]
        elif key.startswith("constraint_"):
            value = side_by_side(value)
        elif key == "lost":
            value = [[r["singular_value"], r.get("given_up", 0), *side_by_side(r["direction"])]
                     for r in value]
            if not value:
                continue
            value += [[0] * len(value[0])] * (6 - len(value))
        elif key == "energy":
            value = [value["kinetic"], value["potential"]]
        elif not isinstance(value, list) and key != "mass":
            continue
        arrays[key] = np.array(value, dtype=float)
    return arrays


@contextlib.contextmanager
def daemon(robots, options=""):
    """A daemon for (name, file, base) in a runtime folder of its own: gives folder and process.

    options: further lines of each robot.
    """
    with tempfile.TemporaryDirectory(prefix="tfpy") as folder:
        config = pathlib.Path(folder) / "config.yaml"
        entries = "".join(
            f"  - name: {name}\n    urdf: {ROBOTS / (file + '.urdf')}\n    base: {base}\n{options}"
            for name, file, base in robots
        )
        config.write_text(f"runtime_dir: {folder}/run\nmax_state_us: 0\ndds:\n  enabled: false\nrobots:\n{entries}")
        with open(f"{folder}/log", "w") as log:
            process = guard.start([DAEMON, str(config)], stdout=log, stderr=log)
        try:
            wait_for(f"{folder}/run", robots[0][0], process)
            yield f"{folder}/run", process
        finally:
            guard.end(process)


def wait_for(folder, robot, process):
    for _ in waiting():
        with contextlib.suppress(tf.DisconnectedError, tf.SystemCallError, tf.TimedOutError):
            tf.Client(robot, runtime_dir=folder).close()
            return
        if process.poll() is not None:
            raise AssertionError(f"the daemon ended with {process.returncode}")
    raise AssertionError("the daemon does not start")


def python(code, *arguments):
    """Runs a program of its own interpreter with the same module."""
    return subprocess.run([sys.executable, "-c", code, str(SOURCE), str(BIN), *arguments],
                          capture_output=True, text=True, timeout=5 * WAIT,
                          env={**os.environ, "PYTHONPATH": os.environ["PYTHONPATH"]})


def resident_kib():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


class Case(unittest.TestCase):
    """Assertions about bits and exceptions"""

    def same_bits(self, got, wanted, what):
        got, wanted = np.asarray(got, dtype=float), np.asarray(wanted, dtype=float)
        self.assertEqual(got.size, wanted.size, what)
        if got.tobytes() != wanted.tobytes():
            self.fail(f"{what}: {got} is not {wanted}")

    @contextlib.contextmanager
    def fails(self, kind, text="", **attributes):
        with self.assertRaises(kind) as caught:
            yield
        self.assertIsInstance(caught.exception, tf.Error)
        self.assertIn(text, str(caught.exception))
        for name, value in attributes.items():
            self.assertEqual(getattr(caught.exception, name), value, name)


def main():
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
