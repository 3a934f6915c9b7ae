/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests at the worker: a direct client of the worker for each robot. The ring carries addresses;
 * requests and replies stay where they are.
 */
#include "dds/topics/dds_internal.h"

#include <linux/futex.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

struct tfa_dds_ring {
    tfa_ring_client ring;
    struct tfa_worker *worker;
    tfa_worker_client *client;
    void *memory;
    dds_slot slots[];
};

static void free_slots(struct tfa_dds_ring *r)
{
    for (uint32_t i = 0; i < r->ring.layout.slots; i++)
        tfa_dds_free_sample(r->slots[i].taken);
}

static void free_ring(struct tfa_dds_ring *r)
{
    free_slots(r);
    free(r->memory);
    free(r);
}

static int make_slots(struct tfa_dds_ring *r)
{
    for (uint32_t i = 0; i < r->ring.layout.slots; i++) {
        r->slots[i].taken = calloc(1, sizeof *r->slots[i].taken);
        if (r->slots[i].taken == NULL)
            return TFA_E_MEMORY;
    }
    return TFA_OK;
}

/* The worker never spins for requests of the gateway: they are long. */
static int attach(struct tfa_dds_ring *r, const dds_robot *robot)
{
    const tfa_ring_layout *layout = &r->ring.layout;
    unsigned char *memory = r->memory, *replies = memory + layout->request_bytes;
    const tfa_worker_client_options options = {.robot = robot->index,
                                               .max_batch = robot->shape.max_batch,
                                               .max_tips = robot->shape.max_tips,
                                               .layout = *layout,
                                               .requests = memory,
                                               .replies = replies,
                                               .wait = TFA_WAIT_BLOCK,
                                               .doorbell = -1,
                                               .internal = true,
                                               .direct = true,
                                               .served = {.kind = TFA_CLIENT_DDS,
                                                          .process = getpid(),
                                                          .user = geteuid(),
                                                          .since = (uint64_t)tfa_dds_monotonic()}};
    r->ring.requests = memory;
    r->ring.replies = replies;
    r->ring.worker_status = (const void *)replies;
    return tfa_worker_attach(r->worker, &options, &r->client);
}

int tfa_dds_ring_open(struct tfa_worker *worker, const dds_robot *robot, uint32_t slots,
                      struct tfa_dds_ring **result)
{
    const tfa_wire_shape nothing = {.max_batch = 1}; /* lines only */
    const tfa_ring_layout layout = tfa_ring_layout_of(&nothing, slots);
    struct tfa_dds_ring *r = calloc(1, sizeof *r + slots * sizeof r->slots[0]);

    *result = NULL;
    if (r == NULL)
        return TFA_E_MEMORY;
    r->ring.layout = layout;
    r->worker = worker;
    r->memory = aligned_alloc(TFA_CACHE_LINE, layout.request_bytes + layout.reply_bytes);
    int status = r->memory != NULL ? make_slots(r) : TFA_E_MEMORY;
    if (status == TFA_OK) {
        memset(r->memory, 0, layout.request_bytes + layout.reply_bytes);
        status = attach(r, robot);
    }
    if (status == TFA_OK)
        *result = r;
    else
        free_ring(r);
    return status;
}

void tfa_dds_ring_close(struct tfa_dds_ring *r)
{
    const struct timespec a_while = {.tv_nsec = 100000};

    if (r == NULL)
        return;
    while (!tfa_worker_detach(r->worker, r->client))
        nanosleep(&a_while, NULL);
    free_ring(r);
}

static dds_slot *slot_at(struct tfa_dds_ring *r, uint64_t index)
{
    return &r->slots[index & (r->ring.layout.slots - 1)];
}

dds_slot *tfa_dds_ring_next(struct tfa_dds_ring *r)
{
    return tfa_ring_full(&r->ring) ? NULL : slot_at(r, r->ring.sent);
}

void tfa_dds_ring_send(struct tfa_dds_ring *r)
{
    tfa_wire_request *line = tfa_ring_next_request(&r->ring);

    line->id = (uint64_t)(uintptr_t)&slot_at(r, r->ring.sent)->call;
    line->t_sent = (uint64_t)tfa_dds_monotonic();
    if (tfa_ring_send(&r->ring))
        tfa_worker_wake(r->worker);
}

dds_slot *tfa_dds_ring_oldest(struct tfa_dds_ring *r)
{
    return tfa_ring_reply_ready(&r->ring) ? slot_at(r, r->ring.received) : NULL;
}

void tfa_dds_ring_release(struct tfa_dds_ring *r)
{
    tfa_ring_release(&r->ring);
}

bool tfa_dds_ring_is_empty(const struct tfa_dds_ring *r)
{
    return r->ring.sent == r->ring.received;
}

void tfa_dds_ring_wait(const struct tfa_dds_ring *r, uint64_t timeout_ns)
{
    const uint64_t index = r->ring.received;
    const void *slot = r->ring.replies + tfa_ring_reply_offset(&r->ring.layout, index);
    const struct timespec time = {.tv_sec = (time_t)(timeout_ns / 1000000000u),
                                  .tv_nsec = (long)(timeout_ns % 1000000000u)};
    const uint64_t seq = tfa_ring_client_prepare_wait(&r->ring, index);

    if (seq <= index)
        (void)syscall(SYS_futex, tfa_ring_futex_word(slot), FUTEX_WAIT, (uint32_t)seq, &time, NULL,
                      0);
    tfa_ring_client_end_wait(&r->ring);
}
