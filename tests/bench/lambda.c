/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of 1, 2, 4 and 8 tips by every method: CPU time of one thread, the median over turns
 * that all methods take one after the other, a new state at every call; and the relative error to
 * propagation in quadruple precision. Tips are spread evenly over the links that end a branch, or,
 * with --along, over all links: a robot in contact along its length.
 *
 *   bench_lambda [--floating] [--along] [--refine N] ROBOT.urdf ...
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "timing.h"

#define TURNS 31
#define TURN_NS 1e6 /* long against a clock read */
#define STATES 16
#define MOST (36 * TFA_MAX_TIPS * TFA_MAX_TIPS)

static const tfa_method methods[] = {
    TFA_METHOD_PROPAGATION, TFA_METHOD_EFPA, TFA_METHOD_PV_OSIMR,      TFA_METHOD_CRBA,
    TFA_METHOD_SCAN,        TFA_METHOD_TFA,  TFA_METHOD_TFA_ONE_SIDED, TFA_METHOD_TFA_CR};
#define METHODS (sizeof methods / sizeof *methods)

struct bench {
    tfa_workspace *w;
    tfa_request request;
    double *q;
    size_t stride;
    unsigned call;
};

static int ask(struct bench *b, tfa_workspace *w, double *out)
{
    tfa_reply reply = {.lambda_inv = out};
    b->request.q = b->q + (b->call++ % STATES) * b->stride;
    return tfa_compute(w, &b->request, &reply);
}

/* ns a call, over one turn */
static double turn(struct bench *b)
{
    double out[MOST];
    unsigned calls = 0;
    const double start = cpu_ns();
    do {
        if (ask(b, b->w, out) != TFA_OK)
            return NAN;
        calls++;
    } while (cpu_ns() - start < TURN_NS);
    return (cpu_ns() - start) / calls;
}

static double error(struct bench *b, const double *want)
{
    double got[MOST], difference = 0, size = 0;
    const size_t n = (size_t)36 * b->request.tip_count * b->request.tip_count;
    b->call = 0;
    if (ask(b, b->w, got) != TFA_OK)
        return NAN;
    for (size_t k = 0; k < n; k++) {
        difference += (got[k] - want[k]) * (got[k] - want[k]);
        size += want[k] * want[k];
    }
    return sqrt(difference / size);
}

static void measure(struct bench *b, tfa_workspace *f128)
{
    static double ns[METHODS][TURNS];
    double want[MOST];
    b->call = 0;
    b->request.method = TFA_METHOD_PROPAGATION;
    if (ask(b, f128, want) != TFA_OK)
        return;
    for (size_t k = 0; k < TURNS; k++)
        for (size_t m = 0; m < METHODS; m++) {
            b->request.method = methods[m];
            ns[m][k] = turn(b);
        }
    for (size_t m = 0; m < METHODS; m++) {
        b->request.method = methods[m];
        qsort(ns[m], TURNS, sizeof **ns, by_value);
        printf("  %-14s %u tips %9.2f us  error %.1e\n", tfa_method_name((uint32_t)methods[m]),
               (unsigned)b->request.tip_count, ns[m][TURNS / 2] / 1e3, error(b, want));
    }
}

/* Links at which a branch ends, or all that move; how many */
static size_t candidates(const tfa_description *d, int along, uint32_t *out)
{
    size_t count = 0;
    for (size_t link = 0; link < d->link_count; link++) {
        int parent = 0, child = 0;
        for (size_t j = 0; j < d->joint_count; j++) {
            parent |= d->joints[j].parent == link;
            child |= d->joints[j].child == link;
        }
        if (along ? child : !parent)
            out[count++] = (uint32_t)link;
    }
    return count;
}

static int robot(const char *path, tfa_base base, int along, uint32_t refine)
{
    static const double pose[7] = {0, 0, 0, 0, 0, 0, 1};
    const tfa_model_options options = {.base = base};
    const tfa_workspace_options plain = {.methods = TFA_METHODS_ALL};
    const tfa_workspace_options quadruple = {.precision = TFA_F128};
    tfa_description *d = NULL;
    tfa_report report = {0};
    tfa_model *model = NULL;
    tfa_workspace *f128 = NULL;
    struct bench b = {0};
    if (tfa_urdf_load(path, &d, &report) != TFA_OK ||
        tfa_model_create(d, &options, &report, &model) != TFA_OK ||
        tfa_workspace_create(model, &plain, &b.w) != TFA_OK ||
        tfa_workspace_create(model, &quadruple, &f128) != TFA_OK) {
        fprintf(stderr, "%s: no model\n", path);
        return 1;
    }
    uint32_t *link = calloc(d->link_count, sizeof *link);
    const size_t count = candidates(d, along, link);
    b.stride = tfa_model_q_count(model);
    b.q = calloc(STATES * b.stride + 1, sizeof *b.q);
    srand(1);
    for (size_t k = 0; k < STATES * b.stride; k++)
        b.q[k] = 2.0 * rand() / RAND_MAX - 1;
    b.request = (tfa_request){.op = TFA_OP_OPERATIONAL_INERTIA,
                              .estimate = TFA_ESTIMATE_NEVER,
                              .refine = refine,
                              .count = 1,
                              .base_pose = pose};
    printf("%s, %s base\n", path, base == TFA_BASE_FLOATING ? "floating" : "fixed");
    for (uint32_t tips = 1; tips <= TFA_MAX_TIPS; tips *= 2) {
        b.request.tip_count = tips;
        for (uint32_t t = 0; t < tips; t++)
            b.request.tips[t] = link[count - 1 - t * count / tips];
        measure(&b, f128);
    }
    free(b.q);
    free(link);
    tfa_workspace_free(f128);
    tfa_workspace_free(b.w);
    tfa_model_free(model);
    tfa_report_free(&report);
    tfa_description_free(d);
    return 0;
}

int main(int argc, char **argv)
{
    tfa_base base = TFA_BASE_FIXED;
    uint32_t refine = 0;
    int along = 0, failed = 0;
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--floating") == 0)
            base = TFA_BASE_FLOATING;
        else if (strcmp(argv[k], "--along") == 0)
            along = 1;
        else if (strcmp(argv[k], "--refine") == 0 && k + 1 < argc)
            refine = (uint32_t)atoi(argv[++k]);
        else
            failed |= robot(argv[k], base, along, refine);
    return failed;
}
