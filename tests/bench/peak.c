/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "peak.h"

#include <string.h>

#include "timing.h"

#define TURNS 20000

/* Twelve chains: two operations at a time, each known after four cycles, leave room for four more.
 * One variable each: an array would be kept in memory. */
#define CHAINS 12
#define EACH(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11)
#define START(k) vec x##k = a * (real_of)k;
#define STEP(k) x##k = x##k * a + b;
#define STAY(k) __asm__ volatile("" : KEEP(x##k));

/* x <- x a + b; nothing may leave its register or the loop. */
#define PEAK(name, real, bytes, features)                                                          \
    features static double name(void)                                                              \
    {                                                                                              \
        typedef real real_of;                                                                      \
        typedef real vec __attribute__((vector_size(bytes)));                                      \
        const vec a = (vec){0} + (real)0.999, b = (vec){0} + (real)0.001;                          \
        EACH(START)                                                                                \
        const double start = cpu_ns();                                                             \
        for (int turn = 0; turn < TURNS; turn++) {                                                 \
            EACH(STEP)                                                                             \
            EACH(STAY)                                                                             \
        }                                                                                          \
        const double ns = cpu_ns() - start;                                                        \
        return 2.0 * CHAINS * TURNS * (double)((bytes) / sizeof(real)) / ns;                       \
    }

#if defined(__x86_64__)
#define KEEP(x) "+x"(x)
#define AVX2 __attribute__((target("avx2,fma")))
#define AVX512 __attribute__((target("avx2,fma,avx512f,avx512vl,avx512dq,avx512bw")))
PEAK(peak_f64_avx2, double, 32, AVX2)
PEAK(peak_f32_avx2, float, 32, AVX2)
#undef KEEP
#define KEEP(x) "+v"(x)
PEAK(peak_f64_avx512, double, 64, AVX512)
PEAK(peak_f32_avx512, float, 64, AVX512)
#undef KEEP
#define KEEP(x) "+x"(x)
#else
#define KEEP(x) "+w"(x)
#endif
PEAK(peak_f64_base, double, 16, )
PEAK(peak_f32_base, float, 16, )

double peak_flops(const char *isa, int floats)
{
#if defined(__x86_64__)
    if (strcmp(isa, "avx512") == 0)
        return floats ? peak_f32_avx512() : peak_f64_avx512();
    if (strcmp(isa, "avx2") == 0)
        return floats ? peak_f32_avx2() : peak_f64_avx2();
#endif
    (void)isa;
    return floats ? peak_f32_base() : peak_f64_base();
}
