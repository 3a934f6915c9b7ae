/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients of a worker: attach, drain, detach; and local clients, those in this process.
 */
#include "worker_internal.h"

#include <errno.h>
#include <linux/futex.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/syscall.h>
#include <time.h>
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
    client->drained = 0;
    client->shape.max_batch = o->max_batch;
    client->wait = o->wait;
    client->doorbell = o->doorbell;
    client->guard = -1;
    client->ring = (tfa_ring_server){.layout = o->layout,
                                     .requests = o->requests,
                                     .replies = o->replies,
                                     .spin = o->wait == TFA_WAIT_SPIN};
    atomic_store_explicit(&client->count.requests, 0, memory_order_relaxed);
    atomic_store_explicit(&client->count.rejected, 0, memory_order_relaxed);
    client->scratch = aligned_alloc(TFA_WIRE_LINE, o->layout.request_stride);
    if (!client->scratch)
        return TFA_E_MEMORY;
    memset(client->scratch, 0, o->layout.request_stride); /* no page fault later */
    if (o->internal)
        return TFA_OK;
    client->guard = tfa_sigbus_guard(o->requests, o->layout.request_bytes);
    return client->guard >= 0 ? TFA_OK : TFA_E_REFUSED;
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
    tfa_sigbus_release(client->guard);
    free(client->scratch);
    client->scratch = NULL;
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

const tfa_worker_client_counters *tfa_worker_client_get_counters(const tfa_worker_client *client)
{
    return &client->count;
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

const tfa_ring_worker_status *tfa_worker_get_status(const tfa_worker *w)
{
    return w->worker_status;
}

/* ---- local clients ---- */

/* A request of a local client comes from threads of this process and of others (with DDS there are
 * three). Where they would queue for the cores that spinning leaves, the worker sleeps instead: on
 * two cores a DDS round trip had a median of 17 or of 107 us with a worker that spins, by where the
 * host put the threads, and 35 us every time with one that sleeps (totalforce latency arm --via dds
 * --wait hybrid, 20000 calls, four runs each, 2026-11-21). */
#define SPIN_PROCESSORS_MIN 4

static tfa_wait local_client_wait_mode(const tfa_worker *w)
{
    if (w->wait == TFA_WAIT_BLOCK || sysconf(_SC_NPROCESSORS_ONLN) < SPIN_PROCESSORS_MIN)
        return TFA_WAIT_BLOCK;
    return TFA_WAIT_HYBRID;
}

static int attach_local_client(tfa_local_client *local_client, uint32_t robot,
                               const tfa_ring_layout *layout)
{
    unsigned char *memory = local_client->memory;
    const tfa_worker_client_options options = {.robot = robot,
                                               .max_batch = local_client->shape.max_batch,
                                               .layout = *layout,
                                               .requests = memory,
                                               .replies = memory + layout->request_bytes,
                                               .wait = local_client_wait_mode(local_client->worker),
                                               .doorbell = -1,
                                               .internal = true};
    local_client->ring = (tfa_ring_client){.layout = *layout,
                                           .requests = memory,
                                           .replies = memory + layout->request_bytes,
                                           .worker_status = local_client->worker->worker_status};
    return tfa_worker_attach(local_client->worker, &options, &local_client->client);
}

int tfa_local_client_open(tfa_worker *w, uint32_t robot, uint32_t slots, uint32_t max_batch,
                          tfa_local_client *local_client)
{
    *local_client = (tfa_local_client){.worker = w};
    if (robot >= w->robot_count)
        return TFA_E_ROBOT;
    pthread_mutex_lock(&w->mutex);
    local_client->shape = w->solver_lists[w->latest][robot].shape;
    pthread_mutex_unlock(&w->mutex);
    if (!tfa_ring_slots_valid(slots) || max_batch == 0 || max_batch > local_client->shape.max_batch)
        return TFA_E_SIZE;
    local_client->shape.max_batch = max_batch;
    const tfa_ring_layout layout = tfa_ring_layout_of(&local_client->shape, slots);
    const size_t size = layout.request_bytes + layout.reply_bytes;
    local_client->memory = aligned_alloc(TFA_WIRE_LINE, size);
    if (!local_client->memory)
        return TFA_E_MEMORY;
    memset(local_client->memory, 0, size);
    int status = attach_local_client(local_client, robot, &layout);
    if (status != TFA_OK) {
        free(local_client->memory);
        local_client->memory = NULL;
    }
    return status;
}

void tfa_local_client_close(tfa_local_client *local_client)
{
    const struct timespec a_while = {.tv_nsec = 100000};
    if (!local_client->client)
        return;
    while (!tfa_worker_detach(local_client->worker, local_client->client))
        nanosleep(&a_while, NULL);
    free(local_client->memory);
    *local_client = (tfa_local_client){0};
}

void tfa_local_client_send(tfa_local_client *local_client)
{
    if (tfa_ring_send(&local_client->ring))
        tfa_worker_wake(local_client->worker);
}

bool tfa_local_client_wait(const tfa_local_client *local_client, uint64_t index,
                           uint64_t timeout_ns)
{
    const tfa_ring_client *ring = &local_client->ring;
    const void *slot = ring->replies + tfa_ring_reply_offset(&ring->layout, index);
    const struct timespec time = {.tv_sec = (time_t)(timeout_ns / 1000000000u),
                                  .tv_nsec = (long)(timeout_ns % 1000000000u)};
    uint64_t seq = tfa_ring_client_prepare_wait(ring, index);
    if (seq <= index) {
        (void)syscall(SYS_futex, tfa_ring_futex_word(slot), FUTEX_WAIT, (uint32_t)seq, &time, NULL,
                      0);
        const tfa_wire_reply *line = slot;
        seq = atomic_load_explicit(&line->seq, memory_order_acquire); /* R2 */
    }
    tfa_ring_client_end_wait(ring);
    return seq > index;
}
