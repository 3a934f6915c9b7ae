/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of one state: the method, refinement, estimate and fallback.
 */
#include <math.h>

#include "kernel/answer.h"
#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/method.h"
#include "kernel/table.h"

int TFA_V(unload_qdd)(const struct state *s, uint32_t k, tfa_reply *reply)
{
    return TFA_V(unload)(s, s->qdd,
                         reply->base_acceleration ? reply->base_acceleration + 6 * (size_t)k : NULL,
                         reply->qdd ? reply->qdd + (size_t)s->m->v_count * k : NULL);
}

/* Refinement and estimate; while the answer is in doubt, that of the next method, refined as the first
 * was. If the estimate is still too large, the wider kernel answers, where there is one. A request
 * without estimates gets the bare answer. *sound: TFA_V(is_answer). */
static tfa_method refine(struct state *s, const tfa_request *r, tfa_method method, uint32_t steps,
                         int certified, int *sound, tfa_answer *out)
{
    const int fully = s->wider && r->refine == TFA_REFINE_DEFAULT;
    struct refined x = TFA_V(refine)(s, method, steps, fully, certified);
    while (x.doubt && r->estimate != TFA_ESTIMATE_NEVER) {
        const int last = method == TFA_V(last_resort)(s);
        if (last && !s->wider)
            break;
        if (s->lanes > 1) { /* the other states may be in no doubt */
            s->apart = 1;
            break;
        }
        if (!(out->flags & TFA_ANSWER_FALLBACK))
            out->flags |= TFA_ANSWER_FALLBACK | x.doubt;
        if (last) {
            out->flags |= TFA_ANSWER_WIDER;
            break;
        }
        method = TFA_V(fallback)(s, method);
        (void)TFA_V(forward_dynamics)(s, method);
        x = TFA_V(refine)(s, method, steps, fully, certified);
    }
    *sound = TFA_V(is_answer)(s, r, method, &x.estimate);
    if (s->lanes > 1 && !*sound)
        s->apart = 1;
    TFA_V(tell_estimate)(s, r, &x.estimate, out);
    return method;
}

/* The wider kernel reads all of the request, whose refinement it takes part in. */
static __attribute__((noinline)) void load_wider(const struct state *s, const tfa_request *r,
                                                 uint32_t k, uint32_t steps)
{
    tfa_request refined = *r;
    refined.refine = steps;
    s->wider->kernel->load(s->wider->state, &refined, k);
}

#if NUM_LANES == 1
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
    int certified = TFA_V(wants_estimate)(r, method), sound = 1;
    int status = TFA_V(forward_dynamics)(s, method);
    if (status != TFA_OK)
        return status;
    if (!certified && TFA_V(alarmed)(s, r, method, out)) {
        certified = 1;
        s->apart = s->lanes > 1; /* the other states may need no estimate */
        if (r->refine == TFA_REFINE_DEFAULT && !steps)
            steps = 1;
    }
    if (s->apart)
        return TFA_OK;
    const int refined = steps > 0 || certified;
    if (refined && s->wider)
        load_wider(s, r, k, steps);
    if (refined)
        method = refine(s, r, method, steps, certified, &sound, out);
    out->method = (uint16_t)method;
    int finite = refined && s->wider ? s->wider->kernel->unload(s->wider->state, k, reply)
                                     : TFA_V(unload_qdd)(s, k, reply);
#if NUM_LANES == 1 /* batches have no tips */
    if (finite && s->tips && reply->lambda_inv) {
        (void)TFA_V(factor)(s, method); /* unless they are there */
        finite = TFA_V(lambda_after)(s, r, k, method, steps_of_tips(method, steps), reply);
    }
#endif
    if (!finite || !sound)
        TFA_V(blame)(s, reply);
    return finite && sound ? TFA_OK : TFA_E_NOT_COMPUTED;
}

#if NUM_LANES == 1
int TFA_V(estimate_forward)(struct state *s, const tfa_request *r, uint32_t k,
                            const tfa_reply *reply, double limit, tfa_answer *out)
{
    tfa_request whole = *r;
    whole.estimate = TFA_ESTIMATE_ALWAYS;
    TFA_V(load)(s, &whole, k, 1);
    TFA_V(load_freedoms)(s, s->qdd, reply->base_acceleration, reply->qdd);
    (void)TFA_V(factor)(s, METHOD_OF_ESTIMATES);
    const struct refined x = TFA_V(refine)(s, METHOD_OF_ESTIMATES, 0, 0, 1);
    TFA_V(tell_estimate)(s, &whole, &x.estimate, out);
    return !x.doubt && x.estimate.lane[0] <= limit;
}
#endif
