# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""totalforce web: the live page of a running daemon, and its metrics for Prometheus."""
import asyncio
import contextlib
import errno
import ipaddress
import os
import signal
import sys

from totalforce_tools.command import GOOD, Command, Failed, Option, Usage
from totalforce_tools.web_daemon import Daemon
from totalforce_tools.web_server import HEAD_BYTES, Server

NICE = 10  # a tenth of a processor that somebody else needs
BACKLOG = 64
REMEDIES = {"EADDRINUSE": "choose a free one, or 0: the system chooses",
            "EACCES": "ports below 1024 need root",
            "EADDRNOTAVAIL": "the address must be one of this machine"}


def listen(text, _):
    """(address, port), or None: no page"""
    if text == "none":
        return None
    host, colon, port = text.rpartition(":")
    if not colon or not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise ValueError(f"'{text}' is not ADDRESS:PORT with a port from 0 to 65535, nor none")
    try:
        return ipaddress.ip_address(host.removeprefix("[").removesuffix("]")), int(port)
    except ValueError:
        raise ValueError(f"'{host}' is not a numeric address, as 127.0.0.1 or [::1]") from None


COMMAND = Command("web", (
    "Serves a live page of a running daemon, read only and without a password: moving figures of "
    "its robots, ellipsoids of their operational-space inertia, rates, percentiles, clients; and "
    "/metrics for Prometheus. It waits for a daemon, and for the next one when it ends."), [
    Option("listen", "l", "ADDRESS:PORT",
           "Numeric address and port of the page, port 0: the system chooses; none: no page "
           "(127.0.0.1:8642)", listen, (ipaddress.ip_address("127.0.0.1"), 8642)),
    Option("allow-remote", None, None,
           "Allow an address that other machines reach: everybody there may read"),
    Option("metrics-socket", None, "FILE", "Serve /metrics on this Unix socket, too (mode 0660)"),
    Option("runtime-dir", None, "DIR",
           "Where the daemon's sockets are ($TOTALFORCE_RUNTIME_DIR, else /run/totalforce)",
           default=os.environ.get("TOTALFORCE_RUNTIME_DIR") or None)])


def check(o):
    if not o.listen and not o.metrics_socket:
        raise Usage("neither a page nor metrics: --listen none needs --metrics-socket")
    if o.listen and not o.listen[0].is_loopback and not o.allow_remote:
        raise Usage(f"--listen: {o.listen[0]} is not loopback, and the page has no password: "
                    "everybody who reaches it could read; 127.0.0.1, or --allow-remote")


def failed(what, error):
    name = errno.errorcode.get(error.errno, "")
    return Failed(f"{what}: {os.strerror(error.errno)}; {REMEDIES.get(name, 'choose another')}")


@contextlib.asynccontextmanager
async def open_sockets(o, server):
    """The port and the socket of metrics, which is removed at the end."""
    if o.listen:
        address, port = map(str, o.listen)
        try:
            opened = await asyncio.start_server(server.serve, address, port, limit=HEAD_BYTES,
                                                backlog=BACKLOG)
        except OSError as error:
            raise failed(f"--listen: {address} port {port}", error) from None
        host = f"[{address}]" if ":" in address else address
        print(f"live page http://{host}:{opened.sockets[0].getsockname()[1]}/, read only")
    if o.metrics_socket:
        mask = os.umask(0o117)
        try:
            await asyncio.start_unix_server(server.serve_metrics, o.metrics_socket,
                                            limit=HEAD_BYTES, backlog=BACKLOG)
        except OSError as error:
            raise failed(f"--metrics-socket: {o.metrics_socket}", error) from None
        os.umask(mask)
        print(f"metrics at {o.metrics_socket}")
    sys.stdout.flush()
    try:
        yield
    finally:
        if o.metrics_socket:
            with contextlib.suppress(OSError):
                os.unlink(o.metrics_socket)


async def serve(o):
    loop, end = asyncio.get_running_loop(), asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, end.set)
    daemon = Daemon(o.runtime_dir)
    server = Server(daemon, o.listen and o.listen[0])
    await daemon.open()
    async with open_sockets(o, server):
        tasks = [asyncio.create_task(daemon.run()), asyncio.create_task(server.sweep()),
                 asyncio.create_task(end.wait())]
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        if not end.is_set():
            tasks[0].result()


def main(argv):
    o = COMMAND.parse(argv)
    check(o)
    os.setpriority(os.PRIO_PROCESS, 0, max(NICE, os.getpriority(os.PRIO_PROCESS, 0)))
    asyncio.new_event_loop().run_until_complete(serve(o))
    sys.stdout.flush()
    os._exit(GOOD)  # a thread that loads a large robot does not delay the end
