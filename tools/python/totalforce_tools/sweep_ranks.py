# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The processes of a sweep: one alone, or the ranks of an MPI job. mpi4py is imported in such a job
only: nothing else needs MPI."""
import contextlib
import os
import re
import sys
import traceback

import totalforce as tf
from totalforce_tools.command import FAILED, Failed

# Open MPI's mpirun, PMI launchers, and srun, which says how many tasks its step has: a batch script
# has no step of its own.
SIZES = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS")


def number(name):
    """A whole number of the environment, or -1"""
    text = os.environ.get(name, "")
    return int(text) if re.fullmatch("0|[1-9][0-9]{0,8}", text) else -1


def launched_ranks():
    """Number of processes that mpirun or srun started; 1 without them"""
    return next((number(name) for name in SIZES if number(name) > 0), 1)


def tell(text):
    print(f"totalforce sweep: {text}", file=sys.stderr)


class Ranks:
    """One process alone. All ranks call these together."""

    rank, size = 0, 1

    def broadcast(self, value):
        """That of rank 0, on all"""
        return value

    def gather(self, value):
        """Those of all ranks, on rank 0"""
        return [value]

    def agree(self, good):
        """Whether `good` on every rank"""
        return good

    def together(self, work, *args):
        """What work(*args) returns. Where it fails on one rank, all of them end."""
        value, good = None, False
        try:
            value, good = work(*args), True
        except (Failed, tf.Error) as error:
            tell(error)
        except SystemExit:
            pass  # after a message
        except OSError as error:
            tell(f"{error.filename}: {error.strerror}")
        if not self.agree(good):
            raise SystemExit(FAILED)
        return value


class MpiRanks(Ranks):
    def __init__(self, comm, mpi):
        self.comm, self.least = comm, mpi.LAND
        self.rank, self.size = comm.Get_rank(), comm.Get_size()

    def broadcast(self, value):
        return self.comm.bcast(value)

    def gather(self, value):
        return self.comm.gather(value)

    def agree(self, good):
        return self.comm.allreduce(good, op=self.least)


@contextlib.contextmanager
def started():
    """The ranks; an error that nothing expects ends all of them."""
    count = launched_ranks()
    if count == 1:
        yield Ranks()
        return
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise Failed(f"{count} ranks were started, and mpi4py is not there: {error}; install "
                     "python3-mpi4py, or use --part I/N without MPI") from None
    ranks = MpiRanks(MPI.COMM_WORLD, MPI)
    if ranks.size == 1:
        raise Failed(f"{count} processes were started, and MPI knows of one only: start them with "
                     "mpirun or srun --mpi=pmix, or use --part I/N")
    try:
        yield ranks
    except SystemExit:
        raise
    except BaseException:
        traceback.print_exc()
        MPI.COMM_WORLD.Abort(FAILED)
