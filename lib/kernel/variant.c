/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The one symbol that a compiled variant offers to the rest of the library.
 */
#include "kernel/cpu.h"
#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/table.h"
#include "variants/sincos.h"

static size_t size(const tfa_model *model, uint32_t methods)
{
    struct state *none;
    return state_walk(model, model_extent(model, methods), NULL, &none);
}

static struct state *init(const tfa_model *model, uint32_t methods, void *memory)
{
    struct state *s = state_init(model, model_extent(model, methods), memory);
    TFA_V(tfa_bake)(s);
    return s;
}

static int answer(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply,
                  tfa_answer *answer_of)
{
    return TFA_V(answer)(s, request, k, 1, reply, answer_of);
}

static void load(struct state *s, const tfa_request *request, uint32_t k)
{
    TFA_V(load)(s, request, k, 1);
}

static void sincos_of_doubles(const double *x, double *sine, double *cosine, size_t count)
{
    sincos_f64_some(x, sine, cosine, count);
}

static void employ(struct state *s, struct tfa_crew *crew)
{
    s->crew = crew;
}

static void round_sincos(struct state *s)
{
    s->round_sincos = 1;
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
    .answer = answer,
    .sincos = sincos_of_doubles,
    .lend = TFA_V(lend),
    .answer_tips = TFA_V(answer_tips),
    .estimate = TFA_V(estimate_forward),
    .employ = employ,
    .round_sincos = round_sincos,
    .strips_bytes = TFA_V(strips_bytes),
    .strips_travel = TFA_V(strips_travel),
    .strips_join = TFA_V(strips_join),
    .strips_pass = TFA_V(strips_pass),
    .strips_close = TFA_V(strips_close),
    .widen = widen,
    .load = load,
    .add = TFA_V(wider_add),
    .residual = TFA_V(wider_residual),
    .unload = TFA_V(unload_qdd),
};
