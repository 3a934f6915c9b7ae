/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What states side by side are worth: forward dynamics of a batch of 512 states one after the other,
 * in the lanes of one processor, and on a pool of two, in turns in one run. Time for one state,
 * medians of rounds; CPU time of the thread for the first two, wall time for the pool.
 *
 *   bench_batch config/robots/arm7.urdf config/robots/humanoid.urdf
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <totalforce/totalforce.h>

#define STATES 512u
#define ROUNDS 101
#define THREADS 2

enum { ONE, LANES, POOL, WAYS };
static const char *const names[WAYS] = {"one by one", "lanes", "lanes, 2 threads"};

struct subject {
    tfa_model *model;
    tfa_workspace *one, *lanes;
    tfa_pool *pool;
    tfa_request request;
    tfa_reply reply;
    double *block;
};

static double now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static double uniform(double range)
{
    return range * (2.0 * rand() / RAND_MAX - 1);
}

static int open_subject(struct subject *s, const char *path)
{
    tfa_report report = {0};
    int status = tfa_model_load(path, NULL, &report, &s->model);
    tfa_report_free(&report);
    if (status == TFA_OK)
        status = tfa_workspace_create(s->model, &(tfa_workspace_options){.states = TFA_STATES_ONE},
                                      &s->one);
    if (status == TFA_OK)
        status = tfa_workspace_create(s->model, NULL, &s->lanes);
    if (status == TFA_OK)
        status = tfa_pool_create(s->model, &(tfa_pool_options){.threads = THREADS}, &s->pool);
    if (status != TFA_OK)
        return status;
    const size_t n = (size_t)STATES * (tfa_model_q_count(s->model) + 1);
    s->block = malloc(4 * n * sizeof *s->block);
    if (!s->block)
        return TFA_E_MEMORY;
    for (size_t k = 0; k < 3 * n; k++)
        s->block[k] = uniform(k < n ? 3 : 1);
    s->request = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                               .count = STATES,
                               .refine = TFA_REFINE_DEFAULT,
                               .q = s->block,
                               .v = s->block + n,
                               .tau = s->block + 2 * n};
    s->reply = (tfa_reply){.qdd = s->block + 3 * n};
    return TFA_OK;
}

static void close_subject(struct subject *s)
{
    free(s->block);
    tfa_pool_free(s->pool);
    tfa_workspace_free(s->lanes);
    tfa_workspace_free(s->one);
    tfa_model_free(s->model);
}

/* ns for one state */
static double turn(struct subject *s, int way)
{
    const clockid_t clock = way == POOL ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID;
    const double start = now(clock);
    const int status = way == POOL
                           ? tfa_pool_compute(s->pool, &s->request, &s->reply)
                           : tfa_compute(way == ONE ? s->one : s->lanes, &s->request, &s->reply);
    return status == TFA_OK ? (now(clock) - start) / STATES : 0;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int measure(const char *path)
{
    struct subject s = {0};
    static double ns[WAYS][ROUNDS];
    const int status = open_subject(&s, path);
    for (int round = 0; status == TFA_OK && round < ROUNDS; round++)
        for (int way = 0; way < WAYS; way++)
            ns[way][round] = turn(&s, way);
    for (int way = 0; status == TFA_OK && way < WAYS; way++) {
        qsort(ns[way], ROUNDS, sizeof ns[way][0], compare);
        const double median = ns[way][ROUNDS / 2];
        printf("%-12s %6u  %-18s %9.1f %9.1f %7.2f\n", tfa_model_name(s.model),
               (unsigned)tfa_model_summarise(s.model).bodies, names[way], median,
               median / tfa_model_summarise(s.model).bodies, ns[ONE][ROUNDS / 2] / median);
    }
    close_subject(&s);
    if (status != TFA_OK)
        fprintf(stderr, "%s: %s\n", path, tfa_status_text(status));
    return status;
}

int main(int argc, char **argv)
{
    int bad = argc < 2;
    printf("# %s\n%-12s %6s  %-18s %9s %9s %7s\n", tfa_isa_name(), "robot", "bodies", "how",
           "ns/state", "ns/body", "times");
    for (int k = 1; k < argc; k++)
        bad |= measure(argv[k]) != TFA_OK;
    return bad;
}
