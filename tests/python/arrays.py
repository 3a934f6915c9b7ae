# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Arrays: in place or converted once, batches, outputs of the caller, replies."""
import pickle
import sys

import numpy as np

import support
import totalforce as tf
from support import Case, load, state


def unaligned(array):
    """The same numbers where numpy does not call them aligned"""
    view = np.zeros(array.nbytes + 1, dtype=np.uint8)[1:].view(np.float64).reshape(array.shape)
    view[...] = array
    return view


class Arrays(Case):
    def setUp(self):
        self.model = load("arm7")
        self.workspace = tf.Workspace(self.model)
        self.fields = state(self.model, np.random.default_rng(1), 5)
        self.qdd = self.workspace.forward_dynamics(**self.fields).qdd

    def test_every_array_of_the_same_numbers_gives_the_same_bits(self):
        q = self.fields["q"]
        read_only = q.copy()
        read_only.flags.writeable = False

        class Own(np.ndarray):
            pass

        variants = {"read-only": read_only, "Fortran order": np.asfortranarray(q),
                    "reversed twice": np.ascontiguousarray(q[:, ::-1])[:, ::-1],
                    "every second row": np.repeat(q, 2, axis=0)[::2],
                    "other byte order": q.astype(">f8"), "unaligned": unaligned(q),
                    "list": q.tolist(), "list of arrays": list(q),
                    "tuple of tuples": tuple(map(tuple, q)), "subclass": q.view(Own),
                    "memoryview": memoryview(q)}
        for name, variant in variants.items():
            with self.subTest(name):
                reply = self.workspace.forward_dynamics(**{**self.fields, "q": variant})
                self.same_bits(reply.qdd, self.qdd, name)

    def test_other_types_are_converted_and_lossy_ones_refused(self):
        for kind in (np.float32, np.float16, np.int64, np.int8, np.uint16, bool):
            q = np.array([1, 0, 1, 1, 0, 1, 0], dtype=kind)
            self.same_bits(self.workspace.mass_matrix(q).M,
                           self.workspace.mass_matrix(q.astype(float)).M, str(kind))
        for q in (np.zeros(7, complex), np.zeros(7, np.longdouble), np.array(["1"] * 7),
                  np.array([None] * 7), np.zeros(7, "datetime64[s]"), [object()] * 7, [1j] * 7):
            with self.fails(tf.InputTypeError, "q: cannot be read", field="q"):
                self.workspace.mass_matrix(q)
        with self.fails(tf.InputError, "q: cannot be read", field="q"):
            self.workspace.mass_matrix([[1, 2], [3]])

    def test_contiguous_float64_is_used_in_place(self):
        q = self.fields["q"][0].copy()
        before = sys.getrefcount(q)
        reply = self.workspace.mass_matrix(q)
        self.assertEqual(sys.getrefcount(q), before)
        out = np.empty((7, 7))
        again = self.workspace.mass_matrix(q, out=out)
        self.assertIs(again.M, out)
        self.same_bits(out, reply.M, "M")

    def test_shapes(self):
        q = self.fields["q"]
        for some, shape in ((q[0], (7, 7)), (q, (5, 7, 7)), (q[:1], (1, 7, 7))):
            self.assertEqual(self.workspace.mass_matrix(some).M.shape, shape)
        joints = f"the robot has 7 joints ({', '.join(f'joint_{k}' for k in range(1, 8))})"
        for bad, shape in ((q[0, :6], "(6,)"), (q[:, :6], "(5, 6)"), (q[None], "(1, 5, 7)"),
                           (np.float64(1), "()"), (np.array(1.0), "()"),
                           (np.zeros((7, 0)), "(7, 0)"), (np.zeros(0), "(0,)")):
            with self.fails(tf.InputError,
                            f"q: shape {shape}, must be (7,) or (count, 7): {joints}", field="q",
                            status="E_SIZE"):
                self.workspace.mass_matrix(bad)
        with self.fails(tf.InputError, "q: 0 states", field="q"):
            self.workspace.mass_matrix(np.zeros((0, 7)))
        with self.fails(tf.InputError, "v: 4 states, other arrays have 5", field="v"):
            self.workspace.forward_dynamics(q, self.fields["v"][:4])

    def test_huge_arrays_are_refused_without_a_copy(self):
        huge = np.broadcast_to(np.zeros(7), (2**33, 7))
        with self.fails(tf.InputError, "states, must be 1 to 4294967295", field="q"):
            self.workspace.mass_matrix(huge)

    def test_one_state_is_repeated_in_a_batch(self):
        q, tau = self.fields["q"], np.zeros((5, 7))
        tau[:, 1] = 3
        self.same_bits(self.workspace.forward_dynamics(q, np.zeros(7), {"joint_2": 3.0}).qdd,
                       self.workspace.forward_dynamics(q, np.zeros((5, 7)), tau).qdd, "repeated")

    def test_joints_by_name(self):
        whole = self.workspace.mass_matrix([0, 0, 0, -1, 0, 0, 0]).M
        for q in ({"joint_4": -1}, {3: -1.0}):
            self.same_bits(self.workspace.mass_matrix(q).M, whole, q)
        with self.fails(tf.InputError, "q: no moving joint 'joint_9'; nearest: 'joint_1'",
                        joint="joint_9", field="q", status="E_JOINT"):
            self.workspace.mass_matrix({"joint_9": 1})
        with self.fails(tf.InputError, "q.joint_1: 2 numbers"):
            self.workspace.mass_matrix({"joint_1": [1, 2]})

    def test_outputs_of_the_caller(self):
        q, v, tau = self.fields["q"], self.fields["v"], self.fields["tau"]
        out = np.empty((5, 7))
        reply = self.workspace.forward_dynamics(q, v, tau, out={"qdd": out})
        self.assertIs(reply.qdd, out)
        again = self.workspace.forward_dynamics(q, v, tau, out=reply)
        self.assertIs(again, reply)
        self.assertIs(again.qdd, out)
        self.same_bits(out, self.qdd, "qdd")
        read_only = np.empty((5, 7))
        read_only.flags.writeable = False
        for bad, kind, text in (
            (np.empty((5, 6)), tf.InputError, "must have the shape (5, 7)"),
            (np.empty(7), tf.InputError, "must have the shape (5, 7)"),
            (np.empty((5, 7), np.float32), tf.InputTypeError, "float64"),
            (np.empty((5, 14))[:, ::2], tf.InputError, "C-contiguous"),
            (read_only, tf.InputError, "writeable"),
            (q, tf.InputError, "shares memory with an input"),
            (tau[::1], tf.InputError, "shares memory with an input"),
            ([0.0] * 7, tf.InputTypeError, "must be an array"),
            ({"qdd": [0.0]}, tf.InputTypeError, "must be an array"),
            ({"M": np.empty((5, 7, 7))}, tf.InputError, "does not answer M"),
            ({"qddd": out}, tf.InputError, "no answer 'qddd'"),
            ({3: out}, tf.InputError, "no answer"),
        ):
            with self.fails(kind, text, field="out"):
                self.workspace.forward_dynamics(q, v, tau, out=bad)
        memory = np.empty((2, 7, 7))
        with self.fails(tf.InputError, "shares memory with dqdd_dq"):
            self.workspace.derivatives(q[0], out={"dqdd_dq": memory[0], "dqdd_dv": memory[0]})
        with self.assertRaisesRegex(tf.InputError, r"must have the shape \(7,\)$"):
            self.workspace.forward_dynamics(q[0], out=reply)

    def test_base_apart(self):
        robot = support.load("quadruped", "floating")
        workspace, rng = tf.Workspace(robot), np.random.default_rng(6)
        for count in (None, 3):
            s = support.state(robot, rng, count)
            state = {name: s[name] for name in ("q", "v", "base_pose", "base_twist")}
            block = np.empty(s["q"].shape[:-1] + (6 + robot.v_count,))
            reply = workspace.bias(**state, out={"gravity": block})
            wanted = workspace.inverse_dynamics(**state)
            parts = ("gravity", "velocity", "damping", "friction", "external")
            self.assertEqual(reply.keys(), [b + p for p in parts for b in ("", "base_")])
            self.assertEqual(set(reply), set(reply.keys()))
            for prefix, total in (("", wanted.tau), ("base_", wanted.base_wrench)):
                got = sum(reply[prefix + part] for part in parts)
                np.testing.assert_allclose(got, total, rtol=1e-9, atol=1e-9)
            self.same_bits(block[..., 6:], reply.gravity, "gravity")
            self.same_bits(block[..., :6], reply["base_gravity"], "base_gravity")
            self.assertIs(reply.base_gravity.base, block)
            again = pickle.loads(pickle.dumps(reply))
            self.same_bits(again.base_velocity, reply.base_velocity, "base_velocity")
            self.same_bits(workspace.bias(**state, out=again).velocity, reply.velocity, "velocity")
            only = workspace.bias(**state, only=["velocity"])
            self.assertEqual(only.keys(), ["velocity", "base_velocity"])
            with self.fails(tf.InputError, "gravity is given twice", field="out"):
                workspace.bias(**state, out={"gravity": block, "base_gravity": block.copy()})
        reply = self.workspace.bias(self.fields["q"])
        self.assertNotIn("base_gravity", reply)
        with self.assertRaisesRegex(AttributeError, "bias answered no base_gravity"):
            reply.base_gravity
        with self.assertRaises(KeyError):
            reply["base_gravity"]

    def test_only(self):
        reply = self.workspace.derivatives(self.fields["q"], only=["dqdd_dtau"])
        self.assertEqual(reply.keys(), ["dqdd_dtau"])
        full = self.workspace.derivatives(self.fields["q"])
        self.same_bits(reply.dqdd_dtau, full.dqdd_dtau, "dqdd_dtau")
        with self.fails(tf.InputError, "only: no 'x'", field="only"):
            self.workspace.derivatives(self.fields["q"], only=["x"])

    def test_reply_is_a_mapping(self):
        reply = self.workspace.forward_dynamics(self.fields["q"][0], tips="tool0",
                                                want=["lambda", "com", "energy", "spectrum"])
        self.assertEqual(set(reply), set(reply.keys()))
        self.assertEqual(set(dict(reply)), set(reply))
        self.assertEqual(len(reply), len(reply.keys()))
        self.assertIn("lambda", reply)
        self.assertNotIn("tau", reply)
        self.assertNotIn(3, reply)
        self.assertIs(reply["lambda"], reply.lambda_)
        self.assertIsInstance(reply.mass, float)
        self.assertIsInstance(float(reply.threshold), float)
        self.assertEqual(int(reply.rank), 6)
        self.assertLess(reply.eig_min, reply.eig_max)
        self.assertIn("forward_dynamics", repr(reply))
        with self.assertRaisesRegex(AttributeError, "forward_dynamics answered no tau"):
            reply.tau
        with self.assertRaises(KeyError):
            reply["tau"]
        with self.assertRaises(TypeError):
            tf.Reply()
        self.assertIsNone(reply.exchange)
        self.assertTrue(np.isnan(reply.error_estimate))
        measured = self.workspace.forward_dynamics(self.fields["q"][0], estimate="always")
        self.assertLess(measured.error_estimate, 1e-12)
        self.assertTrue(measured.flags & tf.ANSWER_ESTIMATED)
        self.assertEqual(measured.fallback, "")

    def test_wrenches_and_accelerations(self):
        q = self.fields["q"]
        six = np.random.default_rng(2).random((5, 6))
        got = self.workspace.forward_dynamics(q, wrench=[("tool0", six), ("tool0", six[0])]).qdd
        sum_ = self.workspace.forward_dynamics(q, wrench={"tool0": six + six[0]}).qdd
        np.testing.assert_allclose(got, sum_, rtol=1e-9, atol=1e-9)
        by_name = self.workspace.task_torques(q[0], acceleration={"tool0": six[0]}).tau
        by_order = self.workspace.task_torques(q[0], None, six[0], tips=["tool0"]).tau
        self.same_bits(by_name, by_order, "acceleration")
        point = self.workspace.task_torques(q[0], acceleration={"tool0": [0, 0, 1]})
        self.assertEqual(point.lambda_inv.shape, (3, 3))
        two = self.workspace.task_torques(q,
                                          acceleration={"tool0": [0, 0, 1], "link_4": six[:, :3]})
        self.assertEqual(two.lambda_inv.shape, (5, 6, 6))

    def test_arrays_that_change_while_they_are_read(self):
        class Shrinks:
            """Empties its dict while numpy converts it"""

            def __init__(self, owner):
                self.owner = owner

            def __array__(self, dtype=None):
                self.owner.clear()
                return np.zeros(3)

        load_ = {"link": "tool0", "mass": 1.0}
        load_["com"] = Shrinks(load_)
        with self.fails(tf.Error):
            self.workspace.mass_matrix(np.zeros(7), payload=load_)

        class Index:
            def __init__(self, owner):
                self.owner = owner

            def __index__(self):
                self.owner.clear()
                return 0

        tips = [0, 1, 2, 3]
        tips[0] = Index(tips)
        self.workspace.kinematics(np.zeros(7), tips=tips, want="pose")


if __name__ == "__main__":
    support.main()
