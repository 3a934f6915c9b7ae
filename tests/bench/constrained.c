/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Time of ops with constraints over that of forward dynamics of the same robot in the same turn,
 * without and with an error estimate of both: medians over turns, one state, the generic kernels
 * (docs/constraints.md).
 *
 *   bench_constrained ROBOTS [TURNS]      ROBOTS: the folder config/robots
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
    const char *name, *file;
    uint32_t rows;
    const char *links[4]; /* held in the world */
} cases[] = {
    {"quadruped, four points",
     "quadruped.urdf",
     TFA_CONSTRAINT_POINT,
     {"FL_foot", "FR_foot", "RL_foot", "RR_foot"}},
    {"quadruped, four welds",
     "quadruped.urdf",
     TFA_CONSTRAINT_WELD,
     {"FL_foot", "FR_foot", "RL_foot", "RR_foot"}},
    {"humanoid, two welds", "humanoid.urdf", TFA_CONSTRAINT_WELD, {"left_foot", "right_foot"}},
    {"humanoid, four welds",
     "humanoid.urdf",
     TFA_CONSTRAINT_WELD,
     {"left_foot", "right_foot", "left_palm", "right_palm"}},
};

static const struct {
    const char *name;
    tfa_op op;
    tfa_estimate estimate;
} columns[] = {
    {"fd", TFA_OP_FORWARD_DYNAMICS, TFA_ESTIMATE_NEVER},
    {"fd estimated", TFA_OP_FORWARD_DYNAMICS, TFA_ESTIMATE_ALWAYS},
    {"constrained", TFA_OP_CONSTRAINED_DYNAMICS, TFA_ESTIMATE_NEVER},
    {"estimated", TFA_OP_CONSTRAINED_DYNAMICS, TFA_ESTIMATE_ALWAYS},
    {"impact", TFA_OP_IMPACT, TFA_ESTIMATE_NEVER},
    {"inverse", TFA_OP_CONSTRAINED_INVERSE_DYNAMICS, TFA_ESTIMATE_NEVER},
};
#define COLUMNS (sizeof columns / sizeof *columns)

static double q[N], v[N], tau[N], pose[7] = {[6] = 1}, twist[6];
static double out[4][N], wrenches[24], six[3][6];
static double times[COLUMNS][TURNS_MAX], ratios[TURNS_MAX];
static tfa_rank rank;

/* Nanoseconds of a call; the workspace keeps what depends on q only, so q changes. */
static double measure(tfa_workspace *w, size_t column, uint32_t constraints)
{
    const tfa_request request = {.op = columns[column].op,
                                 .estimate = columns[column].estimate,
                                 .count = 1,
                                 .constraints = constraints,
                                 .q = q,
                                 .v = v,
                                 .tau = tau,
                                 .qdd = tau,
                                 .base_pose = pose,
                                 .base_twist = twist};
    tfa_reply reply = {.qdd = out[0],
                       .tau = out[1],
                       .v = out[2],
                       .base_acceleration = six[0],
                       .base_wrench = six[1],
                       .base_twist = six[2],
                       .constraint_wrenches = wrenches,
                       .rank = &rank};
    const double start = wall_ns();
    for (int k = 0; k < CALLS; k++) {
        q[0] += 1e-6;
        if (tfa_compute(w, &request, &reply) != TFA_OK)
            exit(EXIT_FAILURE);
    }
    return (wall_ns() - start) / CALLS;
}

static double over(size_t column, size_t by, int turns)
{
    for (int k = 0; k < turns; k++)
        ratios[k] = times[column][k] / times[by][k];
    return median_of(ratios, turns);
}

static void run(tfa_workspace *w, size_t row, uint32_t constraints, int turns)
{
    for (int k = -turns / 10; k < turns; k++) /* some to warm up */
        for (size_t column = 0; column < COLUMNS; column++)
            times[column][k < 0 ? 0 : k] = measure(w, column, constraints);
    measure(w, 2, constraints); /* its rank */
    const double ratio = over(2, 0, turns), estimated = over(3, 1, turns);
    const double impact = over(4, 0, turns), inverse = over(5, 0, turns);
    printf("%s,%u,%u,%.0f,%.2f,%.2f,%.2f,%.2f\n", cases[row].name,
           (unsigned)(rank.rank + rank.lost), (unsigned)rank.rank, median_of(times[0], turns),
           ratio, estimated, impact, inverse);
}

static int open_case(size_t row, const char *folder, int turns)
{
    char path[4096];
    tfa_constraint list[4];
    tfa_scene scene = {.constraints = list};
    for (size_t k = 0; k < 4 && cases[row].links[k]; k++, scene.constraint_count++)
        list[k] = (tfa_constraint){.name = cases[row].links[k],
                                   .link = {NULL, cases[row].links[k]},
                                   .rows = cases[row].rows};
    const tfa_model_options options = {.base = TFA_BASE_FLOATING, .scene = &scene};
    tfa_model *model;
    tfa_workspace *w;
    snprintf(path, sizeof path, "%s/%s", folder, cases[row].file);
    if (tfa_model_load(path, &options, NULL, &model) != TFA_OK)
        return fprintf(stderr, "%s cannot be loaded\n", path), EXIT_FAILURE;
    if (tfa_model_v_count(model) > N || tfa_workspace_create(model, NULL, &w) != TFA_OK)
        return EXIT_FAILURE;
    run(w, row, (1u << scene.constraint_count) - 1, turns);
    tfa_workspace_free(w);
    tfa_model_free(model);
    return EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    const int turns = argc > 2 ? atoi(argv[2]) : 400;
    int failed = EXIT_SUCCESS;
    if (argc < 2 || turns < 1 || turns > TURNS_MAX)
        return fprintf(stderr, "usage: bench_constrained ROBOTS [TURNS]\n"), 3;
    for (int k = 0; k < N; k++) {
        q[k] = 2.0 * rand() / RAND_MAX - 1;
        v[k] = 2.0 * rand() / RAND_MAX - 1;
        tau[k] = 2.0 * rand() / RAND_MAX - 1;
    }
    /* times over fd, estimated ones over fd estimated */
    printf("case,rows,rank,fd_ns,constrained,estimated,impact,inverse\n");
    for (size_t row = 0; row < sizeof cases / sizeof *cases && !failed; row++)
        failed = open_case(row, argv[1], turns);
    return failed;
}
