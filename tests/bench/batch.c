/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What states side by side are worth: batches of 512 states one after the other and in the lanes of one
 * processor, forward dynamics on two threads, too, in turns in one run, in double and in float. Time
 * for one state, medians of rounds; CPU time of the thread for the first two, wall time for threads,
 * which are awake: each turn begins with a batch that is not measured.
 *
 * "callers" are two threads with a workspace and half of the states each and nothing in common: what
 * two processors of this machine are worth, for what the pool adds to be seen. "peak": the share of
 * what the processor does in registers (peak.h), of operations counted by the kernels over a number
 * type that counts (count/); sines are left out. Every processor should be free:
 *
 *   chrt -f 1 bench_batch config/robots/arm7.urdf config/robots/humanoid.urdf
 */
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "peak.h"
#include "timing.h"
#ifdef TFA_COUNT
#include "count/request.h"
#endif

#define STATES 512u
#define BATCHES 8u /* measured in a turn */
#define ROUNDS 51
#define THREADS 2

enum { ONE, LANES, CALLERS, POOL, WAYS };
static const char *const names[WAYS] = {"one by one", "lanes", "lanes, 2 callers",
                                        "lanes, pool of 2"};

static const struct task {
    const char *name;
    tfa_op op;
    tfa_method method;
    uint32_t tips;
} tasks[] = {
    {"forward dynamics", TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, 0},
    {"and one tip", TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, 1},
    {"by crba", TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_CRBA, 0},
    {"by tfa, refined", TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_TFA, 0},
    {"inverse dynamics", TFA_OP_INVERSE_DYNAMICS, TFA_METHOD_AUTO, 0},
    {"mass matrix", TFA_OP_MASS_MATRIX, TFA_METHOD_AUTO, 0},
    {"lambda, one tip", TFA_OP_OPERATIONAL_INERTIA, TFA_METHOD_AUTO, 1},
};
#define TASKS (sizeof tasks / sizeof *tasks)

struct subject {
    tfa_precision precision;
    tfa_model *model;
    tfa_workspace *one, *lanes, *second;
    tfa_pool *pool;
    tfa_request request;
    tfa_reply reply;
    double *block;
};

static double uniform(double range)
{
    return range * (2.0 * rand() / RAND_MAX - 1);
}

static int create_workspaces(struct subject *s)
{
    const tfa_workspace_options one = {.precision = s->precision, .states = TFA_STATES_ONE},
                                lanes = {.precision = s->precision};
    const tfa_pool_options pool = {.threads = THREADS, .precision = s->precision};
    int status = tfa_workspace_create(s->model, &one, &s->one);
    if (status == TFA_OK)
        status = tfa_workspace_create(s->model, &lanes, &s->lanes);
    if (status == TFA_OK)
        status = tfa_workspace_create(s->model, &lanes, &s->second);
    if (status == TFA_OK)
        status = tfa_pool_create(s->model, &pool, &s->pool);
    return status;
}

static int open_subject(struct subject *s, const char *path)
{
    tfa_report report = {0};
    int status = tfa_model_load(path, NULL, &report, &s->model);
    tfa_report_free(&report);
    if (status == TFA_OK)
        status = create_workspaces(s);
    if (status != TFA_OK)
        return status;
    const size_t nq = tfa_model_q_count(s->model), n = (size_t)STATES * (nq + 1);
    s->block = malloc((5 * n + STATES * (nq * nq + 36)) * sizeof *s->block);
    if (!s->block)
        return TFA_E_MEMORY;
    for (size_t k = 0; k < 3 * n; k++)
        s->block[k] = uniform(k < n ? 3 : 1);
    s->request = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                               .count = STATES,
                               .refine = TFA_REFINE_DEFAULT,
                               .q = s->block,
                               .v = s->block + n,
                               .tau = s->block + 2 * n,
                               .qdd = s->block + 2 * n};
    s->request.tips[0] = tfa_model_frame_count(s->model) - 1;
    s->reply = (tfa_reply){.qdd = s->block + 3 * n,
                           .tau = s->block + 4 * n,
                           .lambda_inv = s->block + 5 * n,
                           .mass_matrix = s->block + 5 * n + 36 * STATES};
    return TFA_OK;
}

static void close_subject(struct subject *s)
{
    free(s->block);
    tfa_pool_free(s->pool);
    tfa_workspace_free(s->second);
    tfa_workspace_free(s->lanes);
    tfa_workspace_free(s->one);
    tfa_model_free(s->model);
}

/* ---- two callers ---- */

struct caller {
    struct subject *s;
    pthread_barrier_t *gate;
    int cpu;
    double ns;
};

/* The second half of the states: twice as many batches of them as one caller has of all. */
static void compute_half(const struct subject *s, tfa_workspace *w, uint32_t first)
{
    const size_t n = tfa_model_q_count(s->model);
    tfa_request r = s->request;
    tfa_reply reply = {.qdd = s->reply.qdd + n * first};
    r.count = STATES / 2;
    r.q += n * first;
    r.v += n * first;
    r.tau += n * first;
    (void)tfa_compute(w, &r, &reply);
}

static void *second_caller(void *argument)
{
    struct caller *c = argument;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)c->cpu, &set);
    (void)sched_setaffinity(0, sizeof set, &set);
    pthread_barrier_wait(c->gate);
    for (uint32_t k = 0; k < BATCHES; k++)
        compute_half(c->s, c->s->second, STATES / 2);
    return NULL;
}

/* Both begin at once; the later end counts. */
static double two_callers(struct subject *s)
{
    pthread_barrier_t gate;
    pthread_t thread;
    struct caller c = {.s = s, .gate = &gate, .cpu = sched_getcpu() == 0 ? 1 : 0};
    pthread_barrier_init(&gate, NULL, 2);
    if (pthread_create(&thread, NULL, second_caller, &c) != 0)
        return 0;
    pthread_barrier_wait(&gate);
    const double start = wall_ns();
    for (uint32_t k = 0; k < BATCHES; k++)
        compute_half(s, s->lanes, 0);
    pthread_join(thread, NULL);
    pthread_barrier_destroy(&gate);
    return wall_ns() - start;
}

/* ---- turns ---- */

static int batch(struct subject *s, int way)
{
    return way == POOL ? tfa_pool_compute(s->pool, &s->request, &s->reply)
                       : tfa_compute(way == ONE ? s->one : s->lanes, &s->request, &s->reply);
}

/* ns for one state */
static double turn(struct subject *s, int way)
{
    const clockid_t clock = way == POOL ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID;
    if (way == CALLERS)
        return two_callers(s) / (STATES * BATCHES);
    int status = batch(s, way);
    const double start = time_ns(clock);
    for (uint32_t k = 0; status == TFA_OK && k < BATCHES; k++)
        status = batch(s, way);
    return status == TFA_OK ? (time_ns(clock) - start) / (STATES * BATCHES) : 0;
}

static double median(double *x)
{
    qsort(x, ROUNDS, sizeof *x, by_value);
    return x[ROUNDS / 2];
}

static double flops_of(const struct subject *s)
{
#ifdef TFA_COUNT
    tfa_request r = s->request;
    r.count = 1;
    return count_request(s->model, &r);
#else
    (void)s;
    return 0;
#endif
}

static void print(const struct subject *s, const struct task *task, double ns[][ROUNDS],
                  double *peak, int ways)
{
    const double best = median(peak), flops = flops_of(s), first = median(ns[ONE]);
    const double bodies = tfa_model_summarise(s->model).bodies;
    for (int way = 0; way < ways; way++) {
        const double x = median(ns[way]);
        printf("%-16s %6.0f  %s  %-17s %-17s %9.1f %8.1f %6.2f", tfa_model_name(s->model), bodies,
               s->precision == TFA_F32 ? "f32" : "f64", task->name, names[way], x, x / bodies,
               first / x);
        if (way == LANES && flops > 0)
            printf(" %6.0f %6.1f %6.1f %5.0f%%", flops, flops / x, best, 100 * flops / x / best);
        printf("\n");
    }
}

/* Threads for the first task only: what they are worth does not depend on the task. */
static void measure_task(struct subject *s, const struct task *task)
{
    static double ns[WAYS][ROUNDS], peak[ROUNDS];
    const int ways = task == tasks ? WAYS : LANES + 1;
    s->request.op = task->op;
    s->request.method = task->method;
    s->request.tip_count = task->tips;
    for (int round = 0; round < ROUNDS; round++) {
        peak[round] = peak_flops(tfa_isa_name(), s->precision == TFA_F32);
        for (int way = 0; way < ways; way++)
            ns[way][round] = turn(s, way);
    }
    print(s, task, ns, peak, ways);
}

static int measure(const char *path, tfa_precision precision)
{
    struct subject s = {.precision = precision};
    const int status = open_subject(&s, path);
    if (status != TFA_OK)
        fprintf(stderr, "%s: %s\n", path, tfa_status_text(status));
    for (size_t k = 0; status == TFA_OK && k < TASKS; k++)
        measure_task(&s, &tasks[k]);
    close_subject(&s);
    return status;
}

int main(int argc, char **argv)
{
    int bad = argc < 2;
    printf("# %s; flop of a state, Gflop/s, and peak of one processor\n"
           "%-16s %6s  %3s  %-17s %-17s %9s %8s %6s %6s %6s %6s %6s\n",
           tfa_isa_name(), "robot", "bodies", "", "what", "how", "ns/state", "ns/body", "times",
           "flop", "Gf/s", "peak", "share");
    for (int k = 1; k < argc; k++) {
        bad |= measure(argv[k], TFA_F64) != TFA_OK;
        bad |= measure(argv[k], TFA_F32) != TFA_OK;
    }
    return bad;
}
