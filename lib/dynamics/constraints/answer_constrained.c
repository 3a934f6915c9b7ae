/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics under constraints (constraint_rows.h), Gauss's principle with
 * J_c qdd + J_c-dot v = a (Udwadia and Kalaba 1992; Featherstone 2008, chapter 8), and the impact
 * that ends their motion, plastic and without friction (Featherstone 2008, 11.7):
 *
 *     F = Lambda_c (a - J_c-dot v - J_c M^-1 (tau - h)),   qdd = M^-1 (tau + J_c^T F - h)
 *     F = - Lambda_c (J_c v + k0 e),   v+ = v + M^-1 J_c^T F,   e: errors of position
 *
 * F is the least-squares problem of task torques (lambda_force), with the policies for a lost rank;
 * redundant constraints share F in the metric of the tips.
 */
#include <string.h>

#include "dynamics/core/recursions.h"
#include "dynamics/osim/constraint_rows.h"
#include "dynamics/osim/lambda_inverse.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "interface/traits.h"

/* s->task: as in answer_operational.c */
enum { ERROR, FORCE, UNREACHED = 4 };

/* Six numbers of each constraint, for state k; NULL: not wanted */
static double *block(const struct state *s, double *out, uint32_t k)
{
    return out ? out + (size_t)6 * s->closings * k : NULL;
}

int TFA_V(store_held)(const struct state *s, const num *x, double *out)
{
    double rest = 0;
    for (uint32_t j = 0; j < s->closing_rows; j++)
        rest += (double)x[j] - (double)x[j];
    if (!out)
        return rest == 0;
    memset(out, 0, (size_t)6 * s->closings * sizeof *out);
    for (uint32_t j = 0; j < s->closing_rows; j++)
        out[s->closing_row[j]] = (double)x[j];
    return rest == 0;
}

/* A wrench on the robot instead of one against the error */
static void negate(const struct state *s, num *F)
{
    for (uint32_t j = 0; j < s->closing_rows; j++)
        F[j] = -F[j];
}

void TFA_V(constraint_errors)(struct state *s, uint32_t k, tfa_reply *reply)
{
    double *position = block(s, reply->constraint_position, k),
           *velocity = block(s, reply->constraint_velocity, k);
    TFA_V(constraints_locate)(s);
    for (uint32_t c = 0; c < s->closings; c++)
        for (uint32_t e = 0; e < 6; e++) {
            if (position)
                position[6 * c + e] = (double)s->relative[c].position[e];
            if (velocity)
                velocity[6 * c + e] = (double)s->relative[c].velocity[e];
        }
}

void TFA_V(constraint_wanted)(const struct state *s, const tfa_request *r, uint32_t k, num *x)
{
    const double *wanted = r->constraint_acceleration;
    const double none[2] = {0, 0}, *gains = r->stabilisation ? r->stabilisation : none;
    const size_t first = (size_t)6 * s->closings * k;
    for (uint32_t j = 0; j < s->closing_rows; j++) {
        const uint32_t row = s->closing_row[j], e = row % 6;
        const struct relative_motion *m = &s->relative[row / 6];
        num a = num_of(wanted ? wanted[first + row] : 0);
        a -= num_of(gains[0]) * m->position[e] + num_of(gains[1]) * m->velocity[e];
        x[j] = a - m->bias[e];
    }
}

/* Forces in held rows: -F into `y` */
static void find_force(struct state *s, num *y)
{
    const num *x = task_vector(s, ERROR);
    if (s->keeps_force)
        TFA_V(lambda_force)(s, NULL, x, y);
    else
        TFA_V(force_of)(s, s->task_force, x, y);
}

/* J_c qdd + J_c-dot v - a, which is J_c qdd less the error, into `out` */
static void find_residual(struct state *s, num *out)
{
    const num *x = task_vector(s, ERROR);
    TFA_V(constraint_motion)(s, s->qdd, out);
    for (uint32_t j = 0; j < s->closing_rows; j++)
        out[j] -= x[j];
}

/* Rank, and the directions that are lost, with their rows among all six */
static void store_rank(struct state *s, uint32_t k, const tfa_rank *rank, tfa_reply *reply,
                       tfa_answer *answer)
{
    const size_t n = s->closing_rows, wide = 2 + (size_t)6 * s->closings;
    if (rank->lost)
        answer->flags |= TFA_ANSWER_RANK_LOSS;
    if (reply->rank)
        reply->rank[k] = *rank;
    if (!reply->lost)
        return;
    double *lost = reply->lost + TFA_LOST_MAX * wide * k;
    memset(lost, 0, TFA_LOST_MAX * wide * sizeof *lost);
    if (!rank->lost)
        return;
    TFA_V(lambda_lost)(s, task_vector(s, UNREACHED), lost);
    for (uint32_t d = TFA_LOST_MAX; d-- > 0;) { /* rows move outward: the last ones first */
        double *to = lost + wide * d;
        const double *from = lost + (2 + n) * d;
        double row[2 + 6 * TFA_MAX_TIPS];
        memcpy(row, from, (2 + n) * sizeof *row);
        memset(to, 0, wide * sizeof *to);
        memcpy(to, row, 2 * sizeof *to);
        for (uint32_t j = 0; j < n; j++)
            to[2 + s->closing_row[j]] = row[2 + j];
    }
}

/* Before the forces: factors, the Delassus matrix, rank. Returns the status. */
static int factor_constraints(struct state *s, const tfa_request *r, uint32_t k, int estimated,
                              tfa_reply *reply, tfa_answer *answer)
{
    const size_t six = (size_t)6 * s->closings;
    tfa_rank rank;
    if (r->flags & TFA_WANT_DELASSUS && reply->delassus) {
        (void)TFA_V(factor)(s, TFA_V(method_of_tips)(s));
        s->tip_length = num_of(1);
        TFA_V(tip_rows)(s, r->frame);
        if (!TFA_V(delassus)(s, reply->delassus + six * six * k))
            return TFA_E_NOT_COMPUTED;
    }
    if (!TFA_V(factor_tips)(s, r, estimated, &rank))
        return TFA_E_NOT_COMPUTED;
    if (rank.lost && reply->lost && r->op == TFA_OP_IMPACT)
        memcpy(task_vector(s, UNREACHED), task_vector(s, ERROR), s->closing_rows * sizeof(num));
    else if (rank.lost && reply->lost) {
        num *unreached = task_vector(s, UNREACHED);
        if (s->keeps_force == KEEPS_FORCE_GIVEN)
            return TFA_E_NOT_COMPUTED;
        if (s->keeps_force)
            TFA_V(aba)(s, s->tau, s->qdd); /* leaves the same forces */
        find_residual(s, unreached);
        negate(s, unreached);
    }
    store_rank(s, k, &rank, reply, answer);
    if (r->rank_loss != TFA_RANK_REFUSE || !rank.lost)
        return TFA_OK;
    reply->field = TFA_FIELD_CONSTRAINTS;
    reply->index = rank.rank;
    return TFA_E_RANK;
}

int TFA_V(store_wrenches)(const struct state *s, const num *F, uint32_t k, tfa_reply *reply,
                          tfa_answer *answer)
{
    for (uint32_t j = 0; j < s->closing_rows; j++) {
        const uint32_t row = s->closing_row[j];
        if (row % 6 == 2 && s->closing[row / 6].of->unilateral && F[j] < 0)
            answer->flags |= TFA_ANSWER_PULLS;
    }
    return TFA_V(store_held)(s, F, block(s, reply->constraint_wrenches, k));
}

int TFA_V(constraint_forces)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                             tfa_answer *answer)
{
    num *F = task_vector(s, FORCE);
    TFA_V(constraint_errors)(s, k, reply);
    TFA_V(constraint_wanted)(s, r, k, task_vector(s, ERROR));
    if (!s->keeps_force)
        TFA_V(subtract_bias)(s);
    const int status =
        factor_constraints(s, r, k, answer->flags & TFA_ANSWER_ESTIMATED, reply, answer);
    if (status != TFA_OK)
        return status;
    find_force(s, F);
    if (s->keeps_force) {
        TFA_V(least_squares_image)(s, s->force_row);
        TFA_V(subtract_force_rows)(s, s->force_row);
    }
    negate(s, F);
    return TFA_V(store_wrenches)(s, F, k, reply, answer) ? TFA_OK : TFA_E_NOT_COMPUTED;
}

int TFA_V(constraint_residual)(struct state *s, uint32_t k, tfa_reply *reply)
{
    num *rest = task_vector(s, FORCE);
    find_residual(s, rest);
    return TFA_V(store_held)(s, rest, block(s, reply->constraint_residual, k));
}

/* Forward dynamics with the forces of the request and these */
static void accelerate(struct state *s, const tfa_request *r, const num *F, tfa_method method)
{
    TFA_V(load_tau)(s, r);
    TFA_V(constraint_force)(s, F, s->tau);
    TFA_V(gather_on_leaders)(s, s->tau);
    (void)TFA_V(forward_dynamics)(s, method);
}

int TFA_V(answer_constrained)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *answer)
{
    const int status = TFA_V(constraint_forces)(s, r, k, reply, answer);
    if (status != TFA_OK)
        return status;
    if (s->keeps_force)
        TFA_V(aba_outward)(s, s->qdd);
    else
        accelerate(s, r, task_vector(s, FORCE), (tfa_method)answer->method);
    s->keeps_force = 0;
    int finite = TFA_V(unload_qdd)(s, k, reply);
    TFA_V(round_accelerations)(s);
    finite &= TFA_V(constraint_residual)(s, k, reply);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

/* ---- impact ---- */

/* Velocities of the world from the change in s->qdd */
static int unload_velocities(struct state *s, uint32_t k, tfa_reply *reply)
{
    for (uint32_t j = 0; j < s->freedoms; j++)
        s->dx[j] = world_velocity(s, j) + s->qdd[j];
    return TFA_V(unload)(s, s->dx, reply->base_twist ? reply->base_twist + 6 * (size_t)k : NULL,
                         reply->v ? reply->v + (size_t)s->m->v_count * k : NULL);
}

int TFA_V(answer_impact)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                         tfa_answer *answer)
{
    const tfa_method method = s->by.method;
    num *F = task_vector(s, FORCE), *x = task_vector(s, ERROR);
    answer->method = (uint16_t)method;
    TFA_V(constraint_errors)(s, k, reply);
    for (uint32_t j = 0; j < s->closing_rows; j++) {
        const struct relative_motion *m = &s->relative[s->closing_row[j] / 6];
        const uint32_t e = s->closing_row[j] % 6;
        x[j] =
            -m->velocity[e] - num_of(r->stabilisation ? r->stabilisation[0] : 0) * m->position[e];
    }
    (void)TFA_V(factor)(s, method);
    const int estimated =
        r->estimate == TFA_ESTIMATE_ALWAYS || TFA_V(sentinel_asks_estimate)(s, r, method, answer);
    const int status = factor_constraints(s, r, k, estimated, reply, answer);
    if (status != TFA_OK)
        return status;
    for (uint32_t j = 0; j < s->tip_freedoms; j++)
        s->force_row[j] = num_of(0);
    TFA_V(least_squares)(s, s->force_row, x, F);
    negate(s, F);
    TFA_V(load_forces)(s, NULL, NULL);
    TFA_V(constraint_force)(s, F, s->tau);
    TFA_V(gather_on_leaders)(s, s->tau);
    TFA_V(solve)(s, method, s->tau, s->qdd);
    int finite = TFA_V(store_wrenches)(s, F, k, reply, answer);
    finite &= TFA_V(constraint_residual)(s, k, reply);
    finite &= unload_velocities(s, k, reply);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
