/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The histogram's quantiles stay within its resolution of the exact ones, from 0 to 2^64 - 1.
 */
#include "latency/histogram.h"

#include "test.h"

static histogram *fresh(void)
{
    histogram *h = calloc(1, sizeof *h);
    assert_non_null(h);
    return h;
}

TEST(test_empty)
{
    histogram *h = fresh();
    assert_int_equal(histogram_quantile(h, 0.5), 0);
    assert_true(histogram_mean(h) == 0.0);
    assert_false(histogram_supports(h, 0.5));
    free(h);
}

TEST(test_small_values_are_exact)
{
    histogram *h = fresh();
    for (uint64_t v = 1; v <= 200; v++)
        histogram_add(h, v);
    assert_int_equal(histogram_quantile(h, 0.5), 100);
    assert_int_equal(histogram_quantile(h, 0.99), 198);
    assert_int_equal(histogram_quantile(h, 1.0), 200);
    assert_int_equal(histogram_quantile(h, 0.0), 1);
    assert_true(histogram_mean(h) == 100.5);
    free(h);
}

/* One value alone: every quantile is that value, because the highest bounds the bucket; a second,
 * higher one shows the bucket's own error. */
TEST(test_resolution)
{
    for (unsigned bit = 0; bit < 64; bit++)
        for (int offset = -1; offset <= 1; offset++) {
            uint64_t value = (UINT64_C(1) << bit) + (uint64_t)(int64_t)offset;
            histogram *h = fresh();
            histogram_add(h, value);
            assert_true(histogram_quantile(h, 0.5) == value);
            histogram_add(h, UINT64_MAX);
            uint64_t found = histogram_quantile(h, 0.5);
            assert_true(found >= value);
            assert_true((double)(found - value) <= (double)value / 128.0);
            free(h);
        }
}

static int compare(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

TEST(test_against_sorting)
{
    enum { N = 20000 };
    static uint64_t values[N];
    static const double quantiles[] = {0.01, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0};
    histogram *h = fresh();
    uint64_t seed = 1;
    for (int i = 0; i < N; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        values[i] = (uint64_t)exp(30.0 * (double)(seed >> 11) * 0x1p-53);
        histogram_add(h, values[i]);
    }
    qsort(values, N, sizeof values[0], compare);
    assert_true(h->lowest == values[0] && h->highest == values[N - 1]);
    for (size_t k = 0; k < sizeof quantiles / sizeof quantiles[0]; k++) {
        size_t rank = (size_t)ceil(quantiles[k] * N);
        double exact = (double)values[rank - 1];
        double found = (double)histogram_quantile(h, quantiles[k]);
        assert_true(found >= exact && found <= exact * (1.0 + 1.0 / 128.0));
    }
    free(h);
}

TEST(test_highest_keeps_its_first_place)
{
    histogram *h = fresh();
    static const uint64_t values[] = {5, 9, 2, 9, 1};
    for (size_t i = 0; i < 5; i++)
        histogram_add(h, values[i]);
    assert_int_equal(h->highest_index, 1);
    free(h);
}

TEST(test_supported_quantiles)
{
    histogram *h = fresh();
    for (int i = 0; i < 1000; i++)
        histogram_add(h, 7);
    assert_true(histogram_supports(h, 0.99));
    assert_false(histogram_supports(h, 0.999));
    free(h);
}

TEST(test_written_form)
{
    histogram *h = fresh();
    char *text = NULL;
    size_t size = 0;
    for (uint64_t v = 1; v <= 4; v++)
        histogram_add(h, 1000 * v);
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    histogram_write(h, out, 1000.0);
    fclose(out);
    assert_non_null(strstr(text, "Value     Percentile TotalCount 1/(1-Percentile)"));
    assert_non_null(strstr(text, "0.250000000000          1           1.33"));
    assert_non_null(strstr(text, "4.000 1.000000000000          4\n"));
    assert_non_null(strstr(text, "#[Max     =        4.000, Total count    =            4]"));
    free(text);
    free(h);
}
