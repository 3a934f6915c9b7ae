/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The spectrum costs a small multiple of the request that it belongs to, at most ten: medians of
 * the same request with and without it, in turns.
 */
#include "models.h"
#include "support/wait.h"
#include "test.h"

#define TURNS 201
#define COORDINATES_MAX 64
#define N (6 * TFA_DEFAULT_TIPS)

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
            const uint64_t start = now_ns();
            for (int call = 0; call < 4; call++)
                assert_int_equal(tfa_compute(w, r, reply), TFA_OK);
            ns[with][turn] = (double)(now_ns() - start);
        }
    return median(ns[1]) / median(ns[0]);
}

/* Tips spread over the links, the largest number of them. */
static void compare(const char *file, tfa_base base, tfa_op op)
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
    print_message("%s, base %d, op %d: %.1f times, rank %u\n", file, base, op, times,
                  spectrum.rank);
    tfa_workspace_free(w);
    tfa_model_free(model);
}

TEST(the_spectrum)
{
    for (tfa_base base = TFA_BASE_FIXED; base <= TFA_BASE_FLOATING; base++) {
        compare("arm7.urdf", base, TFA_OP_OPERATIONAL_INERTIA);
        compare("arm7.urdf", base, TFA_OP_FORWARD_DYNAMICS);
        compare("humanoid.urdf", base, TFA_OP_OPERATIONAL_INERTIA);
        compare("humanoid.urdf", base, TFA_OP_FORWARD_DYNAMICS);
    }
}
