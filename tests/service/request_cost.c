/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Kinds of requests by which the worker learns what a state costs.
 */
#include "worker/cost.h"

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
    for (uint32_t flag = 0; flag < 14; flag++) {
        tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1};
        r.flags = flag < 13 ? 1u << flag : 0;
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
    qsort(kinds, count, sizeof *kinds, by_value);
    for (size_t k = 0; k < count; k++)
        assert_true(kinds[k] != 0 && (k == 0 || kinds[k] != kinds[k - 1]));
}

int main(void)
{
    return test_run(NULL, NULL);
}
