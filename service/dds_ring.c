/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS door's end of the internal ring: one port of the worker for each robot.
 */
#include "dds_internal.h"

#include "worker.h"

#include <stdlib.h>

struct tfa_dds_ring {
    tfa_port port;
    tfa_wire_ask *asks; /* of the request in each slot: decides the layout of its reply */
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
    ring->asks = calloc(slots, sizeof *ring->asks);
    if (ring->asks == NULL)
        goto err_asks;
    status = tfa_port_open(worker, robot->index, slots, robot->shape.max_batch, &ring->port);
    if (status != TFA_OK)
        goto err_port;
    *result = ring;
    return TFA_OK;

err_port:
    free(ring->asks);
err_asks:
    free(ring);
    return status;
}

void tfa_dds_ring_close(struct tfa_dds_ring *ring)
{
    if (ring == NULL)
        return;
    tfa_port_close(&ring->port);
    free(ring->asks);
    free(ring);
}

int tfa_dds_ring_submit(struct tfa_dds_ring *ring, const tfa_request *request)
{
    tfa_ring_client *client = &ring->port.ring;
    tfa_wire_ask ask;

    if (tfa_ring_full(client))
        return TFA_E_AGAIN;
    const int status = tfa_wire_encode_request(
        &ring->port.shape, request, tfa_wire_want(request, NULL), ring->next_id,
        (uint64_t)tfa_dds_monotonic(), tfa_ring_next_request(client), &ask);
    if (status != TFA_OK)
        return status;
    ring->next_id++;
    ring->asks[client->sent % client->layout.slots] = ask;
    tfa_port_send(&ring->port);
    return TFA_OK;
}

bool tfa_dds_ring_look(struct tfa_dds_ring *ring, dds_ring_answer *answer)
{
    const tfa_ring_client *client = &ring->port.ring;

    if (!tfa_ring_reply_ready(client))
        return false;
    const tfa_wire_reply *line = tfa_ring_oldest_reply(client);
    tfa_wire_ask ask = ring->asks[client->received % client->layout.slots];
    *answer = (dds_ring_answer){
        .t_start = (int64_t)line->t_start,
        .t_done = (int64_t)line->t_done,
    };
    ask.want = tfa_wire_decode_reply(line, &answer->reply);
    /* The slot is ours until it is released, and it is only read: const may go. */
    tfa_wire_reply_buffers(&ring->port.shape, &ask, (void *)(uintptr_t)line, &answer->reply);
    return true;
}

void tfa_dds_ring_release(struct tfa_dds_ring *ring)
{
    tfa_ring_release(&ring->port.ring);
}

void tfa_dds_ring_wait(const struct tfa_dds_ring *ring, uint64_t index, uint64_t timeout_ns)
{
    (void)tfa_port_wait(&ring->port, index, timeout_ns);
}
