/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The number type. Every numeric source is compiled once for each folder of lib/variants, whose
 * number.h (lib/number) gives `num` and num_sincos; nothing but + - * / and selections is used on
 * it.
 */
#ifndef TFA_SPATIAL_NUM_H
#define TFA_SPATIAL_NUM_H

#include <stddef.h>
#include <stdint.h>

#include "number.h"

/* Of functions inside the step of a body. A call would pass its six-vectors and inertias through
 * memory: written number by number, copied by two or four, and a wide load waits until narrow
 * stores have left the processor (47 ns of 7 bodies, AMD EPYC Zen 5, gcc 12, 2026-11-22). A number
 * type whose operations are calls brings its own. */
#ifndef TFA_INLINE
#define TFA_INLINE static inline __attribute__((always_inline))
#endif

/* Of functions that are better called: rare and large, they would keep the numbers of the others
 * from the registers; TFA_SHARED of those that several files of a kernel call and one defines. A
 * kernel specialised for one robot is one file and knows for each body which of them it takes. */
#ifdef TFA_ONE_FILE
#define TFA_OUTLINE TFA_INLINE
#define TFA_SHARED TFA_INLINE
#else
#define TFA_OUTLINE static __attribute__((noinline))
#define TFA_SHARED
#endif

/* A name of this variant: TFA_V(aba) is aba_f64_avx2 where TFA_VARIANT is f64_avx2. */
#define TFA_V_PASTE(name, variant) tfa_##name##_##variant
#define TFA_V_EXPAND(name, variant) TFA_V_PASTE(name, variant)
#define TFA_V(name) TFA_V_EXPAND(name, TFA_VARIANT)

/* Rounding of an answer: that of num, or of the doubles in which it is given. */
#define ANSWER_EPSILON (NUM_EPSILON > 0x1p-52 ? (double)NUM_EPSILON : 0x1p-52)

/* Sines and cosines of x[first] .. x[end - 1]. Arrays start and end on a whole vector (arena.h): a
 * variant may read and write whole vectors. */
#ifndef num_sincos_many
static inline void num_sincos_many(const num *x, num *s, num *c, size_t first, size_t end)
{
    for (size_t k = first; k < end; k++)
        num_sincos(x[k], &s[k], &c[k]);
}
#endif

/* Rounded to double, for a number type that is wider */
#ifndef num_rounded
#define num_rounded(x) (x)
#endif

/* Lanes: number of states in a num. These are for one; a variant with several
 * brings its own. */
#ifndef NUM_LANES
#define NUM_LANES 1

/* A constant, the same in every lane */
static inline num num_of(double x)
{
    return (num)x;
}

/* array[stride * lane] for the state in every lane, and the number of one lane */
static inline num num_gather(const double *array, size_t stride, const uint32_t *lane)
{
    return (num)array[stride * lane[0]];
}
#define num_lane(x, lane) (x)

/* A comparison as a mask of lanes; whether it holds in all of them */
typedef int num_mask;
#define num_all(m) (m)

/* m ? a : b, where m is the result of a comparison */
#ifndef num_select
#define num_select(m, a, b) ((m) ? (a) : (b))
#endif
#endif

/* A double for every lane */
typedef struct num_doubles {
    double lane[NUM_LANES];
} num_doubles;

static inline num num_abs(num x)
{
    return num_select(x < num_of(0), -x, x);
}

#endif
