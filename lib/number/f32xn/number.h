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

#include "number/sincos.h"
#define lane_sincos sincos_f32

#include "number/lanes.h"

#define NUM_EPSILON 0x1p-23f

#endif
