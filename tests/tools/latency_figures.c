/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Figures of a tally against sorted lists of what the script says.
 */
#include "latency_figures.h"

#include "test.h"

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Nearest rank of a list. */
static uint64_t rank(const uint64_t *sorted, uint64_t count, double quantile)
{
    uint64_t k = (uint64_t)ceil(quantile * (double)count);
    return sorted[(k ? k : 1) - 1];
}

void assert_times(const tfa_histogram *h, const uint64_t *values, uint64_t count)
{
    static const double quantiles[] = {0.5, 0.9, 0.99, 0.999, 0.9999};
    uint64_t *sorted = malloc((count + 1) * sizeof *sorted);
    double sum = 0;
    assert_non_null(sorted);
    memcpy(sorted, values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, by_value);
    for (uint64_t i = 0; i < count; i++)
        sum += (double)values[i];
    assert_int_equal(h->count, count);
    assert_int_equal(h->lowest, sorted[0]);
    assert_int_equal(h->highest, sorted[count - 1]);
    assert_true(fabs(tfa_histogram_mean(h) - sum / (double)count) <= 1e-9 * sum / (double)count);
    for (size_t i = 0; i < sizeof quantiles / sizeof quantiles[0]; i++) {
        const uint64_t true_value = rank(sorted, count, quantiles[i]);
        const uint64_t found = tfa_histogram_quantile(h, quantiles[i]);
        if (found < true_value || (double)found > (double)true_value * (1 + 1.0 / 128))
            fail_msg("p%g: %lu, the script has %lu", 100 * quantiles[i], (unsigned long)found,
                     (unsigned long)true_value);
    }
    free(sorted);
}

tally *script_measure(script *s, const load_shape *shape)
{
    tally *t = tally_create(shape->count);
    loop *l = loop_create(&s->base, loop_window(shape, s->slots));
    assert_non_null(t);
    assert_non_null(l);
    assert_int_equal(loop_run(l, shape, s->now, t), TFA_OK);
    assert_int_equal(t->done, t->sent);
    loop_free(l);
    return t;
}

/* Rows of the breakdown: every power of two in 32. */
static uint64_t row_of(uint64_t value)
{
    uint64_t octave = 0;
    while (value >> octave >= 64)
        octave++;
    return (octave << 32) + (value >> octave);
}

/* Mean parts of the samples in the row of a percentile. */
static void check_breakdown(const tally *t, double quantile)
{
    const uint64_t value = tfa_histogram_quantile(&t->parts[PART_ROUND_TRIP].h, quantile);
    double means[PART_COUNT], sums[PART_COUNT] = {0};
    uint64_t count = 0;
    for (uint64_t i = 0; i < t->sample_count; i++) {
        const uint64_t *parts = t->samples[i].parts;
        uint64_t sum = 0;
        for (int k = 1; k < PART_COUNT; k++)
            sum += parts[k];
        assert_int_equal(sum, parts[PART_ROUND_TRIP]);
        if (row_of(parts[PART_ROUND_TRIP]) != row_of(value))
            continue;
        count++;
        for (int k = 0; k < PART_COUNT; k++)
            sums[k] += (double)parts[k];
    }
    assert_int_equal(breakdown_at(t->breakdown, value, means), count);
    assert_true(count > 0);
    for (int k = 0; k < PART_COUNT; k++)
        assert_true(fabs(means[k] - sums[k] / (double)count) <= 1e-9 * (means[k] + 1));
    assert_true(fabs(means[PART_ROUND_TRIP] - (double)value) <= (double)value / 32);
}

void assert_parts(const tally *t, const script_line *lines, uint64_t count)
{
    static const struct {
        int part;
        uint64_t tenths; /* of the delay, rounded down */
        int rest;        /* the rest of the delay instead */
    } shares[] = {{PART_ROUND_TRIP, 0, 1},
                  {PART_REQUEST, 1, 0},
                  {PART_QUEUE, 2, 0},
                  {PART_COMPUTE, 3, 0},
                  {PART_REPLY, 6, 1}};
    static const double quantiles[] = {0.5, 0.9, 0.99, 0.999};
    uint64_t *values = calloc(count, sizeof *values);
    assert_non_null(values);
    for (size_t k = 0; k < sizeof shares / sizeof *shares; k++) {
        for (uint64_t i = 0; i < count; i++) {
            const uint64_t share = shares[k].tenths * (lines[i].delay / 10);
            values[i] = shares[k].rest ? lines[i].delay - share : share;
        }
        assert_times(&t->parts[shares[k].part].h, values, count);
    }
    assert_int_equal(t->parts[PART_CLIENT].h.highest, 0);
    for (size_t k = 0; k < sizeof quantiles / sizeof *quantiles; k++)
        check_breakdown(t, quantiles[k]);
    free(values);
}
