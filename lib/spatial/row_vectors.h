/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows of a matrix in whole SIMD registers: strides are multiples of NUM_VEC_LANES, rows start
 * aligned (arena.h) and are 0 behind their last number.
 */
#ifndef TFA_SPATIAL_ROW_VECTORS_H
#define TFA_SPATIAL_ROW_VECTORS_H

#include "spatial/vec6.h"

/* Stride of rows of n numbers */
static inline uint32_t row_stride(uint32_t n)
{
    return (n + NUM_VEC_LANES - 1) / NUM_VEC_LANES * NUM_VEC_LANES;
}

static inline num_vec row_load(const num *x)
{
    num_vec v;
    memcpy(&v, __builtin_assume_aligned(x, sizeof v), sizeof v);
    return v;
}

static inline void row_store(num *x, num_vec v)
{
    memcpy(__builtin_assume_aligned(x, sizeof v), &v, sizeof v);
}

/* At any address */
TFA_INLINE num_vec numbers_load(const num *x)
{
    num_vec v;
    memcpy(&v, x, sizeof v);
    return v;
}

TFA_INLINE void numbers_store(num *x, num_vec v)
{
    memcpy(x, &v, sizeof v);
}

/* All numbers of these vectors */
TFA_INLINE int numbers_are_zero(const num_vec *x, int vecs)
{
#if NUM_VEC_LANES > 1
    __typeof__(x[0] != x[0]) any = x[0] != (num_vec){0};
    int sum = 0;
    for (int v = 1; v < vecs; v++)
        any |= x[v] != (num_vec){0};
    for (int l = 0; l < NUM_VEC_LANES; l++)
        sum |= any[l] != 0;
    return !sum;
#else
    for (int v = 0; v < vecs; v++)
        if (!num_all(x[v] == num_of(0)))
            return 0;
    return 1;
#endif
}

/* The order of the sum is that of the lanes; with TFA_EXACT one for all instruction sets */
static inline num row_dot(const num *x, const num *y, uint32_t stride)
{
    num sum = num_of(0);
#ifdef TFA_EXACT
    for (uint32_t c = 0; c < stride; c++)
        sum += x[c] * y[c];
#else
    num_vec products = {0};
    for (uint32_t c = 0; c < stride; c += NUM_VEC_LANES)
        products += row_load(x + c) * row_load(y + c);
    for (int l = 0; l < NUM_VEC_LANES; l++)
        sum += vec_lane(products, l);
#endif
    return sum;
}

#endif
