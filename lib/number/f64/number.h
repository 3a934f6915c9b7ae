/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one double.
 */
#ifndef TFA_NUMBER_H
#define TFA_NUMBER_H

#include <math.h>

#include "number/sincos.h"

typedef double num;
#define NUM_EPSILON 0x1p-52
#define num_sqrt sqrt
#define num_sincos_many sincos_f64

/* Numbers that the instruction set takes at a time (vec6.h) */
#if defined(__AVX512F__)
#define NUM_VEC_LANES 8
#elif defined(__AVX__)
#define NUM_VEC_LANES 4
#else
#define NUM_VEC_LANES 2
#endif

#endif
