# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What a sweep computes: rank 0 reads the robot, all ranks build the same model of it."""
import os
import stat

import totalforce as tf
from totalforce import _totalforce
from totalforce_tools import scene
from totalforce_tools.command import Failed
from totalforce_tools.sweep_options import BLOCKS_MAX, ESTIMATES, RESIDUALS


class Plan:
    """The options `o` with their robot; `identity` is all that decides the answers, in one line."""

    def __init__(self, o, ranks):
        self.o = o
        ranks.together(check_build, ranks)
        model = ranks.together(lambda: scene.load(o.arguments[0], o) if ranks.rank == 0 else None)
        self.model = ranks.together(ranks.broadcast, model)
        ranks.together(self.complete)

    def complete(self):
        o = self.o
        self.kernel = find_kernel(o, self.model)
        self.work = make_work(o, self.model, self.kernel)
        self.states, self.count = open_states(o, self.work)
        self.blocks = -(-self.count // o.block)
        if self.blocks > BLOCKS_MAX:
            raise Failed(f"{o.states}: more than 2^30 blocks: take a larger --block")
        self.identity = self.describe()

    def describe(self):
        o = self.o
        ranges = _totalforce._Sweep.checksum(b"".join(self.work.ranges))
        source = f"states={o.states}" if o.states else f"seed={o.seed} ranges={ranges:016x}"
        return (
            f"version={tf.__version__} isa={tf.isa()} model={self.model.tag} "
            f"kernel={self.kernel.info.digest.hex()[:16] if self.kernel else ''} op={o.op} "
            f"method={o.method} precision={o.precision} "
            f"residual={RESIDUALS.split('|').index(o.residual)} "
            f"estimate={ESTIMATES.split('|').index(o.estimate)} "
            f"refine={'default' if o.refine is None else o.refine} tips={o.tips or ''} {source} "
            f"offset={o.offset} count={self.count} block={o.block} reference={o.reference} "
            f"out={o.out or ''} out-states={o.out_states or ''}")

    def span(self, block):
        """First state and number of states of a block: all but the last have --block."""
        start = block * self.o.block
        return self.o.offset + start, min(self.o.block, self.count - start)


def check_build(ranks):
    """What must be the same on every rank, or the answers had other bits"""
    first_version, first_kernels = ranks.broadcast((tf.__version__, tf.isa()))
    if tf.__version__ != first_version:
        raise Failed(f"rank {ranks.rank} is version {tf.__version__}, rank 0 {first_version}: "
                     "install one version")
    if tf.isa() != first_kernels:
        raise Failed(f"rank {ranks.rank} has the kernels {tf.isa()}, rank 0 {first_kernels}: set "
                     "TFA_ISA to one that all machines have")


def find_kernel(o, model):
    try:
        return scene.find_kernel(o.kernels, model) if o.kernels is not None else None
    except tf.Error as error:
        raise Failed(f"--kernels: {error}") from None


def make_work(o, model, kernel):
    tips = tuple(o.tips.split(",")) if o.tips is not None else ()
    try:
        return _totalforce._Sweep(
            model, o.op, method=o.method, precision=o.precision, residual=o.residual,
            estimate=o.estimate, tips=tips, ranges=(o.velocity, o.torque, o.acceleration),
            seed=o.seed, reference=o.reference, first=o.offset, specialised=kernel,
            **({} if o.refine is None else {"refine": o.refine}))
    except tf.Error as error:
        raise Failed(f"--{error}" if error.field == "tips" else f"{o.arguments[0]}: {error}"
                     ) from None


def open_states(o, work):
    """The file of --states as (descriptor, path), and the number of states"""
    if not o.states:
        return (-1, ""), o.count
    file = os.open(o.states, os.O_RDONLY)
    facts = os.fstat(file)
    if not stat.S_ISREG(facts.st_mode):
        raise Failed(f"{o.states}: no regular file: records are read at their offsets")
    found, rest = divmod(facts.st_size, 8 * work.record)
    if rest:
        raise Failed(f"{o.states}: {facts.st_size} bytes are no whole number of records of "
                     f"{work.record} doubles, which {o.op} of this robot reads")
    if o.offset >= found or o.count > found - o.offset:
        raise Failed(f"{o.states}: has {found} states; --offset {o.offset} --count {o.count} asks "
                     "for more")
    return (file, o.states), o.count or found - o.offset
