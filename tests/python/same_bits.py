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
    changes = {"wrench": {tips[0]: rng.uniform(-9, 9, 6), model.links[1]: rng.uniform(-9, 9, 6)},
               "payload": [{"link": model.links[1], "mass": 0.25},
                           {"link": tips[0], "mass": 0.5, "com": [0, 0, 0.1],
                            "inertia": [0.01, 0, 0, 0.01, 0, 0.01]}], "gravity": [0.1, 0.2, -9]}
    locked = {"locked": [model.joint_names[2]]}
    yield "forward_dynamics", {**s, **tau}
    yield "forward_dynamics", {**s, **tau, **changes, "estimate": "always", "refine": 1}
    yield "forward_dynamics", {**s, **tau, **changes, **locked, "tips": tips,
                               "want": OF_TIPS + EVERYWHERE + OF_LAMBDA, "frame": "local"}
    yield "forward_dynamics", {**s, **tau, "method": "crba"}
    yield "inverse_dynamics", {**s, **qdd, **changes, **tip, "frame": "world"}
    yield "operational_inertia", {**s, "tips": tips, "rows": "point", "want": OF_LAMBDA,
                                  "rank_loss": "damp", "rank_threshold": 1e-5}
    yield "mass_matrix", {**s, **tip}
    yield "kinematics", {**s, **tip, "rows": "point"}
    yield "bias", {**s, **changes}
    yield "bias", {**s, **qdd, "want": ["energy"]}
    task = {"acceleration": {name: rng.uniform(-1, 1, 3) for name in tips},
            "posture_torques": rng.uniform(-5, 5, model.v_count)}
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


def ask_tool(arguments, asked, names=()):
    return run_tool(arguments, [json_line(op, named(fields, names)) for op, fields in asked])


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

    def check_served(self, model, served, scene, asked, answers):
        """The client of a scene answers as `call` and `solve` do."""
        name = scene and f"{served[0]}.test" or served[0]
        with daemon([served], scene) as (folder, _):
            called = ask_tool(["call", name, "--runtime-dir", folder], asked, model.constraints)
            with tf.Client(name, runtime_dir=folder, connect_timeout=support.WAIT) as client:
                for known in ("hash", "joint_names", "links", "modes", "constraints"):
                    self.assertEqual(getattr(client, known), getattr(model, known))
                self.compare(client, called, asked)
                self.compare(client, answers, asked)

    def check_batch(self, model, op, fields):
        """A batch is its states in a workspace and in a pool. Gives the answers to both."""
        workspace = tf.Workspace(model)
        batch = workspace.compute(op, **fields)
        with tf.Pool(model, 3) as pool:
            spread = pool.compute(op, **fields)
        alone = [workspace.compute(op, **one_state(fields, k)) for k in range(21)]
        for k, reply in enumerate(alone):
            for name in reply:
                self.same_bits(batch[name][k], reply[name], f"{op}: {name}[{k}]")
                self.same_bits(spread[name][k], reply[name], f"{op}: {name}[{k}] of a pool")
        return batch, alone

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
                answers = ask_tool(["solve", str(support.ROBOTS / f"{file}.urdf"), "--base", base],
                                   asked)
                self.compare(tf.Workspace(model), answers, asked)
                with tf.Pool(model, 2) as pool:
                    self.compare(pool, answers, asked)

    def test_planar_floating_and_mimic_joints(self):
        data = support.SOURCE / "tests" / "tools" / "data"
        for file, base, options, arguments in (
            ("cart", "fixed", {}, []),
            ("arm", "floating", {}, []),
            ("hand", "fixed",
             {"mimic": "project", "lock_massless_leaves": True, "damping": True, "friction": True,
              "rotors": {"swing": 0.25}},
             ["--mimic", "project", "--lock-massless-leaves", "--damping", "--friction", "--rotor",
              "swing=0.25"]),
        ):
            model = tf.Model(data / f"{file}.urdf", base=base, **options)
            fields = state(model, np.random.default_rng(5))
            rest = {n: fields[n] for n in fields if n == "base_pose"}
            moving = {n: fields[n] for n in fields if n not in ("tau", "base_wrench")}
            asked = [("forward_dynamics", fields), ("bias", moving),
                     ("mass_matrix", {"q": fields["q"], **rest})]
            path = str(data / f"{file}.urdf")
            answers = ask_tool(["solve", path, "--base", base, *arguments], asked)
            self.compare(tf.Workspace(model), answers, asked)
            joint = model.joints[-1]
            if joint.q_count > 1:  # a joint with several coordinates by name
                part = fields["q"][joint.q_index : joint.q_index + joint.q_count]
                q = np.zeros(model.q_count)
                for other in model.joints:
                    if other.type == "floating":
                        q[other.q_index + 6] = 1
                q[joint.q_index : joint.q_index + joint.q_count] = part
                solver = tf.Workspace(model)
                self.same_bits(solver.mass_matrix({joint.name: part}, **rest).M,
                               solver.mass_matrix(q, **rest).M, "by name")

    def test_client_against_call(self):
        robots = [("arm", "arm7", "fixed"), ("dog", "quadruped", "floating")]
        with daemon(robots) as (folder, _):
            for name, file, base in robots:
                model = load(file, base)
                tips = tips_of(model, {f: t for f, _, t in support.ROBOT_LIST}[file])
                asked = list(questions(model, tips, np.random.default_rng(8)))
                answers = ask_tool(["call", name, "--runtime-dir", folder], asked)
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
        asked += [("forward_dynamics", {**one, **tip}), ("operational_inertia", {**still, **tip}),
                  ("kinematics", {**still, **tip, "v": one["v"]})]
        answers = ask_tool(["solve", str(path), "--modes", str(modes)], asked)
        self.assertIn("modes", answers[0])
        self.assertTrue(answers[0]["mode_limit"])
        self.compare(tf.Workspace(model), answers, asked)
        self.check_served(model, ("arm", "arm7", "fixed"),
                          f"    scenes: [{{name: test, modes: [{modes}]}}]\n", asked, answers)
        reply, _ = self.check_batch(model, "forward_dynamics", batch)
        self.assertEqual((reply.flags & tf.ANSWER_MODE_LIMIT).tolist(), [512] + [0] * 20)

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
        questions_of = [("constrained_dynamics", {**batch, **tau, "want": ["delassus", "energy"]}),
                        ("constrained_dynamics", {**batch, **tau, **some, "method": "crba"}),
                        ("impact", {**batch, "want": ["delassus"], "constraints": ["FR_foot"]}),
                        ("impact", {**batch, "rank_loss": "truncate", "rank_threshold": 0.05}),
                        ("constrained_inverse_dynamics",
                         {**batch, **qdd, **some, "torque_weights": {"FL_calf_joint": 3}})]
        asked = [(op, one_state(fields, 0)) for op, fields in questions_of]
        answers = ask_tool(["solve", str(path), "--base", "floating", "--constraints", str(feet)],
                           asked, names)
        workspace = tf.Workspace(model)
        self.compare(workspace, answers, asked)
        self.assertGreater(len(answers[3]["lost"]), 0)
        lists = feet.read_text().replace("\n", "\n    ")
        scene = f"    scenes:\n    - name: test\n    {lists[lists.index('  constraints') :]}\n"
        self.check_served(model, ("dog", "quadruped", "floating"), scene, asked, answers)
        for op, fields in questions_of:
            for alone in self.check_batch(model, op, fields)[1]:
                pulls = alone.flags & tf.ANSWER_PULLS
                self.assertEqual(bool(pulls), (alone.constraint_wrenches[2::6] < 0).any())
        order = [names[k] for k in (0, 2, 3)]
        flat = np.concatenate([wanted.get(n, np.zeros((21, 6))) for n in order], axis=1)
        op, fields = questions_of[1]
        self.same_bits(workspace.compute(op, **{**fields, "constraint_acceleration": flat}).qdd,
                       workspace.compute(op, **fields).qdd, "an array in place of a dict")

    def test_batch_is_its_states(self):
        for file, base, tips in support.ROBOT_LIST:
            model = load(file, base)
            tips = tips_of(model, tips)
            fields = state(model, np.random.default_rng(9), 21)
            fields.update(tips=tips, wrench={tips[0]: np.random.default_rng(1).random((21, 6))},
                          want=OF_TIPS + EVERYWHERE + OF_LAMBDA)
            batch, alone = self.check_batch(model, "forward_dynamics", fields)
            self.same_bits(batch.eig_max, [reply.eig_max for reply in alone], "eig_max")
            self.assertEqual(batch.answers["status"].tolist(), [0] * 21)

    def test_scene_and_options_are_those_of_the_command(self):
        path = support.ROBOTS / "humanoid.urdf"
        made = {"base": "floating", "damping": True, "gravity": (0, 0, -1.6)}
        model = tf.Model(path, **made)
        lock, tip = model.joint_names[5], model.links[-1]
        load_ = {"link": tip, "mass": 2, "com": [0, 0, 0.1]}
        scene = tf.Model(path, **made, locked={lock: 0.25}, payload=[load_])
        arguments = ["--base", "floating", "--damping", "--gravity", "0,0,-1.6", "--lock",
                     f"{lock}=0.25", "--payload", f"{tip}:2,0,0,0.1"]
        asked = [("forward_dynamics", state(scene, np.random.default_rng(3)))]
        self.compare(tf.Workspace(scene), ask_tool(["solve", str(path), *arguments], asked), asked)
        self.assertEqual(scene.v_count, model.v_count - 1)
        derived = model.derive(payload=load_)
        self.assertEqual(derived.hash, tf.Model(path, **made, payload=load_).hash)
        self.assertIs(derived.parent, model)
        for text in (path.read_text(), path.read_bytes()):
            self.assertEqual(tf.Model.parse(text).hash, tf.Model(str(path)).hash)

    def test_precisions_differ_as_they_should(self):
        model = load("arm7")
        fields = state(model, np.random.default_rng(4))
        exact, *rounded = (tf.Workspace(model, **options).forward_dynamics(**fields).qdd
                           for options in ({"precision": "f128"}, {}, {"precision": "f32"},
                                           {"precision": "f32", "residual": "f64"}))
        double, single, mixed = (np.linalg.norm(qdd - exact) / np.linalg.norm(exact)
                                 for qdd in rounded)
        self.assertLess(double, 1e-12)
        self.assertGreater(single, 1e-9)
        self.assertLess(mixed, 1e-12)

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
