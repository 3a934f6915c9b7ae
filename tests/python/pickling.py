# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Models and replies go to other processes; models come from files, names, text and bytes."""
import concurrent.futures
import multiprocessing
import os
import pathlib
import pickle
import tempfile
import unittest.mock

import numpy as np

import support
import totalforce as tf
from support import Case, ROBOTS, load, state

SCENE = {"base": "floating", "gravity": np.array([0, 0, -1.62]), "locked": {"FL_hip_joint": 0.1},
         "payload": [{"link": "FL_foot", "mass": 0.5, "com": [0, 0, 0.1]}], "damping": True,
         "friction": True, "friction_velocity": 0.02, "rotors": {"FL_hip_joint": 1e-4}}


def again(value):
    return pickle.loads(pickle.dumps(value))


def hash_and_reply(model, fields):
    """In the other process"""
    return model.hash, tf.Workspace(model).forward_dynamics(**fields, want=["momentum", "poses"])


class Pickling(Case):
    def test_models(self):
        arm = load("arm7")
        models = [arm, load("quadruped", **SCENE),
                  tf.Model.parse((ROBOTS / "arm6.urdf").read_text(), snap=1e-3, tips=("tool0",)),
                  arm.derive(gravity=[1, 2, 3]),
                  arm.derive(payload={"link": "tool0", "mass": 2}).derive(gravity=(0, 0, 0))]
        for model in models:
            with self.subTest(model=model):
                for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
                    copy = pickle.loads(pickle.dumps(model, protocol))
                    self.assertEqual(copy.hash, model.hash)
                    self.assertEqual(copy.notes, model.notes)
                    self.assertEqual(copy.parent is None, model.parent is None)
        self.assertIn("arm7.urdf", again(arm).notes[0])

    def test_the_file_may_be_gone_and_options_changed(self):
        gravity = np.array([0.0, 0, -3])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "arm.urdf"
            path.write_bytes((ROBOTS / "arm7.urdf").read_bytes())
            model = tf.Model(path, gravity=gravity)
        gravity[:] = 0
        self.assertEqual(again(model).hash, model.hash)
        model = load("humanoid", tips=iter(["left_hand_link"]))
        self.assertEqual(again(model).hash, model.hash)
        model = load("arm7", tips=(tip for tip in ["tool0"]))
        with self.assertRaisesRegex(TypeError, "options cannot be copied: give lists"):
            pickle.dumps(model)

    def test_constraints(self):
        """The same model from dicts, from a file, and again from pickles"""
        foot = {"name": "foot", "second": {"link": "tool0", "xyz": np.array([0, 0, 0.1])},
                "hold": "point", "unilateral": True}
        text = (b"constraints: [{name: foot, second: {link: tool0, xyz: [0, 0, 0.1]}, "
                b"hold: [x, y, z], unilateral: true}]\nactuated: [joint_1, joint_3]")
        motors = ["joint_3", "joint_1"]
        model = load("arm7", constraints=foot, actuated=motors)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "c.yaml"
            path.write_bytes(text)
            others = [load("arm7", constraints=path), load("arm7", constraints=[str(path)]),
                      load("arm7", constraints=(foot,), actuated=motors),
                      load("arm7", constraints=text)]
        for other in [model, *others]:
            self.assertEqual(other.hash, model.hash)
            self.assertEqual(again(other).hash, model.hash)
        hashes = {load("arm7").hash, model.hash, load("arm7", constraints=foot).hash,
                  load("arm7", actuated="joint_1").hash,
                  load("arm7", constraints=text, actuated=["joint_1"]).hash}
        self.assertEqual(len(hashes), 5)
        cases = [({"constraints": {**foot, "hold": "pt"}}, tf.LoadError, "'pt' is not one of point"),
                 ({"constraints": [foot, 3]}, tf.LoadError, r"constraints\[1\]: keys are expected"),
                 ({"constraints": [foot, foot]}, tf.LoadError, "another one has this name"),
                 ({"constraints": {**foot, "second": {"xyz": [0, 0, np.nan]}}}, tf.LoadError,
                  r"constraints\[0\].second.xyz: 'NaN' is not a finite number"),
                 ({"constraints": {**foot, "second": {"link": "tol0"}}}, tf.LoadError,
                  "nearest: 'tool0'"),
                 ({"constraints": 3}, tf.InputTypeError, "must be a file, bytes, or a list"),
                 ({"constraints": {**foot, "name": object()}}, tf.Error, "constraints: must be dicts"),
                 ({"constraints": "/nowhere.yaml"}, tf.LoadError, "No such file"),
                 ({"actuated": 3}, tf.InputTypeError, "must be a list of joints"),
                 ({"actuated": [3]}, tf.InputTypeError, "must be a name"),
                 ({"actuated": "joint"}, tf.LoadError, "nearest: 'joint_1'")]
        for options, error, message in cases:
            with self.subTest(options=options), self.assertRaisesRegex(error, message):
                load("arm7", **options)

    def test_another_process(self):
        dog = load("quadruped", **SCENE)
        fields = state(dog, np.random.default_rng(3), 4)
        wanted = tf.Workspace(dog).forward_dynamics(**fields, want=["momentum", "poses"])
        spawn = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(1, mp_context=spawn) as pool:
            found, reply = pool.submit(hash_and_reply, dog, fields).result()
        self.assertEqual(found, dog.hash)
        self.same_reply(reply, wanted)

    def same_reply(self, copy, reply):
        self.assertEqual(repr(copy), repr(reply))
        for name in ("op", "method", "fallback", "model", "exchange"):
            self.assertEqual(getattr(copy, name), getattr(reply, name), name)
        self.assertEqual(copy.answers.tobytes(), reply.answers.tobytes())
        for name in reply:
            self.same_bits(copy[name], reply[name], name)
        for name in ("rank", "condition", "eig_min"):
            if hasattr(reply, name):
                np.testing.assert_array_equal(getattr(copy, name), getattr(reply, name))
            self.assertEqual(hasattr(copy, name), hasattr(reply, name), name)

    def test_replies(self):
        arm = tf.Workspace(load("arm7"))
        for q in (np.zeros(7), np.linspace(0, 1, 21).reshape(3, 7)):
            for reply in (arm.mass_matrix(q), arm.forward_dynamics(q, estimate="always"),
                          arm.operational_inertia(q, ["tool0"], want=["spectrum", "lambda", "p"])):
                self.same_reply(again(reply), reply)
        reply = again(arm.mass_matrix(np.zeros(7)))
        arm.mass_matrix(np.ones(7), out=reply)
        self.same_bits(reply.M, arm.mass_matrix(np.ones(7)).M, "out=")

    def test_errors_with_replies(self):
        with self.assertRaises(tf.NotComputedError) as caught:
            tf.Workspace(load("arm6")).task_torques(np.array([[0.3, -1, 1, 0.2, 0.5, 0.1],
                                                              [0, -1, 0, 0, 0, 0]]),
                                                    acceleration={"tool0": [0, 0, 1, 0, 0, 0]},
                                                    rank_loss="refuse")
        copy = again(caught.exception)
        self.assertEqual((copy.status, copy.state), ("E_RANK", 1))
        self.same_bits(copy.reply.tau[0], caught.exception.reply.tau[0], "the good state")

    def test_broken_pickles(self):
        restore, arguments = tf.Workspace(load("arm7")).mass_matrix(np.zeros(7)).__reduce__()
        for k, wrong in ((1, 1), (4, b""), (5, b"short"), (6, np.zeros(3)), (7, {"M": 3}),
                         (7, {"N": np.zeros(1)})):
            with self.subTest(k=k, wrong=wrong), self.assertRaises(ValueError):
                restore(*arguments[:k], wrong, *arguments[k + 1 :])


class Sources(Case):
    def test_text_and_bytes(self):
        text = (ROBOTS / "arm7.urdf").read_text()
        wanted = load("arm7").hash
        rest = text.partition("?>")[2].lstrip()
        for source in (text, text.encode(), "\n  " + rest, "\ufeff" + text):
            self.assertEqual(tf.Model(source).hash, wanted)
        self.assertEqual(tf.Model.parse(bytearray(text.encode())).hash, wanted)
        self.assertEqual(tf.joint_limits(text), tf.joint_limits(ROBOTS / "arm7.urdf"))
        self.assertEqual(tf.Model(os.fsencode(ROBOTS / "arm7.urdf")).hash, wanted)
        with self.fails(tf.LoadError, "", status="E_PARSE"):
            tf.Model("<robot" + " " * 5000)

    def test_names(self):
        with tempfile.TemporaryDirectory() as folder:
            share = pathlib.Path(folder) / "share" / "my_arm"
            share.mkdir(parents=True)
            (share / "arm.urdf").write_bytes((ROBOTS / "arm7.urdf").read_bytes())
            with unittest.mock.patch.dict(os.environ, AMENT_PREFIX_PATH=folder, HOME=folder):
                for name in ("package://my_arm/arm.urdf", "$(find my_arm)/arm.urdf",
                             "~/share/my_arm/arm.urdf", f"file://{share}/arm.urdf"):
                    model = tf.Model(name)
                    self.assertEqual(model.hash, load("arm7").hash)
                    self.assertIn(f"{share}/arm.urdf", model.notes[0])
                    self.assertIn("joint_1", tf.joint_limits(name))
                with self.fails(tf.MissingFileError,
                                f"no package 'my_leg' in AMENT_PREFIX_PATH ({folder})", errno=2,
                                filename="package://my_leg/leg.urdf"):
                    tf.Model("package://my_leg/leg.urdf")

    def test_repr(self):
        for name, base, joints in (("quadruped", "floating", 12), ("arm7", "fixed", 7)):
            model = load(name, base)
            self.assertEqual(
                repr(model),
                f"<totalforce.Model '{name}': {joints} joints, {len(model.links)} links, "
                f"{base} base>",
            )


if __name__ == "__main__":
    support.main()
