/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a scene saves: the humanoid as a whole, with its hands locked, as one arm; and what the same
 * q asked for twice saves. CPU time of one thread, median over repetitions, all rows interleaved.
 *
 *   bench_scenes [--csv] [--repetitions N] [HUMANOID.urdf]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "timing.h"

#define STATES 16
#define SLICE_NS 2e6 /* long against a clock read, short against a shift of the host's load */
#define TIP "left_palm"

static const char *const fingers[] = {
    "left_thumb_1_joint",   "left_thumb_2_joint",   "left_index_1_joint",  "left_index_2_joint",
    "left_middle_1_joint",  "left_middle_2_joint",  "left_ring_1_joint",   "left_ring_2_joint",
    "right_thumb_1_joint",  "right_thumb_2_joint",  "right_index_1_joint", "right_index_2_joint",
    "right_middle_1_joint", "right_middle_2_joint", "right_ring_1_joint",  "right_ring_2_joint",
};
#define FINGERS (sizeof fingers / sizeof *fingers)
#define LEFT_FINGERS (FINGERS / 2)

static const char *const tips[] = {TIP};
static tfa_lock locks[FINGERS];

/* What is asked for */
enum ask { FORWARD, LAMBDA, BOTH, REPEATED_FORWARD, REPEATED_LAMBDA, REPEATED_BOTH };

struct row {
    const char *name;
    tfa_base base;
    tfa_scene scene;
    int lock_now; /* fingers are locked by each request instead of by the scene */
    enum ask ask;
    int against; /* row that its speed-up refers to */
};

#define WHOLE                                                                                      \
    {                                                                                              \
        0                                                                                          \
    }
#define HANDS                                                                                      \
    {                                                                                              \
        .locks = locks, .lock_count = FINGERS                                                      \
    }
#define ARM                                                                                        \
    {                                                                                              \
        .root = "torso_link", .tips = tips, .tip_count = 1, .locks = locks,                        \
        .lock_count = LEFT_FINGERS                                                                 \
    }

static const struct row rows[] = {
    {"floating, whole: qdd", TFA_BASE_FLOATING, WHOLE, 0, FORWARD, 0},
    {"floating, hands locked in the scene: qdd", TFA_BASE_FLOATING, HANDS, 0, FORWARD, 0},
    {"floating, hands locked by the request: qdd", TFA_BASE_FLOATING, WHOLE, 1, FORWARD, 0},
    {"floating, whole: qdd at a q seen before", TFA_BASE_FLOATING, WHOLE, 0, REPEATED_FORWARD, 0},
    {"floating, whole: Lambda^-1", TFA_BASE_FLOATING, WHOLE, 0, LAMBDA, 4},
    {"floating, hands locked in the scene: Lambda^-1", TFA_BASE_FLOATING, HANDS, 0, LAMBDA, 4},
    {"floating, whole: Lambda^-1 at a q seen before", TFA_BASE_FLOATING, WHOLE, 0, REPEATED_LAMBDA,
     4},
    {"floating, whole: qdd and Lambda^-1 in one", TFA_BASE_FLOATING, WHOLE, 0, BOTH, 7},
    {"floating, whole: both at a q seen before", TFA_BASE_FLOATING, WHOLE, 0, REPEATED_BOTH, 7},
    {"fixed, whole: qdd", TFA_BASE_FIXED, WHOLE, 0, FORWARD, 9},
    {"fixed, hands locked in the scene: qdd", TFA_BASE_FIXED, HANDS, 0, FORWARD, 9},
    {"fixed, one arm as tip, its hand locked: qdd", TFA_BASE_FIXED, ARM, 0, FORWARD, 9},
    {"fixed, whole: Lambda^-1 (legs are left out)", TFA_BASE_FIXED, WHOLE, 0, LAMBDA, 12},
    {"fixed, hands locked in the scene: Lambda^-1", TFA_BASE_FIXED, HANDS, 0, LAMBDA, 12},
    {"fixed, one arm as tip, its hand locked: Lambda^-1", TFA_BASE_FIXED, ARM, 0, LAMBDA, 12},
};
#define COUNT (sizeof rows / sizeof *rows)

struct bench {
    const struct row *row;
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_model_summary summary;
    double *q, *v, *tau, *qdd, pose[7], twist[6], acceleration[6], lambda[36];
    uint32_t locked[FINGERS], locked_count, tip;
    double *samples;
};

static double uniform(void)
{
    return 2.0 * rand() / RAND_MAX - 1;
}

static void make_states(struct bench *b)
{
    const size_t nq = b->summary.q_count, nv = b->summary.v_count;
    b->q = calloc(STATES * nq + 1, sizeof(double));
    b->v = calloc(STATES * nv + 1, sizeof(double));
    b->tau = calloc(STATES * nv + 1, sizeof(double));
    b->qdd = calloc(nv + 1, sizeof(double));
    b->pose[6] = 1;
    for (size_t k = 0; k < STATES * nq; k++)
        b->q[k] = uniform();
    for (size_t k = 0; k < STATES * nv; k++) {
        b->v[k] = uniform();
        b->tau[k] = uniform();
    }
}

static int open_bench(struct bench *b, const struct row *row, const tfa_description *d,
                      size_t repetitions)
{
    const tfa_model_options options = {.base = row->base, .scene = &row->scene};
    b->row = row;
    b->samples = calloc(repetitions, sizeof(double));
    if (tfa_model_create(d, &options, NULL, &b->model) != TFA_OK ||
        tfa_workspace_create(b->model, NULL, &b->workspace) != TFA_OK)
        return -1;
    b->summary = tfa_model_summarise(b->model);
    b->tip = (uint32_t)tfa_model_find_frame(b->model, TIP);
    for (size_t k = 0; row->lock_now && k < FINGERS; k++)
        b->locked[b->locked_count++] = (uint32_t)tfa_model_find_joint(b->model, fingers[k]);
    make_states(b);
    return 0;
}

static void close_bench(struct bench *b)
{
    tfa_workspace_free(b->workspace);
    tfa_model_free(b->model);
    free(b->q);
    free(b->v);
    free(b->tau);
    free(b->qdd);
    free(b->samples);
}

static void call(struct bench *b, size_t k)
{
    const enum ask ask = b->row->ask;
    const int repeated = ask >= REPEATED_FORWARD;
    const int forward = ask != LAMBDA && ask != REPEATED_LAMBDA;
    const int lambda = ask != FORWARD && ask != REPEATED_FORWARD;
    const size_t state = k % STATES;
    const tfa_request request = {
        .op = forward ? TFA_OP_FORWARD_DYNAMICS : TFA_OP_OPERATIONAL_INERTIA,
        .count = 1,
        .refine = TFA_REFINE_DEFAULT,
        .q = b->q + (repeated ? 0 : state * b->summary.q_count),
        .v = b->v + state * b->summary.v_count,
        .tau = b->tau + state * b->summary.v_count,
        .base_pose = b->pose,
        .base_twist = b->twist,
        .tip_count = lambda ? 1 : 0,
        .tips = {b->tip},
        .locked = b->locked,
        .locked_count = b->locked_count,
    };
    tfa_reply reply = {
        .qdd = b->qdd, .base_acceleration = b->acceleration, .lambda_inv = b->lambda};
    if (tfa_compute(b->workspace, &request, &reply) != TFA_OK)
        fprintf(stderr, "%s: %s\n", b->row->name, tfa_status_text(reply.status));
}

/* ns a call over one turn */
static double turn(struct bench *b, size_t calls)
{
    const double start = cpu_ns();
    for (size_t k = 0; k < calls; k++)
        call(b, k);
    return (cpu_ns() - start) / (double)calls;
}

static void measure(struct bench *benches, size_t repetitions)
{
    size_t calls[COUNT];
    for (size_t k = 0; k < COUNT; k++) {
        (void)turn(&benches[k], STATES);
        calls[k] = (size_t)(SLICE_NS / turn(&benches[k], STATES)) + 1;
    }
    for (size_t r = 0; r < repetitions; r++)
        for (size_t k = 0; k < COUNT; k++)
            benches[k].samples[r] = turn(&benches[k], calls[k]);
    for (size_t k = 0; k < COUNT; k++)
        qsort(benches[k].samples, repetitions, sizeof(double), by_value);
}

static void print(const struct bench *benches, size_t repetitions, int csv)
{
    puts(csv ? "scene,bodies,freedoms,ns,speed_up"
             : "| scene and question | bodies | freedoms | ns a request | speed-up |\n"
               "|---|--:|--:|--:|--:|");
    for (size_t k = 0; k < COUNT; k++) {
        const struct bench *b = &benches[k];
        const double ns = b->samples[repetitions / 2];
        printf(csv ? "\"%s\",%u,%u,%.0f,%.2f\n" : "| %s | %u | %u | %.0f | %.2f |\n", b->row->name,
               b->summary.bodies, b->summary.v_count + tfa_model_base_freedoms(b->model), ns,
               benches[b->row->against].samples[repetitions / 2] / ns);
    }
}

int main(int argc, char **argv)
{
    const char *path = "config/robots/humanoid.urdf";
    size_t repetitions = 31;
    int csv = 0;
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--csv") == 0)
            csv = 1;
        else if (strcmp(argv[k], "--repetitions") == 0 && k + 1 < argc)
            repetitions = (size_t)atoi(argv[++k]);
        else
            path = argv[k];
    }
    for (size_t k = 0; k < FINGERS; k++)
        locks[k] = (tfa_lock){fingers[k], {0.3}};
    tfa_report report = {0};
    tfa_description *d = NULL;
    struct bench benches[COUNT] = {0};
    if (tfa_urdf_load(path, &d, &report) != TFA_OK) {
        fprintf(stderr, "%s: cannot be loaded\n", path);
        return 2;
    }
    for (size_t k = 0; k < COUNT; k++)
        if (open_bench(&benches[k], &rows[k], d, repetitions) != 0) {
            fprintf(stderr, "%s: the scene does not fit this robot\n", rows[k].name);
            return 2;
        }
    measure(benches, repetitions);
    print(benches, repetitions, csv);
    for (size_t k = 0; k < COUNT; k++)
        close_bench(&benches[k]);
    tfa_description_free(d);
    tfa_report_free(&report);
    return 0;
}
