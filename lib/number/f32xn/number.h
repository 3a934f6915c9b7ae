/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: TFA_LANES floats, one of each of as many states.
 */
#ifndef TFA_NUMBER_H
#define TFA_NUMBER_H

#include <stdint.h>

typedef float lane_real;
typedef int32_t lane_bits;
/* The exponent among the bits; that of 2^100 */
#define LANE_EXPONENT (INT32_C(0xff) << 23)
#define LANE_EXPONENT_MAX (INT32_C(227) << 23)

#include "number/sincos.h"
#define lane_sincos sincos_f32
#define lane_sincos_unpadded sincos_unpadded_f32

#include "number/lanes.h"

#define NUM_EPSILON 0x1p-23f

#endif
