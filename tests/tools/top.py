# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce list` and `totalforce top`: as text and JSON, and live in a pseudo-terminal: keys,
another size, the end of the daemon, the terminal as it was before.

    with_domain top.py BIN_DIR SOURCE_DIR
"""
import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time

BIN, SOURCE = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
sys.path.insert(0, os.path.join(SOURCE, "tests/support"))
import guard
from wait import WAIT, waiting

TOOL, DAEMON = os.path.join(BIN, "totalforce"), os.path.join(BIN, "totalforced")
OWN_SCREEN = b"\x1b[?25h\x1b[?1049l"


def check(good, *what):
    if not good:
        raise AssertionError(" ".join(map(str, what)))


def eventually(test, *arguments):
    """What the test returns as soon as it passes"""
    for _ in waiting():
        try:
            return test(*arguments)
        except AssertionError as error:
            failed = error
    raise failed


class Daemon:
    """totalforced with an arm, and other keys of the configuration."""

    def __init__(self, folder, keys=""):
        self.folder, self.process = folder, None
        self.runtime_dir = os.path.join(folder, "run")
        self.config = os.path.join(folder, "arm.yaml")
        with open(self.config, "w", encoding="utf-8") as out:
            out.write(f"{keys}runtime_dir: {self.runtime_dir}\nmax_state_us: 0\nrobots:\n  - name: arm\n"
                      f"    urdf: {SOURCE}/config/robots/arm7.urdf\n")

    def start(self):
        self.process = guard.start([DAEMON, self.config], stderr=subprocess.DEVNULL)
        eventually(tool, self, "status")

    def end(self, number):
        if self.process:
            guard.end(self.process, number)
        self.process = None


def tool(daemon, *arguments, check_status=True):
    done = subprocess.run([TOOL, *arguments, "--runtime-dir", daemon.runtime_dir],
                          capture_output=True, text=True, timeout=WAIT, check=False)
    if check_status:
        check(done.returncode == 0, arguments, done.returncode, done.stderr)
    return done


class Load:
    """A client that asks about 500 times a second; each tenth request is refused."""

    def __init__(self, daemon):
        self.process = guard.start(
            [TOOL, "call", "arm", "--runtime-dir", daemon.runtime_dir, "--timeout-ms",
             str(1000 * WAIT)], stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True)
        self.stop = False
        self.thread = threading.Thread(target=self.ask)
        self.thread.start()

    def ask(self):
        good = '{"op":"forward_dynamics","q":[0,0.1,0,0.2,0,0,0]}\n'
        bad = '{"op":"operational_inertia","q":[0,0,0,0,0,0,0],"tips":["tool0"],"method":"rnea"}\n'
        try:
            while not self.stop:
                self.process.stdin.write(9 * good + bad)
                self.process.stdin.flush()
                time.sleep(0.02)
        except BrokenPipeError:
            pass

    def end(self):
        self.stop = True
        self.thread.join()
        try:
            self.process.stdin.close()
        except BrokenPipeError:
            pass
        self.process.wait(WAIT)
        guard.end(self.process)


class Terminal:
    """`totalforce top` in a pseudo-terminal."""

    def __init__(self, daemon, rows, columns):
        self.master, self.slave = pty.openpty()
        self.before = termios.tcgetattr(self.slave)
        self.resize(rows, columns)
        self.seen = b""
        self.process = subprocess.Popen(
            [TOOL, "top", "--interval", "0.2", "--runtime-dir", daemon.runtime_dir],
            stdin=self.slave, stdout=self.slave, stderr=subprocess.PIPE, start_new_session=True)
        self.process.guard = guard.guard(self.process.pid)

    def resize(self, rows, columns):
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def read(self, seconds):
        if select.select([self.master], [], [], seconds)[0]:
            self.seen += os.read(self.master, 65536)

    def wait(self, condition, what):
        """Until the output since the last call fulfils it."""
        end = time.monotonic() + WAIT
        while not condition(self.seen):
            check(time.monotonic() < end and self.process.poll() is None, "no", what, "in",
                  self.seen[-3000:])
            self.read(0.1)
        found, self.seen = self.seen, b""
        return found

    def wait_for(self, pattern):
        return self.wait(lambda seen: re.search(pattern, seen), pattern)

    def key(self, key):
        os.write(self.master, key)

    def assert_ended(self):
        end = time.monotonic() + WAIT
        while self.process.poll() is None:
            check(time.monotonic() < end, "top does not end")
            self.read(0.05)
        while select.select([self.master], [], [], 0.1)[0]:
            self.read(0)
        self.process.guard.communicate()
        check(self.process.returncode == 0, "status", self.process.returncode)
        check(self.seen.endswith(OWN_SCREEN), "the screen stays:", self.seen[-200:])
        check(termios.tcgetattr(self.slave) == self.before, "the terminal is not as before")
        os.close(self.master)
        os.close(self.slave)


def frames(output):
    """Lines of each whole page of an output."""
    pages = output.split(b"\x1b[H")[1:-1]
    return [re.sub(rb"\x1b\[[0-9?]*[A-Za-z]|\r", b"", page).split(b"\n") for page in pages]


def await_clients(daemon, count):
    """Connections come and go when they are served."""
    def look():
        served = json.loads(tool(daemon, "list", "--json").stdout)
        check(served["robots"][0]["clients"] == count, served)
    eventually(look)


def test_list(daemon):
    await_clients(daemon, 1)
    text = tool(daemon, "list").stdout
    check("arm: 7 joints, 7 freedoms, model " in text and "run/arm.sock, 1 clients" in text, text)
    # by whichever path it was found, it says where it is
    served = json.loads(subprocess.run(
        [TOOL, "list", "--json", "--runtime-dir", daemon.runtime_dir + "/."], check=True,
        stdout=subprocess.PIPE, timeout=WAIT).stdout)
    arm = served["robots"][0]
    check(served["process"] == daemon.process.pid, served)
    check(arm["name"] == "arm" and arm["joints"] == 7 and len(arm["model"]) == 64, arm)
    check(arm["socket"] == daemon.runtime_dir + "/arm.sock" and arm["clients"] == 1, arm)
    check(arm["specialised"] is None and arm["precision"] == "f64" and arm["isa"], arm)


def busy_interval(daemon):
    """One with requests, after a refusal"""
    now = json.loads(tool(daemon, "top", "--once", "--json", "--interval", "0.1").stdout)
    arm = now["robots"][0]
    check(arm["interval"]["queue_us"]["count"] > 0 and arm["totals"]["rejected"] > 0, arm)
    return now


def test_once(daemon):
    """One interval: rates, methods and refusals of a client that asks all the time."""
    now = eventually(busy_interval, daemon)
    arm = now["robots"][0]
    check(arm["interval"]["requests_per_s"] > 0, arm)
    check(set(arm["interval"]["methods"]) == {"aba"}, arm)
    check(arm["totals"]["not_ok"].get("E_METHOD", 0) == arm["totals"]["rejected"] > 0, arm)
    check(sum(arm["totals"]["methods"].values()) + arm["totals"]["rejected"] ==
          arm["totals"]["requests"], arm)
    check(now["clients"][0]["by"] == "shm" and now["clients"][0]["totals"]["requests"] > 0, now)
    part = arm["interval"]["total_us"]
    check(0 < part["p50"] <= part["p99"] <= part["max"], part)
    text = tool(daemon, "top", "--interval", "0.1").stdout  # no terminal: one table
    check("\x1b" not in text and text.count("REQUESTS/S") == 2 and "E_METHOD" in text, text)


def test_keys(daemon):
    for key in (b"q", b"\x03"):
        terminal = Terminal(daemon, 24, 80)
        terminal.wait_for(rb"\x1b\[\?1049h[^$]*REQUESTS/S[^$]*aba [0-9]")
        terminal.key(b"x")  # no key of ours
        terminal.wait_for(rb"REQUESTS/S")
        terminal.key(key)
        terminal.assert_ended()


def test_sizes(daemon):
    terminal = Terminal(daemon, 24, 80)
    terminal.wait_for(rb"REQUESTS/S")
    terminal.resize(7, 33)
    terminal.process.send_signal(signal.SIGWINCH)  # it is not the terminal's own session
    fits = lambda page: len(page) <= 7 and max(map(len, page)) <= 33
    # pages of the size before may still be under way; behind the first that fits all do
    terminal.wait(lambda seen: any(map(fits, frames(seen))), "page that fits")
    pages = frames(terminal.wait(lambda seen: len(frames(seen)) >= 2, "two pages"))
    check(all(map(fits, pages)), pages)
    terminal.process.send_signal(signal.SIGTERM)
    terminal.assert_ended()


def test_daemon_that_ends(daemon):
    terminal = Terminal(daemon, 40, 120)
    terminal.wait_for(b"process %d" % daemon.process.pid)
    for number in (signal.SIGKILL, signal.SIGTERM):
        daemon.end(number)
        terminal.wait_for(rb"the daemon ended; waiting for one")
        daemon.start()
        terminal.wait_for(rb"connected again")
        terminal.wait_for(b"process %d" % daemon.process.pid)
    terminal.key(b"q")
    terminal.assert_ended()
    daemon.end(signal.SIGTERM)
    for command in (["top", "--once"], ["list"], ["status"], ["reload"], ["stop"]):
        done = tool(daemon, *command, check_status=False)
        check(done.returncode == 2 and f"no daemon answers at {daemon.runtime_dir}:" in done.stderr,
              done)


def check_clients(daemon, count):
    """`top` and `list` agree on the connections of other processes."""
    shown = json.loads(tool(daemon, "top", "--once", "--json", "--interval", "0.1").stdout)
    served = json.loads(tool(daemon, "list", "--json").stdout)
    check(shown["robots"][0]["clients"] == served["robots"][0]["clients"] == count, shown, served)
    lines = tool(daemon, "top", "--once", "--interval", "0.1").stdout.splitlines()
    check([line for line in lines if line.split()[:2] == ["arm", str(count)]], lines)
    rows = [line.split()[:2] for line in lines[lines.index("", 2) + 1:]]
    check(["gateway", "dds"] in rows and [str(daemon.process.pid), "dds"] not in rows, lines)
    check(max(map(len, lines[:lines.index("")])) <= 80, "too wide:", lines)


def test_gateways():
    """A gateway of the daemon is named as such, and is no client."""
    with tempfile.TemporaryDirectory(prefix="tfa-top-") as folder:
        daemon = Daemon(folder, f"dds: {{enabled: yes, domain: {os.environ['TEST_DOMAIN']}}}\n")
        try:
            daemon.start()
            check_clients(daemon, 0)
            load = Load(daemon)
            try:
                await_clients(daemon, 1)
                check_clients(daemon, 1)
            finally:
                load.end()
        finally:
            daemon.end(signal.SIGKILL)


def main():
    with tempfile.TemporaryDirectory(prefix="tfa-top-") as folder:
        daemon = Daemon(folder)
        try:
            daemon.start()
            load = Load(daemon)
            try:
                test_list(daemon)
                test_once(daemon)
                test_keys(daemon)
                test_sizes(daemon)
            finally:
                load.end()
            test_daemon_that_ends(daemon)
        finally:
            daemon.end(signal.SIGKILL)
    test_gateways()


main()
