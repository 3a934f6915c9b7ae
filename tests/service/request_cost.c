/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Kinds of requests by which the worker learns what a state costs, and their bounds.
 */
#include "worker/cost.h"
#include "worker/cost_bound.h"

#include "test.h"

#define KINDS_MAX 100000

static uint64_t kinds[KINDS_MAX];
static size_t count;

static void add(const tfa_request *r)
{
    assert_true(count < KINDS_MAX);
    kinds[count++] = tfa_cost_kind(r);
}

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Everything by which a state takes another time: each flag with each number of refinement steps,
 * estimate, number of tips, method and op. */
TEST(kinds_differ)
{
    static const uint32_t refine[] = {0, 1, 2, 3, TFA_REFINE_DEFAULT};
    for (uint32_t flag = 0; flag < 15; flag++) {
        tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1};
        r.flags = flag < 14 ? 1u << flag : 0;
        for (size_t k = 0; k < sizeof refine / sizeof *refine; k++) {
            r.refine = refine[k];
            for (r.estimate = 0; r.estimate <= TFA_ESTIMATE_ALWAYS; r.estimate++)
                for (r.tip_count = 0; r.tip_count <= TFA_MAX_TIPS; r.tip_count += 4)
                    for (r.op = 1; r.op <= TFA_OP_LAST; r.op += 4)
                        for (r.method = 0; r.method < 16; r.method += 5)
                            add(&r);
        }
    }
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 2};
    add(&r);
    r.count = 64;
    add(&r);
    r.wrench_count = 1;
    add(&r);
    r.payload_count = 1;
    add(&r);
    r.locked_count = 1;
    add(&r);
    r.rows = TFA_ROWS_POINT;
    add(&r);
    r.payload_frames[0] = 3;
    add(&r);
    for (r.tip_count = 2; r.tips[0] < 20; r.tips[0]++)
        for (r.tips[1] = 0; r.tips[1] < 20; r.tips[1]++)
            add(&r);
    r = (tfa_request){.op = TFA_OP_IMPACT, .count = 1};
    for (r.constraints = 1; r.constraints < 64; r.constraints++)
        add(&r);
    qsort(kinds, count, sizeof *kinds, by_value);
    for (size_t k = 0; k < count; k++)
        assert_true(kinds[k] != 0 && (k == 0 || kinds[k] != kinds[k - 1]));
}

static void set(tfa_cost_curve *curve, uint32_t none, uint32_t one, uint32_t eight)
{
    *curve = (tfa_cost_curve){{none, one, 0, eight, UINT32_MAX}};
    curve->at[2] = one + (eight - one) * 2 / 7; /* on the line at three tips */
}

/* Parts add up, between points lies a line, a point counts for three quarters of a pose; half as
 * much is added; a constraint counts as a tip. */
TEST(bounds_add_up)
{
    static tfa_cost_parts parts = {.tips = {0, 1, 3, 8, 32}};
    const double margin = 1.5;
    set(&parts.of[TFA_OP_FORWARD_DYNAMICS][TFA_METHOD_DCA].plain, 1000, 2000, 9000);
    set(&parts.of[TFA_OP_FORWARD_DYNAMICS][TFA_METHOD_DCA].refined, 4000, 5000, 12000);
    set(&parts.of[TFA_OP_FORWARD_DYNAMICS][TFA_METHOD_DCA].estimated, 500, 2500, 9500);
    set(&parts.added[TFA_OP_FORWARD_DYNAMICS][0], 0, 100, 800);                     /* spectrum */
    set(&parts.added[TFA_OP_FORWARD_DYNAMICS][TFA_COST_ADDITIONS - 1], 70, 70, 70); /* locked */
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .method = TFA_METHOD_DCA,
                     .count = 1,
                     .refine = TFA_REFINE_DEFAULT};
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * 1000);
    r.tip_count = 5;
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * 6000);
    r.flags = TFA_WANT_SPECTRUM | TFA_WANT_COM;
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * (6000 + 500));
    r.rows = TFA_ROWS_POINT;
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * (5000 + 400));
    r.rows = TFA_ROWS_POSE;
    r.flags = 0;
    r.refine = 1;
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * 7000);
    r.estimate = TFA_ESTIMATE_ALWAYS;
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * 7500);
    r.locked_count = 2;
    assert_int_equal(tfa_cost_bound(&parts, &r), margin * 7570);
    r.tip_count = 32;
    assert_int_equal(tfa_cost_bound(&parts, &r), UINT32_MAX);
    assert_int_equal(tfa_cost_bound(NULL, &r), UINT32_MAX);
    set(&parts.of[TFA_OP_IMPACT][TFA_METHOD_AUTO].plain, 0, 2000, 9000);
    const tfa_request impact = {
        .op = TFA_OP_IMPACT, .refine = TFA_REFINE_DEFAULT, .constraints = 19};
    assert_int_equal(tfa_cost_bound(&parts, &impact), margin * 4000); /* three of them */
    r.op = TFA_OP_LAST + 1; /* its refusal is short */
    assert_int_equal(tfa_cost_bound(&parts, &r), 1);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.method = TFA_COST_METHODS;
    assert_int_equal(tfa_cost_bound(&parts, &r), 1);
}

int main(void)
{
    return test_run(NULL, NULL);
}
