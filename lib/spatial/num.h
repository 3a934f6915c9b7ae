/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The number type. Every numeric source is compiled once for each folder of lib/variants, whose
 * variant.h gives `num` and num_sincos; nothing but + - * / and selections is used on it.
 */
#ifndef TFA_SPATIAL_NUM_H
#define TFA_SPATIAL_NUM_H

#include <stddef.h>
#include <stdint.h>

#include "variant.h"

/* A name of this variant: TFA_V(aba) is aba_f64_avx2 where TFA_VARIANT is f64_avx2. */
#define TFA_V_PASTE(name, variant) tfa_##name##_##variant
#define TFA_V_EXPAND(name, variant) TFA_V_PASTE(name, variant)
#define TFA_V(name) TFA_V_EXPAND(name, TFA_VARIANT)

static inline num num_abs(num x)
{
    return x < 0 ? -x : x;
}

/* Sines and cosines of x[first] .. x[end - 1]. Arrays start and end on a whole vector (arena.h): a
 * variant may read and write whole vectors. */
#ifndef num_sincos_many
static inline void num_sincos_many(const num *x, num *s, num *c, size_t first, size_t end)
{
    for (size_t k = first; k < end; k++)
        num_sincos(x[k], &s[k], &c[k]);
}
#endif

/* m ? a : b, where m is the result of a comparison */
#ifndef num_select
#define num_select(m, a, b) ((m) ? (a) : (b))
#endif

#endif
