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
VALUE, TYPE = tf.InputError, tf.InputTypeError


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
            (VALUE, "nearest: 'forward_dynamics'", dict(op="forward_dynmics")),
            (TYPE, "must be the name of an op", dict(op=3)),
            (TYPE, "mass_matrix does not use it", dict(op="mass_matrix", tau=q)),
            (TYPE, "mass_matrix does not use it unless want has jacobian",
             dict(op="mass_matrix", tips="tool0")),
            (TYPE, "unknown argument 'qd'; nearest: 'v'", dict(qd=q)),
            (TYPE, "nearest: 'tau'", dict(effort=q)),
            (TYPE, "nearest: 'qdd', 'acc", dict(op="inverse_dynamics", a=q)),
            (VALUE, "nearest: 'inverse_dynamics'", dict(op="rnea")),
            (VALUE, "own, base_twist; this robot's base is fixed", dict(v=np.zeros(13))),
            (TYPE, "unknown argument 'methd'; nearest: 'method'", dict(methd="aba")),
            (TYPE, "unknown argument 'timeout'", dict(timeout=1)),
            (VALUE, "v[3] (joint_4): nan: not a finite number", dict(v=bad_v)),
            (VALUE, "tau[0] (joint_1): inf", dict(tau=q + np.inf)),
            (VALUE, "gravity: 2 numbers", dict(gravity=[0, 0])),
            (VALUE, "gravity[2]: nan", dict(gravity=[0, 0, NAN])),
            (VALUE, "must be 3 numbers", dict(gravity="down")),
            (VALUE, "no link 'tol0' in the robot; nearest: 'tool0'", dict(tips=["tol0"])),
            (VALUE, "no link '99'", dict(tips=[99])),
            (VALUE, "no link '-1'", dict(tips=[-1])),
            (TYPE, "name or the index of a link", dict(tips=[2.5])),
            (TYPE, "name or the index of a link", dict(tips=[True])),
            (TYPE, "must be a list of links", dict(tips=5)),
            (VALUE, "more than 32 links", dict(tips=["tool0"] * 33)),
            (tf.UnsupportedError, "9 links, there is memory for 8", dict(tips=["tool0"] * 9)),
            (VALUE, "tips: missing", dict(op="operational_inertia"), "tips"),
            (VALUE, "tips: missing", dict(want=["jacobian"]), "tips"),
            (VALUE, "no 'jacobain'; nearest: 'jacobian'", dict(want=["jacobain"], tips="tool0"),
             "want"),
            (VALUE, "mass_matrix does not answer lambda", dict(op="mass_matrix", want=["lambda"])),
            (TYPE, "must be a list of words", dict(want=7)),
            (VALUE, "no 'six'; there are pose, point", dict(tips="tool0", rows="six")),
            (VALUE, "no 'word'; there are local_world_", dict(tips="tool0", frame="word")),
            (TYPE, "must be a str", dict(tips="tool0", frame=1)),
            (VALUE, "estimate: no 'often'", dict(estimate="often")),
            (VALUE, "method: no 'abba'; nearest: 'aba'", dict(method="abba")),
            (TYPE, "method: int, must be a str", dict(method=3)),
            (VALUE, "method: rnea does not answer forward_dynamics", dict(method="rnea")),
            (VALUE, "refine: must be 0 to 3", dict(refine=4)),
            (VALUE, "refine: must be 0 to 3", dict(refine=-1)),
            (VALUE, "refine: must be 0 to 3", dict(refine=2**70)),
            (TYPE, "must be an int", dict(refine=1.0)),
            (TYPE, "must be an int", dict(refine=True)),
            (VALUE, "no link 'tol0'", dict(wrench={"tol0": q[:6]})),
            (VALUE, "wrench.tool0: shape (7,), must be (6,)", dict(wrench={"tool0": q}),
             "wrench.tool0"),
            (VALUE, "wrench[2] (tool0): nan", dict(wrench={"tool0": [0, 0, NAN, 0, 0, 0]})),
            (VALUE, "9 links, at most 8", dict(wrench=[("tool0", q[:6])] * 9)),
            (TYPE, "not a pair", dict(wrench=[1, 2])),
            (TYPE, "must be {link: numbers}", dict(wrench=3)),
            (TYPE, "must be a dict", dict(payload=3)),
            (TYPE, "must be a dict", dict(payload=[3])),
            (VALUE, "payload.mass: missing", dict(payload={"link": "tool0"})),
            (VALUE, "payload.link: missing", dict(payload={"mass": 1})),
            (VALUE, "unknown key", dict(payload={**load_, "co": 1})),
            (VALUE, "payload.com: 1 numbers", dict(payload={**load_, "com": [1]}), "payload.com"),
            (VALUE, "payload.mass: -1: must not", dict(payload={**load_, "mass": -1})),
            (VALUE, "not a finite number", dict(payload={**load_, "mass": NAN})),
            (VALUE, "no link 'x'", dict(payload={**load_, "link": "x"})),
            (VALUE, "5 loads, at most 4", dict(payload=[load_] * 5)),
            (VALUE, "no moving joint 'elbow'", dict(locked=["elbow"])),
            (TYPE, "must be a list of joints", dict(locked=4)),
            (VALUE, "8 joints, the robot has 7", dict(locked=[0] * 8)),
            (VALUE, "with locked joints; aba does", dict(locked=[0], method="crba"), "locked"),
            (TYPE, "does not use it", dict(op="mass_matrix", locked=[0])),
            (VALUE, "acceleration: missing", dict(op="task_torques"), "acceleration"),
            (VALUE, "tips: missing", dict(op="task_torques", acceleration=[0] * 6), "tips"),
            (VALUE, "shape (5,), must be (6,) or (count, 6): 6 rows for each of 1 tips",
             dict(op="task_torques", acceleration=[0] * 5, tips="tool0"), "acceleration"),
            (VALUE, "0 links", dict(op="task_torques", acceleration={})),
            (VALUE, "'tool0' is not tip 0",
             dict(op="task_torques", acceleration={"tool0": [0] * 6}, tips="link_4"),
             "acceleration"),
            (TYPE, "", dict(op="task_torques", acceleration={"tool0": 3})),
            (VALUE, "rank_threshold: 2, must be above 0 and below 1",
             dict(op="task_torques", acceleration={"tool0": [0] * 6}, rank_threshold=2)),
            (TYPE, "must be a number",
             dict(op="task_torques", acceleration={"tool0": [0] * 6}, rank_threshold="x")),
            (VALUE, "the robot's base is fixed", dict(base_pose=self.pose)),
            (VALUE, "the robot has no flexible links", dict(modes=[0])),
        ]
        for kind, text, fields, *field in arm:
            with self.subTest(**fields):
                with self.fails(kind, text, field=field[0] if field else list(fields)[-1]):
                    self.arm.compute(fields.pop("op", "forward_dynamics"), q, **fields)
        n = self.dog.model.q_count
        own = "a floating base has a field of its own, "
        for text, fields, attributes in (
            ("base_pose: missing", dict(base_pose=None), dict(field="base_pose")),
            (own + "base_pose (x y z, quaternion x y z w)", dict(q=np.zeros(n + 7)), {}),
            (own + "base_wrench", dict(tau=np.zeros((3, n + 6))), {}),
            ("quaternion of norm 2, must be 1", dict(base_pose=[0, 0, 0, 0, 0, 0, 2]),
             dict(field="base_pose", status="E_QUATERNION")),
        ):
            with self.subTest(**fields), self.fails(VALUE, text, **attributes):
                self.dog.forward_dynamics(**{"q": np.zeros(n), "base_pose": self.pose, **fields})

    def test_constraints(self):
        feet = support.ROBOTS / "quadruped_feet.yaml"
        dog = tf.Workspace(load("quadruped", "floating", constraints=feet))
        state = {"q": np.zeros(12), "base_pose": self.pose}
        known = "the robot has 4 constraints (FL_foot, FR_foot, RL_foot, RR_foot)"
        for kind, text, fields, *attributes in (
            (VALUE, f"no constraint 'FL_fot'; nearest: 'FL_foot', 'FR_foot', 'RL_foot'; {known}",
             dict(constraints=["FL_fot"]), dict(field="constraints", constraint="FL_fot")),
            (VALUE, "no constraint '4'; nearest: ", dict(constraints=[4])),
            (VALUE, "'FL_foot' twice", dict(constraints=["FL_foot", 0])),
            (TYPE, "must be a list of constraints", dict(constraints=3.5)),
            (VALUE, f"none active; {known}", dict(constraints=[])),
            (VALUE, "stabilisation: 1 numbers", dict(stabilisation=[1])),
            (VALUE, "stabilisation[1]: -2: must not be negative", dict(stabilisation=[1, -2]),
             dict(field="stabilisation", index=1)),
            (VALUE, "'FL_foot' is not active; name it in constraints",
             dict(constraint_acceleration={"FL_foot": [0] * 6}, constraints="FR_foot"),
             dict(constraint="FL_foot")),
            (VALUE, "constraint_acceleration.FR_foot: shape (5,), must be (6,)",
             dict(constraint_acceleration={"FR_foot": [0] * 5})),
            (VALUE, "shape (6,), must be (24,) or (count, 24): 6 for each of 4 active constraints",
             dict(constraint_acceleration=np.zeros(6))),
            (VALUE, "constraint_acceleration[1] (RR_foot): nan: not a finite number",
             dict(constraint_acceleration={"RR_foot": [0, NAN, 0, 0, 0, 0]}, constraints=[0, 3]),
             dict(field="constraint_acceleration", constraint="RR_foot", index=7)),
            (TYPE, "does not use it", dict(torque_weights=np.ones(12))),
            (tf.NotComputedError,
             "constraints: rows of FL_foot, FR_foot, RL_foot, RR_foot depend on each other",
             dict(rank_loss="refuse", rank_threshold=0.1), dict(status="E_RANK")),
        ):
            with self.subTest(**fields), self.fails(kind, text, **dict(*attributes)):
                dog.constrained_dynamics(**state, **fields)
        with self.fails(VALUE, "torque_weights[1] (FL_thigh_joint): 0: must be above 0", index=1):
            dog.constrained_inverse_dynamics(**state, torque_weights={"FL_thigh_joint": 0})
        with self.fails(tf.InputError, "the robot has no constraints; `constraints` of its scene"):
            self.dog.impact(**state)

    def test_calls(self):
        q, v, check = np.zeros(7), np.zeros((9, 7)), self.arm.model.check
        v[6, 2] = np.inf
        self.assertIsNone(check("forward_dynamics", q))
        for kind, text, call, *attributes in (
            (TYPE, "by position are too many", lambda: self.arm.mass_matrix(q, q)),
            (TYPE, "by position are too many", lambda: self.arm.forward_dynamics(q, q, q, q)),
            (TYPE, "q: given twice", lambda: self.arm.mass_matrix(q, q=q), dict(field="q")),
            (VALUE, "q: missing; the robot has 7 joints", self.arm.mass_matrix, dict(field="q")),
            (VALUE, "q: missing", lambda: self.arm.mass_matrix(None)),
            (TYPE, "op: missing", self.arm.compute),
            (VALUE, "v[2] (joint_3) of state 6: inf",
             lambda: self.arm.forward_dynamics(np.zeros((9, 7)), v),
             dict(field="v", index=2, state=6, joint="joint_3", status="E_VALUE", code=-3)),
            (VALUE, "q: shape (6,)", lambda: check("forward_dynamics", q[:6]), dict(field="q")),
            (VALUE, "v[0] (joint_1): nan", lambda: check("forward_dynamics", q, [NAN] * 7),
             dict(field="v")),
            (VALUE, "tolerance", lambda: self.arm.model.advise(-1.0, q), dict(field="tolerance")),
        ):
            with self.subTest(text), self.fails(kind, text, **dict(*attributes)):
                call()

    def test_failed_states_leave_the_others(self):
        stretched = np.zeros((3, 6))
        stretched[0] = stretched[2] = [0.3, -1, 1, 0.2, 0.5, 0.1]
        stretched[1] = [0, -1, 0, 0, 0, 0]
        arm, up = tf.Workspace(load("arm6")), {"tool0": [0, 0, 1, 0, 0, 0]}
        with self.assertRaises(tf.NotComputedError) as caught:
            arm.task_torques(stretched, acceleration=up, rank_loss="refuse")
        error = caught.exception
        self.assertEqual((error.status, error.state, error.field), ("E_RANK", 1, "tips"))
        self.assertIn("rank 5 of 6 here; rank_loss='truncate' or 'damp' answers", str(error))
        one = arm.task_torques(stretched[2], acceleration=up)
        self.same_bits(error.reply.tau[2], one.tau, "the state behind it")
        self.assertTrue(np.isnan(error.reply.tau[1]).all())


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
            self.assertEqual((error.file, error.line, error.link), (str(path), 3, "arm"))
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
            self.assertEqual((caught.exception.errno, caught.exception.filename),
                             (2, folder + "/none.urdf"))
            with self.assertRaises(tf.FileError):
                tf.Model(folder)

    def test_options(self):
        path = support.ROBOTS / "arm7.urdf"
        for kind, text, options in (
            (VALUE, "base: no 'flying'", dict(base="flying")),
            (TYPE, "base: int", dict(base=1)),
            (VALUE, "gravity: 1 numbers", dict(gravity=[1])),
            (tf.Error, "", dict(gravity=[0, 0, NAN])),
            (VALUE, "mimic", dict(mimic="x")),
            (VALUE, "inertia", dict(inertia="x")),
            (tf.Error, "", dict(snap=1)),
            (tf.LoadError, "nowhere", dict(root="nowhere")),
            (TYPE, "root: int", dict(root=4)),
            (tf.LoadError, "nowhere", dict(tips=["nowhere"])),
            (TYPE, "tips", dict(tips=4)),
            (tf.LoadError, "nothing", dict(locked=["nothing"])),
            (tf.Error, "locked", dict(locked={"joint_1": "x"})),
            (VALUE, "locked", dict(locked={"joint_1": [1, 2]})),
            (TYPE, "locked", dict(locked=3)),
            (tf.LoadError, "x", dict(payload={"link": "x", "mass": 1})),
        ):
            with self.subTest(**options), self.fails(kind, text):
                tf.Model(path, **options)
        for wrong in ({"bse": "fixed"}, {"path": 3}):
            self.assertRaises(TypeError, tf.Model, path, **wrong)
        for wrong in (None, 3, object()):
            self.assertRaises(TypeError, tf.Model, wrong)
            self.assertRaises(TypeError, tf.Model.parse, wrong)
        with self.fails(tf.LoadError, "", status="E_PARSE"):
            tf.Model.parse("<robot")

    def test_workspaces_and_pools(self):
        model = load("arm7")
        for kind, make, options in (
            (VALUE, tf.Workspace, dict(precision="f16")),
            (VALUE, tf.Workspace, dict(residual="x")),
            (VALUE, tf.Workspace, dict(states="all")),
            (VALUE, tf.Workspace, dict(methods=["x"])),
            (TYPE, tf.Workspace, dict(methods=3)),
            (tf.UnsupportedError, tf.Workspace, dict(max_tips=33)),
            (TYPE, tf.Workspace, dict(specialised=model)),
            (VALUE, tf.Pool, dict(threads=257)),
            (VALUE, tf.Pool, dict(threads=2, cpus=[0])),
            (TYPE, tf.Pool, dict(threads=1, cpus=["x"])),
            (VALUE, tf.Pool, dict(priority=100)),
            (TYPE, tf.Pool, dict(thread_pool=3)),
        ):
            with self.subTest(**options), self.fails(kind):
                make(model, **options)
        for wrong in (-1, 2**32, 2**70):
            for make, of, name in ((tf.Workspace, model, "max_tips"), (tf.Pool, model, "threads"),
                                   (tf.Client, "arm", "slots")):
                with self.subTest(name), self.fails(VALUE, "not within 0 to 4294967295"):
                    make(of, **{name: wrong})
        self.assertRaises(TypeError, tf.Pool, model, threads=1.5)
        for wrong in (None, 3, "arm7.urdf"):
            self.assertRaises(TypeError, tf.Workspace, wrong)
            self.assertRaises(TypeError, tf.Pool, wrong)
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
            (tf.Pool(rope, 1, methods=["hessenberg"]), dict(method="hessenberg"),
             "the limit is a main chain of 130 bodies; tfa and auto answer"),
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
