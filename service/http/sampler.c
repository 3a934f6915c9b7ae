/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The last minute, second by second, from differences of the statistics.
 */
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "http/http_internal.h"

#define SECOND_NS 1000000000u

int sampler_open(sampler *s, int statistics)
{
    int status = tfa_statistics_map(statistics, &s->statistics);
    if (status == TFA_OK)
        status = tfa_snapshot_create(s->statistics, &s->now);
    if (status == TFA_OK)
        status = tfa_snapshot_create(s->statistics, &s->before);
    if (status != TFA_OK)
        return status;
    for (status = TFA_E_BUSY; status == TFA_E_BUSY; sched_yield())
        status = tfa_statistics_read(s->statistics, s->before);
    if (status != TFA_OK)
        return status;
    s->now->robot_count = s->before->robot_count;
    s->second = s->before->time; /* now is read by the first update */
    s->history = calloc((size_t)s->before->robot_count * HTTP_SECONDS, sizeof *s->history);
    s->buckets = calloc(TFA_STATISTICS_BUCKETS, sizeof *s->buckets);
    return s->history && s->buckets ? TFA_OK : TFA_E_MEMORY;
}

void sampler_close(sampler *s)
{
    free(s->buckets);
    free(s->rates);
    free(s->history);
    tfa_snapshot_free(s->before);
    tfa_snapshot_free(s->now);
    tfa_statistics_close(s->statistics);
    *s = (sampler){0};
}

/* A snapshot that failed is read again; it holds robots and clients of the statistics all the same.
 */
static bool read_now(sampler *s)
{
    for (int i = 0; i < 3; i++)
        if (tfa_statistics_read(s->statistics, s->now) == TFA_OK) {
            s->read = s->now->time;
            return true;
        }
    return false;
}

void sampler_update(sampler *s, uint64_t now)
{
    if (now - s->read >= HTTP_PERIOD_NS)
        (void)read_now(s);
}

/* ---- a second ---- */

static void set_times(sampler *s, const tfa_histogram *now, const tfa_histogram *before,
                      float times[QUANTILE_COUNT])
{
    static const double quantiles[QUANTILE_COUNT] = {0.5, 0.99, 0.999};
    tfa_histogram d = {.bits = now->bits, .bucket_count = now->bucket_count, .buckets = s->buckets};
    for (uint32_t i = 0; i < d.bucket_count; i++) {
        s->buckets[i] = now->buckets[i] - before->buckets[i];
        d.count += s->buckets[i];
        if (s->buckets[i])
            d.highest =
                tfa_histogram_top(&d, i) < now->highest ? tfa_histogram_top(&d, i) : now->highest;
    }
    for (int k = 0; k < QUANTILE_COUNT; k++)
        times[k] =
            d.count ? (float)((double)tfa_histogram_quantile(&d, quantiles[k]) * 1e-3) : -1.0f;
}

static void add_second(sampler *s, uint32_t robot, double seconds)
{
    const tfa_tally *now = &s->now->robots[robot].total, *before = &s->before->robots[robot].total;
    http_second *to = &s->history[robot * HTTP_SECONDS + s->seconds % HTTP_SECONDS];
    to->requests = (float)((double)(now->requests - before->requests) / seconds);
    to->states = (float)((double)(now->states - before->states) / seconds);
    to->rejected = (float)((double)(now->rejected - before->rejected) / seconds);
    to->fallbacks = (float)((double)(now->fallbacks - before->fallbacks) / seconds);
    set_times(s, &now->queue, &before->queue, to->times[TIME_QUEUE]);
    set_times(s, &now->compute, &before->compute, to->times[TIME_COMPUTE]);
    set_times(s, &now->total, &before->total, to->times[TIME_TOTAL]);
}

static bool same_client(const tfa_served_client *a, uint32_t slot_a, const tfa_served_client *b,
                        uint32_t slot_b)
{
    return a->kind == b->kind && a->robot == b->robot && a->worker == b->worker &&
           a->since == b->since && slot_a == slot_b;
}

static uint64_t requests_before(const sampler *s, const tfa_client_statistics *client)
{
    for (uint32_t i = 0; i < s->before->client_count; i++) {
        const tfa_client_statistics *c = &s->before->clients[i];
        if (same_client(&c->served, c->slot, &client->served, client->slot))
            return c->tally.requests;
    }
    return 0;
}

static void set_rates(sampler *s, double seconds)
{
    const uint32_t count = s->now->client_count;
    if (count > s->rate_room) {
        http_rate *more = realloc(s->rates, 2 * count * sizeof *more);
        if (!more)
            return;
        s->rates = more;
        s->rate_room = 2 * count;
    }
    s->rate_count = count;
    for (uint32_t i = 0; i < count; i++) {
        const tfa_client_statistics *c = &s->now->clients[i];
        const double requests = (double)(c->tally.requests - requests_before(s, c));
        s->rates[i] = (http_rate){c->served, c->slot, (float)(requests / seconds)};
    }
}

uint64_t sampler_tick(sampler *s, uint64_t now)
{
    if (now - s->second < SECOND_NS)
        return s->second + SECOND_NS - now;
    if (!read_now(s))
        return HTTP_PERIOD_NS;
    const double seconds = (double)(s->now->time - s->before->time) * 1e-9;
    tfa_snapshot *last = s->now;
    for (uint32_t i = 0; i < last->robot_count; i++)
        add_second(s, i, seconds);
    set_rates(s, seconds);
    s->seconds++;
    s->second = last->time;
    s->now = s->before;
    s->before = last;
    if (!read_now(s))
        s->read = 0; /* at the next update */
    return SECOND_NS;
}

/* ---- questions ---- */

const http_second *sampler_second(const sampler *s, uint32_t robot, uint32_t ago)
{
    if (ago >= s->seconds || ago >= HTTP_SECONDS)
        return NULL;
    return &s->history[robot * HTTP_SECONDS + (s->seconds - 1 - ago) % HTTP_SECONDS];
}

double sampler_rate(const sampler *s, const tfa_client_statistics *client)
{
    for (uint32_t i = 0; i < s->rate_count; i++)
        if (same_client(&s->rates[i].client, s->rates[i].slot, &client->served, client->slot))
            return (double)s->rates[i].requests;
    return -1;
}
