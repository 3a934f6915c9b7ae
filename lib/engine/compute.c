/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * tfa_compute: a loop over the strategies that serve a request.
 */
#include "engine/methods.h"
#include "engine/strategy.h"

int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    const int status = tfa_request_check(workspace->model, request, reply);
    return status == TFA_OK ? tfa_compute_states(workspace, request, 0, request->count, reply)
                            : status;
}

int tfa_compute_states(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                       uint32_t count, tfa_reply *reply)
{
    const int status = tfa_reserved_check(workspace, request, reply);
    return status == TFA_OK ? tfa_compute_checked(workspace, request, first, first + count, reply)
                            : status;
}

/* An answer whose numbers are not finite is none, if the state has one. */
static void fail_answer(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply)
{
    if (reply->answers && reply->answers[k].status == TFA_OK)
        reply->answers[k].status = TFA_E_NOT_COMPUTED;
    tfa_fail_state(w, c, k, TFA_E_NOT_COMPUTED, (struct failed_field){TFA_FIELD_NONE, 0}, reply);
}

/* Answers of kinematics that the strategy of states k .. k + count - 1 left out */
static void answer_motion(tfa_workspace *w, const struct call *c, uint32_t traits, uint32_t k,
                          uint32_t count, tfa_reply *reply)
{
    const uint32_t flags = (traits & TRAIT_TIP_MOTION ? FLAGS_TIP_MOTION : 0) |
                           (traits & TRAIT_BODY_MOTION ? FLAGS_BODY_MOTION : 0);
    for (uint32_t end = k + count; k < end; k++)
        if (!w->kernel->answer_motion(w->state, c->request, c->by, flags, k, reply))
            fail_answer(w, c, k, reply);
}

void tfa_add_joint_forces(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t count,
                          tfa_reply *reply)
{
    for (uint32_t end = k + count; reply->joint_forces && k < end; k++)
        if (!w->kernel->answer_joint_forces(w->state, c->request, c->by, k, 0, reply))
            fail_answer(w, c, k, reply);
}

void tfa_compute_by(tfa_workspace *w, const struct call *c, uint32_t row, uint32_t k, uint32_t end,
                    tfa_reply *reply)
{
    while (k < end) {
        uint32_t done = 0, s = row;
        while ((done = c->strategy[s]->run(w, c, k, end, reply)) == 0)
            s++; /* the last row answers everything */
        const uint32_t left = c->traits & TRAITS_ADDED & ~c->strategy[s]->added;
        if (left & TRAITS_MOTION)
            answer_motion(w, c, left, k, done, reply);
        if (left & TRAIT_JOINT_FORCES)
            tfa_add_joint_forces(w, c, k, done, reply);
        k += done;
    }
}

int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                        uint32_t end, tfa_reply *reply)
{
    struct call call;
    tfa_call_init(&call, workspace, request);
    tfa_compute_by(workspace, &call, 0, first, end, reply);
    return reply->status;
}

/* Writes to every page of a frame of its own. */
__attribute__((noinline)) void tfa_stack_prepare(void)
{
    volatile unsigned char buffer[TFA_STACK_BYTES];
    for (size_t k = 0; k < sizeof buffer; k += 4096)
        buffer[k] = 0;
}
