/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: TFA_LANES floats, one of each of as many states.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include <stdint.h>

typedef float lane_real;
typedef int32_t lane_bits;

#include "variants/sincos.h"
#define lane_sincos sincos_f32

#include "variants/lanes.h"

#define NUM_EPSILON 0x1p-23f

#endif
