/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients of a worker in the same process.
 */
#include "worker/local_client.h"

#include <linux/futex.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "worker/worker_internal.h"

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
                                               .max_tips = local_client->shape.max_tips,
                                               .layout = *layout,
                                               .requests = memory,
                                               .replies = memory + layout->request_bytes,
                                               .wait = local_client_wait_mode(local_client->worker),
                                               .doorbell = -1,
                                               .internal = true};
    local_client->ring =
        (tfa_ring_client){.layout = *layout,
                          .requests = memory,
                          .replies = memory + layout->request_bytes,
                          .worker_status = (const void *)(memory + layout->request_bytes)};
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
    if (local_client->shape.max_tips > TFA_DEFAULT_TIPS)
        local_client->shape.max_tips = TFA_DEFAULT_TIPS;
    const tfa_ring_layout layout = tfa_ring_layout_of(&local_client->shape, slots);
    const size_t size = layout.request_bytes + layout.reply_bytes;
    local_client->memory = aligned_alloc(TFA_CACHE_LINE, size);
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
