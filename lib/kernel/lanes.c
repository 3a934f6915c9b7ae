/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Several states at a time, one in each lane: the same sources as for one state, over a number type
 * with lanes. What decides by a state's numbers is done for all of them or not at all: those that
 * would not go the same way, and those one of which has no answer, are left to one state at a time.
 */
#include "kernel/cpu.h"
#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/table.h"

static size_t size(const tfa_model *model, uint32_t methods)
{
    struct state *none;
    return state_walk(model, model_extent(model, methods & ~TFA_METHOD_BIT(TFA_METHOD_HESSENBERG)),
                      NULL, &none);
}

static struct state *init(const tfa_model *model, uint32_t methods, void *memory)
{
    struct state *s = state_init(
        model, model_extent(model, methods & ~TFA_METHOD_BIT(TFA_METHOD_HESSENBERG)), memory);
    TFA_V(tfa_bake)(s);
    return s;
}

/* Not the method that keeps O(N^2) numbers. Nor the scans, whose segments
 * fill lanes themselves (strips.h), nor tips, whose six wrenches do (six.h): gcc fuses their products in
 * another way over vectors, and answers would differ from those of one state at a time in the last bit (seen
 * with one state of 19 of a chain of 20 bodies, and with a tip on one joint; gcc 12, 2026-11-22). */
static int takes(const tfa_request *r)
{
    return r->op != TFA_OP_OPERATIONAL_INERTIA && !r->tip_count &&
           r->method != TFA_METHOD_HESSENBERG && r->method != TFA_METHOD_SCAN &&
           r->method != TFA_METHOD_SCAN_TWO_PASS;
}

static int answer(struct state *s, const tfa_request *r, uint32_t k, uint32_t count,
                  tfa_reply *reply, tfa_answer *answers)
{
    return TFA_V(answer)(s, r, k, count, reply, answers) == TFA_OK && !s->apart;
}

const struct tfa_lanes TFA_V(lanes) = {
    .isa = TFA_STRING(TFA_ISA_NAME),
    .precision = TFA_PRECISION,
    .lanes = NUM_LANES,
    .supported = tfa_cpu_supported,
    .size = size,
    .init = init,
    .takes = takes,
    .answer = answer,
};
