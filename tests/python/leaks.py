# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""No leak over 10^5 calls, with --long 10^6: memory stays bounded and reference counts steady; failing
calls, too."""
import gc
import sys

import numpy as np

import support
import totalforce as tf
from support import Case, load, state

CALLS = 1_000_000 if "--long" in sys.argv else 100_000
FAILING = CALLS
BOUND_KIB = 4096


def raised(function, *args, **fields):
    try:
        function(*args, **fields)
    except tf.Error:
        return
    raise AssertionError(function)


class Leaks(Case):
    def setUp(self):
        self.model = load("arm7")
        self.workspace = tf.Workspace(self.model)

    def bounded(self, calls, *watched):
        """Runs a function that repeats its call `n` times; watched: objects it passes."""
        calls(2000)
        gc.collect()
        counts = [sys.getrefcount(o) for o in watched]
        blocks, memory = sys.getallocatedblocks(), support.resident_kib()
        yield
        gc.collect()
        self.assertEqual([sys.getrefcount(o) for o in watched], counts)
        self.assertLess(abs(sys.getallocatedblocks() - blocks), 500)
        self.assertLess(support.resident_kib() - memory, BOUND_KIB)

    def check(self, repeat, count, *watched):
        for _ in self.bounded(repeat, *watched):
            repeat(count)

    def test_single_calls(self):
        q, v = np.zeros(7), np.ones(7)
        call = self.workspace.forward_dynamics

        def repeat(n):
            for _ in range(n):
                call(q, v).qdd

        shared = [sys.getrefcount(None), sys.getrefcount(np.dtype(float))]
        self.check(repeat, CALLS, q, v, self.workspace, self.model)
        for before, kept in zip(shared, (None, np.dtype(float))):  # others use these, too
            self.assertLess(abs(sys.getrefcount(kept) - before), 1000)

    def test_calls_of_every_kind(self):
        s = state(self.model, np.random.default_rng(1))
        q, v, tips, want = s["q"], s["v"], ["tool0", 3], ["poses", "com", "lambda", "jacobian"]
        load_ = {"link": "tool0", "mass": 1.0, "com": [0, 0, 0.1]}
        wrench, locked = {"tool0": np.zeros(6)}, ["joint_2"]
        qs, reply = np.zeros((3, 7)), self.workspace.mass_matrix(q)
        w = self.workspace
        kinds = [
            lambda: w.forward_dynamics(
                q, v, tips=tips, want=want, payload=load_, locked=locked, wrench=wrench
            ).answers,
            lambda: w.compute("bias", q.tolist(), v, want="energy").energy,
            lambda: w.task_torques(qs, v, {"tool0": [0, 0, 1]}).condition,
            lambda: w.mass_matrix(q, out=reply)["M"],
            lambda: w.derivatives({"joint_1": 1}, only=["dqdd_dq"]).method,
            lambda: w.forward_dynamics(qs.astype(np.float32)).method,
            lambda: dict(w.kinematics(q, want=want[:2])),
            lambda: self.model.check("mass_matrix", q),
            lambda: self.model.integrate(qs, self.model.difference(q, qs), dt=0.5),
            lambda: (self.model.neutral(), self.model.joint_limits()),
            lambda: raised(self.model.difference, q, qs[:, 1:]),
            lambda: raised(self.model.integrate, q, v, dt=np.inf),
            lambda: (self.model.joints, self.model.bodies, self.model.summary, self.model.warnings),
        ]

        def repeat(n):
            for _ in range(n // len(kinds) + 1):
                for kind in kinds:
                    kind()

        self.check(repeat, CALLS // 2, q, v, qs, tips, want, load_, wrench, reply, self.workspace)

    def test_failing_calls(self):
        q, w = np.zeros(7), self.workspace
        bad = [dict(v=np.zeros(6)), dict(v=[[1], [1, 2]]), dict(tips=["nothing"]), dict(nothing=1),
               dict(tau=np.full(7, np.nan)), dict(out=q), dict(out={"qdd": np.zeros(6)}),
               dict(wrench={"tool0": np.zeros(6), "link_1": np.zeros(5)}),
               dict(payload={"link": "x"}), dict(locked=["joint_1", "x"]), dict(method="x"),
               dict(v=np.zeros((2, 7)), tau=np.zeros((3, 7))), dict(tips=["tool0"] * 9),
               dict(want=["lambda"], tips=[2, "x"])]

        def repeat(n):
            for _ in range(n // len(bad) + 1):
                for fields in bad:
                    try:
                        w.forward_dynamics(q, **fields)
                    except tf.Error:
                        continue
                    raise AssertionError(fields)

        self.check(repeat, FAILING, q, w, self.model, *(bad[0].values()), *(bad[7].values()))

    def test_statistics(self):
        with support.daemon([("arm", "arm7", "fixed")]) as (folder, _):
            statistics, earlier = tf.Statistics(folder), tf.Histogram([1, 2])
            with tf.Client("arm", runtime_dir=folder) as client:
                client.bias(np.zeros(7))

            def repeat(n):
                for _ in range(n // 100):
                    times = statistics.read()["robots"][0]["total"]["compute"]
                    times.since(earlier).quantile(0.5), times.buckets, times.tops

            self.check(repeat, CALLS, statistics, earlier)

    def test_objects(self):
        def repeat(n):
            for _ in range(n):
                model = tf.Model(support.ROBOTS / "arm6.urdf", gravity=[0, 0, 0], tips="tool0",
                                 payload={"link": "tool0", "mass": 1}, locked={"joint_1": 0.1})
                tf.Workspace(model.derive(gravity=[0, 0, 1]))
                tf.Pool(model, 1).close()
                for wrong in (dict(base="x"), dict(locked=["x"]), dict(payload=[3])):
                    try:
                        tf.Model(support.ROBOTS / "arm6.urdf", **wrong)
                    except tf.Error:
                        pass

        repeat(100)  # the allocator reaches its size
        memory = support.resident_kib()
        repeat(400)
        self.assertLess(support.resident_kib() - memory, BOUND_KIB)


if __name__ == "__main__":
    sys.argv = [word for word in sys.argv if word != "--long"]
    support.main()
