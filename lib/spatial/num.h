/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The number type. Every numeric source is compiled once for each folder of lib/variants, whose
 * variant.h gives `num` and num_sincos; nothing but + - * / and selections is used on it.
 */
#ifndef TFA_SPATIAL_NUM_H
#define TFA_SPATIAL_NUM_H

#include <stdint.h>

#include "variant.h"

/* A name of this variant: TFA_V(aba) is aba_f64_avx2 where TFA_VARIANT is f64_avx2. */
#define TFA_V_PASTE(name, variant) tfa_##name##_##variant
#define TFA_V_EXPAND(name, variant) TFA_V_PASTE(name, variant)
#define TFA_V(name) TFA_V_EXPAND(name, TFA_VARIANT)

/* Rounding of an answer: that of num, or of the doubles in which it is given. */
#define ANSWER_EPSILON (NUM_EPSILON > 0x1p-52 ? (double)NUM_EPSILON : 0x1p-52)

static inline num num_abs(num x)
{
    return x < 0 ? -x : x;
}

/* m ? a : b, where m is the result of a comparison */
#ifndef num_select
#define num_select(m, a, b) ((m) ? (a) : (b))
#endif

#endif
