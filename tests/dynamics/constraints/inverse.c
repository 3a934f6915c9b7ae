/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inverse dynamics under constraints by its definition, of every robot with random constraints and
 * random joints without a motor, M, h and J_c by the oracle in quadruple precision. u: freedoms
 * without a motor, a: those with one.
 *
 *     M qdd + h = tau + J_c^T F in every freedom;   J_c qdd + J_c-dot v - a is the residual;
 *     J_u tau_u = 0: no forces leave less to freedoms without a motor;
 *     tau_a^T W J_a^T dF = 0 for all dF with J_u^T dF = 0: no forces cost less.
 */
#include "constrained_robot.h"
#include "support/oracle_motion.h"
#include "test.h"

enum { MOTION, RESIDUAL, LEFT, COST, KINDS };

static constrained_law laws[KINDS] = {{"motion", {1e-13, 1e-12}, {0}},
                                      {"residual", {1e-12, 1e-9}, {0}},
                                      {"left", {1e-12, 1e-9}, {0}},
                                      {"cost", {1e-11, 1e-8}, {0}}};
static uint32_t cases, met, underactuated;

typedef struct answer {
    double tau[FREEDOMS], F[ROWS], residual[ROWS];
    tfa_rank rank;
} answer;

typedef struct problem {
    constrained_robot *c;
    const tfa_request *r;
    relative_motion m;
    uint32_t n, six, rows, row[ROWS];
    bool motor[FREEDOMS];
    quad qdd[FREEDOMS], h[FREEDOMS], b[FREEDOMS]; /* b = M qdd + h */
    answer a;
} problem;

static quad J(const problem *p, uint32_t k, uint32_t j)
{
    return p->m.J[(size_t)p->row[k] * p->n + j];
}

/* ---- laws ---- */

static void check_motion(const problem *p, int set)
{
    quad error = 0, size = 0;
    for (uint32_t i = 0; i < p->n; i++) {
        quad rest = p->h[i] - p->a.tau[i];
        size = larger(size, p->h[i]);
        for (uint32_t j = 0; j < p->n; j++) {
            const quad term = p->c->robot->o->Mt[(size_t)i * p->n + j] * p->qdd[j];
            rest += term;
            size = larger(size, term);
        }
        for (uint32_t k = 0; k < p->rows; k++) {
            rest -= J(p, k, i) * p->a.F[p->row[k]];
            size = larger(size, J(p, k, i) * p->a.F[p->row[k]]);
        }
        error = larger(error, rest);
    }
    constrained_within(p->c, &laws[MOTION], set, error, size);
}

static void check_residual(const problem *p, int set)
{
    quad error = 0, size = 1;
    for (uint32_t k = 0; k < p->rows; k++) {
        const uint32_t i = p->row[k];
        quad rate = p->m.bias[i] - p->r->constraint_acceleration[i];
        size = larger(size, rate);
        for (uint32_t j = 0; j < p->n; j++) {
            rate += J(p, k, j) * p->qdd[j];
            size = larger(size, J(p, k, j) * p->qdd[j]);
        }
        error = larger(error, rate - p->a.residual[i]);
    }
    constrained_within(p->c, &laws[RESIDUAL], set, error, size);
}

/* What freedoms without a motor keep, against what the constraints could take */
static void check_left(const problem *p, int set)
{
    quad error = 0, size = 0, most = 0, left = 0;
    for (uint32_t j = 0; j < p->n; j++)
        most = larger(most, p->a.tau[j]);
    for (uint32_t k = 0; k < p->rows; k++) {
        quad sum = 0;
        for (uint32_t j = 0; j < p->n; j++) {
            if (p->motor[j])
                continue;
            sum += J(p, k, j) * p->a.tau[j];
            size = larger(size, J(p, k, j));
            left = larger(left, p->a.tau[j]);
        }
        error = larger(error, sum);
    }
    for (uint32_t k = 0; k < p->rows; k++)
        most = larger(most, p->a.F[p->row[k]]);
    constrained_within(p->c, &laws[LEFT], set, error, size * most);
    met += left < most * (quad)1e-9;
}

/* Orthonormal columns of J_u, by Gram-Schmidt twice. Returns their number. */
static uint32_t range_of(const problem *p, quad Q[ROWS][ROWS])
{
    uint32_t rank = 0;
    for (uint32_t j = 0; j < p->n && rank < p->rows; j++) {
        quad *q = Q[rank], size = 0, left = 0;
        if (p->motor[j])
            continue;
        for (uint32_t k = 0; k < p->rows; k++) {
            q[k] = J(p, k, j);
            size += q[k] * q[k];
        }
        for (uint32_t pass = 0; pass < 2 * rank; pass++) {
            quad along = 0;
            for (uint32_t k = 0; k < p->rows; k++)
                along += Q[pass % rank][k] * q[k];
            for (uint32_t k = 0; k < p->rows; k++)
                q[k] -= along * Q[pass % rank][k];
        }
        for (uint32_t k = 0; k < p->rows; k++)
            left += q[k] * q[k];
        if (!(left > (quad)1e-24 * size))
            continue;
        for (uint32_t k = 0; k < p->rows; k++)
            q[k] /= quad_sqrt(left);
        rank++;
    }
    return rank;
}

/* The gradient of the cost by F, less its part in the range of J_u */
static void check_cost(const problem *p, int set)
{
    static quad Q[ROWS][ROWS];
    const uint32_t rank = range_of(p, Q);
    quad g[ROWS] = {0}, size = 0, error = 0;
    for (uint32_t k = 0; k < p->rows; k++)
        for (uint32_t j = 0; j < p->n; j++)
            if (p->motor[j]) {
                const double w = p->r->torque_weights ? p->r->torque_weights[j - p->six] : 1;
                g[k] += J(p, k, j) * w * p->a.tau[j];
                size = larger(size, J(p, k, j) * w * p->b[j]); /* the cost may be 0 */
            }
    for (uint32_t e = 0; e < rank; e++) {
        quad along = 0;
        for (uint32_t k = 0; k < p->rows; k++)
            along += Q[e][k] * g[k];
        for (uint32_t k = 0; k < p->rows; k++)
            g[k] -= along * Q[e][k];
    }
    for (uint32_t k = 0; k < p->rows; k++)
        error = larger(error, g[k]);
    constrained_within(p->c, &laws[COST], set, error, size * (quad)(1 + sqrt(p->a.rank.condition)));
}

/* ---- one robot ---- */

static void check(problem *p, tfa_workspace *w, int set)
{
    tfa_reply reply = {.tau = p->a.tau + p->six,
                       .base_wrench = p->a.tau,
                       .constraint_wrenches = p->a.F,
                       .constraint_residual = p->a.residual,
                       .rank = &p->a.rank};
    compute_ok(p->c->robot, w, p->r, &reply);
    check_motion(p, set);
    check_residual(p, set);
    check_left(p, set);
    check_cost(p, set);
}

/* Two thirds of the joints have a motor. */
static void choose_motors(problem *p, random_source *s)
{
    const tfa_model *m = p->c->robot->model;
    for (uint32_t k = 0; k < tfa_model_joint_count(m); k++) {
        const tfa_joint_info joint = tfa_model_joint(m, k);
        const bool has = random_below(s, 3) != 0;
        if (has)
            p->c->actuated[p->c->actuated_count++] = joint.name;
        for (uint32_t e = 0; e < joint.v_count; e++)
            p->motor[p->six + joint.v_index + e] = has;
    }
    for (uint32_t j = p->six; p->c->actuated_count == 0 && j < p->n; j++)
        p->motor[j] = true; /* an empty list is that of all */
}

static void law(test_robot *robot)
{
    static problem p;
    static double weights[FREEDOMS], acceleration[ROWS], qdd[FREEDOMS];
    random_source s = {robot->seed + 53 + robot->base};
    constrained_robot c = {.robot = robot};
    if (robot->n > 64)
        return;
    p = (problem){.c = &c, .n = robot->n, .six = robot->n - robot->nv};
    choose_motors(&p, &s);
    constrained_draw(&c, &s, 1 + random_below(&s, MOST));
    if (!constrained_open(&c))
        return;
    random_states *states = fixture_states(robot, 3, 1, 0);
    tfa_request r = constrained_request(&c, states);
    for (uint32_t j = 0; j < robot->nv; j++)
        weights[j] = random_uniform(&s, 0.2, 5);
    for (uint32_t k = 0; k < ROWS; k++)
        acceleration[k] = random_uniform(&s, -5, 5);
    for (uint32_t j = 0; j < robot->n; j++)
        p.qdd[j] = qdd[j] = random_uniform(&s, -5, 5);
    r.op = TFA_OP_CONSTRAINED_INVERSE_DYNAMICS;
    r.rank_loss = TFA_RANK_TRUNCATE;
    r.torque_weights = random_below(&s, 2) ? weights : NULL;
    r.constraint_acceleration = acceleration;
    r.base_acceleration = qdd;
    r.qdd = qdd + p.six;
    p.r = &r;
    p.rows = held_rows(&c, p.row);
    relative_motion_of(&c, &r, &p.m);
    oracle_bias_force(robot->o, p.h);
    for (uint32_t j = 0; j < p.n * p.n; j++) {
        p.b[j / p.n] += j % p.n ? 0 : p.h[j / p.n];
        p.b[j / p.n] += robot->o->Mt[j] * p.qdd[j % p.n];
    }
    check(&p, c.f128, 0);
    check(&p, c.f64, 1);
    cases++;
    underactuated += p.six || c.actuated_count;
    random_states_free(states);
    constrained_close(&c);
}

TEST(constrained_inverse_dynamics_by_definition)
{
    for_every_robot(law, false);
    constrained_print(laws, KINDS);
    print_message("  %u robots, %u of %u answers leave nothing to freedoms without a motor\n",
                  (unsigned)cases, (unsigned)met, 2 * (unsigned)cases);
    assert_true(cases > 20 && underactuated > 20 && met > 10 && met < 2 * cases);
}

int main(void)
{
    return test_run(NULL, NULL);
}
