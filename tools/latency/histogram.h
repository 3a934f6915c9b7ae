/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A log-linear histogram of times: fixed memory, constant cost a sample, 0.8 % resolution.
 * (HdrHistogram for C is not packaged in Debian.)
 */
#ifndef TOOLS_LATENCY_HISTOGRAM_H
#define TOOLS_LATENCY_HISTOGRAM_H

#include <stdint.h>
#include <stdio.h>

/* Values below 2^8 have a bucket each; above, every power of two is cut into 2^7. */
enum {
    HISTOGRAM_BITS = 8,
    HISTOGRAM_BUCKETS = (1 << HISTOGRAM_BITS) + (64 - HISTOGRAM_BITS) * (1 << (HISTOGRAM_BITS - 1))
};

/** Zero-initialise. Written by histogram_add only. */
typedef struct histogram {
    uint64_t count;
    uint64_t lowest, highest; /**< exact */
    uint64_t highest_index;   /**< which sample was the highest: the first of equals */
    double sum;
    uint64_t buckets[HISTOGRAM_BUCKETS];
} histogram;

/** Adds one value. No allocation, no branch that depends on what came before but the extremes. */
void histogram_add(histogram *h, uint64_t value);

/** The value that a share `quantile` (0..1) of the samples does not exceed: at most 0.8 % too high,
 *  never above the highest. 0 for an empty histogram. */
uint64_t histogram_quantile(const histogram *h, double quantile);

/** The mean; 0 for an empty histogram. */
double histogram_mean(const histogram *h);

/** True when so many samples lie beyond the quantile (10) that it means something. */
int histogram_supports(const histogram *h, double quantile);

/** Writes the percentile distribution in HdrHistogram's text format (.hgrm), which its plotters
 *  read; values are divided by `scale`. */
void histogram_write(const histogram *h, FILE *out, double scale);

#endif
