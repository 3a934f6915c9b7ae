/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clocks in ns, the order of samples for qsort, and their median.
 */
#ifndef TFA_BENCH_TIMING_H
#define TFA_BENCH_TIMING_H

#include <stdlib.h>
#include <time.h>

static inline double time_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* Of this thread alone: what others take of its processor does not count. */
static inline double cpu_ns(void)
{
    return time_ns(CLOCK_THREAD_CPUTIME_ID);
}

static inline double wall_ns(void)
{
    return time_ns(CLOCK_MONOTONIC);
}

static inline int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the values. */
static inline double median_of(double *values, int n)
{
    qsort(values, (size_t)n, sizeof *values, by_value);
    return values[n / 2];
}

#endif
