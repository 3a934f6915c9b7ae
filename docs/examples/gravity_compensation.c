/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Gravity compensation: an arm that holds still by the torques of gravity alone, and can be moved
 * by hand. The controller asks the library or, with the name of a robot, a running daemon over
 * shared memory; the arm is simulated at 1 kHz and after a second pushed at the tool, for a fifth
 * of one.
 *
 * Damping is 5/s times the generalised momentum M v: each motion dies away at one rate. A constant
 * d for all joints is unstable where dt M^-1 d has an eigenvalue above 2, as in the last joints of
 * an arm.
 *
 *     cc gravity_compensation.c -o gravity_compensation \
 *         $(pkg-config --cflags --libs totalforce) -lm
 *     ./gravity_compensation config/robots/arm7.urdf tool0 [ROBOT]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

#define N 64 /* joints, at most, each of one freedom; a fixed base */

/* Farthest that a joint has moved; `from` becomes q. */
static double moved(uint32_t joints, const double *q, double *from)
{
    double most = 0;
    for (uint32_t j = 0; j < joints; j++) {
        most = fmax(most, fabs(q[j] - from[j]));
        from[j] = q[j];
    }
    return most;
}

/* A force along each axis of the world, N, that accelerates the tool by some 4 m/s^2 */
static int choose_push(tfa_workspace *workspace, uint32_t tool, const double *q, double *push)
{
    double lambda_inv[36];
    const tfa_request request = {
        .op = TFA_OP_OPERATIONAL_INERTIA, .count = 1, .q = q, .tip_count = 1, .tips = {tool}};
    tfa_reply reply = {.lambda_inv = lambda_inv};
    const int status = tfa_compute(workspace, &request, &reply);
    *push = 4 / (lambda_inv[0] + lambda_inv[7] + lambda_inv[14]); /* 1/kg along x, y, z */
    return status;
}

/* Accelerations of the arm with these torques, and a push of the tool */
static int simulate(tfa_workspace *workspace, uint32_t tool, const double *q, const double *v,
                    const double *tau, double push, double *qdd)
{
    const double wrench[6] = {push, push, push};
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .count = 1,
                                 .q = q,
                                 .v = v,
                                 .tau = tau,
                                 .wrench_count = 1,
                                 .wrench_frames = {tool},
                                 .wrenches = wrench};
    tfa_reply reply = {.qdd = qdd};
    return tfa_compute(workspace, &request, &reply);
}

int main(int argc, char **argv)
{
    tfa_model *model = NULL;
    tfa_workspace *workspace = NULL;
    tfa_client *client = NULL; /* NULL: the library answers */
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
    double q[N], before[N], v[N] = {0}, tau[N], momentum[N], qdd[N], energy[2], push = 0;
    for (int j = 0; j < N; j++)
        before[j] = q[j] = j % 2 ? 0.6 : -0.3;
    if (status == TFA_OK)
        status = choose_push(workspace, (uint32_t)tool, q, &push);
    for (int k = 0; status == TFA_OK && k < 12000; k++) {
        const tfa_request request = {.op = TFA_OP_BIAS,
                                     .flags = TFA_WANT_ENERGY | TFA_WANT_GENERALISED_MOMENTUM,
                                     .count = 1,
                                     .q = q,
                                     .v = v};
        tfa_reply reply = {
            .gravity_force = tau, .generalised_momentum = momentum, .energy = energy};
        status = client ? tfa_client_call(client, &request, &reply, 1000000000, NULL)
                        : tfa_compute(workspace, &request, &reply);
        for (uint32_t j = 0; j < joints; j++)
            tau[j] -= 5 * momentum[j]; /* a push dies away; the arm stays where it came to */
        if (status == TFA_OK)
            status = simulate(workspace, (uint32_t)tool, q, v, tau, k / 200 == 5 ? push : 0, qdd);
        for (uint32_t j = 0; status == TFA_OK && j < joints; j++)
            q[j] += 1e-3 * (v[j] += 1e-3 * qdd[j]);
        if (status == TFA_OK && k % 1000 == 999)
            printf("%.1f s: moved %.3e rad, kinetic energy %.3e J, potential energy %.6f J\n",
                   1e-3 * (k + 1), moved(joints, q, before), energy[0], energy[1]);
    }
    if (status != TFA_OK)
        fprintf(stderr, "%s; %s\n", tfa_status_text(status), tfa_status_cause(status));
    tfa_client_close(client);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return status == TFA_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
