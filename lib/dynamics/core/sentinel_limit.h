/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where the sentinel trips (sentinel.h).
 */
#ifndef TFA_DYNAMICS_CORE_SENTINEL_LIMIT_H
#define TFA_DYNAMICS_CORE_SENTINEL_LIMIT_H

#include "spatial/num.h"

/* docs/accuracy.md, "The sentinel" */
#define SENTINEL_LIMIT (NUM_EPSILON > 0x1p-30 ? 3e-4 : 1e-9)
#define SENTINEL_RATIO num_of((double)NUM_EPSILON / SENTINEL_LIMIT)

/* The smaller of a margin and that of one more joint. TFA_WITHOUT_SENTINEL is for
 * tests/bench/sentinel.sh, which measures the sentinel's cost. */
static inline num sentinel_smaller(num margin, num joint)
{
#ifdef TFA_WITHOUT_SENTINEL
    (void)joint;
    return margin;
#else
    return num_select(joint < margin, joint, margin);
#endif
}

/* Of one joint, whose D is a difference of numbers up to G: below zero where D is not safe */
static inline num sentinel_margin(num D, num G)
{
    return D - G * SENTINEL_RATIO;
}

#endif
