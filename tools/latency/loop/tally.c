/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Figures of a measured load.
 */
#include "tally.h"

#include <stdlib.h>
#include <string.h>

const char *const latency_parts[PART_COUNT] = {"round_trip", "client",  "request",
                                               "queue",      "compute", "reply"};

void latency_times_init(latency_times *times)
{
    (void)!tfa_histogram_init(&times->h, LATENCY_BITS, 64, times->buckets);
}

static unsigned row_of(uint64_t value)
{
    enum { LINEAR = 1 << BREAKDOWN_BITS, HALF = LINEAR / 2 };
    if (value < LINEAR)
        return (unsigned)value;
    const unsigned shift = 64u - (unsigned)__builtin_clzll(value) - BREAKDOWN_BITS;
    return LINEAR + (shift - 1) * HALF + ((unsigned)(value >> shift) - HALF);
}

uint64_t breakdown_at(const breakdown_row *rows, uint64_t round_trip, double means[PART_COUNT])
{
    const breakdown_row *row = &rows[row_of(round_trip)];
    for (int i = 0; i < PART_COUNT; i++)
        means[i] = row->count ? row->sums[i] / (double)row->count : 0;
    return row->count;
}

void memory_touch(void *memory, size_t size)
{
    enum { PAGE = 4096 };
    volatile unsigned char *at = memory;
    for (size_t i = 0; i < size; i += PAGE)
        at[i] = at[i];
    if (size)
        at[size - 1] = at[size - 1];
}

tally *tally_create(uint64_t sample_capacity)
{
    tally *t = malloc(sizeof *t);
    if (!t)
        return NULL;
    memset(t, 0, sizeof *t);
    for (int i = 0; i < PART_COUNT; i++)
        latency_times_init(&t->parts[i]);
    for (int i = 0; i < TALLY_SLICES; i++)
        latency_times_init(&t->slices[i]);
    memory_touch(t, sizeof *t);
    if (sample_capacity == 0)
        return t;
    t->samples = malloc(sample_capacity * sizeof *t->samples);
    if (!t->samples) {
        tally_free(t);
        return NULL;
    }
    memory_touch(t->samples, sample_capacity * sizeof *t->samples);
    t->sample_capacity = sample_capacity;
    return t;
}

void tally_free(tally *t)
{
    if (t)
        free(t->samples);
    free(t);
}

void tally_add(tally *t, const latency_sample *sample, unsigned slice)
{
    const uint64_t trip = sample->parts[PART_ROUND_TRIP];
    const tfa_histogram *seen = &t->parts[PART_ROUND_TRIP].h;
    if (seen->count == 0 || trip < seen->lowest)
        t->fastest = *sample;
    if (seen->count == 0 || trip > seen->highest)
        t->slowest = *sample;
    t->last = trip;
    breakdown_row *row = &t->breakdown[row_of(trip)];
    row->count++;
    for (int i = 0; i < PART_COUNT; i++) {
        tfa_histogram_add(&t->parts[i].h, sample->parts[i]);
        row->sums[i] += (double)sample->parts[i];
    }
    tfa_histogram_add(&t->slices[slice < TALLY_SLICES ? slice : TALLY_SLICES - 1].h, trip);
    if (t->sample_count < t->sample_capacity)
        t->samples[t->sample_count++] = *sample;
}

static void count_status(tally *t, int status, uint64_t count)
{
    for (int i = 0; i < TALLY_STATUSES; i++) {
        if (t->statuses[i].count != 0 && t->statuses[i].status != status)
            continue;
        t->statuses[i].status = status;
        t->statuses[i].count += count;
        return;
    }
}

void tally_reject(tally *t, int status)
{
    t->rejected++;
    count_status(t, status, 1);
}

void tally_outcome(tally *t, int missed)
{
    t->run = missed ? t->run + 1 : 0;
    if (t->run > t->longest_run)
        t->longest_run = t->run;
    atomic_store_explicit(&t->done, atomic_load_explicit(&t->done, memory_order_relaxed) + 1,
                          memory_order_relaxed);
}

static void merge_extremes(tally *all, const tally *client)
{
    const tfa_histogram *to = &all->parts[PART_ROUND_TRIP].h;
    const tfa_histogram *from = &client->parts[PART_ROUND_TRIP].h;
    if (from->count == 0)
        return;
    if (to->count == 0 || from->lowest < to->lowest)
        all->fastest = client->fastest;
    if (to->count == 0 || from->highest > to->highest)
        all->slowest = client->slowest;
}

void tally_merge(tally *all, const tally *client)
{
    merge_extremes(all, client);
    for (int i = 0; i < PART_COUNT; i++)
        (void)!tfa_histogram_merge(&all->parts[i].h, &client->parts[i].h);
    for (int i = 0; i < TALLY_SLICES; i++)
        (void)!tfa_histogram_merge(&all->slices[i].h, &client->slices[i].h);
    for (int i = 0; i < BREAKDOWN_ROWS; i++) {
        all->breakdown[i].count += client->breakdown[i].count;
        for (int k = 0; k < PART_COUNT; k++)
            all->breakdown[i].sums[k] += client->breakdown[i].sums[k];
    }
    all->sent += client->sent;
    all->lost += client->lost;
    all->rejected += client->rejected;
    all->late += client->late;
    all->full += client->full;
    all->duplicates += client->duplicates;
    all->stale += client->stale;
    all->reordered += client->reordered;
    all->reconnects += client->reconnects;
    for (int i = 0; i < TALLY_STATUSES && client->statuses[i].count; i++)
        count_status(all, client->statuses[i].status, client->statuses[i].count);
    if (client->longest_run > all->longest_run)
        all->longest_run = client->longest_run;
    if (client->elapsed_ns > all->elapsed_ns)
        all->elapsed_ns = client->elapsed_ns;
    if (client->method)
        all->method = client->method;
}
