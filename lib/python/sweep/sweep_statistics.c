/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Distributions of numbers over states.
 */
#include "sweep_statistics.h"

#include <math.h>
#include <string.h>

/* A group of larger values could overflow. */
#define GROUP_VALUE_MAX 0x1p1000
_Static_assert(sizeof(statistics) % sizeof(uint64_t) == 0, "statistics are words");

static unsigned bin_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const int exponent = (int)(bits >> 52) - 1023 - STATISTICS_LOWEST_EXPONENT;
    return exponent < 0                      ? 0
           : exponent >= STATISTICS_BINS - 2 ? STATISTICS_BINS - 1
                                             : (unsigned)exponent + 1;
}

void series_add(series *s, double *group, double value, uint64_t state)
{
    if (!isfinite(value))
        return;
    if (s->count == 0 || value < s->min) {
        s->min = value;
        s->min_at = state;
    }
    if (s->count == 0 || value > s->max) {
        s->max = value;
        s->max_at = state;
    }
    s->bins[bin_of(value)]++;
    s->count++;
    if (value < GROUP_VALUE_MAX)
        *group += value;
    else
        exact_sum_add(&s->sum, value);
}

void statistics_end_groups(statistics *s, double groups[SERIES])
{
    for (int k = 0; k < SERIES; k++) {
        if (groups[k] > 0)
            exact_sum_add(&s->series[k].sum, groups[k]);
        groups[k] = 0;
    }
}
