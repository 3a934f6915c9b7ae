# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce web`: requests that it refuses, connections that hold it up, metrics, models that
change, workers that do not notice, daemons that end, and its own end.

    http_server.py BIN ROBOTS
"""
import concurrent.futures
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

from totalforce_tools import command, web

from http_daemon import WAIT, Client, Daemon, ask, connect, exchange, wait_for

BIN, ROBOTS = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
ARM = ("arm", ROBOTS / "arm7.urdf", "")
EVIL = '<img src=x onerror="window.hit=1">\\'


def check(good, *what):
    if not good:
        raise AssertionError(" ".join(map(str, what)))


# ---- the command line ----

def refused(code, text, *options):
    done = subprocess.run([BIN / "totalforce", "web", "--runtime-dir", "/nowhere", *options],
                          capture_output=True, text=True, check=False, timeout=WAIT)
    check(done.returncode == code and text in done.stderr, options, done)


def wrong(text, address):
    """A value of --listen that is a usage error"""
    try:
        web.check(web.COMMAND.parse(["--listen", address]))
        raise AssertionError(f"{address} is taken")
    except command.Usage as error:
        check(text in str(error), address, error)


def check_options(folder):
    wrong("--listen: 0.0.0.0 is not loopback", "0.0.0.0:0")
    wrong("127.0.0.1, or --allow-remote", "0.0.0.0:0")
    wrong("not loopback", "[::]:0")
    wrong("'example.org' is not a numeric address", "example.org:80")
    wrong("'127.0.0.1:65536' is not ADDRESS:PORT", "127.0.0.1:65536")
    refused(3, "--listen none needs --metrics-socket", "--listen", "none")
    refused(2, "choose another", "--metrics-socket", str(folder / "none" / "m.sock"), "--listen",
            "none")
    with Daemon(BIN, folder, [ARM], "", ("--listen", "0.0.0.0:0", "--allow-remote")) as daemon:
        check(daemon.get("/", host="192.0.2.7")[0] == 200, "a number is refused")
        check(daemon.get("/", host="robot.example")[0] == 421, "a name is taken")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        refused(2, f"127.0.0.1 port {port}: Address already in use; choose a free one", "--listen",
                f"127.0.0.1:{port}")


# ---- requests ----

def check_hosts(daemon):
    port = daemon.port
    for host in ("localhost", f"localhost:{port}", "LOCALHOST", f"127.0.0.1:{port}", "127.0.0.2",
                 f"[::1]:{port}"):
        check(daemon.get("/motion", host=host)[0] == 200, host)
    for host in ("evil.example", f"evil.example:{port}", "localhost.evil.example", "192.0.2.1",
                 "localhost:x", "[::1", "", "127.0.0.1.evil.example", "a" * 300, "localhost\0",
                 "localhost\0.evil.example", "127.0.0.1\0"):
        code, _, body = daemon.get("/motion", host=host)
        check(code in (400, 421) and "positions" not in body, host, code)
    for name in ("evil.example", "localhost"):
        code, _, body = daemon.get("/motion", host="localhost", headers=f"Host: {name}\r\n")
        check(code in (400, 421) and "positions" not in body, "two hosts", name, code)
    code, _, body = daemon.get("/motion", host=None)
    check(code in (400, 421) and "positions" not in body, "no host", code)


def check_methods(daemon):
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "BREW"):
        code, headers, _ = daemon.get("/state", method=method,
                                      headers="Content-Length: 5\r\n", body=b"hello")
        check(code == 405 and headers["allow"] == "GET, HEAD", method, code)
    code, _, body = daemon.get("/state", headers="Content-Length: 5\r\n", body=b"hello")
    check(code == 413 and "uptime" not in body, "GET with a body:", code)
    code, headers, body = daemon.get("/state", method="HEAD")
    check(code == 200 and int(headers["content-length"]) > 100 and not body, "HEAD", code, body)


def check_headers(daemon):
    for path in ("/", "/state", "/metrics", "/absent"):
        _, headers, body = daemon.get(path, headers="Origin: http://evil.example\r\n")
        check(not any(name.startswith("access-control") for name in headers), path, headers)
        check("default-src 'none'" in headers["content-security-policy"], path, headers)
        check(headers["x-content-type-options"] == "nosniff", path, headers)
        check(headers["cache-control"] == "no-store", path, headers)
        if path == "/":
            nonce = re.search("script-src 'nonce-([0-9a-f]{32})'", headers["content-security-policy"])
            check(nonce and body.count(f'nonce="{nonce[1]}"') == 2 and "@" + "NONCE" not in body, "nonce")
    first, second = daemon.get("/")[2], daemon.get("/")[2]
    check(first != second, "the nonce is the same twice")
    for path in ("/absent", "/..", "/state/", "/state?robot=nobody", "/etc/passwd", "//", "/metrics%00",
                 "/state%00", "/state?robot=arm%00", "/state?robot=%00"):
        check(daemon.get(path)[0] == 404, path)


def check_malformed(daemon):
    address = ("127.0.0.1", daemon.port)
    big = [b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"y" * 10**6 + b"\r\n\r\n",
           b"GET /" + b"a" * 10**6 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n",
           b"GET / HTTP/1.1\r\nHost: localhost\r\n" + b"A: b\r\n" * 10**5 + b"\r\n"]
    small = [b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 200, b"\r\n" * 3 + b"x" * 100 + b"\r\n\r\n",
             b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\0" * 4000]
    with concurrent.futures.ThreadPoolExecutor(8) as pool: # some are closed when they are silent
        answers = pool.map(lambda data: (data, exchange(address, data)), big + small)
    for data, answer in answers:
        check(not answer.startswith(b"HTTP/1.1 200"), data[:40], answer[:60])
    with connect(address) as s: # two requests at once, then a third
        for _ in range(2):
            s.sendall(b"GET /motion HTTP/1.1\r\nHost: localhost\r\n\r\n" * 2)
        answer = b""
        while answer.count(b"HTTP/1.1 200 ") < 4:
            part = s.recv(65536)
            check(part, "the connection was closed", answer[-200:])
            answer += part
    check(daemon.get("/state")[0] == 200, "nothing is answered any more")


def check_names(daemon):
    model = daemon.json("/model?robot=evil")
    check(EVIL in "".join(model["frames"]), model["frames"])
    check("<img" not in daemon.get("/model?robot=evil")[2] and "<img" not in daemon.get("/")[2], "raw")


def check_ellipsoids(daemon):
    """Values are ordered; vectors are unit eigenvectors of the block."""
    for tip in daemon.json("/motion?robot=arm")["tips"]:
        block, values, vectors = tip["lambda_inv"], tip["values"], tip["vectors"]
        check(values == sorted(values, reverse=True), values)
        for k in range(3):
            v = vectors[3 * k:3 * k + 3]
            turned = [sum(block[3 * i + j] * v[j] for j in range(3)) for i in range(3)]
            check(max(abs(turned[i] - values[k] * v[i]) for i in range(3)) < 1e-4 * values[0] and
                  abs(sum(x * x for x in v) - 1) < 1e-4, tip)


# ---- connections ----

def check_silence(daemon):
    """More silent and slow connections than there is room for: others are answered, and they are
    closed."""
    address = ("127.0.0.1", daemon.port)
    quiet = [connect(address) for _ in range(60)]
    for s in quiet[::2]:
        s.sendall(b"GET /state HTTP/1.1\r\n")
    end = time.monotonic() + WAIT
    while any(is_open(s) for s in quiet):
        check(time.monotonic() < end, "silent connections stay")
        check(daemon.get("/motion")[0] == 200, "not answered")
        for s in quiet[::2]: # a byte now and then is no progress
            try:
                s.sendall(b"X")
            except OSError:
                pass
        time.sleep(0.2)
    for s in quiet:
        s.close()


def is_open(s):
    s.setblocking(False)
    try:
        return s.recv(65536) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False


def check_crowd(daemon):
    """A thousand connections at once."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    before = len(os.listdir(f"/proc/{daemon.web.pid}/fd"))
    many = []
    most = 0
    for i in range(1000):
        many.append(connect(("127.0.0.1", daemon.port)))
        if i % 100 == 99:
            check(daemon.get("/motion")[0] == 200, "not answered")
            most = max(most, len(os.listdir(f"/proc/{daemon.web.pid}/fd")))
    check(most <= before + 48, most - before, "connections at once")
    for s in many:
        s.close()
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    print(f"1000 connections: {most - before} open at once")


# ---- metrics ----

def parse_metrics(text):
    """{(name, labels): value}; every sample stands under HELP and TYPE of its family"""
    found, family, kind = {}, None, None
    for line in text.splitlines():
        if line.startswith("# HELP "):
            family, kind = line.split()[2], None
        elif line.startswith("# TYPE "):
            check(line.split()[2] == family, line)
            kind = line.split()[3]
        else:
            match = re.fullmatch(r'(\w+)(\{(?:\w+="(?:[^"\\\n]|\\.)*",?)*\})? (\S+)', line)
            check(match and kind and match[1].startswith(family), line)
            labels = tuple(sorted(re.findall(r'(\w+)="((?:[^"\\\n]|\\.)*)"', match[2] or "")))
            check((match[1], labels) not in found, "twice:", line)
            found[match[1], labels] = float(match[3])
    return found


def check_buckets(metrics):
    """Buckets are cumulative, and the last is the count."""
    series = {}
    for (name, labels), value in metrics.items():
        if name.endswith("_bucket"):
            le = float(dict(labels)["le"])
            rest = tuple(label for label in labels if label[0] != "le")
            series.setdefault((name[:-7], rest), []).append((le, value))
    check(series, "no histograms")
    for (name, rest), buckets in series.items():
        values = [value for _, value in sorted(buckets)]
        check(values == sorted(values), name, rest, values)
        check(max(buckets)[0] == float("inf") and values[-1] == metrics[name + "_count", rest], name)


def check_metrics(daemon):
    address = daemon.metrics
    wait_for(lambda: daemon.json("/state?robot=arm")["requests"] == 200 and
             daemon.json("/state?robot=arm")["second"] > 1, "requests are missing")
    code, headers, text = ask(address, "/metrics")
    check(code == 200 and headers["content-type"].startswith("text/plain; version=0.0.4"), headers)
    metrics = parse_metrics(text)
    check_buckets(metrics)
    check(metrics["totalforce_requests_total", (("robot", "arm"),)] == 200, "requests")
    check(parse_metrics(daemon.get("/metrics")[2]).keys() == metrics.keys(), "another text over TCP")
    check(ask(address, "/metrics", host="prometheus.example")[0] == 200, "a name at the Unix socket")
    for path in ("/", "/state"):
        check(ask(address, path)[0] == 404, path, "at the Unix socket")
    check(os.stat(address).st_mode & 0o777 == 0o660, "mode")


def ask_some(daemon, count):
    line = json.dumps({"op": "forward_dynamics", "q": [0.1] * 7, "v": [0] * 7, "tau": [0] * 7})
    answers = daemon.tool("call", "arm", "--timeout-ms", str(1000 * WAIT),
                          input=f"{line}\n" * count).splitlines()
    check(len(answers) == count and all("qdd" in json.loads(text) for text in answers), answers[-1:])


# ---- beside the workers ----

def stat(process):
    """Fields of /proc/PID/stat from the third on, by proc(5)"""
    return pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(") ")[2].split()


def check_process(daemon):
    """nice 10, the ordinary scheduler, and no shared memory that it could write"""
    fields = stat(daemon.web)
    check(int(fields[16]) == 10 and int(fields[38]) == 0, "nice", fields[16], "policy", fields[38])
    maps = pathlib.Path(f"/proc/{daemon.web.pid}/maps").read_text().splitlines()
    shared = [line for line in maps if line.split()[1].endswith("s")]
    check(shared and not any("w" in line.split()[1] for line in shared), shared)


class Visitor:
    """`with Visitor(..)`: asks as the page does."""

    def __init__(self, daemon):
        self.daemon, self.stop, self.failures, self.visits = daemon, threading.Event(), [], 0
        self.thread = threading.Thread(target=self._visit)

    def _visit(self):
        while not self.stop.is_set():
            for path in ("/motion", "/state"):
                code = self.daemon.get(path)[0]
                if code != 200:
                    self.failures.append((path, code))
                self.visits += 1
            self.stop.wait(0.05)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        self.thread.join()


def check_worker(daemon):
    """A daemon whose page is visited answers every request."""
    with Visitor(daemon) as visitor:
        ask_some(daemon, 2000)
        wait_for(lambda: visitor.visits >= 20, "the server is not visited")
        ask_some(daemon, 2000)
    check(not visitor.failures, visitor.failures)


# ---- models, directories, the end ----

def check_reload(daemon, urdf):
    before = daemon.json("/model?robot=evil")
    text = urdf.read_text().replace("mass value=\"", "mass value=\"1")
    urdf.write_text(text)
    daemon.tool("reload")
    wait_for(lambda: daemon.json("/model?robot=evil")["model"] != before["model"], "no other model")
    motion = daemon.json("/motion?robot=evil")
    wait_for(lambda: daemon.json("/state?robot=evil")["model"] == motion["model"], "models differ")
    check("values" in motion["tips"][0], motion)


def check_directory(daemon):
    """Whoever removes the daemon's runtime directory takes nothing from the page."""
    shutil.rmtree(daemon.runtime_dir)
    wait_for(lambda: os.path.exists(os.path.join(daemon.runtime_dir, ".control.sock")), "no socket")
    check(daemon.get("/motion")[0] == 200 and ask(daemon.metrics, "/metrics")[0] == 200, "gone")


def drawn(daemon):
    """A figure of the daemon that is running"""
    code, _, text = daemon.get("/state")
    return code == 200 and json.loads(text)["process"] == daemon.process.pid and \
        "positions" in json.loads(text)["motion"]


def check_other_daemon(daemon):
    """Nothing is shown of a daemon that ended or was killed; the next one is found."""
    wait_for(lambda: drawn(daemon), "no figure")
    for number in (signal.SIGTERM, signal.SIGKILL):
        daemon.end_daemon(number)
        wait_for(lambda: daemon.get("/state")[0] == 503, "the daemon is still shown")
        check({daemon.get(path)[0] for path in ("/motion", "/model", "/metrics")} == {503}, number)
        check(daemon.get("/")[0] == 200, "no page")
        daemon.start_daemon()
        wait_for(lambda: drawn(daemon), "no figure")


def check_other_model(daemon):
    """No figure of a model that is not the daemon's: its file was changed, and not loaded again."""
    daemon.end_web()
    daemon.end_daemon()
    daemon.start_daemon()
    urdf = daemon.evil
    text = urdf.read_text()
    urdf.write_text(text.replace("mass value=\"", "mass value=\"2"))
    daemon.start_web()
    error = lambda: daemon.json("/motion?robot=evil").get("error", "")
    wait_for(lambda: "the daemon serves model" in error(), "another model is drawn")
    check(daemon.json("/model?robot=evil")["frames"] == [], "frames of another model")
    check("positions" in daemon.json("/motion?robot=arm"), "no figure of the other robot")
    daemon.tool("reload")
    wait_for(lambda: not error(), "no figure of the model that was loaded")


def check_end(daemon):
    """Open connections, and one that never reads its answer, do not delay the end."""
    many = [connect(("127.0.0.1", daemon.port)) for _ in range(30)]
    many[0].sendall(b"GET /state HTTP/1.1\r\nHost: localhost\r\n\r\n" * 200)
    process = daemon.web
    daemon.end_web(signal.SIGINT)
    check(process.returncode == 0, process.returncode)
    check(not os.path.exists(daemon.metrics), "the socket stays")
    check("arm" in daemon.tool("status"), "the daemon ended, too")
    for s in many:
        s.close()


def check_kill(daemon):
    daemon.start_web()
    daemon.end_web(signal.SIGKILL)
    check(os.path.exists(daemon.metrics), "it was not killed")
    daemon.start_web()
    check(ask(daemon.metrics, "/metrics")[0] == 200, "the socket of a killed process is in the way")


def check_other_user(folder):
    """Another user, who may open the sockets: the page is whole, and nothing can be ordered."""
    if os.geteuid() != 0:
        return
    nobody, own = 65534, folder / "of_nobody"
    own.mkdir()
    os.chown(own, nobody, nobody)
    folder.chmod(0o711)
    daemon = Daemon(BIN, folder, [ARM], "group: nogroup\n")
    daemon.metrics = str(own / ".metrics.sock")
    daemon.user = {"user": nobody, "group": nobody, "extra_groups": []}
    with daemon:
        check(os.stat(f"/proc/{daemon.web.pid}").st_uid == nobody, "of another user")
        check("tips" in daemon.json("/motion") and "totalforce_" in ask(daemon.metrics, "/metrics")[2],
              "no figures")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_options(folder)
        check_other_user(folder)
        evil = folder / "evil.urdf"
        chain = subprocess.run([BIN / "totalforce", "chain", "rank-deficient", "--bodies", "5"],
                               check=True, capture_output=True, text=True).stdout
        name = EVIL.replace("<", "&lt;").replace('"', "&quot;")
        evil.write_text(chain.replace('"link', f'"{name}link'))
        with Daemon(BIN, folder, [ARM, ("evil", evil, "")]) as daemon:
            daemon.evil = evil
            for step in (check_hosts, check_methods, check_headers, check_malformed, check_names,
                         check_ellipsoids):
                step(daemon)
            ask_some(daemon, 200)
            check_metrics(daemon)
            check_process(daemon)
            with Client(daemon, "arm", 7):
                check_silence(daemon)
                check_crowd(daemon)
            check_worker(daemon)
            check_reload(daemon, evil)
            check_directory(daemon)
            check_other_daemon(daemon)
            check_other_model(daemon)
            check_end(daemon)
            check_kill(daemon)


main()
