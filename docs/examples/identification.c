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

enum { STATES = 50, N = 64, PARAMETERS = TFA_LINK_PARAMETERS + 2 * N, ROWS = STATES * N };
static int joints, columns, rows; /* of the arm: at most N, PARAMETERS, ROWS */

/* kg, m, kg m^2 about the centre: what is on the real tool, and its joints' friction */
static const double load[TFA_PAYLOAD_NUMBERS] = {1.7,  0.02, -0.03, 0.08, 4e-3,
                                                 1e-4, 0,    5e-3,  0,    3e-3};
static double damping[N], friction[N]; /* N m s, N m */

static double random_between(double limit)
{
    return limit * (2.0 * rand() / RAND_MAX - 1);
}

/* Reflects rows r.. of A and b so that column k has one entry there, in row r */
static void reflect(double A[ROWS][PARAMETERS], double b[ROWS], int r, int k, double square)
{
    const double diagonal = A[r][k] > 0 ? -sqrt(square) : sqrt(square);
    A[r][k] -= diagonal;
    const double scale = -diagonal * A[r][k]; /* half of the square of the reflected vector */
    for (int c = k + 1; c <= columns; c++) {
        double dot = 0;
        for (int i = r; i < rows; i++)
            dot += A[i][k] * (c < columns ? A[i][c] : b[i]);
        for (int i = r; i < rows; i++)
            *(c < columns ? &A[i][c] : &b[i]) -= dot / scale * A[i][k];
    }
    A[r][k] = diagonal;
}

/* x of the least |A x - b|; A and b are overwritten, b from the rank on by what stays unexplained.
 * A column that depends on those before it gets 0. Returns the rank. */
static int least_squares(double A[ROWS][PARAMETERS], double b[ROWS], double x[PARAMETERS])
{
    int rank = 0, row[PARAMETERS];
    for (int k = 0; k < columns; k++) {
        double whole = 0, square = 0;
        for (int i = 0; i < rows; i++) {
            whole += A[i][k] * A[i][k];
            square += i < rank ? 0 : A[i][k] * A[i][k];
        }
        row[k] = square > 1e-20 * whole ? rank++ : -1;
        if (row[k] >= 0)
            reflect(A, b, row[k], k, square);
    }
    for (int k = columns; k-- > 0;) {
        x[k] = row[k] >= 0 ? b[row[k]] : 0;
        for (int c = k + 1; row[k] >= 0 && c < columns; c++)
            x[k] -= A[row[k]][c] * x[c];
        x[k] /= row[k] >= 0 ? A[row[k]][k] : 1;
    }
    return rank;
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
    double of_joint[N][TFA_JOINT_PARAMETERS];
    for (int j = 0; j < joints; j++) {
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
    tfa_reply reply = {.regressor = Y[0], .joint_regressor = of_joint[0]};
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
    for (int j = 0; j < joints; j++) {
        for (int c = 0; c < columns; c++)
            A[j][c] = c < TFA_LINK_PARAMETERS ? Y[j][c] : 0;
        A[j][TFA_LINK_PARAMETERS + j] = of_joint[j][1];
        A[j][TFA_LINK_PARAMETERS + joints + j] = of_joint[j][2];
        b[j] = real[j] - model[j] + damping[j] * of_joint[j][1] + friction[j] * of_joint[j][2];
    }
}

/* Result of least_squares, with the largest error */
static void print(const double *p, int rank, const double *unexplained)
{
    double error = 0;
    if (rank < columns) {
        for (int i = rank; i < rows; i++)
            error = hypot(error, unexplained[i]);
        printf("%d of %d parameters: this tip's motion does not tell the load's ten apart; largest "
               "error %.1e N m\n",
               rank, columns, error);
        return;
    }
    for (int j = 0; j < joints; j++) {
        error = fmax(error, fabs(p[TFA_LINK_PARAMETERS + j] - damping[j]));
        error = fmax(error, fabs(p[TFA_LINK_PARAMETERS + joints + j] - friction[j]));
    }
    for (int e = 0; e < 3; e++)
        error = fmax(error, fabs(p[1 + e] / p[0] - load[1 + e]));
    error = fmax(error, fabs(p[0] - load[0]));
    printf("mass %.6f kg, centre %.4f %.4f %.4f m; largest error %.1e\n", p[0], p[1] / p[0],
           p[2] / p[0], p[3] / p[0], error);
}

int main(int argc, char **argv)
{
    static double A[ROWS][PARAMETERS], b[ROWS], p[PARAMETERS];
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_report report = {0};
    const int loaded =
        tfa_model_load(argc > 1 ? argv[1] : "config/robots/arm7.urdf", NULL, &report, &model);
    tfa_report_free(&report);
    if (loaded != TFA_OK) {
        fprintf(stderr, "%s; %s\n", tfa_status_text(loaded), tfa_status_cause(loaded));
        return 1;
    }
    joints = (int)tfa_model_v_count(model);
    columns = TFA_LINK_PARAMETERS + 2 * joints;
    rows = STATES * joints;
    if (joints > N || (int)tfa_model_q_count(model) != joints) {
        fprintf(stderr, "%d freedoms: at most %d, in joints of one\n", joints, N);
        return 1;
    }
    for (int j = 0; j < joints; j++) {
        damping[j] = 1.5 - 1.2 * j / joints;
        friction[j] = 2 - 1.5 * j / joints;
    }
    const int32_t tip = tfa_model_find_frame(model, argc > 2 ? argv[2] : "tool0");
    if (tip < 0 || tfa_workspace_create(model, NULL, &workspace) != TFA_OK) {
        fprintf(stderr, "no link of that name, or no memory\n");
        return 1;
    }
    for (int k = 0; k < STATES; k++)
        measure(workspace, (uint32_t)tip, A + joints * k, b + joints * k);
    const int rank = least_squares(A, b, p);
    print(p, rank, b);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}
