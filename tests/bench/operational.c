/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Time of answers around forward dynamics, over plain forward dynamics of the same state in the
 * same turn: medians over turns, one state of one tip, the generic kernels.
 *
 *   bench_operational URDF TIP fixed|floating [TURNS]
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "timing.h"

#define N 128 /* freedoms, at most */
#define TURNS_MAX 4000
#define CALLS 40 /* in a row, each at another q */

static const struct {
    const char *name;
    tfa_op op;
    uint32_t tips, flags;
} rows[] = {
    {"qdd", TFA_OP_FORWARD_DYNAMICS, 0, 0},
    {"qdd, lambda_inv", TFA_OP_FORWARD_DYNAMICS, 1, 0},
    {"qdd, lambda_inv, J, J-dot v, pose", TFA_OP_FORWARD_DYNAMICS, 1,
     TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_POSES},
    {"the same, lambda", TFA_OP_FORWARD_DYNAMICS, 1,
     TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_POSES | TFA_WANT_LAMBDA},
    {"the same, lambda, mu, p", TFA_OP_FORWARD_DYNAMICS, 1,
     TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_POSES | TFA_WANT_LAMBDA |
         TFA_WANT_MU | TFA_WANT_P},
    {"task torques", TFA_OP_TASK_TORQUES, 1, 0},
    {"J, J-dot v, pose, twist alone", TFA_OP_KINEMATICS, 1,
     TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_POSES | TFA_WANT_TWISTS},
    {"com, momentum, energy alone", TFA_OP_KINEMATICS, 0,
     TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY},
    {"bias forces", TFA_OP_BIAS, 0, 0},
    {"derivatives", TFA_OP_DERIVATIVES, 0, 0},
    {"derivatives of tau", TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, 0, 0},
    {"generalised momentum and its rate", TFA_OP_KINEMATICS, 0, TFA_WANT_GENERALISED_MOMENTUM},
    {"regressor of a link", TFA_OP_REGRESSOR, 1, 0},
    {"regressor of all bodies, 32 at most", TFA_OP_REGRESSOR, TFA_MAX_TIPS, 0},
    {"qdd with damping and friction", TFA_OP_FORWARD_DYNAMICS, 0, 0},
};
#define ROWS (sizeof rows / sizeof *rows)
#define PASSIVE (ROWS - 1) /* of the robot with both */

static double q[2 * N], v[N], tau[N], pose[7] = {[6] = 1}, twist[6], wrench[6], acceleration[6];
static double forces[10][N], matrices[3][N * N], jacobian[6 * N], com_jacobian[3 * N];
static double regressor[N * TFA_LINK_PARAMETERS * TFA_MAX_TIPS];
static double lambda_inv[36], lambda[36], small[10][8];
static double times[ROWS][TURNS_MAX], ratios[TURNS_MAX];

static void fill(double *x, int count)
{
    for (int k = 0; k < count; k++)
        x[k] = 2.0 * rand() / RAND_MAX - 1;
}

/* Nanoseconds of a call; the workspace keeps what depends on q only, so q changes. */
static double measure(tfa_workspace *w, size_t row, const uint32_t *tips, uint32_t bodies)
{
    tfa_rank rank;
    tfa_request request = {.op = rows[row].op,
                           .count = 1,
                           .refine = TFA_REFINE_DEFAULT,
                           .flags = rows[row].flags,
                           .tip_count = rows[row].tips < bodies ? rows[row].tips : bodies,
                           .q = q,
                           .v = v,
                           .tau = tau,
                           .base_pose = pose,
                           .base_twist = twist,
                           .base_wrench = wrench,
                           .task_acceleration = acceleration};
    tfa_reply reply = {.qdd = forces[0],
                       .base_acceleration = small[0],
                       .tau = forces[1],
                       .base_wrench = small[1],
                       .lambda_inv = lambda_inv,
                       .poses = small[2],
                       .twists = small[3],
                       .jacobian = jacobian,
                       .bias_acceleration = small[4],
                       .com = small[5],
                       .com_velocity = small[6],
                       .com_jacobian = com_jacobian,
                       .mass = small[7],
                       .momentum = small[8],
                       .energy = small[9],
                       .lambda = lambda,
                       .rank = &rank,
                       .mu = forces[2],
                       .p = forces[3],
                       .gravity_force = forces[4],
                       .velocity_force = forces[5],
                       .damping_force = forces[6],
                       .external_force = forces[7],
                       .armature_force = forces[8],
                       .dqdd_dq = matrices[0],
                       .dqdd_dv = matrices[1],
                       .dqdd_dtau = matrices[2],
                       .dtau_dq = matrices[0],
                       .dtau_dv = matrices[1],
                       .regressor = regressor,
                       .generalised_momentum = forces[0],
                       .momentum_rate = forces[1]};
    memcpy(request.tips, tips, request.tip_count * sizeof *tips);
    const double start = wall_ns();
    for (int k = 0; k < CALLS; k++) {
        q[0] += 1e-6;
        if (tfa_compute(w, &request, &reply) != TFA_OK)
            exit(EXIT_FAILURE);
    }
    return (wall_ns() - start) / CALLS;
}

/* The robot, [1] with damping and friction; ends the program where it cannot be loaded */
static void load(const char *file, tfa_base base, tfa_model *model[2], tfa_workspace *w[2])
{
    const tfa_workspace_options all_tips = {.max_tips = TFA_MAX_TIPS};
    for (uint32_t passive = 0; passive < 2; passive++) {
        const tfa_model_options options = {.base = base, .damping = passive, .friction = passive};
        if (tfa_model_load(file, &options, NULL, &model[passive]) == TFA_OK &&
            tfa_workspace_create(model[passive], &all_tips, &w[passive]) == TFA_OK)
            continue;
        fprintf(stderr, "%s cannot be loaded\n", file);
        exit(2);
    }
}

int main(int argc, char **argv)
{
    const int turns = argc > 4 ? atoi(argv[4]) : 400;
    tfa_model *models[2];
    tfa_workspace *w[2];
    if (argc < 4 || turns < 1 || turns > TURNS_MAX)
        return fprintf(stderr, "usage: bench_operational URDF TIP fixed|floating [TURNS]\n"), 3;
    load(argv[1], strcmp(argv[3], "floating") == 0 ? TFA_BASE_FLOATING : TFA_BASE_FIXED, models, w);
    const tfa_model *model = models[0];
    const int32_t tip = tfa_model_find_frame(model, argv[2]);
    const uint32_t freedoms = tfa_model_v_count(model) + tfa_model_base_freedoms(model),
                   bodies = tfa_model_summarise(model).bodies;
    if (tip < 0 || freedoms > N)
        return fprintf(stderr, "no link %s, or too many joints\n", argv[2]), 2;
    uint32_t tips[TFA_MAX_TIPS] = {(uint32_t)tip};
    for (uint32_t k = 1; k < TFA_MAX_TIPS; k++)
        tips[k] = tfa_model_body_frame(model, k % bodies);
    fill(q, N);
    fill(v, N);
    fill(tau, N);
    fill(twist, 6);
    fill(acceleration, 6);
    for (int k = -turns / 10; k < turns; k++) /* some to warm up */
        for (size_t row = 0; row < ROWS; row++)
            times[row][k < 0 ? 0 : k] = measure(w[row == PASSIVE], row, tips, bodies);
    printf("%s, %u freedoms\n", tfa_model_name(model), (unsigned)freedoms);
    for (size_t row = 0; row < ROWS; row++) {
        for (int k = 0; k < turns; k++)
            ratios[k] = times[row][k] / times[0][k];
        const double ratio = median_of(ratios, turns);
        double copy[TURNS_MAX];
        memcpy(copy, times[row], sizeof copy);
        printf("%-36s %8.0f ns  %6.2f x qdd\n", rows[row].name, median_of(copy, turns), ratio);
    }
    for (int passive = 0; passive < 2; passive++) {
        tfa_workspace_free(w[passive]);
        tfa_model_free(models[passive]);
    }
    return EXIT_SUCCESS;
}
