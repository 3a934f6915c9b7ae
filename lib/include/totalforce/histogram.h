/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Log-linear histogram of times: fixed memory, constant cost a value, bounded relative error, as
 * HdrHistogram (Tene 2012).
 */
#ifndef TOTALFORCE_HISTOGRAM_H
#define TOTALFORCE_HISTOGRAM_H

#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Buckets of a histogram of `bits` bits for values below 2^range: values below 2^bits have a
 *  bucket each; above, every power of two is cut into 2^(bits - 1). 1 <= bits <= range <= 64 and
 *  bits <= 16. */
#define TFA_HISTOGRAM_BUCKETS(bits, range)                                                         \
    ((1u << (bits)) + ((range) - (bits)) * (1u << (bits) >> 1))

/** Histogram. Made by tfa_histogram_init, written by tfa_histogram_add and _merge. Members may be
 *  read. The buckets are the caller's: a copy of this struct shares them. */
typedef struct tfa_histogram {
    uint32_t bits;          /**< resolution: a bucket is at most 2^(1 - bits) of its values wide */
    uint32_t bucket_count;  /**< TFA_HISTOGRAM_BUCKETS(bits, range) */
    uint64_t count;         /**< values added */
    uint64_t lowest;        /**< exact; 0 while empty */
    uint64_t highest;       /**< exact; 0 while empty */
    uint64_t highest_index; /**< number of the first highest value, from 0 */
    double sum;             /**< of the values */
    uint64_t *buckets;      /**< bucket_count; values of 2^range and above lie in the last one */
} tfa_histogram;

/**
 * Makes an empty histogram.
 *
 * @param histogram  is overwritten
 * @param bits       1 to 16: 8 for a resolution of 0.8 %, 5 for 6.3 %
 * @param range      bits to 64: quantiles of values from 2^range on are the highest value
 * @param buckets    TFA_HISTOGRAM_BUCKETS(bits, range), set to zero; must outlive the histogram
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, or bits or range outside their bounds)
 */
TFA_API TFA_CHECKED int tfa_histogram_init(tfa_histogram *histogram, uint32_t bits, uint32_t range,
                                           uint64_t *buckets);

/** Empties a histogram. */
TFA_API void tfa_histogram_clear(tfa_histogram *histogram);

/** Adds a value. Constant cost, no allocation. One thread at a time. */
TFA_API void tfa_histogram_add(tfa_histogram *histogram, uint64_t value);

/**
 * Adds all values of another histogram; highest_index counts them after those of `histogram`.
 *
 * @return TFA_OK; TFA_E_SIZE (bits or bucket_count differ; nothing was changed)
 */
TFA_API TFA_CHECKED int tfa_histogram_merge(tfa_histogram *histogram, const tfa_histogram *other);

/**
 * Makes `earlier` the values that were added to `now` since it was a copy of `now`. Its lowest and
 * highest are then bounds by their buckets, at most those of `now`; highest_index is 0.
 *
 * @return TFA_OK; TFA_E_SIZE (bits or bucket_count differ; nothing was changed)
 */
TFA_API TFA_CHECKED int tfa_histogram_since(tfa_histogram *earlier, const tfa_histogram *now);

/**
 * Value that a share `quantile` of the values does not exceed, by nearest rank.
 *
 * @param histogram  any
 * @param quantile   0 to 1
 * @return at most 2^(1 - bits) too high, never above the highest value; 0 for an empty histogram
 */
TFA_API uint64_t tfa_histogram_quantile(const tfa_histogram *histogram, double quantile);

/** Mean of the values, exact but for rounding; 0 for an empty histogram. */
TFA_API double tfa_histogram_mean(const tfa_histogram *histogram);

/** Largest value that falls into a bucket; UINT64_MAX for the last one. */
TFA_API uint64_t tfa_histogram_top(const tfa_histogram *histogram, uint32_t bucket);

/** 1 if at least 10 values lie beyond the quantile; with fewer it is noise. */
TFA_API int tfa_histogram_supports(const tfa_histogram *histogram, double quantile);

#ifdef __cplusplus
}
#endif
#endif
