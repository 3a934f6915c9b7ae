# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Processes that end with the test that started them, also where ctest's limit kills it."""
import signal
import subprocess

from wait import WAIT


def guard(group):
    """Kills the process group as soon as this process has ended, however it does."""
    return subprocess.Popen(["sh", "-c", f"cat; kill -s KILL -- -{group}"], process_group=0,
                            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)


def start(command, **options):
    """Popen of a process group of its own, with a guard"""
    process = subprocess.Popen(command, process_group=0, **options)
    process.guard = guard(process.pid)
    return process


def end(process, number=signal.SIGTERM):
    """Signals a process of start(), waits for its end, and ends what is left of its group."""
    process.send_signal(number)
    try:
        return process.wait(WAIT)
    finally:
        process.guard.communicate()
        process.wait()
