/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The 2-norm of freedoms, whatever their scale.
 */
#ifndef TFA_DYNAMICS_SOLVE_NORM_H
#define TFA_DYNAMICS_SOLVE_NORM_H

#include <math.h>

#include "spatial/num.h"

/* Sums of squares within keep their digits. */
#define SQUARES_LEAST num_of(NUM_EPSILON > 0x1p-30 ? 1e-25 : 1e-280)
#define SQUARES_MOST num_of(NUM_EPSILON > 0x1p-30 ? 1e37 : 1e300)

/* 2-norms whose squares under- or overflow: by the largest number */
static __attribute__((noinline)) num_doubles norm_scaled(const num *x, uint32_t n)
{
    num most = num_of(0), sum = num_of(0);
    num_doubles root;
    for (uint32_t j = 0; j < n; j++)
        most = num_select(num_abs(x[j]) > most, num_abs(x[j]), most);
    most = num_select(most > 0, most, num_of(1));
    for (uint32_t j = 0; j < n; j++)
        sum += x[j] / most * (x[j] / most);
    for (int l = 0; l < NUM_LANES; l++)
        root.lane[l] = (double)num_lane(most, l) * sqrt((double)num_lane(sum, l));
    return root;
}

/* A lane has the same bits whatever stands in the others. */
static inline num_doubles norm(const num *x, uint32_t n)
{
    num sum = num_of(0);
    num_doubles root;
    for (uint32_t j = 0; j < n; j++)
        sum += x[j] * x[j];
    for (int l = 0; l < NUM_LANES; l++)
        root.lane[l] = sqrt((double)num_lane(sum, l));
    if (num_all(sum > SQUARES_LEAST) && num_all(sum < SQUARES_MOST))
        return root;
    const num_doubles scaled = norm_scaled(x, n);
    for (int l = 0; l < NUM_LANES; l++)
        if (!(num_lane(sum, l) > num_lane(SQUARES_LEAST, l)) ||
            !(num_lane(sum, l) < num_lane(SQUARES_MOST, l)))
            root.lane[l] = scaled.lane[l];
    return root;
}

#endif
