/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Central differences of forward dynamics. See differences.h.
 */
#include "differences.h"

#include "test.h"

/* Steps h, h/2, h/4: an error of h^6, and 1e-16 / h by the answers' doubles */
#define STEP 0x1p-10
#define STEPS 3

struct point {
    double *q, *v, *tau;
    double pose[7], twist[6], wrench[6];
};

/* ---- motion along a freedom ---- */

/* quat <- quat exp(angle axis), and a position moved along an axis of the frame */
static void rotate_axis(double quat[4], int axis, double angle)
{
    const double c = cos(angle / 2), s = sin(angle / 2);
    const double d[4] = {axis == 0 ? s : 0, axis == 1 ? s : 0, axis == 2 ? s : 0, c};
    const double x = quat[0], y = quat[1], z = quat[2], w = quat[3];
    quat[0] = w * d[0] + x * d[3] + y * d[2] - z * d[1];
    quat[1] = w * d[1] - x * d[2] + y * d[3] + z * d[0];
    quat[2] = w * d[2] + x * d[1] - y * d[0] + z * d[3];
    quat[3] = w * d[3] - x * d[0] - y * d[1] - z * d[2];
}

static void shift(double *position, const double quat[4], int axis, double length)
{
    const double x = quat[0], y = quat[1], z = quat[2], w = quat[3];
    const double R[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                         2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                         2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    for (int k = 0; k < 3; k++)
        position[k] += length * R[3 * k + axis];
}

static void move_pose(double pose[7], uint32_t freedom, double step)
{
    double *quat = pose + 3;
    const double size =
        sqrt(quat[0] * quat[0] + quat[1] * quat[1] + quat[2] * quat[2] + quat[3] * quat[3]);
    for (int k = 0; k < 4; k++)
        quat[k] /= size;
    if (freedom < 3)
        shift(pose, quat, (int)freedom, step);
    else
        rotate_axis(quat, (int)freedom - 3, step);
}

static void move(const difference_robot *robot, struct point *x, uint32_t freedom, double step)
{
    const uint32_t six = robot->six;
    if (freedom < six) {
        move_pose(x->pose, freedom, step);
        return;
    }
    uint32_t j = 0;
    tfa_joint_info joint = tfa_model_joint(robot->model, j);
    while (freedom - six >= joint.v_index + joint.v_count)
        joint = tfa_model_joint(robot->model, ++j);
    const uint32_t k = freedom - six - joint.v_index;
    double *q = x->q + joint.q_index;
    if (joint.type == TFA_JOINT_FLOATING) {
        move_pose(q, k, step);
    } else if (joint.type == TFA_JOINT_PLANAR && k < 2) {
        q[0] += step * (k == 0 ? cos(q[2]) : -sin(q[2]));
        q[1] += step * (k == 0 ? sin(q[2]) : cos(q[2]));
    } else {
        q[k] += step;
    }
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
    struct point x = {malloc((robot->nq + 1) * sizeof(double)),
                      malloc((robot->nv + 1) * sizeof(double)),
                      malloc((robot->nv + 1) * sizeof(double)),
                      {0},
                      {0},
                      {0}};
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

static void release(struct point *x)
{
    free(x->q);
    free(x->v);
    free(x->tau);
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

/* Accelerations in quadruple precision, base first */
static void accelerations(const difference_robot *robot, const tfa_request *r,
                          const struct point *x, double *out)
{
    tfa_request at = at_point(r, x);
    tfa_reply reply = {.qdd = out + robot->six, .base_acceleration = out};
    at.op = TFA_OP_FORWARD_DYNAMICS;
    const int status = tfa_compute(robot->quad, &at, &reply);
    if (status != TFA_OK)
        fail_msg("%s: forward dynamics: %s", robot->name, tfa_status_text(status));
}

void difference_column(const difference_robot *robot, const tfa_request *r, difference_by by,
                       uint32_t freedom, double *column)
{
    static void (*const changes[])(const difference_robot *, struct point *, uint32_t,
                                   double) = {[BY_Q] = move, [BY_V] = speed_up, [BY_TAU] = push};
    double t[STEPS][DIFFERENCE_MAX], plus[DIFFERENCE_MAX], minus[DIFFERENCE_MAX];
    const uint32_t n = robot->n;
    assert_true(n <= DIFFERENCE_MAX);
    for (int k = 0; k < STEPS; k++) {
        const double h = STEP / (1 << k);
        struct point up = copy_of(robot, r), down = copy_of(robot, r);
        changes[by](robot, &up, freedom, h);
        changes[by](robot, &down, freedom, -h);
        accelerations(robot, r, &up, plus);
        accelerations(robot, r, &down, minus);
        for (uint32_t i = 0; i < n; i++)
            t[k][i] = (plus[i] - minus[i]) / (2 * h);
        release(&up);
        release(&down);
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

/* The largest entry; a matrix of zeros has the size of the accelerations. */
double difference_size(const difference_robot *robot, const tfa_request *r, const double *matrix)
{
    double qdd[DIFFERENCE_MAX];
    struct point x = copy_of(robot, r);
    accelerations(robot, r, &x, qdd);
    release(&x);
    const double size = fmax(difference_largest(matrix, (size_t)robot->n * robot->n),
                             0.01 * difference_largest(qdd, robot->n));
    return size > 0 ? size : 1;
}
