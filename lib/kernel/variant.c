/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The one symbol that a compiled variant offers to the rest of the library.
 */
#include "kernel/cpu.h"
#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/table.h"

static size_t size(const tfa_model *model)
{
    struct state *none;
    return state_walk(model, NULL, &none);
}

static struct state *init(const tfa_model *model, void *memory)
{
    struct state *s = state_init(model, memory);
    TFA_V(tfa_bake)(s);
    return s;
}

static void load(struct state *s, const tfa_request *request, uint32_t k)
{
    TFA_V(load)(s, request, k, 1);
}

static void widen(struct state *s, const struct tfa_wider *wider)
{
    s->wider = wider;
}

const struct tfa_kernel TFA_V(kernel) = {
    .isa = TFA_STRING(TFA_ISA_NAME),
    .precision = TFA_PRECISION,
    .supported = tfa_cpu_supported,
    .size = size,
    .init = init,
    .answer = TFA_V(answer),
    .widen = widen,
    .load = load,
    .add = TFA_V(wider_add),
    .residual = TFA_V(wider_residual),
    .unload = TFA_V(unload_qdd),
};
