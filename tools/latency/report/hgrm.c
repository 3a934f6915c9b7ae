/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Percentile distribution as text.
 */
#include "hgrm.h"

#include <math.h>

/* HdrHistogram's buckets: the linear part, and one for each power of two above. */
static int buckets_of(const tfa_histogram *h)
{
    const uint32_t linear = UINT32_C(1) << h->bits;
    return 1 + (int)((h->bucket_count - linear) / (linear / 2));
}

/* Spread of the samples, each taken at the top of its bucket. */
static double deviation(const tfa_histogram *h)
{
    double mean = tfa_histogram_mean(h), sum = 0;
    for (uint32_t i = 0; i < h->bucket_count; i++) {
        uint64_t top = tfa_histogram_top(h, i);
        double off = (double)(top < h->highest ? top : h->highest) - mean;
        if (h->buckets[i])
            sum += off * off * (double)h->buckets[i];
    }
    return h->count ? sqrt(sum / (double)h->count) : 0.0;
}

void hgrm_write(const tfa_histogram *h, FILE *out, double scale)
{
    uint64_t seen = 0;
    fprintf(out, "%12s %14s %10s %14s\n\n", "Value", "Percentile", "TotalCount",
            "1/(1-Percentile)");
    for (uint32_t i = 0; i < h->bucket_count && seen < h->count; i++) {
        if (h->buckets[i] == 0)
            continue;
        seen += h->buckets[i];
        uint64_t top = tfa_histogram_top(h, i) < h->highest ? tfa_histogram_top(h, i) : h->highest;
        double share = (double)seen / (double)h->count;
        fprintf(out, "%12.3f %2.12f %10llu", (double)top / scale, share, (unsigned long long)seen);
        if (seen < h->count)
            fprintf(out, " %14.2f", 1.0 / (1.0 - share));
        fputc('\n', out);
    }
    fprintf(out, "#[Mean    = %12.3f, StdDeviation   = %12.3f]\n", tfa_histogram_mean(h) / scale,
            deviation(h) / scale);
    fprintf(out, "#[Max     = %12.3f, Total count    = %12llu]\n", (double)h->highest / scale,
            (unsigned long long)h->count);
    fprintf(out, "#[Buckets = %12d, SubBuckets     = %12d]\n", buckets_of(h), 1 << h->bits >> 1);
}
