# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What the page shows of a running daemon: its statistics, the last minute second by second,
figures of its robots. Nothing is shown of a daemon that has ended; the next one is found."""
import asyncio
import collections
import time

import totalforce as tf
from totalforce_tools.web_robot import load_figure

PERIOD = 0.05  # copies of the statistics and figures are at most so old, s
SECONDS = 60  # of history
ALIVE = 3  # workers that sleep make progress every second
OPEN = 0.3  # a daemon that hangs delays nothing for longer, s
WAIT = 1.0  # a request waits so long for a model that is being loaded, s
RETRY = 2  # a model that could not be had is asked for again, s
TIMES = ("queue", "compute", "total")
QUANTILES = (0.5, 0.99, 0.999)


class Gone(Exception):
    """No daemon answers: the reason."""


def microseconds(now, before):
    """Median, 99 % and 99.9 % of the times of one second; None: nothing was asked."""
    times = now.since(before)
    return [1e-3 * times.quantile(q) if times.count else None for q in QUANTILES]


def second_of(now, before, seconds):
    """A row of the history: requests, states, rejected, fallbacks in a second, then times, us."""
    counts = ("requests", "states", "rejected", "fallbacks")
    row = [(now[name] - before[name]) / seconds for name in counts]
    return row + [us for name in TIMES for us in microseconds(now[name], before[name])]


def client_key(client):
    return tuple(client[name] for name in ("kind", "robot", "worker", "since", "slot"))


class Daemon:
    def __init__(self, runtime_dir):
        self.runtime_dir = runtime_dir
        self.reason = "no daemon was found yet"
        self._forget()

    def _forget(self):
        self.statistics = self.now = self.before = None
        self.history, self.rates, self.figures, self.seconds = [], {}, {}, 0

    # Statistics

    async def open(self):
        """Looks for a daemon."""
        try:
            statistics = await asyncio.to_thread(tf.Statistics, self.runtime_dir, timeout=OPEN)
            now = await asyncio.to_thread(statistics.read)
        except tf.Error as error:
            self.reason = str(error)
            return
        self._forget()
        self.statistics, self.now, self.before = statistics, now, now
        self.read = self.alive = time.monotonic()
        self.history = [collections.deque(maxlen=SECONDS) for _ in now["robots"]]

    def update(self):
        """Reads the statistics unless that was done less than a period ago. A snapshot that failed
        is read again later."""
        clock = time.monotonic()
        if not self.statistics or clock - self.read < PERIOD:
            return
        try:
            now = self.statistics.read(timeout=PERIOD / 10)
        except tf.BusyError:
            now = self.now
        else:
            self.read = clock
            if now["heartbeat"] != self.now["heartbeat"]:
                self.alive = clock
            self.now = now
        if now["stopped"] or clock - self.alive > ALIVE:
            self._forget()
            self.reason = "the daemon ended" if now["stopped"] else "the daemon does not move"

    def snapshot(self):
        self.update()
        if not self.now:
            raise Gone(self.reason)
        return self.now

    def tick(self):
        """Ends a second."""
        self.update()
        seconds = 1e-9 * (self.now["time"] - self.before["time"]) if self.now else 0
        if seconds <= 0:
            return
        for rows, now, before in zip(self.history, self.now["robots"], self.before["robots"]):
            rows.append(second_of(now["total"], before["total"], seconds))
        earlier = {client_key(c): c["tally"]["requests"] for c in self.before["clients"]}
        self.rates = {client_key(c): (c["tally"]["requests"] - earlier.get(client_key(c), 0))
                      / seconds for c in self.now["clients"]}
        self.seconds += 1
        self.before = self.now

    async def run(self):
        """Every second, for ever."""
        due = time.monotonic()
        while True:
            if self.statistics:
                self.tick()
            if not self.statistics:
                await self.open()
            due = max(due + 1, time.monotonic())
            await asyncio.sleep(due - time.monotonic())

    # Robots

    def robot(self, name):
        """Number of a robot, the first where none is named; KeyError: there is none."""
        names = [r["name"] for r in self.snapshot()["robots"]]
        if name is not None and name not in names:
            raise KeyError(name)
        return names.index(name) if name is not None else 0

    def _load(self, robot):
        name, served = robot["name"], robot["model_hash"]
        directory = self.runtime_dir or self.now["runtime_dir"]
        task = asyncio.create_task(asyncio.to_thread(load_figure, name, served, directory))
        entry = {"hash": served, "task": task, "since": time.monotonic()}
        self.figures[name] = entry
        return entry

    async def figure(self, index):
        """(figure, None) of a robot, or (None, why there is none)."""
        robot = self.snapshot()["robots"][index]
        entry = self.figures.get(robot["name"])
        failed = entry and entry["task"].done() and entry["task"].exception()
        late = failed and time.monotonic() - entry["since"] > RETRY
        if not entry or late or entry["hash"] != robot["model_hash"]:
            entry = self._load(robot)
        done, _ = await asyncio.wait([entry["task"]], timeout=WAIT)
        if not done:
            return None, "the model is being loaded"
        error = entry["task"].exception()
        return (None, str(error)) if error else (entry["task"].result(), None)
