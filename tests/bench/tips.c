/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of tips as a robot's controller asks for it: for one tip and for all that are named, alone
 * and in one request with forward dynamics, without and with the error estimate; and a peer that has it
 * (CRBA, a sparse factorisation, half a solve of six columns). CPU time of one thread, medians over turns that
 * all rows take one after the other, a new state at every call, sine and cosine included.
 *
 *   bench_tips [--floating] [--turns N] ROBOT.urdf LINK[,LINK ...] ...
 *
 * The links are to be ones that a joint moves: peers know no others. Each row ends with its ratio to
 * forward dynamics.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "peer.h"
#include "timing.h"

#define STATES 16
#define TURN_NS 1e6 /* long against a clock read, short against a shift of the host's load */
#define ROWS_MAX 16
#define ALL UINT32_MAX /* tips: all that are named */

struct robot {
    tfa_model *model;
    tfa_workspace *workspace;
    double pose[7];
    double *q, *v, *tau, *qdd;
    char *link[TFA_MAX_TIPS];
    uint32_t tip[TFA_MAX_TIPS], tips;
};

struct row {
    const char *what;
    struct robot *robot;
    uint32_t tips;
    int forward;
    tfa_estimate estimate;
    const struct peer_lambda *peer; /* NULL: ours */
    void *peer_robot;
    double lambda[36 * TFA_MAX_TIPS * TFA_MAX_TIPS], qdd_base[6];
    double *samples;
};

static double uniform(void)
{
    return 2.0 * rand() / RAND_MAX - 1;
}

static void call(struct row *row, size_t k)
{
    const struct robot *b = row->robot;
    const double *q = b->q + k % STATES * tfa_model_q_count(b->model);
    const size_t at = k % STATES * tfa_model_v_count(b->model);
    if (row->peer) {
        if (row->forward)
            row->peer->peer->forward(row->peer_robot, q, b->v + at, b->tau + at, b->qdd);
        for (uint32_t t = 0; t < row->tips; t++)
            if (row->peer->lambda(row->peer_robot, q, b->link[t], row->lambda) != 0)
                row->lambda[0] = NAN;
        return;
    }
    tfa_request request = {
        .op = row->forward ? TFA_OP_FORWARD_DYNAMICS : TFA_OP_OPERATIONAL_INERTIA,
        .estimate = row->estimate,
        .refine = TFA_REFINE_DEFAULT,
        .count = 1,
        .q = q,
        .v = row->forward ? b->v + at : NULL,
        .tau = row->forward ? b->tau + at : NULL,
        .base_pose = b->pose,
        .tip_count = row->tips,
    };
    for (uint32_t t = 0; t < row->tips; t++)
        request.tips[t] = b->tip[t];
    tfa_reply reply = {
        .qdd = b->qdd, .base_acceleration = row->qdd_base, .lambda_inv = row->lambda};
    if (tfa_compute(b->workspace, &request, &reply) != TFA_OK)
        row->lambda[0] = NAN;
}

/* ns a call over one turn */
static double turn(struct row *row, size_t calls)
{
    const double start = cpu_ns();
    for (size_t k = 0; k < calls; k++)
        call(row, k);
    return (cpu_ns() - start) / (double)calls;
}

static void measure(struct row *rows, size_t count, size_t turns)
{
    size_t calls[ROWS_MAX];
    for (size_t k = 0; k < count; k++) {
        rows[k].samples = calloc(turns, sizeof(double));
        (void)turn(&rows[k], STATES);
        calls[k] = (size_t)(TURN_NS / turn(&rows[k], STATES)) + 1;
    }
    for (size_t r = 0; r < turns; r++)
        for (size_t k = 0; k < count; k++)
            rows[k].samples[r] = turn(&rows[k], calls[k]);
    for (size_t k = 0; k < count; k++)
        qsort(rows[k].samples, turns, sizeof(double), by_value);
}

/* Largest difference of a peer's answer for the first tip from ours, relative */
static double difference(struct row *ours, struct row *peer)
{
    double most = 0, size = 0;
    call(ours, 0);
    call(peer, 0);
    for (int e = 0; e < 36; e++) {
        most = fmax(most, fabs(ours->lambda[e] - peer->lambda[e]));
        size = fmax(size, fabs(ours->lambda[e]));
    }
    return most / size;
}

static void print(struct row *rows, size_t count, size_t turns)
{
    const double forward = rows[0].samples[turns / 2];
    for (size_t k = 0; k < count; k++) {
        const struct row *r = &rows[k];
        printf("  %-10s %u tips  %-34s %9.0f ns  (least %.0f)  x %.2f",
               r->peer ? r->peer->peer->name : "", (unsigned)r->tips, r->what,
               r->samples[turns / 2], r->samples[0], r->samples[turns / 2] / forward);
        if (r->peer && !r->forward && r->tips == 1)
            printf("  difference %.0e", difference(&rows[1], &rows[k]));
        putchar('\n');
    }
}

/* What is asked, of ours and of the peers that know Lambda^-1; row 0 is forward dynamics, row 1 one
 * tip. Returns how many rows. */
static size_t make_rows(struct robot *b, const char *path, const tfa_description *d, int fixed,
                        struct row *rows)
{
    static const struct row ours[] = {
        {.what = "qdd", .forward = 1, .estimate = TFA_ESTIMATE_NEVER},
        {.what = "Lambda^-1", .tips = 1, .estimate = TFA_ESTIMATE_NEVER},
        {.what = "Lambda^-1 and estimate", .tips = 1, .estimate = TFA_ESTIMATE_ALWAYS},
        {.what = "qdd and Lambda^-1", .tips = 1, .forward = 1, .estimate = TFA_ESTIMATE_NEVER},
        {.what = "Lambda^-1", .tips = ALL, .estimate = TFA_ESTIMATE_NEVER},
        {.what = "Lambda^-1 and estimate", .tips = ALL, .estimate = TFA_ESTIMATE_ALWAYS},
        {.what = "qdd and Lambda^-1", .tips = ALL, .forward = 1, .estimate = TFA_ESTIMATE_NEVER},
    };
    static const struct row theirs[] = {
        {.what = "qdd", .forward = 1},
        {.what = "Lambda^-1", .tips = 1},
        {.what = "qdd, then Lambda^-1", .tips = 1, .forward = 1},
    };
    size_t n = 0;
    for (size_t k = 0; k < sizeof ours / sizeof *ours; k++)
        if (ours[k].tips != ALL || b->tips > 1)
            rows[n++] = ours[k];
    for (const struct peer_lambda *p = peer_lambda_table; fixed && p->peer; p++) {
        char why[256] = "";
        void *robot = p->peer->make(path, d, why, sizeof why);
        if (why[0])
            fprintf(stderr, "%s: %s\n", p->peer->name, why);
        for (size_t ask = 0; robot && ask < sizeof theirs / sizeof *theirs; ask++) {
            rows[n] = theirs[ask];
            rows[n].peer = p;
            rows[n++].peer_robot = robot;
        }
    }
    for (size_t k = 0; k < n; k++) {
        rows[k].robot = b;
        rows[k].tips = rows[k].tips == ALL ? b->tips : rows[k].tips;
    }
    return n;
}

/* Names of links, separated by commas. Returns 0, or -1 where one is not there. */
static int find_tips(struct robot *b, char *names)
{
    b->tips = 0;
    for (char *name = strtok(names, ","); name && b->tips < TFA_MAX_TIPS;
         name = strtok(NULL, ",")) {
        const int32_t frame = tfa_model_find_frame(b->model, name);
        if (frame < 0)
            return -1;
        b->link[b->tips] = name;
        b->tip[b->tips++] = (uint32_t)frame;
    }
    return b->tips ? 0 : -1;
}

static void make_states(struct robot *b)
{
    const size_t nq = tfa_model_q_count(b->model), nv = tfa_model_v_count(b->model);
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

static int bench(const char *path, char *names, tfa_base base, size_t turns)
{
    struct row *rows = calloc(ROWS_MAX, sizeof *rows);
    const tfa_model_options options = {.base = base};
    tfa_description *d = NULL;
    tfa_report report = {0};
    struct robot b = {0};
    if (tfa_urdf_load(path, &d, &report) != TFA_OK ||
        tfa_model_create(d, &options, &report, &b.model) != TFA_OK ||
        tfa_workspace_create(b.model, NULL, &b.workspace) != TFA_OK || find_tips(&b, names) != 0) {
        fprintf(stderr, "%s: no model, or no such link\n", path);
        return 1;
    }
    make_states(&b);
    printf("%s, %s base, %u freedoms, tip %s\n", path,
           base == TFA_BASE_FIXED ? "fixed" : "floating",
           (unsigned)(tfa_model_v_count(b.model) + tfa_model_base_freedoms(b.model)), b.link[0]);
    const size_t count = make_rows(&b, path, d, base == TFA_BASE_FIXED, rows);
    measure(rows, count, turns);
    print(rows, count, turns);
    for (size_t k = 0; k < count; k++) {
        free(rows[k].samples);
        if (rows[k].peer && !rows[k].tips)
            rows[k].peer->peer->release(rows[k].peer_robot);
    }
    free(rows);
    free(b.q);
    free(b.v);
    free(b.tau);
    free(b.qdd);
    tfa_workspace_free(b.workspace);
    tfa_model_free(b.model);
    tfa_report_free(&report);
    tfa_description_free(d);
    return 0;
}

int main(int argc, char **argv)
{
    tfa_base base = TFA_BASE_FIXED;
    size_t turns = 101;
    int failed = 0;
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--floating") == 0)
            base = TFA_BASE_FLOATING;
        else if (strcmp(argv[k], "--turns") == 0 && k + 1 < argc)
            turns = (size_t)atoi(argv[++k]);
        else if (k + 1 < argc)
            failed |= bench(argv[k], argv[k + 1], base, turns), k++;
    return failed;
}
