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

#include "number/sincos.h"
#define lane_sincos sincos_f64

#include "number/lanes.h"

#define NUM_EPSILON 0x1p-52

#endif
