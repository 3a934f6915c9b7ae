/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mixed precision: accelerations by refined factors; everything else by the residual kernel, which
 * also answers if the estimate stays too large.
 */
#include "engine/strategy.h"

static int answer_by_residual_kernel(tfa_workspace *w, const tfa_request *r, uint32_t k,
                                     tfa_reply *reply, tfa_answer *answer)
{
    const struct tfa_resolved by = tfa_resolve_method(w, r, traits_of(r));
    return w->residual_kernel.kernel->answer(w->residual_kernel.state, r, by, k, 1, reply, answer);
}

/* Float factors are those of a batch of one state. */
static int answer_factors(tfa_workspace *w, const tfa_request *r, struct tfa_resolved by,
                          uint32_t k, tfa_reply *reply, tfa_answer *answer)
{
    return w->precision == TFA_F32 ? w->batch->answer(w->batch_state, r, by, k, 1, reply, answer)
                                   : w->kernel->answer(w->state, r, by, k, 1, reply, answer);
}

/* 1: the kernel of the factors has this method */
static int has_factors(const tfa_workspace *w, tfa_method method)
{
    return w->precision != TFA_F32 || w->batch->solves(method);
}

static int answer_forward(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply,
                          tfa_answer *answer)
{
    tfa_request part = *c->request;
    tfa_reply untouched = *reply;
    part.tip_count = 0;
    part.flags = 0;
    uint16_t reasons = TFA_ANSWER_RESIDUAL_PRECISION;
    if (has_factors(w, c->by.method)) {
        const int status = answer_factors(w, &part, c->by, k, reply, answer);
        if (status == TFA_OK && !(answer->flags & TFA_ANSWER_RESIDUAL_PRECISION))
            return status;
        reasons |= answer->flags & (uint16_t)~TFA_ANSWER_ESTIMATED;
        if (status == TFA_E_NOT_COMPUTED)
            reasons |= TFA_ANSWER_FALLBACK | TFA_ANSWER_NOT_FINITE;
    }
    if (reasons & TFA_ANSWER_FALLBACK)
        part.method = TFA_METHOD_AUTO;
    *reply = untouched;
    const int status = answer_by_residual_kernel(w, &part, k, reply, answer);
    answer->flags |= reasons;
    return status;
}

/* What the request asks of its tips, and the other answers of its flags. The answer keeps the
 * method and the estimate of the accelerations. */
static int answer_tips(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply,
                       tfa_answer *answer)
{
    tfa_answer tips;
    tfa_request part = *c->request;
    part.op = TFA_OP_OPERATIONAL_INERTIA;
    part.method = TFA_METHOD_AUTO;
    part.refine = TFA_REFINE_DEFAULT;
    part.estimate = TFA_ESTIMATE_NEVER;
    answer->status = answer_by_residual_kernel(w, &part, k, reply, &tips);
    return answer->status;
}

/* Kinematics need no accelerations: a state that has none has kinematics all the same. */
static int answer_all(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply,
                      tfa_answer *answer)
{
    if (!(c->traits & TRAIT_FD))
        return answer_by_residual_kernel(w, c->request, k, reply, answer);
    const struct tfa_residual_kernel *residual = &w->residual_kernel;
    int status = answer_forward(w, c, k, reply, answer);
    if (status == TFA_OK && c->traits & TRAIT_JOINT_FORCES && reply->joint_forces &&
        !residual->kernel->answer_joint_forces(residual->state, c->request, c->by, k, 0, reply))
        status = answer->status = TFA_E_NOT_COMPUTED;
    if (status == TFA_OK && c->traits & TRAIT_TIPS)
        return answer_tips(w, c, k, reply, answer);
    if (c->request->flags &&
        !residual->kernel->answer_motion(residual->state, c->request, c->by, TFA_WANT_ALL, k,
                                         reply) &&
        status == TFA_OK)
        answer->status = TFA_E_NOT_COMPUTED;
    return answer->status;
}

__attribute__((noinline)) uint32_t tfa_run_mixed(tfa_workspace *w, const struct call *c, uint32_t k,
                                                 uint32_t end, tfa_reply *reply)
{
    (void)end;
    tfa_reply one = *reply;
    tfa_answer answer;
    const int status = answer_all(w, c, k, &one, &answer);
    tfa_finish_single(w, c, k, status, tfa_failed_field(&one), &answer, reply);
    return 1;
}
