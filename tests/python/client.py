# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A real daemon: replies under way, batches, deadlines, its end and its return, the fallback."""
import contextlib
import json
import os
import threading
import time

import numpy as np

import support
import totalforce as tf
from support import WAIT, Case, daemon, load, state, waiting


class Clients(Case):
    def test_send_and_receive(self):
        with daemon([("arm", "arm7", "fixed")]) as (folder, process):
            with tf.Client("arm", runtime_dir=folder, slots=4, max_batch=8, max_tips=2,
                           connect_timeout=WAIT) as client:
                self.assertEqual(client.daemon_pid, process.pid)
                self.assertEqual((client.slots, client.max_batch, client.max_tips), (4, 8, 2))
                workspace = tf.Workspace(load("arm7"))
                fields = state(workspace.model, np.random.default_rng(1), 8)
                ids = [client.send("forward_dynamics", **fields),
                       client.send("mass_matrix", fields["q"][0]),
                       client.send("forward_dynamics", fields["q"][0], [float("nan")] * 7)]
                self.assertEqual(client.outstanding, 3)
                with self.fails(tf.InputError):  # receive the replies first
                    client.mass_matrix(fields["q"][0])
                first, second = client.receive(timeout=WAIT), client.receive()
                with self.fails(tf.InputError, "v[0] (joint_1): nan", field="v"):
                    client.receive()
                self.assertEqual([first.exchange.id, second.exchange.id], ids[:2])
                self.same_bits(first.qdd, workspace.forward_dynamics(**fields).qdd, "qdd")
                self.same_bits(second.M, workspace.mass_matrix(fields["q"][0]).M, "M")
                with self.fails(tf.InputError, "no request of send() is outstanding"):
                    client.receive()
                e = client.mass_matrix(fields["q"][0], timeout=WAIT).exchange
                self.assertTrue(e.t_sent <= e.t_received <= e.t_start <= e.t_done <= e.t_reply)
                self.assertEqual(e.daemon, "OK")
                for _ in range(4):
                    client.send("mass_matrix", fields["q"][0])
                with self.fails(tf.BusyError, "", status="E_AGAIN"):
                    client.send("mass_matrix", fields["q"][0])
                client.close()
                client.close()
                with self.fails(tf.InputError, "the client is closed"):
                    client.hash

    def test_limits_and_options(self):
        with daemon([("arm", "arm7", "fixed")]) as (folder, _):
            os.environ["TOTALFORCE_RUNTIME_DIR"] = folder
            with tf.Client("arm", wait="block", connect_timeout=WAIT) as client:
                self.assertEqual(client.wait, "block")
                with self.fails(tf.InputError, "", status="E_SIZE"):
                    client.mass_matrix(np.zeros((2, 7)))
                for bad in (0, -1, float("nan")):
                    with self.fails(tf.InputError, "timeout", field="timeout"):
                        client.mass_matrix(np.zeros(7), timeout=bad)
                with self.fails(tf.InputTypeError, field="timeout"):
                    client.mass_matrix(np.zeros(7), timeout="x")
            del os.environ["TOTALFORCE_RUNTIME_DIR"]
            for options, kind, text in (
                (dict(robot="leg"), tf.InputError, "leg"),
                (dict(slots=3), tf.InputError, ""),
                (dict(wait="x"), tf.InputError, "wait"),
                (dict(deadline=-1), tf.InputError, "deadline"),
                (dict(connect_timeout=-1), tf.InputError, "connect_timeout"),
                (dict(runtime_dir=folder + "/none"), tf.DisconnectedError, "no daemon listens at"),
            ):
                with self.subTest(**options), self.fails(kind, text):
                    tf.Client(**{"robot": "arm", "runtime_dir": folder, "connect_timeout": WAIT,
                                 **options})
            for wrong in ({}, {"robot": 3}, {"robot": "arm", "unknown": 1}):
                with self.assertRaises(TypeError):
                    tf.Client(**wrong)
            status = json.loads(tf.daemon_command("status", runtime_dir=folder))
            self.assertIn("arm", json.dumps(status))
            self.assertIn("ok", tf.daemon_command("reload", runtime_dir=folder))
            with self.fails(tf.RefusedError):
                tf.daemon_command("dance", runtime_dir=folder)
            with self.fails(tf.DisconnectedError):
                tf.daemon_command("status", runtime_dir=folder + "/none")

    def test_end_return_and_fallback(self):
        model = load("arm7")
        q = np.full(7, 0.3)
        wanted = tf.Workspace(model).mass_matrix(q).M
        with daemon([("arm", "arm7", "fixed")]) as (folder, process):
            client = tf.Client("arm", runtime_dir=folder, connect_timeout=WAIT)
            other = tf.Client("arm", runtime_dir=folder, connect_timeout=WAIT)
            with self.fails(tf.LoadError, "hash", status="E_MODEL"):
                other.set_fallback(load("arm6"))
            with self.fails(tf.InputTypeError):
                other.set_fallback(3)
            other.set_fallback(model)
            client.send("mass_matrix", q)
            client.receive()
            self.assertIn("ok", tf.daemon_command("stop", runtime_dir=folder))
            process.wait(WAIT)
            with self.fails(tf.DisconnectedError, "", status="E_DISCONNECTED"):
                client.mass_matrix(q)
            reply = other.mass_matrix(q, timeout=WAIT)
            self.same_bits(reply.M, wanted, "M of the fallback")
            self.assertEqual(reply.exchange.daemon, "E_DISCONNECTED")
            other.set_fallback(None)
            with self.fails(tf.DisconnectedError):
                other.mass_matrix(q)
            with daemon([("arm", "arm7", "fixed")]) as (second, _):
                standby = tf.Client("arm", runtime_dir=folder, standby_dir=second,
                                    connect_timeout=WAIT)
                self.same_bits(standby.mass_matrix(q).M, wanted, "M of the standby")
                standby.close()
            client.close()
            other.close()

    def test_two_threads_and_the_gil(self):
        with daemon([("human", "humanoid", "fixed")], "    max_batch: 2048\n") as (folder, _):
            client = tf.Client("human", runtime_dir=folder, max_batch=2048, connect_timeout=WAIT)
            fields = state(load("humanoid"), np.random.default_rng(1), 2048)
            busy, done = [], threading.Event()

            def other():
                while not done.is_set():
                    try:
                        client.mass_matrix(fields["q"][0])
                    except tf.BusyError as error:
                        busy.append(error.status)
                    time.sleep(0.0005)

            thread = threading.Thread(target=other)
            thread.start()
            served = 0
            for _ in waiting():
                try:
                    client.forward_dynamics(**fields)
                    served += 1
                except tf.BusyError:
                    time.sleep(0.001)
                if served and busy:
                    break
            done.set()
            thread.join()
            self.assertGreater(served, 0)
            self.assertTrue(busy, "the second thread was never refused")

    def test_fork(self):
        with daemon([("arm", "arm7", "fixed")]) as (folder, _):
            done = support.python(
                """
import os, sys
import numpy as np, totalforce as tf
client = tf.Client('arm', runtime_dir=sys.argv[3], connect_timeout=300)
client.mass_matrix(np.zeros(7))
child = os.fork()
if child == 0:
    try:
        client.mass_matrix(np.zeros(7))
    except tf.UnsupportedError as error:
        print(error)
    client.close()
    with tf.Client('arm', runtime_dir=sys.argv[3], connect_timeout=300) as own:
        own.mass_matrix(np.zeros(7))
    sys.exit(0)
print(os.waitpid(child, 0)[1])
for _ in range(100):
    client.mass_matrix(np.zeros(7), timeout=300)
kept = client
""",
                folder,
            )
            self.assertEqual(done.stderr, "")
            self.assertEqual(done.stdout,
                             "the client was made before a fork: make one in this " "process\n0\n")

    def test_no_leak(self):
        with daemon([("arm", "arm7", "fixed")]) as (folder, _):
            q = np.zeros(7)
            with tf.Client("arm", runtime_dir=folder, connect_timeout=WAIT) as client:

                def repeat(n):
                    for _ in range(n):
                        client.mass_matrix(q)
                        client.send("mass_matrix", q)
                        client.receive().exchange

                repeat(500)
                memory = support.resident_kib()
                repeat(20000)
                self.assertLess(support.resident_kib() - memory, 2048)

            def connect(n):
                for _ in range(n):
                    for _ in waiting():  # places of clients that left are free when that is served
                        with contextlib.suppress(tf.RefusedError):
                            tf.Client("arm", runtime_dir=folder, connect_timeout=WAIT).close()
                            break

            connect(10)
            memory = support.resident_kib()
            connect(100)
            self.assertLess(support.resident_kib() - memory, 2048)


if __name__ == "__main__":
    support.main()
