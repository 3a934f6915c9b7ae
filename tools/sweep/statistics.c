/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of a sweep.
 */
#include "statistics.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WORDS = sizeof(statistics) / sizeof(uint64_t) };
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

double series_bin_bound(unsigned bin)
{
    return bin == 0                 ? 0.0
           : bin >= STATISTICS_BINS ? INFINITY
                                    : ldexp(1.0, (int)bin - 1 + STATISTICS_LOWEST_EXPONENT);
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

void series_end_group(series *s, double *group)
{
    if (*group > 0)
        exact_sum_add(&s->sum, *group);
    *group = 0;
}

double series_mean(const series *s)
{
    return s->count ? exact_sum_value(&s->sum) / (double)s->count : 0.0;
}

double series_quantile(const series *s, double quantile)
{
    uint64_t wanted = (uint64_t)ceil(quantile * (double)s->count), seen = 0;
    wanted = wanted ? wanted : 1;
    for (unsigned bin = 0; bin < STATISTICS_BINS; bin++) {
        seen += s->bins[bin];
        if (seen >= wanted)
            return fmin(series_bin_bound(bin + 1), s->max);
    }
    return s->max;
}

/* Extremes of equal value belong to the first state, whichever side has it. */
static void merge_extremes(series *into, const series *from)
{
    const int none = into->count == 0;
    if (none || from->min < into->min || (from->min == into->min && from->min_at < into->min_at)) {
        into->min = from->min;
        into->min_at = from->min_at;
    }
    if (none || from->max > into->max || (from->max == into->max && from->max_at < into->max_at)) {
        into->max = from->max;
        into->max_at = from->max_at;
    }
}

static void merge_series(series *into, const series *from)
{
    if (from->count == 0)
        return;
    merge_extremes(into, from);
    into->count += from->count;
    exact_sum_merge(&into->sum, &from->sum);
    for (unsigned bin = 0; bin < STATISTICS_BINS; bin++)
        into->bins[bin] += from->bins[bin];
}

void statistics_merge(statistics *into, const statistics *from)
{
#define MERGE_COUNT(member, name) into->member += from->member;
    STATISTICS_COUNTS(MERGE_COUNT)
#undef MERGE_COUNT
    for (int k = 0; k < STATISTICS_STATUSES; k++)
        into->status[k] += from->status[k];
    for (int k = 0; k < STATISTICS_METHODS; k++)
        into->method[k] += from->method[k];
#define MERGE_SERIES(member, name, what) merge_series(&into->member, &from->member);
    STATISTICS_SERIES(MERGE_SERIES)
#undef MERGE_SERIES
}

void statistics_write(const statistics *s, FILE *out)
{
    uint64_t words[WORDS];
    memcpy(words, s, sizeof words);
    for (unsigned k = 0; k < WORDS; k++)
        if (words[k])
            fprintf(out, " %x:%" PRIx64, k, words[k]);
}

int statistics_read(statistics *s, const char *text)
{
    uint64_t words[WORDS] = {0};
    while (*text == ' ') {
        char *end;
        const unsigned long index = strtoul(text + 1, &end, 16);
        if (*end != ':' || index >= WORDS)
            return -1;
        words[index] = strtoull(end + 1, &end, 16);
        text = end;
    }
    memcpy(s, words, sizeof words);
    return *text == '\0' ? 0 : -1;
}
