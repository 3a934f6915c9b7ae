/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reproducible choices for the fuzz targets: one 64-bit seed decides all of them.
 */
#ifndef TESTS_FUZZ_CHANCE_H
#define TESTS_FUZZ_CHANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct chance {
    uint64_t state;
};

/* splitmix64 (Steele, Lea, Flood 2014) */
static inline uint64_t chance_next(struct chance *c)
{
    uint64_t z = c->state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* 0 .. n - 1; 0 for n = 0 */
static inline size_t chance_below(struct chance *c, size_t n)
{
    return n > 0 ? (size_t)(chance_next(c) % n) : 0;
}

static inline bool chance_percent(struct chance *c, unsigned percent)
{
    return chance_next(c) % 100 < percent;
}

/* Uniform in -1 .. 1. */
static inline double chance_signed(struct chance *c)
{
    return (double)(int64_t)chance_next(c) * 0x1p-63;
}

#endif
