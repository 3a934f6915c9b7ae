# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Requests and replies of HTTP/1.1: GET and HEAD without a body, by number or localhost.

A connection is closed that completes nothing for a while, whatever it sends or does not read, and
the one that is silent for longest makes room for a new one.
"""
import asyncio
import http.server
import io
import ipaddress
import re
import time
import urllib.parse

from totalforce_tools import web_metrics, web_state
from totalforce_tools.web_daemon import Gone

CONNECTIONS = 48  # at once
IDLE = 5  # a connection without a complete request or reply is closed, s
HEAD_BYTES = 16384  # of a request's line and headers
TEXT = "text/plain; charset=utf-8"
PATHS = {"/state": web_state.state, "/motion": web_state.motion, "/model": web_state.model}


def is_ours(host, address):
    """Whether this value of the Host header may be served. Pages of other names that point here may
    not read us (DNS rebinding): a name can be made to point here by anybody, a number cannot."""
    found = re.fullmatch(r"(?:\[([^]]*)\]|([^:\[]*))(?::[0-9]{0,5})?", host or "")
    name = (found[1] or found[2] or "") if found else ""
    try:
        number = ipaddress.ip_address(name)
    except ValueError:
        return name.lower() == "localhost"
    return number.is_loopback or address.is_unspecified or number == address


class Request(http.server.BaseHTTPRequestHandler):
    """The standard library's parser, for bytes that were received."""

    protocol_version = "HTTP/1.1"

    def __init__(self, head):
        self.rfile, self.refused, self.headers = io.BytesIO(head), None, {}
        self.raw_requestline = self.rfile.readline()
        if self.parse_request() and not self.request_version.startswith("HTTP/1."):
            self.send_error(505)

    def send_error(self, code, message=None, explain=None):
        self.refused = (int(code), f"{message or self.responses[code][0]}\n")

    def handle_expect_100(self):
        return True

    def fault(self, address):
        """(code, text) of a request that is not answered, else None; address None: any host."""
        hosts = self.headers.get_all("Host", []) if not self.refused else []
        if self.refused:
            return self.refused
        if self.command not in ("GET", "HEAD"):
            return 405, "read only: GET and HEAD\n"
        if address and (len(hosts) != 1 or not is_ours(hosts[0], address)):
            return 421, "this server is called localhost, or by its number\n"
        if self.headers.get("Content-Length", "0") != "0" or "Transfer-Encoding" in self.headers:
            return 413, "requests have no body here\n"
        return None


async def answer_robot(daemon, path, query):
    name = urllib.parse.parse_qs(query, errors="replace").get("robot", [None])[0]
    try:
        value = await PATHS[path](daemon, daemon.robot(name))
    except (KeyError, IndexError):
        return 404, TEXT, "no robot of this name is served here\n", ""
    return 200, "application/json", web_state.json_text(value), ""


async def answer(daemon, target, metrics_only):
    """(code, type, text, nonce) of the reply to GET target"""
    path, _, query = target.partition("?")
    try:
        if path == "/metrics":
            return 200, web_metrics.CONTENT_TYPE, web_metrics.text(daemon.snapshot()), ""
        if metrics_only:
            return 404, TEXT, "here is /metrics only\n", ""
        if path == "/":
            return 200, "text/html; charset=utf-8", *web_state.page(daemon)
        if path in PATHS:
            return await answer_robot(daemon, path, query)
    except Gone as reason:
        return 503, TEXT, f"{reason}\n", ""
    return 404, TEXT, "here are /, /state, /motion, /model and /metrics\n", ""


def reply_bytes(code, kind, text, nonce, close, head_only=False):
    """A page may use its own script and style, its own JSON, nothing else."""
    policy = "default-src 'none'; frame-ancestors 'none'" + (
        f"; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src 'self'; "
        "img-src data:; base-uri 'none'; form-action 'none'" if nonce else "")
    body = text.encode(errors="replace")
    lines = [f"HTTP/1.1 {code} {http.server.BaseHTTPRequestHandler.responses[code][0]}",
             f"Content-Length: {len(body)}", f"Content-Type: {kind}",
             f"Content-Security-Policy: {policy}", "X-Content-Type-Options: nosniff",
             "Referrer-Policy: no-referrer", "Cross-Origin-Resource-Policy: same-origin",
             "Cache-Control: no-store"]
    lines += ["Allow: GET, HEAD"] * (code == 405) + ["Connection: close"] * close
    return "\r\n".join([*lines, "", ""]).encode() + (b"" if head_only else body)


class Server:
    """Connections to a port, whose Host must be ours, and to a socket of metrics."""

    def __init__(self, daemon, address):
        self.daemon, self.address, self.since = daemon, address, {}

    async def serve(self, reader, writer, metrics_only=False):
        while len(self.since) >= CONNECTIONS:
            self._end(min(self.since, key=self.since.get))
        self.since[writer] = time.monotonic()
        writer.transport.set_write_buffer_limits(0)  # drained is what the system has taken
        try:
            while await self._turn(reader, writer, metrics_only):
                self.since[writer] = time.monotonic()
                await asyncio.sleep(0)  # others come between requests that were sent at once
            writer.write_eof()  # what a refused request still sends is not read, nor is it an error
            while await reader.read(HEAD_BYTES):
                pass
        except (OSError, EOFError):
            pass
        finally:
            self._end(writer)

    async def _turn(self, reader, writer, metrics_only):
        """One request. @return whether another may follow"""
        try:
            request = Request(await reader.readuntil(b"\r\n\r\n"))
            fault = request.fault(None if metrics_only else self.address)
            close = bool(fault) or request.close_connection or request.request_version == "HTTP/1.0"
        except asyncio.LimitOverrunError:
            request, fault, close = None, (431, "a request of more than 16 KiB\n"), True
        if fault:
            made = fault[0], TEXT, fault[1], ""
        else:
            made = await answer(self.daemon, request.requestline.split()[1], metrics_only)
        writer.write(reply_bytes(*made, close, bool(request) and request.command == "HEAD"))
        await writer.drain()
        return not close

    async def serve_metrics(self, reader, writer):
        await self.serve(reader, writer, metrics_only=True)

    def _end(self, writer):
        self.since.pop(writer, None)
        writer.transport.abort()

    async def sweep(self):
        while True:
            await asyncio.sleep(0.5)
            for writer, since in list(self.since.items()):
                if time.monotonic() - since > IDLE:
                    self._end(writer)
