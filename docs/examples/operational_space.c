/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Impedance control of a tool: it moves to a goal, its pose in another posture, as a mass on a
 * spring and a damper would, while damping in the null space stills the elbow. The controller asks
 * the library or, with the name of a robot, a running daemon over shared memory; the arm is
 * simulated at 1 kHz.
 *
 *     cc operational_space.c -o operational_space $(pkg-config --cflags --libs totalforce) -lm
 *     ./operational_space config/robots/arm7.urdf tool0 [ROBOT]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

#define N 64 /* joints, at most, each of one freedom; a fixed base */

static tfa_workspace *workspace;
static tfa_client *client; /* NULL: the library answers */

static int ask(const tfa_request *request, tfa_reply *reply)
{
    return client ? tfa_client_call(client, request, reply, 1000000000, NULL)
                  : tfa_compute(workspace, request, reply);
}

/* Acceleration of the tool, linear then angular: spring to the goal, critically damped */
static void impedance(const double goal[7], const double pose[7], const double twist[6],
                      double acceleration[6])
{
    const double kp = 100, kd = 20, *g = goal + 3, *p = pose + 3;
    const double turn[4] = {p[3] * g[0] - g[3] * p[0] + p[1] * g[2] - p[2] * g[1],
                            p[3] * g[1] - g[3] * p[1] + p[2] * g[0] - p[0] * g[2],
                            p[3] * g[2] - g[3] * p[2] + p[0] * g[1] - p[1] * g[0],
                            p[3] * g[3] + p[0] * g[0] + p[1] * g[1] + p[2] * g[2]};
    for (int k = 0; k < 3; k++) {
        acceleration[k] = kp * (goal[k] - pose[k]) - kd * twist[k];
        acceleration[3 + k] = kp * 2 * copysign(turn[k], turn[k] * turn[3]) - kd * twist[3 + k];
    }
}

/* Angle between the attitudes of two poses */
static double angle(const double a[7], const double b[7])
{
    double along = 0;
    for (int k = 3; k < 7; k++)
        along += a[k] * b[k];
    return 2 * acos(fmin(1, fabs(along)));
}

/* Pose of the tool in the posture q + offset */
static int find_pose(uint32_t tool, uint32_t joints, const double *q, double offset, double pose[7])
{
    double posture[N];
    for (uint32_t j = 0; j < joints; j++)
        posture[j] = q[j] + offset;
    const tfa_request request = {.op = TFA_OP_KINEMATICS,
                                 .flags = TFA_WANT_POSES,
                                 .count = 1,
                                 .q = posture,
                                 .tip_count = 1,
                                 .tips = {tool}};
    tfa_reply reply = {.poses = pose};
    return ask(&request, &reply);
}

/* One millisecond. @return status; pose: of the tool, before */
static int step(uint32_t tool, uint32_t joints, double q[N], double v[N], const double goal[7],
                double pose[7])
{
    double twist[6], acceleration[6], gravity[N], momentum[N], posture[N], tau[N], qdd[N];
    tfa_request request = {.op = TFA_OP_BIAS,
                           .flags =
                               TFA_WANT_POSES | TFA_WANT_TWISTS | TFA_WANT_GENERALISED_MOMENTUM,
                           .refine = TFA_REFINE_DEFAULT,
                           .count = 1,
                           .q = q,
                           .v = v,
                           .tip_count = 1,
                           .tips = {tool}};
    tfa_reply reply = {
        .gravity_force = gravity, .generalised_momentum = momentum, .poses = pose, .twists = twist};
    int status = ask(&request, &reply);
    if (status != TFA_OK)
        return status;
    impedance(goal, pose, twist, acceleration);
    for (uint32_t j = 0; j < joints; j++)
        posture[j] = gravity[j] - 5 * momentum[j]; /* damping of 5/s, stable on every arm */
    request.op = TFA_OP_TASK_TORQUES;
    request.flags = 0;
    request.tau = posture;
    request.task_acceleration = acceleration;
    request.rank_loss = TFA_RANK_DAMP; /* slow, not wild, near a singular pose */
    reply = (tfa_reply){.tau = tau};
    status = ask(&request, &reply);
    if (status != TFA_OK)
        return status;

    /* the arm: forward dynamics, semi-implicit Euler */
    request = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = q, .v = v, .tau = tau};
    reply = (tfa_reply){.qdd = qdd};
    status = tfa_compute(workspace, &request, &reply);
    for (uint32_t j = 0; status == TFA_OK && j < joints; j++)
        q[j] += 1e-3 * (v[j] += 1e-3 * qdd[j]);
    return status;
}

int main(int argc, char **argv)
{
    tfa_model *model = NULL;
    int status = tfa_model_load(argc > 1 ? argv[1] : "arm7.urdf", NULL, NULL, &model);
    if (status == TFA_OK)
        status = tfa_workspace_create(model, NULL, &workspace);
    const int32_t tool =
        status == TFA_OK ? tfa_model_find_frame(model, argc > 2 ? argv[2] : "") : -1;
    const uint32_t joints = status == TFA_OK ? tfa_model_v_count(model) : 0;
    if (status == TFA_OK && tool < 0)
        status = TFA_E_LINK;
    if (status == TFA_OK && (joints > N || tfa_model_q_count(model) != joints)) {
        fprintf(stderr, "%u freedoms: at most %d, in joints of one\n", (unsigned)joints, N);
        status = TFA_E_UNSUPPORTED;
    }
    if (status == TFA_OK && argc > 3)
        status = tfa_client_connect(&(tfa_client_options){.robot = argv[3]}, &client);
    double q[N], v[N] = {0}, goal[7], pose[7];
    for (int j = 0; j < N; j++)
        q[j] = j % 2 ? 0.6 : -0.3;
    if (status == TFA_OK)
        status = find_pose((uint32_t)tool, joints, q, 0.1, goal);
    for (int k = 0; status == TFA_OK && k < 3000; k++) {
        status = step((uint32_t)tool, joints, q, v, goal, pose);
        if (status == TFA_OK && k % 500 == 499)
            printf("%.1f s: %.3e m, %.3e rad from the goal\n", 1e-3 * (k + 1),
                   hypot(hypot(goal[0] - pose[0], goal[1] - pose[1]), goal[2] - pose[2]),
                   angle(goal, pose));
    }
    if (status != TFA_OK)
        fprintf(stderr, "%s; %s\n", tfa_status_text(status), tfa_status_cause(status));
    tfa_client_close(client);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return status == TFA_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
