/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * tfa_compute: which of a workspace's kernels answers which state.
 */
#include <math.h>

#include "methods/workspace.h"

/* Fewer states go one at a time: eight lanes take as long as 1.5 states of a 7-joint arm (measured
 * 2026-11-22, Intel Xeon with AVX-512). */
#define LANES_STATES_MIN 2

static void add_spectrum(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const uint32_t n = 6 * r->tip_count;
    const double *lambda = reply->lambda_inv + (size_t)n * n * k;
    reply->spectrum[k] = tfa_spectrum_of(lambda, n, w->spectrum);
}

/* ---- factors in one arithmetic, residuals in another ---- */

static int answer_wider(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply,
                        tfa_answer *answer)
{
    return w->wider.kernel->answer(w->wider.state, r, k, reply, answer);
}

/* Accelerations by refined factors; what is in doubt then, or was refused, by the wider kernel. */
static int answer_forward_mixed(tfa_workspace *w, const tfa_request *r, uint32_t k,
                                tfa_reply *reply, tfa_answer *answer)
{
    tfa_request part = *r;
    tfa_reply untouched = *reply;
    part.tip_count = 0;
    part.flags &= ~TFA_WANT_POSES;
    const int status = w->kernel->answer(w->state, &part, k, reply, answer);
    if (status == TFA_OK && !(answer->flags & TFA_ANSWER_WIDER))
        return status;
    uint16_t reasons = (answer->flags & (uint16_t)~TFA_ANSWER_ESTIMATED) | TFA_ANSWER_WIDER;
    if (status == TFA_E_NOT_COMPUTED)
        reasons |= TFA_ANSWER_FALLBACK | TFA_ANSWER_NOT_FINITE;
    part.method = reasons & TFA_ANSWER_FALLBACK ? TFA_METHOD_AUTO : r->method;
    *reply = untouched;
    const int last = answer_wider(w, &part, k, reply, answer);
    answer->flags |= reasons;
    return last;
}

static __attribute__((noinline)) int answer_mixed(tfa_workspace *w, const tfa_request *r,
                                                  uint32_t k, tfa_reply *reply, tfa_answer *answer)
{
    if (r->op != TFA_OP_FORWARD_DYNAMICS || r->hold != TFA_HOLD_NONE)
        return answer_wider(w, r, k, reply, answer);
    const int status = answer_forward_mixed(w, r, k, reply, answer);
    if (status != TFA_OK || !r->tip_count)
        return status;
    tfa_answer tips;
    tfa_request part = *r;
    part.op = TFA_OP_OPERATIONAL_INERTIA;
    part.method = TFA_METHOD_AUTO;
    part.refine = TFA_REFINE_DEFAULT;
    part.estimate = TFA_ESTIMATE_NEVER;
    return answer_wider(w, &part, k, reply, &tips);
}

int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    int status = tfa_request_check(workspace->model, request, reply);
    return status == TFA_OK ? tfa_compute_checked(workspace, request, reply) : status;
}

/* May the states of a request go side by side? Forward dynamics and nothing else, by aba. */
static int goes_by_lanes(const tfa_workspace *w, const tfa_request *r)
{
    return w->lanes && r->op == TFA_OP_FORWARD_DYNAMICS &&
           (r->method == TFA_METHOD_AUTO || r->method == TFA_METHOD_ABA) &&
           r->estimate != TFA_ESTIMATE_ALWAYS && r->hold == TFA_HOLD_NONE &&
           (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT) && !r->tip_count &&
           !r->wrench_count && !r->payload_count && !r->locked_count;
}

/* As many states from k on as go side by side; 0 where one at a time is better or has to say
 * what is wrong. */
static uint32_t compute_lanes(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const uint32_t left = r->count - k;
    const uint32_t count = left < w->lanes->lanes ? left : w->lanes->lanes;
    if (count < LANES_STATES_MIN || !w->lanes->answer(w->lane_state, r, k, count, reply))
        return 0;
    for (uint32_t l = 0; reply->answers && l < count; l++)
        reply->answers[k + l] =
            (tfa_answer){.method = TFA_METHOD_ABA, .error_estimate = (double)NAN};
    return count;
}

static int compute_one(tfa_workspace *w, const tfa_request *request, uint32_t k, tfa_reply *reply)
{
    const int spectrum = request->flags & TFA_WANT_SPECTRUM && request->tip_count &&
                         reply->spectrum && reply->lambda_inv;
    tfa_reply one = *reply;
    tfa_answer answer;
    const int status = w->wider.kernel ? answer_mixed(w, request, k, &one, &answer)
                                       : w->kernel->answer(w->state, request, k, &one, &answer);
    if (reply->answers)
        reply->answers[k] = answer;
    if (status != TFA_OK && reply->status == TFA_OK) {
        reply->status = status;
        reply->field = one.field;
        reply->index = one.index;
        reply->state = k;
    }
    if (status == TFA_OK && spectrum)
        add_spectrum(w, request, k, reply);
    return status;
}

int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    const int lanes = goes_by_lanes(workspace, request);
    for (uint32_t k = 0; k < request->count;) {
        uint32_t done = lanes ? compute_lanes(workspace, request, k, reply) : 0;
        if (!done)
            (void)compute_one(workspace, request, k, reply);
        k += done ? done : 1;
    }
    return reply->status;
}
