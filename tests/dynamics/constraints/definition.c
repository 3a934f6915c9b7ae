/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constrained dynamics against its definition, of every robot with random constraints between its
 * links and the world, frames anywhere on them:
 *
 *     inverse dynamics of the answer, with the constraint forces as wrenches on links, gives tau;
 *     the relative acceleration of the frames is the one wanted, less what a lost rank gives up;
 *     no force stands in a row that is not held.
 *
 * The two determine qdd where the rank is full.
 */
#include "constrained_robot.h"
#include "test.h"

static uint32_t cases, full;
static double worst_force, worst_motion, worst_estimate;
static const double gains[2] = {3, 2};

/* F on the second link, -F on the first, at the origins of the links */
static void push(const relative_motion *m, const double *F, uint32_t k, int side, double out[6])
{
    const vec3 f = mat_apply(&m->R[k][0], vec_from(F)), n = mat_apply(&m->R[k][0], vec_from(F + 3));
    const vec3 moment = vec_add(n, vec_cross(m->arm[k][side], f));
    for (int e = 0; e < 3; e++) {
        out[e] = (double)(side ? f.x[e] : -f.x[e]);
        out[3 + e] = (double)(side ? moment.x[e] : -moment.x[e]);
    }
}

/* Inverse dynamics of the answer with these wrenches: the forces of the request */
static void check_forces(const constrained_robot *c, const tfa_request *state,
                         const relative_motion *m, const constrained_answer *a, double bound)
{
    const test_robot *robot = c->robot;
    const uint32_t six = robot->n - robot->nv;
    double got[FREEDOMS], wrenches[12 * MOST], size = 1, error = 0;
    tfa_request r = *state;
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.qdd = a->qdd + six;
    r.base_acceleration = a->qdd;
    r.frame = TFA_FRAME_LOCAL_WORLD_ALIGNED;
    r.wrenches = wrenches;
    for (uint32_t k = 0; k < c->count; k++)
        for (int side = 0; side < 2; side++) {
            if (c->link[k][side] == WORLD)
                continue;
            push(m, a->F + 6 * k, k, side, wrenches + 6 * r.wrench_count);
            r.wrench_frames[r.wrench_count++] = c->link[k][side];
        }
    for (uint32_t k = 0; k < 6 * r.wrench_count; k++)
        size = fmax(size, fabs(wrenches[k]));
    tfa_reply reply = {.tau = got + six, .base_wrench = got};
    compute_ok(robot, c->f128, &r, &reply);
    for (uint32_t j = 0; j < robot->n; j++)
        error = fmax(error, fabs(got[j] - (j < six ? state->base_wrench[j] : state->tau[j - six])));
    assert_within(robot, "forces", error / size, bound, &worst_force);
}

/* Row i: dw/dt against what was wanted. Returns the error, in `size` the largest number in it. */
static double check_row(const constrained_robot *c, const relative_motion *m,
                        const constrained_answer *a, uint32_t i, double *size)
{
    quad rate = m->bias[i];
    assert_true(fabs((double)m->velocity[i] - a->velocity[i]) <=
                1e-12 * (1 + fabs(a->velocity[i])));
    if (i % 6 < 3)
        assert_true(fabs((double)m->position[i] - a->position[i]) <= 1e-12);
    if (!(c->constraint[i / 6].rows >> i % 6 & 1)) {
        assert_true(a->F[i] == 0 && a->residual[i] == 0);
        return 0;
    }
    *size = fmax(*size, fabs((double)rate));
    for (uint32_t j = 0; j < c->robot->n; j++) {
        const quad term = m->J[(size_t)i * c->robot->n + j] * a->qdd[j];
        rate += term;
        *size = fmax(*size, fabs((double)term));
    }
    const double wanted = -gains[0] * a->position[i] - gains[1] * a->velocity[i];
    return fabs((double)rate - wanted - (a->rank.lost ? a->residual[i] : 0));
}

static void check(const constrained_robot *c, tfa_workspace *w, const tfa_request *r, double bound)
{
    static relative_motion m;
    static constrained_answer a;
    double error = 0, size = 1;
    constrained_ask(c, w, r, &a);
    relative_motion_of(c, r, &m);
    for (uint32_t i = 0; i < 6 * c->count; i++)
        error = fmax(error, check_row(c, &m, &a, i, &size));
    full += a.rank.lost == 0;
    assert_within(c->robot, "accelerations", error / size, bound * (1 + sqrt(a.rank.condition)),
                  &worst_motion);
    check_forces(c, r, &m, &a, bound);
}

/* Both estimates, relative to the accelerations with and without the constraints' forces, against
 * quadruple precision */
static void check_estimate(const constrained_robot *c, tfa_request r)
{
    static constrained_answer a, exact;
    const uint32_t n = c->robot->n, six = n - c->robot->nv;
    double free[FREEDOMS], error[FREEDOMS];
    r.estimate = TFA_ESTIMATE_ALWAYS;
    constrained_ask(c, c->f64, &r, &a);
    constrained_ask(c, c->f128, &r, &exact);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    tfa_reply reply = {.qdd = free + six, .base_acceleration = free};
    compute_ok(c->robot, c->f128, &r, &reply);
    for (uint32_t j = 0; j < n; j++)
        error[j] = a.qdd[j] - exact.qdd[j];
    const double size = norm2(free, n) + norm2(exact.qdd, n),
                 estimate = a.answer.error_estimate + a.rank.error_estimate;
    assert_within(c->robot, "error over its estimate", norm2(error, n) / (size * estimate), 3,
                  &worst_estimate);
}

static void law(test_robot *robot)
{
    random_source s = {robot->seed + 77 + robot->base};
    constrained_robot c = {.robot = robot};
    if (robot->n > 100)
        return;
    constrained_draw(&c, &s, 1 + random_below(&s, MOST));
    if (!constrained_open(&c))
        return;
    random_states *states = fixture_states(robot, 5, 1, 0);
    tfa_request r = constrained_request(&c, states);
    r.stabilisation = gains;
    check(&c, c.f128, &r, 1e-13);
    check(&c, c.f64, &r, 1e-9);
    check_estimate(&c, r);
    cases++;
    random_states_free(states);
    constrained_close(&c);
}

TEST(constrained_dynamics_by_definition)
{
    for_every_robot(law, false);
    print_message("  %u robots, %u answers of full rank; forces within %.1e, accelerations %.1e; "
                  "errors %.2f of their estimates at most\n",
                  (unsigned)cases, (unsigned)full, worst_force, worst_motion, worst_estimate);
    assert_true(cases > 20 && full > 20);
}
