/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * An arm that holds its posture is pushed at the tool: a momentum observer sees it without a
 * sensor, and says with which wrench.
 *
 *     cc collision_detection.c -o collision_detection $(pkg-config --cflags --libs totalforce) -lm
 *     ./collision_detection config/robots/arm7.urdf tool0
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

enum { N = 64 };                          /* joints, at most, each of one freedom */
static const double dt = 1e-3, gain = 50; /* s; 1/s: a time constant of 20 ms */
static double push[6];                    /* N, axes of the world, at the origin of the tip */
static tfa_workspace *workspace;
static uint32_t n;

/* tfa_compute, or the end of the program */
static void compute(const tfa_request *request, tfa_reply *reply)
{
    if (tfa_compute(workspace, request, reply) == TFA_OK)
        return;
    fprintf(stderr, "%s\n", tfa_status_text(reply->status));
    exit(1);
}

/* A push that accelerates the tip by some 4 m/s^2 */
static void choose_push(const double *q, uint32_t tip)
{
    static const double direction[3] = {0.8, -0.3, 0.5};
    double lambda_inv[36];
    const tfa_request request = {
        .op = TFA_OP_OPERATIONAL_INERTIA, .count = 1, .q = q, .tip_count = 1, .tips = {tip}};
    tfa_reply reply = {.lambda_inv = lambda_inv};
    compute(&request, &reply);
    const double mass = 3 / (lambda_inv[0] + lambda_inv[7] + lambda_inv[14]); /* kg */
    for (int e = 0; e < 3; e++)
        push[e] = 4 * mass * direction[e];
}

/* Largest torque of the push, N m, and in *error the largest difference to torques r: the external
 * force of bias is - J^T push */
static double compare(const double *q, uint32_t tip, const double *r, double *error)
{
    double external[N], largest = 0;
    const tfa_request request = {.op = TFA_OP_BIAS,
                                 .count = 1,
                                 .q = q,
                                 .wrench_count = 1,
                                 .wrench_frames = {tip},
                                 .wrenches = push};
    tfa_reply reply = {.external_force = external};
    compute(&request, &reply);
    *error = 0;
    for (uint32_t j = 0; j < n; j++) {
        *error = fmax(*error, fabs(r[j] + external[j]));
        largest = fmax(largest, fabs(external[j]));
    }
    return largest;
}

/* The robot in simulation: velocity Verlet, one step of dt */
static void move(double *q, double *v, const double *tau, uint32_t tip, const double *wrench)
{
    double qdd[N];
    tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .refine = TFA_REFINE_DEFAULT,
                           .count = 1,
                           .q = q,
                           .v = v,
                           .tau = tau,
                           .wrench_count = 1,
                           .wrench_frames = {tip},
                           .wrenches = wrench};
    tfa_reply reply = {.qdd = qdd};
    compute(&request, &reply);
    for (uint32_t j = 0; j < n; j++) {
        v[j] += dt / 2 * qdd[j];
        q[j] += dt * v[j];
    }
    compute(&request, &reply);
    for (uint32_t j = 0; j < n; j++)
        v[j] += dt / 2 * qdd[j];
}

/* Torques that hold the posture: gravity, and a spring and damper in the metric of M */
static void hold(const double *q, const double *v, const double *posture, double *tau)
{
    double qdd[N];
    for (uint32_t j = 0; j < n; j++)
        qdd[j] = 400 * (posture[j] - q[j]) - 40 * v[j];
    const tfa_request request = {
        .op = TFA_OP_INVERSE_DYNAMICS, .count = 1, .q = q, .v = v, .qdd = qdd};
    tfa_reply reply = {.tau = tau};
    compute(&request, &reply);
}

/* One sample for the observer: what a program does in each cycle. Returns the largest of its
 * torques. */
static double observe(tfa_observer *observer, double t, const double *q, const double *v,
                      const double *tau)
{
    tfa_request request;
    tfa_reply reply;
    double largest = 0;
    tfa_observer_request(observer, &request, &reply);
    request.q = q;
    request.v = v;
    compute(&request, &reply);
    (void)tfa_observer_update(observer, t, tau, NULL, &reply);
    for (uint32_t j = 0; j < n; j++)
        largest = fmax(largest, fabs(tfa_observer_torques(observer)[j]));
    return largest;
}

int main(int argc, char **argv)
{
    const char *file = argc > 1 ? argv[1] : "config/robots/arm7.urdf";
    tfa_model *model;
    tfa_report report = {0};
    tfa_observer *observer;
    double q[N], v[N] = {0}, posture[N], tau[N], wrench[6], error, detected = INFINITY;
    const int loaded = tfa_model_load(file, NULL, &report, &model);
    tfa_report_free(&report);
    if (loaded != TFA_OK) {
        fprintf(stderr, "%s; %s\n", tfa_status_text(loaded), tfa_status_cause(loaded));
        return 1;
    }
    n = tfa_model_v_count(model);
    if (n > N || tfa_model_q_count(model) != n) {
        fprintf(stderr, "%u freedoms: at most %d, in joints of one\n", (unsigned)n, N);
        return 1;
    }
    const int32_t tip = tfa_model_find_frame(model, argc > 2 ? argv[2] : "tool0");
    if (tip < 0 || tfa_workspace_create(model, NULL, &workspace) != TFA_OK ||
        tfa_observer_create(0, n, &(tfa_observer_options){.gain = gain}, &observer) != TFA_OK) {
        fprintf(stderr, "no link of that name, or no memory\n");
        return 1;
    }
    for (uint32_t j = 0; j < n; j++)
        q[j] = posture[j] = 0.4 - 0.2 * j;
    choose_push(q, (uint32_t)tip);
    const double threshold = /* of a real robot: above its noise */
        0.1 * compare(q, (uint32_t)tip, tfa_observer_torques(observer), &error);
    for (int k = 0; k < 500; k++) { /* the push begins after 0.2 s */
        static const double none[6] = {0};
        hold(q, v, posture, tau);
        if (observe(observer, k * dt, q, v, tau) > threshold)
            detected = fmin(detected, k * dt - 0.2);
        move(q, v, tau, (uint32_t)tip, k < 200 ? none : push);
    }
    tfa_request request;
    tfa_reply reply;
    tfa_observer_wrench_request(observer, (uint32_t)tip, &request, &reply);
    request.q = q;
    request.rank_loss = TFA_RANK_TRUNCATE; /* of a tip behind less than six joints */
    compute(&request, &reply);
    if (tfa_observer_wrench(observer, &reply, wrench) != TFA_OK)
        return 1;
    const double largest = compare(q, (uint32_t)tip, tfa_observer_torques(observer), &error);
    printf("pushed by %.2f %.2f %.2f N, detected %.0f ms after the push; wrench %.2f %.2f %.2f N, "
           "directions lost %u; torques: error %.1e\n",
           push[0], push[1], push[2], 1e3 * detected, wrench[0], wrench[1], wrench[2],
           (unsigned)reply.rank->lost, error / largest);
    tfa_observer_free(observer);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}
