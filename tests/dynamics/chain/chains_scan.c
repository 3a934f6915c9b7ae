/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan: the same numbers as the articulated-body algorithm for every length of chain,
 * where it cuts, and its associative combination. Its error: chains_scan_error.c.
 */
#include "support/chains_scan.h"

#include "dynamics/core/recursions.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/scan/scan.h"
#include "dynamics/solve/method.h"
#include "support/chains_state.h"
#include "support/fixture.h"
#include "test.h"

/* ---- every length, in quadruple precision ---- */

static double worst_length;

static void compare(struct bench *b, tfa_method method)
{
    struct state *s = bench_state(b);
    const uint32_t n = b->model->freedoms;
    const struct chain_method *chain = TFA_V(method)(method)->chain;
    num *want = calloc(n, sizeof *want), *got = calloc(n, sizeof *got);
    assert_true(want && got);
    for (int bias = 0; bias < 2; bias++) {
        num difference = 0, size = 0;
        if (bias) {
            TFA_V(aba)(s, s->tau, want);
        } else {
            TFA_V(aba_factor)(s);
            TFA_V(aba_solve)(s, s->tau, want);
        }
        assert_int_equal(TFA_V(chain_factor)(s, chain), TFA_OK);
        for (int again = 0; again < 2; again++) { /* factors last; the answer may be the question */
            memcpy(got, s->tau, n * sizeof *got);
            TFA_V(chain_solve)(s, chain, got, got, bias);
        }
        for (uint32_t k = 0; k < n; k++) {
            difference += (got[k] - want[k]) * (got[k] - want[k]);
            size += want[k] * want[k];
        }
        const double error = sqrt((double)(difference / size));
        assert_false(s->stalled);
        if (!(error < 1e-25))
            fail_msg("%s, %u links, %s: error %.3g", b->d->name, (unsigned)b->d->joint_count,
                     tfa_method_name((uint32_t)method), error);
        worst_length = fmax(worst_length, error);
    }
    free(got);
    free(want);
    free(b->memory);
    b->memory = NULL;
}

TEST(every_length_equals_aba)
{
    static const chain_mechanism kinds[] = {CHAIN_MIXED, CHAIN_POINTS, CHAIN_HEAVY_SPOTS};
    for (uint32_t links = 1; links <= 130; links += links < 40 ? 1 : test_extent(7, 1))
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            const tfa_base base = (links + k) % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
            struct bench b = bench_open(kinds[k], links, base, links);
            compare(&b, TFA_METHOD_SCAN);
            compare(&b, TFA_METHOD_SCAN_TWO_PASS);
            compare(&b, TFA_METHOD_HYBRID);
            bench_close(&b);
        }
    print_message("  worst difference %.2g\n", worst_length);
}

/* ---- Lambda^-1 of a tip ---- */

TEST(tip_equals_propagation)
{
    num want[36];
    for (uint32_t links = 1; links <= 130; links += links < 40 ? 1 : 7) {
        struct bench b = bench_open(CHAIN_MIXED, links, TFA_BASE_FIXED, links);
        struct state *s = bench_state(&b);
        s->tips = 1;
        s->tip[0] = tfa_model_frame_count(b.model) - 1;
        TFA_V(aba_factor)(s);
        TFA_V(lambda_propagation)(s, TFA_FRAME_LOCAL);
        TFA_V(lambda_mirror)(s);
        memcpy(want, s->lambda, sizeof want);
        for (int two = 0; two < 2; two++) {
            const tfa_method method = two ? TFA_METHOD_SCAN_TWO_PASS : TFA_METHOD_SCAN;
            num worst = 0, size = 0;
            assert_int_equal(TFA_V(chain_factor)(s, TFA_V(method)(method)->chain), TFA_OK);
            assert_int_equal(TFA_V(scan_lambda)(s, TFA_FRAME_LOCAL), 1);
            for (int k = 0; k < 36; k++) {
                const num d = num_abs(s->lambda[k] - want[k]);
                worst = d > worst ? d : worst;
                size = num_abs(want[k]) > size ? num_abs(want[k]) : size;
            }
            assert_true((double)(worst / size) < 1e-28);
        }
        bench_close(&b);
    }
}

/* ---- side branches ---- */

/* Every fourth link hangs from the one before as a branch of its own: the chain goes on beside
 * it. */
static void branch(tfa_description *d)
{
    for (size_t k = 2; k + 1 < d->joint_count; k += 4)
        d->joints[k + 1].parent = d->joints[k].parent;
}

/* Side branches, wrenches, velocities, rotor inertia, all types of joints, two trees at times */
TEST(branches_and_wrenches_equal_aba)
{
    for (uint32_t test_case = 0; test_case < 40; test_case++) {
        const tfa_base base = test_case % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
        struct bench b = {.d = chain_create(CHAIN_MIXED, 50 + 2 * test_case, test_case)};
        random_source r = {test_case};
        branch(b.d);
        if (test_case % 4 == 0)
            b.d->joints[20].parent = 0;
        bench_load(&b, CHAIN_MIXED, base, test_case);
        for (uint32_t k = 0; k < 2; k++) {
            b.wrench_frames[k] = random_below(&r, tfa_model_frame_count(b.model));
            for (uint32_t e = 0; e < 6; e++)
                b.wrenches[6 * k + e] = random_uniform(&r, -5, 5);
        }
        b.wrench_count = 2;
        assert_int_equal(b.model->trees, base == TFA_BASE_FIXED && test_case % 4 == 0 ? 2 : 1);
        compare(&b, TFA_METHOD_SCAN);
        compare(&b, TFA_METHOD_SCAN_TWO_PASS);
        compare(&b, TFA_METHOD_HYBRID);
        bench_close(&b);
    }
    print_message("  worst difference %.2g\n", worst_length);
}

/* ---- cuts ---- */

static const struct scan *factored(struct bench *b, tfa_method method)
{
    struct state *s = bench_state(b);
    assert_int_equal(TFA_V(chain_factor)(s, TFA_V(method)(method)->chain), TFA_OK);
    return (const struct scan *)(const void *)s->rows;
}

static uint32_t refactored(const struct scan *scan)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < scan->segments; k++)
        count += scan->segment[k].refactored != 0;
    return count;
}

/* Segments cover the chain, 12 to 20 bodies each, and end on bodies with mass. */
TEST(cuts_end_on_heavy_bodies)
{
    struct bench b = bench_open(CHAIN_ALTERNATING9, 500, TFA_BASE_FIXED, 3);
    const struct scan *scan = factored(&b, TFA_METHOD_SCAN);
    uint32_t at = 0;
    assert_true(scan->segments > 25);
    for (uint32_t k = 0; k < scan->segments; k++) {
        const struct scan_segment *segment = &scan->segment[k];
        assert_int_equal(segment->first, at);
        at = segment->end;
        if (k + 1 == scan->segments)
            break;
        assert_in_range(segment->end - segment->first, 12, 20);
        assert_true(b.model->body[b.model->chain[0].body[at - 1]].mass > 0.5);
    }
    assert_int_equal(at, 500);
    assert_int_equal(refactored(scan), 0);
    bench_close(&b);
}

/* A millionfold heavier tip right behind a cut: one segment goes a second time, not the others. */
TEST(a_cut_with_a_large_ratio_gets_a_second_pass)
{
    uint32_t light = 0;
    for (uint32_t links = 20; links < 120; links++) {
        struct bench b = bench_open(CHAIN_HEAVY_TIP, links, TFA_BASE_FIXED, links);
        const uint32_t count = refactored(factored(&b, TFA_METHOD_SCAN));
        assert_true(count <= 1);
        light += count;
        free(b.memory);
        const struct scan *two = factored(&b, TFA_METHOD_SCAN_TWO_PASS);
        assert_int_equal(refactored(two), two->segments - 1);
        bench_close(&b);
    }
    print_message("  %u of 100 chains with a heavy tip\n", (unsigned)light);
}

/* ---- the associative combination ---- */

/* B^T B */
static void square(num *out, const num *B)
{
    struct row6 b[6], c[6];
    mat6_rows_load(b, B);
    mat6_rows_tmul(c, B, b);
    mat6_rows_store(out, c);
}

static void random_element(random_source *r, struct scan_element *x)
{
    num B[MAT6_PADDED], K[MAT6_PADDED];
    for (int k = 0; k < 36; k++) {
        x->A[k] = (num)random_uniform(r, -1, 1);
        B[k] = k < 18 ? (num)random_uniform(r, -1, 1) : 0; /* C and J of rank 3 */
        K[k] = k < 18 ? (num)random_uniform(r, -1, 1) : 0;
    }
    square(x->C, B);
    square(x->J, K);
}

static double element_difference(const struct scan_element *x, const struct scan_element *y)
{
    num worst = 0;
    for (int k = 0; k < 36; k++) {
        const num d[3] = {x->A[k] - y->A[k], x->C[k] - y->C[k], x->J[k] - y->J[k]};
        for (int e = 0; e < 3; e++)
            worst = num_abs(d[e]) > worst ? num_abs(d[e]) : worst;
    }
    return (double)worst;
}

TEST(combining_is_associative)
{
    random_source r = {5};
    for (int test_case = 0; test_case < 100; test_case++) {
        struct scan_element x[3];
        for (int k = 0; k < 3; k++)
            random_element(&r, &x[k]);
        const struct scan_element inner = scan_combine(&x[0], &x[1]),
                                  outer = scan_combine(&x[1], &x[2]);
        const struct scan_element one = scan_combine(&inner, &x[2]),
                                  other = scan_combine(&x[0], &outer);
        assert_true(element_difference(&one, &other) < 1e-28);
        assert_true(element_difference(&one, &inner) > 1e-3);
    }
}
