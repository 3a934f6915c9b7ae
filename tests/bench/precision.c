/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a precision costs and what it gives: time of one forward dynamics beside aba in double, in
 * turns in one run, and the error against quadruple precision. CPU time of one thread, median of
 * rounds; a new q in every call.
 *
 *   totalforce chain random --bodies 128 > chain.urdf; bench_precision chain.urdf
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

#include "timing.h"

#define STATES 16
#define ROUNDS 21
#define SLICE_NS 2e6

#define F64 .precision = TFA_F64, .residual = TFA_RESIDUAL_SAME, .states = TFA_STATES_ONE
#define F32 .precision = TFA_F32, .residual = TFA_RESIDUAL_SAME, .states = TFA_STATES_ONE
#define F128 .precision = TFA_F128, .residual = TFA_RESIDUAL_SAME, .states = TFA_STATES_ONE
#define F32_F64 .precision = TFA_F32, .residual = TFA_RESIDUAL_F64, .states = TFA_STATES_ONE
#define F64_F128 .precision = TFA_F64, .residual = TFA_RESIDUAL_F128, .states = TFA_STATES_ONE

static struct way {
    const char *name;
    tfa_op op;
    tfa_workspace_options options;
    tfa_method method;
    uint32_t refine;
    tfa_workspace *workspace;
    double error, ns[ROUNDS];
} ways[] = {
    {"aba, f64", TFA_OP_FORWARD_DYNAMICS, {F64}, TFA_METHOD_ABA, 0, 0, 0, {0}},
    {"aba, f64, refined once", TFA_OP_FORWARD_DYNAMICS, {F64}, TFA_METHOD_ABA, 1, 0, 0, {0}},
    {"aba, f32", TFA_OP_FORWARD_DYNAMICS, {F32}, TFA_METHOD_ABA, 0, 0, 0, {0}},
    {"aba, f32+f64, 1 step", TFA_OP_FORWARD_DYNAMICS, {F32_F64}, TFA_METHOD_ABA, 1, 0, 0, {0}},
    {"aba, f32+f64", TFA_OP_FORWARD_DYNAMICS, {F32_F64}, TFA_METHOD_ABA, -1u, 0, 0, {0}},
    {"scan, f32+f64", TFA_OP_FORWARD_DYNAMICS, {F32_F64}, TFA_METHOD_SCAN, -1u, 0, 0, {0}},
    {"tfa, f64, refined once", TFA_OP_FORWARD_DYNAMICS, {F64}, TFA_METHOD_TFA, 1, 0, 0, {0}},
    {"aba, f64+f128", TFA_OP_FORWARD_DYNAMICS, {F64_F128}, TFA_METHOD_ABA, -1u, 0, 0, {0}},
    {"tfa, f64+f128", TFA_OP_FORWARD_DYNAMICS, {F64_F128}, TFA_METHOD_TFA, -1u, 0, 0, {0}},
    {"aba, f128", TFA_OP_FORWARD_DYNAMICS, {F128}, TFA_METHOD_ABA, 0, 0, 0, {0}},
    {"rnea, f64", TFA_OP_INVERSE_DYNAMICS, {F64}, TFA_METHOD_RNEA, 0, 0, 0, {0}},
    {"rnea, f128", TFA_OP_INVERSE_DYNAMICS, {F128}, TFA_METHOD_RNEA, 0, 0, 0, {0}},
};
#define WAYS ((int)(sizeof ways / sizeof *ways))
#define REFERENCE 9 /* aba, f128 */

static double *q, *v, *tau, *answer[STATES];

static void ask(const struct way *w, size_t state, size_t n, double *out)
{
    const tfa_request r = {.op = w->op,
                           .method = w->method,
                           .estimate = TFA_ESTIMATE_NEVER,
                           .refine = w->refine,
                           .count = 1,
                           .q = q + n * state,
                           .v = v + n * state,
                           .tau = tau + n * state,
                           .qdd = v + n * state};
    tfa_reply reply = {.qdd = out, .tau = out};
    if (tfa_compute(w->workspace, &r, &reply) != TFA_OK)
        exit(EXIT_FAILURE);
}

static double sample(const struct way *w, size_t n, double *out)
{
    long calls = 0;
    const double start = cpu_ns();
    double now = start;
    for (size_t state = 0; now - start < SLICE_NS || calls < 3; state = (state + 1) % STATES) {
        ask(w, state, n, out);
        calls++;
        now = cpu_ns();
    }
    return (now - start) / (double)calls;
}

/* The largest relative error of the states */
static void measure_error(struct way *w, size_t n, double *out)
{
    w->error = 0;
    for (size_t state = 0; w->op == TFA_OP_FORWARD_DYNAMICS && state < STATES; state++) {
        double difference = 0, size = 0;
        ask(w, state, n, out);
        for (size_t k = 0; k < n; k++) {
            difference += pow(out[k] - answer[state][k], 2);
            size += pow(answer[state][k], 2);
        }
        w->error = fmax(w->error, sqrt(difference / size));
    }
}

static void run(const tfa_model *model, const char *file)
{
    const size_t n = tfa_model_v_count(model);
    double *out = calloc(n, sizeof *out);
    double **arrays[] = {&q, &v, &tau};
    for (int a = 0; a < 3; a++) {
        *arrays[a] = calloc(STATES * n, sizeof **arrays[a]);
        for (size_t k = 0; k < STATES * n; k++)
            (*arrays[a])[k] = 2.0 * rand() / RAND_MAX - 1;
    }
    for (int k = 0; k < WAYS; k++)
        if (tfa_workspace_create(model, &ways[k].options, &ways[k].workspace) != TFA_OK)
            exit(EXIT_FAILURE);
    for (size_t state = 0; state < STATES; state++)
        ask(&ways[REFERENCE], state, n, answer[state] = calloc(n, sizeof(double)));
    for (int round = 0; round < ROUNDS; round++)
        for (int k = 0; k < WAYS; k++)
            ways[k].ns[round] = sample(&ways[k], n, out);
    for (int k = 0; k < WAYS; k++) {
        struct way *w = &ways[k];
        qsort(w->ns, ROUNDS, sizeof *w->ns, by_value);
        measure_error(w, n, out);
        printf("%s, %zu freedoms: %-24s %9.1f ns a freedom, %7.2f of aba; error %.1e\n", file, n,
               w->name, w->ns[ROUNDS / 2] / (double)n, w->ns[ROUNDS / 2] / ways[0].ns[ROUNDS / 2],
               w->error);
        tfa_workspace_free(w->workspace);
    }
}

int main(int argc, char **argv)
{
    for (int k = 1; k < argc; k++) {
        tfa_description *d = NULL;
        tfa_report report = {0};
        tfa_model *model = NULL;
        if (tfa_urdf_load(argv[k], &d, &report) != TFA_OK ||
            tfa_model_create(d, NULL, &report, &model) != TFA_OK)
            return EXIT_FAILURE;
        run(model, argv[k]);
        tfa_model_free(model);
        tfa_description_free(d);
        tfa_report_free(&report);
    }
    return EXIT_SUCCESS;
}
