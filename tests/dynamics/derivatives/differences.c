/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Central differences of forward and inverse dynamics. See differences.h.
 */
#include "differences.h"

#include "support/step.h"
#include "test.h"

/* Steps h, h/2, h/4: an error of (h / s)^6, where friction changes over velocities of s = 0.01, and
 * 1e-16 / h by the answers' doubles */
#define STEP 0x1p-12
#define STEPS 3

struct point {
    double q[2 * DIFFERENCE_MAX], v[DIFFERENCE_MAX], tau[DIFFERENCE_MAX];
    double pose[7], twist[6], wrench[6];
};

/* ---- motion along a freedom ---- */

static void move(const difference_robot *robot, struct point *x, uint32_t freedom, double step)
{
    double v[DIFFERENCE_MAX] = {0};
    v[freedom] = 1;
    step_model(robot->model, x->q, x->pose, v, step, x->q, x->pose);
}

static void speed_up(const difference_robot *robot, struct point *x, uint32_t freedom, double step)
{
    const uint32_t six = robot->six;
    *(freedom < six ? &x->twist[freedom] : &x->v[freedom - six]) += step;
}

static void push(const difference_robot *robot, struct point *x, uint32_t freedom, double step)
{
    const uint32_t six = robot->six;
    *(freedom < six ? &x->wrench[freedom] : &x->tau[freedom - six]) += step;
}

/* ---- points ---- */

static struct point copy_of(const difference_robot *robot, const tfa_request *r)
{
    struct point x = {0};
    assert_true(robot->n <= DIFFERENCE_MAX && robot->nq <= 2 * DIFFERENCE_MAX);
    memcpy(x.q, r->q, robot->nq * sizeof(double));
    memcpy(x.v, r->v, robot->nv * sizeof(double));
    memcpy(x.tau, r->tau, robot->nv * sizeof(double));
    if (robot->six) {
        memcpy(x.pose, r->base_pose, sizeof x.pose);
        memcpy(x.twist, r->base_twist, sizeof x.twist);
        memcpy(x.wrench, r->base_wrench, sizeof x.wrench);
    }
    return x;
}

static tfa_request at_point(const tfa_request *r, const struct point *x)
{
    tfa_request at = *r;
    at.q = x->q;
    at.v = x->v;
    at.tau = x->tau;
    at.base_pose = x->pose;
    at.base_twist = x->twist;
    at.base_wrench = x->wrench;
    return at;
}

/* What is derived, in quadruple precision, base first */
static void values_at(const difference_robot *robot, const tfa_request *r, difference_by by,
                      const struct point *x, double *out)
{
    tfa_request at = at_point(r, x);
    tfa_reply reply = {.qdd = out + robot->six, .base_acceleration = out};
    at.op = TFA_OP_FORWARD_DYNAMICS;
    if (by >= ID_BY_Q) {
        at.op = TFA_OP_INVERSE_DYNAMICS;
        reply = (tfa_reply){.tau = out + robot->six, .base_wrench = out};
    }
    const int status = tfa_compute(robot->quad, &at, &reply);
    if (status != TFA_OK)
        fail_msg("%s: op %d: %s", robot->name, (int)at.op, tfa_status_text(status));
}

void difference_column(const difference_robot *robot, const tfa_request *r, difference_by by,
                       uint32_t freedom, double *column)
{
    static void (*const changes[])(const difference_robot *, struct point *, uint32_t, double) = {
        [BY_Q] = move, [BY_V] = speed_up, [BY_TAU] = push, [ID_BY_Q] = move, [ID_BY_V] = speed_up};
    double t[STEPS][DIFFERENCE_MAX], plus[DIFFERENCE_MAX], minus[DIFFERENCE_MAX];
    const uint32_t n = robot->n;
    for (int k = 0; k < STEPS; k++) {
        const double h = STEP / (1 << k);
        struct point up = copy_of(robot, r), down = copy_of(robot, r);
        changes[by](robot, &up, freedom, h);
        changes[by](robot, &down, freedom, -h);
        values_at(robot, r, by, &up, plus);
        values_at(robot, r, by, &down, minus);
        for (uint32_t i = 0; i < n; i++)
            t[k][i] = (plus[i] - minus[i]) / (2 * h);
    }
    for (int order = 1; order < STEPS; order++) /* Richardson */
        for (int k = STEPS - 1; k >= order; k--)
            for (uint32_t i = 0; i < n; i++)
                t[k][i] += (t[k][i] - t[k - 1][i]) / ((1 << 2 * order) - 1);
    memcpy(column, t[STEPS - 1], n * sizeof *column);
}

double difference_largest(const double *x, size_t n)
{
    double most = 0;
    for (size_t k = 0; k < n; k++)
        if (!(fabs(x[k]) <= most)) /* once NaN, always */
            most = isnan(most) ? most : fabs(x[k]);
    return most;
}

double difference_size(const difference_robot *robot, const tfa_request *r, difference_by by,
                       const double *matrix)
{
    double value[DIFFERENCE_MAX];
    struct point x = copy_of(robot, r);
    values_at(robot, r, by, &x, value);
    const double size = fmax(difference_largest(matrix, (size_t)robot->n * robot->n),
                             0.01 * difference_largest(value, robot->n));
    return size > 0 ? size : 1;
}
