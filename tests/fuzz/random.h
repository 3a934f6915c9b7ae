/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reproducible choices of fuzz targets and hostile tests: one 64-bit seed decides all of them.
 */
#ifndef TESTS_FUZZ_RANDOM_H
#define TESTS_FUZZ_RANDOM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct random_source {
    uint64_t state;
};

/* splitmix64 (Steele, Lea, Flood 2014) */
static inline uint64_t random_next(struct random_source *c)
{
    uint64_t z = c->state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* 0 .. n - 1; 0 for n = 0 */
static inline size_t random_below(struct random_source *c, size_t n)
{
    return n > 0 ? (size_t)(random_next(c) % n) : 0;
}

static inline bool random_percent(struct random_source *c, unsigned percent)
{
    return random_next(c) % 100 < percent;
}

/* Uniform in -1 .. 1. */
static inline double random_signed(struct random_source *c)
{
    return (double)(int64_t)random_next(c) * 0x1p-63;
}

#endif
