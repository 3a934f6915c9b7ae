/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Impact by its definition, of every robot with random constraints, M and J_c by the oracle in
 * quadruple precision:
 *
 *     M (v+ - v) = J_c^T F;   J_c v+ is the residual, 0 where the rank is full;
 *     kinetic energy falls by that of the motion that ends: (v+ - v)^T M v+ = 0 without a residual.
 */
#include "constrained_robot.h"
#include "support/oracle_motion.h"
#include "test.h"

enum { IMPULSE, RESIDUAL, CLOSED, ENERGY, KINDS };

static constrained_law laws[KINDS] = {{"impulse", {1e-13, 1e-9}, {0}},
                                      {"residual", {1e-13, 1e-9}, {0}},
                                      {"closed", {1e-14, 1e-11}, {0}},
                                      {"energy", {1e-13, 1e-9}, {0}}};
static uint32_t cases, full;

typedef struct impact {
    double v[FREEDOMS], F[ROWS], residual[ROWS];
    tfa_rank rank;
} impact;

/* M (v+ - v) - J^T F, and the energy that the impact leaves in the closed motion */
static void check_impulse(const constrained_robot *c, const relative_motion *m, const impact *a,
                          const quad *v, int set)
{
    const uint32_t n = c->robot->n;
    quad error = 0, size = 0, work = 0, most = 0;
    for (uint32_t i = 0; i < n; i++) {
        quad p = 0;
        for (uint32_t j = 0; j < n; j++) {
            const quad term = c->robot->o->Mt[(size_t)i * n + j] * (a->v[j] - v[j]);
            p += term;
            size = larger(size, term);
        }
        work += p * a->v[i];
        most = larger(larger(most, p * a->v[i]), p * v[i]);
        for (uint32_t k = 0; k < 6 * c->count; k++) {
            p -= m->J[(size_t)k * n + i] * a->F[k];
            size = larger(size, m->J[(size_t)k * n + i] * a->F[k]);
        }
        error = larger(error, p);
    }
    constrained_within(c, &laws[IMPULSE], set, error, size);
    if (!a->rank.lost)
        constrained_within(c, &laws[ENERGY], set, work, most);
}

/* Relative to motion before and after: what ends leaves rounding. */
static void check_motion(const constrained_robot *c, const relative_motion *m, const impact *a,
                         const quad *v, int set)
{
    const uint32_t n = c->robot->n;
    uint32_t row[ROWS];
    const uint32_t rows = held_rows(c, row);
    quad error = 0, closed = 0, size = 0;
    for (uint32_t k = 0; k < rows; k++) {
        quad w = 0;
        for (uint32_t j = 0; j < n; j++) {
            w += m->J[(size_t)row[k] * n + j] * a->v[j];
            size = larger(size, m->J[(size_t)row[k] * n + j] * a->v[j]);
            size = larger(size, m->J[(size_t)row[k] * n + j] * v[j]);
        }
        closed = larger(closed, w);
        error = larger(error, w - a->residual[row[k]]);
    }
    constrained_within(c, &laws[RESIDUAL], set, error, size);
    if (!a->rank.lost)
        constrained_within(c, &laws[CLOSED], set, closed,
                           size * (quad)(1 + sqrt(a->rank.condition)));
}

static void check(const constrained_robot *c, tfa_workspace *w, const tfa_request *r, int set)
{
    static relative_motion m;
    static impact a;
    quad v[FREEDOMS];
    const uint32_t n = c->robot->n, six = n - c->robot->nv;
    tfa_reply reply = {.v = a.v + six,
                       .base_twist = a.v,
                       .constraint_wrenches = a.F,
                       .constraint_residual = a.residual,
                       .rank = &a.rank};
    compute_ok(c->robot, w, r, &reply);
    relative_motion_of(c, r, &m);
    for (uint32_t j = 0; j < n; j++)
        v[j] = j < six ? r->base_twist[j] : r->v[j - six];
    check_impulse(c, &m, &a, v, set);
    check_motion(c, &m, &a, v, set);
    full += a.rank.lost == 0;
}

static void law(test_robot *robot)
{
    random_source s = {robot->seed + 31 + robot->base};
    constrained_robot c = {.robot = robot};
    if (robot->n > 100)
        return;
    constrained_draw(&c, &s, 1 + random_below(&s, MOST));
    if (!constrained_open(&c))
        return;
    random_states *states = fixture_states(robot, 9, 1, 0);
    tfa_request r = constrained_request(&c, states);
    r.op = TFA_OP_IMPACT;
    check(&c, c.f128, &r, 0);
    check(&c, c.f64, &r, 1);
    cases++;
    random_states_free(states);
    constrained_close(&c);
}

TEST(impact_by_definition)
{
    for_every_robot(law, false);
    constrained_print(laws, KINDS);
    assert_true(cases > 20 && full > 20);
}

int main(void)
{
    return test_run(NULL, NULL);
}
