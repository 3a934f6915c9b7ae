/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: TFA_LANES doubles, one of each of as many states.
 */
#ifndef TFA_NUMBER_H
#define TFA_NUMBER_H

#include <stdint.h>

typedef double lane_real;
typedef int64_t lane_bits;
/* The exponent among the bits; that of 2^900 */
#define LANE_EXPONENT (INT64_C(0x7ff) << 52)
#define LANE_EXPONENT_MAX (INT64_C(1923) << 52)

#include "number/sincos.h"
#define lane_sincos sincos_f64
#define lane_sincos_unpadded sincos_unpadded_f64

#include "number/lanes.h"

#define NUM_EPSILON 0x1p-52

#endif
