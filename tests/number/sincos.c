/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sines and cosines (number/sincos.h) against quadruple precision, at most 1.1 units in the last
 * place, and the same bits in every lane. Compiled for each instruction set, with and without fused
 * products, and with sums reordered.
 */
#include "number/sincos.h"

#include <sys/mman.h>

#include "dynamics/cpu.h"
#include "model/quad.h"
#include "test.h"

#ifndef ZEROS_HAVE_NO_SIGN /* as with -fno-signed-zeros */
#define ZEROS_HAVE_NO_SIGN 0
#endif

enum { MANY = 64, ROUNDS = TEST_ROUNDS(4000), PAGE = 65536 };

/* The end of memory that can be read */
static char *readable_end(void)
{
    static char *end;
    if (!end) {
        char *pages =
            mmap(NULL, 2 * PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        assert_true(pages != MAP_FAILED);
        end = pages + PAGE;
        assert_int_equal(mprotect(end, PAGE, PROT_NONE), 0);
    }
    return end;
}

static uint64_t random_bits(void)
{
    static uint64_t x = 88172645463325252u;
    x ^= x << 13, x ^= x >> 7;
    return x ^= x << 17;
}

/* Random numbers up to the limit, 4 and 1e-3; multiples of pi/2 and the double next to one of those
 * up to 2^15 */
static double angle(uint32_t kind, double limit)
{
    const double u = (double)(random_bits() >> 11) * 0x1p-53;
    const double worst = ldexp(0x1.6c6cbc45dc8dep5, (int)(random_bits() % 10));
    if (kind == 0)
        return (2 * u - 1) * limit;
    if (kind == 1)
        return (2 * u - 1) * 4;
    if (kind == 2)
        return floor((2 * u - 1) * limit / 1.6) * 0x1.921fb54442d18p0;
    return kind == 3 && worst < limit ? worst : u * 1e-3;
}

static double ulps(tfa_quad got, tfa_quad wanted, int digits)
{
    int e;
    frexp((double)wanted, &e);
    const tfa_quad error = (got - wanted) / ldexp(1, e - digits);
    return (double)(error < 0 ? -error : error);
}

/* The checks are functions of their own: compilers move instructions of the set before a question
 * whether the processor has it. */
static void where_supported(void (*check)(void))
{
    if (!tfa_cpu_supported())
        skip();
    check();
}

#define LAW(type, real, libm, digits, limit)                                                       \
    static __attribute__((noinline)) void check_ulps_##type(void)                                  \
    {                                                                                              \
        real x[MANY], s[MANY], c[MANY], s1[MANY], c1[MANY];                                        \
        double most = 0;                                                                           \
        for (uint32_t round = 0; round < ROUNDS; round++) {                                        \
            for (uint32_t k = 0; k < MANY; k++)                                                    \
                x[k] = (real)angle((round + k) % 5, limit);                                        \
            const uint32_t count = 1 + round % 40;                                                 \
            sincos_##type(x, s, c, 0, MANY);                                                       \
            real *last = (real *)(void *)readable_end() - count;                                   \
            memcpy(last, x + 7, count * sizeof *x);                                                \
            s1[count] = 2; /* 16: the most lanes */                                                \
            sincos_unpadded_##type(last, s1, c1, count);                                           \
            assert_true(count < 16 || s1[count] == 2);                                             \
            assert_memory_equal(s1, s + 7, count * sizeof *s);                                     \
            assert_memory_equal(c1, c + 7, count * sizeof *c);                                     \
            for (uint32_t k = 0; k < MANY; k++) {                                                  \
                tfa_quad sine, cosine;                                                             \
                TFA_QUAD_SINCOS(x[k], &sine, &cosine);                                             \
                most = fmax(most, fmax(ulps(s[k], sine, digits), ulps(c[k], cosine, digits)));     \
            }                                                                                      \
        }                                                                                          \
        printf("%d angles: at most %.3f ulp\n", ROUNDS *MANY, most);                               \
        assert_true(most <= 1.1);                                                                  \
    }                                                                                              \
    /* Beside a NaN, too; all others as if they were alone */                                      \
    static __attribute__((noinline)) void check_large_angles_##type(void)                          \
    {                                                                                              \
        real x[MANY], s[MANY], c[MANY], one[MANY], two[MANY];                                      \
        const real odd[] = {-(real)0,                                                              \
                            (real)NAN,                                                             \
                            (real)1e30,                                                            \
                            (real)-1e12,                                                           \
                            (real)INFINITY,                                                        \
                            (real)(limit),                                                         \
                            (real)(limit * 1.0001),                                                \
                            (real)(-limit * 1.0001),                                               \
                            0,                                                                     \
                            1};                                                                    \
        for (uint32_t shift = 0; shift < MANY; shift++) {                                          \
            for (uint32_t k = 0; k < MANY; k++)                                                    \
                x[k] = (k + shift) % 11 < 10 ? odd[(k + shift) % 11] : (real)0.5;                  \
            sincos_##type(x, s, c, 0, MANY);                                                       \
            for (uint32_t k = 0; k < MANY; k++) {                                                  \
                sincos_unpadded_##type(x + k, one, two, 1);                                        \
                if (!(fabs((double)x[k]) <= limit))                                                \
                    libm(x[k], one, two);                                                          \
                assert_true(isnan(one[0]) ? isnan(s[k]) && isnan(c[k])                             \
                                          : one[0] == s[k] && two[0] == c[k]);                     \
                assert_true(x[k] != 0 || ZEROS_HAVE_NO_SIGN || signbit(s[k]) == signbit(x[k]));    \
                assert_true(x[k] != 0 || (s[k] == 0 && c[k] == 1));                                \
            }                                                                                      \
        }                                                                                          \
    }                                                                                              \
    TEST(sines_are_within_1_1_ulp_##type)                                                          \
    {                                                                                              \
        where_supported(check_ulps_##type);                                                        \
    }                                                                                              \
    TEST(large_angles_are_those_of_libm_and_zeros_keep_their_sign_##type)                          \
    {                                                                                              \
        where_supported(check_large_angles_##type);                                                \
    }
LAW(f64, double, sincos, 53, 0x1p15)
LAW(f32, float, sincosf, 24, 0x1p6)
