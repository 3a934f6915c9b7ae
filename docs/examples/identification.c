/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Payload and joint friction of an arm from 50 states: torques are linear in the ten parameters of
 * the load and in damping and friction of each joint.
 *
 *     cc identification.c -o identification $(pkg-config --cflags --libs totalforce) -lm
 *     ./identification config/robots/arm7.urdf tool0
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

enum { STATES = 50, N = 7, PARAMETERS = TFA_LINK_PARAMETERS + 2 * N, ROWS = STATES * N };

/* kg, m, kg m^2 about the centre: what is on the real tool, and its joints' friction */
static const double load[TFA_PAYLOAD_NUMBERS] = {1.7,  0.02, -0.03, 0.08, 4e-3,
                                                 1e-4, 0,    5e-3,  0,    3e-3};
static const double damping[N] = {1.5, 1.3, 1.1, 0.9, 0.7, 0.5, 0.3}; /* N m s */
static const double friction[N] = {2, 1.75, 1.5, 1.25, 1, 0.75, 0.5}; /* N m */

static double random_between(double limit)
{
    return limit * (2.0 * rand() / RAND_MAX - 1);
}

/* x of the least |A x - b| by Householder reflections; A and b are overwritten */
static void least_squares(double A[ROWS][PARAMETERS], double b[ROWS], double x[PARAMETERS])
{
    for (int k = 0; k < PARAMETERS; k++) {
        double square = 0, diagonal;
        for (int i = k; i < ROWS; i++)
            square += A[i][k] * A[i][k];
        diagonal = A[k][k] > 0 ? -sqrt(square) : sqrt(square);
        A[k][k] -= diagonal;
        const double scale = -diagonal * A[k][k]; /* half of the square of the reflected vector */
        for (int c = k + 1; c <= PARAMETERS; c++) {
            double dot = 0;
            for (int i = k; i < ROWS; i++)
                dot += A[i][k] * (c < PARAMETERS ? A[i][c] : b[i]);
            for (int i = k; i < ROWS; i++)
                *(c < PARAMETERS ? &A[i][c] : &b[i]) -= dot / scale * A[i][k];
        }
        A[k][k] = diagonal;
    }
    for (int k = PARAMETERS; k-- > 0;) {
        x[k] = b[k];
        for (int c = k + 1; c < PARAMETERS; c++)
            x[k] -= A[k][c] * x[c];
        x[k] /= A[k][k];
    }
}

static void compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    if (tfa_compute(workspace, request, reply) == TFA_OK)
        return;
    fprintf(stderr, "%s\n", tfa_status_text(reply->status));
    exit(1);
}

/* Rows of one state: columns of the load, damping, friction; the torques that they explain */
static void measure(tfa_workspace *workspace, uint32_t tip, double A[N][PARAMETERS], double b[N])
{
    double q[N], v[N], qdd[N], model[N], real[N], Y[N][TFA_LINK_PARAMETERS];
    double joints[N][TFA_JOINT_PARAMETERS];
    for (int j = 0; j < N; j++) {
        q[j] = random_between(2);
        v[j] = random_between(1.5);
        qdd[j] = random_between(5);
    }
    tfa_request request = {.op = TFA_OP_REGRESSOR,
                           .count = 1,
                           .tip_count = 1,
                           .tips = {tip},
                           .q = q,
                           .v = v,
                           .qdd = qdd};
    tfa_reply reply = {.regressor = Y[0], .joint_regressor = joints[0]};
    compute(workspace, &request, &reply);
    request.op = TFA_OP_INVERSE_DYNAMICS;
    request.tip_count = 0;
    reply = (tfa_reply){.tau = model};
    compute(workspace, &request, &reply);
    request.payload_count = 1; /* in place of a measurement */
    request.payload_frames[0] = tip;
    request.payloads = load;
    reply.tau = real;
    compute(workspace, &request, &reply);
    for (int j = 0; j < N; j++) {
        for (int c = 0; c < PARAMETERS; c++)
            A[j][c] = c < TFA_LINK_PARAMETERS ? Y[j][c] : 0;
        A[j][TFA_LINK_PARAMETERS + j] = joints[j][1];
        A[j][TFA_LINK_PARAMETERS + N + j] = joints[j][2];
        b[j] = real[j] - model[j] + damping[j] * joints[j][1] + friction[j] * joints[j][2];
    }
}

int main(int argc, char **argv)
{
    static double A[ROWS][PARAMETERS], b[ROWS], p[PARAMETERS];
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_report report = {0};
    double error = 0;
    const int loaded =
        tfa_model_load(argc > 1 ? argv[1] : "config/robots/arm7.urdf", NULL, &report, &model);
    tfa_report_free(&report);
    if (loaded != TFA_OK || tfa_model_v_count(model) != N)
        return 1;
    const int32_t tip = tfa_model_find_frame(model, argc > 2 ? argv[2] : "tool0");
    if (tip < 0 || tfa_workspace_create(model, NULL, &workspace) != TFA_OK)
        return 1;
    for (int k = 0; k < STATES; k++)
        measure(workspace, (uint32_t)tip, A + N * k, b + N * k);
    least_squares(A, b, p);
    for (int j = 0; j < N; j++) {
        error = fmax(error, fabs(p[TFA_LINK_PARAMETERS + j] - damping[j]));
        error = fmax(error, fabs(p[TFA_LINK_PARAMETERS + N + j] - friction[j]));
    }
    for (int e = 0; e < 3; e++)
        error = fmax(error, fabs(p[1 + e] / p[0] - load[1 + e]));
    error = fmax(error, fabs(p[0] - load[0]));
    printf("mass %.6f kg, centre %.4f %.4f %.4f m; largest error %.1e\n", p[0], p[1] / p[0],
           p[2] / p[0], p[3] / p[0], error);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}
