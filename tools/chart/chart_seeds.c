/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One row out of the rows of several seeds, and rows whose answers are the same.
 */
#include "chart.h"

#include <math.h>
#include <stddef.h>

/* Median over the seeds of one number of a row, `offset` bytes into it */
static double median_of(const chart_row *first, size_t stride, uint32_t seeds, size_t offset)
{
    double values[CHART_SEEDS];
    for (uint32_t s = 0; s < seeds; s++)
        values[s] = *(const double *)(const void *)((const char *)&first[s * stride] + offset);
    return chart_median(values, seeds);
}

static const size_t medians[] = {offsetof(chart_row, error),    offsetof(chart_row, floor),
                                 offsetof(chart_row, estimate), offsetof(chart_row, time),
                                 offsetof(chart_row, aba_time), offsetof(chart_row, ratio)};

static chart_row combine(const chart_row *first, size_t stride, uint32_t seeds)
{
    chart_row row = *first;
    for (uint32_t s = 1; s < seeds; s++) {
        const chart_row *other = &first[s * stride];
        if (!chart_row_good(other))
            return *other;
        row.worst = fmax(row.worst, other->worst);
        row.error_low = fmin(row.error_low, other->error_low);
        row.error_high = fmax(row.error_high, other->error_high);
        row.time_low = fmin(row.time_low, other->time_low);
        row.time_high = fmax(row.time_high, other->time_high);
        row.samples += other->samples;
        row.bits = row.bits * CHART_HASH_PRIME ^ other->bits;
    }
    for (size_t i = 0; i < sizeof medians / sizeof *medians; i++)
        *(double *)(void *)((char *)&row + medians[i]) =
            median_of(first, stride, seeds, medians[i]);
    return row;
}

void chart_combine_seeds(chart_row *rows, size_t count, uint32_t seeds)
{
    for (size_t i = 0; i < count; i++)
        if (chart_row_good(&rows[i]))
            rows[i] = combine(&rows[i], count, seeds);
}

static int are_same(const chart_row *a, const chart_row *b)
{
    return a->rhs == b->rhs && a->choice.refine == b->choice.refine &&
           a->choice.precision == b->choice.precision && a->bits == b->bits;
}

/* Answers that are exact are the same, whatever the code; and Lambda^-1 by propagation and pv-osimr
 * is the same by different code. */
static int is_comparable(const chart_row *row)
{
    const uint32_t precision = row->choice.precision;
    return chart_row_good(row) && row->choice.op == CHART_FORWARD && row->choice.threads == 1 &&
           row->choice.strategy == CHART_SINGLE &&
           (precision == CHART_F64 || precision == CHART_F32);
}

void chart_find_same(chart_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < i && is_comparable(&rows[i]); k++)
            if (chart_row_drawn(&rows[k]) && are_same(&rows[i], &rows[k])) {
                rows[i].same_as = rows[k].choice.method;
                break;
            }
}
