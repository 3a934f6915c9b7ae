/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Progress of long work, in the last line of a terminal.
 */
#include "progress.h"

#include <inttypes.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

static const uint64_t pause_ns = 500000000;

int progress_wanted(void)
{
    static int terminal = -1;
    if (terminal < 0)
        terminal = isatty(STDERR_FILENO);
    return terminal;
}

static uint64_t clock_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

void progress_show(const char *what, uint64_t done, uint64_t count, const char *unit)
{
    static int shown;
    static uint64_t last;
    if (!progress_wanted() || (what == NULL && !shown))
        return;
    const uint64_t now = clock_now();
    if (what != NULL && count > 0 && now - last < pause_ns)
        return;
    last = now;
    shown = what != NULL;
    if (what == NULL)
        fputs("\r\033[K", stderr);
    else if (count == 0)
        fprintf(stderr, "\r\033[K%s ...", what);
    else
        fprintf(stderr, "\r\033[K%s: %" PRIu64 " of %" PRIu64 "%s%s", what, done, count,
                *unit ? " " : "", unit);
    fflush(stderr);
}
