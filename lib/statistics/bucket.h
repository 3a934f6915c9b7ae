/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Buckets of a log-linear histogram: the arithmetic of histogram.h and of the histograms in shared
 * memory.
 */
#ifndef TFA_STATISTICS_BUCKET_H
#define TFA_STATISTICS_BUCKET_H

#include <stdint.h>

/* Bucket of a value, below bucket_count. */
static inline uint32_t tfa_bucket_of(uint32_t bits, uint32_t bucket_count, uint64_t value)
{
    const uint32_t half = UINT32_C(1) << bits >> 1;
    const uint32_t highest_bit = 63u ^ (uint32_t)__builtin_clzll(value | half);
    const uint32_t shift = highest_bit - (bits - 1);
    /* value >> shift is below 2 half, and at least half where shift is above 0 */
    const uint32_t bucket = shift * half + (uint32_t)(value >> shift);
    return bucket < bucket_count ? bucket : bucket_count - 1;
}

/* The largest value of a bucket. */
static inline uint64_t tfa_bucket_top(uint32_t bits, uint32_t bucket_count, uint32_t bucket)
{
    const uint32_t linear = UINT32_C(1) << bits, half = linear / 2;
    if (bucket + 1 >= bucket_count)
        return UINT64_MAX;
    if (bucket < linear)
        return bucket;
    const uint32_t shift = (bucket - linear) / half + 1;
    const uint64_t mantissa = (bucket - linear) % half + half;
    return ((mantissa + 1) << shift) - 1;
}

#endif
