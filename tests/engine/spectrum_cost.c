/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The spectrum costs a small multiple of the request that it belongs to: medians of the same
 * request with and without it, in turns.
 */
#include "models.h"
#include "support/sanitized.h"
#include "test.h"

#include <time.h>

#define TIMES_MAX 10.0
#define TURNS 201
#define COORDINATES_MAX 64
#define N (6 * TFA_DEFAULT_TIPS)

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, TURNS, sizeof *values, by_value);
    return values[TURNS / 2];
}

/* Median time with the spectrum over that without. */
static double ratio(tfa_workspace *w, tfa_request *r, tfa_reply *reply)
{
    static double ns[2][TURNS];
    for (int turn = 0; turn < TURNS; turn++)
        for (int with = 0; with < 2; with++) {
            r->flags = with ? TFA_WANT_SPECTRUM : 0;
            const double start = now();
            for (int call = 0; call < 4; call++)
                assert_int_equal(tfa_compute(w, r, reply), TFA_OK);
            ns[with][turn] = now() - start;
        }
    return median(ns[1]) / median(ns[0]);
}

/* Tips spread over the links, the largest number of them. */
static void law(const char *file, tfa_base base, tfa_op op)
{
    static double q[COORDINATES_MAX], v[COORDINATES_MAX], qdd[COORDINATES_MAX], lambda[N * N];
    static const double pose[7] = {[6] = 1};
    double base_acceleration[6];
    tfa_spectrum spectrum;
    tfa_model *model = bundled_model(file, &(tfa_model_options){.base = base});
    tfa_workspace *w = workspace_for(model, NULL);
    const uint32_t links = tfa_model_frame_count(model);
    assert_in_range(tfa_model_q_count(model), 1, COORDINATES_MAX);
    for (uint32_t k = 0; k < COORDINATES_MAX; k++)
        q[k] = 0.3 + 0.1 * k, v[k] = 0.05 * k;
    tfa_request r = {
        .op = op, .count = 1, .q = q, .v = v, .base_pose = pose, .tip_count = TFA_DEFAULT_TIPS};
    for (uint32_t t = 0; t < TFA_DEFAULT_TIPS; t++)
        r.tips[t] = links - 1 - t * (links - 1) / TFA_DEFAULT_TIPS;
    tfa_reply reply = {.lambda_inv = lambda, .spectrum = &spectrum};
    if (op == TFA_OP_FORWARD_DYNAMICS) {
        reply.qdd = qdd;
        reply.base_acceleration = base == TFA_BASE_FLOATING ? base_acceleration : NULL;
    }
    const double times = ratio(w, &r, &reply);
    print_message("  %s, base %d, op %d: %.1f times, rank %u\n", file, base, op, times,
                  spectrum.rank);
    if (!(times <= TIMES_MAX))
        fail_msg("%s, base %d, op %d: the spectrum makes it %.1f times as long, at most %.0f", file,
                 base, op, times, TIMES_MAX);
    tfa_workspace_free(w);
    tfa_model_free(model);
}

TEST(the_spectrum_costs_a_small_multiple)
{
#if defined(SANITIZED) || !defined(__OPTIMIZE__)
    print_message("not the product's code: its times say nothing\n");
    skip();
#endif
    for (tfa_base base = TFA_BASE_FIXED; base <= TFA_BASE_FLOATING; base++) {
        law("arm7.urdf", base, TFA_OP_OPERATIONAL_INERTIA);
        law("arm7.urdf", base, TFA_OP_FORWARD_DYNAMICS);
        law("humanoid.urdf", base, TFA_OP_OPERATIONAL_INERTIA);
        law("humanoid.urdf", base, TFA_OP_FORWARD_DYNAMICS);
    }
}
