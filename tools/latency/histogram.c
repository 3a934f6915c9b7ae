/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A log-linear histogram of times.
 */
#include "histogram.h"

#include <math.h>

/* Samples beyond a quantile below which it is noise. */
enum { SAMPLES_BEYOND = 10 };

enum { LINEAR = 1 << HISTOGRAM_BITS, HALF = LINEAR / 2 };

static unsigned bucket_of(uint64_t value)
{
    if (value < LINEAR)
        return (unsigned)value;
    unsigned shift = 63u - (unsigned)__builtin_clzll(value) - (HISTOGRAM_BITS - 1);
    /* value >> shift lies in HALF .. LINEAR - 1 */
    return LINEAR + (shift - 1) * HALF + ((unsigned)(value >> shift) - HALF);
}

/* The largest value that falls into the bucket. */
static uint64_t bucket_top(unsigned bucket)
{
    if (bucket < LINEAR)
        return bucket;
    unsigned shift = (bucket - LINEAR) / HALF + 1;
    uint64_t mantissa = (bucket - LINEAR) % HALF + HALF;
    return ((mantissa + 1) << shift) - 1;
}

void histogram_add(histogram *h, uint64_t value)
{
    if (h->count == 0 || value < h->lowest)
        h->lowest = value;
    if (h->count == 0 || value > h->highest) {
        h->highest = value;
        h->highest_index = h->count;
    }
    h->buckets[bucket_of(value)]++;
    h->sum += (double)value;
    h->count++;
}

uint64_t histogram_quantile(const histogram *h, double quantile)
{
    uint64_t wanted = (uint64_t)ceil(quantile * (double)h->count);
    uint64_t seen = 0;
    if (wanted < 1)
        wanted = 1;
    for (unsigned i = 0; i < HISTOGRAM_BUCKETS; i++) {
        seen += h->buckets[i];
        if (seen >= wanted)
            return bucket_top(i) < h->highest ? bucket_top(i) : h->highest;
    }
    return h->highest;
}

double histogram_mean(const histogram *h)
{
    return h->count ? h->sum / (double)h->count : 0.0;
}

int histogram_supports(const histogram *h, double quantile)
{
    return (1.0 - quantile) * (double)h->count >= SAMPLES_BEYOND * (1.0 - 1e-9);
}

/* Spread of the samples, each taken at the top of its bucket. */
static double deviation(const histogram *h)
{
    double mean = histogram_mean(h), sum = 0;
    for (unsigned i = 0; i < HISTOGRAM_BUCKETS; i++) {
        double off = (double)bucket_top(i) - mean;
        if (h->buckets[i])
            sum += off * off * (double)h->buckets[i];
    }
    return h->count ? sqrt(sum / (double)h->count) : 0.0;
}

void histogram_write(const histogram *h, FILE *out, double scale)
{
    uint64_t seen = 0;
    fprintf(out, "%12s %14s %10s %14s\n\n", "Value", "Percentile", "TotalCount",
            "1/(1-Percentile)");
    for (unsigned i = 0; i < HISTOGRAM_BUCKETS && seen < h->count; i++) {
        if (h->buckets[i] == 0)
            continue;
        seen += h->buckets[i];
        uint64_t top = bucket_top(i) < h->highest ? bucket_top(i) : h->highest;
        double share = (double)seen / (double)h->count;
        fprintf(out, "%12.3f %2.12f %10llu", (double)top / scale, share, (unsigned long long)seen);
        if (seen < h->count)
            fprintf(out, " %14.2f", 1.0 / (1.0 - share));
        fputc('\n', out);
    }
    fprintf(out, "#[Mean    = %12.3f, StdDeviation   = %12.3f]\n", histogram_mean(h) / scale,
            deviation(h) / scale);
    fprintf(out, "#[Max     = %12.3f, Total count    = %12llu]\n", (double)h->highest / scale,
            (unsigned long long)h->count);
    fprintf(out, "#[Buckets = %12d, SubBuckets     = %12d]\n", 64 - HISTOGRAM_BITS + 1, HALF);
}
