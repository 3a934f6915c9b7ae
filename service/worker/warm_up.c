/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker that spins keeps itself warm: it solves requests again that it answered, so that their
 * code, tables and workspaces stay in the caches nearest to its processor.
 *
 * Nothing observable follows. The request is the worker's private copy, the answers go to memory of
 * the worker's own, the solver leaves its policies alone; cost model, shares of time, counters,
 * heartbeats and rings are not touched. A request waits for one warm-up at most, which takes no
 * longer than a turn, and warm-ups together take a small share of the worker's time. A worker that
 * naps or sleeps does none.
 */
#include "worker_internal.h"

#include <stdlib.h>
#include <string.h>

/* A warm-up is followed by a pause of so many times its length, so that it delays few requests. */
#define PAUSE_LENGTHS 16
/* Requests of clients that have sent nothing for this time are not solved again. */
#define RECENT_NS 1000000000u

int tfa_worker_warm_up_init(worker_warm_up *warm_up, uint32_t period_ns)
{
    *warm_up = (worker_warm_up){.period_ns = period_ns};
    if (!period_ns)
        return TFA_OK;
    warm_up->reply = aligned_alloc(TFA_CACHE_LINE, TFA_WARM_UP_REPLY_BYTES);
    if (!warm_up->reply)
        return TFA_E_MEMORY;
    memset(warm_up->reply, 0, TFA_WARM_UP_REPLY_BYTES); /* no page fault later */
    return TFA_OK;
}

void tfa_worker_warm_up_keep(const tfa_worker *w, tfa_worker_client *client)
{
    const worker_request *at = &client->at;
    client->warm = w->warm_up.period_ns && !client->direct && at->robot->warm_up &&
                   tfa_wire_has_answers(at->reply.status) && at->spent_ns <= w->turn_ns;
}

void tfa_worker_warm_up_forget(tfa_worker *w)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    for (uint32_t i = 0; i < used; i++)
        if (atomic_load_explicit(&w->clients[i].state, memory_order_acquire) == CLIENT_ATTACHED)
            w->clients[i].warm = false; /* R6 */
}

void tfa_worker_warm_up_restart(tfa_worker *w)
{
    w->warm_up.due = w->now + w->warm_up.period_ns;
}

/* The next client with a request to solve again; NULL: none. */
static tfa_worker_client *find_client(tfa_worker *w)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    for (uint32_t k = 0; k < used; k++) {
        w->warm_up.client = w->warm_up.client + 1 < used ? w->warm_up.client + 1 : 0;
        tfa_worker_client *client = &w->clients[w->warm_up.client];
        if (atomic_load_explicit(&client->state, memory_order_acquire) ==
                CLIENT_ATTACHED && /* R6 */
            client->warm &&
            w->now - client->at.start < RECENT_NS)
            return client;
    }
    return NULL;
}

/* The way of a request from its private copy to the encoded reply, in the memory of the client's
 * request under way: there is none. @return false: the request is no ordinary one */
static bool solve_again(const tfa_worker *w, tfa_worker_client *client)
{
    const tfa_worker_robot *robot = &w->robots[client->robot];
    worker_request *at = &client->at;
    const tfa_wire_reply_shape *shape = &client->form.reply_shape;
    if (tfa_wire_reply_bytes(&client->shape, shape) > TFA_WARM_UP_REPLY_BYTES)
        return false;
    tfa_worker_move_reply(client, w->warm_up.reply);
    robot->warm_up(robot->self, &at->request, &at->reply);
    tfa_wire_encode_reply(&at->reply, shape->want, w->warm_up.reply);
    return true;
}

/* What the next request writes to besides. */
static void prefetch(const tfa_worker_client *client)
{
    __builtin_prefetch(client->at.cost, 1);
    __builtin_prefetch(&client->virtual_ns, 1);
    tfa_worker_prefetch_tally(client);
    tfa_ring_prefetch_for_write(tfa_ring_reply(&client->ring));
}

void tfa_worker_warm_up(tfa_worker *w)
{
    worker_warm_up *warm_up = &w->warm_up;
    if (!warm_up->period_ns || w->now < warm_up->due)
        return;
    tfa_worker_client *client = find_client(w);
    if (!client) {
        tfa_worker_warm_up_restart(w);
        return;
    }
    const uint64_t start = w->now;
    client->warm = solve_again(w, client);
    prefetch(client);
    w->now = tfa_worker_clock();
    const uint64_t took = w->now - start < w->turn_ns ? w->now - start : w->turn_ns;
    const uint64_t pause = PAUSE_LENGTHS * took;
    warm_up->due = w->now + (pause > warm_up->period_ns ? pause : warm_up->period_ns);
}
