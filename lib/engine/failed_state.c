/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers that a failed state does not have. They become NaN: over shared memory and DDS the caller
 * would find those of an earlier request in their place.
 */
#include <math.h>

#include "engine/strategy.h"
#include "interface/fields.h"

static void fill(double *x, size_t width, uint32_t k)
{
    for (size_t e = 0; x && e < width; e++)
        x[width * k + e] = (double)NAN;
}

/* Answers of a solution with the task's forces */
static void void_operational(const tfa_request *r, size_t rows, uint32_t k, const tfa_reply *reply)
{
    if (r->flags & TFA_WANT_LAMBDA)
        fill(reply->lambda, rows * rows, k);
    if (r->flags & TFA_WANT_MU)
        fill(reply->mu, rows, k);
    if (r->flags & TFA_WANT_P)
        fill(reply->p, rows, k);
}

static void void_constrained(const struct tfa_model *m, const tfa_request *r, uint32_t k,
                             const tfa_reply *reply)
{
    const size_t six = tfa_constraint_numbers(r);
    const int fd = r->op == TFA_OP_CONSTRAINED_DYNAMICS, impact = r->op == TFA_OP_IMPACT;
    fill(fd ? reply->qdd : impact ? reply->v : reply->tau, m->v_count, k);
    if (m->base_freedoms)
        fill(fd ? reply->base_acceleration : impact ? reply->base_twist : reply->base_wrench, 6, k);
    fill(reply->constraint_wrenches, six, k);
    fill(reply->constraint_residual, six, k);
}

static void void_rank(const struct call *c, uint32_t k, const tfa_reply *reply)
{
    const uint32_t rows = rows_of(c->request) * c->request->tip_count;
    if (reply->rank && c->traits & (TRAIT_LAMBDA | TRAIT_TASK | TRAITS_CONSTRAINED))
        reply->rank[k] = (tfa_rank){.threshold = (double)NAN,
                                    .condition = (double)NAN,
                                    .length = (double)NAN,
                                    .error_estimate = (double)NAN};
    if (rows && c->traits & (TRAIT_LAMBDA | TRAIT_TASK))
        fill(reply->lost, (size_t)TFA_LOST_MAX * (2 + rows), k);
    if (reply->spectrum && reply->lambda_inv && c->traits & TRAIT_SPECTRUM)
        reply->spectrum[k] = (tfa_spectrum){.eig_min = (double)NAN, .eig_max = (double)NAN};
}

static void void_derivatives(const struct tfa_model *m, uint32_t traits, uint32_t k,
                             const tfa_reply *reply)
{
    const size_t n = (size_t)m->base_freedoms + m->v_count;
    if (traits & TRAIT_DERIVATIVES) {
        fill(reply->dqdd_dq, n * n, k);
        fill(reply->dqdd_dv, n * n, k);
        fill(reply->dqdd_dtau, n * n, k);
    }
    if (traits & TRAIT_ID_DERIVATIVES) {
        fill(reply->dtau_dq, n * n, k);
        fill(reply->dtau_dv, n * n, k);
    }
}

void tfa_void_failed_state(const tfa_workspace *w, const struct call *c, uint32_t k, int status,
                           const tfa_reply *reply)
{
    const tfa_request *r = c->request;
    const size_t rows = (size_t)rows_of(r) * r->tip_count;
    if (rows && c->traits & TRAITS_LAMBDA_INV)
        void_operational(r, rows, k, reply);
    if (c->traits & TRAIT_TASK) {
        fill(reply->tau, w->model->v_count, k);
        fill(w->model->base_freedoms ? reply->base_wrench : NULL, 6, k);
    }
    if (c->traits & TRAITS_CONSTRAINED)
        void_constrained(w->model, r, k, reply);
    if (status == TFA_E_RANK)
        return;
    void_rank(c, k, reply);
    if (c->traits & TRAITS_CONSTRAINED) {
        const size_t six = tfa_constraint_numbers(r);
        if (c->traits & TFA_OPS_CONSTRAINED_SOLVE)
            fill(reply->lost, TFA_LOST_MAX * (2 + six), k);
        fill(reply->constraint_position, six, k);
        fill(reply->constraint_velocity, six, k);
        if (r->flags & TFA_WANT_DELASSUS)
            fill(reply->delassus, six * six, k);
    }
    if (c->traits & TRAIT_JOINT_FORCES)
        fill(reply->joint_forces, 6 * (size_t)w->model->frames, k);
    void_derivatives(w->model, c->traits, k, reply);
    if (c->traits & (TRAIT_FD | TRAIT_TASK) || (c->traits & TRAIT_OSIM && status == TFA_E_SINGULAR))
        fill(reply->lambda_inv, rows * rows, k);
    if (c->traits & TRAIT_FD && status == TFA_E_SINGULAR) {
        fill(reply->qdd, w->model->v_count, k);
        fill(w->model->base_freedoms ? reply->base_acceleration : NULL, 6, k);
        fill(reply->modes, w->model->modes, k);
    }
}
