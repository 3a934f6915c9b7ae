/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operational-space dynamics (Khatib 1987):
 *
 *     mu = Lambda (J M^-1 (velocity + damping + friction + external) - J-dot v)
 *     p = Lambda J M^-1 gravity
 *
 * and task torques: with the posture torques tau_0 the tips would have x0 = J qdd_0 + J-dot v with
 * qdd_0 = M^-1 (tau_0 - h), so that
 *
 *     F = Lambda (x_desired - J-dot v) - Lambda J M^-1 (tau_0 - h),   tau = tau_0 + J^T F
 *
 * is the dynamically consistent torque, (1 - J^T Lambda J M^-1) tau_0 in the task's null space.
 * Lambda J M^-1 of forces is one least-squares problem (lambda_force): accelerations J M^-1 h would
 * have lost the digits that Lambda multiplies.
 */
#include <string.h>

#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/lambda_inverse.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/bias_force.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"
#include "interface/traits.h"

/* s->task: numbers of one vector of the tips' rows, five of which fit; two are scratch of Lambda */
enum { ERROR, FORCE, UNREACHED = 4 };

/* Returns 1 when all of it is finite. */
static int store_rows(double *out, const num *x, size_t count)
{
    double sum = 0;
    for (size_t e = 0; e < count; e++) {
        out[e] = (double)x[e];
        sum += out[e] - out[e];
    }
    return sum == 0;
}

/* J-dot v of tip t, which goes with s->qdd */
static void tip_bias(struct state *s, const tfa_request *r, uint32_t t, num bias[6])
{
    struct tip at;
    struct tip_velocity motion;
    TFA_V(tip_locate)(s, t, r->frame, &at);
    TFA_V(tip_velocity)(s, &at, &motion);
    TFA_V(tip_acceleration)(s, &at, &motion, NULL, bias);
}

/* ---- task torques ---- */

void TFA_V(subtract_bias)(struct state *s)
{
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->dx[j] = num_of(0);
    TFA_V(rnea)(s, s->dx, s->task_force, 1);
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->task_force[j] = s->tau[j] - s->task_force[j];
}

/* x_desired - J-dot v - J qdd_0 */
static void find_unreached(struct state *s, const tfa_request *r)
{
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        num x[6];
        TFA_V(tip_locate)(s, t, r->frame, &at);
        TFA_V(tip_jacobian_mul)(s, &at, s->qdd, x);
        for (uint32_t row = s->tip_rows * t, e = 0; e < s->tip_rows; e++, row++)
            task_vector(s, UNREACHED)[row] = task_vector(s, ERROR)[row] - x[e];
    }
}

void TFA_V(task_error)(struct state *s, const tfa_request *r, uint32_t k)
{
    const double *desired = r->task_acceleration + all_tip_rows(s) * k;
    for (uint32_t t = 0; t < s->tips; t++) {
        num bias[6];
        tip_bias(s, r, t, bias);
        for (uint32_t e = 0; e < s->tip_rows; e++) {
            const uint32_t row = s->tip_rows * t + e;
            task_vector(s, ERROR)[row] = num_of(desired[row]) - bias[e];
        }
    }
    if (s->keeps_force)
        return;
    find_unreached(s, r);
    TFA_V(subtract_bias)(s);
}

tfa_method TFA_V(method_of_tips)(const struct state *s)
{
    return s->m->mimics ? TFA_METHOD_CRBA : METHOD_OF_ESTIMATES;
}

int TFA_V(factor_tips)(struct state *s, const tfa_request *r, int estimated, tfa_rank *rank)
{
    const tfa_method method = TFA_V(method_of_tips)(s);
    if (s->m->mimics && !reserves_method(s->methods, method))
        return 0; /* no memory for M */
    (void)TFA_V(factor)(s, method);
    if (!TFA_V(lambda_factor)(s, r, estimated, rank))
        return 0;
    if (estimated)
        rank->error_estimate += TFA_V(lambda_inverse_error)(s, r);
    return 1;
}

void TFA_V(force_of)(struct state *s, const num *tau, const num *x, num *y)
{
    if (!s->m->mimics)
        TFA_V(solve_free)(s, METHOD_OF_ESTIMATES, tau, s->dx);
    TFA_V(lambda_force)(s, tau, x, y);
}

/* -F = Lambda (J M^-1 (tau_0 - h) - (x_desired - J-dot v)) and tau_0 + J^T F, where joints are not
 * locked */
static int answer_torques(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    num *tau = s->res;
    if (s->keeps_force)
        TFA_V(lambda_force)(s, NULL, task_vector(s, ERROR), task_vector(s, FORCE));
    else
        TFA_V(force_of)(s, s->task_force, task_vector(s, ERROR), task_vector(s, FORCE));
    TFA_V(tips_jacobian_tmul)(s, r->frame, task_vector(s, FORCE), tau);
    for (uint32_t j = 0; s->locked && j < s->freedoms; j++)
        if (s->lock[j])
            tau[j] = num_of(0);
    if (!s->keeps_force || s->has_passive_force)
        TFA_V(load_forces)(s, r->base_wrench, r->tau);
    for (uint32_t j = 0; j < s->freedoms; j++)
        tau[j] = s->tau[j] - tau[j];
    return TFA_V(unload_force)(s, tau,
                               reply->base_wrench ? reply->base_wrench + 6 * (size_t)k : NULL,
                               reply->tau ? reply->tau + (size_t)s->m->v_count * k : NULL);
}

/* ---- operational-space forces ---- */

static int answer_p(struct state *s, uint32_t k, tfa_reply *reply)
{
    const size_t n = all_tip_rows(s);
    TFA_V(gravity_force)(s, s->res);
    TFA_V(force_of)(s, s->res, NULL, task_vector(s, FORCE));
    return store_rows(reply->p + n * k, task_vector(s, FORCE), n);
}

static int answer_mu(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const size_t n = all_tip_rows(s);
    num *bias = task_vector(s, ERROR), *mu = task_vector(s, FORCE);
    TFA_V(external_force)(s, s->tau);
    TFA_V(velocity_force)(s, s->res);
    TFA_V(dissipative_force)(s, s->dx);
    for (uint32_t j = 0; j < s->freedoms; j++)
        s->res[j] += s->tau[j] + s->dx[j];
    for (uint32_t t = 0; t < s->tips; t++) {
        num x[6];
        tip_bias(s, r, t, x);
        for (uint32_t e = 0; e < s->tip_rows; e++)
            bias[s->tip_rows * t + e] = x[e];
    }
    TFA_V(force_of)(s, s->res, bias, mu);
    return store_rows(reply->mu + n * k, mu, n);
}

/* Rank and the directions that are lost */
static void store_rank(struct state *s, const tfa_request *r, uint32_t k, tfa_rank *rank,
                       tfa_reply *reply, tfa_answer *answer)
{
    const size_t n = all_tip_rows(s);
    if (rank->lost)
        answer->flags |= TFA_ANSWER_RANK_LOSS;
    if (reply->rank)
        reply->rank[k] = *rank;
    if (!reply->lost)
        return;
    double *lost = reply->lost + TFA_LOST_MAX * (2 + n) * k;
    memset(lost, 0, TFA_LOST_MAX * (2 + n) * sizeof *lost);
    if (r->op != TFA_OP_TASK_TORQUES)
        for (size_t e = 0; e < n; e++)
            task_vector(s, UNREACHED)[e] = num_of(0);
    if (!rank->lost)
        return;
    if (s->keeps_force) {
        TFA_V(aba)(s, s->tau, s->qdd); /* leaves the same forces */
        find_unreached(s, r);
    }
    TFA_V(lambda_lost)(s, task_vector(s, UNREACHED), lost);
}

int TFA_V(answer_operational)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *answer)
{
    const size_t n = all_tip_rows(s);
    tfa_rank rank;
    if (!TFA_V(factor_tips)(s, r, answer->flags & TFA_ANSWER_ESTIMATED, &rank))
        return TFA_E_NOT_COMPUTED;
    if (rank.lost && s->keeps_force == KEEPS_FORCE_GIVEN)
        return TFA_E_NOT_COMPUTED;
    store_rank(s, r, k, &rank, reply, answer);
    if (r->rank_loss == TFA_RANK_REFUSE && rank.lost) {
        reply->field = TFA_FIELD_TIPS;
        reply->index = rank.rank;
        return TFA_E_RANK;
    }
    int finite = r->op != TFA_OP_TASK_TORQUES || answer_torques(s, r, k, reply);
    if (r->flags & TFA_WANT_LAMBDA && reply->lambda)
        finite &= TFA_V(lambda_dense)(s, reply->lambda + n * n * k);
    if (r->flags & TFA_WANT_P && reply->p)
        finite &= answer_p(s, k, reply);
    if (r->flags & TFA_WANT_MU && reply->mu)
        finite &= answer_mu(s, r, k, reply);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
