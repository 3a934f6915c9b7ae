/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Long requests in a worker without a thread: what comes between their parts, and what does not.
 */
#include "local_client_calls.h"
#include "test.h"
#include "worker/worker_internal.h"

#define LONG 4 /* states */

/* A solver that takes its time: one state, then a pause. What happens in the pause is in
 * `in_pause`. */
typedef struct slow {
    uint32_t calls, states, pauses;
    void (*in_pause)(struct slow *s);
    tfa_worker *worker;
    tfa_local_client *other;
    uint64_t id;
    uint32_t answered; /* short requests, each within the pause in which it came */
    tfa_worker_robot next;
} slow;

static int add_slowly(void *self, const tfa_request *request, tfa_reply *reply,
                      const tfa_yield *yield)
{
    slow *s = self;
    s->calls++;
    assert_true((request->count > 1) == (yield != NULL));
    for (uint32_t k = 0; k < request->count; k++) {
        for (uint32_t i = 2 * k; i < 2 * k + 2; i++)
            reply->qdd[i] = request->q[i] + request->tau[i];
        s->states += yield != NULL;
        if (!yield || k + 1 == request->count)
            continue;
        s->pauses++;
        if (s->in_pause)
            s->in_pause(s);
        const uint32_t calls = s->calls;
        yield->serve_others(yield->context);
        if (s->in_pause && s->calls == calls + 1)
            s->answered++;
    }
    return TFA_OK;
}

static tfa_worker *make_worker(slow *s)
{
    const tfa_worker_robot robot = {.shape = {.q_count = 2, .v_count = 2, .max_batch = LONG},
                                    .solve = add_slowly,
                                    .self = s,
                                    .cut = 1};
    const tfa_worker_options options = {
        .robots = &robot, .robot_count = 1, .spin_ns = 20000, .wait = TFA_WAIT_BLOCK};
    assert_int_equal(tfa_worker_create(&options, &s->worker), TFA_OK);
    s->next = robot;
    return s->worker;
}

static void send_long(tfa_local_client *local_client, uint64_t id)
{
    static const double q[2 * LONG], tau[2 * LONG];
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS, .count = LONG, .q = q, .tau = tau};
    tfa_wire_reply_shape ask;
    assert_int_equal(tfa_wire_encode_request(&local_client->shape, &request,
                                             tfa_wire_want(&request, NULL), id, 0,
                                             tfa_ring_next_request(&local_client->ring), &ask),
                     TFA_OK);
    tfa_local_client_send(local_client);
}

static void receive_long(tfa_local_client *local_client, uint64_t id)
{
    assert_true(tfa_ring_reply_ready(&local_client->ring));
    const tfa_wire_reply *line = tfa_ring_oldest_reply(&local_client->ring);
    assert_int_equal(line->id, id);
    tfa_ring_release(&local_client->ring);
}

/* The reply to the last one must be there, before the long request goes on. */
static void send_short(slow *s)
{
    if (s->id)
        assert_true(receive_from(s->other, (double)s->id, s->id));
    s->id++;
    assert_int_equal(send_to(s->other, (double)s->id, s->id), TFA_OK);
}

/* A short request that comes during a long one waits for one part of it; a long one of another
 * client, and what the same client sent behind, for its end. */
TEST(short_requests_come_between)
{
    slow s = {.in_pause = send_short};
    tfa_local_client busy, other, rival;
    tfa_worker *worker = make_worker(&s);
    assert_int_equal(tfa_local_client_open(worker, 0, 8, LONG, &busy), TFA_OK);
    assert_int_equal(tfa_local_client_open(worker, 0, 8, 1, &other), TFA_OK);
    assert_int_equal(tfa_local_client_open(worker, 0, 8, LONG, &rival), TFA_OK);
    s.other = &other;
    send_long(&busy, 1);
    send_long(&busy, 2);
    send_long(&rival, 3);
    assert_int_equal(tfa_worker_cycle(worker), 2); /* one long request is a turn */
    assert_int_equal(s.states, 2 * LONG);
    assert_int_equal(s.pauses, 2 * (LONG - 1));
    assert_int_equal(s.answered, 2 * (LONG - 1));
    receive_long(&busy, 1);
    receive_long(&rival, 3);
    assert_false(tfa_ring_reply_ready(&busy.ring));
    assert_int_equal(tfa_worker_cycle(worker), 1);
    receive_long(&busy, 2);
    assert_int_equal(s.answered, 3 * (LONG - 1));
    assert_int_equal(tfa_worker_client_get_counters(other.client)->requests, s.answered);
    tfa_local_client_close(&busy);
    tfa_local_client_close(&other);
    tfa_local_client_close(&rival);
    tfa_worker_destroy(worker);
}

static void offer_again(slow *s)
{
    tfa_worker_offer(s->worker, &s->next);
    s->in_pause = NULL;
}

static bool took(const tfa_worker *w)
{
    return atomic_load(&w->taken) == atomic_load(&w->offer);
}

/* A long request is answered by one solver from its beginning to its end. */
TEST(long_requests_keep_their_solver)
{
    slow first = {.in_pause = offer_again}, second = {0};
    tfa_local_client busy;
    tfa_worker *worker = make_worker(&first);
    first.next.self = &second;
    assert_int_equal(tfa_local_client_open(worker, 0, 8, LONG, &busy), TFA_OK);
    send_long(&busy, 1);
    assert_int_equal(tfa_worker_cycle(worker), 1);
    assert_int_equal(first.states, LONG);
    assert_false(took(worker));
    send_long(&busy, 2);
    assert_int_equal(tfa_worker_cycle(worker), 1);
    assert_int_equal(second.states, LONG);
    assert_true(took(worker));
    tfa_local_client_close(&busy);
    tfa_worker_destroy(worker);
}
