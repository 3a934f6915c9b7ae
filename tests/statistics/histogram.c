/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The histogram's quantiles stay within its resolution of the exact ones, from 0 to 2^64 - 1.
 */
#include <totalforce/histogram.h>

#include "test.h"

/* One block: the histogram, its buckets. */
static tfa_histogram *fresh_of(uint32_t bits, uint32_t range)
{
    tfa_histogram *h = malloc(sizeof *h + TFA_HISTOGRAM_BUCKETS(bits, range) * sizeof *h->buckets);
    assert_non_null(h);
    assert_int_equal(tfa_histogram_init(h, bits, range, (uint64_t *)(h + 1)), TFA_OK);
    return h;
}

static tfa_histogram *fresh(void)
{
    return fresh_of(8, 64);
}

TEST(test_empty)
{
    tfa_histogram *h = fresh();
    assert_int_equal(tfa_histogram_quantile(h, 0.5), 0);
    assert_true(tfa_histogram_mean(h) == 0.0);
    assert_false(tfa_histogram_supports(h, 0.5));
    free(h);
}

TEST(test_small_values_are_exact)
{
    tfa_histogram *h = fresh();
    for (uint64_t v = 1; v <= 200; v++)
        tfa_histogram_add(h, v);
    assert_int_equal(tfa_histogram_quantile(h, 0.5), 100);
    assert_int_equal(tfa_histogram_quantile(h, 0.99), 198);
    assert_int_equal(tfa_histogram_quantile(h, 1.0), 200);
    assert_int_equal(tfa_histogram_quantile(h, 0.0), 1);
    assert_true(tfa_histogram_mean(h) == 100.5);
    free(h);
}

/* One value alone: every quantile is that value, because the highest bounds the bucket; a second,
 * higher one shows the bucket's own error. */
TEST(test_resolution)
{
    for (unsigned bit = 0; bit < 64; bit++)
        for (int offset = -1; offset <= 1; offset++) {
            uint64_t value = (UINT64_C(1) << bit) + (uint64_t)(int64_t)offset;
            tfa_histogram *h = fresh();
            tfa_histogram_add(h, value);
            assert_true(tfa_histogram_quantile(h, 0.5) == value);
            tfa_histogram_add(h, UINT64_MAX);
            uint64_t found = tfa_histogram_quantile(h, 0.5);
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
    tfa_histogram *h = fresh();
    uint64_t seed = 1;
    for (int i = 0; i < N; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        values[i] = (uint64_t)exp(30.0 * (double)(seed >> 11) * 0x1p-53);
        tfa_histogram_add(h, values[i]);
    }
    qsort(values, N, sizeof values[0], compare);
    assert_true(h->lowest == values[0] && h->highest == values[N - 1]);
    for (size_t k = 0; k < sizeof quantiles / sizeof quantiles[0]; k++) {
        size_t rank = (size_t)ceil(quantiles[k] * N);
        double exact = (double)values[rank - 1];
        double found = (double)tfa_histogram_quantile(h, quantiles[k]);
        assert_true(found >= exact && found <= exact * (1.0 + 1.0 / 128.0));
    }
    free(h);
}

TEST(test_highest_keeps_its_first_place)
{
    tfa_histogram *h = fresh();
    static const uint64_t values[] = {5, 9, 2, 9, 1};
    for (size_t i = 0; i < 5; i++)
        tfa_histogram_add(h, values[i]);
    assert_int_equal(h->highest_index, 1);
    free(h);
}

TEST(test_supported_quantiles)
{
    tfa_histogram *h = fresh();
    for (int i = 0; i < 1000; i++)
        tfa_histogram_add(h, 7);
    assert_true(tfa_histogram_supports(h, 0.99));
    assert_false(tfa_histogram_supports(h, 0.999));
    free(h);
}

/* Every resolution: buckets are in order, each value lies in one whose top is near. */
TEST(test_bits_and_range)
{
    for (uint32_t bits = 1; bits <= 10; bits++)
        for (uint32_t range = bits; range <= 64; range += 13) {
            tfa_histogram *h = fresh_of(bits, range);
            for (uint32_t i = 1; i < h->bucket_count; i++)
                assert_true(tfa_histogram_top(h, i) > tfa_histogram_top(h, i - 1));
            for (uint32_t bit = 0; bit < 64; bit++) {
                const uint64_t value = (UINT64_C(1) << bit) + (UINT64_C(1) << bit) / 3;
                tfa_histogram_clear(h);
                tfa_histogram_add(h, value);
                tfa_histogram_add(h, UINT64_MAX);
                const uint64_t found = tfa_histogram_quantile(h, 0.5);
                assert_true(found >= value);
                if (bit + 1 < range)
                    assert_true((double)(found - value) <= ldexp((double)value, 1 - (int)bits));
            }
            free(h);
        }
}

TEST(test_bad_arguments)
{
    tfa_histogram h;
    uint64_t bucket;
    assert_int_equal(tfa_histogram_init(NULL, 5, 40, &bucket), TFA_E_ARGUMENT);
    assert_int_equal(tfa_histogram_init(&h, 5, 40, NULL), TFA_E_ARGUMENT);
    assert_int_equal(tfa_histogram_init(&h, 0, 40, &bucket), TFA_E_ARGUMENT);
    assert_int_equal(tfa_histogram_init(&h, 17, 40, &bucket), TFA_E_ARGUMENT);
    assert_int_equal(tfa_histogram_init(&h, 5, 4, &bucket), TFA_E_ARGUMENT);
    assert_int_equal(tfa_histogram_init(&h, 5, 65, &bucket), TFA_E_ARGUMENT);
}

TEST(test_since_is_what_was_added)
{
    tfa_histogram *now = fresh_of(5, 40), *before = fresh_of(5, 40), *added = fresh_of(5, 40);
    uint64_t seed = 3;
    for (int i = 0; i < 3000; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        const uint64_t value = 100 + (seed >> 40) % 100000;
        tfa_histogram_add(now, value);
        tfa_histogram_add(i < 1000 ? before : added, value);
    }
    assert_int_equal(tfa_histogram_since(before, now), TFA_OK);
    assert_int_equal(before->count, 2000);
    assert_memory_equal(before->buckets, added->buckets, now->bucket_count * sizeof(uint64_t));
    assert_true(fabs(before->sum / added->sum - 1) < 1e-12);
    assert_true(before->lowest <= added->lowest && before->highest >= added->highest);
    assert_true(before->highest <= now->highest && before->lowest >= now->lowest);
    assert_int_equal(tfa_histogram_since(now, now), TFA_OK);
    assert_true(now->count == 0 && now->highest == 0 && tfa_histogram_quantile(now, 0.5) == 0);
    free(now), free(before), free(added);
}

TEST(test_merge_is_adding_all)
{
    tfa_histogram *a = fresh_of(5, 40), *b = fresh_of(5, 40), *both = fresh_of(5, 40);
    tfa_histogram *other = fresh_of(6, 40);
    uint64_t seed = 7;
    for (int i = 0; i < 2000; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        tfa_histogram_add(i < 700 ? a : b, seed >> (seed & 31));
        tfa_histogram_add(both, seed >> (seed & 31));
    }
    assert_int_equal(tfa_histogram_merge(a, b), TFA_OK);
    assert_true(a->count == both->count && a->lowest == both->lowest);
    assert_true(a->highest == both->highest && a->highest_index == both->highest_index);
    assert_true(fabs(a->sum / both->sum - 1) < 1e-12);
    assert_memory_equal(a->buckets, both->buckets, a->bucket_count * sizeof *a->buckets);
    assert_int_equal(tfa_histogram_merge(other, a), TFA_E_SIZE);
    assert_int_equal(other->count, 0);
    assert_int_equal(tfa_histogram_merge(a, other) != TFA_OK, 1);
    free(a), free(b), free(both), free(other);
}
