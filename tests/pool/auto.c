/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `auto` goes by the crossovers: which method answers, on chains one body shorter than the number
 * and as long as it, by one thread and by several; and what the scan cannot take goes another way.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <totalforce/totalforce.h>

#include "random_robot.h"

enum { LONGEST = 64, THREADS = 3 };

/* A random chain and all that answers for it */
struct subject {
    tfa_description *description;
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_pool *pool;
};

static void open_subject(struct subject *s, uint32_t bodies, const tfa_workspace_options *options)
{
    const random_robot_options chain = {.shape = RANDOM_CHAIN, .joints = bodies};
    s->description = random_robot_create(bodies, &chain);
    assert_non_null(s->description);
    assert_int_equal(tfa_model_create(s->description, NULL, NULL, &s->model), TFA_OK);
    assert_int_equal(tfa_workspace_create(s->model, options, &s->workspace), TFA_OK);
    const tfa_pool_options pool = {.threads = THREADS,
                                   .precision = options->precision,
                                   .residual = options->residual,
                                   .crossovers = options->crossovers};
    assert_int_equal(tfa_pool_create(s->model, &pool, &s->pool), TFA_OK);
}

static void close_subject(struct subject *s)
{
    tfa_pool_free(s->pool);
    tfa_workspace_free(s->workspace);
    tfa_model_free(s->model);
    random_robot_free(s->description);
}

/* The method that answered; `changed` is a request with nothing but what is special about it. */
static tfa_method who(const struct subject *s, const tfa_request *changed, int pool)
{
    static double q[LONGEST], qdd[LONGEST], lambda[36 * 4];
    tfa_answer answer = {0};
    tfa_request r = *changed;
    tfa_reply reply = {.qdd = qdd, .lambda_inv = lambda, .answers = &answer};
    r.op = r.op ? r.op : TFA_OP_FORWARD_DYNAMICS;
    r.count = 1;
    r.q = q;
    assert_int_equal(pool ? tfa_pool_compute(s->pool, &r, &reply)
                          : tfa_compute(s->workspace, &r, &reply),
                     TFA_OK);
    return (tfa_method)answer.method;
}

static const tfa_request forward; /* nothing special */

/* Each number rules its own number of threads and op, and no other. */
static void test_scan_from(void **state)
{
    (void)state;
    tfa_crossovers c = *tfa_crossovers_default();
    const tfa_workspace_options options = {.crossovers = &c};
    c.scan_from_1 = 40;
    c.scan_from_2 = 24;
    c.lambda_scan_from_1 = c.lambda_scan_from_2 = TFA_NEVER;
    for (uint32_t bodies = 23; bodies <= 40; bodies += bodies == 24 ? 15 : 1) {
        struct subject s;
        open_subject(&s, bodies, &options);
        const tfa_request lambda = {.op = TFA_OP_OPERATIONAL_INERTIA,
                                    .tip_count = 1,
                                    .tips = {tfa_model_frame_count(s.model) - 1}};
        assert_int_equal(who(&s, &forward, 0), bodies >= 40 ? TFA_METHOD_SCAN : TFA_METHOD_ABA);
        assert_int_equal(who(&s, &forward, 1), bodies >= 24 ? TFA_METHOD_SCAN : TFA_METHOD_ABA);
        assert_int_equal(who(&s, &lambda, 1), TFA_METHOD_PROPAGATION);
        close_subject(&s);
    }
}

static void test_lambda_scan_from(void **state)
{
    (void)state;
    tfa_crossovers c = *tfa_crossovers_default();
    const tfa_workspace_options options = {.crossovers = &c};
    struct subject s;
    c.scan_from_1 = 2;
    c.lambda_scan_from_1 = LONGEST + 1;
    c.scan_from_2 = c.lambda_scan_from_2 = LONGEST;
    open_subject(&s, LONGEST, &options);
    const uint32_t last = tfa_model_frame_count(s.model) - 1;
    const tfa_request tip = {.op = TFA_OP_OPERATIONAL_INERTIA, .tip_count = 1, .tips = {last}};
    const tfa_request middle = {.op = TFA_OP_OPERATIONAL_INERTIA, .tip_count = 1, .tips = {9}};
    const tfa_request both = {.tip_count = 1, .tips = {last}};
    assert_int_equal(who(&s, &tip, 0), TFA_METHOD_PROPAGATION);
    assert_int_equal(who(&s, &tip, 1), TFA_METHOD_SCAN);
    assert_int_equal(who(&s, &middle, 1), TFA_METHOD_PROPAGATION);
    assert_int_equal(who(&s, &both, 0), TFA_METHOD_ABA);
    assert_int_equal(who(&s, &both, 1), TFA_METHOD_SCAN);
    close_subject(&s);
}

/* Locked joints, other arithmetics, the numbers shipped: as a chain that is too short */
static void test_not_by_scan(void **state)
{
    (void)state;
    static const tfa_workspace_options precisions[] = {
        {.precision = TFA_F32}, {.precision = TFA_F128}, {.residual = TFA_RESIDUAL_F128}};
    tfa_crossovers c = *tfa_crossovers_default();
    c.scan_from_1 = 2;
    tfa_workspace_options options = {.crossovers = &c};
    const uint32_t joint = 3;
    const tfa_request locked = {.locked_count = 1, .locked = &joint};
    struct subject s;
    open_subject(&s, LONGEST, &options);
    assert_int_equal(who(&s, &forward, 0), TFA_METHOD_SCAN);
    assert_int_equal(who(&s, &locked, 0), TFA_METHOD_ABA);
    close_subject(&s);
    for (size_t k = 0; k < sizeof precisions / sizeof *precisions; k++) {
        options = precisions[k];
        options.crossovers = &c;
        open_subject(&s, LONGEST, &options);
        assert_int_equal(who(&s, &forward, 0), TFA_METHOD_ABA);
        close_subject(&s);
    }
}

static void test_tips_from(void **state)
{
    (void)state;
    tfa_crossovers c = *tfa_crossovers_default();
    const tfa_workspace_options options = {.crossovers = &c};
    for (uint32_t from = 2; from <= 4; from++) {
        struct subject s;
        c.pv_from = from;
        open_subject(&s, 8, &options);
        for (uint32_t tips = 1; tips <= 2; tips++) {
            const tfa_request r = {
                .op = TFA_OP_OPERATIONAL_INERTIA, .tip_count = tips, .tips = {8, 7}};
            assert_int_equal(who(&s, &r, 0),
                             tips >= from ? TFA_METHOD_PV_OSIMR : TFA_METHOD_PROPAGATION);
        }
        close_subject(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scan_from),
        cmocka_unit_test(test_lambda_scan_from),
        cmocka_unit_test(test_not_by_scan),
        cmocka_unit_test(test_tips_from),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
