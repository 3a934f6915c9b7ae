/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway's end of the internal ring: one local client of the worker for each robot.
 */
#include "dds_internal.h"

#include "worker/local_client.h"

#include <stdlib.h>

struct tfa_dds_ring {
    tfa_local_client local_client;
    /* of the request in each slot: decides the layout of its reply */
    tfa_wire_reply_shape *reply_shapes;
    uint64_t next_id;
};

int tfa_dds_ring_open(struct tfa_worker *worker, const dds_robot *robot, uint32_t slots,
                      struct tfa_dds_ring **result)
{
    struct tfa_dds_ring *ring = calloc(1, sizeof *ring);
    int status = TFA_E_MEMORY;

    *result = NULL;
    if (ring == NULL)
        return status;
    ring->reply_shapes = calloc(slots, sizeof *ring->reply_shapes);
    if (ring->reply_shapes == NULL)
        goto err_reply_shapes;
    status = tfa_local_client_open(worker, robot->index, slots, robot->shape.max_batch,
                                   &ring->local_client);
    if (status != TFA_OK)
        goto err_attach;
    *result = ring;
    return TFA_OK;

err_attach:
    free(ring->reply_shapes);
err_reply_shapes:
    free(ring);
    return status;
}

void tfa_dds_ring_close(struct tfa_dds_ring *ring)
{
    if (ring == NULL)
        return;
    tfa_local_client_close(&ring->local_client);
    free(ring->reply_shapes);
    free(ring);
}

int tfa_dds_ring_submit(struct tfa_dds_ring *ring, const tfa_request *request)
{
    tfa_ring_client *client = &ring->local_client.ring;
    tfa_wire_reply_shape reply_shape;

    if (tfa_ring_full(client))
        return TFA_E_AGAIN;
    const int status = tfa_wire_encode_request(
        &ring->local_client.shape, request, tfa_wire_want(request, NULL), ring->next_id,
        (uint64_t)tfa_dds_monotonic(), tfa_ring_next_request(client), &reply_shape);
    if (status != TFA_OK)
        return status;
    ring->next_id++;
    ring->reply_shapes[client->sent % client->layout.slots] = reply_shape;
    tfa_local_client_send(&ring->local_client);
    return TFA_OK;
}

bool tfa_dds_ring_peek(struct tfa_dds_ring *ring, dds_ring_answer *answer)
{
    const tfa_ring_client *client = &ring->local_client.ring;

    if (!tfa_ring_reply_ready(client))
        return false;
    const tfa_wire_reply *line = tfa_ring_oldest_reply(client);
    tfa_wire_reply_shape reply_shape = ring->reply_shapes[client->received % client->layout.slots];
    *answer = (dds_ring_answer){
        .t_start = (int64_t)line->t_start,
        .t_done = (int64_t)line->t_done,
    };
    reply_shape.want = tfa_wire_decode_reply(line, &answer->reply);
    /* The slot is ours until it is released, and it is only read: const may go. */
    tfa_wire_reply_buffers(&ring->local_client.shape, &reply_shape, (void *)(uintptr_t)line,
                           &answer->reply);
    return true;
}

void tfa_dds_ring_release(struct tfa_dds_ring *ring)
{
    tfa_ring_release(&ring->local_client.ring);
}

void tfa_dds_ring_wait(const struct tfa_dds_ring *ring, uint64_t index, uint64_t timeout_ns)
{
    (void)tfa_local_client_wait(&ring->local_client, index, timeout_ns);
}
