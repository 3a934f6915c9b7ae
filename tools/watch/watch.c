/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Readings of a daemon's statistics.
 */
#include "watch.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define BUSY_TRIES 1000      /* of a millisecond: a writer may wait for a processor */
#define ALIVE_NS 3000000000u /* workers that sleep make progress every second */

/* ---- reading ---- */

static int read_now(const watch *w)
{
    const struct timespec pause = {.tv_nsec = 1000000};
    int status = TFA_E_BUSY;
    for (int i = 0; i < BUSY_TRIES && status == TFA_E_BUSY; i++) {
        if (i)
            nanosleep(&pause, NULL);
        status = tfa_statistics_read(w->statistics, w->now);
    }
    return status;
}

int watch_open(watch *w, int32_t timeout_ms)
{
    watch_close(w);
    int status = tfa_statistics_open(w->runtime_dir, timeout_ms, &w->statistics);
    if (status == TFA_OK)
        status = tfa_snapshot_create(w->statistics, &w->now);
    if (status == TFA_OK)
        status = tfa_snapshot_create(w->statistics, &w->since);
    if (status == TFA_OK)
        status = read_now(w);
    if (status == TFA_OK)
        w->alive_time = w->now->time;
    else
        watch_close(w);
    return status;
}

void watch_close(watch *w)
{
    tfa_snapshot_free(w->now);
    tfa_snapshot_free(w->since);
    tfa_statistics_close(w->statistics);
    free(w->clients);
    *w = (watch){.runtime_dir = w->runtime_dir};
}

bool watch_is_gone(const watch *w)
{
    return w->now->stopped || w->now->time - w->alive_time > ALIVE_NS;
}

/* ---- differences ---- */

/* `earlier` becomes what was added since. */
static void subtract(tfa_tally *earlier, const tfa_tally *now)
{
    const size_t counters = offsetof(tfa_tally, largest_estimate) / sizeof(uint64_t);
    uint64_t *words = &earlier->requests;
    for (size_t i = 0; i < counters; i++)
        words[i] = (&now->requests)[i] - words[i];
    for (int i = 0; i < TFA_STATISTICS_DECADES; i++)
        earlier->estimate_decades[i] = now->estimate_decades[i] - earlier->estimate_decades[i];
    earlier->largest_estimate = now->largest_estimate;
    (void)!tfa_histogram_since(&earlier->queue, &now->queue);
    (void)!tfa_histogram_since(&earlier->compute, &now->compute);
    (void)!tfa_histogram_since(&earlier->total, &now->total);
}

static bool is_same(const tfa_client_statistics *a, const tfa_client_statistics *b)
{
    return a->slot == b->slot && memcmp(&a->served, &b->served, sizeof a->served) == 0;
}

/* All that a client has is new if it came meanwhile. */
static const tfa_tally *subtract_client(const watch *w, const tfa_client_statistics *now)
{
    for (uint32_t i = 0; i < w->since->client_count; i++) {
        tfa_client_statistics *earlier = &w->since->clients[i];
        if (!is_same(earlier, now))
            continue;
        subtract(&earlier->tally, &now->tally);
        return &earlier->tally;
    }
    return &now->tally;
}

static int make_room(watch *w, uint32_t clients)
{
    if (clients <= w->client_room)
        return TFA_OK;
    const tfa_tally **more = realloc(w->clients, clients * sizeof *more);
    if (!more)
        return TFA_E_MEMORY;
    w->clients = more;
    w->client_room = clients;
    return TFA_OK;
}

int watch_read(watch *w)
{
    tfa_snapshot *const before = w->now;
    const uint64_t time = before->time, heartbeat = before->heartbeat;
    w->now = w->since;
    w->since = before;
    int status = read_now(w);
    if (status == TFA_OK)
        status = make_room(w, w->now->client_count);
    if (status != TFA_OK) { /* the reading before stays */
        w->since = w->now;
        w->now = before;
        return status;
    }
    for (uint32_t i = 0; i < w->now->robot_count; i++)
        subtract(&w->since->robots[i].total, &w->now->robots[i].total);
    for (uint32_t i = 0; i < w->now->client_count; i++)
        w->clients[i] = subtract_client(w, &w->now->clients[i]);
    w->seconds = 1e-9 * (double)(w->now->time - time);
    if (w->now->heartbeat != heartbeat)
        w->alive_time = w->now->time;
    return TFA_OK;
}
