# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The bits of C: every op of the bundled robots as `totalforce solve` and `call` answer it."""
import numpy as np

import support
import totalforce as tf
from support import Case, daemon, json_arrays, json_line, load, run_tool, state, tips_of

EVERYWHERE = ["poses", "com", "momentum", "energy", "generalised_momentum"]  # rigid: the last
OF_TIPS = ["pose", "twist", "jacobian", "bias_acceleration"]
OF_LAMBDA = ["lambda", "mu", "p", "spectrum"]


def questions(model, tips, rng):
    """(op, fields) of every op, with scenes, wrenches and everything that can be wanted."""
    s = state(model, rng)
    tau = {name: s.pop(name) for name in ("tau", "base_wrench") if name in s}
    qdd = {"qdd": rng.uniform(-1, 1, model.v_count)}
    if model.base_freedoms:
        qdd["base_acceleration"] = rng.uniform(-1, 1, 6)
    tip = {"tips": tips, "want": OF_TIPS + EVERYWHERE}
    changes = {
        "wrench": {tips[0]: rng.uniform(-9, 9, 6), model.links[1]: rng.uniform(-9, 9, 6)},
        "payload": {
            "link": tips[0],
            "mass": 0.5,
            "com": [0, 0, 0.1],
            "inertia": [0.01, 0, 0, 0.01, 0, 0.01],
        },
        "gravity": [0.1, 0.2, -9],
    }
    locked = {"locked": [model.joint_names[2]]}
    yield "forward_dynamics", {**s, **tau}
    yield "forward_dynamics", {**s, **tau, **changes, "estimate": "always", "refine": 1}
    yield "forward_dynamics", {
        **s,
        **tau,
        **changes,
        **locked,
        "tips": tips,
        "want": OF_TIPS + EVERYWHERE + OF_LAMBDA,
        "frame": "local",
    }
    yield "forward_dynamics", {**s, **tau, "method": "crba"}
    yield "inverse_dynamics", {**s, **qdd, **changes, **tip, "frame": "world"}
    yield "operational_inertia", {
        **s,
        "tips": tips,
        "rows": "point",
        "want": OF_LAMBDA,
        "rank_loss": "damp",
        "rank_threshold": 1e-5,
    }
    yield "mass_matrix", {**s, **tip}
    yield "kinematics", {**s, **tip, "rows": "point"}
    yield "bias", {**s, **changes}
    yield "bias", {**s, **qdd, "want": ["energy"]}
    task = {
        "acceleration": {name: rng.uniform(-1, 1, 3) for name in tips},
        "posture_torques": rng.uniform(-5, 5, model.v_count),
    }
    yield "task_torques", {**s, **task, **changes}
    yield "derivatives", {**s, **tau}
    yield "regressor", {**s, **qdd, "tips": tips}


def one_state(fields, k):
    """State k of a batch."""
    if isinstance(fields, np.ndarray):
        return fields[k] if fields.ndim == 2 else fields
    if isinstance(fields, dict):
        return {name: one_state(value, k) for name, value in fields.items()}
    return fields


def named(fields, names):
    """With names in place of indices of constraints, as JSON has them."""
    listed = [names[c] if isinstance(c, int) else c for c in fields.get("constraints", [])]
    return {**fields, "constraints": listed} if listed else fields


class SameBits(Case):
    def compare(self, solver, answers, asked):
        self.assertEqual(len(answers), len(asked))
        for (op, fields), answer in zip(asked, answers):
            self.assertEqual(answer["status"], "ok", answer)
            reply = solver.compute(op, **fields)
            wanted = json_arrays(solver if isinstance(solver, tf.Client) else solver.model, answer)
            self.assertGreater(len(wanted), 0)
            for name, numbers in wanted.items():
                if name.startswith("base_") and name not in reply:
                    continue  # part of a vector with the base first
                self.same_bits(reply[name], numbers, f"{op}: {name}")
            self.assertEqual(reply.method, answer["method"])
            self.assertEqual(reply.model, answer["model"])
            for name in ("rank", "threshold", "eig_min", "eig_max", "error_estimate"):
                if name in answer:
                    self.same_bits(getattr(reply, name), answer[name], f"{op}: {name}")

    def observe(self, model, client, tip):
        """An observer through the daemon has the bits of one in this process."""
        both = [tf.Observer(solver, 40, max_gap=1) for solver in (tf.Workspace(model), client)]
        rng = np.random.default_rng(3)
        for k in range(12):
            sample = state(model, rng)
            time = 0.01 * k + (2 if k > 8 else 0)
            events = [o.update(time, **sample) for o in both]
            expected = {0: "started", 9: "gap"}.get(k, "updated")
            self.assertEqual(events, [expected] * 2)
            self.same_bits(both[0].torques, both[1].torques, "observer")
        self.assertGreater(np.abs(both[0].torques).max(), 0)
        where = {name: sample[name] for name in ("q", "base_pose") if name in sample}
        self.same_bits(*(o.wrench(tip, **where) for o in both), "wrench")

    def test_workspace_and_pool_against_solve(self):
        for file, base, tips in support.ROBOT_LIST:
            with self.subTest(robot=file, base=base):
                model = load(file, base)
                rng = np.random.default_rng(7)
                asked = list(questions(model, tips_of(model, tips), rng))
                answers = run_tool(
                    ["solve", str(support.ROBOTS / f"{file}.urdf"), "--base", base],
                    [json_line(op, fields) for op, fields in asked],
                )
                self.compare(tf.Workspace(model), answers, asked)
                with tf.Pool(model, 2) as pool:
                    self.compare(pool, answers, asked)

    def test_planar_floating_and_mimic_joints(self):
        data = support.SOURCE / "tests" / "tools" / "data"
        for file, base, options, arguments in (
            ("cart", "fixed", {}, []),
            ("arm", "floating", {}, []),
            (
                "hand",
                "fixed",
                {"mimic": "project", "lock_massless_leaves": True, "damping": True,
                 "friction": True, "rotors": {"swing": 0.25}},
                ["--mimic", "project", "--lock-massless-leaves", "--damping", "--friction",
                 "--rotor", "swing=0.25"],
            ),
        ):
            model = tf.Model(data / f"{file}.urdf", base=base, **options)
            rng = np.random.default_rng(5)
            fields = state(model, rng)
            asked = [
                ("forward_dynamics", fields),
                (
                    "bias",
                    {name: fields[name] for name in fields if name not in ("tau", "base_wrench")},
                ),
                (
                    "mass_matrix",
                    {"q": fields["q"], **{n: fields[n] for n in fields if n == "base_pose"}},
                ),
            ]
            lines = [json_line(op, question) for op, question in asked]
            path = str(data / f"{file}.urdf")
            answers = run_tool(["solve", path, "--base", base, *arguments], lines)
            self.compare(tf.Workspace(model), answers, asked)
            joint = model.joints[-1]
            if joint.q_count > 1:  # a joint with several coordinates by name
                part = fields["q"][joint.q_index : joint.q_index + joint.q_count]
                q = np.zeros(model.q_count)
                for other in model.joints:
                    if other.type == "floating":
                        q[other.q_index + 6] = 1
                q[joint.q_index : joint.q_index + joint.q_count] = part
                rest = {n: fields[n] for n in fields if n == "base_pose"}
                solver = tf.Workspace(model)
                self.same_bits(
                    solver.mass_matrix({joint.name: part}, **rest).M,
                    solver.mass_matrix(q, **rest).M,
                    "by name",
                )

    def test_client_against_call(self):
        robots = [("arm", "arm7", "fixed"), ("dog", "quadruped", "floating")]
        with daemon(robots) as (folder, _):
            for name, file, base in robots:
                model = load(file, base)
                tips = tips_of(model, {f: t for f, _, t in support.ROBOT_LIST}[file])
                asked = list(questions(model, tips, np.random.default_rng(8)))
                answers = run_tool(
                    ["call", name, "--runtime-dir", folder],
                    [json_line(op, fields) for op, fields in asked],
                )
                with tf.Client(name, runtime_dir=folder, connect_timeout=support.WAIT) as client:
                    self.assertEqual(client.hash, model.hash)
                    self.assertEqual(client.joint_names, model.joint_names)
                    self.observe(model, client, tips[0])
                    self.assertEqual(client.links, model.links)
                    self.compare(client, answers, asked)

    def test_modes(self):
        path = support.ROBOTS / "arm7.urdf"
        modes = support.SOURCE / "tests" / "tools" / "data" / "arm7_modes.yaml"
        model = tf.Model(path, modes=modes)
        self.assertEqual(model.modes, ("link_2", "link_2", "link_4"))
        rng = np.random.default_rng(11)
        batch = state(model, rng, 21)
        batch["modes"] = rng.uniform(-0.04, 0.04, (21, 3))
        batch["mode_velocities"] = rng.uniform(-1, 1, (21, 3))
        batch["modes"][0, 0] = 0.06  # beyond its limit
        one = {name: numbers[0] for name, numbers in batch.items()}
        still = {name: one[name] for name in ("q", "modes", "mode_velocities")}
        tip = {"tips": ["tool0"], "want": OF_TIPS + EVERYWHERE[:-1]}
        asked = [("forward_dynamics", {**one, "method": m}) for m in ("aba", "scan", "dca")]
        asked += [
            ("forward_dynamics", {**one, **tip}),
            ("operational_inertia", {**still, **tip}),
            ("kinematics", {**still, **tip, "v": one["v"]}),
        ]
        lines = [json_line(op, fields) for op, fields in asked]
        answers = run_tool(["solve", str(path), "--modes", str(modes)], lines)
        self.assertIn("modes", answers[0])
        self.assertTrue(answers[0]["mode_limit"])
        workspace = tf.Workspace(model)
        self.compare(workspace, answers, asked)
        scene = f"    scenes: [{{name: flexible, modes: [{modes}]}}]\n"
        with daemon([("arm", "arm7", "fixed")], scene) as (folder, _):
            called = run_tool(["call", "arm.flexible", "--runtime-dir", folder], lines)
            with tf.Client("arm.flexible", runtime_dir=folder, connect_timeout=support.WAIT) as c:
                self.assertEqual(c.modes, model.modes)
                self.compare(c, called, asked)
                self.compare(c, answers, asked)
        reply = workspace.forward_dynamics(**batch)
        self.assertEqual((reply.flags & tf.ANSWER_MODE_LIMIT).tolist(), [512] + [0] * 20)
        with tf.Pool(model, 3) as pool:
            spread = pool.forward_dynamics(**batch)
        for k in range(21):
            alone = workspace.forward_dynamics(**{n: f[k] for n, f in batch.items()})
            for name in ("qdd", "modes"):
                self.same_bits(reply[name][k], alone[name], f"{name}[{k}]")
                self.same_bits(spread[name][k], alone[name], f"{name}[{k}] of a pool")

    def test_constraints(self):
        path, feet = support.ROBOTS / "quadruped.urdf", support.ROBOTS / "quadruped_feet.yaml"
        model = load("quadruped", "floating", constraints=feet)
        names = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
        self.assertEqual(model.constraints, names)
        rng = np.random.default_rng(12)
        batch = state(model, rng, 21)
        tau = {name: batch.pop(name) for name in ("tau", "base_wrench")}
        qdd = {"qdd": rng.uniform(-1, 1, (21, model.v_count))}
        wanted = {name: rng.uniform(-1, 1, (21, 6)) for name in names[2:]}
        some = {"constraints": [3, "FL_foot", "RL_foot"], "stabilisation": [100, 20]}
        some["constraint_acceleration"] = wanted
        questions_of = [
            ("constrained_dynamics", {**batch, **tau, "want": ["delassus", "energy"]}),
            ("constrained_dynamics", {**batch, **tau, **some, "method": "crba"}),
            ("impact", {**batch, "want": ["delassus"], "constraints": ["FR_foot"]}),
            ("impact", {**batch, "rank_loss": "truncate", "rank_threshold": 0.05}),
            (
                "constrained_inverse_dynamics",
                {**batch, **qdd, **some, "torque_weights": {"FL_calf_joint": 3}},
            ),
        ]
        asked = [(op, one_state(fields, 0)) for op, fields in questions_of]
        lines = [json_line(op, named(fields, names)) for op, fields in asked]
        answers = run_tool(
            ["solve", str(path), "--base", "floating", "--constraints", str(feet)], lines
        )
        workspace = tf.Workspace(model)
        self.compare(workspace, answers, asked)
        self.assertGreater(len(answers[3]["lost"]), 0)
        lists = feet.read_text().replace("\n", "\n    ")
        scene = f"    scenes:\n    - name: standing\n    {lists[lists.index('  constraints') :]}\n"
        with daemon([("dog", "quadruped", "floating")], scene) as (folder, _):
            called = run_tool(["call", "dog.standing", "--runtime-dir", folder], lines)
            with tf.Client("dog.standing", runtime_dir=folder, connect_timeout=support.WAIT) as c:
                self.assertEqual(c.constraints, names)
                self.assertEqual(c.hash, model.hash)
                self.compare(c, called, asked)
                self.compare(c, answers, asked)
        with tf.Pool(model, 3) as pool:
            for op, fields in questions_of:
                reply, spread = workspace.compute(op, **fields), pool.compute(op, **fields)
                for k in range(21):
                    alone = workspace.compute(op, **one_state(fields, k))
                    for name in alone:
                        self.same_bits(reply[name][k], alone[name], f"{op}: {name}[{k}]")
                        self.same_bits(spread[name][k], alone[name], f"{op}: {name}[{k}] of a pool")
                    pulls = alone.flags & tf.ANSWER_PULLS
                    self.assertEqual(bool(pulls), (alone.constraint_wrenches[2::6] < 0).any())
        order = [names[k] for k in (0, 2, 3)]
        flat = np.concatenate([wanted.get(n, np.zeros((21, 6))) for n in order], axis=1)
        op, fields = questions_of[1]
        self.same_bits(
            workspace.compute(op, **{**fields, "constraint_acceleration": flat}).qdd,
            workspace.compute(op, **fields).qdd,
            "an array in place of a dict",
        )

    def test_batch_is_its_states(self):
        for file, base, tips in support.ROBOT_LIST:
            model = load(file, base)
            workspace = tf.Workspace(model)
            tips = tips_of(model, tips)
            fields = state(model, np.random.default_rng(9), 21)
            fields.update(
                tips=tips,
                wrench={tips[0]: np.random.default_rng(1).random((21, 6))},
                want=OF_TIPS + EVERYWHERE + OF_LAMBDA,
            )
            batch = workspace.forward_dynamics(**fields)
            with tf.Pool(model, 3) as pool:
                spread = pool.forward_dynamics(**fields)
            for k in range(21):
                one = {n: f[k] if isinstance(f, np.ndarray) else f for n, f in fields.items()}
                one["wrench"] = {tips[0]: fields["wrench"][tips[0]][k]}
                reply = workspace.forward_dynamics(**one)
                for name in reply:
                    self.same_bits(batch[name][k], reply[name], f"{file}: {name}[{k}]")
                    self.same_bits(spread[name][k], reply[name], f"{file}: {name}[{k}] of a pool")
                self.same_bits(batch.eig_max[k], reply.eig_max, "eig_max")
            self.assertEqual(batch.answers["status"].tolist(), [0] * 21)

    def test_scene_and_options_are_those_of_the_command(self):
        path = support.ROBOTS / "humanoid.urdf"
        model = tf.Model(path, base="floating", damping=True, gravity=[0, 0, -1.6])
        lock, tip = model.joint_names[5], model.links[-1]
        scene = tf.Model(
            path,
            base="floating",
            damping=True,
            gravity=(0, 0, -1.6),
            locked={lock: 0.25},
            payload=[{"link": tip, "mass": 2, "com": [0, 0, 0.1]}],
        )
        arguments = [
            "--base",
            "floating",
            "--damping",
            "--gravity",
            "0,0,-1.6",
            "--lock",
            f"{lock}=0.25",
            "--payload",
            f"{tip}:2,0,0,0.1",
        ]
        fields = state(scene, np.random.default_rng(3))
        (answer,) = run_tool(
            ["solve", str(path), *arguments], [json_line("forward_dynamics", fields)]
        )
        self.assertEqual(answer["status"], "ok", answer)
        self.same_bits(tf.Workspace(scene).forward_dynamics(**fields).qdd, answer["qdd"], "qdd")
        self.assertEqual(scene.v_count, model.v_count - 1)
        derived = model.derive(payload={"link": tip, "mass": 2, "com": [0, 0, 0.1]})
        direct = tf.Model(
            path,
            base="floating",
            damping=True,
            gravity=(0, 0, -1.6),
            payload={"link": tip, "mass": 2, "com": [0, 0, 0.1]},
        )
        self.assertEqual(derived.hash, direct.hash)
        self.assertIs(derived.parent, model)
        self.assertEqual(tf.Model.parse(path.read_text()).hash, tf.Model(str(path)).hash)
        self.assertEqual(tf.Model.parse(path.read_bytes()).hash, tf.Model(str(path)).hash)

    def test_precisions_differ_as_they_should(self):
        model = load("arm7")
        fields = state(model, np.random.default_rng(4))
        exact = tf.Workspace(model, precision="f128").forward_dynamics(**fields).qdd
        double = tf.Workspace(model).forward_dynamics(**fields).qdd
        single = tf.Workspace(model, precision="f32").forward_dynamics(**fields).qdd
        mixed = tf.Workspace(model, precision="f32", residual="f64").forward_dynamics(**fields).qdd
        size = np.linalg.norm(exact)
        self.assertLess(np.linalg.norm(double - exact) / size, 1e-12)
        self.assertGreater(np.linalg.norm(single - exact) / size, 1e-9)
        self.assertLess(np.linalg.norm(mixed - exact) / size, 1e-12)

    def test_advice(self):
        model = load("humanoid")
        fields = state(model, np.random.default_rng(5), 4)
        fields["v"] *= 0
        advice = model.advise(0.5, **fields)
        self.assertEqual(len(advice.single_error), len(model.joint_names))
        self.assertLessEqual(advice.error, 0.5)
        self.assertTrue(set(advice.joints) <= set(model.joint_names))


if __name__ == "__main__":
    support.main()
