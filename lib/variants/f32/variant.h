/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one float.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include <math.h>

typedef float num;
#define NUM_EPSILON 0x1p-23f

static inline void num_sincos(num x, num *s, num *c)
{
    sincosf(x, s, c);
}

#endif
