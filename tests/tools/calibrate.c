/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where two ways cross, from their ratios; and that both ways of every contest can be measured.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "calibrate.h"

enum { COUNT = 4 };

static const uint32_t sizes[COUNT] = {16, 32, 64, 128};

static const struct row {
    double ratios[COUNT];
    uint32_t from;
} rows[] = {
    {{2, 2, 2, 2}, TFA_NEVER},
    {{2, 2, 2, 1}, TFA_NEVER},
    {{0.5, 0.5, 0.5, 1.1}, TFA_NEVER}, /* it pays, but not for ever */
    {{0.5, 0.5, 0.5, 0.5}, 16},
    {{0.9, 1.2, 0.9, 0.5}, 51}, /* a lucky first size does not count: 32 x 2^(2/3) = 50.8 */
    {{2, 1.5, 0.5, 0.4}, 46},   /* half way between 32 and 64: 32 sqrt 2 = 45.3 */
    {{2, 1, 0.999, 0.4}, 32},   /* at 32 itself */
    {{2, 2, 2, 0.999}, 128},
};

static void test_crossing(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const uint32_t from = calibrate_crossing(sizes, rows[k].ratios, COUNT);
        if (from != rows[k].from)
            fail_msg("row %zu: %u, not %u", k, from, rows[k].from);
    }
}

static void test_contests(void **state)
{
    (void)state;
    static const calibrate_contest contests[] = {
        {.axis = CALIBRATE_STATES, .op = TFA_OP_FORWARD_DYNAMICS, .threads = 1},
        {.axis = CALIBRATE_WORK, .op = TFA_OP_FORWARD_DYNAMICS, .threads = 2},
        {.axis = CALIBRATE_CHAIN,
         .op = TFA_OP_FORWARD_DYNAMICS,
         .next = TFA_METHOD_SCAN,
         .threads = 2},
        {.axis = CALIBRATE_CHAIN,
         .op = TFA_OP_OPERATIONAL_INERTIA,
         .next = TFA_METHOD_SCAN,
         .threads = 1},
        {.axis = CALIBRATE_TIPS, .op = TFA_OP_OPERATIONAL_INERTIA, .threads = 1},
    };
    for (size_t k = 0; k < sizeof contests / sizeof *contests; k++)
        for (uint32_t size = 2; size <= 8; size += 3) {
            double ratio = 0;
            assert_int_equal(calibrate_measure(&contests[k], size, 1, &ratio), TFA_OK);
            assert_true(ratio > 0 && ratio < 1e6);
        }
}

static void test_refusal(void **state)
{
    (void)state;
    const calibrate_contest inverse = {.axis = CALIBRATE_CHAIN,
                                       .op = TFA_OP_FORWARD_DYNAMICS,
                                       .next = TFA_METHOD_RNEA,
                                       .threads = 1};
    double ratio = 0;
    assert_int_equal(calibrate_measure(&inverse, 3, 1, &ratio), TFA_E_METHOD);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_crossing),
        cmocka_unit_test(test_contests),
        cmocka_unit_test(test_refusal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
