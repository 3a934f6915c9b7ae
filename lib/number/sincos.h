/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sines and cosines of many numbers, as many at a time as the instruction set has lanes: at most
 * 1.1 units in the last place (tests/number/sincos.c), the same bits in every lane, and with
 * TFA_EXACT by every instruction set. Up to a limit, 2^15 and 64, by reduction to x - n pi/2 and
 * polynomials (sincos_vector.h); libm beyond. 7 angles by avx2: about 120 instructions. Products
 * are fused here on their own, whatever -ffp-contract says: kernels of single robots are compiled
 * without.
 */
#ifndef TFA_NUMBER_SINCOS_H
#define TFA_NUMBER_SINCOS_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* By instruction set: bytes of a vector, the signs of its lanes as an integer that is 0 where none
 * is set, and a b + c with one rounding where there is one. */
#if defined(__AVX512F__)
#include <immintrin.h>
#define SINCOS_BYTES 64
#define sincos_signs_f64(x) _mm512_movepi64_mask((__m512i)(x))
#define sincos_signs_f32(x) _mm512_movepi32_mask((__m512i)(x))
#define sincos_fused_f64 _mm512_fmadd_pd
#define sincos_fused_f32 _mm512_fmadd_ps
#define SINCOS_FUSES
#define SINCOS_REGISTER "+v"
#elif defined(__AVX2__)
#include <immintrin.h>
#define SINCOS_BYTES 32
#define sincos_signs_f64(x) _mm256_movemask_pd((__m256d)(x))
#define sincos_signs_f32(x) _mm256_movemask_ps((__m256)(x))
#define sincos_fused_f64 _mm256_fmadd_pd
#define sincos_fused_f32 _mm256_fmadd_ps
#define SINCOS_FUSES
#define SINCOS_REGISTER "+x"
#elif defined(__x86_64__)
#include <immintrin.h>
#define SINCOS_BYTES 16
#define sincos_signs_f64(x) _mm_movemask_pd((__m128d)(x))
#define sincos_signs_f32(x) _mm_movemask_ps((__m128)(x))
#define SINCOS_REGISTER "+x"
#elif defined(__aarch64__)
#include <arm_neon.h>
#define SINCOS_BYTES 16
#define sincos_signs_f64(x) (vmaxvq_u32((uint32x4_t)(x)) >> 31)
#define sincos_signs_f32(x) (vmaxvq_u32((uint32x4_t)(x)) >> 31)
#define sincos_fused_f64(a, b, c) vfmaq_f64(c, a, b)
#define sincos_fused_f32(a, b, c) vfmaq_f32(c, a, b)
#define SINCOS_FUSES
#define SINCOS_REGISTER "+w"
#else
#error "vectors of this processor are missing here"
#endif

/* pi/2 in three parts; of the first two, products with n up to the limit are exact. SINE, COSINE:
 * (r - sin r) / r^3 and (cos r - 1 + r^2 / 2) / r^4 in r^2, highest power first. */
#define SINCOS(name) name##_f64
#define SINCOS_REAL double
#define SINCOS_BITS int64_t
#define SINCOS_SIGN INT64_MIN
#define SINCOS_LIBM sincos
#define SINCOS_LIMIT 0x1p15
#define SINCOS_ROUND 0x1.8p52
#define SINCOS_PIO2(part) part(0x1.921fb5444p+0, 0x1.68c234c4cp-39, 0x1.98a2e03707345p-77)
#define SINCOS_SINE(each)                                                                          \
    each(-1.58962301576546568060e-10), each(2.50507477628578072866e-8),                            \
        each(-2.75573136213857245213e-6), each(1.98412698295895385996e-4),                         \
        each(-8.33333333332211858878e-3), each(1.66666666666666307295e-1)
#define SINCOS_COSINE(each)                                                                        \
    each(-1.13585365213876817300e-11), each(2.08757008419747316778e-9),                            \
        each(-2.75573141792967388112e-7), each(2.48015872888517045348e-5),                         \
        each(-1.38888888888730564116e-3), each(4.16666666666665929218e-2)
#include "number/sincos_vector.h"

#define SINCOS(name) name##_f32
#define SINCOS_REAL float
#define SINCOS_BITS int32_t
#define SINCOS_SIGN INT32_MIN
#define SINCOS_LIBM sincosf
#define SINCOS_LIMIT 0x1p6f
#define SINCOS_ROUND 0x1.8p23f
#define SINCOS_PIO2(part) part(0x1.921f8p+0f, 0x1.aa22p-19f, 0x1.68c234p-39f)
#define SINCOS_SINE(each) each(1.9515295891e-4f), each(-8.3321608736e-3f), each(1.6666654611e-1f)
#define SINCOS_COSINE(each)                                                                        \
    each(2.443315711809948e-5f), each(-1.388731625493765e-3f), each(4.166664568298827e-2f)
#include "number/sincos_vector.h"

#undef SINCOS_FUSES
#undef SINCOS_BYTES
#undef SINCOS_REGISTER

#endif
