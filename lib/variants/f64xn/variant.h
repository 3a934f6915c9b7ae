/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: TFA_LANES doubles, one of each of as many states.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include <stdint.h>

#include "variants/sincos_f64.h"

#define NUM_LANES TFA_LANES
#define NUM_EPSILON 0x1p-52

typedef double num __attribute__((vector_size(8 * NUM_LANES)));
typedef int64_t num_mask __attribute__((vector_size(8 * NUM_LANES)));

static inline num num_of(double x)
{
    return (num){0} + x;
}

static inline num num_choose(num_mask m, num a, num b)
{
    return (num)((m & (num_mask)a) | (~m & (num_mask)b));
}
#define num_select(m, a, b) num_choose((num_mask)(m), (a), (b))

static inline int num_every(num_mask m)
{
    int64_t all = -1;
    for (int l = 0; l < NUM_LANES; l++)
        all &= m[l];
    return all != 0;
}
#define num_all(m) num_every(m)

static inline num num_gather(const double *array, size_t stride, const uint32_t *lane)
{
    num x;
    for (int l = 0; l < NUM_LANES; l++)
        x[l] = array[stride * lane[l]];
    return x;
}
#define num_lane(x, lane) ((x)[lane])

static inline void num_sincos_many(const num *x, num *s, num *c, size_t first, size_t end)
{
    sincos_f64((const double *)x, (double *)s, (double *)c, first * NUM_LANES, end * NUM_LANES);
}
#define num_sincos_many num_sincos_many

#endif
