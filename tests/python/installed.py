# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`cmake --install` puts a complete package below the prefix, which needs PYTHONPATH alone."""
import os
import subprocess
import sys
import tempfile

import support

CODE = """
import numpy as np, pathlib, totalforce as tf
folder = pathlib.Path(tf.__file__).parent
assert {p.name for p in folder.iterdir()} >= {"py.typed", "_totalforce.pyi", "errors.py"}, folder
print(folder)
print(tf.Workspace(tf.Model("config/robots/arm7.urdf")).mass_matrix(np.zeros(7)).M.shape)
print([line for line in open("/proc/self/maps") if "libtotalforce" in line][0].split()[-1])
"""


class Installed(support.Case):
    def test_package(self):
        with tempfile.TemporaryDirectory(prefix="tfinst") as prefix:
            build = support.BIN.parent
            subprocess.run(
                ["cmake", "--install", str(build), "--prefix", prefix],
                check=True,
                stdout=subprocess.DEVNULL,
            )
            with open(build / "CMakeCache.txt") as cache:
                entry = [line for line in cache if line.startswith("TFA_PYTHON_DIR:")]
            path = f"{prefix}/{entry[0].strip().split('=')[1]}"
            environment = {**os.environ, "PYTHONPATH": path}
            environment.pop("LD_LIBRARY_PATH", None)
            done = subprocess.run(
                [sys.executable, "-c", CODE],
                cwd=support.SOURCE,
                env=environment,
                capture_output=True,
                text=True,
                timeout=5 * support.WAIT,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            lines = done.stdout.splitlines()
            self.assertEqual(lines[:2], [f"{path}/totalforce", "(7, 7)"])
            self.assertTrue(lines[2].startswith(prefix), lines[2])


if __name__ == "__main__":
    support.main()
