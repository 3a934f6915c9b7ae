/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sines and cosines of many doubles by SLEEF, as many at a time as the instruction set has lanes. Its
 * error is below 1 unit in the last place for every angle (glibc: 0.55). Without SLEEF one by one.
 */
#ifndef TFA_VARIANTS_SINCOS_F64_H
#define TFA_VARIANTS_SINCOS_F64_H

#include <math.h>
#include <stddef.h>

#ifdef TFA_SLEEF
#include <sleef.h>
#include <string.h>

/* 7 angles: 150 ns by glibc one by one, 36 by two calls of avx2, 20 by one of avx512. Measured
 * 2026-11-22 on an Intel Xeon (AVX-512) VM, random angles up to 3 rad. */
#if defined(__AVX512F__)
typedef Sleef___m512d_2 sincos_pairs;
#define SINCOS_PAIRS Sleef_finz_sincosd8_u10avx512f
#elif defined(__AVX2__)
typedef Sleef___m256d_2 sincos_pairs;
#define SINCOS_PAIRS Sleef_finz_sincosd4_u10avx2
#else
typedef Sleef___m128d_2 sincos_pairs;
#define SINCOS_PAIRS Sleef_cinz_sincosd2_u10sse2
#endif

/* Of x[first] .. x[end - 1]; whole vectors are read and written, from the one that holds `first`. */
static inline void sincos_f64(const double *x, double *s, double *c, size_t first, size_t end)
{
    sincos_pairs p;
    const size_t lanes = sizeof p.x / sizeof *x;
    for (size_t k = first / lanes * lanes; k < end; k += lanes) {
        memcpy(&p.x, x + k, sizeof p.x);
        p = SINCOS_PAIRS(p.x);
        memcpy(s + k, &p.x, sizeof p.x);
        memcpy(c + k, &p.y, sizeof p.y);
    }
}
#else
static inline void sincos_f64(const double *x, double *s, double *c, size_t first, size_t end)
{
    for (size_t k = first; k < end; k++)
        sincos(x[k], &s[k], &c[k]);
}
#endif

#endif
