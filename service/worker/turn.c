/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker's cycle: which client is served next, and one piece of work for it.
 */
#include "worker_internal.h"

#include <linux/futex.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "platform/sigbus.h"

/* Turns that a client gets ahead of the others after it was idle. */
#define CREDIT_TURNS 4
/* A drain ends after so much of the worker's time. */
#define DRAIN_NS 1000000000u
/* Between two heartbeats in the memory of clients */
#define BEAT_NS 10000000u

/* All that is counted of a request that was answered. */
static tfa_tally_request tally_of(const tfa_worker *w, const tfa_worker_client *client)
{
    const worker_request *at = &client->at;
    const tfa_wire_request *line = client->scratch;
    const bool has_answers = tfa_wire_has_answers(at->reply.status);
    return (tfa_tally_request){.status = at->reply.status,
                               .has_answers = has_answers,
                               .refined = has_answers && at->request.refine - 1 < TFA_MAX_REFINE,
                               .states = at->request.count,
                               .answers = has_answers ? at->reply.answers : NULL,
                               .busy_ns = at->spent_ns,
                               .sent = line->t_sent,
                               .received = at->received,
                               .start = at->start,
                               .done = w->now};
}

/* The last state of the robot, for readers of the statistics. Direct clients publish it
 * themselves: their arrays are theirs again. */
static void publish_state(const tfa_worker *w, const tfa_worker_client *client)
{
    const worker_request *at = &client->at;
    if (!client->self_test && tfa_wire_has_answers(at->reply.status))
        tfa_state_publish(&w->statistics.states[client->robot], &at->request, client->shape.q_count,
                          client->shape.base_freedoms != 0, w->now);
}

/* ---- other solvers ---- */

/* A request under way uses solvers other than these. */
static bool others_in_use(const tfa_worker *w, const tfa_worker_robot *robots)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    for (uint32_t i = 0; i < used; i++) {
        const tfa_worker_client *client = &w->clients[i];
        if (client->at.active && client->at.robot != &robots[client->robot])
            return true;
    }
    return false;
}

/* New requests use the solvers offered last; requests under way keep theirs. */
static void accept_offer(tfa_worker *w)
{
    const tfa_worker_robot *offer = atomic_load_explicit(&w->offer, memory_order_acquire); /* R12 */
    if (offer != w->robots) {
        tfa_worker_warm_up_forget(w);
        memset(w->costs, 0, w->robot_count * sizeof *w->costs); /* of other models */
    }
    w->robots = offer;
    if (offer != atomic_load_explicit(&w->taken, memory_order_relaxed) && !others_in_use(w, offer))
        atomic_store_explicit(&w->taken, offer, memory_order_release); /* A13 */
}

/* ---- clients ---- */

/* No more requests of this client. It may be leaving at the same moment: then it stays so. */
static void mark_broken(tfa_worker_client *client)
{
    uint32_t attached = CLIENT_ATTACHED;
    client->at.active = false;
    atomic_compare_exchange_strong_explicit(&client->state, &attached, CLIENT_BROKEN,
                                            memory_order_relaxed, memory_order_relaxed);
}

static void mark_detached(tfa_worker_client *client, uint32_t state)
{
    client->at.active = false;
    atomic_compare_exchange_strong_explicit(&client->state, &state, CLIENT_DETACHED,
                                            memory_order_release, memory_order_relaxed); /* A8 */
}

bool tfa_worker_client_has_work(const tfa_worker *w, const tfa_worker_client *client)
{
    if (client->at.active)
        return tfa_worker_long_may_go_on(w, client);
    return tfa_ring_poll_last(&client->ring) != TFA_RING_EMPTY;
}

/* The thread beside the worker has none of the client's requests. */
static bool is_settled(tfa_worker *w, tfa_worker_client *client)
{
    if (!client->at.active || client->at.place != REQUEST_AWAY)
        return true;
    if (!tfa_worker_long_may_go_on(w, client))
        return false;
    (void)tfa_worker_long_take_back(w, client);
    return true;
}

static bool waits_for_thread(const tfa_worker_client *client)
{
    return client->at.active && client->at.place == REQUEST_WAITING;
}

/* Whether an attached or draining client has work that may be done. */
static bool is_ready(tfa_worker *w, tfa_worker_client *client)
{
    if (client->at.active && !tfa_worker_long_may_go_on(w, client))
        return false;
    if (tfa_sigbus_is_lost(&client->lost)) {
        if (is_settled(w, client))
            mark_broken(client);
        return false;
    }
    if (client->at.active)
        return true;
    const tfa_ring_state state = tfa_ring_poll(&client->ring);
    if (state == TFA_RING_BROKEN)
        mark_broken(client);
    return state == TFA_RING_READY;
}

static bool is_draining(const tfa_worker_client *client)
{
    return atomic_load_explicit(&client->state, memory_order_relaxed) == CLIENT_DRAINING;
}

/* A client that is detached once its earlier requests are answered: no more than the ring holds. */
static bool is_drained(tfa_worker *w, tfa_worker_client *client)
{
    return client->drained >= client->ring.layout.slots || client->drain_ns > DRAIN_NS ||
           !(client->at.active || is_ready(w, client));
}

/* Lists the clients that have work. @return how many */
static uint32_t collect_ready(tfa_worker *w)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    uint32_t count = 0;
    for (uint32_t i = 0; i < used; i++) {
        tfa_worker_client *client = &w->clients[i];
        const uint32_t state = atomic_load_explicit(&client->state, memory_order_acquire);
        const bool leaves = state == CLIENT_DETACHING ||
                            (state == CLIENT_DRAINING && is_drained(w, client)); /* R7 */
        if (leaves && is_settled(w, client))
            mark_detached(client, state);
        else if (!leaves && (state == CLIENT_DRAINING || state == CLIENT_ATTACHED) &&
                 is_ready(w, client)) /* R6 */
            w->ready[count++] = client;
    }
    return count;
}

/* An idle client does not save up its time: it is a few turns ahead at most. */
static void limit_credit(const tfa_worker *w, uint32_t count)
{
    const uint64_t credit = (uint64_t)CREDIT_TURNS * w->turn_ns;
    const uint64_t least = w->virtual_clock > credit ? w->virtual_clock - credit : 0;
    for (uint32_t k = 0; k < count; k++)
        if (w->ready[k]->virtual_ns < least)
            w->ready[k]->virtual_ns = least;
}

static uint32_t least_served(const tfa_worker *w, uint32_t count)
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < count; k++)
        if (w->ready[k]->virtual_ns < w->ready[best]->virtual_ns)
            best = k;
    return best;
}

/* ---- requests ---- */

static bool is_late(const tfa_wire_request *line, uint64_t now)
{
    return line->deadline_us && now > line->t_sent &&
           now - line->t_sent > UINT64_C(1000) * line->deadline_us;
}

/* A request of another form than the last one. */
static __attribute__((noinline)) int decode_form(tfa_worker_client *client, void *slot)
{
    worker_request *at = &client->at;
    tfa_wire_reply_shape shape;
    client->form.bytes = 0;
    const int status = tfa_wire_decode_request(&client->shape, client->scratch, &at->request,
                                               &shape, &at->reply.field);
    at->want = shape.want;
    if (status != TFA_OK) {
        at->reply.index = tfa_wire_refused_index(&at->request, at->reply.field);
        return status;
    }
    tfa_wire_reply_buffers(&client->shape, &shape, slot, &at->reply);
    if (!at->reply.answers) /* for the statistics */
        at->reply.answers = client->answers;
    at->slot = slot;
    at->kind = tfa_cost_kind(&at->request);
    tfa_wire_keep_form(&client->shape, client->scratch, &shape, &client->form);
    return TFA_OK;
}

/* Decodes the private copy of a request. The buffers of the reply lie in its slot. */
static int decode_request(const tfa_worker *w, tfa_worker_client *client, bool same_form)
{
    worker_request *at = &client->at;
    void *slot = tfa_ring_reply(&client->ring);
    if (is_late(client->scratch, w->now))
        return TFA_E_LATE;
    if (!same_form)
        return decode_form(client, slot);
    tfa_wire_decode_again(&client->shape, client->scratch, &at->request);
    if (at->request.tip_count | at->request.payload_count | at->request.locked_count)
        at->kind = tfa_cost_kind(&at->request); /* links differ within a form */
    at->want = client->form.reply_shape.want;
    tfa_worker_move_reply(client, slot);
    return TFA_OK;
}

static int take_call(const tfa_worker *w, worker_request *at, uint64_t address)
{
    at->call = (tfa_worker_call *)(uintptr_t)address;
    at->request = at->call->request;
    at->reply = at->call->reply;
    at->reply.field = TFA_FIELD_NONE;
    at->kind = tfa_cost_kind(&at->request);
    return at->call->deadline && w->now > at->call->deadline ? TFA_E_LATE : TFA_OK;
}

/* Copies the next request into private memory. @return it has the form of the last one */
static bool copy_request(const tfa_worker_client *client)
{
    const void *slot = tfa_ring_request(&client->ring);
    if (client->direct) {
        memcpy(client->scratch, slot, TFA_WIRE_LINE);
        return false;
    }
    tfa_ring_prefetch_for_write(tfa_ring_reply(&client->ring));
    return tfa_wire_copy_request(&client->shape, &client->form, slot, client->scratch);
}

/* Takes the next request, which is there, out of the ring. @return false: the client's memory is
 * gone. Otherwise the status of its reply so far is that of its decoding. */
static bool begin_request(tfa_worker *w, tfa_worker_client *client, uint64_t cycle_start)
{
    worker_request *at = &client->at;
    client->warm = false; /* its copy is overwritten */
    tfa_worker_prefetch_tally(client);
    const tfa_wire_request *line = client->scratch;
    const bool same_form = copy_request(client);
    const uint64_t sent = line->t_sent;
    if (tfa_sigbus_is_lost(&client->lost))
        return false;
    if (sent > w->now) /* it came after the cycle began */
        w->now = tfa_worker_clock();
    at->active = true;
    at->place = REQUEST_HERE;
    at->first = 0;
    at->want = 0;
    at->spent_ns = 0;
    at->robot = &w->robots[client->robot];
    at->received = sent > cycle_start ? w->now : cycle_start;
    at->start = w->now;
    at->reply.field = TFA_FIELD_NONE;
    at->reply.index = at->reply.state = 0;
    at->reply.model = 0;
    at->reply.status =
        client->direct ? take_call(w, at, line->id) : decode_request(w, client, same_form);
    if (at->reply.status == TFA_OK) {
        at->cost = tfa_cost_find(&w->costs[client->robot], at->kind);
        at->reply.status = tfa_worker_admit(w, client);
    }
    return true;
}

/* Solves a part that fits a turn. @return the client's share of the time, ns */
static uint64_t solve_part(tfa_worker *w, tfa_worker_client *client)
{
    worker_request *at = &client->at;
    const uint32_t left = at->request.count - at->first, first = at->first;
    const uint32_t fit = left == 1 ? 1 : tfa_cost_states(at->cost, w->turn_ns); /* it divides */
    const uint32_t count = left < fit ? left : fit;
    const uint64_t before = w->now, expected = (uint64_t)at->cost->state_ns * count;
    at->reply.status =
        at->robot->solve(at->robot->self, &at->request, &at->reply, at->first, count);
    at->first += count;
    w->now = tfa_worker_clock();
    const uint64_t took = w->now - before;
    at->spent_ns += took;
    tfa_cost_record(at->cost, &at->reply, first, count, took);
    tfa_cost_owe(&client->debt, &at->reply, first, count, took, at->robot->max_state_ns, w->now);
    /* far beyond its cost, the time was lost to another program */
    const uint64_t most = 8 * expected + w->turn_ns;
    return took < most ? took : most;
}

/* From the thread beside the worker. @return the client's share, ns */
static uint64_t take_back(tfa_worker *w, tfa_worker_client *client)
{
    worker_request *at = &client->at;
    at->spent_ns = tfa_worker_long_take_back(w, client);
    w->now = tfa_worker_clock();
    tfa_cost_record(at->cost, &at->reply, 0, at->request.count, at->spent_ns);
    return at->spent_ns;
}

static void finish_call(const tfa_worker *w, const worker_request *at)
{
    tfa_worker_call *call = at->call;
    call->reply = at->reply;
    call->t_received = at->received;
    call->t_start = at->start;
    call->t_done = w->now;
}

/* Publishes the reply and counts the request: a reply to one state first, its answer copied before,
 * because the slot is in the client's cache then; the slot of a direct client is its own then.
 * @return the client waits */
static bool publish(const tfa_worker *w, tfa_worker_client *client)
{
    tfa_tally_request request = tally_of(w, client);
    tfa_shared_tally *tally = &client->shared->tally;
    tfa_answer answer;
    if (client->direct || request.states != 1) {
        tfa_tally_count(tally, &request);
        if (!client->direct)
            publish_state(w, client);
        return tfa_ring_publish(&client->ring);
    }
    if (request.answers) {
        answer = request.answers[0];
        request.answers = &answer;
    }
    const bool waits = tfa_ring_publish(&client->ring);
    tfa_tally_count(tally, &request);
    publish_state(w, client);
    return waits;
}

static void finish_request(const tfa_worker *w, tfa_worker_client *client)
{
    worker_request *at = &client->at;
    tfa_wire_reply *slot = tfa_ring_reply(&client->ring);
    const tfa_wire_request *line = client->scratch;
    if (client->direct) {
        finish_call(w, at);
    } else {
        tfa_wire_encode_reply(&at->reply, at->want, slot);
        slot->id = line->id;
        slot->t_received = at->received;
        slot->t_start = at->start;
        slot->t_done = w->now;
    }
    tfa_worker_tap_request(w, client);
    at->active = false;
    if (publish(w, client)) /* one thread waits for it */
        (void)syscall(SYS_futex, tfa_ring_futex_word(slot), FUTEX_WAKE, 1, NULL, NULL, 0);
}

/* A request, or a part of a long one. @return false: the client is broken */
static bool serve(tfa_worker *w, tfa_worker_client *client, uint64_t cycle_start)
{
    worker_request *at = &client->at;
    if (waits_for_thread(client)) { /* since another cycle: all that wait, in fair order */
        if (tfa_worker_long_may_go_on(w, client))
            tfa_worker_long_give(w, client);
        return true;
    }
    if (!at->active && !begin_request(w, client, cycle_start)) {
        mark_broken(client);
        return false;
    }
    if (waits_for_thread(client))
        return true;
    if (at->reply.status == TFA_OK || at->first) {
        /* meanwhile another kind may have taken its row */
        at->cost = tfa_cost_find(&w->costs[client->robot], at->kind);
        const uint64_t took = tfa_worker_cut_short(w, client) ? 0
                              : at->place == REQUEST_AWAY     ? take_back(w, client)
                                                              : solve_part(w, client);
        client->virtual_ns += took;
        client->drain_ns += is_draining(client) ? took : 0;
    }
    if (!tfa_wire_has_answers(at->reply.status) || at->first >= at->request.count) {
        finish_request(w, client);
        tfa_worker_warm_up_keep(w, client);
        client->drained += is_draining(client);
    }
    return true;
}

/* ---- the cycle ---- */

/* Requests in the ring; relaxed: it is a figure only. */
static uint32_t count_queued(const tfa_worker_client *client)
{
    const tfa_ring_server *ring = &client->ring;
    uint32_t count = client->at.active;
    for (uint64_t next = ring->next + count; count < ring->layout.slots; next++, count++) {
        const tfa_wire_request *line =
            (const void *)(ring->requests + tfa_ring_request_offset(&ring->layout, next));
        if (atomic_load_explicit(&line->seq, memory_order_relaxed) != next + 1)
            break;
    }
    return count;
}

/* A sign of life, for the control thread in each cycle, for clients now and then. */
static void beat(tfa_worker *w)
{
    atomic_store_explicit(&w->statistics.worker->heartbeat, ++w->beats, memory_order_relaxed);
    if (w->now - w->last_beat < BEAT_NS)
        return;
    w->last_beat = w->now;
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    for (uint32_t i = 0; i < used; i++) {
        const tfa_worker_client *client = &w->clients[i];
        if (atomic_load_explicit(&client->state, memory_order_acquire) != CLIENT_ATTACHED) /* R6 */
            continue;
        atomic_store_explicit(&tfa_ring_worker_status_of(&client->ring)->heartbeat, w->beats,
                              memory_order_relaxed); /* A5 */
        atomic_store_explicit(&client->shared->queued, count_queued(client), memory_order_relaxed);
    }
}

uint32_t tfa_worker_cycle(tfa_worker *w)
{
    uint32_t count = collect_ready(w), pieces = 0;
    accept_offer(w);               /* R12 after R6 */
    tfa_robot_taps_take(&w->taps); /* R15 after R12 */
    if (count) {
        const uint64_t start = w->now = tfa_worker_clock();
        limit_credit(w, count);
        do {
            const uint32_t k = least_served(w, count);
            tfa_worker_client *client = w->ready[k];
            if (client->virtual_ns > w->virtual_clock)
                w->virtual_clock = client->virtual_ns;
            pieces += serve(w, client, start);
            if (waits_for_thread(client) || /* in the next cycle, among all that do */
                !is_ready(w, client))
                w->ready[k] = w->ready[--count];
        } while (count && w->now - start < w->turn_ns);
    }
    beat(w);
    return pieces;
}
