# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Every wrong input gives the exception of its kind, with field, entry, name and remedy."""
import pathlib
import tempfile

import numpy as np

import support
import totalforce as tf
from support import Case, load

NAN = float("nan")


class Requests(Case):
    def setUp(self):
        self.arm = tf.Workspace(load("arm7"))
        self.dog = tf.Workspace(load("quadruped", "floating"))
        self.pose = [0, 0, 0, 0, 0, 0, 1]

    def test_classes_are_those_that_python_users_catch(self):
        for kind, base in (
            (tf.InputError, ValueError),
            (tf.InputTypeError, TypeError),
            (tf.NotComputedError, ArithmeticError),
            (tf.TimedOutError, TimeoutError),
            (tf.DisconnectedError, ConnectionError),
            (tf.LoadError, ValueError),
            (tf.MissingFileError, FileNotFoundError),
            (tf.FileError, OSError),
            (tf.OutOfMemoryError, MemoryError),
            (tf.RefusedError, PermissionError),
            (tf.BusyError, RuntimeError),
            (tf.UnsupportedError, RuntimeError),
        ):
            self.assertTrue(issubclass(kind, base) and issubclass(kind, tf.Error), kind)

    def test_table(self):
        q = np.zeros(7)
        bad_v = np.zeros(7)
        bad_v[3] = NAN
        load_ = {"link": "tool0", "mass": 1}
        arm = [
            (dict(op="forward_dynmics"), tf.InputError, "nearest: 'forward_dynamics'", "op"),
            (dict(op=3), tf.InputTypeError, "must be the name of an op", "op"),
            (
                dict(op="mass_matrix", tau=q),
                tf.InputTypeError,
                "mass_matrix does not use it",
                "tau",
            ),
            (
                dict(op="mass_matrix", tips="tool0"),
                tf.InputTypeError,
                "mass_matrix does not use it unless want has jacobian",
                "tips",
            ),
            (dict(qd=q), tf.InputTypeError, "unknown argument 'qd'; nearest: 'v'", "qd"),
            (dict(effort=q), tf.InputTypeError, "nearest: 'tau'", "effort"),
            (dict(op="inverse_dynamics", a=q), tf.InputTypeError, "nearest: 'qdd', 'acc", "a"),
            (dict(op="rnea"), tf.InputError, "nearest: 'inverse_dynamics'", "op"),
            (
                dict(v=np.zeros(13)),
                tf.InputError,
                "own, base_twist; this robot's base is fixed",
                "v",
            ),
            (
                dict(methd="aba"),
                tf.InputTypeError,
                "unknown argument 'methd'; nearest: 'method'",
                "methd",
            ),
            (dict(timeout=1), tf.InputTypeError, "unknown argument 'timeout'", "timeout"),
            (dict(v=bad_v), tf.InputError, "v[3] (joint_4): nan: not a finite number", "v"),
            (dict(tau=q + np.inf), tf.InputError, "tau[0] (joint_1): inf", "tau"),
            (dict(gravity=[0, 0]), tf.InputError, "gravity: 2 numbers", "gravity"),
            (dict(gravity=[0, 0, NAN]), tf.InputError, "gravity[2]: nan", "gravity"),
            (dict(gravity="down"), tf.InputError, "must be 3 numbers", "gravity"),
            (
                dict(tips=["tol0"]),
                tf.InputError,
                "no link 'tol0' in the robot; nearest: 'tool0'",
                "tips",
            ),
            (dict(tips=[99]), tf.InputError, "no link '99'", "tips"),
            (dict(tips=[-1]), tf.InputError, "no link '-1'", "tips"),
            (dict(tips=[2.5]), tf.InputTypeError, "name or the index of a link", "tips"),
            (dict(tips=[True]), tf.InputTypeError, "name or the index of a link", "tips"),
            (dict(tips=5), tf.InputTypeError, "must be a list of links", "tips"),
            (dict(tips=["tool0"] * 33), tf.InputError, "more than 32 links", "tips"),
            (
                dict(tips=["tool0"] * 9),
                tf.UnsupportedError,
                "9 links, there is memory for 8",
                "tips",
            ),
            (dict(op="operational_inertia"), tf.InputError, "tips: missing", "tips"),
            (dict(want=["jacobian"]), tf.InputError, "tips: missing", "tips"),
            (
                dict(want=["jacobain"], tips="tool0"),
                tf.InputError,
                "no 'jacobain'; nearest: 'jacobian'",
                "want",
            ),
            (
                dict(op="mass_matrix", want=["lambda"]),
                tf.InputError,
                "mass_matrix does not answer lambda",
                "want",
            ),
            (dict(want=7), tf.InputTypeError, "must be a list of words", "want"),
            (dict(tips="tool0", rows="six"), tf.InputError, "no 'six'; there are pose, point", "rows"),
            (dict(tips="tool0", frame="word"), tf.InputError, "no 'word'; there are local_world_", "frame"),
            (dict(tips="tool0", frame=1), tf.InputTypeError, "must be a str", "frame"),
            (dict(estimate="often"), tf.InputError, "estimate: no 'often'", "estimate"),
            (dict(method="abba"), tf.InputError, "method: no 'abba'; nearest: 'aba'", "method"),
            (dict(method=3), tf.InputTypeError, "method: int, must be a str", "method"),
            (
                dict(method="rnea"),
                tf.InputError,
                "method: rnea does not answer forward_dynamics",
                "method",
            ),
            (dict(refine=4), tf.InputError, "refine: must be 0 to 3", "refine"),
            (dict(refine=-1), tf.InputError, "refine: must be 0 to 3", "refine"),
            (dict(refine=2**70), tf.InputError, "refine: must be 0 to 3", "refine"),
            (dict(refine=1.0), tf.InputTypeError, "must be an int", "refine"),
            (dict(refine=True), tf.InputTypeError, "must be an int", "refine"),
            (dict(wrench={"tol0": q[:6]}), tf.InputError, "no link 'tol0'", "wrench"),
            (
                dict(wrench={"tool0": q}),
                tf.InputError,
                "wrench.tool0: shape (7,), must be (6,)",
                "wrench.tool0",
            ),
            (
                dict(wrench={"tool0": [0, 0, NAN, 0, 0, 0]}),
                tf.InputError,
                "wrench[2] (tool0): nan",
                "wrench",
            ),
            (dict(wrench=[("tool0", q[:6])] * 9), tf.InputError, "9 links, at most 8", "wrench"),
            (dict(wrench=[1, 2]), tf.InputTypeError, "not a pair", "wrench"),
            (dict(wrench=3), tf.InputTypeError, "must be {link: numbers}", "wrench"),
            (dict(payload=3), tf.InputTypeError, "must be a dict", "payload"),
            (dict(payload=[3]), tf.InputTypeError, "must be a dict", "payload"),
            (dict(payload={"link": "tool0"}), tf.InputError, "payload.mass: missing", "payload"),
            (dict(payload={"mass": 1}), tf.InputError, "payload.link: missing", "payload"),
            (dict(payload={**load_, "co": 1}), tf.InputError, "unknown key", "payload"),
            (
                dict(payload={**load_, "com": [1]}),
                tf.InputError,
                "payload.com: 1 numbers",
                "payload.com",
            ),
            (dict(payload={**load_, "mass": -1}), tf.InputError, "payload.mass: -1: must not", "payload"),
            (dict(payload={**load_, "mass": NAN}), tf.InputError, "not a finite number", "payload"),
            (dict(payload={**load_, "link": "x"}), tf.InputError, "no link 'x'", "payload"),
            (dict(payload=[load_] * 5), tf.InputError, "5 loads, at most 4", "payload"),
            (dict(locked=["elbow"]), tf.InputError, "no moving joint 'elbow'", "locked"),
            (dict(locked=4), tf.InputTypeError, "must be a list of joints", "locked"),
            (dict(locked=[0] * 8), tf.InputError, "8 joints, the robot has 7", "locked"),
            (
                dict(locked=[0], method="crba"),
                tf.InputError,
                "with locked joints; aba does",
                "locked",
            ),
            (dict(op="mass_matrix", locked=[0]), tf.InputTypeError, "does not use it", "locked"),
            (dict(op="task_torques"), tf.InputError, "acceleration: missing", "acceleration"),
            (dict(op="task_torques", acceleration=[0] * 6), tf.InputError, "tips: missing", "tips"),
            (
                dict(op="task_torques", acceleration=[0] * 5, tips="tool0"),
                tf.InputError,
                "shape (5,), must be (6,) or (count, 6): 6 rows for each of 1 tips",
                "acceleration",
            ),
            (dict(op="task_torques", acceleration={}), tf.InputError, "0 links", "acceleration"),
            (
                dict(op="task_torques", acceleration={"tool0": [0] * 6}, tips="link_4"),
                tf.InputError,
                "'tool0' is not tip 0",
                "acceleration",
            ),
            (
                dict(op="task_torques", acceleration={"tool0": 3}),
                tf.InputTypeError,
                "",
                "acceleration",
            ),
            (
                dict(op="task_torques", acceleration={"tool0": [0] * 6}, rank_threshold=2),
                tf.InputError,
                "rank_threshold: 2, must be above 0 and below 1",
                "rank_threshold",
            ),
            (
                dict(op="task_torques", acceleration={"tool0": [0] * 6}, rank_threshold="x"),
                tf.InputTypeError,
                "must be a number",
                "rank_threshold",
            ),
            (dict(base_pose=self.pose), tf.InputError, "the robot's base is fixed", "base_pose"),
            (dict(modes=[0]), tf.InputError, "the robot has no flexible links", "modes"),
        ]
        for fields, kind, text, field in arm:
            with self.subTest(**fields):
                with self.fails(kind, text, field=field):
                    self.arm.compute(fields.pop("op", "forward_dynamics"), q, **fields)
        n = self.dog.model.q_count
        with self.fails(tf.InputError, "base_pose: missing", field="base_pose"):
            self.dog.mass_matrix(np.zeros(n))
        for fields, name in (
            (dict(q=np.zeros(n + 7)), "base_pose (x y z, quaternion x y z w)"),
            (dict(q=np.zeros(n), tau=np.zeros((3, n + 6))), "base_wrench"),
        ):
            with self.fails(tf.InputError, f"a floating base has a field of its own, {name}"):
                self.dog.forward_dynamics(base_pose=self.pose, **fields)
        with self.fails(
            tf.InputError,
            "quaternion of norm 2, must be 1",
            field="base_pose",
            status="E_QUATERNION",
        ):
            self.dog.mass_matrix(np.zeros(n), base_pose=[0, 0, 0, 0, 0, 0, 2])

    def test_constraints(self):
        feet = support.ROBOTS / "quadruped_feet.yaml"
        dog = tf.Workspace(load("quadruped", "floating", constraints=feet))
        state = {"q": np.zeros(12), "base_pose": self.pose}
        known = "the robot has 4 constraints (FL_foot, FR_foot, RL_foot, RR_foot)"
        for fields, kind, text, attributes in (
            (
                dict(constraints=["FL_fot"]),
                tf.InputError,
                f"no constraint 'FL_fot'; nearest: 'FL_foot', 'FR_foot', 'RL_foot'; {known}",
                dict(field="constraints", constraint="FL_fot"),
            ),
            (dict(constraints=[4]), tf.InputError, "no constraint '4'; nearest: ", {}),
            (dict(constraints=["FL_foot", 0]), tf.InputError, "'FL_foot' twice", {}),
            (dict(constraints=3.5), tf.InputTypeError, "must be a list of constraints", {}),
            (dict(constraints=[]), tf.InputError, f"none active; {known}", {}),
            (dict(stabilisation=[1]), tf.InputError, "stabilisation: 1 numbers", {}),
            (
                dict(stabilisation=[1, -2]),
                tf.InputError,
                "stabilisation[1]: -2: must not be negative",
                dict(field="stabilisation", index=1),
            ),
            (
                dict(constraint_acceleration={"FL_foot": [0] * 6}, constraints="FR_foot"),
                tf.InputError,
                "'FL_foot' is not active; name it in constraints",
                dict(constraint="FL_foot"),
            ),
            (
                dict(constraint_acceleration={"FR_foot": [0] * 5}),
                tf.InputError,
                "constraint_acceleration.FR_foot: shape (5,), must be (6,)",
                {},
            ),
            (
                dict(constraint_acceleration=np.zeros(6)),
                tf.InputError,
                "shape (6,), must be (24,) or (count, 24): 6 for each of 4 active constraints",
                {},
            ),
            (
                dict(constraint_acceleration={"RR_foot": [0, NAN, 0, 0, 0, 0]}, constraints=[0, 3]),
                tf.InputError,
                "constraint_acceleration[1] (RR_foot): nan: not a finite number",
                dict(field="constraint_acceleration", constraint="RR_foot", index=7),
            ),
            (dict(torque_weights=np.ones(12)), tf.InputTypeError, "does not use it", {}),
            (
                dict(rank_loss="refuse", rank_threshold=0.1),
                tf.NotComputedError,
                "constraints: rows of FL_foot, FR_foot, RL_foot, RR_foot depend on each other",
                dict(status="E_RANK"),
            ),
        ):
            with self.subTest(**fields), self.fails(kind, text, **attributes):
                dog.constrained_dynamics(**state, **fields)
        with self.fails(
            tf.InputError, "torque_weights[1] (FL_thigh_joint): 0: must be above 0", index=1
        ):
            dog.constrained_inverse_dynamics(**state, torque_weights={"FL_thigh_joint": 0})
        with self.fails(tf.InputError, "the robot has no constraints; `constraints` of its scene"):
            self.dog.impact(**state)

    def test_positions(self):
        q = np.zeros(7)
        with self.fails(tf.InputTypeError, "by position are too many"):
            self.arm.mass_matrix(q, q)
        with self.fails(tf.InputTypeError, "by position are too many"):
            self.arm.forward_dynamics(q, q, q, q)
        with self.fails(tf.InputTypeError, "q: given twice", field="q"):
            self.arm.mass_matrix(q, q=q)
        with self.fails(tf.InputError, "q: missing; the robot has 7 joints", field="q"):
            self.arm.mass_matrix()
        with self.fails(tf.InputError, "q: missing"):
            self.arm.mass_matrix(None)
        with self.fails(tf.InputTypeError, "op: missing"):
            self.arm.compute()

    def test_entry_of_a_batch(self):
        v = np.zeros((9, 7))
        v[6, 2] = np.inf
        with self.fails(
            tf.InputError,
            "v[2] (joint_3) of state 6: inf",
            field="v",
            index=2,
            state=6,
            joint="joint_3",
            status="E_VALUE",
            code=-3,
        ):
            self.arm.forward_dynamics(np.zeros((9, 7)), v)

    def test_failed_states_leave_the_others(self):
        stretched = np.zeros((3, 6))
        stretched[0] = stretched[2] = [0.3, -1, 1, 0.2, 0.5, 0.1]
        stretched[1] = [0, -1, 0, 0, 0, 0]
        arm = tf.Workspace(load("arm6"))
        with self.assertRaises(tf.NotComputedError) as caught:
            arm.task_torques(
                stretched, acceleration={"tool0": [0, 0, 1, 0, 0, 0]}, rank_loss="refuse"
            )
        error = caught.exception
        self.assertEqual((error.status, error.state, error.field), ("E_RANK", 1, "tips"))
        self.assertIn("rank 5 of 6 here; rank_loss='truncate' or 'damp' answers", str(error))
        one = arm.task_torques(stretched[2], acceleration={"tool0": [0, 0, 1, 0, 0, 0]})
        self.same_bits(error.reply.tau[2], one.tau, "the state behind it")
        self.assertTrue(np.isnan(error.reply.tau[1]).all())

    def test_check_raises_the_same(self):
        model = self.arm.model
        self.assertIsNone(model.check("forward_dynamics", np.zeros(7)))
        with self.fails(tf.InputError, "q: shape (6,)", field="q"):
            model.check("forward_dynamics", np.zeros(6))
        with self.fails(tf.InputError, "v[0] (joint_1): nan", field="v"):
            model.check("forward_dynamics", np.zeros(7), [NAN] * 7)
        with self.fails(tf.InputError, "tolerance", field="tolerance"):
            model.advise(-1.0, np.zeros(7))


URDF = """<robot name="r">
  <link name="world"/>
  <link name="arm"><inertial><mass value="{mass}"/>
    <inertia ixx="{ixx}" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="j" type="{type}"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
</robot>"""


def chain(joints):
    """URDF of a chain of equal links"""
    links = "".join(
        f"<link name='l{k}'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' "
        f"iyz='0' izz='1'/></inertial></link><joint name='j{k}' type='continuous'>"
        f"<parent link='l{k - 1}'/><child link='l{k}'/><origin xyz='0 0 1'/><axis xyz='1 0 0'/>"
        f"</joint>"
        for k in range(1, joints + 1)
    )
    return f"<robot name='chain'><link name='l0'/>{links}</robot>"


class Robots(Case):
    def write(self, folder, **values):
        path = pathlib.Path(folder) / "robot.urdf"
        path.write_text(URDF.format(**{"mass": 1, "ixx": 1, "type": "revolute", **values}))
        return path

    def test_loading(self):
        with tempfile.TemporaryDirectory() as folder:
            path = self.write(folder, ixx=-1)
            with self.assertRaises(tf.LoadError) as caught:
                tf.Model(path)
            error = caught.exception
            self.assertEqual(error.file, str(path))
            self.assertEqual(error.line, 3)
            self.assertEqual(error.link, "arm")
            self.assertIn(f"{path}:3: error: link 'arm'", str(error))
            self.assertTrue(any(m.severity == "error" and m.line == 3 for m in error.messages))
            with self.assertRaises(tf.LoadError):
                tf.Model(self.write(folder, mass="heavy"))
            with self.fails(tf.LoadError, "", status="E_NO_MASS"):
                tf.Model.parse(
                    "<robot name='r'><link name='a'/><link name='b'/>"
                    "<joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>"
                    "</robot>"
                )
            model = tf.Model(self.write(folder))
            self.assertTrue(all(": warning: " in text for text in model.warnings))
            self.assertEqual(tf.joint_limits(path), {"j": (-1, 2, 1, 1)})
            none = (-np.inf, np.inf, np.inf, np.inf)
            self.assertEqual(tf.joint_limits(path, ["k"]), {"k": none})
            with self.assertRaises(tf.MissingFileError) as caught:
                tf.Model(folder + "/none.urdf")
            self.assertEqual(
                (caught.exception.errno, caught.exception.filename), (2, folder + "/none.urdf")
            )
            with self.assertRaises(tf.FileError):
                tf.Model(folder)

    def test_options(self):
        path = support.ROBOTS / "arm7.urdf"
        for options, kind, text in (
            (dict(base="flying"), tf.InputError, "base: no 'flying'"),
            (dict(base=1), tf.InputTypeError, "base: int"),
            (dict(gravity=[1]), tf.InputError, "gravity: 1 numbers"),
            (dict(gravity=[0, 0, NAN]), tf.Error, ""),
            (dict(mimic="x"), tf.InputError, "mimic"),
            (dict(inertia="x"), tf.InputError, "inertia"),
            (dict(snap=1), tf.Error, ""),
            (dict(root="nowhere"), tf.LoadError, "nowhere"),
            (dict(root=4), tf.InputTypeError, "root: int"),
            (dict(tips=["nowhere"]), tf.LoadError, "nowhere"),
            (dict(tips=4), tf.InputTypeError, "tips"),
            (dict(locked=["nothing"]), tf.LoadError, "nothing"),
            (dict(locked={"joint_1": "x"}), tf.Error, "locked"),
            (dict(locked={"joint_1": [1, 2]}), tf.InputError, "locked"),
            (dict(locked=3), tf.InputTypeError, "locked"),
            (dict(payload={"link": "x", "mass": 1}), tf.LoadError, "x"),
        ):
            with self.subTest(**options), self.fails(kind, text):
                tf.Model(path, **options)
        for wrong in ({"bse": "fixed"}, {"path": 3}):
            with self.assertRaises(TypeError):
                tf.Model(path, **wrong)
        for wrong in (None, 3, object()):
            with self.assertRaises(TypeError):
                tf.Model(wrong)
            with self.assertRaises(TypeError):
                tf.Model.parse(wrong)
        with self.fails(tf.LoadError, "", status="E_PARSE"):
            tf.Model.parse("<robot")

    def test_workspaces_and_pools(self):
        model = load("arm7")
        for options, kind in (
            (dict(precision="f16"), tf.InputError),
            (dict(residual="x"), tf.InputError),
            (dict(states="all"), tf.InputError),
            (dict(methods=["x"]), tf.InputError),
            (dict(methods=3), tf.InputTypeError),
            (dict(max_tips=33), tf.UnsupportedError),
            (dict(specialised=model), tf.InputTypeError),
        ):
            with self.subTest(**options), self.fails(kind):
                tf.Workspace(model, **options)
        for options, kind in (
            (dict(threads=257), tf.InputError),
            (dict(threads=2, cpus=[0]), tf.InputError),
            (dict(threads=1, cpus=["x"]), tf.InputTypeError),
            (dict(priority=100), tf.InputError),
            (dict(thread_pool=3), tf.InputTypeError),
        ):
            with self.subTest(**options), self.fails(kind):
                tf.Pool(model, **options)
        for wrong in (-1, 2**32, 2**70):
            with self.fails(tf.InputError, "not within 0 to 4294967295"):
                tf.Workspace(model, max_tips=wrong)
            with self.fails(tf.InputError, "not within 0 to 4294967295"):
                tf.Pool(model, threads=wrong)
            with self.fails(tf.InputError, "not within 0 to 4294967295"):
                tf.Client("arm", slots=wrong)
        with self.assertRaises(TypeError):
            tf.Pool(model, threads=1.5)
        for wrong in (None, 3, "arm7.urdf"):
            with self.assertRaises(TypeError):
                tf.Workspace(wrong)
            with self.assertRaises(TypeError):
                tf.Pool(wrong)
        reserved = tf.Workspace(model, methods=["tfa"], max_tips=1)
        self.assertIn("tfa", reserved.methods)
        with self.fails(tf.UnsupportedError):
            reserved.forward_dynamics(np.zeros(7), method="cfa")
        rope = tf.Model.parse(chain(300))
        lean = tf.Workspace(rope)
        for workspace, ask, text in (
            (lean, dict(method="tfa"), "no memory was reserved for tfa; methods=['tfa']"),
            (lean, dict(op="mass_matrix"), "methods=['crba'] of a Workspace or Pool"),
            (lean, dict(op="derivatives"), "of 300 freedoms: the limit is 256 freedoms"),
            (
                tf.Pool(rope, 1, methods=["hessenberg"]),
                dict(method="hessenberg"),
                "the limit is a main chain of 130 bodies; tfa and auto answer",
            ),
        ):
            with self.subTest(**ask), self.fails(tf.UnsupportedError, text):
                workspace.compute(ask.pop("op", "forward_dynamics"), np.zeros(300), **ask)
        with self.fails(tf.FileError):
            tf.Specialised("/nowhere.so", model)

    def test_closed(self):
        model = load("arm7")
        with tf.Pool(model, 2) as pool:
            self.assertEqual(pool.threads, 2)
        pool.close()
        for use in (lambda: pool.mass_matrix(np.zeros(7)), lambda: pool.threads, pool.__enter__):
            with self.fails(tf.InputError, "the pool is closed"):
                use()
        threads = tf.ThreadPool(2)
        pool = tf.Pool(model, thread_pool=threads)
        with self.fails(tf.BusyError, "1 pools use the thread pool"):
            threads.close()
        pool.close()
        threads.close()
        with self.fails(tf.InputError, "the thread pool is closed"):
            tf.Pool(model, thread_pool=threads)


if __name__ == "__main__":
    support.main()
