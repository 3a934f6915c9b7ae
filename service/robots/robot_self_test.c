/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Is a robot fit to answer? Checked alone, before anybody is served, and through a worker.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/log.h"
#include "robot.h"
#include "worker/local_client.h"
#include "worker/posture.h"

#define RESIDUAL 1e-6 /* of the forces: a wrong model is wrong by far more, rounding by far less */
#define SELF_TEST_NS 100000000u
#define SELF_TEST_TRIES 100 /* 10 s: a loaded machine may be slow, a robot may be large */

/* ---- alone: the equation of motion ---- */

/* The state that is checked and both sides of M qdd + h = tau. */
typedef struct motion {
    double *q, *v, *tau, *qdd, *back, *h;
    double base_acceleration[6], base_back[6], base_h[6];
} motion;

static const double check_pose[7] = {0, 0, 0, 0, 0, 0.6, 0.8};
static const double check_twist[6] = {0.1, -0.2, 0.3, 0.2, 0.1, -0.3};
static const double check_wrench[6] = {1, 2, -3, 0.3, 0.2, 0.1};

/* A state in which nothing is zero or aligned, always the same. */
static void set_motion(const tfa_robot *robot, motion *m)
{
    tfa_posture_set(robot->model, 0.1, check_pose + 3, m->q);
    for (uint32_t i = 0; i < robot->shape.v_count; i++) {
        m->v[i] = 0.3 - 0.1 * (i % 7);
        m->tau[i] = 1 - 0.4 * (i % 6);
    }
}

static double largest(const double *x, size_t n)
{
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

/* |tau - back| over |tau| + |h| + |back - h|, where back = M qdd + h. */
static double residual(const double *tau, const double *back, const double *h, size_t n,
                       double *forces)
{
    double most = 0;
    for (size_t i = 0; i < n; i++) {
        most = fmax(most, fabs(tau[i] - back[i]));
        *forces = fmax(*forces, fabs(back[i] - h[i]));
    }
    *forces = fmax(*forces, fmax(largest(tau, n), largest(h, n)));
    return most;
}

static int solve_motion(tfa_workspace *w, const tfa_robot *robot, motion *m)
{
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .estimate = TFA_ESTIMATE_NEVER,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = 1,
                     .q = m->q,
                     .v = m->v,
                     .tau = m->tau};
    if (robot->shape.base_freedoms) {
        r.base_pose = check_pose;
        r.base_twist = check_twist;
        r.base_wrench = check_wrench;
    }
    tfa_reply forward = {.qdd = m->qdd, .base_acceleration = m->base_acceleration};
    tfa_reply back = {.tau = m->back, .base_wrench = m->base_back};
    tfa_reply bias = {.tau = m->h, .base_wrench = m->base_h};
    int status = tfa_compute(w, &r, &forward);
    if (status == TFA_OK && tfa_model_mode_count(robot->model)) {
        r.method = TFA_METHOD_DCA;
        back = (tfa_reply){.qdd = m->back, .base_acceleration = m->base_back};
        return tfa_compute(w, &r, &back);
    }
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.tau = r.base_wrench = NULL;
    if (status == TFA_OK)
        status = tfa_compute(w, &r, &bias);
    r.qdd = m->qdd;
    r.base_acceleration = robot->shape.base_freedoms ? m->base_acceleration : NULL;
    return status == TFA_OK ? tfa_compute(w, &r, &back) : status;
}

/* Flexible links have no inverse dynamics: two methods must agree. */
static int check_methods(const tfa_robot *robot, const motion *m)
{
    double size = 0, most = residual(m->qdd, m->back, m->back, robot->shape.v_count, &size);
    if (robot->shape.base_freedoms)
        most = fmax(most, residual(m->base_acceleration, m->base_back, m->base_back, 6, &size));
    if (most <= RESIDUAL * size)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "robot '%s': self-test: dca misses the accelerations by %.3g of %.3g",
            robot->name, most, size);
    return TFA_E_NOT_COMPUTED;
}

static int check_residual(const tfa_robot *robot, const motion *m)
{
    double forces = 0, most = residual(m->tau, m->back, m->h, robot->shape.v_count, &forces);
    if (robot->shape.base_freedoms)
        most = fmax(most, residual(check_wrench, m->base_back, m->base_h, 6, &forces));
    if (most <= RESIDUAL * forces)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "robot '%s': self-test: M qdd + h misses tau by %.3g of %.3g",
            robot->name, most, forces);
    return TFA_E_NOT_COMPUTED;
}

int tfa_robot_verify(const tfa_robot *robot)
{
    const size_t n = (robot->shape.q_count > robot->shape.v_count ? robot->shape.q_count
                                                                  : robot->shape.v_count) +
                     1;
    double *memory = calloc(6 * n, sizeof *memory);
    tfa_workspace *w = NULL;
    if (!memory)
        return TFA_E_MEMORY;
    motion m = {
        memory, memory + n, memory + 2 * n, memory + 3 * n, memory + 4 * n, memory + 5 * n, {0},
        {0},    {0}};
    set_motion(robot, &m);
    int status = tfa_workspace_create(robot->model, NULL, &w);
    if (status == TFA_OK)
        status = solve_motion(w, robot, &m);
    if (status == TFA_OK)
        status = tfa_model_mode_count(robot->model) ? check_methods(robot, &m)
                                                    : check_residual(robot, &m);
    else if (tfa_wire_has_answers(status))
        status = TFA_OK; /* singular at this q: it was answered all the same */
    tfa_workspace_free(w);
    free(memory);
    return status;
}

/* ---- through a worker ---- */

/* q = 0, but quaternions are 0 0 0 1. */
static void set_zero(const tfa_robot *robot, double *q)
{
    static const double unit[4] = {0, 0, 0, 1};
    memset(q, 0, robot->shape.q_count * sizeof *q);
    tfa_posture_set_quaternions(robot->model, unit, q);
}

static int request_zero_pose(tfa_local_client *local_client, const double *q)
{
    static const double pose[7] = {0, 0, 0, 0, 0, 0, 1};
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = q,
                                 .base_pose = local_client->shape.base_freedoms ? pose : NULL};
    tfa_wire_reply_shape reply_shape;
    tfa_reply reply;
    int status =
        tfa_wire_encode_request(&local_client->shape, &request, tfa_wire_want(&request, NULL), 1, 0,
                                tfa_ring_next_request(&local_client->ring), &reply_shape, NULL);
    if (status != TFA_OK)
        return status;
    tfa_local_client_send(local_client);
    int tries = 0;
    while (!tfa_local_client_wait(local_client, 0, SELF_TEST_NS))
        if (++tries == SELF_TEST_TRIES)
            return TFA_E_TIMEOUT;
    (void)tfa_wire_decode_reply(tfa_ring_oldest_reply(&local_client->ring), &reply);
    /* a robot may be singular at q = 0; it was answered all the same */
    return tfa_wire_has_answers(reply.status) ? TFA_OK : reply.status;
}

int tfa_robot_self_test(const tfa_robot *robot, tfa_worker *worker, uint32_t index)
{
    tfa_local_client local_client;
    double *q = malloc((robot->shape.q_count + 1) * sizeof *q);
    if (!q)
        return TFA_E_MEMORY;
    set_zero(robot, q);
    int status = tfa_local_client_open(worker, index, 1, 1, &local_client);
    if (status == TFA_OK) {
        status = request_zero_pose(&local_client, q);
        tfa_local_client_close(&local_client);
    }
    free(q);
    return status;
}
