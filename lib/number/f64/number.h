/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one double.
 */
#ifndef TFA_NUMBER_H
#define TFA_NUMBER_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "number/sincos.h"

typedef double num;
typedef double lane_real;
/* The exponent among the bits; that of 2^900 */
#define LANE_EXPONENT (INT64_C(0x7ff) << 52)
#define LANE_EXPONENT_MAX (INT64_C(1923) << 52)

/* Is it a number, and not too large? By its bits, for compilers that take it for granted. */
static inline int num_is_moderate(num x)
{
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & LANE_EXPONENT) < LANE_EXPONENT_MAX;
}

#define NUM_EPSILON 0x1p-52
#define num_sqrt sqrt
#define num_sincos_many sincos_f64
#define lane_sincos_unpadded sincos_unpadded_f64

/* Numbers that the instruction set takes at a time (vec6.h) */
#if defined(__AVX512F__)
#define NUM_VEC_LANES 8
#elif defined(__AVX__)
#define NUM_VEC_LANES 4
#else
#define NUM_VEC_LANES 2
#endif

#endif
