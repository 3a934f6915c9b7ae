/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segments of a chain in SIMD lanes: where they are cut, the numbers of the
 * articulated-body algorithm for every length, and the same bits on any number of threads. Meant to
 * run under ThreadSanitizer too. Errors: chains_scan_error.c.
 */
#include "dynamics/scan/chain_cut.h"
#include "engine/workspace.h"
#include "models.h"
#include "support/chains_scan.h"
#include "support/random_robot.h"
#include "test.h"

#include <totalforce/totalforce.h>

#define STATES 3u
#define STEP (4u / TEST_ROUNDS(4u)) /* between lengths */
enum { POOLS = 3 };
static const uint32_t pool_threads[POOLS] = {2, 3, 7};

struct test_case {
    tfa_description *description;
    tfa_model *model;
    tfa_workspace *workspace;
    size_t n;
    double *q, *v, *tau, *want, *got;
    double pose[7 * STATES]; /* of a floating base */
};

static struct test_case test_case_open(chain_mechanism mechanism, uint32_t links, tfa_base base,
                                       double damping)
{
    struct test_case x = {.description = chain_create(mechanism, links, links)};
    const tfa_model_options options = {.base = base, .damping = 1, .friction = damping > 0};
    random_source s = {links};
    for (size_t k = 0; k < x.description->joint_count; k++)
        x.description->joints[k].damping = x.description->joints[k].friction =
            damping * (double)(k % 3);
    x.model = compiled(x.description, &options);
    const tfa_workspace_options workspace_options = {.methods = TFA_METHODS_ALL};
    x.workspace = workspace_for(x.model, &workspace_options);
    x.n = tfa_model_v_count(x.model);
    x.q = calloc(8 * STATES * x.n, sizeof *x.q);
    assert_non_null(x.q);
    x.v = x.q + STATES * x.n;
    x.tau = x.v + STATES * x.n;
    x.want = x.tau + STATES * x.n;
    x.got = x.want + STATES * x.n;
    for (uint32_t k = 0; k < STATES; k++) {
        chain_coordinates(mechanism, x.description, k + 1, x.q + k * x.n);
        x.pose[7 * k + 6] = 1;
    }
    for (size_t k = 0; k < STATES * x.n; k++) {
        x.v[k] = random_uniform(&s, -1, 1);
        x.tau[k] = random_uniform(&s, -1, 1);
    }
    return x;
}

static void test_case_close(struct test_case *x)
{
    free(x->q);
    tfa_workspace_free(x->workspace);
    tfa_model_free(x->model);
    chain_free(x->description);
}

static tfa_request request_of(const struct test_case *x, tfa_method method, int moving)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .method = method,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .count = STATES,
                         .q = x->q,
                         .v = moving ? x->v : NULL,
                         .tau = x->tau,
                         .base_pose = tfa_model_base_freedoms(x->model) ? x->pose : NULL};
}

/* ---- the cuts ---- */

TEST(segments_cover_the_chain)
{
    for (uint32_t links = 48; links < 400; links += links < 130 ? 1 : 37) {
        struct test_case x = test_case_open(CHAIN_HEAVY_SPOTS, links, TFA_BASE_FIXED, 0);
        const struct tfa_chain_segments s = tfa_cut_segments(x.model);
        uint32_t end = 0;
        assert_true(s.count >= 8 && s.count % 8 == 0 && s.count <= TFA_SEGMENTS_MAX);
        for (uint32_t k = 0; k < s.count; k++) {
            assert_int_equal(s.first[k], end);
            end += s.length[k];
            assert_true(s.shortest <= s.length[k] && s.length[k] <= s.longest);
            assert_true(s.length[k] * s.count * 4 > links * 3 - 4 * s.count);
        }
        assert_int_equal(end, links);
        test_case_close(&x);
    }
}

/* Other robots go another way. */
TEST(others_are_not_taken)
{
    static const struct {
        chain_mechanism mechanism;
        uint32_t links;
        tfa_base base;
    } others[] = {{CHAIN_RANDOM, 47, TFA_BASE_FIXED},
                  {CHAIN_MIXED, 100, TFA_BASE_FIXED},
                  {CHAIN_BRANCHES, 100, TFA_BASE_FIXED},
                  {CHAIN_RANDOM, 100, TFA_BASE_FLOATING}};
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        struct test_case x =
            test_case_open(others[k].mechanism, others[k].links, others[k].base, 0);
        assert_int_equal(tfa_cut_segments(x.model).count, 0);
        assert_null(x.workspace->segment_lanes);
        test_case_close(&x);
    }
}

/* ---- the numbers ---- */

/* aba's own error here is up to 1e-9 */
#define BOUND 1e-8

static void compare(struct test_case *x, tfa_method method, int moving)
{
    tfa_answer answers[STATES];
    tfa_reply want = {.qdd = x->want}, got = {.qdd = x->got, .answers = answers};
    tfa_request r = request_of(x, TFA_METHOD_ABA, moving);
    assert_int_equal(tfa_compute(x->workspace, &r, &want), TFA_OK);
    r.method = method;
    assert_int_equal(tfa_compute(x->workspace, &r, &got), TFA_OK);
    for (uint32_t k = 0; k < STATES; k++) {
        double difference = 0, size = 0;
        for (size_t j = k * x->n; j < (k + 1) * x->n; j++) {
            difference += (x->got[j] - x->want[j]) * (x->got[j] - x->want[j]);
            size += x->want[j] * x->want[j];
        }
        if (!(sqrt(difference / size) < BOUND))
            fail_msg("%s, %zu joints, %s, %s: %.3g", x->description->name, x->n,
                     tfa_method_name((uint32_t)method), moving ? "moving" : "at rest",
                     sqrt(difference / size));
        assert_int_equal(answers[k].method, method);
        assert_int_equal(answers[k].flags, 0);
    }
}

TEST(every_length_equals_aba)
{
    static const chain_mechanism kinds[] = {CHAIN_RANDOM, CHAIN_HEAVY_SPOTS, CHAIN_HELIX,
                                            CHAIN_POINTS};
    for (uint32_t links = 48; links < 300; links += (links < 100 ? 1 : 23) * STEP)
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            struct test_case x =
                test_case_open(kinds[k], links, TFA_BASE_FIXED, links % 3 ? 0 : 0.1);
            assert_int_equal(x.workspace->segment_lanes != NULL,
                             tfa_cut_segments(x.model).count > 0);
            if (kinds[k] == CHAIN_RANDOM)
                assert_non_null(x.workspace->segment_lanes);
            for (int moving = 0; moving < 2; moving++) {
                compare(&x, TFA_METHOD_SCAN, moving);
                compare(&x, TFA_METHOD_SCAN_TWO_PASS, moving);
                if (kinds[k] == CHAIN_POINTS) /* refused: bodies without inverse */
                    continue;
                compare(&x, TFA_METHOD_TFA_CR, moving);
                memcpy(x.got + STATES * x.n, x.got, STATES * x.n * sizeof *x.got);
                compare(&x, TFA_METHOD_CFA_CR, moving);
                assert_memory_equal(x.got + STATES * x.n, x.got, STATES * x.n * sizeof *x.got);
            }
            test_case_close(&x);
        }
}

/* An answer that is not finite is not given, and the next one is none the worse. */
TEST(overflow_is_noticed)
{
    struct test_case x = test_case_open(CHAIN_RANDOM, 100, TFA_BASE_FIXED, 0);
    const double before = x.tau[x.n + 40];
    tfa_answer answers[STATES];
    tfa_reply reply = {.qdd = x.got, .answers = answers};
    const tfa_request r = request_of(&x, TFA_METHOD_SCAN, 1);
    x.tau[x.n + 40] = 1e308;
    assert_int_equal(tfa_compute(x.workspace, &r, &reply), TFA_E_NOT_COMPUTED);
    assert_int_equal(reply.state, 1);
    assert_int_equal(answers[0].status, TFA_OK);
    assert_int_equal(answers[1].status, TFA_E_NOT_COMPUTED);
    assert_int_equal(answers[2].status, TFA_OK);
    x.tau[x.n + 40] = before;
    compare(&x, TFA_METHOD_SCAN, 1);
    test_case_close(&x);
}

/* ---- threads ---- */

static void same_bits_on_threads(struct test_case *x, tfa_batch_pool *pool, tfa_method method,
                                 uint32_t count)
{
    tfa_request r = request_of(x, method, 1);
    tfa_reply want = {.qdd = x->want}, got = {.qdd = x->got};
    r.estimate = TFA_ESTIMATE_DEFAULT;
    r.refine = TFA_REFINE_DEFAULT;
    r.count = count;
    memset(x->got, 0, count * x->n * sizeof *x->got);
    assert_int_equal(tfa_compute(x->workspace, &r, &want), TFA_OK);
    assert_int_equal(tfa_batch_pool_compute(pool, &r, &got), TFA_OK);
    assert_memory_equal(x->got, x->want, count * x->n * sizeof *x->got);
}

TEST(threads_give_the_same_bits)
{
    static const tfa_method methods[] = {TFA_METHOD_SCAN, TFA_METHOD_SCAN_TWO_PASS,
                                         TFA_METHOD_TFA_CR, TFA_METHOD_CFA_CR, TFA_METHOD_ABA};
    static const uint32_t lengths[] = {60, 180, 840};
    static const struct {
        chain_mechanism mechanism;
        tfa_base base;
    } kinds[] = {{CHAIN_RANDOM, TFA_BASE_FIXED}, /* in lanes, from 64 bodies a lane on threads */
                 {CHAIN_RANDOM, TFA_BASE_FLOATING},
                 {CHAIN_BRANCHES, TFA_BASE_FIXED},
                 {CHAIN_ALTERNATING9, TFA_BASE_FLOATING}};
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
        for (size_t length = 0; length < sizeof lengths / sizeof *lengths; length++) {
            const uint32_t links = lengths[length];
            struct test_case x = test_case_open(kinds[kind].mechanism, links, kinds[kind].base, 0);
            for (int p = 0; p < POOLS; p++) {
                tfa_batch_pool *pool = NULL;
                const tfa_batch_pool_options options = {.threads = pool_threads[p],
                                                        .methods = TFA_METHODS_ALL};
                assert_int_equal(tfa_batch_pool_create(x.model, &options, &pool), TFA_OK);
                for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
                    for (uint32_t count = 1; count <= STATES; count++)
                        same_bits_on_threads(&x, pool, methods[m], count);
                tfa_batch_pool_free(pool);
            }
            test_case_close(&x);
        }
}
