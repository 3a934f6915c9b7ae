/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of one state of random chains of rods: aba, and the methods that go in parts on
 * one core and on the threads of a pool, in turns in one run, a new state at every call. Medians and
 * minima of rounds, wall time; the difference to aba's answer. -r: with one step of refinement and its
 * estimate, aba without.
 *
 *   bench_chains [-t THREADS] [-m METHOD] [-r] [LENGTH ...]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

#include "bench.h"
#include "timing.h"

#define STATES 8u
#define ROUNDS 51
#define ROUND_NS 2e6 /* about: calls of one contestant in a row */

enum { ABA, ALONE, POOL, WAYS };

static double uniform(double range)
{
    return range * (2.0 * rand() / RAND_MAX - 1);
}

struct subject {
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_pool *pool;
    size_t n;
    double *q, *v, *tau, *qdd[WAYS];
    tfa_method method;
    int refined;
};

static int ask(struct subject *s, int way, uint32_t state)
{
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .method = way == ABA ? TFA_METHOD_ABA : s->method,
                           .refine = way != ABA && s->refined,
                           .estimate =
                               way != ABA && s->refined ? TFA_ESTIMATE_ALWAYS : TFA_ESTIMATE_NEVER,
                           .count = 1,
                           .q = s->q + s->n * state,
                           .v = s->v + s->n * state,
                           .tau = s->tau + s->n * state};
    tfa_reply reply = {.qdd = s->qdd[way]};
    return way == POOL ? tfa_pool_compute(s->pool, &r, &reply)
                       : tfa_compute(s->workspace, &r, &reply);
}

static double difference(const struct subject *s, int way)
{
    double sum = 0, size = 0;
    for (size_t k = 0; k < s->n; k++) {
        const double d = s->qdd[way][k] - s->qdd[ABA][k];
        sum += d * d;
        size += s->qdd[ABA][k] * s->qdd[ABA][k];
    }
    return sqrt(sum / size);
}

static int open_subject(struct subject *s, int length, uint32_t threads, tfa_method method,
                        int refined)
{
    char path[] = "/tmp/chain-XXXXXX";
    const int file = mkstemp(path);
    *s = (struct subject){.method = method, .refined = refined};
    if (file < 0 || close(file) || chain_urdf(path, length, 1))
        return -1;
    int status = tfa_model_load(path, NULL, NULL, &s->model);
    unlink(path);
    if (status == TFA_OK)
        status = tfa_workspace_create(s->model, NULL, &s->workspace);
    if (status == TFA_OK)
        status = tfa_pool_create(s->model, &(tfa_pool_options){.threads = threads}, &s->pool);
    if (status != TFA_OK)
        return -1;
    s->n = tfa_model_q_count(s->model);
    double *x = malloc((3 * STATES + WAYS) * s->n * sizeof *x);
    if (!x)
        return -1;
    for (size_t k = 0; k < 3 * STATES * s->n; k++)
        x[k] = uniform(k < STATES * s->n ? 3.0 : 1.0);
    s->q = x;
    s->v = s->q + STATES * s->n;
    s->tau = s->v + STATES * s->n;
    for (int way = 0; way < WAYS; way++)
        s->qdd[way] = s->tau + (STATES + (size_t)way) * s->n;
    return 0;
}

static void measure(struct subject *s, uint32_t threads)
{
    static double ns[WAYS][ROUNDS];
    double worst[WAYS] = {0};
    const int calls = 1 + (int)(ROUND_NS / (80.0 * (double)s->n));
    for (uint32_t k = 0; k < STATES; k++)
        for (int way = 0; way < WAYS; way++) {
            if (ask(s, way, k) != TFA_OK)
                printf("no answer\n");
            worst[way] = fmax(worst[way], difference(s, way));
        }
    for (int round = 0; round < ROUNDS; round++)
        for (int way = 0; way < WAYS; way++) {
            (void)ask(s, way, 0); /* threads awake */
            const double start = wall_ns();
            for (int c = 0; c < calls; c++)
                (void)ask(s, way, (uint32_t)(round + c) % STATES);
            ns[way][round] = (wall_ns() - start) / calls;
        }
    const char *const name = tfa_method_name(s->method);
    printf("%5zu", s->n);
    for (int way = 0; way < WAYS; way++) {
        qsort(ns[way], ROUNDS, sizeof **ns, by_value);
        printf("  %s%s %8.2f us (least %8.2f)", way == ABA ? "aba" : name,
               way == POOL ? " pool" : "", ns[way][ROUNDS / 2] * 1e-3, ns[way][0] * 1e-3);
    }
    printf("  ns a body %5.1f %5.1f %5.1f  %u threads  %.1e\n", ns[ABA][ROUNDS / 2] / (double)s->n,
           ns[ALONE][ROUNDS / 2] / (double)s->n, ns[POOL][ROUNDS / 2] / (double)s->n, threads,
           worst[ALONE]);
}

int main(int argc, char **argv)
{
    static const int lengths[] = {16, 32, 48, 64, 96, 128, 192, 256, 512, 1000, 2048, 4096};
    uint32_t threads = 2;
    int32_t method = TFA_METHOD_SCAN, option;
    int refined = 0;
    while ((option = getopt(argc, argv, "t:m:r")) != -1)
        if (option == 't')
            threads = (uint32_t)atoi(optarg);
        else if (option == 'r')
            refined = 1;
        else if (option != 'm' || (method = tfa_method_find(optarg)) < 0)
            return 3;
    const int given = argc - optind;
    const int count = given ? given : (int)(sizeof lengths / sizeof *lengths);
    for (int k = 0; k < count; k++) {
        struct subject s;
        if (open_subject(&s, given ? atoi(argv[optind + k]) : lengths[k], threads,
                         (tfa_method)method, refined))
            return 2;
        measure(&s, threads);
        tfa_pool_free(s.pool);
        tfa_workspace_free(s.workspace);
        tfa_model_free(s.model);
        free(s.q);
    }
    return 0;
}
