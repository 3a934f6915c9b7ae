/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics, one state at a time: our methods and the peers that are built in, interleaved
 * in one run. CPU time of one thread, median over repetitions, a new state at every call, sine and
 * cosine included.
 *
 *   bench_dynamics [--csv] [--repetitions N] [ROBOT.urdf ...]
 */
#include "bench.h"
#include "peer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

#include "timing.h"

#define STATES 16
#define MAX_CONTESTANTS 8
#define SLICE_NS                                                                                   \
    2e6 /* one contestant's turn: long against a clock read, short against a shift of
                        the host's load, so that all see the same machine */

struct ours {
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_method method;
};

static void release_ours(void *robot)
{
    struct ours *o = robot;
    tfa_workspace_free(o->workspace);
    tfa_model_free(o->model);
    free(o);
}

static void *make_ours(const tfa_description *description, tfa_method method)
{
    static const tfa_workspace_options options = {.methods = TFA_METHODS_ALL};
    struct ours *o = calloc(1, sizeof *o);
    o->method = method;
    if (tfa_model_create(description, NULL, NULL, &o->model) == TFA_OK &&
        tfa_workspace_create(o->model, &options, &o->workspace) == TFA_OK)
        return o;
    release_ours(o);
    return NULL;
}

static void *make_aba(const char *path, const tfa_description *d, char *why, size_t size)
{
    (void)path, (void)why, (void)size;
    return make_ours(d, TFA_METHOD_ABA);
}

static void *make_crba(const char *path, const tfa_description *d, char *why, size_t size)
{
    (void)path, (void)why, (void)size;
    return d->joint_count > PEER_BODIES_MAX ? NULL
                                            : make_ours(d, TFA_METHOD_CRBA); /* O(N d^2): minutes */
}

static void *make_tfa(const char *path, const tfa_description *d, char *why, size_t size)
{
    (void)path, (void)why, (void)size;
    return make_ours(d, TFA_METHOD_TFA);
}

static void forward_ours(void *robot, const double *q, const double *v, const double *tau,
                         double *qdd)
{
    struct ours *o = robot;
    tfa_request request = {
        .op = TFA_OP_FORWARD_DYNAMICS,
        .method = o->method,
        .estimate = TFA_ESTIMATE_NEVER,
        .count = 1,
        .q = q,
        .v = v,
        .tau = tau,
    };
    tfa_reply reply = {.qdd = qdd};
    if (tfa_compute(o->workspace, &request, &reply) != TFA_OK)
        qdd[0] = NAN;
}

static const struct peer contestants[] = {
    {"totalforce aba", make_aba, forward_ours, release_ours},
    {"totalforce crba", make_crba, forward_ours, release_ours},
    {"totalforce tfa", make_tfa, forward_ours, release_ours},
};

struct entry {
    const struct peer *who;
    void *robot;
    double *samples; /* ns a call, by repetition */
    double error;    /* largest difference from the first contestant, relative */
};

struct states {
    size_t n;
    double *q, *v, *tau, *qdd, *first;
};

static double uniform(void)
{
    return 2.0 * rand() / RAND_MAX - 1;
}

static struct states make_states(size_t n)
{
    struct states s = {.n = n};
    s.q = calloc(STATES * n, sizeof(double));
    s.v = calloc(STATES * n, sizeof(double));
    s.tau = calloc(STATES * n, sizeof(double));
    s.qdd = calloc(n, sizeof(double));
    s.first = calloc(n, sizeof(double));
    for (size_t k = 0; k < STATES * n; k++) {
        s.q[k] = 3 * uniform();
        s.v[k] = uniform();
        s.tau[k] = uniform();
    }
    return s;
}

static void free_states(struct states *s)
{
    free(s->q);
    free(s->v);
    free(s->tau);
    free(s->qdd);
    free(s->first);
}

static void call(const struct entry *e, const struct states *s, size_t k)
{
    size_t at = k % STATES * s->n;
    e->who->forward(e->robot, s->q + at, s->v + at, s->tau + at, s->qdd);
}

/* ns a call over one turn */
static double turn(const struct entry *e, const struct states *s, size_t calls)
{
    double start = cpu_ns();
    for (size_t k = 0; k < calls; k++)
        call(e, s, k);
    return (cpu_ns() - start) / (double)calls;
}

static double difference(const struct states *s)
{
    double sum = 0, size = 0;
    for (size_t k = 0; k < s->n; k++) {
        sum += (s->qdd[k] - s->first[k]) * (s->qdd[k] - s->first[k]);
        size += s->first[k] * s->first[k];
    }
    return sqrt(sum / size);
}

static size_t gather(struct entry *entries, const char *path, const tfa_description *d,
                     size_t repetitions)
{
    const struct peer *all[MAX_CONTESTANTS];
    size_t count = 0, n = 0;
    for (size_t k = 0; k < sizeof contestants / sizeof *contestants; k++)
        all[count++] = &contestants[k];
    for (size_t k = 0; peer_table[k] && d->joint_count <= PEER_BODIES_MAX; k++)
        all[count++] = peer_table[k];
    for (size_t k = 0; k < count; k++) {
        char why[256] = "";
        void *robot = all[k]->make(path, d, why, sizeof why);
        if (!robot && why[0])
            fprintf(stderr, "%s: %s\n", all[k]->name, why);
        if (robot)
            entries[n++] = (struct entry){all[k], robot, calloc(repetitions, sizeof(double)), 0};
    }
    return n;
}

static void measure(struct entry *entries, size_t count, struct states *s, size_t repetitions)
{
    size_t calls[MAX_CONTESTANTS];
    for (size_t k = 0; k < count; k++) {
        call(&entries[k], s, 0);
        if (k == 0)
            memcpy(s->first, s->qdd, s->n * sizeof(double));
        entries[k].error = difference(s);
        calls[k] = (size_t)(SLICE_NS / turn(&entries[k], s, STATES)) + 1;
    }
    for (size_t r = 0; r < repetitions; r++)
        for (size_t k = 0; k < count; k++)
            entries[k].samples[r] = turn(&entries[k], s, calls[k]);
    for (size_t k = 0; k < count; k++)
        qsort(entries[k].samples, repetitions, sizeof(double), by_value);
}

static void print(const struct entry *e, const struct entry *first, const char *robot, size_t n,
                  size_t repetitions, int csv)
{
    double median = e->samples[repetitions / 2], base = first->samples[repetitions / 2];
    const char *format =
        csv ? "%s,%zu,%s,%.0f,%.1f,%.2f,%.1e\n" : "%-16s %5zu  %-16s %10.0f %9.1f %8.2f   %.1e\n";
    printf(format, robot, n, e->who->name, median, median / (double)n, median / base, e->error);
}

static int bench(const char *path, size_t repetitions, int csv)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    if (tfa_urdf_load(path, &d, &report) != TFA_OK) {
        fprintf(stderr, "%s: cannot be loaded\n", path);
        return 1;
    }
    size_t n = 0;
    for (size_t j = 0; j < d->joint_count; j++)
        n += d->joints[j].type != TFA_JOINT_FIXED;
    struct states s = make_states(n);
    struct entry entries[MAX_CONTESTANTS];
    size_t count = gather(entries, path, d, repetitions);
    measure(entries, count, &s, repetitions);
    for (size_t k = 0; k < count; k++)
        print(&entries[k], &entries[0], d->name, n, repetitions, csv);
    for (size_t k = 0; k < count; k++) {
        entries[k].who->release(entries[k].robot);
        free(entries[k].samples);
    }
    free_states(&s);
    tfa_description_free(d);
    tfa_report_free(&report);
    return 0;
}

static int bench_chains(size_t repetitions, int csv)
{
    static const int lengths[] = {7, 16, 64, 256, 1000};
    char path[] = "/tmp/tfa-bench-XXXXXX.urdf";
    int fd = mkstemps(path, 5), status = fd < 0;
    if (fd >= 0)
        close(fd);
    for (size_t k = 0; !status && k < sizeof lengths / sizeof *lengths; k++)
        status = chain_urdf(path, lengths[k], 1) || bench(path, repetitions, csv);
    unlink(path);
    return status;
}

int main(int argc, char **argv)
{
    size_t repetitions = 31;
    int csv = 0, status = 0, robots = 0;
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--csv") == 0)
            csv = 1;
        else if (strcmp(argv[k], "--repetitions") == 0 && k + 1 < argc)
            repetitions = (size_t)atoi(argv[++k]);
    }
    puts(csv ? "robot,joints,contestant,ns,ns_per_joint,ratio,difference"
             : "robot           joints  contestant         ns a call  ns/joint    ratio   "
               "difference");
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--repetitions") == 0)
            k++;
        else if (argv[k][0] != '-' && ++robots)
            status |= bench(argv[k], repetitions, csv);
    }
    return robots ? status : bench_chains(repetitions, csv);
}
