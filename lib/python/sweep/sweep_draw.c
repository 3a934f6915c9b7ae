/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Draws states. A number is mix(key(seed, state) + counter) with the finaliser of splitmix64
 * (Steele, Lea, Flood, OOPSLA 2014; Stafford's variant 13), which vectorises: two multiplications,
 * no carried state. Compiled without fused operations, so that every machine has the same bits.
 */
#include "sweep_states.h"

#include <math.h>
#include <string.h>

#define GOLDEN UINT64_C(0x9e3779b97f4a7c15)

static inline uint64_t mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Mixed twice: seeds that differ by one have nothing in common. */
static inline uint64_t key_of(uint64_t seed_key, uint64_t state)
{
    return mix(seed_key + state * GOLDEN);
}

/* Uniform in [0, 1), 52 bits: the mantissa of a number in [1, 2) */
static inline double unit(uint64_t bits)
{
    double value;
    bits = bits >> 12 | UINT64_C(0x3ff0000000000000);
    memcpy(&value, &bits, sizeof value);
    return value - 1.0;
}

/* One body for several instruction sets */
static inline __attribute__((always_inline)) void draw(const state_record *r, uint64_t seed_key,
                                                       uint64_t first, uint32_t count, double *out)
{
    const uint64_t *restrict counter = r->counter;
    const double *restrict low = r->low, *restrict span = r->span;
    const uint32_t width = r->width;
    for (uint32_t s = 0; s < count; s++) {
        const uint64_t key = key_of(seed_key, first + s);
        double *restrict to = out + (size_t)s * width;
        for (uint32_t c = 0; c < width; c++)
            to[c] = low[c] + span[c] * unit(mix(key + counter[c]));
    }
}

typedef void draw_function(const state_record *r, uint64_t seed_key, uint64_t first, uint32_t count,
                           double *out);

static void draw_base(const state_record *r, uint64_t seed_key, uint64_t first, uint32_t count,
                      double *out)
{
    draw(r, seed_key, first, count, out);
}

#if defined(__x86_64__)
__attribute__((target("avx512f,avx512dq,avx512vl"))) static void
draw_avx512(const state_record *r, uint64_t seed_key, uint64_t first, uint32_t count, double *out)
{
    draw(r, seed_key, first, count, out);
}

__attribute__((target("avx2"))) static void draw_avx2(const state_record *r, uint64_t seed_key,
                                                      uint64_t first, uint32_t count, double *out)
{
    draw(r, seed_key, first, count, out);
}
#endif

static draw_function *best_draw(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return draw_avx512;
    if (__builtin_cpu_supports("avx2"))
        return draw_avx2;
#endif
    return draw_base;
}

/* Uniform on the sphere: points of the cube outside of the ball are drawn again (Marsaglia 1972).
 * Square roots and divisions are rounded alike on every machine, sines are not. */
static void draw_quaternion(uint64_t key, uint64_t counter, double *quaternion)
{
    enum { TRIES = 64 }; /* 0.69^64: never */
    for (uint64_t k = 1; k <= TRIES; k++) {
        double square = 0, at[4];
        for (uint64_t i = 0; i < 4; i++) {
            at[i] = 2.0 * unit(mix(key + counter + ((4 * k + i) << 32) * GOLDEN)) - 1.0;
            square += at[i] * at[i];
        }
        if (square > 1.0 || square < 0.01)
            continue;
        const double norm = sqrt(square);
        for (int i = 0; i < 4; i++)
            quaternion[i] = at[i] / norm;
        return;
    }
    memcpy(quaternion, (const double[4]){0, 0, 0, 1}, 4 * sizeof *quaternion);
}

void state_record_draw(const state_record *r, uint64_t seed, uint64_t first, uint32_t count,
                       double *out)
{
    const uint64_t seed_key = mix(seed + GOLDEN);
    best_draw()(r, seed_key, first, count, out);
    for (uint32_t s = 0; r->quaternion_count && s < count; s++)
        for (uint32_t k = 0; k < r->quaternion_count; k++) {
            const uint32_t at = r->quaternion[k];
            draw_quaternion(key_of(seed_key, first + s), r->counter[at],
                            out + (size_t)s * r->width + at);
        }
}
