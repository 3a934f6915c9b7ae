# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The examples of docs/examples/python run, cells apart, and come to their result."""
import os
import re
import subprocess
import sys

import support

EXAMPLES = support.SOURCE / "docs" / "examples" / "python"
# what each prints: a pattern and a bound of the number that it captures
RESULTS = {
    "forward_dynamics_batch.py": (r"largest difference from inverse dynamics: ([\d.e+-]+)", 1e-9),
    "operational_space_control.py": (r"error after 3 s: ([\d.e+-]+) mm", 0.1),
    "collision_detection.py": (r"worst of detection and errors: ([\d.e+-]+)", 0.03),
    "identification.py": (r"largest error without noise: ([\d.e+-]+)", 1e-9),
    "leg_with_rods.py": (r"worst of closure, rest and residual: ([\d.e+-]+)", 1e-9),
    "optimisation.py": (r"worst of swing-up .rad. and reach .m.: ([\d.e+-]+)", 1e-3),
    "quadruped_shifts_weight.py": (r"worst of weight, .* acceleration: ([\d.e+-]+)", 1e-9),
    "standing_and_reaching.py": (r"worst of soles, base wrench and task: ([\d.e+-]+)", 1e-9),
    "two_arms_hold_a_bar.py": (r"worst of closure, .* residual: ([\d.e+-]+)", 1e-8),
    "accuracy_of_two_methods.py": (r"worst error of aba, double: ([\d.e+-]+)", 1e-8),
}
ROBOTS = support.SOURCE / "tests" / "tools" / "data" / "example_robots"
OF_ANY_ROBOT = ("forward_dynamics_batch.py", "operational_space_control.py", "identification.py",
                "collision_detection.py", "accuracy_of_two_methods.py")


class Examples(support.Case):
    def test_every_example(self):
        names = sorted(path.name for path in EXAMPLES.glob("*.py"))
        self.assertEqual(names, sorted(RESULTS))
        for name in names:
            with self.subTest(name):
                self.assertGreater((EXAMPLES / name).read_text().count("\n# %%"), 2, "cells")
                self.comes_to_its_result(name)

    def test_any_robot(self):
        for line in ROBOTS.read_text().splitlines():
            file, tip = line.split()
            for name in OF_ANY_ROBOT:
                with self.subTest(name, file=file):
                    if not (support.SOURCE / file).exists():
                        self.skipTest(f"{file} is not there")
                    self.comes_to_its_result(name, file, tip)

    def comes_to_its_result(self, name, *arguments):
        done = subprocess.run([sys.executable, "-W", "error", str(EXAMPLES / name), *arguments],
                              capture_output=True, text=True, timeout=5 * support.WAIT,
                              cwd=support.SOURCE, env=dict(os.environ))
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        pattern, bound = RESULTS[name]
        found = re.search(pattern, done.stdout)
        self.assertTrue(found, done.stdout)
        self.assertLess(float(found[1]), bound)


if __name__ == "__main__":
    support.main()
