/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Four neighbouring numbers of the state in every lane, between arrays of doubles and num: rows of
 * four are read and written as vectors and transposed in registers. One by one they take five
 * instructions a number, half of the time of forward dynamics of an arm in 16 lanes.
 */
#ifndef TFA_SPATIAL_ROWS_H
#define TFA_SPATIAL_ROWS_H

#include <string.h>

#include "spatial/num.h"

#if NUM_LANES == 4 || NUM_LANES == 8 || NUM_LANES == 16
#define NUM_ROW 4

typedef double row_doubles __attribute__((vector_size(NUM_ROW * sizeof(double))));
typedef lane_real row_lanes __attribute__((vector_size(NUM_ROW * sizeof(lane_real))));

/* DO(first lane) for each four lanes */
#if NUM_LANES == 4
#define ROWS_EACH(DO) DO(0)
#elif NUM_LANES == 8
#define ROWS_EACH(DO) DO(0), DO(4)
#else
#define ROWS_EACH(DO) DO(0), DO(4), DO(8), DO(12)
#endif

/* Of two vectors, in each four lanes: their numbers in turns, first and second half; halves */
#define ROWS_LOW(b) b, NUM_LANES + b, b + 1, NUM_LANES + b + 1
#define ROWS_HIGH(b) b + 2, NUM_LANES + b + 2, b + 3, NUM_LANES + b + 3
#define ROWS_FRONT(b) b, b + 1, NUM_LANES + b, NUM_LANES + b + 1
#define ROWS_BACK(b) b + 2, b + 3, NUM_LANES + b + 2, NUM_LANES + b + 3

/* Transposes the 4 x 4 numbers in each four lanes. */
TFA_INLINE void rows_transpose(num x[NUM_ROW])
{
    const num a = __builtin_shufflevector(x[0], x[1], ROWS_EACH(ROWS_LOW)),
              b = __builtin_shufflevector(x[2], x[3], ROWS_EACH(ROWS_LOW)),
              c = __builtin_shufflevector(x[0], x[1], ROWS_EACH(ROWS_HIGH)),
              d = __builtin_shufflevector(x[2], x[3], ROWS_EACH(ROWS_HIGH));
    x[0] = __builtin_shufflevector(a, b, ROWS_EACH(ROWS_FRONT));
    x[1] = __builtin_shufflevector(a, b, ROWS_EACH(ROWS_BACK));
    x[2] = __builtin_shufflevector(c, d, ROWS_EACH(ROWS_FRONT));
    x[3] = __builtin_shufflevector(c, d, ROWS_EACH(ROWS_BACK));
}

/* x[e], lane l: array[stride * lane[l] + e] */
TFA_INLINE void rows_gather(num x[NUM_ROW], const double *array, size_t stride,
                            const uint32_t *lane)
{
    row_lanes row[NUM_LANES];
#pragma GCC unroll 16
    for (int l = 0; l < NUM_LANES; l++) {
        row_doubles from;
        memcpy(&from, array + stride * lane[l], sizeof from);
        row[l] = __builtin_convertvector(from, row_lanes);
    }
#pragma GCC unroll 4
    for (int e = 0; e < NUM_ROW; e++) {
#define ROWS_JOIN(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7)
#if NUM_LANES == 4
        x[e] = row[e];
#elif NUM_LANES == 8
        x[e] = ROWS_JOIN(row[e], row[e + 4]);
#else
        x[e] = __builtin_shufflevector(ROWS_JOIN(row[e], row[e + 4]),
                                       ROWS_JOIN(row[e + 8], row[e + 12]), 0, 1, 2, 3, 4, 5, 6, 7,
                                       8, 9, 10, 11, 12, 13, 14, 15);
#endif
#undef ROWS_JOIN
    }
    rows_transpose(x);
}

#define ROWS_PUT(b)                                                                                \
    {                                                                                              \
        const row_lanes row = __builtin_shufflevector(x[e], x[e], b, b + 1, b + 2, b + 3);         \
        const row_doubles to = __builtin_convertvector(row, row_doubles);                          \
        memcpy(array + stride * lane[b + e], &to, sizeof to);                                      \
    }

/* The reverse. Lanes of the same state hold the same numbers. */
TFA_INLINE void rows_scatter(const num four[NUM_ROW], double *array, size_t stride,
                             const uint32_t *lane)
{
    num x[NUM_ROW] = {four[0], four[1], four[2], four[3]};
    rows_transpose(x);
#pragma GCC unroll 4
    for (int e = 0; e < NUM_ROW; e++) {
        ROWS_PUT(0)
#if NUM_LANES > 4
        ROWS_PUT(4)
#endif
#if NUM_LANES > 8
        ROWS_PUT(8)
        ROWS_PUT(12)
#endif
    }
}

#undef ROWS_PUT
#endif

/* n neighbouring numbers of every lane: array[stride * lane[l] + k] = x[k], lane l. Lanes of the
 * same state hold the same numbers. */
TFA_INLINE void scatter_numbers(const num *x, const uint32_t *lane, double *array, size_t stride,
                                size_t n)
{
    size_t k = 0;
#ifdef NUM_ROW
    if (n >= NUM_ROW) {
#pragma GCC unroll 64
        for (; k + NUM_ROW <= n; k += NUM_ROW)
            rows_scatter(x + k, array + k, stride, lane);
        if (k < n)
            rows_scatter(x + n - NUM_ROW, array + n - NUM_ROW, stride, lane);
        k = n;
    }
#endif
    for (; k < n; k++)
#pragma GCC unroll 16
        for (uint32_t l = 0; l < NUM_LANES; l++)
            array[stride * lane[l] + k] = (double)num_lane(x[k], l);
}

#endif
