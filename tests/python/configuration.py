# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Laws of integrate, difference, neutral, random_configuration and joint_limits."""
import pickle

import numpy as np
import support

import totalforce as tf

LINK = (
    "<link name='{0}'><inertial><mass value='1'/><origin xyz='0.1 0.2 0.3'/><inertia ixx='1' "
    "ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>"
)
JOINT = (
    "<joint name='{0}' type='{1}'><parent link='{2}'/><child link='{0}'/>{3}"
    "<origin xyz='0.1 0 0.4' rpy='0.3 0.2 0'/><axis xyz='0.6 0 0.8'/></joint>"
)
PARTS = [
    ("table", "planar", "root", ""),
    ("drone", "floating", "table", "<limit effort='3' velocity='2'/>"),
    ("wheel", "continuous", "drone", ""),
    ("lead", "revolute", "drone", "<limit lower='-1' upper='1' effort='9' velocity='0'/>"),
    ("tail", "revolute", "lead", "<mimic joint='lead' multiplier='-2' offset='0.5'/>"
     "<limit lower='-1' upper='3' effort='-1' velocity='7'/>"),
    ("slide", "prismatic", "tail", ""),
]  # fmt: skip
NAMES = ["root", *(part[0] for part in PARTS)]
MADE = "<robot name='made'>{}{}</robot>".format("".join(map(LINK.format, NAMES)),
                                                "".join(JOINT.format(*part) for part in PARTS))


def robots():
    for name, base, _ in support.ROBOT_LIST:
        yield f"{name} {base}", support.load(name, base)
    for base in ("fixed", "floating"):
        yield f"made {base}", tf.Model(MADE, base=base, mimic="project")


def velocities(model, rng, scale, count=()):
    v = rng.uniform(-1, 1, count + (model.v_count + model.base_freedoms,)) * scale
    twist = v[..., model.v_count :] if model.base_freedoms else None
    return {"v": v[..., : model.v_count], "base_twist": twist}


def poses(model, at):
    reply = tf.Workspace(model).kinematics(at.q, base_pose=at.base_pose, want="poses")
    signs = np.where(reply.poses[..., 6:] < 0, -1, 1) * [1, 1, 1, 1]
    return np.concatenate((reply.poses[..., :3], reply.poses[..., 3:] * signs), axis=-1)


class Configurations(support.Case):
    def near(self, got, wanted, what, tolerance=1e-12):
        for a, b in zip(got, wanted):
            self.assertEqual(a is None, b is None, what)
            if a is not None:
                np.testing.assert_allclose(a, b, rtol=0, atol=tolerance, err_msg=what)

    def test_inverses(self):
        for what, model in robots():
            rng = np.random.default_rng(3)
            q, p = model.random_configuration(rng, 50), model.random_configuration(rng, 50)
            v = model.difference(q, p)
            np.testing.assert_allclose(poses(model, model.integrate(q, v)), poses(model, p), rtol=0,
                                       atol=1e-9, err_msg=what)
            for scale in (1.8, 1e-3, 1e-9, 0):  # norms of rotations stay below pi
                v = velocities(model, rng, scale, (50,))
                back = model.difference(q, model.integrate(q, **v))
                self.near(back, v.values(), f"{what} {scale}", 3e-14 + 1e-13 * scale)

    def test_half_turns(self):
        model = tf.Model(MADE, base="floating")
        for angle in (np.pi, np.pi - 1e-9):
            v = {"v": np.zeros(model.v_count), "base_twist": np.array([1, 2, 3, angle, 0, 0])}
            start = model.neutral()
            self.near(model.difference(start, model.integrate(start, **v)), v.values(), str(angle))

    def test_rates_of_poses(self):
        h = 1e-5
        for what, model in robots():
            rng = np.random.default_rng(4)
            q, v = model.random_configuration(rng), velocities(model, rng, 1)
            ahead, behind = (model.integrate(q, dt=dt, **v) for dt in (h, -h))
            tip = model.links[-1]
            reply = tf.Workspace(model).kinematics(
                q.q, v["v"], base_pose=q.base_pose, base_twist=v["base_twist"], tips=tip,
                want=["twist", "jacobian"], 
            )  # fmt: skip
            rate = (poses(model, ahead)[-1] - poses(model, behind)[-1])[:3] / (2 * h)
            np.testing.assert_allclose(rate, reply.twist[0, :3], rtol=0, atol=1e-7, err_msg=what)
            moved = [x for x in (v["base_twist"], v["v"]) if x is not None]
            twist = reply.jacobian @ np.concatenate(moved)
            np.testing.assert_allclose(rate, twist[:3], rtol=0, atol=1e-7, err_msg=what)

    def test_neutral(self):
        for what, model in robots():
            start = model.neutral()
            self.assertEqual(np.count_nonzero(start.q), sum(j.q_count == 7 for j in model.joints))
            self.near(model.integrate(start), start, what, 0)
            for x in model.difference(start, start):
                self.assertTrue(x is None or not np.any(x), what)
            reply = tf.Workspace(model).kinematics(start.q, base_pose=start.base_pose,
                                                   tips=model.links[0], want="pose")
            self.near(reply.pose, [[0, 0, 0, 0, 0, 0, 1]], what, 0)

    def test_batches(self):
        for what, model in robots():
            rng = np.random.default_rng(5)
            q, p = model.random_configuration(rng, 7), model.random_configuration(rng)
            v, back = model.difference(q, p), model.difference(p, q)
            moved = model.integrate(p, v, dt=0.5)
            for k in range(7):
                one = tf.Configuration([x if x is None else x[k] for x in q])
                for got, wanted in ((model.difference(one, p), v), (model.difference(p, one), back),
                                    (model.integrate(p, model.difference(one, p), dt=0.5), moved)):
                    for a, b in zip(got, wanted):
                        self.assertEqual(a is None, b is None)
                        if a is not None:
                            self.same_bits(a, b[k], what)

    def test_random(self):
        for what, model in robots():
            first = model.random_configuration(8, 200)
            self.near(first, model.random_configuration(8, 200), what, 0)
            self.assertFalse((first.q == model.random_configuration(9, 200).q).all(), what)
            rng = np.random.default_rng(8)
            self.near(first, model.random_configuration(rng, 200), what, 0)
            self.assertFalse((first.q == model.random_configuration(rng, 200).q).all(), what)
            tf.Workspace(model).kinematics(first.q, base_pose=first.base_pose)
            for joint in model.declared:
                low, high, _, _ = model.joint_limits([joint.name])[joint.name]
                k = joint.joint if joint.joint >= 0 else joint.leader
                if k < 0 or model.joints[k].q_count > 1:
                    continue
                q = first.q[:, model.joints[k].q_index]
                q = q if joint.joint >= 0 else joint.multiplier * q + joint.offset
                self.assertTrue((low <= q).all() and (q <= high).all(), f"{what} {joint.name}")
                if np.isfinite(low) and joint.joint >= 0 and what[:4] != "made":
                    self.assertGreater(np.ptp(q), 0.9 * (high - low), joint.name)

    def test_limits(self):
        inf = np.inf
        wanted = {"table": (-inf, inf, inf, inf), "drone": (-inf, inf, 2, 3),
                  "wheel": (-inf, inf, inf, inf), "lead": (-1, 1, 0, 9), "tail": (-1, 3, 7, inf)}
        model = tf.Model(MADE, mimic="project")
        for one in (model, model.derive(gravity=[0, 0, 0]), pickle.loads(pickle.dumps(model))):
            self.assertEqual(one.joint_limits(wanted), wanted)
            self.assertEqual(tuple(one.joint_limits()), model.joint_names)
        self.assertEqual(tf.joint_limits(MADE, list(wanted)), wanted)
        self.assertEqual(model.joint_limits()["lead"].effort, 9)

    def test_refusals(self):
        arm, float_ = support.load("arm7"), support.load("quadruped", "floating")
        q = np.zeros(7)
        with self.fails(tf.InputError, "v: shape (6,)", field="v"):
            arm.integrate(q, np.zeros(6))
        with self.fails(tf.InputError, "to: q: shape (6,)"):
            arm.difference(q, np.zeros(6))
        with self.fails(tf.InputError, "to: 2 states, q has 3", field="to"):
            arm.difference(np.zeros((3, 7)), np.zeros((2, 7)))
        with self.fails(tf.InputError, "", field="q"):
            arm.integrate(np.full(7, np.nan))
        with self.fails(tf.InputError, "dt: inf", field="dt"):
            arm.integrate(q, dt=np.inf)
        with self.fails(tf.InputError, "base is fixed", field="base_pose"):
            arm.integrate(q, base_pose=[0, 0, 0, 0, 0, 0, 1])
        with self.fails(tf.InputError, "base_pose: missing", field="base_pose"):
            float_.integrate(np.zeros(float_.q_count))
        with self.fails(tf.InputTypeError, "names: int"):
            arm.joint_limits([3])


if __name__ == "__main__":
    support.main()
