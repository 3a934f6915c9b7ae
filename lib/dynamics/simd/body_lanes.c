/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward and inverse dynamics of one state with its independent branches in SIMD lanes: the same
 * sources as for one body after the other, and the same answers to the bit. Tips use these factors.
 */
#include <math.h>

#include "dynamics/core/recursions.h"
#include "dynamics/core/sentinel.h"
#include "dynamics/simd/body_lanes_init.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/norm.h"
#include "interface/kernel_table.h"
#include "layout/parent_transfer.h"
#include "layout/schedule_body_lanes.h"

/* Time for a step against that for one body, a chain of 64 in one lane: 1.5 with two lanes of SSE2,
 * 1.6 with four of AVX2, 1.4 with four and 2.1 with eight of AVX-512. Measured 2026-11-22 on an AMD
 * EPYC (Zen 5) VM; a humanoid of 47 bodies in 14 steps took 0.43 of its time, 20 bodies' worth. */
#define STEP_COST (NUM_LANES > 4 ? 2.1 : 1.5)

static size_t size(const tfa_model *model, const struct tfa_lane_schedule *schedule)
{
    struct state *none;
    return state_walk(model, TFA_V(body_lanes_extent)(model, schedule), NULL, &none);
}

/* 1: the answer takes what the inward pass leaves of forces */
static inline int leaves_forces(const tfa_request *r)
{
    return (TFA_OP_BIT(r->op) & (TFA_OPS_TASK | TFA_OPS_CONSTRAINED_FD)) != 0;
}

static int body_lanes_answer(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    TFA_V(load)(s, r, k, 1);
    if (r->op == TFA_OP_INVERSE_DYNAMICS)
        return TFA_V(inverse_dynamics)(s, k, reply) ? TFA_ANSWERED : TFA_NOT_ANSWERED;
    if (r->op == TFA_OP_OPERATIONAL_INERTIA) {
        TFA_V(aba_factor)(s);
        return sentinel_trips(s) ? TFA_ANSWERED_SENTINEL : TFA_ANSWERED;
    }
    const int only_forces = leaves_forces(r);
    TFA_V(aba)(s, s->tau, only_forces ? NULL : s->qdd);
    if (!only_forces && !TFA_V(unload_qdd)(s, k, reply))
        return TFA_NOT_ANSWERED;
    return sentinel_trips(s) ? TFA_ANSWERED_SENTINEL : TFA_ANSWERED;
}

/* |x|, summed up in the order of the bodies as for one body at a time */
static double norm_of(struct state *s, const num *x)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t e = 0; e < m->body[i].n; e++) {
            const num lanes = x[s->lane_constants[s->step_of[i]].v + e];
            s->in_body_order[m->body[i].v + e] = num_of(num_lane(lanes, s->lane_of[i]));
        }
    return norm(s->in_body_order, m->freedoms).lane[0];
}

/* |M^-1 (tau - RNEA(qdd))|, the residual perturbed or not */
static double correction(struct state *s, int perturbed)
{
    if (perturbed)
        TFA_V(rnea_perturbed)(s, s->qdd, s->res, 1);
    else
        TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < s->freedoms; j++) {
        const num rest = s->tau[j] - s->res[j], e = perturbed * NUM_EPSILON * num_abs(s->tau[j]);
        s->res[j] = rest + num_select(rest < 0, -e, e);
    }
    TFA_V(aba_solve)(s, s->res, s->dx);
    return norm_of(s, s->dx);
}

/* As refine.c: the larger correction over |qdd| */
static int estimate(struct state *s, double limit, tfa_answer *answer)
{
    const double size = norm_of(s, s->qdd), perturbed = correction(s, 1), plain = correction(s, 0);
    const double change = plain > perturbed ? plain : perturbed;
    const double estimate = ESTIMATE_SAFETY * (size > 0 ? change / size : change);
    const double world = s->boosted ? norm_of(s, TFA_V(world_accelerations)(s)) : size;
    answer->error_estimate = estimate_in_world(estimate, size, world);
    answer->flags |= TFA_ANSWER_ESTIMATED;
    return estimate <= limit;
}

/* Lane l of n numbers, from memory: through vectors it would take longer. */
static inline void copy_lane(void *out, const num *from, uint32_t n, uint32_t l)
{
    const aliased_double *x = (const aliased_double *)from + l;
    double *to = out;
#pragma GCC unroll 12
    for (uint32_t e = 0; e < n; e++)
        to[e] = x[e * NUM_LANES];
}

/* H of joints that are not fused is constant, and only forces go past a base. */
static __attribute__((noinline)) void copy_joint_nd(const struct joint_nd *w,
                                                    const struct tfa_body *b, uint32_t l,
                                                    int forces, const struct tfa_factor_buffers *to)
{
    const size_t at = to->joint_nd_bytes * (size_t)b->joint_nd;
    if (forces)
        copy_lane(to->joint_nd_u + at, w->u, b->n, l);
    for (uint32_t k = 0; k < b->n; k++) {
        copy_lane((double *)(to->L + at) + 6 * k, w->L + 6 * k, 6, l);
        if (!b->base || forces)
            copy_lane((double *)(to->joint_nd_U + at) + 6 * k, w->U + 6 * k, 6, l);
        if (!is_fused(b->kind))
            continue;
        copy_lane((double *)(to->H + at) + 6 * k, w->H + 6 * k, 6, l);
        copy_lane((double *)(to->part + at) + 12 * k, &w->part[k].E.xx, 12, l);
    }
}

static inline void copy_body(const struct state *s, uint32_t i, int forces,
                             const struct tfa_factor_buffers *to)
{
    const struct tfa_body *b = &s->m->body[i];
    const uint32_t k = s->step_of[i], l = s->lane_of[i];
    copy_lane((double *)to->X + 12 * (size_t)i, &s->X[k].E.xx, 12, l);
    if (forces)
        copy_lane((double *)to->c + 6 * (size_t)i, &s->c[k].w.x, 6, l);
    if (b->n > 1) {
        copy_joint_nd(&s->joint_nd[b->joint_nd], b, l, forces, to);
        return;
    }
    copy_lane((double *)to->U + 6 * (size_t)i, &s->U[k].w.x, 6, l);
    copy_lane((double *)to->Dinv + i, &s->Dinv[k], 1, l);
    if (forces)
        copy_lane((double *)to->u + i, &s->u[k], 1, l);
}

/* Bodies that carry a tip or a frame of an active constraint. Returns their number. */
static uint32_t carriers_of(const struct tfa_model *m, const tfa_request *r,
                            int32_t out[2 * TFA_MAX_CONSTRAINTS])
{
    uint32_t n = 0;
    for (uint32_t t = 0; r->op != TFA_OP_CONSTRAINED_DYNAMICS && t < r->tip_count; t++)
        out[n++] = m->frame[r->tips[t]].body;
    for (uint32_t c = 0; r->op == TFA_OP_CONSTRAINED_DYNAMICS && c < m->constraints; c++)
        for (int side = 0; side < 2; side++)
            if (r->constraints >> c & 1 && m->closure[c].frame[side] >= 0)
                out[n++] = m->frame[m->closure[c].frame[side]].body;
    return n;
}

/* From each of these to the first body that was visited already */
#define FOR_EACH_CARRIER(m, r, i)                                                                  \
    uint8_t visited_[TFA_BODY_LANES_BODIES_MAX] = {0};                                             \
    int32_t carrier_[2 * TFA_MAX_CONSTRAINTS];                                                     \
    const uint32_t carriers_ = carriers_of(m, r, carrier_);                                        \
    for (uint32_t at_ = 0; at_ < carriers_; at_++)                                                 \
        for (int32_t i = carrier_[at_]; i >= 0 && !visited_[i];                                    \
             visited_[i] = 1, i = (m)->body[i].parent)

static void copy_tip_factors(const struct state *s, const tfa_request *r,
                             const struct tfa_factor_buffers *to)
{
    const int forces = leaves_forces(r);
    if (forces)
        *to->moving = s->moving;
    FOR_EACH_CARRIER(s->m, r, i)
    {
        copy_body(s, (uint32_t)i, forces, to);
    }
}

static int body_lanes_accelerate(struct state *s, const tfa_request *r,
                                 const struct tfa_factor_buffers *from, uint32_t k,
                                 tfa_reply *reply)
{
    FOR_EACH_CARRIER(s->m, r, i)
    {
        const struct tfa_body *b = &s->m->body[i];
        const uint32_t step = s->step_of[i];
        const double *u =
            b->n > 1
                ? (const double *)(from->joint_nd_u + from->joint_nd_bytes * (size_t)b->joint_nd)
                : (const double *)from->u + i;
        num *to = b->n > 1 ? s->joint_nd[b->joint_nd].u : &s->u[step];
        for (uint32_t l = 0; l < NUM_LANES; l++) /* idle lanes have it for their own branches */
            for (uint32_t e = 0;
                 s->lane_constants[step].lane_body.lane[l] == (uint32_t)i && e < b->n; e++)
                ((aliased_double *)(to + e))[l] = u[e];
    }
    TFA_V(aba_outward)(s, s->qdd);
    return TFA_V(unload_qdd)(s, k, reply);
}

static void copy_forces(struct state *s, const tfa_reply *reply,
                        const struct tfa_factor_buffers *to)
{
    TFA_V(load_accelerations)(s, reply->base_acceleration, reply->qdd);
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    *to->moving = s->moving;
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->m->body[i];
        const uint32_t k = s->step_of[i], l = s->lane_of[i];
        copy_lane((double *)to->X + 12 * (size_t)i, &s->X[k].E.xx, 12, l);
        copy_lane((double *)to->v + 6 * (size_t)i, &s->v[k].w.x, 6, l);
        copy_lane((double *)to->a + 6 * (size_t)i, &s->a[k].w.x, 6, l);
        copy_lane((double *)to->f + 6 * (size_t)i, &s->f[k].w.x, 6, l);
        if (is_fused(b->kind))
            copy_joint_nd(&s->joint_nd[b->joint_nd], b, l, 0, to);
    }
}

const struct tfa_body_lanes_kernel TFA_V(body_lanes) = {
    .lanes = NUM_LANES,
    .step = STEP_COST,
    .size = size,
    .init = TFA_V(body_lanes_init),
    .answer = body_lanes_answer,
    .estimate = estimate,
    .copy_factors = copy_tip_factors,
    .accelerate = body_lanes_accelerate,
    .copy_forces = copy_forces,
};
