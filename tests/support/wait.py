# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Waiting for a condition, as wait.h."""
import time

WAIT = 300  # seconds for what must happen; only ever used up by a failure


def waiting():
    """Turns until the loop that takes them breaks: what is waited for is looked at in each, and once
    more after that."""
    end = time.monotonic() + WAIT
    while time.monotonic() < end:
        yield
        time.sleep(0.02)
    yield


def until(condition):
    """Its last value: true, unless the time is over"""
    for _ in waiting():
        if value := condition():
            break
    return value
