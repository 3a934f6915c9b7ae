/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of execution strategies, and their runs.
 */
#include <math.h>

#include "dynamics/scan/chain_cut.h"
#include "engine/methods.h"
#include "engine/strategy.h"
#include "engine/tuning.h"
#include "model/tips.h"

#define BIT TFA_METHOD_BIT
#define SCANS (BIT(TFA_METHOD_SCAN) | BIT(TFA_METHOD_SCAN_TWO_PASS))
#define CYCLIC (BIT(TFA_METHOD_TFA_CR) | BIT(TFA_METHOD_CFA_CR))
#define ARTICULATED (BIT(TFA_METHOD_ABA) | BIT(TFA_METHOD_PROPAGATION) | BIT(TFA_METHOD_PV_OSIMR))
#define SPECIALISED                                                                                \
    (BIT(TFA_METHOD_ABA) | BIT(TFA_METHOD_RNEA) | BIT(TFA_METHOD_PROPAGATION) |                    \
     BIT(TFA_METHOD_CRBA))
#define ANY_OP TFA_OPS_ALL

static const tfa_answer no_estimate = {.error_estimate = (double)NAN};

/* ---- common to the runs ---- */

void tfa_finish_spectrum(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply)
{
    if (!reply->spectrum || !reply->lambda_inv)
        return;
    const uint32_t n = rows_of(c->request) * c->request->tip_count;
    reply->spectrum[k] = tfa_spectrum_of(reply->lambda_inv + (size_t)n * n * k, n, w->spectrum);
}

void tfa_fail_state(tfa_workspace *w, const struct call *c, uint32_t k, int status,
                    struct failed_field failed, tfa_reply *reply)
{
    tfa_void_failed_state(w, c, k, status, reply);
    if (reply->status != TFA_OK)
        return;
    reply->status = status;
    reply->field = failed.field;
    reply->index = failed.index;
    reply->state = k;
}

void tfa_finish_single(tfa_workspace *w, const struct call *c, uint32_t k, int status,
                       struct failed_field failed, const tfa_answer *answer, tfa_reply *reply)
{
    if (status == TFA_OK || status == TFA_E_RANK)
        tfa_finish_state(w, c, k, answer, reply);
    else if (reply->answers)
        reply->answers[k] = *answer;
    if (status != TFA_OK)
        tfa_fail_state(w, c, k, status, failed, reply);
}

/* 1: the reply has all accelerations */
static int has_accelerations(const tfa_workspace *w, const tfa_reply *reply)
{
    return reply->qdd && (reply->base_acceleration || !w->model->base_freedoms);
}

/* Estimates the accelerations in the reply if the request or the sentinel asks for it. Returns 0 if
 * the kernel of one state must answer instead. */
static int estimate_if_requested(tfa_workspace *w, const struct call *c, uint32_t k,
                                 int sentinel_tripped, int with_body_lanes, const tfa_reply *reply,
                                 tfa_answer *answer)
{
    const tfa_request *r = c->request;
    const int asked = c->traits & TRAIT_FD && c->traits & TRAIT_ESTIMATE;
    sentinel_tripped &= (c->traits & TRAIT_DEFAULT_ESTIMATE) != 0;
    if (!asked && !sentinel_tripped)
        return 1;
    if (!(c->traits & TRAIT_FD) || c->traits & TRAIT_TIPS || !has_accelerations(w, reply))
        return 0;
    if (sentinel_tripped)
        answer->flags |= TFA_ANSWER_SENTINEL;
    const double limit = sentinel_tripped ? SENTINEL_ESTIMATE_MAX : FALLBACK_ESTIMATE;
    return with_body_lanes ? w->body_lanes->estimate(w->body_lanes_state, limit, answer)
                           : w->kernel->estimate(w->state, r, k, reply, limit, answer);
}

/* ---- specialised: the robot's specialised kernel ---- */

static int has_specialised(const tfa_workspace *w)
{
    return w->specialised != NULL;
}

/* Tips in float that it has in double only are computed in double, as by the generic
 * kernel. */
static int specialised_serves(const tfa_workspace *w, const struct call *c)
{
    if (c->traits & TRAIT_DERIVATIVES && c->by.method != TFA_METHOD_CRBA) /* its code has M */
        return 0;
    if (w->precision == TFA_F32)
        return w->specialised->supports_f32(&w->host, c->request) ||
               (c->traits & TRAIT_TIPS && w->specialised->supports(&w->host, c->request));
    return w->specialised->supports(&w->host, c->request);
}

/* States of one run, as bits: with an answer, and with one in double that floats were asked for */
struct solved {
    uint32_t count, answered, in_double;
};

/* In double precision: several states in lanes, or one. Which of them makes no difference to the
 * answers: one takes lanes where there is no other code, and the other way round. */
static struct solved solve_specialised(tfa_workspace *w, const tfa_request *r, uint32_t k,
                                       uint32_t left, tfa_reply *reply)
{
    const struct tfa_specialised_kernel *s = w->specialised;
    struct solved x = {left < s->lanes ? left : s->lanes, TFA_SPECIALISED_NO_CODE, 0};
    if (x.count >= TFA_BATCH_STATES_MIN)
        x.answered = s->solve_batch(&w->host, r, k, x.count, reply);
    if (x.answered != TFA_SPECIALISED_NO_CODE)
        return x;
    x.count = 1;
    x.answered = s->solve(&w->host, r, k, reply);
    if (x.answered == TFA_SPECIALISED_NO_CODE && s->lanes)
        x.answered = s->solve_batch(&w->host, r, k, 1, reply);
    return x;
}

/* The same in single precision, which has code for lanes only; with a tip in double if need be */
static struct solved solve_specialised_f32(tfa_workspace *w, const tfa_request *r, uint32_t k,
                                           uint32_t left, tfa_reply *reply)
{
    const struct tfa_specialised_kernel *s = w->specialised;
    struct solved x = {left < s->lanes_f32 ? left : s->lanes_f32, 0, 0};
    x.answered = s->solve_batch_f32(&w->host, r, k, x.count, reply);
    for (uint32_t l = 0; r->tip_count && l < x.count; l++)
        if (!(x.answered >> l & 1) && s->solve(&w->host, r, k + l, reply) == 1)
            x.in_double |= UINT32_C(1) << l;
    return x;
}

static inline void finish_answered(tfa_workspace *w, const struct call *c, uint32_t k,
                                   uint16_t flags, tfa_reply *reply)
{
    tfa_answer answer = no_estimate;
    answer.method = (uint16_t)c->by.method;
    answer.flags = flags;
    tfa_finish_state(w, c, k, &answer, reply);
}

/* Of states from k on. Those without an answer go to the rows behind this one, which is the first;
 * their neighbours do not, or bits would depend on them. */
static void finish_specialised(tfa_workspace *w, const struct call *c, uint32_t k,
                               const struct solved *x, tfa_reply *reply)
{
    const uint32_t answered = x->answered | x->in_double;
    for (uint32_t l = 0, first = 0; l < x->count; first = l) {
        while (l < x->count && !(answered >> l & 1))
            l++;
        if (l > first)
            tfa_compute_by(w, c, 1, k + first, k + l, reply);
        for (; l < x->count && answered >> l & 1; l++)
            finish_answered(w, c, k + l, x->in_double >> l & 1 ? TFA_ANSWER_RESIDUAL_PRECISION : 0,
                            reply);
    }
}

/* Computes up to `lanes` states. Those whose answer is not finite, or where the sentinel trips, are
 * left to the generic kernels, which report the reason. */
static uint32_t run_specialised(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                                tfa_reply *reply)
{
    const tfa_request *r = c->request;
    if (c->traits & TRAIT_TIPS && !reply->lambda_inv)
        return 0;
    const struct solved x = w->precision == TFA_F32 ? solve_specialised_f32(w, r, k, end - k, reply)
                                                    : solve_specialised(w, r, k, end - k, reply);
    if (x.answered == TFA_SPECIALISED_NO_CODE && !x.in_double)
        return 0;
    if (x.count == 1 && x.answered & 1)
        finish_answered(w, c, k, 0, reply);
    else
        finish_specialised(w, c, k, &x, reply);
    return x.count;
}

/* ---- mixed: factors in one arithmetic, residuals in another ---- */

static int has_residual_kernel(const tfa_workspace *w)
{
    return w->residual_kernel.kernel != NULL;
}

/* ---- segment lanes: one state of a long chain, its segments in lanes ---- */

/* Cyclic reduction is over segments here, whose factors are those of articulated bodies: it is
 * neither refined nor estimated unless the request or the sentinel asks for it. */

static int has_segments(const tfa_workspace *w)
{
    return w->segment_lanes != NULL;
}

static uint32_t run_segments(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                             tfa_reply *reply)
{
    (void)end;
    tfa_answer answer = no_estimate;
    answer.method = (uint16_t)c->by.method;
    const int answered = w->segment_lanes->answer(w->segment_lanes_state, w->executor, c->request,
                                                  k, c->by.method, reply);
    if (!answered ||
        !estimate_if_requested(w, c, k, answered == TFA_ANSWERED_SENTINEL, 0, reply, &answer))
        return 0;
    tfa_finish_state(w, c, k, &answer, reply);
    return 1;
}

/* ---- batch: several states in lanes ---- */

static int has_batch(const tfa_workspace *w)
{
    return w->batch != NULL;
}

/* Methods that the batch kernel lacks, cyclic reduction over segments, and derivatives of large
 * robots go one state at a time. */
static int batch_serves(const tfa_workspace *w, const struct call *c)
{
    if (w->segment_lanes && CYCLIC & BIT(c->by.method))
        return 0;
    if (c->traits & TRAITS_DERIVATIVES && w->model->freedoms > TFA_DERIVATIVES_LANES_FREEDOMS_MAX)
        return 0;
    return !(c->traits & TRAITS_FORWARD) || w->batch->solves(c->by.method);
}

/* Computes states k .. k + count - 1. Returns count; 0 if there are too few, one must be computed
 * alone, or one by another strategy: of floats by double. */
static uint32_t run_lanes(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t count,
                          tfa_reply *reply)
{
    tfa_answer answers[TFA_BATCH_LANES_MAX];
    if (count < c->batch_min)
        return 0;
    tfa_reply several = *reply;
    if (w->batch->answer(w->batch_state, c->request, c->by, k, count, &several, answers) != TFA_OK)
        return 0;
    for (uint32_t l = 0; l < count; l++)
        tfa_finish_state(w, c, k + l, &answers[l], reply);
    if (w->precision == TFA_F32 && c->traits & TRAIT_JOINT_FORCES)
        tfa_add_joint_forces(w, c, k, count, reply);
    return count;
}

static uint32_t run_batch(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                          tfa_reply *reply)
{
    const uint32_t left = end - k;
    const uint32_t done = run_lanes(w, c, k, left < w->batch_max ? left : w->batch_max, reply);
    return done || left == 1 ? done : run_lanes(w, c, k, 1, reply);
}

/* ---- body lanes: one state, its independent branches in lanes ---- */

static int has_body_lanes(const tfa_workspace *w)
{
    return w->body_lanes != NULL;
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

/* Forward dynamics and task torques by aba; inverse dynamics without other answers; Lambda^-1 if
 * the trees of the tips have more bodies than body lanes cost, because scalar code skips the other
 * trees. The scalar kernel estimates for tips. */
static int body_lanes_serve(const tfa_workspace *w, const struct call *c)
{
    if (c->traits & TRAIT_ID)
        return !(c->traits & (TRAIT_TIPS | TRAITS_ADDED));
    if (c->traits & TRAIT_CONSTRAINED_FD)
        return !(c->traits & (TRAIT_TIPS | TRAIT_POSES | TRAITS_ADDED | TRAIT_ESTIMATE));
    if (c->traits & TRAIT_ESTIMATE && c->traits & TRAIT_TIPS)
        return 0;
    return c->traits & (TRAIT_FD | TRAIT_TASK) ||
           bodies_of_tips(w->model, c->request) >= w->body_lanes_min_bodies;
}

/* Returns 0 if the kernel of one state must answer instead. */
static int body_lanes_joint_forces(tfa_workspace *w, const struct call *c, uint32_t k,
                                   tfa_reply *reply)
{
    if (!(c->traits & TRAIT_JOINT_FORCES) || !reply->joint_forces)
        return 1;
    if (!has_accelerations(w, reply))
        return 0;
    w->body_lanes->copy_forces(w->body_lanes_state, reply, &w->factors);
    return w->kernel->answer_joint_forces(w->state, c->request, c->by, k, 1, reply);
}

/* Returns 0 if the kernel of one state must answer instead. */
static int body_lanes_constraints(tfa_workspace *w, const struct call *c, uint32_t k,
                                  tfa_reply *reply, tfa_answer *answer)
{
    const tfa_request *r = c->request;
    if (!has_accelerations(w, reply))
        return 0;
    w->body_lanes->copy_factors(w->body_lanes_state, r, &w->factors);
    return w->kernel->answer_tips(w->state, r, c->by, k, reply, answer) &&
           w->body_lanes->accelerate(w->body_lanes_state, r, &w->factors, k, reply) &&
           w->kernel->constraint_residual(w->state, k, reply);
}

static uint32_t run_body_lanes(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                               tfa_reply *reply)
{
    (void)end;
    tfa_answer answer = no_estimate;
    answer.method = c->traits & TRAIT_ID ? (uint16_t)c->by.method : TFA_METHOD_ABA;
    const int answered = w->body_lanes->answer(w->body_lanes_state, c->request, k, reply);
    if (!answered ||
        !estimate_if_requested(w, c, k, answered == TFA_ANSWERED_SENTINEL, 1, reply, &answer) ||
        !body_lanes_joint_forces(w, c, k, reply))
        return 0;
    if (c->traits & TRAIT_CONSTRAINED_FD && !body_lanes_constraints(w, c, k, reply, &answer))
        return 0;
    if (c->traits & TRAIT_TIPS) {
        w->body_lanes->copy_factors(w->body_lanes_state, c->request, &w->factors);
        if (!w->kernel->answer_tips(w->state, c->request, c->by, k, reply, &answer))
            return 0;
    }
    tfa_finish_state(w, c, k, &answer, reply);
    return 1;
}

/* ---- scalar: one state, one body after the other; serves everything ---- */

static int always(const tfa_workspace *w)
{
    (void)w;
    return 1;
}

/* Float factors exist in batches only: a scalar answer has higher precision. */
static uint32_t run_scalar(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                           tfa_reply *reply)
{
    (void)end;
    tfa_answer answer;
    const struct failed_field before = tfa_failed_field(reply);
    const int status = w->kernel->answer(w->state, c->request, c->by, k, 1, reply, &answer);
    const struct failed_field failed = tfa_failed_field(reply);
    reply->field = before.field; /* of the first state that failed, if one has */
    reply->index = before.index;
    if (w->precision == TFA_F32)
        answer.flags |= TFA_ANSWER_RESIDUAL_PRECISION;
    tfa_finish_single(w, c, k, status, failed, &answer, reply);
    return 1;
}

/* ---- the table ---- */

#define REFUSED_BY_FACTORS (TRAITS_CHANGED | TRAIT_REFINE)
/* Answers that the scalar kernel computes while it has the state */
#define SCALAR_ONLY (TRAIT_LAMBDA | TRAIT_POINT)
static const struct strategy strategies[TFA_STRATEGIES] = {
    {"specialised", has_specialised,
     TRAIT_FD | TRAIT_ID | TRAIT_OSIM | TRAIT_M | TRAITS_DERIVATIVES, SCALAR_ONLY, 0, SPECIALISED,
     specialised_serves, run_specialised},
    {"mixed", has_residual_kernel, ANY_OP, 0, TRAITS_ADDED, TFA_METHODS_ALL, NULL, tfa_run_mixed},
    {"segment lanes", has_segments, TRAIT_FD, REFUSED_BY_FACTORS | TRAIT_TIPS, 0, SCANS | CYCLIC,
     NULL, run_segments},
    {"batch", has_batch, TRAIT_FD | TRAIT_ID | TRAIT_M | TRAITS_DERIVATIVES, TRAIT_TIPS,
     TRAIT_JOINT_FORCES, TFA_METHODS_ALL, batch_serves, run_batch},
    {"body lanes", has_body_lanes,
     TRAIT_FD | TRAIT_ID | TRAIT_OSIM | TRAIT_TASK | TRAIT_CONSTRAINED_FD,
     REFUSED_BY_FACTORS | TRAIT_LAMBDA, TRAIT_TIP_MOTION | TRAIT_JOINT_FORCES,
     ARTICULATED | BIT(TFA_METHOD_RNEA), body_lanes_serve, run_body_lanes},
    {"scalar", always, ANY_OP, 0, TRAITS_ADDED, TFA_METHODS_ALL, NULL, run_scalar},
};

uint32_t tfa_strategies_of(const tfa_workspace *w, const struct strategy **out)
{
    uint32_t count = 0;
    for (size_t k = 0; k < sizeof strategies / sizeof *strategies; k++)
        if (strategies[k].is_available(w))
            out[count++] = &strategies[k];
    return count;
}

/* Derivatives of one state have their columns in lanes: a full vector of eight states takes as long
 * as 2.5 (arm7) to 4.7 states alone (humanoid30, floating), of four 1.8 to 3.2 (bench_suite --tasks
 * derivatives,batch-derivatives, Intel Xeon VM, gcc 12, 2026-11-28). */
static uint32_t batch_min(const tfa_workspace *w, uint32_t traits)
{
    const uint32_t half = w->batch ? w->batch->lanes / 2 : 0;
    return traits & TRAITS_DERIVATIVES && w->precision == TFA_F64 && half > w->batch_min
               ? half
               : w->batch_min;
}

/* Full vectors of states are always faster; fewer states go one at a time with body lanes. */
void tfa_call_init(struct call *c, const tfa_workspace *w, const tfa_request *r)
{
    c->request = r;
    c->traits = traits_of(r);
    c->by = tfa_resolve_method(w, r, c->traits);
    c->batch_min = batch_min(w, c->traits);
    c->strategies = 0;
    c->solve_one = NULL;
    const uint32_t method = TFA_METHOD_BIT(c->by.method);
    for (uint32_t k = 0; k < w->strategies; k++) {
        const struct strategy *s = w->strategy[k];
        if (!(c->traits & s->ops) || c->traits & s->refuses || !(s->methods & method) ||
            (s->serves && !s->serves(w, c)))
            continue;
        c->strategy[c->strategies++] = s;
        if (s->run == run_body_lanes)
            c->batch_min = w->batch_min_body_lanes;
        if (s->run == run_specialised && w->precision != TFA_F32 &&
            !(c->traits & (TRAITS_ADDED | TRAIT_SPECTRUM)))
            c->solve_one = w->specialised->solve;
    }
}

int tfa_method_is_parallel(const tfa_model *model, const tfa_request *r)
{
    if (!((SCANS | CYCLIC | BIT(TFA_METHOD_HYBRID)) & TFA_METHOD_BIT(r->method)))
        return 0;
    for (uint32_t t = 0; t < model->trees; t++)
        if (model->chain[t].length >= TFA_PARTS_BODIES_MIN)
            return 1;
    return 0;
}
