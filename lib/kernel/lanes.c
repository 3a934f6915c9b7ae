/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of several states at a time, one in each lane: the same sources as for one state,
 * over a number type with lanes. What goes another way than aba's is left to one state at a time.
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

static int answer(struct state *s, const tfa_request *r, uint32_t k, uint32_t count,
                  tfa_reply *reply)
{
    TFA_V(load)(s, r, k, count);
    TFA_V(aba)(s, s->tau, s->qdd);
    return TFA_V(unload)(s, s->qdd,
                         reply->base_acceleration ? reply->base_acceleration + 6 * (size_t)k : NULL,
                         reply->qdd ? reply->qdd + (size_t)s->m->v_count * k : NULL);
}

const struct tfa_lanes TFA_V(lanes) = {
    .isa = TFA_STRING(TFA_ISA_NAME),
    .lanes = NUM_LANES,
    .supported = tfa_cpu_supported,
    .size = size,
    .init = state_init,
    .answer = answer,
};
