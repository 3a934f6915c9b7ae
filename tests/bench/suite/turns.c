/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Time: contestants in turns, so that what the machine does to one it does to all.
 */
#include "suite.h"

#include <math.h>
#include <stdlib.h>

#include "../timing.h"

enum { ROUNDS_MAX = 256 };

static double median(const double *values, uint32_t n, double *least)
{
    double sorted[ROUNDS_MAX];
    for (uint32_t k = 0; k < n; k++)
        sorted[k] = values[k];
    qsort(sorted, n, sizeof *sorted, by_value);
    if (least)
        *least = sorted[0];
    return sorted[n / 2];
}

/* ns for one of `calls` calls. One thread's time is its CPU time; a single call is too short for
 * that clock, which is a system call. */
static double time_turn(struct contest *c, uint32_t contestant, uint32_t calls)
{
    const int cold = c->task->how == HOW_COLD;
    const clockid_t clock =
        c->task->threads > 1 || cold ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID;
    if (cold) {
        flush_all();
        (void)time_ns(clock); /* the clock is not what is to be cold */
    }
    const double start = time_ns(clock);
    for (uint32_t k = 0; k < calls; k++)
        (void)contest_call(c, contestant);
    return (time_ns(clock) - start) / calls;
}

static uint32_t summarise(struct contest *c, struct figures figures[SUITE_CONTESTANTS])
{
    for (uint32_t k = 0; k < c->count; k++) {
        const double bytes = (double)contest_bytes(c, k);
        figures[k] = (struct figures){bytes, bytes, k ? bytes / figures[0].median : 1};
    }
    return 1;
}

uint32_t contest_measure(struct contest *c, double turn_us, uint32_t rounds,
                         struct figures figures[SUITE_CONTESTANTS])
{
    static double ns[SUITE_CONTESTANTS][ROUNDS_MAX], ratio[ROUNDS_MAX];
    uint32_t calls[SUITE_CONTESTANTS];
    rounds = rounds > ROUNDS_MAX ? ROUNDS_MAX : rounds;
    if (c->task->how == HOW_BYTES)
        return summarise(c, figures);
    for (uint32_t k = 0; k < c->count; k++) {
        const double once = time_turn(c, k, 1), few = time_turn(c, k, 2);
        const double fastest = fmin(once, few);
        calls[k] =
            c->task->how == HOW_COLD || fastest <= 0 ? 1 : (uint32_t)(1e3 * turn_us / fastest) + 1;
    }
    for (uint32_t r = 0; r < rounds; r++)
        for (uint32_t k = 0; k < c->count; k++)
            ns[k][r] = time_turn(c, k, calls[k]) / c->task->states;
    for (uint32_t k = 0; k < c->count; k++) {
        for (uint32_t r = 0; r < rounds; r++)
            ratio[r] = ns[k][r] / ns[0][r];
        figures[k].median = median(ns[k], rounds, &figures[k].least);
        figures[k].times = median(ratio, rounds, NULL);
    }
    return rounds;
}
