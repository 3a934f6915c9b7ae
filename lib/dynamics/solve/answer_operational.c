/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operational-space dynamics (Khatib 1987) with the Lambda^-1 that is there:
 *
 *     mu = Lambda (J M^-1 (velocity + damping + external) - J-dot v),   p = Lambda J M^-1 gravity
 *
 * and task torques: with the posture torques tau_0 the tips have x0 = J qdd_0 + J-dot v, so that
 *
 *     F = Lambda (x_desired - x0),   tau = tau_0 + J^T F
 *
 * is the dynamically consistent torque, (1 - J^T Lambda J M^-1) tau_0 in the task's null space.
 */
#include "dynamics/core/bias_force.h"
#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/lambda_inverse.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "interface/traits.h"

/* s->task: numbers of one vector of the tips' rows, four of which fit */
static num *task_vector(const struct state *s, uint32_t which)
{
    return s->task + (size_t)which * s->tip_rows * s->tips;
}

enum { ERROR, FORCE, SCRATCH };

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

/* ---- task torques ---- */

void TFA_V(task_error)(struct state *s, const tfa_request *r, uint32_t k)
{
    const double *desired = r->task_acceleration + (size_t)s->tip_rows * s->tips * k;
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        struct tip_velocity motion;
        num x[6];
        TFA_V(tip_locate)(s, t, r->frame, &at);
        TFA_V(tip_velocity)(s, &at, &motion);
        TFA_V(tip_acceleration)(s, &at, &motion, s->qdd, x);
        for (uint32_t e = 0; e < s->tip_rows; e++)
            task_vector(s, ERROR)[s->tip_rows * t + e] =
                num_of(desired[s->tip_rows * t + e]) - x[e];
    }
}

/* tau_0 + J^T F, where joints are not locked */
static int answer_torques(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    num *tau = s->res;
    for (uint32_t j = 0; j < s->freedoms; j++)
        tau[j] = num_of(0);
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        num F[6] = {num_of(0), num_of(0), num_of(0), num_of(0), num_of(0), num_of(0)};
        TFA_V(tip_locate)(s, t, r->frame, &at);
        for (uint32_t e = 0; e < s->tip_rows; e++)
            F[e] = task_vector(s, FORCE)[s->tip_rows * t + e];
        TFA_V(tip_jacobian_tmul)(s, &at, F, tau);
    }
    for (uint32_t j = 0; s->locked && j < s->freedoms; j++)
        if (s->lock[j])
            tau[j] = num_of(0);
    TFA_V(load_forces)(s, r->base_wrench, r->tau);
    for (uint32_t j = 0; j < s->freedoms; j++)
        tau[j] += s->tau[j];
    const int finite =
        TFA_V(unload_force)(s, tau, reply->base_wrench ? reply->base_wrench + 6 * (size_t)k : NULL,
                            reply->tau ? reply->tau + (size_t)s->m->v_count * k : NULL);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

/* ---- operational-space forces ---- */

/* x = J M^-1 x of all tips, in s->task; s->res is x. */
static void tip_response(struct state *s, const tfa_request *r)
{
    const tfa_method method = TFA_V(last_resort)(s);
    TFA_V(gather_on_leaders)(s, s->res);
    (void)TFA_V(factor)(s, method);
    TFA_V(solve)(s, method, s->res, s->res);
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        num x[6];
        TFA_V(tip_locate)(s, t, r->frame, &at);
        TFA_V(tip_jacobian_mul)(s, &at, s->res, x);
        for (uint32_t e = 0; e < s->tip_rows; e++)
            task_vector(s, ERROR)[s->tip_rows * t + e] = x[e];
    }
}

static int answer_p(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const size_t n = (size_t)s->tip_rows * s->tips;
    TFA_V(gravity_force)(s, s->res);
    tip_response(s, r);
    TFA_V(lambda_mul)(s, task_vector(s, ERROR), task_vector(s, FORCE), task_vector(s, SCRATCH));
    return store_rows(reply->p + n * k, task_vector(s, FORCE), n);
}

static int answer_mu(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const size_t n = (size_t)s->tip_rows * s->tips;
    TFA_V(external_force)(s, s->tau);
    TFA_V(velocity_force)(s, s->res);
    TFA_V(damping_force)(s, s->dx);
    for (uint32_t j = 0; j < s->freedoms; j++)
        s->res[j] += s->tau[j] + s->dx[j];
    tip_response(s, r);
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        struct tip_velocity motion;
        num x[6];
        TFA_V(tip_locate)(s, t, r->frame, &at);
        TFA_V(tip_velocity)(s, &at, &motion);
        TFA_V(tip_acceleration)(s, &at, &motion, NULL, x);
        for (uint32_t e = 0; e < s->tip_rows; e++)
            task_vector(s, ERROR)[s->tip_rows * t + e] -= x[e];
    }
    TFA_V(lambda_mul)(s, task_vector(s, ERROR), task_vector(s, FORCE), task_vector(s, SCRATCH));
    return store_rows(reply->mu + n * k, task_vector(s, FORCE), n);
}

int TFA_V(answer_operational)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const size_t n = (size_t)s->tip_rows * s->tips;
    const double relative = r->rank_threshold ? *r->rank_threshold : 0;
    tfa_rank rank;
    if (!TFA_V(lambda_factor)(s, r->rank_loss, relative, &rank))
        return TFA_E_NOT_COMPUTED;
    if (reply->rank)
        reply->rank[k] = rank;
    if (r->rank_loss == TFA_RANK_REFUSE && rank.rank < n) {
        reply->field = TFA_FIELD_TIPS;
        reply->index = rank.rank;
        return TFA_E_RANK;
    }
    int status = TFA_OK;
    if (r->op == TFA_OP_TASK_TORQUES) {
        TFA_V(lambda_mul)(s, task_vector(s, ERROR), task_vector(s, FORCE), task_vector(s, SCRATCH));
        status = answer_torques(s, r, k, reply);
    }
    int finite = status == TFA_OK;
    if (r->flags & TFA_WANT_LAMBDA && reply->lambda)
        finite &= TFA_V(lambda_dense)(s, reply->lambda + n * n * k);
    if (r->flags & TFA_WANT_P && reply->p)
        finite &= answer_p(s, r, k, reply);
    if (r->flags & TFA_WANT_MU && reply->mu)
        finite &= answer_mu(s, r, k, reply);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
