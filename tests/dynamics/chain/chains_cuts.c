/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forces at the cuts of a chain (scan/cut_forces.h) for cuts of any number: one segment is aba, one
 * body a segment is cfa, all between give the same accelerations; the iterations of conjugate
 * gradients, and that they tell where they do not suffice.
 */
#include "dynamics/core/aba_step.h"
#include "dynamics/core/recursions.h"
#include "dynamics/scan/cut_forces.h"
#include "support/chains_scan.h"
#include "support/chains_state.h"
#include "support/random_robot.h"
#include "test.h"

/* A chain cut into so many segments; its qdd by aba and by the forces at the cuts */
struct cuts {
    struct bench b;
    struct state *s;
    const struct tfa_chain *chain;
    struct scan *scan;
    num *want, *got;
};

static struct cuts open_cuts(struct bench b, uint32_t segments, double tolerance)
{
    struct cuts x = {.b = b};
    struct state *s = x.s = bench_state(&x.b);
    const uint32_t links = s->m->chain[0].length;
    x.chain = s->m->chain;
    x.scan = aligned_alloc(64, TFA_V(scan_with_cuts_bytes)(links, segments));
    x.want = calloc((size_t)2 * links, sizeof *x.want);
    assert_true(x.scan && x.want);
    x.got = x.want + links;
    (void)TFA_V(scan_with_cuts)(x.scan, links, segments);
    x.scan->segments = segments;
    x.scan->cuts->tolerance = (num)tolerance;
    for (uint32_t k = 0; k < segments; k++)
        x.scan->segment[k] =
            (struct scan_segment){.first = links * k / segments, .end = links * (k + 1) / segments};
    TFA_V(aba)(s, s->tau, x.want);
    assert_int_equal(TFA_V(chain_reduce_branches)(s, x.chain, 1), TFA_OK);
    assert_int_equal(TFA_V(scan_factor_floating)(s, x.chain, x.scan), TFA_OK);
    return x;
}

static void solve_cuts(struct cuts *x)
{
    for (uint32_t i = 0; i < x->s->m->bodies; i++)
        aba_backward_start(x->s, i, ABA_FORCE | ABA_BIAS);
    TFA_V(scan_solve)(x->s, x->chain, x->scan, x->s->tau, x->got, 1);
}

static void close_cuts(struct cuts *x)
{
    free(x->scan);
    free(x->want);
    bench_close(&x->b);
}

static double error_of(const struct cuts *x)
{
    num difference = 0, size = 0;
    for (uint32_t j = 0; j < x->s->m->freedoms; j++) {
        difference += (x->got[j] - x->want[j]) * (x->got[j] - x->want[j]);
        size += x->want[j] * x->want[j];
    }
    return sqrt((double)(difference / size));
}

/* ---- the accelerations ---- */

TEST(any_number_of_segments_equals_aba)
{
    double worst = 0;
    for (uint32_t links = 1; links <= 40; links += links < 10 ? 1 : 6)
        for (uint32_t segments = 1; segments <= links; segments++)
            for (int iterative = 0; iterative < 2; iterative++) {
                const chain_mechanism mechanism = segments % 2 ? CHAIN_RANDOM : CHAIN_HELIX;
                struct cuts x = open_cuts(bench_open(mechanism, links, TFA_BASE_FIXED, links),
                                          segments, iterative ? 1e-30 : 0);
                solve_cuts(&x);
                const double error = error_of(&x);
                if (!(error < 1e-25))
                    fail_msg("%u links, %u segments, %s: %.3g", (unsigned)links, (unsigned)segments,
                             iterative ? "iterative" : "direct", error);
                assert_false(x.s->stalled);
                worst = fmax(worst, error);
                close_cuts(&x);
            }
    print_message("  worst difference %.2g\n", worst);
}

static double largest_difference(const num *x, const num *y, uint32_t rows, uint32_t columns)
{
    double worst = 0;
    for (uint32_t e = 0; e < rows; e++)
        for (uint32_t f = 0; f < columns; f++)
            worst = fmax(worst, (double)num_abs(x[6 * e + f] - y[6 * e + f]));
    return worst;
}

TEST(one_body_a_segment_is_cfa)
{
    for (uint32_t links = 2; links <= 40; links += 7) {
        struct cuts x = open_cuts(bench_open(CHAIN_RANDOM, links, TFA_BASE_FIXED, links), links, 1);
        struct cfa_row *row = calloc(links, sizeof *row);
        num D[36], L[36];
        assert_non_null(row);
        for (uint32_t k = 0; k < links; k++) {
            const struct cyclic_row *got = &x.scan->cuts->system[k];
            assert_int_equal(cfa_start(x.s, x.chain, row, k), 1);
            cfa_assemble(x.s, x.chain, row, k, D, L);
            if (k < 2) /* the first row is eliminated */
                continue;
            assert_int_equal(got->size, 5);
            assert_true(largest_difference(got->D.a, D, 5, 5) < 1e-28);
            assert_true(largest_difference(got->L, L, 5, 5) < 1e-28);
        }
        free(row);
        close_cuts(&x);
    }
}

/* ---- iterations ---- */

/* Those of the same mechanisms in the prototype, to 1e-12; coil: 5 pi / N about the links */
static const struct {
    chain_mechanism mechanism;
    uint32_t links, segments, iterations;
} iterations[] = {
    {CHAIN_RANDOM, 64, 4, 10},         {CHAIN_RANDOM, 64, 8, 24},
    {CHAIN_RANDOM, 1024, 4, 1},        {CHAIN_RANDOM, 1024, 16, 3},
    {CHAIN_RANDOM, 1024, 64, 22},      {CHAIN_STRAIGHT, 1024, 4, 5},
    {CHAIN_STRAIGHT, 1024, 16, 17},    {CHAIN_STRAIGHT, 1024, 64, 67},
    {CHAIN_HELIX, 1024, 4, 12},        {CHAIN_HELIX, 1024, 16, 57},
    {CHAIN_ALTERNATING, 1024, 4, 2},   {CHAIN_ALTERNATING, 1024, 16, 3},
    {CHAIN_ALTERNATING, 1024, 64, 19},
};

static struct bench coil(uint32_t links)
{
    struct bench b = {.d = chain_create(CHAIN_HELIX, links, 1)};
    random_source r = {3};
    for (size_t k = 0; k < links; k++) {
        b.d->joints[k].quat[0] = sin(2.5 * acos(-1) / links);
        b.d->joints[k].quat[3] = cos(2.5 * acos(-1) / links);
    }
    bench_load(&b, CHAIN_HELIX, TFA_BASE_FIXED, 1);
    for (size_t k = 0; k < links; k++)
        b.q[k] = random_uniform(&r, -0.5, 0.5);
    return b;
}

TEST(iterations_are_few)
{
    for (size_t k = 0; k < sizeof iterations / sizeof *iterations; k++) {
        const uint32_t links = iterations[k].links, segments = iterations[k].segments;
        struct cuts x =
            open_cuts(iterations[k].mechanism == CHAIN_HELIX
                          ? coil(links)
                          : bench_open(iterations[k].mechanism, links, TFA_BASE_FIXED, 1),
                      segments, 1e-12);
        solve_cuts(&x);
        print_message("  %s %u / %u: %d iterations, error %.1e\n",
                      chain_mechanism_names[iterations[k].mechanism], (unsigned)links,
                      (unsigned)segments, x.scan->cuts->iterations, error_of(&x));
        assert_in_range(x.scan->cuts->iterations, 0, (3 * iterations[k].iterations + 1) / 2);
        assert_false(x.s->stalled);
        close_cuts(&x);
    }
}

/* One body a segment: the system of cfa, condition 4e9, which the iterations do not solve. */
TEST(a_stall_is_told)
{
    struct cuts x = open_cuts(bench_open(CHAIN_ALTERNATING, 64, TFA_BASE_FIXED, 1), 64, 1e-12);
    solve_cuts(&x);
    assert_true(x.s->stalled);
    close_cuts(&x);
}
