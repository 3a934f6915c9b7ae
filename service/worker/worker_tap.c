/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Records of answered requests; and how a worker that runs gets taps and loses them.
 */
#include "worker/worker_tap.h"

#include <string.h>

#include "worker/worker_internal.h"

/* ---- records ---- */

static tfa_wire_reply_shape reply_shape_of(const tfa_tap_entry *e)
{
    const tfa_request *r = e->request;
    if (!tfa_wire_has_answers(e->reply->status)) /* the request may be anything */
        return (tfa_wire_reply_shape){0};
    tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(e->shape, r);
    shape.want &= e->request_copy ? e->want : tfa_wire_want(r, e->reply);
    return shape;
}

/* @return false: a slot of this shape does not hold it */
static bool write_request(const tfa_tap_entry *e, size_t bytes, void *slot)
{
    tfa_wire_request *line = slot;
    if (e->request_copy) {
        memcpy(slot, e->request_copy, bytes);
        if (e->reply->status != TFA_E_LATE && e->reply->status != TFA_E_PROTOCOL)
            line->estimate = (uint8_t)e->request->estimate;
    } else {
        tfa_wire_reply_shape unused;
        const uint64_t want = tfa_wire_want(e->request, e->reply);
        if (tfa_wire_encode_request(e->shape, e->request, want, e->id, e->t_sent, slot, &unused,
                                    NULL) != TFA_OK)
            return false;
    }
    atomic_store_explicit(&line->seq, 0, memory_order_relaxed); /* T1 publishes it */
    return true;
}

static void write_reply(const tfa_tap_entry *e, const tfa_wire_reply_shape *shape, size_t bytes,
                        void *slot)
{
    tfa_wire_reply *line = slot;
    if (e->reply_slot)
        memcpy((unsigned char *)slot + TFA_WIRE_LINE,
               (const unsigned char *)e->reply_slot + TFA_WIRE_LINE, bytes - TFA_WIRE_LINE);
    else
        tfa_wire_write_answers(e->shape, shape, e->reply, slot);
    memset(slot, 0, TFA_WIRE_LINE);
    tfa_wire_encode_reply(e->reply, shape->want, slot);
    line->id = e->id;
    line->t_received = e->t_received;
    line->t_start = e->t_start;
    line->t_done = e->t_done;
}

void tfa_tap_put(tfa_tap *tap, const tfa_tap_entry *e)
{
    const tfa_wire_reply_shape shape = reply_shape_of(e);
    const size_t request = e->request_copy ? tfa_wire_copied_bytes(e->shape, e->request_copy)
                                           : tfa_wire_request_bytes(e->shape, e->request),
                 reply = tfa_wire_reply_bytes(e->shape, &shape);
    const size_t bytes = sizeof(tfa_tap_record) + request + reply;
    tfa_tap_record *record = tfa_tap_reserve(tap, bytes);
    if (!record)
        return;
    unsigned char *const at = (unsigned char *)(record + 1);
    if (!write_request(e, request, at)) {
        tfa_tap_drop(tap);
        return;
    }
    write_reply(e, &shape, reply, at + request);
    *record = (tfa_tap_record){.bytes = (uint32_t)bytes,
                               .request_bytes = (uint32_t)request,
                               .reply_bytes = (uint32_t)reply,
                               .max_batch = e->shape->max_batch,
                               .max_tips = e->shape->max_tips,
                               .producer = tap->producer,
                               .estimate = (uint8_t)e->estimate};
    tfa_tap_publish(tap, bytes);
}

/* ---- the worker's thread ---- */

void tfa_worker_tap_put(tfa_tap *tap, const tfa_worker *w, tfa_worker_client *client)
{
    const worker_request *at = &client->at;
    const tfa_wire_request *line = client->scratch;
    tfa_tap_entry entry = {.shape = &client->shape,
                           .request = &at->request,
                           .reply = &at->reply,
                           .want = at->want,
                           .id = line->id,
                           .t_sent = line->t_sent,
                           .t_received = at->received,
                           .t_start = at->start,
                           .t_done = w->now};
    if (client->direct) {
        entry.id = 0; /* it is an address */
        entry.estimate = at->call->request.estimate;
    } else {
        entry.request_copy = client->scratch;
        entry.reply_slot = tfa_ring_reply(&client->ring);
        entry.estimate = (tfa_estimate)line->estimate;
    }
    tfa_tap_put(tap, &entry);
}

/* ---- other threads ---- */

void tfa_worker_set_tap(tfa_worker *w, uint32_t robot, tfa_tap *tap)
{
    tfa_robot_taps_set(&w->taps, robot, tap); /* A14, A15 */
    tfa_worker_wake(w);
}

bool tfa_worker_taps_are_taken(const tfa_worker *w)
{
    return tfa_robot_taps_are_taken(&w->taps) ||                                    /* R16 */
           atomic_load_explicit(&w->phase, memory_order_acquire) != WORKER_RUNNING; /* R10 */
}
