/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sines and cosines of many numbers by SLEEF, as many at a time as the instruction set has lanes.
 * Its error is below 1 unit in the last place for every angle (glibc: 0.55). Without SLEEF one by
 * one.
 */
#ifndef TFA_NUMBER_SINCOS_H
#define TFA_NUMBER_SINCOS_H

#include <math.h>
#include <stddef.h>

#ifdef TFA_SLEEF
#include <sleef.h>
#include <stdint.h>
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
#elif defined(__ARM_NEON)
typedef Sleef_float64x2_t_2 sincos_doubles;
typedef Sleef_float32x4_t_2 sincos_floats;
#ifdef TFA_EXACT
#define SINCOS_DOUBLES Sleef_cinz_sincosd2_u10advsimdnofma
#define SINCOS_FLOATS Sleef_cinz_sincosf4_u10advsimdnofma
#else
#define SINCOS_DOUBLES Sleef_finz_sincosd2_u10advsimd
#define SINCOS_FLOATS Sleef_finz_sincosf4_u10advsimd
#endif
#else
typedef Sleef___m128d_2 sincos_doubles;
typedef Sleef___m128_2 sincos_floats;
#define SINCOS_DOUBLES Sleef_cinz_sincosd2_u10sse2
#define SINCOS_FLOATS Sleef_cinz_sincosf4_u10sse2
#endif

/* Of x[first] .. x[end - 1]; whole vectors are read and written, from the one that holds
 * `first`. */
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

/* The `count` numbers from x on and zeros behind them, at most a vector of them: no others are
 * read, nor do they have to come from memory as they were written, one by one. */
#if defined(__AVX512F__)
static inline __m512d sincos_load_masked(const double *x, size_t count)
{
    return _mm512_maskz_loadu_pd((__mmask8)(0xffu >> (count < 8 ? 8 - count : 0)), x);
}
#elif defined(__AVX2__)
static inline __m256d sincos_load_masked(const double *x, size_t count)
{
    static const int64_t mask[8] = {-1, -1, -1, -1, 0, 0, 0, 0};
    const size_t skipped = count < 4 ? 4 - count : 0;
    return _mm256_maskload_pd(x, _mm256_loadu_si256((const __m256i *)(mask + skipped)));
}
#elif defined(__ARM_NEON)
static inline float64x2_t sincos_load_masked(const double *x, size_t count)
{
    return count < 2 ? vcombine_f64(vld1_f64(x), vdup_n_f64(0)) : vld1q_f64(x);
}
#else
static inline __m128d sincos_load_masked(const double *x, size_t count)
{
    return count < 2 ? _mm_load_sd(x) : _mm_loadu_pd(x);
}
#endif

/* Of x[0] .. x[count - 1], which need not end on a whole vector; whole ones are written. */
static inline void sincos_f64_unpadded(const double *x, double *s, double *c, size_t count)
{
    sincos_doubles p;
    const size_t lanes = sizeof p.x / sizeof *x;
    for (size_t k = 0; k < count; k += lanes) {
        p = SINCOS_DOUBLES(sincos_load_masked(x + k, count - k));
        memcpy(s + k, &p.x, sizeof p.x);
        memcpy(c + k, &p.y, sizeof p.y);
    }
}
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

static inline void sincos_f64_unpadded(const double *x, double *s, double *c, size_t count)
{
    sincos_f64(x, s, c, 0, count);
}
#endif

#endif
