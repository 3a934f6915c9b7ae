/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * tfa_compute: which of a workspace's kernels answers which state.
 */
#include <math.h>

#include "kernel/cut.h"
#include "methods/tuning.h"
#include "methods/workspace.h"
#include "model/tips.h"

static int wants_spectrum(const tfa_request *r, const tfa_reply *reply)
{
    return r->flags & TFA_WANT_SPECTRUM && r->tip_count && reply->spectrum && reply->lambda_inv;
}

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
    if (r->op != TFA_OP_FORWARD_DYNAMICS)
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

int tfa_room_check(const tfa_workspace *w, const tfa_request *r, tfa_reply *reply)
{
    const int whole = r->op == TFA_OP_MASS_MATRIX;
    if (w->methods & TFA_METHOD_BIT(whole ? TFA_METHOD_CRBA : r->method))
        return TFA_OK;
    reply->field = whole ? TFA_FIELD_OP : TFA_FIELD_METHOD;
    reply->index = whole ? 0 : (uint32_t)r->method;
    return reply->status = TFA_E_UNSUPPORTED;
}

int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    const int status = tfa_request_check(workspace->model, request, reply);
    return status == TFA_OK ? tfa_compute_states(workspace, request, 0, request->count, reply)
                            : status;
}

int tfa_compute_states(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                       uint32_t count, tfa_reply *reply)
{
    const int status = tfa_room_check(workspace, request, reply);
    return status == TFA_OK ? tfa_compute_checked(workspace, request, first, first + count, reply)
                            : status;
}

/* Of the robot as it is */
static int is_unchanged(const tfa_request *r)
{
    return !r->wrench_count && !r->payload_count && !r->locked_count;
}

/* And nothing but the answer is asked, as the articulated-body factors give it, and its estimate */
static int is_plain(const tfa_request *r)
{
    return is_unchanged(r) && (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT);
}

/* Is an estimate asked for that only the kernel of one state gives together with the answer? */
static int estimates_tips(const tfa_request *r)
{
    return r->estimate == TFA_ESTIMATE_ALWAYS && r->tip_count;
}

static int is_scan(tfa_method method)
{
    return method == TFA_METHOD_SCAN || method == TFA_METHOD_SCAN_TWO_PASS;
}

static int is_cyclic(tfa_method method)
{
    return method == TFA_METHOD_TFA_CR || method == TFA_METHOD_CFA_CR;
}

/* May the segments of a chain go side by side? */
static int takes_strips(const tfa_workspace *w, const tfa_request *r)
{
    return w->strips && is_forward(r) && is_plain(r) && !r->tip_count;
}

static int goes_by_strips(const tfa_workspace *w, const tfa_request *r)
{
    return is_scan(r->method) && takes_strips(w, r);
}

/* Bodies of the trees that carry a tip */
static uint32_t bodies_of_tips(const struct tfa_model *m, const tfa_request *r)
{
    const struct tfa_chain *tree[TFA_MAX_TIPS];
    const uint32_t trees = tfa_trees_of_tips(m, r, tree);
    uint32_t bodies = 0;
    for (uint32_t k = 0; k < trees; k++)
        bodies += tree[k]->end - tree[k]->first;
    return bodies;
}

/* May the limbs of one state? By aba; Lambda^-1 where more bodies have to be folded than limbs are
 * worth, of which one at a time leaves out the other trees. */
static int goes_by_limbs(const tfa_workspace *w, const tfa_request *r)
{
    const int aba = r->method == TFA_METHOD_AUTO || r->method == TFA_METHOD_ABA;
    if (!w->limbs || !is_plain(r) || estimates_tips(r))
        return 0;
    if (is_forward(r))
        return aba;
    return r->op == TFA_OP_OPERATIONAL_INERTIA &&
           (aba || r->method == TFA_METHOD_PROPAGATION || r->method == TFA_METHOD_PV_OSIMR) &&
           bodies_of_tips(w->model, r) >= w->limbs_from;
}

/* Where the sentinel tripped, an answer with a larger estimate is refined by the kernel of one state. */
#define ALARM_ESTIMATE 1e-7

/* Estimate of accelerations that stand in the reply, if the request or the sentinel asks for it. Returns 0
 * where the kernel of one state is to answer instead. */
static int estimate_if_asked(tfa_workspace *w, const tfa_request *r, uint32_t k, int alarmed,
                             int by_limbs, const tfa_reply *reply, tfa_answer *answer)
{
    const int asked = is_forward(r) && r->estimate == TFA_ESTIMATE_ALWAYS;
    alarmed &= r->estimate == TFA_ESTIMATE_DEFAULT;
    if (!asked && !alarmed)
        return 1;
    const int whole = reply->qdd && (reply->base_acceleration || !w->model->base_freedoms);
    if (!is_forward(r) || r->tip_count || !whole)
        return 0;
    if (alarmed)
        answer->flags |= TFA_ANSWER_SENTINEL;
    const double limit = alarmed ? ALARM_ESTIMATE : FALLBACK_ESTIMATE;
    return by_limbs ? w->limbs->estimate(w->limb_state, limit, answer)
                    : w->kernel->estimate(w->state, r, k, reply, limit, answer);
}

static int compute_strips(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const double light = r->method == TFA_METHOD_SCAN ? TFA_SCAN_LIGHT : -1; /* every cut */
    tfa_answer answer = {.method = (uint16_t)r->method, .error_estimate = (double)NAN};
    const int answered = w->strips->answer(w->strips_state, w->crew, r, k, light, reply);
    if (!answered ||
        !estimate_if_asked(w, r, k, answered == TFA_ANSWERED_ALARMED, 0, reply, &answer))
        return 0;
    if (reply->answers)
        reply->answers[k] = answer;
    return 1;
}

/* As many of the states k .. end - 1 as go side by side; 0 where they are fewer than `from`, or one has
 * to say what is wrong. */
static uint32_t compute_lanes(tfa_workspace *w, const tfa_request *r, uint32_t k, uint32_t end,
                              uint32_t from, tfa_reply *reply)
{
    tfa_answer answers[TFA_LANES_MAX];
    tfa_reply several = *reply;
    const uint32_t left = end - k;
    const uint32_t count = left < w->lanes->lanes ? left : w->lanes->lanes;
    if (count < from || !w->lanes->answer(w->lane_state, r, k, count, &several, answers))
        return 0;
    for (uint32_t l = 0; l < count; l++) {
        if (reply->answers)
            reply->answers[k + l] = answers[l];
        if (wants_spectrum(r, reply))
            add_spectrum(w, r, k + l, reply);
    }
    return count;
}

/* State k, its limbs side by side, then what its tips ask for. Returns 0 where it has to say what is
 * wrong. */
static uint32_t compute_limbs(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    tfa_answer answer = {.method = TFA_METHOD_ABA, .error_estimate = (double)NAN};
    const int answered = w->limbs->answer(w->limb_state, r, k, reply);
    if (!answered ||
        !estimate_if_asked(w, r, k, answered == TFA_ANSWERED_ALARMED, 1, reply, &answer))
        return 0;
    if (r->tip_count) {
        w->limbs->give(w->limb_state, r, &w->factors);
        if (!w->kernel->answer_tips(w->state, r, k, reply, &answer))
            return 0;
    }
    if (reply->answers)
        reply->answers[k] = answer;
    if (wants_spectrum(r, reply))
        add_spectrum(w, r, k, reply);
    return 1;
}

/* Bodies of the longest main chain */
static uint32_t longest_chain(const tfa_model *m)
{
    uint32_t longest = 0;
    for (uint32_t t = 0; t < m->trees; t++)
        longest = m->chain[t].length > longest ? m->chain[t].length : longest;
    return longest;
}

int tfa_goes_in_parts(const tfa_model *model, const tfa_request *r)
{
    return (is_scan(r->method) || is_cyclic(r->method)) &&
           longest_chain(model) >= TFA_PARTS_BODIES_MIN;
}

/* May the chain of a state go in pieces? Forward dynamics of the robot as it is, or Lambda^-1 of one
 * tip as it comes. */
static int goes_by_pieces(const tfa_workspace *w, const tfa_request *r)
{
    const int bare = r->refine == 0 && r->estimate == TFA_ESTIMATE_NEVER;
    const int asked = is_forward(r)
                          ? !r->tip_count
                          : r->op == TFA_OP_OPERATIONAL_INERTIA && r->tip_count == 1 && bare &&
                                r->method == TFA_METHOD_TFA_CR && !(r->flags & TFA_WANT_POSES);
    return w->pieces && w->strips && asked && is_cyclic(r->method) && is_unchanged(r);
}

/* The scan judges what pieces answer: as accurate as aba, and as parallel as they are. */
struct strips_judge {
    struct tfa_judge judge;
    tfa_workspace *workspace;
    const tfa_request *request;
    uint32_t state;
};

static int judge_by_strips(struct tfa_judge *judge, const double *residual, double *x)
{
    static const double weightless[3];
    const struct strips_judge *j = (const struct strips_judge *)judge;
    tfa_workspace *w = j->workspace;
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .count = 1,
                           .q = j->request->q + (size_t)w->model->q_count * j->state,
                           .tau = residual,
                           .gravity = weightless};
    tfa_reply reply = {.qdd = x};
    return w->strips->answer(w->strips_state, w->crew, &r, 0, TFA_SCAN_LIGHT, &reply) !=
           TFA_NOT_ANSWERED;
}

/* By one number at a time where the chain does not go in pieces, or its answer is not good enough */
static int answer_one(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply,
                      tfa_answer *answer)
{
    struct strips_judge by = {{judge_by_strips}, w, r, k};
    struct pieces *p = w->piece_state;
    const int lambda = r->op == TFA_OP_OPERATIONAL_INERTIA;
    if (goes_by_pieces(w, r) &&
        (lambda ? w->pieces->answer_lambda(p, w->crew, r, k, reply, answer)
                : w->pieces->answer(p, w->crew, r, k, &by.judge, reply, answer)))
        return TFA_OK;
    return w->kernel->answer(w->state, r, k, reply, answer);
}

static int compute_one(tfa_workspace *w, const tfa_request *request, uint32_t k, tfa_reply *reply)
{
    tfa_reply one = *reply;
    tfa_answer answer;
    const int status = w->wider.kernel ? answer_mixed(w, request, k, &one, &answer)
                                       : answer_one(w, request, k, &one, &answer);
    if (reply->answers)
        reply->answers[k] = answer;
    if (status != TFA_OK && reply->status == TFA_OK) {
        reply->status = status;
        reply->field = one.field;
        reply->index = one.index;
        reply->state = k;
    }
    if (status == TFA_OK && wants_spectrum(request, reply))
        add_spectrum(w, request, k, reply);
    return status;
}

/* Resolves TFA_METHOD_AUTO by the model and the request: the segment scan for long chains of
 * revolute joints, in double precision; all else the kernels resolve. Returns the request, or a
 * copy that names the scan. */
static const tfa_request *resolve_method(const tfa_workspace *w, const tfa_request *r,
                                         tfa_request *named)
{
    if (r->method != TFA_METHOD_AUTO || w->model->bodies < TFA_SCAN_BODIES_MIN ||
        !takes_strips(w, r))
        return r;
    *named = *r;
    named->method = TFA_METHOD_SCAN;
    return named;
}

/* Batches with payloads go by the generic lanes: the specialised kernel has these one at a time. */
static int goes_by_own(const tfa_workspace *w, const tfa_request *r, const tfa_reply *reply)
{
    const int to_nowhere = r->tip_count && !reply->lambda_inv;
    const int loaded_batch = r->payload_count && r->count > 1;
    return w->own && !to_nowhere && !loaded_batch && w->own->takes(&w->host, r);
}

/* What says who answered: the methods that a robot's own kernel is made of */
static uint16_t own_method(const tfa_request *r)
{
    if (r->method != TFA_METHOD_AUTO)
        return (uint16_t)r->method;
    return r->op == TFA_OP_INVERSE_DYNAMICS      ? TFA_METHOD_RNEA
           : r->op == TFA_OP_OPERATIONAL_INERTIA ? TFA_METHOD_PROPAGATION
                                                 : TFA_METHOD_ABA;
}

/* What a robot's own kernel is asked when an estimate of its answer is to follow */
static const tfa_request *without_estimate(const tfa_request *r, tfa_request *bare)
{
    if (!is_forward(r) || r->tip_count || r->estimate != TFA_ESTIMATE_ALWAYS)
        return r;
    *bare = *r;
    bare->estimate = TFA_ESTIMATE_NEVER;
    return bare;
}

/* By the robot's own kernel: as many of the states k .. end - 1 as it takes at a time, without tips. 0 where
 * an answer is not finite or in doubt: the generic kernel answers and reports why. */
static uint32_t compute_own(tfa_workspace *w, const tfa_request *r, const tfa_request *bare,
                            uint32_t k, uint32_t end, tfa_reply *reply)
{
    const uint32_t left = end - k, lanes = r->tip_count ? 0 : w->own->lanes;
    uint32_t count = left < lanes ? left : lanes;
    if (count < TFA_LANES_STATES_MIN || !w->own->many(&w->host, bare, k, count, reply))
        count = w->own->one(&w->host, bare, k, reply) ? 1 : 0;
    for (uint32_t l = 0; l < count; l++) {
        tfa_answer answer = {.method = own_method(r), .error_estimate = (double)NAN};
        if (!estimate_if_asked(w, r, k + l, 0, 0, reply, &answer))
            return l;
        if (reply->answers)
            reply->answers[k + l] = answer;
        if (wants_spectrum(r, reply))
            add_spectrum(w, r, k + l, reply);
    }
    return count;
}

/* By the generic kernels, states first .. end - 1 */
static void compute_generic(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                            uint32_t end, tfa_reply *reply)
{
    tfa_request named;
    const tfa_request *one = resolve_method(workspace, request, &named);
    const int strips = goes_by_strips(workspace, one);
    const int limbs = goes_by_limbs(workspace, one);
    const uint32_t few = TFA_LANES_STATES_MIN;
    const int lanes = workspace->lanes && end - first >= few &&
                      !goes_by_strips(workspace, request) && !goes_by_pieces(workspace, request) &&
                      workspace->lanes->takes(request);
    const uint32_t from = limbs && workspace->lanes_from > few ? workspace->lanes_from : few;
    for (uint32_t k = first; k < end;) {
        uint32_t done = lanes ? compute_lanes(workspace, request, k, end, from, reply) : 0;
        if (!done && strips)
            done = (uint32_t)compute_strips(workspace, one, k, reply);
        if (!done && limbs)
            done = compute_limbs(workspace, one, k, reply);
        if (!done)
            (void)compute_one(workspace, one, k, reply);
        k += done ? done : 1;
    }
}

int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                        uint32_t end, tfa_reply *reply)
{
    tfa_request copy;
    const tfa_request *bare = workspace->own ? without_estimate(request, &copy) : request;
    const int own = goes_by_own(workspace, bare, reply);
    for (uint32_t k = first; own && k < end;) {
        const uint32_t done = compute_own(workspace, request, bare, k, end, reply);
        if (!done) /* what is wrong with this state, a generic kernel says */
            compute_generic(workspace, request, k, k + 1, reply);
        k += done ? done : 1;
    }
    if (!own)
        compute_generic(workspace, request, first, end, reply);
    return reply->status;
}
