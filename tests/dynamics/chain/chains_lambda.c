/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 in one go: every method that answers several tips by one block solve or one crossing
 * gives what force propagation gives, for every length of chain, in quadruple precision.
 */
#include "dynamics/core/recursions.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/scan/scan.h"
#include "dynamics/solve/method.h"
#include "support/chains_state.h"
#include "support/fixture.h"
#include "test.h"

#define LONGEST 40
#define TIPS 4
#define ENTRIES (36 * TIPS * TIPS)

/* Largest difference over largest entry; double of what is left of 34 digits */
static double difference(const num *got, const num *want, size_t n)
{
    num worst = 0, size = 0;
    for (size_t k = 0; k < n; k++) {
        const num d = num_abs(got[k] - want[k]), x = num_abs(want[k]);
        worst = d > worst || !(d == d) ? d : worst;
        size = x > size ? x : size;
    }
    return (double)(size > 0 ? worst / size : worst);
}

/* One of: a method along chains refined so many times; the scan; composed propagators */
static struct way {
    const char *name;
    tfa_method factors;
    uint32_t refine;
    double bound, worst;
    uint32_t answered;
} ways[] = {
    {"tfa", TFA_METHOD_TFA, 0, 2e-30, 0, 0},
    {"tfa, refined", TFA_METHOD_TFA, 1, 2e-31, 0, 0},
    {"tfa, refined twice", TFA_METHOD_TFA, 2, 2e-31, 0, 0},
    {"tfa-cr", TFA_METHOD_TFA_CR, 0, 2e-30, 0, 0},
    {"tfa-cr, refined", TFA_METHOD_TFA_CR, 1, 2e-31, 0, 0},
    {"tfa-cr, refined twice", TFA_METHOD_TFA_CR, 2, 2e-31, 0, 0},
    {"scan", TFA_METHOD_SCAN, 0, 5e-32, 0, 0},
    {"scan-two-pass", TFA_METHOD_SCAN_TWO_PASS, 0, 5e-32, 0, 0},
    {"pv-osimr", TFA_METHOD_ABA, 0, 2e-32, 0, 0},
};
#define WAYS (sizeof ways / sizeof *ways)

/* 0: the way does not answer these tips, or refuses a body of theirs */
static int answer_way(struct state *s, const struct way *way)
{
    const struct chain_method *chain = TFA_V(method)(way->factors)->chain;
    if (TFA_V(factor)(s, way->factors) != TFA_OK)
        return 0;
    if (!chain)
        TFA_V(lambda_pv)(s, TFA_FRAME_WORLD);
    else if (chain->forces_6rhs)
        TFA_V(lambda_chain)(s, TFA_FRAME_WORLD, chain, way->refine);
    else
        return TFA_V(scan_lambda)(s, TFA_FRAME_WORLD);
    return 1;
}

static void every_way(struct bench *b, const uint32_t *tips)
{
    static num want[ENTRIES];
    struct state *s = bench_state(b);
    for (s->tips = 1; s->tips <= TIPS; s->tips += s->tips < 2 ? 1 : 2) {
        const size_t n = (size_t)36 * s->tips * s->tips;
        memcpy(s->tip, tips, s->tips * sizeof *tips);
        TFA_V(aba_factor)(s);
        TFA_V(lambda_propagation)(s, TFA_FRAME_WORLD);
        TFA_V(lambda_mirror)(s);
        memcpy(want, s->lambda, n * sizeof *want);
        for (size_t w = 0; w < WAYS; w++) {
            if (!answer_way(s, &ways[w]))
                continue;
            TFA_V(lambda_mirror)(s);
            const double error = difference(s->lambda, want, n);
            if (!(error <= ways[w].bound))
                fail_msg("%s, %u links, %u tips (%u %u %u %u), %s: %g", b->d->name, (unsigned)b->n,
                         (unsigned)s->tips, (unsigned)tips[0], (unsigned)tips[1], (unsigned)tips[2],
                         (unsigned)tips[3], ways[w].name, error);
            ways[w].worst = fmax(ways[w].worst, error);
            ways[w].answered++;
        }
    }
}

static void print_ways(void)
{
    for (size_t w = 0; w < WAYS; w++) {
        print_message("  %-22s %5u answers, worst %.1e\n", ways[w].name, (unsigned)ways[w].answered,
                      ways[w].worst);
        assert_true(ways[w].answered > LONGEST);
    }
}

/* The last link, the one in the middle, any, and the root */
TEST(every_length)
{
    static const chain_mechanism kinds[] = {CHAIN_MIXED, CHAIN_POINTS};
    for (uint32_t links = 1; links <= LONGEST; links++)
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            const tfa_base base = (links + k) % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
            struct bench b = bench_open(kinds[k], links, base, links);
            random_source r = {links};
            const uint32_t tips[TIPS] = {links, links / 2, random_below(&r, links), 0};
            every_way(&b, tips);
            bench_close(&b);
        }
    print_ways();
}

/* Branches at any link, two trees at times, fused joints: tips on the chain, on its side branches,
 * on one body, inside a joint */
TEST(side_branches)
{
    for (uint32_t test_case = 0; test_case < 72; test_case++) {
        const uint32_t links = 4 + test_case % 50;
        const tfa_base base = test_case % 4 > 1 ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
        struct bench b = {.d = chain_create(CHAIN_MIXED, links, test_case)};
        random_source r = {test_case};
        for (size_t k = 1; k < b.d->joint_count; k++)
            if (random_below(&r, 4) == 0)
                b.d->joints[k].parent = b.d->joints[random_below(&r, (uint32_t)k)].parent;
        if (test_case % 2)
            random_robot_empty_links(&r, b.d, 0.3);
        if (tfa_model_size(b.d, NULL) > 0) { /* none: more than six joints without mass in a row */
            uint32_t tips[TIPS];
            bench_load(&b, CHAIN_MIXED, base, test_case);
            for (uint32_t t = 0; t < TIPS; t++)
                tips[t] = random_below(&r, tfa_model_frame_count(b.model));
            if (test_case % 5 == 0)
                tips[3] = tips[0];
            if (tfa_model_summarise(b.model).singular_body < 0)
                every_way(&b, tips);
        }
        bench_close(&b);
    }
    print_ways();
}

/* The scan has what a tip before the last cut needs only up to what the scan itself knows. */
TEST(scan_refuses_tips_before_the_last_cut)
{
    struct bench b = bench_open(CHAIN_RANDOM, 64, TFA_BASE_FIXED, 1);
    struct state *s = bench_state(&b);
    assert_int_equal(TFA_V(factor)(s, TFA_METHOD_SCAN), TFA_OK);
    const struct scan *scan = (const struct scan *)(const void *)s->rows;
    const uint32_t last = scan->segment[scan->segments - 1].first;
    s->tips = 2;
    s->tip[0] = 64;
    for (uint32_t link = 0; link <= 64; link++) { /* link k is body k - 1, link 0 the root */
        s->tip[1] = link;
        assert_int_equal(TFA_V(scan_lambda)(s, TFA_FRAME_LOCAL), link == 0 || link > last);
    }
    bench_close(&b);
}
