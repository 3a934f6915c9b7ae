# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`cmake --install` puts a complete package below the prefix, which needs PYTHONPATH alone."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
from importlib.machinery import EXTENSION_SUFFIXES

import support

CODE = """
import numpy as np, pathlib, totalforce as tf
folder = pathlib.Path(tf.__file__).parent
assert {p.name for p in folder.iterdir()} >= {"py.typed", "_totalforce.pyi", "errors.py"}, folder
print(folder)
print(tf.Workspace(tf.Model("config/robots/arm7.urdf")).mass_matrix(np.zeros(7)).M.shape)
print([line for line in open("/proc/self/maps") if "libtotalforce" in line][0].split()[-1])
"""

# what stands in place of the extension module or of numpy, and what the import says
REFUSALS = [
    ("_totalforce/__init__.py", "raise ImportError('liburdf_x.so.3: cannot open shared object file: No')",
     "needs the library liburdf_x.so.3"),
    ("_totalforce.cpython-30-x.so", "", "but: _totalforce.cpython-30-x.so"),
    ("../numpy/__init__.py", "raise ImportError('none here')", "NumPy 1.22 or later (none here)"),
    ("_totalforce/__init__.py", "raise ImportError('numpy has ABI 3')", "from FOLDER: numpy has ABI 3"),
]  # fmt: skip


class Installed(support.Case):
    def test_refusals(self):
        for name, text, wanted in REFUSALS:
            with self.subTest(wanted), tempfile.TemporaryDirectory() as folder:
                package = pathlib.Path(folder) / "totalforce"
                package.mkdir()
                for module in ("__init__.py", "import_error.py"):
                    shutil.copy(support.SOURCE / "lib/python/totalforce" / module, package)
                (package / name).parent.mkdir(exist_ok=True)
                if name.startswith("_totalforce/"):  # is found before the module beside it
                    (package / ("_totalforce" + EXTENSION_SUFFIXES[0])).touch()
                (package / name).write_text(text)
                done = subprocess.run(
                    [sys.executable, "-c", "import totalforce"],
                    env={**os.environ, "PYTHONPATH": folder}, capture_output=True, text=True,
                )  # fmt: skip
                self.assertEqual(done.returncode, 1)
                self.assertIn("ImportError: ", done.stderr)
                self.assertIn(wanted.replace("FOLDER", str(package)), done.stderr.splitlines()[-1])

    def test_package(self):
        with tempfile.TemporaryDirectory(prefix="tfinst") as prefix:
            build = support.BIN.parent
            subprocess.run(["cmake", "--install", str(build), "--prefix", prefix], check=True,
                           stdout=subprocess.DEVNULL)
            with open(build / "CMakeCache.txt") as cache:
                entry = [line for line in cache if line.startswith("TFA_PYTHON_DIR:")]
            path = f"{prefix}/{entry[0].strip().split('=')[1]}"
            environment = {**os.environ, "PYTHONPATH": path}
            environment.pop("LD_LIBRARY_PATH", None)
            done = subprocess.run([sys.executable, "-c", CODE], cwd=support.SOURCE, env=environment,
                                  capture_output=True, text=True, timeout=5 * support.WAIT)
            self.assertEqual(done.returncode, 0, done.stderr)
            lines = done.stdout.splitlines()
            self.assertEqual(lines[:2], [f"{path}/totalforce", "(7, 7)"])
            self.assertTrue(lines[2].startswith(prefix), lines[2])


if __name__ == "__main__":
    support.main()
