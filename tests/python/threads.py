# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Threads, processes, lifetimes: the GIL, shared workspaces, forks, the end of Python."""
import contextlib
import gc
import subprocess
import sys
import threading
import time

import numpy as np

import support
import totalforce as tf
from support import Case, load, python, state, waiting


class Threads(Case):
    def long_batch(self, solver, seconds=0.2):
        """Fields of a batch that takes about so long: others may, or may not, run meanwhile."""
        model = solver.model
        rng = np.random.default_rng(1)
        short = state(model, rng, 4)
        per_state = min(solver._time(4, "forward_dynamics", **short) for _ in range(3)) / 4e9
        return state(model, rng, max(4, int(seconds / per_state)))

    def ticks(self, work):
        """How often another thread ran while `work` was done"""
        times = []
        done = threading.Event()

        def tick():
            while not done.is_set():
                times.append(time.perf_counter())
                time.sleep(0.001)

        thread = threading.Thread(target=tick)
        thread.start()
        start = time.perf_counter()
        work()
        end = time.perf_counter()
        done.set()
        thread.join()
        return sum(start < t < end for t in times)

    def runs_beside(self, work, count):
        """Another thread runs so often, sooner or later. With the GIL held it would run only before
        and behind the work."""
        self.assertTrue(any(self.ticks(work) > count for _ in waiting()))

    def test_other_threads_run_while_a_batch_is_computed(self):
        for make in (tf.Workspace, tf.Pool):
            solver = make(load("humanoid"), precision="f128")
            fields = self.long_batch(solver)
            self.runs_beside(lambda: solver.forward_dynamics(**fields), 20)

    def test_other_threads_run_while_a_robot_is_loaded(self):
        chain = subprocess.run([support.TOOL, "chain", "straight", "--bodies", "3000"],
                               capture_output=True, check=True).stdout
        self.runs_beside(lambda: tf.Model.parse(chain), 5)

    def test_two_threads_on_one_workspace(self):
        workspace = tf.Workspace(load("humanoid"), precision="f128")
        fields = self.long_batch(workspace, 0.1)
        wanted = workspace.forward_dynamics(**fields).qdd.tobytes()
        results, busy = [], []

        def work():
            for _ in waiting():
                try:
                    results.append(workspace.forward_dynamics(**fields).qdd.tobytes() == wanted)
                except tf.BusyError as error:
                    busy.append(error.status)
                    time.sleep(0.02)
                if results and busy:
                    break

        threads = [threading.Thread(target=work) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(results and all(results))
        self.assertTrue(busy)
        self.assertEqual(set(busy), {"E_BUSY"})
        workspace.mass_matrix(fields["q"][0])

    def refusals(self):
        """Statuses of a call and of close() in a second thread while the pool computes a batch"""
        found = []

        def other(pool, q, done):
            while not found and not done.is_set():
                try:
                    pool.mass_matrix(q)  # the batch has not begun
                except tf.BusyError as error:
                    found.append(error.status)
                time.sleep(0.0001)
            try:
                pool.close()  # unless the batch has ended
            except tf.BusyError as error:
                found.append(error.status)

        with tf.Pool(load("humanoid"), 2, precision="f128") as pool:
            fields, done = self.long_batch(pool, 0.1), threading.Event()
            thread = threading.Thread(target=other, args=(pool, fields["q"][0], done))
            thread.start()
            with contextlib.suppress(tf.BusyError):  # the other thread came first
                pool.forward_dynamics(**fields)
            done.set()
            thread.join()
        return found

    def test_pool_of_two_threads_is_busy_for_the_second(self):
        self.assertTrue(any(self.refusals() == ["E_BUSY", "E_BUSY"] for _ in waiting()))

    def test_a_pool_that_another_thread_closes(self):
        for _ in range(20):  # the call finds it open or closed, never half of each
            pool = tf.Pool(load("arm7"), 2)
            thread = threading.Thread(target=pool.close)
            thread.start()
            with contextlib.suppress(tf.Error):
                pool.mass_matrix(np.zeros((64, 7)))
            with contextlib.suppress(tf.BusyError):
                pool.close()
            thread.join()

    def test_a_workspace_of_each_thread(self):
        model = load("arm7")
        fields = state(model, np.random.default_rng(3), 200)
        wanted = tf.Workspace(model).forward_dynamics(**fields).qdd.tobytes()
        right = []

        def work():
            workspace = tf.Workspace(model)
            right.append(all(workspace.forward_dynamics(**fields).qdd.tobytes() == wanted
                             for _ in range(200)))

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(right, [True] * 4)

    def meddle(self, workspace, fields, reply):
        """A batch, whose q another thread drops and reshapes once the call holds it: its qdd, and
        whether the array could not be resized"""
        arrays, refused = {"q": fields["q"].copy()}, []
        others = {name: value for name, value in fields.items() if name != "q"}
        own = sys.getrefcount(arrays["q"])
        done = threading.Event()

        def other():
            while sys.getrefcount(arrays["q"]) == own and not done.is_set():
                time.sleep(0.001)
            view = arrays.pop("q")
            view.shape = (-1,)
            try:
                view.resize(1)  # the call holds a reference, unless it has ended
            except ValueError:
                refused.append(True)
            tf.Workspace(workspace.model, precision="f128").forward_dynamics(fields["q"], out=reply)

        thread = threading.Thread(target=other)
        thread.start()
        got = workspace.forward_dynamics(arrays["q"], **others)
        done.set()
        thread.join()
        return got.qdd.tobytes(), refused

    def test_memory_that_other_threads_drop_and_reshape(self):
        workspace = tf.Workspace(load("humanoid"), precision="f128")
        fields = self.long_batch(workspace, 0.1)
        reply = workspace.forward_dynamics(**fields)
        wanted = reply.qdd.tobytes()
        for _ in waiting():
            got, refused = self.meddle(workspace, fields, reply)
            self.assertEqual(got, wanted)
            if refused:
                return
        self.fail("an array that a call holds can be resized")


class Lifetimes(Case):
    def test_solvers_keep_their_model(self):
        for make in (lambda model: tf.Workspace(model), lambda model: tf.Pool(model, 2),
                     lambda model: tf.Workspace(model.derive(gravity=[0, 0, 0]))):
            model = load("arm7")
            wanted = make(model).mass_matrix(np.zeros(7)).M
            solver = make(model)
            before = sys.getrefcount(model)
            del model
            gc.collect()
            junk = [bytearray(100000) for _ in range(50)]
            self.same_bits(solver.mass_matrix(np.zeros(7)).M, wanted, "M")
            del junk
            self.assertGreaterEqual(before, 2)

    def test_replies_outlive_everything(self):
        reply = tf.Workspace(load("arm7")).mass_matrix(np.zeros(7))
        gc.collect()
        self.assertEqual(reply.M.shape, (7, 7))
        self.assertTrue(reply.M.flags.owndata)

    def test_model_is_freed(self):
        before = support.resident_kib()
        for _ in range(300):
            tf.Workspace(load("humanoid"))
        self.assertLess(support.resident_kib() - before, 20000)

    def test_end_of_python_with_live_objects(self):
        done = python(
            """
import sys, threading
import numpy as np, totalforce as tf
model = tf.Model(sys.argv[1] + '/config/robots/humanoid.urdf')
workspace, pool, threads = tf.Workspace(model), tf.Pool(model, 2), tf.ThreadPool(2)
shared = tf.Pool(model, thread_pool=threads)
reply = workspace.mass_matrix(np.zeros(model.q_count))
q = np.zeros((200000, model.q_count))
def work():
    tf.Workspace(model).forward_dynamics(q)
threading.Thread(target=work, daemon=True).start()
import builtins
builtins.kept = [model, workspace, pool, shared, reply]
print('end')
"""
        )
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "end\n", ""))

    def test_fork(self):
        done = python(
            """
import os, sys
import numpy as np, totalforce as tf
model = tf.Model(sys.argv[1] + '/config/robots/arm7.urdf')
workspace, pool = tf.Workspace(model), tf.Pool(model, 2)
pool.mass_matrix(np.zeros((8, 7)))
child = os.fork()
if child == 0:
    for solver in (workspace, pool):
        try:
            solver.mass_matrix(np.zeros(7))
            print('computed')
        except tf.UnsupportedError as error:
            print(error)
    tf.Workspace(model).mass_matrix(np.zeros(7))
    with tf.Pool(model, 2) as own:
        own.mass_matrix(np.zeros((8, 7)))
    tf.Model(sys.argv[1] + '/config/robots/arm7.urdf')
    del pool
    sys.exit(0)
print(os.waitpid(child, 0)[1])
pool.mass_matrix(np.zeros((8, 7)))
"""
        )
        self.assertEqual(done.stderr, "")
        self.assertEqual(
            done.stdout,
            "computed\nthe pool was made before a fork: make one in this " "process\n0\n",
        )


if __name__ == "__main__":
    support.main()
