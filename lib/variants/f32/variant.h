/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one float.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include "variants/sincos.h"

typedef float num;
#define NUM_EPSILON 0x1p-23f
#define num_sincos_many sincos_f32

/* Numbers that the instruction set takes at a time (six.h) */
#if defined(__AVX__)
#define NUM_ROW 8
#else
#define NUM_ROW 4
#endif

#endif
