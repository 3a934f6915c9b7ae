/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Whether this processor has the features that the flags of this variant allow.
 */
#ifndef TFA_DYNAMICS_CPU_H
#define TFA_DYNAMICS_CPU_H

/* Exactly the features that the flags of this variant allow. */
static int tfa_cpu_supported(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
#if defined(__AVX512F__)
    if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512vl") ||
        !__builtin_cpu_supports("avx512dq") || !__builtin_cpu_supports("avx512bw"))
        return 0;
#endif
#if defined(__AVX2__)
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
        return 0;
#endif
#endif
    return 1;
}

#define TFA_STRING_EXPAND(x) #x
#define TFA_STRING(x) TFA_STRING_EXPAND(x)

#endif
