# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Statistics of a running daemon, and histograms."""
import numpy as np
import support
import totalforce as tf
from wait import until


class Histograms(support.Case):
    def test_values(self):
        values = [3, 40, 40, 1000, 2**40]
        h = tf.Histogram(values)
        self.assertEqual((h.count, h.lowest, h.highest, h.sum), (5, 3, 2**40, float(sum(values))))
        self.assertEqual(h.mean, sum(values) / 5)
        self.assertEqual(int(h.buckets.sum()), 5)
        self.assertEqual(h.buckets.size, h.tops.size)
        self.assertTrue(np.all(h.tops[1:] > h.tops[:-1]))
        self.assertEqual(h.quantile(1), 2**40)
        for share, value in ((0.2, 3), (0.5, 40), (0.8, 1000)):
            self.assertTrue(value <= h.quantile(share) <= 1.063 * value, share)
        self.assertEqual((tf.Histogram().count, tf.Histogram().quantile(0.5)), (0, 0))

    def test_differences(self):
        earlier, later = tf.Histogram([5, 70]), tf.Histogram([5, 70, 900, 900])
        since = later.since(earlier)
        self.assertEqual((since.count, later.count, earlier.count), (2, 4, 2))
        self.assertTrue(900 <= since.quantile(0.1) <= 957)

    def test_errors(self):
        with self.fails(tf.InputTypeError, "must be a Histogram"):
            tf.Histogram().since([1])
        self.assertRaises(OverflowError, tf.Histogram, [-1])
        self.assertRaises(TypeError, tf.Histogram, ["a"])


class Figures(support.Case):
    def test_counts(self):
        with support.daemon([("arm", "arm7", "fixed"), ("dog", "quadruped", "floating")]) as (
            folder,
            process,
        ):
            statistics = tf.Statistics(folder)
            with tf.Client("arm", runtime_dir=folder) as client:
                for k in range(30):
                    client.forward_dynamics(np.full(7, 0.01 * k), method="crba" if k < 10 else None)
                with self.fails(tf.InputError):
                    client.forward_dynamics(np.full(7, np.nan))
                read = lambda: statistics.read()["robots"][0]["total"]
                self.assertTrue(until(lambda: read()["requests"] == 31), read())
                # whoever saw that the daemon serves is gone when its end is served
                shm = lambda: [c for c in statistics.read()["clients"] if c["kind"] == "shm"]
                self.assertTrue(until(lambda: len(shm()) == 1), shm())
                now, (mine,) = statistics.read(), shm()
            self.assertEqual(mine["tally"]["requests"], 31)
            self.assertEqual((mine["robot"], now["process"]), (0, process.pid))
            arm, dog = now["robots"]
            self.assertEqual((arm["name"], dog["name"], dog["base_freedoms"]), ("arm", "dog", 6))
            self.assertEqual(arm["model_hash"], support.load("arm7").hash)
            self.assertEqual(arm["total"]["methods"], {"crba": 10, "aba": 20})
            self.assertEqual(arm["total"]["statuses"], {"OK": 30, "E_VALUE": 1})
            self.assertEqual(arm["total"]["rejected"], 1)
            for time in ("queue", "compute", "total"):
                self.assertEqual(arm["total"][time].count, 31, time)
            self.assertLessEqual(arm["total"]["busy_ns"], arm["total"]["compute"].sum)
            self.assertEqual(arm["state"]["q"].shape, (7,))
            self.assertEqual((arm["state"]["base_pose"], dog["state"]), (None, None))
            self.assertIn("E_VALUE", tf.STATUSES)
            self.assertEqual((now["version"], now["stopped"], now["dds"]), (tf.__version__, 0, None))
            tf.daemon_command("stop", runtime_dir=folder)
            self.assertTrue(until(lambda: statistics.read()["stopped"] == 1))
            self.assertEqual(read()["requests"], 31)
            with self.fails(tf.DisconnectedError, "statistics"):
                tf.Statistics(folder)

    def test_snapshots_stay(self):
        """Figures outlive statistics and later snapshots."""
        with support.daemon([("arm", "arm7", "fixed")]) as (folder, _):
            statistics = tf.Statistics(folder)
            with tf.Client("arm", runtime_dir=folder) as client:
                client.forward_dynamics(np.zeros(7))
                total = lambda: statistics.read()["robots"][0]["total"]
                self.assertTrue(until(lambda: total()["requests"] == 1))
                before = total()["compute"]
                client.forward_dynamics(np.zeros(7))
                self.assertTrue(until(lambda: total()["requests"] == 2))
                after = total()["compute"]
            del statistics
            self.assertEqual((before.count, after.count, after.since(before).count), (1, 2, 1))


class Armature(support.Case):
    def test_armature(self):
        plain, heavy = support.load("arm7"), support.load("arm7", armature={"joint_1": 0.5})
        self.assertNotEqual(plain.hash, heavy.hash)
        mass = [tf.Workspace(m).mass_matrix(np.zeros(7)).M for m in (plain, heavy)]
        self.assertAlmostEqual((mass[1] - mass[0])[0, 0], 0.5)
        self.assertEqual([j.armature for j in heavy.joints][:2], [0.5, 0])
        for wrong in ({"joint_9": 1}, {1: 1}):
            with self.fails(tf.InputError, "armature: the file has no joint"):
                support.load("arm7", armature=wrong)
        with self.fails(tf.InputTypeError, "armature"):
            support.load("arm7", armature=[1])

    def test_damping_and_friction_by_joint(self):
        model = support.load("arm7", damping={"joint_2": 1.5}, friction={"joint_3": 4})
        file = support.load("arm7", damping=True, friction=True)
        for k, (got, wanted) in enumerate(zip(model.joints, file.joints)):
            self.assertEqual(got.damping, 1.5 if k == 1 else wanted.damping)
            self.assertEqual(got.friction, 4 if k == 2 else wanted.friction)
        forces = tf.Workspace(model).bias(np.zeros(7), np.full(7, 2.0))
        self.assertEqual(forces.damping[1], 3)
        with self.fails(tf.InputError, "damping: the file has no joint 'x'", field="damping"):
            support.load("arm7", damping={"x": 1})
        with self.fails(tf.InputError, "friction: -1 of joint 'joint_1'", field="friction"):
            support.load("arm7", friction={"joint_1": -1})

    def test_rotors(self):
        text = (support.ROBOTS / "arm7.urdf").read_text().replace(
            "</robot>", "<transmission><joint name='joint_1'/><actuator><mechanicalReduction>-100"
            "</mechanicalReduction></actuator></transmission></robot>")
        model = tf.Model.parse(text, rotors={"joint_1": 1e-4, "joint_2": 0.5},
                               armature={"joint_1": 2})
        self.assertEqual([j.armature for j in model.joints][:3], [3, 0.5, 0])
        self.assertIn("no-reduction", [m.code for m in model.messages])
        for rotors, code in (({"joint_9": 1}, "scene-rotor"), ({"joint_1": -1}, "scene-rotor")):
            with self.assertRaises(tf.LoadError) as raised:
                tf.Model.parse(text, rotors=rotors)
            self.assertIn(code, [m.code for m in raised.exception.messages])
        with self.fails(tf.InputTypeError, "rotors"):
            support.load("arm7", rotors=[1])

    def test_friction(self):
        text = (support.ROBOTS / "arm7.urdf").read_text()
        v = np.array([0.2, -0.3, 0, 1e-3, 5, -4, 0.01])
        plain = tf.Model.parse(text, damping=True)
        text = text.replace("<dynamics ", "<dynamics friction='2' ")
        model = tf.Model.parse(text, damping=True, friction=True, friction_velocity=0.1)
        self.assertEqual([(j.damping, j.friction) for j in model.joints],
                         [(j.damping, 2) for j in plain.joints])
        self.assertTrue(any(j.damping for j in plain.joints))
        want = 2 * v / np.sqrt(v**2 + 0.1**2)
        bias = tf.Workspace(model).bias(np.zeros(7), v)
        np.testing.assert_allclose(bias.friction, want, rtol=1e-14)
        tau = [tf.Workspace(m).inverse_dynamics(np.zeros(7), v).tau for m in (plain, model)]
        np.testing.assert_allclose(tau[1] - tau[0], want, rtol=0, atol=1e-13)
        with self.assertRaises(tf.LoadError):
            tf.Model.parse(text, friction=True, friction_velocity=-1)


if __name__ == "__main__":
    support.main()
