# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`pip wheel` makes a wheel that carries its libraries; a fresh venv answers with it."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile
from importlib.util import find_spec
from shutil import which

import support

# of the platform, as PEP 600 has them
OUTSIDE = re.compile(r"(libc|libm|libdl|libpthread|libgcc_s|libstdc\+\+|ld-linux-.*)\.so\.\d")
APT = which("dpkg-query")
CODE = """
import numpy as np, totalforce as tf
print(tf.Workspace(tf.Model(%r)).mass_matrix(np.zeros(7)).M.shape, tf.__file__)
print(*{line.split()[-1] for line in open("/proc/self/maps") if ".so" in line})
"""


@unittest.skipUnless(all(map(find_spec, ("pip", "setuptools", "wheel"))), "no build back end")
class Wheel(support.Case):
    def run_in(self, folder, *command):
        environment = {n: v for n, v in os.environ.items() if n not in ("PYTHONPATH", "LD_LIBRARY_PATH")}
        # kernels of one instruction set are enough; the warnings of the presets let ccache serve
        environment["CMAKE_ARGS"] = "-DTFA_ISA_VARIANTS=OFF -DTFA_WERROR=ON"
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout[-2000:] + done.stderr[-2000:])
        return done.stdout

    def test_wheel(self):
        pip = ("-m", "pip", "--disable-pip-version-check")
        with tempfile.TemporaryDirectory(prefix="tfwheel") as folder:
            self.run_in(folder, sys.executable, *pip, "wheel", "--no-build-isolation", "--no-deps",
                        "--no-index", str(support.SOURCE))  # fmt: skip
            (wheel,) = pathlib.Path(folder).glob("totalforce-*.whl")
            one = f"cp3{sys.version_info.minor}-" * 2 if sys.version_info < (3, 11) else "cp311-abi3-"
            self.assertRegex(wheel.name, rf"-{one}manylinux_2_\d+_\w+\.whl$")
            with zipfile.ZipFile(wheel) as content:
                names = content.namelist()
                (metadata,) = (content.read(n).decode() for n in names if n.endswith("/METADATA"))
            self.assertIn("Requires-Dist: numpy", metadata)
            self.run_in(folder, sys.executable, "-m", "venv", "--system-site-packages", "venv")
            python = f"{folder}/venv/bin/python"
            self.run_in(folder, python, *pip, "install", "--no-index", "--no-deps", str(wheel))
            answer, mapped = self.run_in(folder, python, "-c",
                                         CODE % str(support.ROBOTS / "arm7.urdf")).splitlines()
            package = pathlib.Path(answer.split()[-1]).parent
            self.assertTrue(answer.startswith("(7, 7)") and package.is_relative_to(folder), answer)
            carried = {path.name: path for path in package.glob("*.so*")}
            terms = {path.name for path in (package / "licences").glob("*")}
            for name, path in carried.items():
                self.assertTrue("totalforce" in name or not APT or name in terms, name)
                self.assertIn(str(path), mapped.split())
                listed = self.run_in(folder, "readelf", "-d", str(path))
                for needed in re.findall(r"\(NEEDED\).*\[(.*)\]", listed):
                    self.assertTrue(needed in carried or OUTSIDE.fullmatch(needed), needed)
                runpath = re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", listed)
                self.assertIn(runpath, ([], ["$ORIGIN"]), name)
            self.assertTrue({"libtotalforce.so.0", "py.typed"} <= {p.name for p in package.iterdir()})


if __name__ == "__main__":
    support.main()
