/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inverse dynamics under constraints: with b = M qdd + h, freedoms with a motor (a) and without
 * one (u),
 *
 *     min |W^1/2 (b_a - J_a^T F)|  under  J_u^T F = b_u,   tau = b - J_c^T F
 *
 * F of least norm in the metric of the constraints: F = F_u + F_a, F_u = (J_u^T)^+ b_u and F_a of
 * least squares in the null space of J_u^T (null-space method; Lawson and Hanson 1974, chapter 20;
 * Righetti et al. 2013 for legged robots). What J_u^T F leaves of b_u stands in tau of freedoms
 * without a motor.
 */
#include <string.h>

#include "dynamics/core/recursions.h"
#include "dynamics/osim/constraint_rows.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/osim/lambda_inverse.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "spatial/dense.h"

/* s->task: wanted accelerations; forces F_u, F_a; scratch */
enum { WANTED, FORCE, MORE, REST };

/* Freedoms by what their force costs. Free: locked ones, followers, modes */
enum { WITHOUT_MOTOR, WITH_MOTOR, FREE };

/* s->mark by public freedom: 1 where its joint has a motor */
static void mark_motors(struct state *s)
{
    for (uint32_t j = 0; j < s->m->joints; j++) {
        const tfa_joint_info *joint = &s->m->joint[j];
        memset(s->mark + joint->v_index, joint->actuated != 0, joint->v_count);
    }
}

static int kind_of(const struct state *s, uint32_t j)
{
    const struct tfa_model *m = s->m;
    if (j < m->base_freedoms)
        return WITHOUT_MOTOR;
    if (s->lock[j] || j >= m->freedoms - m->modes)
        return FREE;
    for (uint32_t k = 0; k < m->mimics; k++)
        if (m->mimic[k].follower == j)
            return FREE;
    return s->mark[m->freedom[j - m->base_freedoms].from] ? WITH_MOTOR : WITHOUT_MOTOR;
}

/* Jacobians of the links by freedoms, in s->psi; those of followers on their leaders */
static void find_jacobian(struct state *s)
{
    const struct tfa_model *m = s->m;
    TFA_V(constraint_jacobian)(s);
    for (uint32_t k = 0; k < m->mimics; k++) {
        num *leader = tip_columns(s, s->psi, m->mimic[k].leader, 0);
        const num *follower = tip_columns(s, s->psi, m->mimic[k].follower, 0);
        for (uint32_t e = 0; e < 6 * s->tips; e++)
            leader[e] += num_of(m->mimic[k].multiplier) * follower[e];
    }
}

/* Takes what the directions of F_u make of a row x: x - V V^T x, or x - U^T U^+T x */
static void leave_null_space(const struct state *s, num *row)
{
    const uint32_t n = s->closing_rows, stride = tip_stride(s);
    num *a = s->coefficient;
    for (uint32_t k = 0; k < s->tip_rank; k++) {
        a[k] = dense_dot(s->direction + (size_t)stride * k, row, n);
        a[k] /= s->spectral ? s->eigenvalue[k] : num_of(1);
    }
    for (uint32_t k = 0; k < s->tip_rank; k++) {
        const num *v = (s->spectral ? s->direction : s->triangle) + (size_t)stride * k;
        for (uint32_t e = 0; e < n; e++)
            row[e] -= a[k] * v[e];
    }
}

/* Root of the weight of freedom j */
static num weight_of(const struct state *s, const tfa_request *r, uint32_t j)
{
    const uint32_t nb = s->m->base_freedoms;
    return r->torque_weights ? num_sqrt(num_of(r->torque_weights[s->m->freedom[j - nb].from]))
                             : num_of(1);
}

/* Rows of J_c^T of one kind into s->phi, and of b into s->force_row. Returns the sum of the squares
 * of J_c^T. */
static num find_rows(struct state *s, const tfa_request *r, int kind, const num *b)
{
    const uint32_t n = s->closing_rows, stride = tip_stride(s);
    num size = num_of(0);
    s->tip_freedoms = 0;
    for (uint32_t j = 0; j < s->freedoms; j++) {
        if (kind_of(s, j) != kind)
            continue;
        num *row = s->phi + (size_t)stride * s->tip_freedoms;
        const num w = kind == WITH_MOTOR ? weight_of(s, r, j) : num_of(1);
        const num *from = tip_columns(s, s->psi, j, 0);
        for (uint32_t e = 0; e < stride; e++)
            row[e] = e < n ? w * scale_of(s, e) * from[TFA_V(constraint_column)(s, e)] : num_of(0);
        size += dense_dot(row, row, n);
        if (kind == WITH_MOTOR)
            leave_null_space(s, row);
        s->force_row[s->tip_freedoms++] = w * b[j];
    }
    return size;
}

/* b -= J_c^T F, with followers on their leaders */
static void subtract_force(struct state *s, const num *F, num *b)
{
    num *minus = task_vector(s, REST);
    for (uint32_t j = 0; j < s->closing_rows; j++)
        minus[j] = -F[j];
    TFA_V(constraint_force)(s, minus, b);
    TFA_V(gather_on_leaders)(s, b);
}

/* F by both steps, b becomes tau. Returns 0 where it is not finite. */
static int find_force(struct state *s, const tfa_request *r, num *b, tfa_rank *rank)
{
    num *F = task_vector(s, FORCE), *more = task_vector(s, MORE);
    tfa_rank second;
    TFA_V(metric_load)(s, r);
    num size = find_rows(s, r, WITHOUT_MOTOR, b);
    if (!TFA_V(factor_rows)(s, r, 0, size, rank))
        return 0;
    TFA_V(least_squares)(s, s->force_row, NULL, F);
    subtract_force(s, F, b);
    size = find_rows(s, r, WITH_MOTOR, b);
    if (!TFA_V(factor_rows)(s, r, 0, size, &second))
        return 0;
    TFA_V(least_squares)(s, s->force_row, NULL, more);
    subtract_force(s, more, b);
    for (uint32_t j = 0; j < s->closing_rows; j++)
        F[j] += more[j];
    if (second.rank && (!rank->rank || second.condition > rank->condition))
        rank->condition = second.condition;
    rank->error_estimate =
        second.error_estimate > rank->error_estimate ? second.error_estimate : rank->error_estimate;
    rank->rank += second.rank;
    rank->lost = s->closing_rows - rank->rank;
    return 1;
}

/* J_c qdd + J_c-dot v - a to the reply */
static int store_residual(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    num *x = task_vector(s, WANTED), *rest = task_vector(s, REST);
    TFA_V(constraint_wanted)(s, r, k, x);
    TFA_V(constraint_motion)(s, s->qdd, rest);
    for (uint32_t j = 0; j < s->closing_rows; j++)
        rest[j] -= x[j];
    double *out = reply->constraint_residual;
    return TFA_V(store_held)(s, rest, out ? out + (size_t)6 * s->closings * k : NULL);
}

int TFA_V(answer_constrained_inverse)(struct state *s, const tfa_request *r, uint32_t k,
                                      tfa_reply *reply, tfa_answer *answer)
{
    tfa_rank rank;
    answer->method = (uint16_t)s->by.method;
    TFA_V(constraint_errors)(s, k, reply);
    int finite = store_residual(s, r, k, reply);
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; s->has_passive_force && j < s->freedoms; j++)
        s->res[j] -= s->passive_force[j];
    TFA_V(gather_on_leaders)(s, s->res);
    mark_motors(s);
    find_jacobian(s);
    if (!find_force(s, r, s->res, &rank))
        return TFA_E_NOT_COMPUTED;
    if (rank.lost)
        answer->flags |= TFA_ANSWER_RANK_LOSS;
    if (reply->rank)
        reply->rank[k] = rank;
    if (r->rank_loss == TFA_RANK_REFUSE && rank.lost) {
        reply->field = TFA_FIELD_CONSTRAINTS;
        reply->index = rank.rank;
        return TFA_E_RANK;
    }
    finite &= TFA_V(store_wrenches)(s, task_vector(s, FORCE), k, reply, answer);
    finite &= TFA_V(unload_force)(s, s->res,
                                  reply->base_wrench ? reply->base_wrench + 6 * (size_t)k : NULL,
                                  reply->tau ? reply->tau + (size_t)s->m->v_count * k : NULL);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
