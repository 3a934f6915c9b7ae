# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A totalforced, its `totalforce web`, and a client that moves its robot, for tests in Python."""
import json
import math
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import guard
from wait import WAIT, until


class Daemon:
    """`with Daemon(..)`: runtime_dir, process, and port, metrics, web (a process) of its page;
    `text` is configuration, `options` are those of totalforce web."""

    def __init__(self, bin_dir, folder, robots, text="", options=()):
        self.bin, self.folder = str(bin_dir), str(folder)
        self.runtime_dir = os.path.join(self.folder, "run")
        self.config = os.path.join(self.folder, "c.yaml")
        self.process = self.web = self.port = None
        self.log = os.path.join(self.folder, "log")
        self.metrics = os.path.join(self.folder, ".metrics.sock")
        self.options, self.user = options, {}
        lines = "".join(f"  - {{name: {name}, urdf: '{urdf}'{more}}}\n" for name, urdf, more in robots)
        with open(self.config, "w", encoding="utf-8") as out:
            out.write(f"runtime_dir: {self.runtime_dir}\nmax_state_us: 0\n{text}robots:\n{lines}")

    def start_daemon(self):
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = guard.start([os.path.join(self.bin, "totalforced"), self.config],
                                       stderr=log)
        wait_for(lambda: "ready:" in self.messages() or self.process.poll() is not None,
                 "the daemon does not start")
        if self.process.poll() is not None:
            raise AssertionError(self.messages())

    def start_web(self, port=0):
        log = os.path.join(self.folder, "web.log")
        with open(log, "w", encoding="utf-8") as out:
            self.web = guard.start(
                [os.path.join(self.bin, "totalforce"), "web", "--runtime-dir", self.runtime_dir,
                 "--listen", f"127.0.0.1:{port}", "--metrics-socket", self.metrics, *self.options],
                stdout=out, stderr=subprocess.STDOUT, **self.user)
        text = lambda: pathlib.Path(log).read_text(encoding="utf-8")
        wait_for(lambda: "metrics at" in text() or self.web.poll() is not None, "no page")
        found = re.search(r"live page http://\S+:(\d+)/, read only", text())
        if not found:
            raise AssertionError(text())
        self.port = int(found[1])

    def messages(self):
        with open(self.log, encoding="utf-8") as log:
            return log.read()

    def end_daemon(self, number=signal.SIGTERM):
        if self.process:
            guard.end(self.process, number)
        self.process = None

    def end_web(self, number=signal.SIGTERM):
        if self.web:
            guard.end(self.web, number)
        self.web = None

    def __enter__(self):
        self.start_daemon()
        self.start_web()
        return self

    def __exit__(self, *_):
        self.end_web()
        self.end_daemon()

    def tool(self, *arguments, **options):
        return subprocess.run([os.path.join(self.bin, "totalforce"), *arguments, "--runtime-dir",
                               self.runtime_dir], check=True, capture_output=True, text=True,
                              timeout=WAIT, **options).stdout

    def get(self, path, **options):
        """(status, headers, body) of a GET"""
        return ask(("127.0.0.1", self.port), path, **options)

    def json(self, path):
        code, _, body = self.get(path)
        if code != 200:
            raise AssertionError(f"{path}: {code} {body}")
        return json.loads(body)


class Client:
    """`with Client(..)`: a process that asks for forward dynamics, at other joint positions each time."""

    def __init__(self, daemon, robot, joints):
        self.process = guard.start(
            [os.path.join(daemon.bin, "totalforce"), "call", robot, "--runtime-dir",
             daemon.runtime_dir, "--timeout-ms", str(1000 * WAIT)], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        self.joints, self.running = joints, True
        self.thread = threading.Thread(target=self._move)
        self.thread.start()

    def _move(self):
        begin = time.monotonic()
        while self.running:
            t = time.monotonic() - begin
            q = [0.8 * math.sin(2 * t + 0.7 * k) for k in range(self.joints)]
            self.process.stdin.write(json.dumps({"op": "forward_dynamics", "q": q,
                                                 "v": [0] * self.joints,
                                                 "tau": [0] * self.joints}) + "\n")
            self.process.stdin.flush()
            time.sleep(0.01)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.running = False
        self.thread.join()
        self.process.stdin.close()
        self.process.wait(WAIT)
        self.process.guard.communicate()


def wait_for(condition, text):
    if not until(condition):
        raise AssertionError(text)


def connect(address):
    family = socket.AF_UNIX if isinstance(address, str) else socket.AF_INET
    s = socket.socket(family, socket.SOCK_STREAM)
    s.settimeout(WAIT)
    s.connect(address)
    return s


def exchange(address, data):
    """All that comes back for these bytes until the server ends, or has sent the reply's length"""
    with connect(address) as s:
        answer = b""
        try:
            s.sendall(data)
            while True:
                part = s.recv(65536)
                answer += part
                if not part or complete(answer, data.startswith(b"HEAD")):
                    return answer
        except (ConnectionResetError, BrokenPipeError):
            return answer


def complete(answer, head):
    top, found, body = answer.partition(b"\r\n\r\n")
    length = re.search(rb"(?i)content-length: (\d+)", top)
    return found and (head or (length and len(body) >= int(length[1])))


def ask(address, path, method="GET", host="localhost", headers="", body=b""):
    name = f"Host: {host}\r\n" if host is not None else ""
    data = f"{method} {path} HTTP/1.1\r\n{name}{headers}\r\n".encode() + body
    answer = exchange(address, data)
    top, _, text = answer.partition(b"\r\n\r\n")
    lines = top.decode("latin-1").split("\r\n")
    found = {name.lower(): value for name, _, value in (line.partition(": ") for line in lines[1:])}
    return int(lines[0].split()[1]) if answer else None, found, text.decode()
