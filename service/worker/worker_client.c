/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients of a worker: attach, drain, detach; and other solvers.
 */
#include "worker_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "platform/sigbus.h"

/* ---- attach and detach ---- */

static tfa_worker_client *find_free_client(tfa_worker *w)
{
    for (uint32_t i = 0; i < TFA_WORKER_CLIENTS_MAX; i++)
        if (atomic_load_explicit(&w->clients[i].state, memory_order_relaxed) == CLIENT_FREE)
            return &w->clients[i];
    return NULL;
}

static int init_client(const tfa_worker *w, const tfa_worker_client_options *o,
                       tfa_worker_client *client)
{
    client->robot = o->robot;
    client->shape = w->solver_lists[w->latest][o->robot].shape;
    client->virtual_ns = client->drain_ns = 0;
    client->drained = 0;
    client->debt = (tfa_cost_debt){0};
    client->shape.max_batch = o->max_batch;
    client->shape.max_tips = o->max_tips;
    client->wait = o->wait;
    client->doorbell = o->doorbell;
    client->direct = o->direct;
    client->warm = false;
    client->guards[0] = client->guards[1] = -1;
    atomic_store_explicit(&client->lost, false, memory_order_relaxed); /* A6 publishes it */
    client->form.bytes = 0;
    client->ring = (tfa_ring_server){.layout = o->layout,
                                     .requests = o->requests,
                                     .replies = o->replies,
                                     .spin = o->wait == TFA_WAIT_SPIN};
    client->scratch = aligned_alloc(TFA_CACHE_LINE, o->layout.request_stride);
    client->answers = malloc(o->max_batch * sizeof *client->answers);
    if (!client->scratch || !client->answers)
        return TFA_E_MEMORY;
    memset(client->scratch, 0, o->layout.request_stride); /* no page fault later */
    memset(client->answers, 0, o->max_batch * sizeof *client->answers);
    if (o->internal)
        return TFA_OK;
    client->guards[0] = tfa_sigbus_guard(o->requests, o->layout.request_bytes, &client->lost);
    client->guards[1] = tfa_sigbus_guard(o->replies, o->layout.reply_bytes, &client->lost);
    return client->guards[0] >= 0 && client->guards[1] >= 0 ? TFA_OK : TFA_E_REFUSED;
}

/* ---- statistics: under the mutex ---- */

static void begin_statistics(tfa_worker *w, const tfa_worker_client_options *o,
                             tfa_worker_client *client)
{
    tfa_shared_worker *block = w->statistics.worker;
    const uint32_t number = (uint32_t)(client - w->clients);
    tfa_served_client served = o->served;
    served.kind = served.kind ? served.kind : TFA_CLIENT_SELF;
    served.robot = o->robot;
    served.worker = (int32_t)w->statistics.number;
    served.slots = o->layout.slots;
    client->self_test = served.kind == TFA_CLIENT_SELF;
    client->shared = &w->statistics.clients[number];
    tfa_record_begin(&block->version);
    tfa_tally_clear(&client->shared->tally);
    tfa_words_write(client->shared->served, &served, sizeof served);
    tfa_counter_set(&client->shared->queued, 0);
    if (number >= atomic_load_explicit(&block->clients_used, memory_order_relaxed))
        tfa_counter_set(&block->clients_used, number + 1);
    tfa_record_end(&block->version);
}

/* The worker has detached: its counters go to those of the departed. */
static void end_statistics(tfa_worker *w, tfa_worker_client *client)
{
    tfa_shared_worker *block = w->statistics.worker;
    tfa_served_client served = {0};
    tfa_record_begin(&block->version);
    if (!client->self_test)
        tfa_tally_add(&w->statistics.departed[client->robot], &client->shared->tally);
    tfa_words_write(client->shared->served, &served, sizeof served);
    tfa_record_end(&block->version);
}

static int watch_doorbell(const tfa_worker *w, const tfa_worker_client *client)
{
    struct epoll_event event = {.events = EPOLLIN | EPOLLET};
    if (client->doorbell < 0 || epoll_ctl(w->epoll, EPOLL_CTL_ADD, client->doorbell, &event) == 0)
        return TFA_OK;
    return TFA_E_SYSTEM;
}

static void free_client_resources(tfa_worker_client *client)
{
    tfa_sigbus_release(client->guards[0]);
    tfa_sigbus_release(client->guards[1]);
    free(client->scratch);
    free(client->answers);
    client->scratch = NULL;
    client->answers = NULL;
}

static int attach(tfa_worker *w, const tfa_worker_client_options *o, tfa_worker_client **out)
{
    tfa_worker_client *client = find_free_client(w);
    if (!client)
        return TFA_E_REFUSED;
    int status = init_client(w, o, client);
    if (status == TFA_OK)
        status = watch_doorbell(w, client);
    if (status != TFA_OK) {
        free_client_resources(client);
        return status;
    }
    begin_statistics(w, o, client);
    atomic_fetch_add_explicit(&w->modes[client->wait], 1, memory_order_relaxed);
    atomic_store_explicit(&client->state, CLIENT_ATTACHED, memory_order_release); /* A6 */
    const uint32_t number = (uint32_t)(client - w->clients);
    if (number >= atomic_load_explicit(&w->clients_used, memory_order_relaxed))
        atomic_store_explicit(&w->clients_used, number + 1, memory_order_release); /* A9 */
    *out = client;
    return TFA_OK;
}

int tfa_worker_attach(tfa_worker *w, const tfa_worker_client_options *options,
                      tfa_worker_client **client)
{
    *client = NULL;
    if (options->robot >= w->robot_count)
        return TFA_E_ROBOT;
    pthread_mutex_lock(&w->mutex);
    int status = attach(w, options, client);
    pthread_mutex_unlock(&w->mutex);
    tfa_worker_wake(w);
    return status;
}

/* Asks the worker to detach if it was not asked. @return the client is detached */
static bool detach(tfa_worker *w, tfa_worker_client *client, uint32_t target_state)
{
    pthread_mutex_lock(&w->mutex);
    uint32_t state = atomic_load_explicit(&client->state, memory_order_acquire); /* R8 */
    if (state != target_state && state != CLIENT_DETACHING && state != CLIENT_DETACHED) {
        atomic_store_explicit(&client->state, target_state, memory_order_release); /* A7 */
        state = target_state;
        tfa_worker_wake(w);
    }
    const bool detached =
        state == CLIENT_DETACHED ||
        atomic_load_explicit(&w->phase, memory_order_acquire) != WORKER_RUNNING; /* R10 */
    if (detached) {
        if (client->doorbell >= 0)
            (void)epoll_ctl(w->epoll, EPOLL_CTL_DEL, client->doorbell, NULL);
        atomic_fetch_sub_explicit(&w->modes[client->wait], 1, memory_order_relaxed);
        free_client_resources(client);
        if (state != CLIENT_DETACHED) /* a worker that does not run has not detached itself */
            client->at.active = false;
        end_statistics(w, client);
        atomic_store_explicit(&client->state, CLIENT_FREE, memory_order_relaxed);
    }
    pthread_mutex_unlock(&w->mutex);
    return detached;
}

bool tfa_worker_detach(tfa_worker *w, tfa_worker_client *client)
{
    return detach(w, client, CLIENT_DETACHING);
}

bool tfa_worker_drain(tfa_worker *w, tfa_worker_client *client)
{
    return detach(w, client, CLIENT_DRAINING);
}

/* ---- other solvers ---- */

void tfa_worker_offer(tfa_worker *w, const tfa_worker_robot *robots)
{
    pthread_mutex_lock(&w->mutex);
    w->latest = 1 - w->latest;
    tfa_worker_robot *list = w->solver_lists[w->latest];
    memcpy(list, robots, w->robot_count * sizeof *list);
    atomic_store_explicit(&w->offer, list, memory_order_release); /* A12 */
    pthread_mutex_unlock(&w->mutex);
    tfa_worker_wake(w);
}

bool tfa_worker_offer_is_taken(const tfa_worker *w)
{
    return atomic_load_explicit(&w->taken, memory_order_acquire) == /* R13 */
               atomic_load_explicit(&w->offer, memory_order_relaxed) ||
           atomic_load_explicit(&w->phase, memory_order_acquire) != WORKER_RUNNING; /* R10 */
}

bool tfa_worker_client_is_broken(const tfa_worker_client *client)
{
    return atomic_load_explicit(&client->state, memory_order_relaxed) == CLIENT_BROKEN;
}

tfa_tally_sums tfa_worker_client_sums(const tfa_worker_client *client)
{
    tfa_tally_sums sums = {0};
    tfa_tally_sum(&client->shared->tally, &sums);
    return sums;
}

void tfa_worker_wake(tfa_worker *w)
{
    const uint64_t one = 1;
    ssize_t n;
    do
        n = write(w->wake_event, &one, sizeof one);
    while (n < 0 && errno == EINTR);
}

void tfa_worker_stop(tfa_worker *w)
{
    atomic_store_explicit(&w->stop, true, memory_order_release); /* A11 */
    tfa_worker_wake(w);
}

uint64_t tfa_worker_heartbeat(const tfa_worker *w)
{
    return atomic_load_explicit(&w->statistics.worker->heartbeat, memory_order_relaxed);
}
