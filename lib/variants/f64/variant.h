/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one double.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include "variants/sincos.h"

typedef double num;
#define NUM_EPSILON 0x1p-52
#define num_sincos_many sincos_f64

/* Numbers that the instruction set takes at a time (six.h) */
#if defined(__AVX512F__)
#define NUM_ROW 8
#elif defined(__AVX__)
#define NUM_ROW 4
#else
#define NUM_ROW 2
#endif

#endif
