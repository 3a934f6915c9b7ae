# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Threads take blocks until none is left. A thread has a block to itself - states, dynamics,
statistics, without Python's lock - so that nothing but the list of blocks is shared."""
import os
import signal
import sys
import threading
import time

import numpy as np

import totalforce as tf
from totalforce_tools import sweep_resume, sweep_statistics
from totalforce_tools.command import Failed
from totalforce_tools.sweep_options import THREADS_MAX
from totalforce_tools.sweep_ranks import tell

MERGED = 256  # statistics of blocks that are merged together


class Results:
    """Of a run; on rank 0 after `merge` those of all ranks"""

    def __init__(self, plan):
        self.done = np.zeros(plan.blocks, bool)
        self.statistics = sweep_statistics.empty()
        self.found = self.finished = self.states = 0  # blocks of resume files, of this run; states
        # processors that this process may use: mpirun and srun give each rank its own
        self.threads = plan.o.threads or min(len(os.sched_getaffinity(0)), THREADS_MAX)
        self.elapsed, self.seconds = 0.0, np.zeros(5)
        self.interrupted = False

    def missing(self):
        return len(self.done) - self.found - self.finished

    def merge(self, ranks):
        """Sums over the ranks, on rank 0"""
        all_ranks = ranks.gather((self.finished, self.states, self.threads, self.interrupted,
                                  self.seconds, self.done, self.statistics))
        if ranks.rank == 0:
            columns = list(zip(*all_ranks))
            self.finished, self.states, self.threads = (sum(column) for column in columns[:3])
            self.interrupted, self.seconds = any(columns[3]), sum(columns[4])
            self.done = np.logical_or.reduce(columns[5])
            self.statistics = sweep_statistics.merge(columns[6])


class Job:
    def __init__(self, plan, ranks, results):
        self.plan, self.ranks, self.results = plan, ranks, results
        self.ended = threading.Condition()  # what is below belongs to its holder
        self.blocks = self.mine()
        self.unmerged, self.running, self.failed = [], 0, False

    def mine(self):
        """Blocks go to the parts in turn, and those of a part that are not done to its ranks."""
        part, parts = self.plan.o.part or (1, 1)
        todo = np.flatnonzero(~self.results.done[part - 1 :: parts])
        return iter(todo[self.ranks.rank :: self.ranks.size] * parts + part - 1)

    def open(self):
        """All ranks together, whatever one of them meets"""
        self.ranks.together(self.open_workers)
        o, work = self.plan.o, self.plan.work
        self.out = self.open_file(o.out, work.answer)
        self.out_states = self.open_file(o.out_states, work.record)

    def open_workers(self):
        o = self.plan.o
        try:
            self.plan.work.open(self.results.threads, self.plan.states)
        except tf.Error as error:
            raise Failed(f"{o.arguments[0]}: {error}") from None
        number = (o.part[0] - 1 if o.part else 0) * self.ranks.size + self.ranks.rank
        self.resume = sweep_resume.Out(self.plan, number) if o.resume is not None else None

    def open_file(self, path, width):
        """A file that all ranks write at offsets, as (descriptor, path). Rank 0 makes it; contents
        within its size stay."""
        if path is None:
            return -1, ""
        size = self.plan.count * width * 8

        def make():
            file = os.open(path, os.O_WRONLY | os.O_CREAT, 0o666)
            try:
                os.ftruncate(file, size)
            except OSError as error:
                raise Failed(f"{path}: {error.strerror}") from None
            return file

        first = self.ranks.together(lambda: make() if self.ranks.rank == 0 else None)
        return self.ranks.together(lambda: make() if first is None else first), path

    def take(self):
        """The next block, or None"""
        with self.ended:
            if self.results.interrupted or self.failed:
                return None
            return next(self.blocks, None)

    def finish(self, block, data):
        """Its answers are written already: a block in the resume file is complete."""
        words = sweep_statistics.words_of(data)
        with self.ended:
            if self.resume:
                self.resume.add(block, words)
            self.unmerged.append(words)
            if len(self.unmerged) == MERGED:
                self.merge()
            self.results.done[block] = True
            self.results.finished += 1
            self.results.states += int(words[0])

    def merge(self):
        self.results.statistics = sweep_statistics.merge(
            [self.results.statistics, *self.unmerged])
        self.unmerged = []

    def fail(self, text):
        with self.ended:
            if not self.failed:
                tell(text)
            self.failed = True

    def work(self, k):
        work, files = self.plan.work, (self.plan.states, self.out, self.out_states)
        try:
            while (block := self.take()) is not None:
                try:
                    data = work.block(k, *self.plan.span(int(block)), *files)
                except OSError as error:
                    self.fail(f"block {block}: {error}")
                else:
                    self.finish(int(block), data)
        except Failed as error:
            self.fail(error)
        finally:
            with self.ended:
                self.running -= 1
                self.ended.notify()

    def print_progress(self, elapsed, before, after):
        """Rank 0 speaks; the others go as fast."""
        r, o, size = self.results, self.plan.o, self.ranks.size
        if self.ranks.rank == 0 and not o.quiet:
            total = self.plan.blocks // o.part[1] + 1 if o.part else self.plan.blocks
            done = min(r.found + r.finished * size, total)
            print(f"{before}{100 * done / total:5.1f} %, {r.states * size / elapsed:.3g} states/s",
                  end=after, file=sys.stderr, flush=True)

    def watch(self):
        """Waits for the threads; says each second how far they are on a terminal, each ten seconds
        elsewhere."""
        start = told = time.monotonic()
        terminal = sys.stderr.isatty()
        with self.ended:
            while self.running:
                if (not self.ended.wait(1.0)
                        and time.monotonic() - told >= (0.9 if terminal else 9.9)):
                    told = time.monotonic()
                    before, after = ("\r", "") if terminal else ("", "\n")
                    self.print_progress(told - start, before, after)
        self.results.elapsed = time.monotonic() - start
        if terminal and told > start:
            self.print_progress(self.results.elapsed, "\r", "\n")

    def start(self):
        """As many threads as the system gives"""
        threads = []
        for k in range(self.results.threads):
            thread = threading.Thread(target=self.work, args=(k,))
            with self.ended:
                self.running += 1
            try:
                thread.start()
            except RuntimeError as error:
                with self.ended:
                    self.running -= 1
                if not threads:
                    self.fail(f"no thread could be started: {error}")
                break
            threads.append(thread)
        return threads

    def run(self):
        def interrupt(number, _):  # the second signal ends the program
            self.results.interrupted = True
            signal.signal(number, signal.SIG_DFL)

        signal.signal(signal.SIGINT, interrupt)
        signal.signal(signal.SIGTERM, interrupt)
        threads = self.start()
        self.watch()
        for thread in threads:
            thread.join()
        self.merge()
        self.results.seconds = np.array(self.plan.work.seconds)


def run(plan, ranks):
    """Computes what is not finished yet. Results, and whether nothing failed"""
    results = Results(plan)
    # rank 0 knows the finished blocks; their statistics stay with it
    if plan.o.resume is not None:
        found = ranks.together(lambda: sweep_resume.read(plan, results.done)
                               if ranks.rank == 0 else results.statistics)
        results.statistics = found
        results.done = ranks.broadcast(results.done)
        results.found = int(results.done.sum())
    good = True
    if not plan.o.merge:
        job = Job(plan, ranks, results)
        job.open()
        job.run()
        good = not job.failed
    good = ranks.agree(good)
    results.merge(ranks)
    return results, good
