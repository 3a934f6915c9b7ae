# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Sums, statistics and drawn states of a sweep: the same bits for any split and order."""
import fractions
import math
import random
import struct
import tempfile

import numpy as np

import support
import totalforce as tf
from totalforce_tools import sweep_resume
from totalforce_tools import sweep_statistics as statistics

Sweep = tf._totalforce._Sweep
VALUES, GROUP = 4096, statistics.GROUP


def value(rng, low, high):
    """Over a range of exponents, subnormal numbers and zero included"""
    return math.ldexp(rng.random(), rng.randrange(low, high))


def count(values, first=0):
    return statistics.words_of(Sweep.count(struct.pack(f"{len(values)}d", *values), first))


def mean_of(values, apart=GROUP):
    """Mean of values that stand `apart` states apart: each is alone in its group."""
    spread = [math.nan] * (apart * len(values))
    spread[::apart] = values
    return statistics.series_mean(statistics.series_of(count(spread), "answer"))


class Sums(support.Case):
    def test_exact(self):
        self.assertEqual(mean_of([2.0**1000, 1.0, 1.0, 1.0]), 2.0**998)
        self.assertEqual(mean_of([2.0**53, 1.0]), 2.0**52)  # a tie goes to even
        self.assertEqual(mean_of([2.0**53, 1.0, 5e-324, 0.0]), 2.0**51 + 0.5)  # no tie any more
        self.assertEqual(mean_of([5e-324] * 10), 5e-324)
        self.assertEqual(mean_of([0.0]), 0.0)
        self.assertEqual(mean_of([0.1] * 1000), 0.1)  # 1000 x (0.1 + 5.5e-18), rounded once
        self.assertEqual(mean_of([1.7e308] * 2), math.inf)

    def test_whole_range(self):
        rng = random.Random(1)
        values = [value(rng, -1074, 1024) for _ in range(VALUES // 4)]
        spread = [math.nan] * (GROUP * len(values))
        spread[::GROUP] = values
        series = statistics.series_of(count(spread), "answer")
        exact = sum(map(fractions.Fraction, values))
        self.assertEqual(fractions.Fraction(statistics.exact_sum(series), 1 << 1074), exact)

    def test_groups_are_sequential(self):
        rng = random.Random(4)
        values = [rng.random() for _ in range(3 * GROUP + 100)]
        groups = [np.cumsum(values[k : k + GROUP])[-1] for k in range(0, len(values), GROUP)]
        exact = sum(map(fractions.Fraction, groups))
        series = statistics.series_of(count(values), "answer")
        self.assertEqual(fractions.Fraction(statistics.exact_sum(series), 1 << 1074), exact)


class Statistics(support.Case):
    def test_no_order(self):
        rng = random.Random(2)
        values = [3.5 if k % 100 == 7 else math.nan if k % 97 == 5 else 3.5 + value(rng, -70, 70)
                  for k in range(VALUES)]
        values[11::700] = [2.0**80] * len(values[11::700])
        whole = count(values)
        order = [(5 * k + 3) % (VALUES // GROUP) * GROUP for k in range(VALUES // GROUP)]
        parts = [count(values[first : first + GROUP], first) for first in order]
        for split in (1, 3, 7):
            merged = statistics.merge([statistics.merge(parts[:split]),
                                       statistics.merge(parts[split:])])
            for name in statistics.SERIES:
                a, b = (statistics.series_of(words, name) for words in (whole, merged))
                self.assertEqual(statistics.exact_sum(a), statistics.exact_sum(b))
                outside = [*range(statistics.SUM), *range(statistics.BIN, statistics.LENGTH)]
                self.same_bits(a[outside].view(float), b[outside].view(float), name)
        answer = statistics.series_of(merged, "answer")
        self.assertEqual(statistics.number_at(answer, statistics.MIN), 3.5)
        self.assertEqual(answer[statistics.MIN_AT], values.index(3.5))
        self.assertEqual(answer[statistics.MAX_AT], 11)

    def test_counts_are_added(self):
        words = statistics.empty()
        words[: statistics.FIRST] = np.arange(statistics.FIRST)
        total = statistics.merge([words, words, statistics.empty()])
        self.assertTrue((total == 2 * words).all())

    def test_bins(self):
        values = [0.0, 2.0**-70, 1.0, 1.999, 2.0, 2.0**64, 2.0**1001, math.inf]
        s = statistics.series_of(count(values), "answer")
        self.assertEqual(s[0], 7)
        bins = s[statistics.BIN :]
        self.assertEqual([int(bins[k]) for k in (0, 65, 66, statistics.BINS - 1)], [2, 2, 1, 2])
        self.assertEqual([statistics.bin_bound(k) for k in (65, 66)], [1.0, 2.0])
        self.assertEqual(statistics.series_quantile(s, 0.5), 2.0)
        self.assertEqual(statistics.series_quantile(s, 1.0), 2.0**1001)

    def test_written_statistics_are_read_back(self):
        rng = random.Random(3)
        words = count([value(rng, -200, 200) for _ in range(GROUP)])
        with tempfile.NamedTemporaryFile() as file:
            out = sweep_resume.Out.__new__(sweep_resume.Out)
            out.file = file
            out.add(12, words)
            file.seek(0)
            line = file.read().rstrip(b"\n")
        block, found = sweep_resume.read_block(line)
        self.assertEqual(block, 12)
        self.assertTrue((found == words).all())
        self.assertIsNone(sweep_resume.read_block(line[:-1]))
        self.assertIsNone(sweep_resume.read_block(line.replace(b"block 12", b"block 13")))
        for text in (b"block 1 0:1 ffff:1", b"block 1 0:1 2", b"block 1 0:1x"):
            whole = text + b" #%016x" % Sweep.checksum(text)
            self.assertIsNone(sweep_resume.read_block(whole), text)
        good = b"block 1 0:1 2:1"
        self.assertIsNotNone(sweep_resume.read_block(good + b" #%016x" % Sweep.checksum(good)))


class Blocks(support.Case):
    def drawn(self, sweep, first, number):
        with tempfile.TemporaryFile() as file:
            none = (-1, "")
            sweep.block(0, first, number, none, none, (file.fileno(), "states"))
            return np.fromfile(file, float).reshape(-1, sweep.record)

    def sweep(self, seed, first):
        model = support.load("arm7", "floating")
        sweep = Sweep(model, "forward_dynamics", seed=seed, ranges=(2.0, 30.0, 4.0), first=first)
        sweep.open(1, (-1, ""))
        return sweep

    def test_states_are_drawn_alone(self):
        """A state is a function of seed and number, whatever is drawn with it."""
        every = self.drawn(self.sweep(9, 1000), 1000, 37)
        self.assertEqual(every.shape, (37, 7 + 6 + 6 + 3 * 7))
        for k, state in enumerate(every):
            self.same_bits(self.drawn(self.sweep(9, 1000 + k), 1000 + k, 1), state, k)
            self.assertFalse((self.drawn(self.sweep(10, 999 + k), 999 + k, 1) == state).any())
            self.assertLess(abs(state[3:7] @ state[3:7] - 1), 1e-15)
        for columns, bound in ((slice(0, 7), 1), (slice(7, 13), 2), (slice(13, 19), 30),
                               (slice(26, 33), 2), (slice(33, 40), 30)):
            self.assertTrue((abs(every[:, columns]) <= bound).all(), columns)
        low, high, _, _ = np.transpose(list(tf.joint_limits(support.ROBOTS / "arm7.urdf").values()))
        self.assertTrue((low <= every[:, 19:26]).all() and (every[:, 19:26] <= high).all())

    def test_faults(self):
        sweep = self.sweep(1, 0)
        none = (-1, "")
        with self.fails(tf.BusyError, "worker 1: is not open"):
            sweep.block(1, 0, 1, none, none, none)
        with self.fails(tf.InputError):
            sweep.open(1, none)
        with self.assertRaisesRegex(OSError, "nowhere: Bad file descriptor"):
            sweep.block(0, 0, 1, none, (999, "nowhere"), none)
        with tempfile.TemporaryFile() as file:
            with self.assertRaisesRegex(OSError, "short: state 3: the file has become shorter"):
                sweep.block(0, 3, 1, (file.fileno(), "short"), none, none)
        with self.fails(tf.InputError, "tips: no link 'toool'"):
            Sweep(sweep_model(), "operational_inertia", tips=("toool",))
        with self.fails(tf.UnsupportedError, "op: sweeps do not compute kinematics"):
            Sweep(sweep_model(), "kinematics")


def sweep_model():
    return support.load("arm7")


if __name__ == "__main__":
    support.main()
