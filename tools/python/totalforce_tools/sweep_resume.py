# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Resume files: finished blocks with their statistics, one line each with a checksum, appended by
one process. PREFIX.0, PREFIX.1, ... of one sweep are read together.

  totalforce-sweep 1 version=... isa=... model=... op=... seed=... count=... block=...
  block 12 0:10000 6:10000 ... #43eaeb339d9ba566

The first line is everything that decides the result. Words of a block are index:value in
hexadecimal: the words of its statistics that are not zero. The number behind # is the FNV-1a hash
of the line before the blank. A line that was cut off is a missing block.
"""
import errno
import fcntl
import glob
import os
import re

import numpy as np

import totalforce_tools.sweep_statistics as statistics
from totalforce import _totalforce
from totalforce_tools.command import Failed

HEAD = b"totalforce-sweep 1 "
LINE = re.compile(rb"(block ([0-9]{1,19})((?: [0-9a-f]{1,8}:[0-9a-f]{1,16})*)) #([0-9a-f]{16})")
checksum = _totalforce._Sweep.checksum


def difference(path, theirs, ours):
    """The first word in which two identities differ, of both"""
    pairs = list(zip(theirs.split(b" ") + [b""], ours.split(b" ") + [b""]))
    found, mine = next((pair for pair in pairs if pair[0] != pair[1]), pairs[-1])
    return Failed(f"{path}: is of another sweep: it has {os.fsdecode(found)}, this one "
                  f"{os.fsdecode(mine)}; take another --resume FILE")


def read_words(text):
    """Statistics, or None of a text that has none"""
    words = statistics.empty()
    for pair in text.split():
        index, value = (int(digits, 16) for digits in pair.split(b":"))
        if index >= statistics.WORDS:
            return None
        words[index] = value
    return words


def read_block(line):
    """Number and statistics; None of a line that a process was killed in: its block is missing."""
    whole = LINE.fullmatch(line)
    if not whole or checksum(whole[1]) != int(whole[4], 16):
        return None
    words = read_words(whole[3])
    return None if words is None else (int(whole[2]), words)


def read(plan, done):
    """Statistics of the blocks in all files of the prefix, which are marked in `done`."""
    found, total, identity = [], statistics.empty(), os.fsencode(plan.identity)
    for path in sorted(glob.glob(glob.escape(plan.o.resume) + ".[0-9]*")):
        with open(path, "rb") as lines:
            for line in lines:
                line = line.rstrip(b"\n")
                if line.startswith(HEAD) and line[len(HEAD):] != identity:
                    raise difference(path, line[len(HEAD):], identity)
                block = read_block(line)
                if block and block[0] < plan.blocks and not done[block[0]]:
                    done[block[0]] = True
                    found.append(block[1])
            total, found = statistics.merge([total, *found]), []
    return total


class Out:
    """PREFIX.`number`, to append to; for one process at a time"""

    def __init__(self, plan, number):
        self.prefix, path = plan.o.resume, f"{plan.o.resume}.{number}"
        flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            self.file = os.fdopen(os.open(path, flags, 0o666), "a+b")
        except OSError as error:
            why = "a symbolic link" if error.errno == errno.ELOOP else error.strerror
            raise Failed(f"--resume {path}: {why}") from None
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise Failed(f"{path}: another sweep writes it: wait for it, or take another --resume "
                         "FILE") from None
        # a line that was cut off ends here, and its successor stays whole
        self.file.seek(-1 if self.file.tell() else 0, os.SEEK_END)
        begin = b"" if self.file.read(1) in (b"", b"\n") else b"\n"
        self.write(begin + HEAD + os.fsencode(plan.identity) + b"\n")

    def write(self, data):
        try:
            self.file.write(data)
            self.file.flush()
        except OSError as error:
            raise Failed(f"--resume {self.prefix}: {error.strerror}") from None

    def add(self, block, words):
        pairs = "".join(f" {k:x}:{words[k]:x}" for k in np.flatnonzero(words).tolist())
        text = f"block {block}{pairs}".encode()
        self.write(text + f" #{checksum(text):016x}\n".encode())
