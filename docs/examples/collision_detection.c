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

enum { N = 16 };                          /* joints, at most */
static const double dt = 1e-3, gain = 50; /* s; 1/s: a time constant of 20 ms */
static const double threshold = 1;        /* N m */
static const double push[6] = {8, -3, 5}; /* N, axes of the world, at the origin of the tip */
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
    double q[N], v[N] = {0}, posture[N], tau[N], wrench[6], error = 0, detected = INFINITY;
    const int loaded = tfa_model_load(file, NULL, &report, &model);
    tfa_report_free(&report);
    if (loaded != TFA_OK || tfa_model_q_count(model) > N)
        return 1;
    n = tfa_model_v_count(model);
    const int32_t tip = tfa_model_find_frame(model, argc > 2 ? argv[2] : "tool0");
    if (tip < 0 || tfa_workspace_create(model, NULL, &workspace) != TFA_OK ||
        tfa_observer_create(0, n, &(tfa_observer_options){.gain = gain}, &observer) != TFA_OK)
        return 1;
    for (uint32_t j = 0; j < n; j++)
        q[j] = posture[j] = 0.4 - 0.2 * j;
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
    compute(&request, &reply);
    if (tfa_observer_wrench(observer, &reply, wrench) != TFA_OK)
        return 1;
    for (int e = 0; e < 6; e++)
        error = fmax(error, fabs(wrench[e] - push[e]));
    printf("detected %.0f ms after the push; wrench %.2f %.2f %.2f N, error %.1e\n", 1e3 * detected,
           wrench[0], wrench[1], wrench[2], error);
    tfa_observer_free(observer);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}
