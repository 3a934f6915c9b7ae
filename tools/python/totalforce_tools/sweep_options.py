# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The command line of `totalforce sweep`."""
import totalforce as tf
from totalforce_tools import scene
from totalforce_tools.cases import METHODS
from totalforce_tools.command import Command, Group, Option, Usage, positive, whole, word
from totalforce_tools.sweep_statistics import GROUP

# 2^16 states of an arm are 5 ms of a core: a block costs nothing to hand out, and its line in the
# resume file is short beside its work.
BLOCK, BLOCK_MAX, BLOCKS_MAX = 65536, 1 << 24, 1 << 30
THREADS_MAX, PARTS_MAX, U64_MAX = 256, 100000, (1 << 64) - 1

OPS = tf.OPS[: tf.OPS.index("mass_matrix") + 1]
RESIDUALS, ESTIMATES = "same|f64|f128", "default|never|always"  # in the order of their numbers


def read_part(text, _):
    part, slash, parts = text.partition("/")
    if not slash:
        raise ValueError(f"'{text}' is not I/N, such as 1/8")
    parts = whole(1, PARTS_MAX)(parts, None)
    return whole(1, parts)(part, None), parts


def read_block(text, _):
    block = whole(GROUP, BLOCK_MAX)(text, None)
    if block % GROUP:
        raise ValueError(f"{text} is not a multiple of {GROUP}")
    return block


LINE = Command("sweep", (
    "Computes one operation of a robot for many states, and their statistics. The states are drawn "
    "from a seed or read from a file. Statistics and answers have the same bits for any number of "
    "threads, parts and ranks."
), [
    Group("What is computed:"),
    Option("op", None, "OP", "Operation (forward_dynamics)", word(OPS), OPS[0]),
    Option("method", "m", "METHOD", "Method (auto)", word(tuple(METHODS)), "auto"),
    Option("precision", None, "f64|f128|f32", "Arithmetic of the factors (f64)",
           word(("f64", "f128", "f32")), "f64"),
    scene.choice("residual", RESIDUALS, "Arithmetic of refinement (same)", default="same"),
    scene.choice("estimate", ESTIMATES, "Error estimates (default: where the sentinel trips)",
                 default="default"),
    Option("refine", None, "0|1|2|3", "Refinement steps (default)", whole(0, tf.MAX_REFINE)),
    Option("tips", None, "LINK,...", "Links of operational_inertia, in this order"),
    Option("kernels", None, "FOLDER", "The robot's kernel that `totalforce specialise` put there"),
    Group("States:"),
    Option("count", "n", "N", "How many (of a file: all)", whole(1, U64_MAX), 0),
    Option("seed", "s", "N", "Of the drawn states (1)", whole(0, U64_MAX), 1),
    Option("offset", None, "N", "Number of the first state (0)", whole(0, U64_MAX), 0),
    Option("states", None, "FILE",
           "Read them from this file of little-endian doubles, see docs/sweep.md"),
    Option("velocity", None, "X", "Drawn velocities are within -X..X (1)", positive(), 1.0),
    Option("torque", None, "X", "Drawn torques and forces are within -X..X (1)", positive(), 1.0),
    Option("acceleration", None, "X",
           "Drawn accelerations of inverse_dynamics are within -X..X (1)", positive(), 1.0),
    Group("Work:"),
    Option("threads", "t", "N", "Of each rank (one for each processor that it may use)",
           whole(1, THREADS_MAX)),
    Option("block", None, "N", "States of a block, a multiple of 512 (65536)", read_block, BLOCK),
    Option("resume", None, "FILE",
           "Keep finished blocks in FILE.0, FILE.1, ..., and compute the others only"),
    Option("part", None, "I/N", "Only the blocks of part I of N; needs --resume", read_part),
    Option("merge", None, None, "Compute nothing: the statistics of the blocks of --resume"),
    Group("Results:"),
    Option("out", None, "FILE", "Write the answers there, little-endian doubles"),
    Option("out-states", None, "FILE", "Write the states there"),
    Option("reference", None, "N", "Compare every N-th state with quadruple precision",
           whole(1, U64_MAX), 0),
    Option("expect-error", None, "X", "Exit status 1 if a state fails, or an error (without "
           "--reference: an estimate) is above X", positive()),
    Option("json", None, None, "JSON in place of a table"),
    Option("quiet", None, None, "No progress and no rate on standard error"),
    *scene.OPTIONS,
], (
    "Operations: forward_dynamics, inverse_dynamics, operational_inertia, mass_matrix.\n\n"
    "On several machines: `mpirun -n 8 totalforce sweep ...`, or srun; without MPI --part I/N "
    "--resume FILE on each, then the same command with --merge.\n\n"
    "Statistics are printed on standard output; progress and rate on standard error. Exit status "
    "1: --expect-error does not hold, or blocks are missing."
), "FILE.urdf", {"METHOD": tuple(METHODS), "OP": OPS})


def check_states(o):
    if not o.arguments:
        raise Usage("which URDF file?")
    if not o.count and not o.states:
        raise Usage("how many states? --count N")
    if max(o.count, o.offset) > U64_MAX // 4:
        raise Usage("--count and --offset: at most 2^62 states")
    if o.count // o.block >= BLOCKS_MAX:
        raise Usage(f"--count: more than 2^30 blocks of {o.block} states: --block {BLOCK_MAX}")


def parse(argv):
    o = LINE.parse(argv, most=1)
    check_states(o)
    if o.op not in METHODS[o.method].ops:
        raise Usage(f"--method: {o.method} does not answer {o.op}; "
                    "`totalforce methods` lists who does")
    if o.op == "operational_inertia" and o.tips is None:
        raise Usage("operational_inertia of which links? --tips LINK,...")
    if o.op != "operational_inertia" and o.tips is not None:
        raise Usage(f"--tips: {o.op} has none")
    if o.precision == "f128" and o.residual == "f64":
        raise Usage("--residual f64: narrower than --precision f128")
    if (o.part or o.merge) and o.resume is None:
        raise Usage(f"{'--part' if o.part else '--merge'}: finished blocks are kept in a file: "
                    "--resume FILE")
    if o.part and o.merge:
        raise Usage(f"--merge: takes all parts, not --part {o.part[0]}/{o.part[1]}")
    return o
