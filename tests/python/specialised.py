# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A specialised kernel: built, loaded, used by a workspace and a pool; wrong ones are refused."""
import pathlib
import subprocess
import tempfile

import numpy as np

import support
import totalforce as tf
from support import Case, load, state


class Specialised(Case):
    def check_sweep(self, model, workspace, folder):
        """Its answers are those of a workspace with the kernel."""
        command = [support.TOOL, "sweep", str(support.ROBOTS / "arm6.urdf"), "--count", "700",
                   "--kernels", folder, "--out", f"{folder}/answers", "--out-states",
                   f"{folder}/states"]
        subprocess.run(command, check=True, capture_output=True, timeout=5 * support.WAIT)
        q, v, tau = np.split(np.fromfile(f"{folder}/states").reshape(700, -1), 3, axis=1)
        wanted = workspace.forward_dynamics(q, v=v, tau=tau).qdd
        self.same_bits(np.fromfile(f"{folder}/answers"), wanted, "sweep")

    def test_build_load_use(self):
        model = load("arm6")
        with tempfile.TemporaryDirectory(prefix="tfspec") as folder:
            path = pathlib.Path(folder) / tf.Specialised.file_name(model)
            built = tf.Specialised.build(
                model, path, single=True, algorithm="aba", sources=str(support.SOURCE / "lib")
            )
            self.assertEqual(built.bytes, path.stat().st_size)
            kernel = tf.Specialised(path, model)
            self.assertEqual(kernel.info.bodies, 6)
            self.assertEqual(len(kernel.info.digest), 32)
            fields = state(model, np.random.default_rng(1))
            wanted = tf.Workspace(model).forward_dynamics(**fields).qdd
            workspace = tf.Workspace(model, specialised=kernel)
            with tf.Pool(model, 1, specialised=kernel) as pool:
                for solver in (workspace, pool):
                    got = solver.forward_dynamics(**fields).qdd
                    np.testing.assert_allclose(got, wanted, rtol=1e-9)
            self.check_sweep(model, workspace, folder)
            with self.fails(tf.UnsupportedError):
                tf.Specialised(path, load("arm7"))
            with self.fails(tf.InputError):
                tf.Workspace(load("arm7"), specialised=kernel)
            del kernel  # the workspace keeps it
            workspace.forward_dynamics(**fields)
            path.chmod(0o666)
            with self.fails(tf.RefusedError):
                tf.Specialised(path, model)
        with self.fails(tf.InputError, "algorithm", field="algorithm"):
            tf.Specialised.build(model, "/nowhere/x.so", algorithm="x")
        with self.fails(tf.Error):
            tf.Specialised.build(model, "/nowhere/x.so", sources=str(support.SOURCE / "lib"))


if __name__ == "__main__":
    support.main()
