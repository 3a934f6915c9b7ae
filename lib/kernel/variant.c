/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The one symbol that a compiled variant offers to the rest of the library.
 */
#include <string.h>

#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/table.h"

/* Exactly the features that the flags of this variant allow. */
static int supported(void)
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

static size_t size(const tfa_model *model)
{
    struct state *none;
    return state_walk(model, NULL, &none);
}

static struct state *init(const tfa_model *model, void *memory)
{
    struct state *s;
    size_t bytes = size(model);
    memset(memory, 0, bytes);
    (void)state_walk(model, memory, &s);
    TFA_V(tfa_bake)(s);
    return s;
}

static void widen(struct state *s, const struct tfa_wider *wider)
{
    s->wider = wider;
}

#define TFA_STRING_EXPAND(x) #x
#define TFA_STRING(x) TFA_STRING_EXPAND(x)

const struct tfa_kernel TFA_V(kernel) = {
    .isa = TFA_STRING(TFA_ISA_NAME),
    .precision = TFA_PRECISION,
    .supported = supported,
    .size = size,
    .init = init,
    .answer = TFA_V(answer),
    .widen = widen,
    .load = TFA_V(load),
    .add = TFA_V(wider_add),
    .residual = TFA_V(wider_residual),
    .unload = TFA_V(unload_qdd),
};
