/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of forward dynamics against central differences, on the robots of the fixture, with
 * wrenches in three frames and locked joints. derivatives_reduced.c has robots that the library
 * reduces, payloads and damping.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "differences.h"
#include "support/fixture.h"
#include "support/sanitized.h"
#include "test.h"

#define ROBOT_MAX 60 /* freedoms: larger robots take minutes */
#ifdef SANITIZED
static const uint32_t freedoms_max = 12;
#else
static const uint32_t freedoms_max = ROBOT_MAX;
#endif

/* Relative to the largest entry by rows: differences, and double against quadruple precision */
#define BOUND 1e-9
#define BOUND_F64 1e-9
static double worst[3], worst_f64[3];

struct matrices {
    double *dq, *dv, *dtau;
};

static difference_robot quad_of(const test_robot *robot)
{
    return (difference_robot){robot->name,          robot->model, robot->f128, robot->n,
                              robot->n - robot->nv, robot->nq,    robot->nv};
}

static void compare_columns(const test_robot *robot, const tfa_request *r, difference_by by,
                            const double *got, const char *what, double *worst_of)
{
    const uint32_t n = robot->n;
    const difference_robot quad = quad_of(robot);
    const double size = difference_size(&quad, r, got);
    double column[DIFFERENCE_MAX];
    /* every column of random robots, some of files */
    const uint32_t step = robot->random ? 1 : n / 5 + 1;
    for (uint32_t j = robot->random ? 0 : (uint32_t)robot->seed % step; j < n; j += step) {
        difference_column(&quad, r, by, j, column);
        for (uint32_t i = 0; i < n; i++)
            column[i] -= got[(size_t)n * i + j];
        assert_within(robot, what, difference_largest(column, n) / size, BOUND, worst_of);
    }
}

static void derivatives_of(const test_robot *robot, tfa_workspace *w, const tfa_request *r,
                           struct matrices *m)
{
    tfa_reply reply = {.dqdd_dq = m->dq, .dqdd_dv = m->dv, .dqdd_dtau = m->dtau};
    tfa_request ask = *r;
    ask.op = TFA_OP_DERIVATIVES;
    compute_ok(robot, w, &ask, &reply);
}

static void check(const test_robot *robot, const tfa_request *r)
{
    static double memory[6][DIFFERENCE_MAX * DIFFERENCE_MAX];
    struct matrices quad = {memory[0], memory[1], memory[2]},
                    got = {memory[3], memory[4], memory[5]};
    const size_t entries = (size_t)robot->n * robot->n;
    derivatives_of(robot, robot->f128, r, &quad);
    derivatives_of(robot, robot->f64, r, &got);
    compare_columns(robot, r, BY_Q, quad.dq, "dqdd/dq", &worst[0]);
    compare_columns(robot, r, BY_V, quad.dv, "dqdd/dv", &worst[1]);
    compare_columns(robot, r, BY_TAU, quad.dtau, "dqdd/dtau", &worst[2]);
    for (int k = 0; k < 3; k++) {
        double *a = memory[k], *b = memory[3 + k];
        const difference_robot in_quad = quad_of(robot);
        const double size = difference_size(&in_quad, r, a);
        for (size_t e = 0; e < entries; e++)
            b[e] -= a[e];
        assert_within(robot, "double precision", difference_largest(b, entries) / size, BOUND_F64,
                      &worst_f64[k]);
    }
}

static void law(test_robot *robot)
{
    if (robot->n > freedoms_max)
        return;
    random_states *x = fixture_states(robot, 31, 1, 2);
    tfa_request r = fixture_request(robot, x);
    r.refine = TFA_REFINE_DEFAULT;
    r.estimate = TFA_ESTIMATE_NEVER;
    for (int frame = 0; frame < 3; frame++) {
        r.frame = (tfa_reference_frame)frame;
        check(robot, &r);
        if (r.wrench_count == 0 || robot->n > 40)
            break;
    }
    random_states_free(x);
}

TEST(derivatives_are_limits_of_differences)
{
    for_every_robot(law, false);
    for (int k = 0; k < 3; k++)
        print_message("  %-10s differences %.2g, f64 %.2g\n",
                      (const char *[]){"dqdd/dq", "dqdd/dv", "dqdd/dtau"}[k], worst[k],
                      worst_f64[k]);
}

/* A locked joint has no acceleration, whatever changes; the others are those of the robot with it
 * fixed. */
static void locked(test_robot *robot)
{
    const uint32_t joint = 0;
    if (robot->n > freedoms_max || !robot->random || robot->nv < 2 ||
        tfa_model_summarise(robot->model).mimics)
        return;
    random_states *x = fixture_states(robot, 32, 1, 0);
    tfa_request r = fixture_request(robot, x);
    r.locked = &joint;
    r.locked_count = 1;
    r.estimate = TFA_ESTIMATE_NEVER;
    check(robot, &r);
    random_states_free(x);
}

EVERY_ROBOT(locked_joints, locked, true)

TEST(methods_and_sizes_are_checked)
{
    test_robot robot;
    assert_int_equal(fixture_open(0, TFA_BASE_FIXED, &robot), 1);
    random_states *x = fixture_states(&robot, 1, 1, 0);
    tfa_request r = fixture_request(&robot, x);
    tfa_reply reply = {0};
    r.op = TFA_OP_DERIVATIVES;
    r.method = TFA_METHOD_TFA;
    assert_int_equal(tfa_compute(robot.f64, &r, &reply), TFA_E_METHOD);
    assert_int_equal(reply.field, TFA_FIELD_METHOD);
    random_states_free(x);
    fixture_close(&robot);
}
