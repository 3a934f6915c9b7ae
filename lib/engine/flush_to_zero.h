/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flush to zero: while a request is computed, subnormal numbers (below 2.3e-308) count as zero,
 * operands and results. Processors take such operations out of their pipelines: a state of products
 * below that took a humanoid's ABA 45 us in place of 5.5, CRBA 136 in place of 8 (Intel Xeon,
 * 2026-11-28), and no bound of a worker's time would hold. The caller's mode is put back.
 *
 * Quadruple precision is software and keeps them.
 */
#ifndef TFA_LIB_ENGINE_FLUSH_TO_ZERO_H
#define TFA_LIB_ENGINE_FLUSH_TO_ZERO_H

#include <stdint.h>

#if defined(__x86_64__)
#define FLUSH_BITS 0x8040u /* MXCSR: FTZ, DAZ */
static inline uint64_t float_mode(void)
{
    return __builtin_ia32_stmxcsr();
}
static inline void set_float_mode(uint64_t mode)
{
    __builtin_ia32_ldmxcsr((unsigned)mode);
}
#elif defined(__aarch64__)
#define FLUSH_BITS (1u << 24) /* FPCR: FZ */
static inline uint64_t float_mode(void)
{
    uint64_t mode;
    __asm__ volatile("mrs %0, fpcr" : "=r"(mode));
    return mode;
}
static inline void set_float_mode(uint64_t mode)
{
    __asm__ volatile("msr fpcr, %0" : : "r"(mode) : "memory");
}
#else
#define FLUSH_BITS 0u
static inline uint64_t float_mode(void)
{
    return 0;
}
static inline void set_float_mode(uint64_t mode)
{
    (void)mode;
}
#endif

/** @return what tfa_flush_end takes */
static inline uint64_t tfa_flush_begin(void)
{
    const uint64_t before = float_mode();
    if ((before & FLUSH_BITS) != FLUSH_BITS)
        set_float_mode(before | FLUSH_BITS);
    return before;
}

static inline void tfa_flush_end(uint64_t before)
{
    if ((before & FLUSH_BITS) != FLUSH_BITS)
        set_float_mode(before);
}

#endif
