/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One state of a checked request: the method, refinement, estimate, fallback, and the answer.
 */
#include <math.h>

#include "kernel/kernel.h"
#include "kernel/lambda.h"
#include "kernel/load.h"

/* Above this estimate the answer of a method that lost too much is replaced by ABA's
 * (methods.md section 4: over 180 cases nothing worse passed unnoticed). */
#define FALLBACK_ESTIMATE 1e-4

static int wants_estimate(const tfa_request *r, tfa_method method)
{
    return r->estimate == TFA_ESTIMATE_ALWAYS ||
           (r->estimate == TFA_ESTIMATE_DEFAULT &&
            (method == TFA_METHOD_TFA || method == TFA_METHOD_TFA_ONE_SIDED));
}

static uint32_t refine_steps(const tfa_request *r, tfa_method method)
{
    if (r->refine != TFA_REFINE_DEFAULT)
        return r->refine;
    return method == TFA_METHOD_TFA ? 1 : 0;
}

/* Factors of a method; TFA may refuse. */
static int factor(struct state *s, tfa_method method)
{
    if (method == TFA_METHOD_TFA)
        return TFA_V(tfa_factor)(s);
    if (method == TFA_METHOD_CRBA) {
        TFA_V(crba)(s);
        TFA_V(ltdl_factor)(s);
    } else {
        TFA_V(aba_factor)(s);
    }
    return TFA_OK;
}

/* qdd = M^-1 (tau - h), leaving the method's factors */
static int forward_dynamics(struct state *s, tfa_method method)
{
    if (method == TFA_METHOD_ABA) {
        TFA_V(aba)(s, s->tau, s->qdd);
        return TFA_OK;
    }
    int status = factor(s, method);
    if (status != TFA_OK)
        return status;
    if (method == TFA_METHOD_TFA) {
        TFA_V(tfa_solve)(s, s->tau, s->qdd, 1);
        return TFA_OK;
    }
    const uint32_t n = s->m->freedoms;
    for (uint32_t j = 0; j < n; j++)
        s->dx[j] = 0;
    TFA_V(rnea)(s, s->dx, s->res, 1);
    for (uint32_t j = 0; j < n; j++)
        s->qdd[j] = s->tau[j] - s->res[j];
    TFA_V(ltdl_solve)(s, s->qdd, 1);
    return TFA_OK;
}

/* The body whose projected inertia D is not positive, if that is what went wrong. */
static void blame(struct state *s, tfa_reply *reply)
{
    TFA_V(aba_factor)(s);
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        double d = (double)s->Dinv[i];
        if (s->m->body[i].n == 1 && !(d > 0 && isfinite(d))) {
            reply->field = TFA_FIELD_BODY;
            reply->index = s->m->body[i].link;
            return;
        }
    }
}

/* Copies Lambda^-1 out; returns 1 when all of it is finite. */
static int unload_lambda(const struct state *s, double *out)
{
    const size_t n = 6 * s->tips;
    int finite = 1;
    for (size_t e = 0; e < n * n; e++) {
        double x = (double)s->lambda[e];
        finite &= isfinite(x) != 0;
        if (out)
            out[e] = x;
    }
    return finite;
}

/* Lambda^-1 with the factors that the method left */
static void lambda_kept(struct state *s, tfa_reference_frame frame, tfa_method method,
                        uint32_t refine)
{
    if (method == TFA_METHOD_TFA || refine > 0)
        TFA_V(lambda_columns)(s, frame, method, refine);
    else if (method == TFA_METHOD_CRBA)
        TFA_V(lambda_crba)(s, frame);
    else
        TFA_V(lambda_propagation)(s, frame);
}

/* |Lambda^-1 f - J x| / (|Lambda^-1| |f|) with x = M^-1 J^T f refined once, f of signs: what the
 * answer does to one wrench against a second solution that shares the factors only. */
static double lambda_estimate(struct state *s, tfa_reference_frame frame, tfa_method method)
{
    const uint32_t nv = s->m->freedoms;
    const size_t n = 6 * s->tips;
    TFA_V(jacobian)(s, frame);
    for (uint32_t j = 0; j < nv; j++) {
        s->tau[j] = 0;
        for (size_t e = 0; e < n; e++)
            s->tau[j] += (e % 3 == 1 ? -1 : 1) * s->psi[(size_t)j * n + e];
    }
    TFA_V(solve)(s, method, s->tau, s->qdd);
    TFA_V(rnea)(s, s->qdd, s->res, 0);
    for (uint32_t j = 0; j < nv; j++)
        s->res[j] = s->tau[j] - s->res[j];
    TFA_V(solve)(s, method, s->res, s->dx);
    num difference = 0, size = 0;
    for (size_t e = 0; e < n; e++) {
        num y = 0;
        for (uint32_t j = 0; j < nv; j++)
            y -= s->psi[(size_t)j * n + e] * (s->qdd[j] + s->dx[j]);
        for (size_t f = 0; f < n; f++) {
            num l = s->lambda[e * n + f];
            y += (f % 3 == 1 ? -1 : 1) * l;
            size += l * l;
        }
        difference += y * y;
    }
    return size > 0 ? sqrt((double)difference / ((double)size * (double)n)) : 0;
}

static int answer_forward(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                          tfa_answer *out)
{
    tfa_method method = r->method == TFA_METHOD_AUTO ? TFA_METHOD_ABA : r->method;
    const uint32_t steps = refine_steps(r, method);
    int status = forward_dynamics(s, method);
    if (status != TFA_OK)
        return status;
    if (steps > 0 || wants_estimate(r, method)) {
        int converging;
        out->error_estimate = TFA_V(refine)(s, method, steps, &converging);
        out->flags |= TFA_ANSWER_ESTIMATED;
        if (method != TFA_METHOD_ABA && !(converging && out->error_estimate <= FALLBACK_ESTIMATE)) {
            method = TFA_METHOD_ABA;
            out->flags |= TFA_ANSWER_FALLBACK;
            TFA_V(aba)(s, s->tau, s->qdd);
            out->error_estimate = TFA_V(refine)(s, method, 0, &converging);
        }
    }
    out->method = (uint16_t)method;
    const size_t nj = s->m->freedoms - s->m->base_freedoms;
    int finite = TFA_V(unload)(
        s, s->qdd, reply->base_acceleration ? reply->base_acceleration + 6 * (size_t)k : NULL,
        reply->qdd ? reply->qdd + nj * k : NULL);
    if (finite && s->tips && reply->lambda_inv) {
        lambda_kept(s, r->frame, method, method == TFA_METHOD_ABA ? 0 : steps);
        finite = unload_lambda(s, reply->lambda_inv + (size_t)36 * s->tips * s->tips * k);
    }
    if (!finite)
        blame(s, reply);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

static int answer_lambda(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                         tfa_answer *out)
{
    tfa_method method = r->method;
    if (method == TFA_METHOD_AUTO || method == TFA_METHOD_ABA)
        method = TFA_METHOD_PROPAGATION;
    const uint32_t steps = refine_steps(r, method);
    /* forward elimination of the tips needs no factors of the whole robot, its estimate does */
    const int direct = method == TFA_METHOD_TFA_ONE_SIDED && steps == 0;
    tfa_method factors = method;
    if (direct || method == TFA_METHOD_PROPAGATION)
        factors = TFA_METHOD_ABA;
    else if (method == TFA_METHOD_TFA_ONE_SIDED)
        factors = TFA_METHOD_TFA;
    int status = direct ? TFA_V(lambda_one_sided)(s, r->frame) : TFA_OK;
    if (status == TFA_OK && (!direct || wants_estimate(r, method)))
        status = factor(s, factors);
    if (status != TFA_OK)
        return status;
    if (!direct)
        lambda_kept(s, r->frame, factors, steps);
    if (wants_estimate(r, method)) {
        out->error_estimate = lambda_estimate(s, r->frame, factors);
        out->flags |= TFA_ANSWER_ESTIMATED;
        if (method != TFA_METHOD_PROPAGATION && !(out->error_estimate <= FALLBACK_ESTIMATE)) {
            out->flags |= TFA_ANSWER_FALLBACK;
            method = TFA_METHOD_PROPAGATION;
            TFA_V(aba_factor)(s);
            TFA_V(lambda_propagation)(s, r->frame);
            out->error_estimate = lambda_estimate(s, r->frame, TFA_METHOD_ABA);
        }
    }
    out->method = (uint16_t)method;
    double *to = reply->lambda_inv ? reply->lambda_inv + (size_t)36 * s->tips * s->tips * k : NULL;
    if (unload_lambda(s, to))
        return TFA_OK;
    blame(s, reply);
    return TFA_E_NOT_COMPUTED;
}

static int answer_inverse(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *out)
{
    const size_t nj = s->m->freedoms - s->m->base_freedoms;
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    out->method = TFA_METHOD_RNEA;
    int finite =
        TFA_V(unload)(s, s->res, reply->base_wrench ? reply->base_wrench + 6 * (size_t)k : NULL,
                      reply->tau ? reply->tau + nj * k : NULL);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

/* Rows of M hold ancestors only; everything else of the dense answer is zero. */
static int answer_mass(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *out)
{
    const struct tfa_model *m = s->m;
    const size_t n = m->freedoms;
    TFA_V(crba)(s);
    out->method = TFA_METHOD_CRBA;
    double *M = reply->mass_matrix ? reply->mass_matrix + n * n * k : NULL;
    for (size_t e = 0; M && e < n * n; e++)
        M[e] = 0;
    int finite = 1;
    for (uint32_t j = 0; M && j < n; j++)
        for (int32_t i = (int32_t)j; i >= 0; i = m->dof_parent[i]) {
            double x = (double)s->M[m->dof_row[j] + m->dof_depth[i]];
            finite &= isfinite(x) != 0;
            M[j * n + (size_t)i] = M[(size_t)i * n + j] = x;
        }
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

int TFA_V(answer)(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply,
                  tfa_answer *answer)
{
    *answer = (tfa_answer){.error_estimate = NAN};
    TFA_V(load)(s, request, k);
    switch (request->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        answer->status = answer_forward(s, request, k, reply, answer);
        break;
    case TFA_OP_OPERATIONAL_INERTIA:
        answer->status = answer_lambda(s, request, k, reply, answer);
        break;
    case TFA_OP_INVERSE_DYNAMICS:
        answer->status = answer_inverse(s, k, reply, answer);
        break;
    default:
        answer->status = answer_mass(s, k, reply, answer);
    }
    if (answer->status == TFA_E_SINGULAR) {
        reply->field = TFA_FIELD_BODY;
        reply->index = s->m->body[s->bad_body].link;
    }
    return answer->status;
}
