/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sums, statistics and drawn states of a sweep: the same bits for any split and order.
 */
#include "mechanism/mechanism.h"
#include "sweep/statistics.h"
#include "sweep/sweep_states.h"

#include "models.h"
#include "test.h"

#include <math.h>
#include <totalforce/model.h>

enum { VALUES = 4096 };

/* Over the whole range of exponents, subnormal numbers and zero included */
static double value(uint64_t *random, int spread)
{
    const int exponent = (int)(mechanism_random_bits(random) % (unsigned)(2 * spread)) - spread;
    return ldexp(mechanism_random_uniform(random, 0.0, 1.0), exponent);
}

TEST(test_sum_is_exact)
{
    exact_sum sum = {0};
    exact_sum_add(&sum, 0x1p1000);
    for (int k = 0; k < 3; k++)
        exact_sum_add(&sum, 1.0);
    exact_sum_add(&sum, 0x1p-1074);
    assert_true(exact_sum_value(&sum) == 0x1p1000);
    sum = (exact_sum){0};
    exact_sum_add(&sum, 0x1p53);
    exact_sum_add(&sum, 1.0);
    assert_true(exact_sum_value(&sum) == 0x1p53); /* a tie goes to even */
    exact_sum_add(&sum, 0x1p-1074);
    assert_true(exact_sum_value(&sum) == 0x1p53 + 2.0); /* no tie any more */
    sum = (exact_sum){0};
    for (int k = 0; k < 10; k++)
        exact_sum_add(&sum, 0x1p-1074);
    assert_true(exact_sum_value(&sum) == 10 * 0x1p-1074);
    sum = (exact_sum){0};
    assert_true(exact_sum_value(&sum) == 0.0);
    for (int k = 0; k < 1000; k++)
        exact_sum_add(&sum, 0.1);
    assert_true(exact_sum_value(&sum) == 100.0); /* 1000 x (0.1 + 5.5e-18), rounded once */
}

TEST(test_sum_has_no_order)
{
    static double values[VALUES];
    uint64_t random = 1;
    exact_sum up = {0}, down = {0}, halves[2] = {0};
    for (int k = 0; k < VALUES; k++)
        values[k] = value(&random, 1074);
    for (int k = 0; k < VALUES; k++) {
        exact_sum_add(&up, values[k]);
        exact_sum_add(&down, values[VALUES - 1 - k]);
        exact_sum_add(&halves[k % 3 == 0], values[k]);
    }
    exact_sum_merge(&halves[0], &halves[1]);
    assert_memory_equal(&up, &down, sizeof up);
    assert_memory_equal(&up, &halves[0], sizeof up);
}

/* Statistics of groups first..end - 1 */
static statistics *of_groups(const double *values, unsigned first, unsigned end)
{
    statistics *s = calloc(1, sizeof *s);
    double group = 0;
    assert_non_null(s);
    for (unsigned k = first * STATISTICS_GROUP; k < end * STATISTICS_GROUP; k++) {
        series_add(&s->answer, &group, values[k], k);
        if (k % STATISTICS_GROUP == STATISTICS_GROUP - 1)
            series_end_group(&s->answer, &group);
        s->states++;
        s->status[k % 3]++;
    }
    return s;
}

TEST(test_statistics_have_no_order)
{
    enum { GROUPS = VALUES / STATISTICS_GROUP };
    static double values[VALUES];
    uint64_t random = 2;
    for (int k = 0; k < VALUES; k++)
        values[k] = k % 100 == 7 ? 3.5 : k % 97 == 5 ? NAN : 3.5 + value(&random, 70);
    statistics *whole = of_groups(values, 0, GROUPS), *merged = calloc(1, sizeof *merged);
    assert_non_null(merged);
    for (unsigned k = 0; k < GROUPS; k++) {
        const unsigned group = (5 * k + 3) % GROUPS;
        statistics *part = of_groups(values, group, group + 1);
        statistics_merge(merged, part);
        free(part);
    }
    assert_memory_equal(whole, merged, sizeof *whole);
    assert_true(whole->answer.min == 3.5 && whole->answer.min_at == 7);
    free(whole);
    free(merged);
}

TEST(test_written_statistics_are_read_back)
{
    static double values[STATISTICS_GROUP];
    uint64_t random = 3;
    char *text = NULL;
    size_t size = 0;
    for (int k = 0; k < STATISTICS_GROUP; k++)
        values[k] = value(&random, 200);
    statistics *s = of_groups(values, 0, 1), *found = calloc(1, sizeof *found);
    FILE *out = open_memstream(&text, &size);
    assert_true(found && out);
    statistics_write(s, out);
    fclose(out);
    assert_int_equal(statistics_read(found, text), 0);
    assert_memory_equal(s, found, sizeof *s);
    assert_int_equal(statistics_read(found, " 0:1 ffff:1"), -1);
    assert_int_equal(statistics_read(found, " 0:1 2"), -1);
    assert_int_equal(statistics_read(found, " 0:1x"), -1);
    free(text);
    free(s);
    free(found);
}

TEST(test_bins)
{
    series *s = calloc(1, sizeof *s);
    double group = 0;
    assert_non_null(s);
    const double values[] = {0.0, 0x1p-70, 1.0, 1.999, 2.0, 0x1p64, 0x1p1001, INFINITY};
    for (uint64_t k = 0; k < 8; k++)
        series_add(s, &group, values[k], k);
    series_end_group(s, &group);
    assert_int_equal(s->count, 7);
    assert_int_equal(s->bins[0], 2);
    assert_int_equal(s->bins[65], 2);
    assert_int_equal(s->bins[66], 1);
    assert_int_equal(s->bins[STATISTICS_BINS - 1], 2);
    assert_true(series_bin_bound(65) == 1.0 && series_bin_bound(66) == 2.0);
    assert_true(series_quantile(s, 0.5) == 2.0 && series_quantile(s, 1.0) == 0x1p1001);
    free(s);
}

/* A state is a function of seed and number, whatever is drawn with it. */
TEST(test_states_are_drawn_alone)
{
    enum { STATES = 37 };
    tfa_report report = {0};
    tfa_model *model = NULL;
    state_record r;
    const state_ranges ranges = {2, 30, 4};
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    assert_int_equal(
        tfa_model_load(TFA_SOURCE_DIR "/config/robots/arm7.urdf", &floating, &report, &model),
        TFA_OK);
    tfa_report_free(&report);
    assert_int_equal(state_record_make(&r, model, TFA_OP_FORWARD_DYNAMICS, NULL, &ranges), TFA_OK);
    assert_int_equal(r.width, 7 + 6 + 6 + 3 * 7);
    double *all = calloc(STATES, r.width * sizeof *all), *one = calloc(1, r.width * sizeof *one);
    assert_true(all && one);
    state_record_draw(&r, 9, 1000, STATES, all);
    for (uint32_t k = 0; k < STATES; k++) {
        const double *at = all + (size_t)k * r.width, *x = at + 3;
        state_record_draw(&r, 9, 1000 + k, 1, one);
        assert_memory_equal(one, at, r.width * sizeof *one);
        assert_true(fabs(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 1) < 1e-15);
        for (uint32_t c = 0; c < r.width; c++)
            assert_true(fabs(at[c]) <= (c >= r.at[STATE_FORCE] || (c >= 13 && c < 19) ? 30 : M_PI));
        state_record_draw(&r, 10, 999 + k, 1, one);
        assert_memory_not_equal(one, at, r.width * sizeof *one);
    }
    free(all);
    free(one);
    state_record_free(&r);
    tfa_model_free(model);
}
