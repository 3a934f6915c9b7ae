/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Log-linear histogram.
 */
#include <math.h>
#include <string.h>
#include <totalforce/histogram.h>

#include "bucket.h"

#define BITS_MAX 16
#define SAMPLES_BEYOND 10 /* a quantile with fewer beyond it is noise */

int tfa_histogram_init(tfa_histogram *h, uint32_t bits, uint32_t range, uint64_t *buckets)
{
    if (!h || !buckets || bits < 1 || bits > BITS_MAX || range < bits || range > 64)
        return TFA_E_ARGUMENT;
    *h = (tfa_histogram){
        .bits = bits, .bucket_count = TFA_HISTOGRAM_BUCKETS(bits, range), .buckets = buckets};
    tfa_histogram_clear(h);
    return TFA_OK;
}

void tfa_histogram_clear(tfa_histogram *h)
{
    h->count = h->lowest = h->highest = h->highest_index = 0;
    h->sum = 0;
    memset(h->buckets, 0, h->bucket_count * sizeof *h->buckets);
}

void tfa_histogram_add(tfa_histogram *h, uint64_t value)
{
    if (h->count == 0 || value < h->lowest)
        h->lowest = value;
    if (h->count == 0 || value > h->highest) {
        h->highest = value;
        h->highest_index = h->count;
    }
    h->buckets[tfa_bucket_of(h->bits, h->bucket_count, value)]++;
    h->sum += (double)value;
    h->count++;
}

int tfa_histogram_merge(tfa_histogram *h, const tfa_histogram *other)
{
    if (h->bits != other->bits || h->bucket_count != other->bucket_count)
        return TFA_E_SIZE;
    if (other->count == 0)
        return TFA_OK;
    if (h->count == 0 || other->lowest < h->lowest)
        h->lowest = other->lowest;
    if (h->count == 0 || other->highest > h->highest) {
        h->highest = other->highest;
        h->highest_index = h->count + other->highest_index;
    }
    for (uint32_t i = 0; i < h->bucket_count; i++)
        h->buckets[i] += other->buckets[i];
    h->sum += other->sum;
    h->count += other->count;
    return TFA_OK;
}

int tfa_histogram_since(tfa_histogram *earlier, const tfa_histogram *now)
{
    uint64_t count = 0, lowest = 0, highest = 0;
    if (earlier->bits != now->bits || earlier->bucket_count != now->bucket_count)
        return TFA_E_SIZE;
    for (uint32_t i = 0; i < now->bucket_count; i++) {
        const uint64_t added =
            now->buckets[i] > earlier->buckets[i] ? now->buckets[i] - earlier->buckets[i] : 0;
        earlier->buckets[i] = added;
        if (added && !count)
            lowest = i ? tfa_histogram_top(now, i - 1) + 1 : 0;
        if (added)
            highest = tfa_histogram_top(now, i);
        count += added;
    }
    earlier->count = count;
    earlier->lowest = count && lowest < now->lowest ? now->lowest : lowest;
    earlier->highest = highest > now->highest ? now->highest : highest;
    earlier->highest_index = 0;
    earlier->sum = count && now->sum > earlier->sum ? now->sum - earlier->sum : 0;
    return TFA_OK;
}

uint64_t tfa_histogram_top(const tfa_histogram *h, uint32_t bucket)
{
    return tfa_bucket_top(h->bits, h->bucket_count, bucket);
}

uint64_t tfa_histogram_quantile(const tfa_histogram *h, double quantile)
{
    uint64_t wanted = (uint64_t)ceil(quantile * (double)h->count);
    uint64_t seen = 0;
    if (wanted < 1)
        wanted = 1;
    for (uint32_t i = 0; i < h->bucket_count; i++) {
        seen += h->buckets[i];
        if (seen >= wanted) {
            const uint64_t top = tfa_histogram_top(h, i);
            return top < h->highest ? top : h->highest;
        }
    }
    return h->highest;
}

double tfa_histogram_mean(const tfa_histogram *h)
{
    return h->count ? h->sum / (double)h->count : 0.0;
}

int tfa_histogram_supports(const tfa_histogram *h, double quantile)
{
    return (1.0 - quantile) * (double)h->count >= SAMPLES_BEYOND * (1.0 - 1e-9);
}
