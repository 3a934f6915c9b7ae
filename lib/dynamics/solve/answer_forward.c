/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of one state: the method, refinement, estimate and fallback.
 */
#include <math.h>

#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/norm.h"
#include "dynamics/solve/refine.h"
#include "interface/kernel_table.h"
#include "interface/traits.h"

/* The estimates of s->qdd as those of the accelerations in the world */
static void store_estimate(const struct state *s, const tfa_request *r, num_doubles estimate,
                           tfa_answer *out)
{
    if (s->boosted) {
        const num_doubles boosted = norm(s->qdd, s->freedoms),
                          world = norm(TFA_V(world_accelerations)(s), s->freedoms);
        for (uint32_t l = 0; l < s->lanes; l++)
            estimate.lane[l] = estimate_in_world(estimate.lane[l], boosted.lane[l], world.lane[l]);
    }
    TFA_V(store_estimate)(s, r, &estimate, out);
}

/* By default an answer that the sentinel doubts is refined if its estimate, too, asks for it. */
static int doubt_is_confirmed(const tfa_request *r, const tfa_answer *out, uint32_t steps,
                              const struct refined *x)
{
    return out->flags & TFA_ANSWER_SENTINEL && r->refine == TFA_REFINE_DEFAULT && !steps &&
           !(x->estimate.lane[0] <= SENTINEL_ESTIMATE_MAX);
}

/* Refinement and estimate; while the estimate is too large, the answer of the next method, refined
 * as the first was. If the estimate is still too large, the residual kernel answers, where there is
 * one. A request without estimates gets the answer of the method. *valid:
 * TFA_V(estimate_is_valid). */
static tfa_method refine(struct state *s, const tfa_request *r, tfa_method method, uint32_t steps,
                         enum estimation estimation, int *valid, tfa_answer *out)
{
    const int to_full_precision = s->residual_kernel && r->refine == TFA_REFINE_DEFAULT;
    struct refined x = TFA_V(refine)(s, method, steps, to_full_precision, estimation);
    if (doubt_is_confirmed(r, out, steps, &x)) {
        steps = 1;
        x = TFA_V(refine)(s, method, steps, to_full_precision, estimation);
    }
    if (s->lanes > 1 && x.estimated && estimation != ESTIMATE) /* the other states are not */
        s->lanes_diverged = 1;
    while (x.fallback_reason && r->estimate != TFA_ESTIMATE_NEVER) {
        const int last = method == TFA_V(last_resort)(s);
        if (last && !s->residual_kernel)
            break;
        if (s->lanes > 1) { /* the other states may need no fallback */
            s->lanes_diverged = 1;
            break;
        }
        if (!(out->flags & TFA_ANSWER_FALLBACK))
            out->flags |= TFA_ANSWER_FALLBACK | x.fallback_reason;
        if (last) {
            out->flags |= TFA_ANSWER_RESIDUAL_PRECISION;
            break;
        }
        method = TFA_V(fallback)(s, method);
        (void)TFA_V(forward_dynamics)(s, method);
        x = TFA_V(refine)(s, method, steps, to_full_precision, ESTIMATE);
    }
    *valid = TFA_V(estimate_is_valid)(s, r, method, &x.estimate);
    if (s->lanes > 1 && !*valid)
        s->lanes_diverged = 1;
    if (x.estimated)
        store_estimate(s, r, x.estimate, out);
    return method;
}

/* The residual kernel reads all of the request. */
static __attribute__((noinline)) void
load_residual_kernel(const struct state *s, const tfa_request *r, uint32_t k, uint32_t steps)
{
    tfa_request refined = *r;
    refined.refine = steps;
    s->residual_kernel->kernel->load(s->residual_kernel->state, &refined, k);
}

#if NUM_LANES == 1
static int needs_lambda_inv(const struct state *s, const tfa_request *r, const tfa_reply *reply)
{
    return s->tips &&
           (reply->lambda_inv || r->flags & FLAGS_LAMBDA || r->op == TFA_OP_TASK_TORQUES);
}

/* Task torques take what the inward pass of aba leaves, where nothing else reads qdd. */
static int takes_force(const struct state *s, const tfa_request *r, tfa_method method, int refined)
{
    return TFA_OP_BIT(r->op) & (TRAIT_TASK | TRAIT_CONSTRAINED_FD) && method == TFA_METHOD_ABA &&
           !refined && !s->locked && !s->m->mimics && !HAS_MODES(s);
}

/* Force propagation is not refined. */
static uint32_t steps_of_tips(tfa_method method, uint32_t steps)
{
    return TFA_V(method)(method)->osim ? 0 : steps;
}
#endif

int TFA_V(answer_forward)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                          tfa_answer *out)
{
    tfa_method method = s->by.method;
    uint32_t steps = TFA_V(refine_steps)(s, r, method);
    int with_estimate = TFA_V(wants_estimate)(r, method), valid = 1;
#if NUM_LANES == 1
    s->keeps_force = takes_force(s, r, method, steps > 0 || with_estimate);
#endif
    int status = TFA_V(forward_dynamics)(s, method);
    if (status != TFA_OK)
        return status;
    if (s->keeps_force && TFA_V(sentinel_of)(s, method)) {
        s->keeps_force = 0;
        (void)TFA_V(forward_dynamics)(s, method);
    }
    if (s->stalled) {
        out->flags |= TFA_ANSWER_FALLBACK | TFA_ANSWER_STALLED;
        method = TFA_V(fallback)(s, method);
        (void)TFA_V(forward_dynamics)(s, method);
        with_estimate = r->estimate != TFA_ESTIMATE_NEVER;
    }
    if (!with_estimate && TFA_V(sentinel_asks_estimate)(s, r, method, out)) {
        with_estimate = 1;
        s->lanes_diverged = s->lanes > 1; /* the other states may need no estimate */
    }
    if (s->lanes_diverged)
        return TFA_OK;
    const int refined = steps > 0 || with_estimate;
    if (refined && s->residual_kernel)
        load_residual_kernel(s, r, k, steps);
    if (refined)
        method = refine(s, r, method, steps,
                        with_estimate                       ? ESTIMATE
                        : r->estimate != TFA_ESTIMATE_NEVER ? ESTIMATE_IN_DOUBT
                                                            : ESTIMATE_NOT,
                        &valid, out);
    out->method = (uint16_t)method;
    int finite = s->keeps_force ? 1
                 : refined && s->residual_kernel
                     ? s->residual_kernel->kernel->unload(s->residual_kernel->state, k, reply)
                     : TFA_V(unload_qdd)(s, k, reply);
#if NUM_LANES == 1 /* batches have no tips */
    if (finite && r->op == TFA_OP_TASK_TORQUES)
        TFA_V(task_error)(s, r, k);
    if (finite && needs_lambda_inv(s, r, reply)) {
        (void)TFA_V(factor)(s, method); /* unless they are there */
        finite = TFA_V(lambda_after)(s, r, k, method, steps_of_tips(method, steps), reply);
    }
#endif
    if (!finite || !valid)
        TFA_V(report_singular_body)(s, reply);
    return finite && valid ? TFA_OK : TFA_E_NOT_COMPUTED;
}

#if NUM_LANES == 1
int TFA_V(estimate_forward)(struct state *s, const tfa_request *r, uint32_t k,
                            const tfa_reply *reply, double limit, tfa_answer *out)
{
    tfa_request whole = *r;
    whole.estimate = TFA_ESTIMATE_ALWAYS;
    TFA_V(load)(s, &whole, k, 1);
    TFA_V(load_accelerations)(s, reply->base_acceleration, reply->qdd);
    (void)TFA_V(factor)(s, METHOD_OF_ESTIMATES);
    const struct refined x = TFA_V(refine)(s, METHOD_OF_ESTIMATES, 0, 0, ESTIMATE);
    store_estimate(s, &whole, x.estimate, out);
    return !x.fallback_reason && x.estimate.lane[0] <= limit;
}
#endif
