/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * num of TFA_LANES states in lanes: a vector of lane_real, one of each state.
 * Included by number.h of each type, which defines lane_real and the integer of its width,
 * lane_bits.
 */
#ifndef TFA_NUMBER_LANES_H
#define TFA_NUMBER_LANES_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define NUM_LANES TFA_LANES

typedef lane_real num __attribute__((vector_size(sizeof(lane_real) * NUM_LANES)));
typedef lane_bits num_mask __attribute__((vector_size(sizeof(lane_real) * NUM_LANES)));

static inline num num_of(double x)
{
    return (num){0} + (lane_real)x;
}

static inline num num_choose(num_mask m, num a, num b)
{
    return (num)((m & (num_mask)a) | (~m & (num_mask)b));
}
#define num_select(m, a, b) num_choose((num_mask)(m), (a), (b))

static inline int num_every(num_mask m)
{
    lane_bits all = -1;
    for (int l = 0; l < NUM_LANES; l++)
        all &= m[l];
    return all != 0;
}
#define num_all(m) num_every(m)

/* Is it a number, and not too large? By its bits, for compilers that take it for granted. */
static inline num_mask num_is_moderate(num x)
{
    return ((num_mask)x & LANE_EXPONENT) < LANE_EXPONENT_MAX;
}

static inline num num_gather(const double *array, size_t stride, const uint32_t *lane)
{
    num x;
    for (int l = 0; l < NUM_LANES; l++)
        x[l] = (lane_real)array[stride * lane[l]];
    return x;
}
#define num_lane(x, lane) ((x)[lane])

static inline num num_root(num x)
{
    for (int l = 0; l < NUM_LANES; l++)
        x[l] = (lane_real)sqrt((double)x[l]);
    return x;
}
#define num_sqrt num_root

/* By the numbers of one lane after the other */
static inline void num_sincos_many(const num *x, num *s, num *c, size_t first, size_t end)
{
    lane_sincos((const lane_real *)x, (lane_real *)s, (lane_real *)c, first * NUM_LANES,
                end * NUM_LANES);
}
#define num_sincos_many num_sincos_many

#endif
