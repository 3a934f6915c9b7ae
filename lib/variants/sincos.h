/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sines and cosines of many numbers by SLEEF, as many at a time as the instruction set has lanes. Its
 * error is below 1 unit in the last place for every angle (glibc: 0.55). Without SLEEF one by one.
 */
#ifndef TFA_VARIANTS_SINCOS_H
#define TFA_VARIANTS_SINCOS_H

#include <math.h>
#include <stddef.h>

#ifdef TFA_SLEEF
#include <sleef.h>
#include <string.h>

/* 7 angles: 150 ns by glibc one by one, 36 by two calls of avx2, 20 by one of avx512. Measured
 * 2026-11-22 on an Intel Xeon (AVX-512) VM, random angles up to 3 rad. With TFA_EXACT, where all
 * instruction sets agree to the bit, those without fused multiplication and addition. */
#if defined(__AVX512F__)
typedef Sleef___m512d_2 sincos_doubles;
typedef Sleef___m512_2 sincos_floats;
#ifdef TFA_EXACT
#define SINCOS_DOUBLES Sleef_cinz_sincosd8_u10avx512fnofma
#define SINCOS_FLOATS Sleef_cinz_sincosf16_u10avx512fnofma
#else
#define SINCOS_DOUBLES Sleef_finz_sincosd8_u10avx512f
#define SINCOS_FLOATS Sleef_finz_sincosf16_u10avx512f
#endif
#elif defined(__AVX2__)
typedef Sleef___m256d_2 sincos_doubles;
typedef Sleef___m256_2 sincos_floats;
#ifdef TFA_EXACT
#define SINCOS_DOUBLES Sleef_cinz_sincosd4_u10avx
#define SINCOS_FLOATS Sleef_cinz_sincosf8_u10avx
#else
#define SINCOS_DOUBLES Sleef_finz_sincosd4_u10avx2
#define SINCOS_FLOATS Sleef_finz_sincosf8_u10avx2
#endif
#else
typedef Sleef___m128d_2 sincos_doubles;
typedef Sleef___m128_2 sincos_floats;
#define SINCOS_DOUBLES Sleef_cinz_sincosd2_u10sse2
#define SINCOS_FLOATS Sleef_cinz_sincosf4_u10sse2
#endif

/* Of x[first] .. x[end - 1]; whole vectors are read and written, from the one that holds `first`. */
#define SINCOS_MANY(name, real, pairs, pairs_of)                                                   \
    static inline void name(const real *x, real *s, real *c, size_t first, size_t end)             \
    {                                                                                              \
        pairs p;                                                                                   \
        const size_t lanes = sizeof p.x / sizeof *x;                                               \
        for (size_t k = first / lanes * lanes; k < end; k += lanes) {                              \
            memcpy(&p.x, x + k, sizeof p.x);                                                       \
            p = pairs_of(p.x);                                                                     \
            memcpy(s + k, &p.x, sizeof p.x);                                                       \
            memcpy(c + k, &p.y, sizeof p.y);                                                       \
        }                                                                                          \
    }
SINCOS_MANY(sincos_f64, double, sincos_doubles, SINCOS_DOUBLES)
SINCOS_MANY(sincos_f32, float, sincos_floats, SINCOS_FLOATS)
#undef SINCOS_MANY
#else
#define SINCOS_MANY(name, real, pair_of)                                                           \
    static inline void name(const real *x, real *s, real *c, size_t first, size_t end)             \
    {                                                                                              \
        for (size_t k = first; k < end; k++)                                                       \
            pair_of(x[k], &s[k], &c[k]);                                                           \
    }
SINCOS_MANY(sincos_f64, double, sincos)
SINCOS_MANY(sincos_f32, float, sincosf)
#undef SINCOS_MANY
#endif

#endif
