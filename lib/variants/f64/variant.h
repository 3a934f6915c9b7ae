/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one double.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include <math.h>

typedef double num;
#define NUM_EPSILON 0x1p-52

static inline void num_sincos(num x, num *s, num *c)
{
    sincos(x, s, c);
}

#endif
