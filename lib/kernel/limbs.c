/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of one state with its independent limbs in the lanes: the same sources as for one
 * body after the other, and the same answers to the bit. Tips have their factors from there.
 */
#include <math.h>

#include "kernel/answer.h"
#include "kernel/join.h"
#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/norm.h"
#include "kernel/packed.h"
#include "kernel/sentinel.h"
#include "kernel/table.h"
#include "plan/limbs.h"

/* Time for a step against that for one body, a chain of 64 in one lane: 1.5 with two lanes of SSE2,
 * 1.6 with four of AVX2, 1.4 with four and 2.1 with eight of AVX-512. Measured 2026-11-22 on an AMD EPYC
 * (Zen 5) VM; a humanoid of 47 bodies in 14 steps took 0.43 of its time, 20 bodies' worth. */
#define STEP (NUM_LANES > 4 ? 2.1 : 1.5)

static size_t size(const tfa_model *model, const struct tfa_packing *packing)
{
    struct state *none;
    return state_walk(model, TFA_V(packed_extent)(model, packing), NULL, &none);
}

static int answer(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    TFA_V(load)(s, r, k, 1);
    if (r->op == TFA_OP_OPERATIONAL_INERTIA) {
        TFA_V(aba_factor)(s);
        return sentinel_trips(s) ? TFA_ANSWERED_ALARMED : TFA_ANSWERED;
    }
    TFA_V(aba)(s, s->tau, s->qdd);
    if (!TFA_V(unload)(s, s->qdd,
                       reply->base_acceleration ? reply->base_acceleration + 6 * (size_t)k : NULL,
                       reply->qdd ? reply->qdd + (size_t)s->m->v_count * k : NULL))
        return TFA_NOT_ANSWERED;
    return sentinel_trips(s) ? TFA_ANSWERED_ALARMED : TFA_ANSWERED;
}

/* |x|, summed up in the order of the bodies as for one body at a time */
static double norm_of(struct state *s, const num *x)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t e = 0; e < m->body[i].n; e++) {
            const num lanes = x[s->packed[s->step_of[i]].v + e];
            s->inner[m->body[i].v + e] = num_of(num_lane(lanes, s->lane_of[i]));
        }
    return norm(s->inner, m->freedoms).lane[0];
}

/* As refine.c: |M^-1 (tau - RNEA(qdd))| / |qdd|, the residual perturbed */
static int estimate(struct state *s, double limit, tfa_answer *answer)
{
    TFA_V(rnea_perturbed)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < s->freedoms; j++) {
        const num rest = s->tau[j] - s->res[j], e = NUM_EPSILON * num_abs(s->tau[j]);
        s->res[j] = rest + num_select(rest < 0, -e, e);
    }
    TFA_V(aba_solve)(s, s->res, s->dx);
    const double size = norm_of(s, s->qdd), change = norm_of(s, s->dx);
    answer->error_estimate = ESTIMATE_SAFETY * (size > 0 ? change / size : change);
    answer->flags |= TFA_ANSWER_ESTIMATED;
    return answer->error_estimate <= limit;
}

/* Lane l of n numbers, from memory: by way of vectors it would take longer. */
static inline void give_lane(void *out, const num *from, uint32_t n, uint32_t l)
{
    const shared_double *x = (const shared_double *)from + l;
    double *to = out;
#pragma GCC unroll 12
    for (uint32_t e = 0; e < n; e++)
        to[e] = x[e * NUM_LANES];
}

/* H of joints that are not fused is constant, and nothing goes on past a base. */
static __attribute__((noinline)) void give_multi(const struct multi *w, const struct tfa_body *b,
                                                 uint32_t l, const struct tfa_factors *to)
{
    const size_t at = to->multi_bytes * (size_t)b->multi;
    for (uint32_t k = 0; k < b->n; k++) {
        give_lane((double *)(to->L + at) + 6 * k, w->L + 6 * k, 6, l);
        if (!b->base)
            give_lane((double *)(to->multi_U + at) + 6 * k, w->U + 6 * k, 6, l);
        if (!is_fused(b->kind))
            continue;
        give_lane((double *)(to->H + at) + 6 * k, w->H + 6 * k, 6, l);
        give_lane((double *)(to->part + at) + 12 * k, &w->part[k].E.xx, 12, l);
    }
}

static inline void give_body(const struct state *s, uint32_t i, const struct tfa_factors *to)
{
    const struct tfa_body *b = &s->m->body[i];
    const uint32_t k = s->step_of[i], l = s->lane_of[i];
    give_lane((double *)to->X + 12 * (size_t)i, &s->X[k].E.xx, 12, l);
    if (b->n > 1) {
        give_multi(&s->multi[b->multi], b, l, to);
        return;
    }
    give_lane((double *)to->U + 6 * (size_t)i, &s->U[k].w.x, 6, l);
    give_lane((double *)to->Dinv + i, &s->Dinv[k], 1, l);
}

/* From each tip to the first body that another tip has given already */
static void lend_factors(const struct state *s, const tfa_request *r, const struct tfa_factors *to)
{
    uint8_t given[TFA_LIMBS_BODIES_MAX] = {0};
    for (uint32_t t = 0; t < r->tip_count; t++)
        for (int32_t i = s->m->frame[r->tips[t]].body; i >= 0 && !given[i];
             i = s->m->body[i].parent) {
            give_body(s, (uint32_t)i, to);
            given[i] = 1;
        }
}

const struct tfa_limbs TFA_V(limbs) = {
    .lanes = NUM_LANES,
    .step = STEP,
    .size = size,
    .init = TFA_V(packed_init),
    .answer = answer,
    .estimate = estimate,
    .give = lend_factors,
};
