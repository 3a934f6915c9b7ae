/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker with a solver of our own: its cycle without a thread, then with threads on all sides.
 */
#include "worker/local_client.h"

#include "local_client_calls.h"
#include "platform/sigbus.h"
#include "support/wait.h"
#include "test.h"
#include "worker/worker_internal.h"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#define CLIENTS 3
#define EXCHANGES 3000
#define VISITS 40

/* The worker's clock: 1 us for each look at it, so that what the worker bounds by time it does
 * however seldom its thread runs. */
uint64_t tfa_worker_clock(void)
{
    static _Atomic uint64_t now = 1000000;
    return atomic_fetch_add(&now, 1000);
}

void tfa_worker_nap(uint64_t ns)
{
    (void)ns;
}

/* qdd = q + tau, or a refusal when op is not forward dynamics. */
static int add(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    uint32_t *calls = self;
    ++*calls;
    if (request->op != TFA_OP_FORWARD_DYNAMICS) {
        reply->field = TFA_FIELD_OP;
        return TFA_E_ARGUMENT;
    }
    for (uint32_t i = 2 * first; i < 2 * (first + count); i++)
        reply->qdd[i] = request->q[i] + request->tau[i];
    return TFA_OK;
}

typedef struct bench {
    tfa_worker *worker;
    uint32_t calls;
    pthread_t thread;
} bench;

static void close_bench(bench *b)
{
    tfa_worker_destroy(b->worker);
}
#define SCOPED_BENCH SCOPED(close_bench) bench

static void make_bench(bench *b, tfa_wait wait)
{
    const tfa_worker_robot robot = {
        .shape = {.q_count = 2, .v_count = 2, .max_batch = 4}, .solve = add, .self = &b->calls};
    const tfa_worker_options options = {
        .robots = &robot, .robot_count = 1, .spin_ns = 20000, .wait = wait};
    b->calls = 0;
    assert_int_equal(tfa_worker_create(&options, &b->worker), TFA_OK);
}

/* ---- without a thread ---- */

TEST(cycle_answers)
{
    SCOPED_BENCH b;
    SCOPED_LOCAL_CLIENT local_client;
    make_bench(&b, TFA_WAIT_BLOCK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 8, 4, &local_client), TFA_OK);
    assert_int_equal(tfa_worker_cycle(b.worker), 0);
    for (int i = 0; i < 50; i++) {
        assert_int_equal(send_to(&local_client, i, (uint64_t)i), TFA_OK);
        assert_false(tfa_ring_reply_ready(&local_client.ring));
        assert_int_equal(tfa_worker_cycle(b.worker), 1);
        assert_true(tfa_ring_reply_ready(&local_client.ring));
        assert_true(receive_from(&local_client, i, (uint64_t)i));
    }
    assert_int_equal(b.calls, 50);
    assert_int_equal(tfa_worker_client_sums(local_client.client).requests, 50);
    assert_int_equal(tfa_worker_heartbeat(b.worker), 51);
}

/* A client with a full ring does not keep another waiting for more than one request. */
TEST(turns_are_bounded)
{
    SCOPED_BENCH b;
    SCOPED_LOCAL_CLIENT greedy, modest;
    make_bench(&b, TFA_WAIT_BLOCK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 64, 1, &greedy), TFA_OK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 1, 1, &modest), TFA_OK);
    for (uint64_t i = 0; i < 64; i++)
        assert_int_equal(send_to(&greedy, 1, i), TFA_OK);
    assert_int_equal(send_to(&greedy, 1, 64), TFA_E_AGAIN);
    assert_int_equal(send_to(&modest, 2, 5), TFA_OK);
    uint32_t all = 0;
    for (uint32_t n; (n = tfa_worker_cycle(b.worker)) != 0;)
        all += n;
    assert_int_equal(all, 65);
    tfa_ring_release(&greedy.ring);
    const tfa_wire_reply *own = tfa_ring_oldest_reply(&modest.ring);
    const tfa_wire_reply *second = tfa_ring_oldest_reply(&greedy.ring);
    assert_true(own->t_done <= second->t_start);
    assert_true(receive_from(&modest, 2, 5));
}

TEST(refusals_are_counted)
{
    SCOPED_BENCH b;
    SCOPED_LOCAL_CLIENT local_client;
    tfa_wire_reply_shape ask;
    tfa_reply reply;
    const tfa_request wrong = {.op = TFA_OP_MASS_MATRIX, .count = 1};
    make_bench(&b, TFA_WAIT_BLOCK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 2, 1, &local_client), TFA_OK);
    assert_int_equal(tfa_wire_encode_request(&local_client.shape, &wrong, 0, 9, 0,
                                             tfa_ring_next_request(&local_client.ring), &ask, NULL),
                     TFA_OK);
    tfa_local_client_send(&local_client);
    /* a robot of another size: refused before the solver sees it */
    tfa_wire_request *line = tfa_ring_next_request(&local_client.ring);
    assert_int_equal(
        tfa_wire_encode_request(&local_client.shape, &wrong, 0, 10, 0, line, &ask, NULL), TFA_OK);
    line->dof++;
    tfa_local_client_send(&local_client);
    uint32_t served = 0;
    for (uint32_t n; (n = tfa_worker_cycle(b.worker)) != 0;)
        served += n;
    assert_int_equal(served, 2);
    assert_int_equal(tfa_wire_decode_reply(tfa_ring_oldest_reply(&local_client.ring), &reply), 0);
    assert_int_equal(reply.status, TFA_E_ARGUMENT);
    assert_int_equal(reply.field, TFA_FIELD_OP);
    tfa_ring_release(&local_client.ring);
    (void)tfa_wire_decode_reply(tfa_ring_oldest_reply(&local_client.ring), &reply);
    assert_int_equal(reply.status, TFA_E_PROTOCOL);
    assert_int_equal(b.calls, 1);
    assert_int_equal(tfa_worker_client_sums(local_client.client).rejected, 2);
}

TEST(broken_window_ends_the_client)
{
    SCOPED_BENCH b;
    SCOPED_LOCAL_CLIENT bad, good;
    make_bench(&b, TFA_WAIT_BLOCK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 4, 1, &bad), TFA_OK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 4, 1, &good), TFA_OK);
    tfa_wire_request *line = tfa_ring_next_request(&bad.ring);
    atomic_store(&line->seq, 77);
    assert_int_equal(send_to(&good, 3, 1), TFA_OK);
    assert_int_equal(tfa_worker_cycle(b.worker), 1);
    assert_true(tfa_worker_client_is_broken(bad.client));
    assert_false(tfa_worker_client_is_broken(good.client));
    atomic_store(&line->seq, 1); /* too late to be good again */
    assert_int_equal(tfa_worker_cycle(b.worker), 0);
}

TEST(client_entries_run_out_and_come_back)
{
    SCOPED_BENCH b;
    tfa_local_client *ports = calloc(TFA_WORKER_CLIENTS_MAX + 1, sizeof *ports);
    make_bench(&b, TFA_WAIT_BLOCK);
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < TFA_WORKER_CLIENTS_MAX; i++)
            assert_int_equal(tfa_local_client_open(b.worker, 0, 1, 1, &ports[i]), TFA_OK);
        assert_int_equal(tfa_local_client_open(b.worker, 0, 1, 1, &ports[TFA_WORKER_CLIENTS_MAX]),
                         TFA_E_REFUSED);
        for (int i = 0; i < TFA_WORKER_CLIENTS_MAX; i++)
            tfa_local_client_close(&ports[i]);
    }
    assert_int_equal(tfa_local_client_open(b.worker, 1, 1, 1, &ports[0]), TFA_E_ROBOT);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 3, 1, &ports[0]), TFA_E_SIZE);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 1, 5, &ports[0]), TFA_E_SIZE);
    free(ports);
}

TEST(sleep_ends_for_requests_and_kicks)
{
    SCOPED_BENCH b;
    SCOPED_LOCAL_CLIENT local_client;
    make_bench(&b, TFA_WAIT_BLOCK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 1, 1, &local_client), TFA_OK);
    tfa_worker_sleep(b.worker, -1); /* the wake-up of attach */
    assert_int_equal(send_to(&local_client, 1, 1), TFA_OK);
    tfa_worker_sleep(b.worker, -1); /* would hang if the recheck missed the request */
    assert_int_equal(tfa_worker_cycle(b.worker), 1);
    tfa_worker_wake(b.worker);
    tfa_worker_sleep(b.worker, -1);
}

/* ---- with threads ---- */

static void *worker_thread(void *worker)
{
    tfa_worker_run(worker);
    return NULL;
}

/* Waits: looks, then sleeps as long as a test waits for anything: a lost wake-up runs into the
 * limit of the test. */
static bool wait_for(tfa_local_client *local_client)
{
    for (int i = 0; i < 64; i++)
        if (tfa_ring_reply_ready(&local_client->ring))
            return true;
    const uint64_t index = local_client->ring.received;
    return WAIT_FOR(tfa_local_client_wait(local_client, index, WAIT_NS));
}

static void *client(void *argument)
{
    tfa_local_client *local_client = argument;
    uint64_t sent = 0, received = 0;
    while (received < EXCHANGES) {
        while (sent < EXCHANGES && send_to(local_client, (double)sent, sent) == TFA_OK)
            sent++;
        if (!wait_for(local_client) || !receive_from(local_client, (double)received, received))
            return (void *)1;
        received++;
    }
    return NULL;
}

/* Comes, asks once, goes: the client changes hands while the worker runs. */
static void *visitor(void *argument)
{
    tfa_worker *worker = argument;
    for (uint64_t i = 0; i < VISITS; i++) {
        tfa_local_client local_client;
        if (tfa_local_client_open(worker, 0, 2, 1, &local_client) != TFA_OK)
            return (void *)1;
        if (send_to(&local_client, 5, i) != TFA_OK ||
            (i % 2 && !(wait_for(&local_client) && receive_from(&local_client, 5, i))))
            return (void *)1;
        tfa_local_client_close(&local_client); /* every other time with a request under way */
    }
    return NULL;
}

static void threads(tfa_wait wait)
{
    SCOPED_BENCH b;
    tfa_local_client ports[CLIENTS];
    pthread_t clients[CLIENTS], guest;
    void *result;
    make_bench(&b, wait);
    assert_int_equal(pthread_create(&b.thread, NULL, worker_thread, b.worker), 0);
    for (uint32_t i = 0; i < CLIENTS; i++) {
        assert_int_equal(tfa_local_client_open(b.worker, 0, 1u << i, 1, &ports[i]), TFA_OK);
        assert_int_equal(pthread_create(&clients[i], NULL, client, &ports[i]), 0);
    }
    assert_int_equal(pthread_create(&guest, NULL, visitor, b.worker), 0);
    for (uint32_t i = 0; i < CLIENTS; i++) {
        pthread_join(clients[i], &result);
        assert_null(result);
    }
    pthread_join(guest, &result);
    assert_null(result);
    for (uint32_t i = 0; i < CLIENTS; i++) {
        assert_int_equal(tfa_worker_client_sums(ports[i].client).requests, EXCHANGES);
        tfa_local_client_close(&ports[i]);
    }
    tfa_worker_stop(b.worker);
    pthread_join(b.thread, NULL);
}

TEST(threads_hybrid)
{
    threads(TFA_WAIT_HYBRID);
}

TEST(threads_block)
{
    threads(TFA_WAIT_BLOCK);
}

/* What is in the rings when the end comes is answered. */
TEST(stop_drains)
{
    SCOPED_BENCH b;
    SCOPED_LOCAL_CLIENT local_client;
    make_bench(&b, TFA_WAIT_BLOCK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 64, 1, &local_client), TFA_OK);
    for (uint64_t i = 0; i < 64; i++)
        assert_int_equal(send_to(&local_client, 1, i), TFA_OK);
    tfa_worker_stop(b.worker);
    assert_int_equal(pthread_create(&b.thread, NULL, worker_thread, b.worker), 0);
    pthread_join(b.thread, NULL);
    for (uint64_t i = 0; i < 64; i++) {
        assert_true(tfa_ring_reply_ready(&local_client.ring));
        assert_true(receive_from(&local_client, 1, i));
    }
}

/* ---- other solvers, and clients that have to go ---- */

#define OFFERS 300

/* One of many solvers: it must not be asked once the worker took another. */
typedef struct one_of {
    uint32_t calls;
    bool retired, asked_late;
    _Atomic bool *hold; /* it waits as long as this is set */
} one_of;

static int add_once(void *self, tfa_request *request, tfa_reply *reply, uint32_t first,
                    uint32_t count)
{
    one_of *me = self;
    if (me->retired)
        return TFA_E_SYSTEM;
    while (me->hold && atomic_load(me->hold))
        sched_yield();
    return add(&me->calls, request, reply, first, count);
}

static void add_again(void *self, const tfa_request *request, tfa_reply *reply)
{
    one_of *me = self;
    me->asked_late = me->asked_late || me->retired;
    reply->qdd[0] = request->q[0];
}

static tfa_worker_robot served_by(one_of *one)
{
    return (tfa_worker_robot){.shape = {.q_count = 2, .v_count = 2, .max_batch = 4},
                              .solve = add_once,
                              .warm_up = add_again,
                              .self = one};
}

static void make_bench_of(bench *b, one_of *one)
{
    const tfa_worker_robot robot = served_by(one);
    const tfa_worker_options options = {.robots = &robot,
                                        .robot_count = 1,
                                        .spin_ns = 20000,
                                        .warm_ns = 1,
                                        .wait = TFA_WAIT_HYBRID};
    assert_int_equal(tfa_worker_create(&options, &b->worker), TFA_OK);
}

/* The cycle after an offer answers with it, and without requests takes it all the same. */
TEST(offers_are_taken)
{
    SCOPED_BENCH b;
    one_of ones[3] = {{0}};
    SCOPED_LOCAL_CLIENT local_client;
    make_bench_of(&b, &ones[0]);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 4, 1, &local_client), TFA_OK);
    for (uint32_t i = 0; i < 3; i++) {
        const tfa_worker_robot robot = served_by(&ones[i]);
        if (i)
            tfa_worker_offer(b.worker, &robot);
        assert_int_equal(send_to(&local_client, i, i), TFA_OK);
        assert_int_equal(tfa_worker_cycle(b.worker), 1);
        assert_int_equal(ones[i].calls, 1);
        assert_true(receive_from(&local_client, i, i));
    }
}

/* Clients ask all the time; each solver is spoilt as soon as the worker says that it took the next.
 * ThreadSanitizer sees to it that this is an order and not luck. */
TEST(offers_while_asked)
{
    SCOPED_BENCH b;
    one_of *ones = calloc(OFFERS, sizeof *ones);
    tfa_local_client ports[CLIENTS];
    pthread_t clients[CLIENTS];
    void *result;
    make_bench_of(&b, &ones[0]);
    assert_int_equal(pthread_create(&b.thread, NULL, worker_thread, b.worker), 0);
    for (uint32_t i = 0; i < CLIENTS; i++) {
        assert_int_equal(tfa_local_client_open(b.worker, 0, 8, 1, &ports[i]), TFA_OK);
        assert_int_equal(pthread_create(&clients[i], NULL, client, &ports[i]), 0);
    }
    for (uint32_t i = 1; i < OFFERS; i++) {
        const tfa_worker_robot robot = served_by(&ones[i]);
        tfa_worker_offer(b.worker, &robot);
        while (!tfa_worker_offer_is_taken(b.worker))
            sched_yield();
        ones[i - 1].retired = true;
    }
    for (uint32_t i = 0; i < CLIENTS; i++) {
        pthread_join(clients[i], &result);
        assert_null(result); /* every answer is right */
        tfa_local_client_close(&ports[i]);
    }
    tfa_worker_stop(b.worker);
    pthread_join(b.thread, NULL);
    uint32_t calls = 0;
    for (uint32_t i = 0; i < OFFERS; i++) {
        calls += ones[i].calls;
        assert_false(ones[i].asked_late);
    }
    assert_int_equal(calls, CLIENTS * EXCHANGES);
    free(ones);
}

/* What a client sent before it has to go is answered; another is not disturbed. */
TEST(drained_clients)
{
    SCOPED_BENCH b;
    _Atomic bool hold = false;
    one_of one = {.hold = &hold};
    tfa_local_client local_client, other;
    make_bench_of(&b, &one);
    assert_int_equal(pthread_create(&b.thread, NULL, worker_thread, b.worker), 0);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 16, 1, &local_client), TFA_OK);
    assert_int_equal(tfa_local_client_open(b.worker, 0, 1, 1, &other), TFA_OK);
    assert_int_equal(send_to(&other, 2, 0), TFA_OK); /* answered: the thread runs */
    assert_true(wait_for(&other) && receive_from(&other, 2, 0));
    atomic_store(&hold, true);
    for (uint64_t i = 0; i < 16; i++)
        assert_int_equal(send_to(&local_client, (double)i, i), TFA_OK);
    assert_false(tfa_worker_drain(b.worker, local_client.client));
    assert_false(tfa_worker_drain(b.worker, local_client.client));
    atomic_store(&hold, false);
    while (!tfa_worker_drain(b.worker, local_client.client))
        sched_yield();
    local_client.client = NULL;
    for (uint64_t i = 0; i < 16; i++) {
        assert_true(tfa_ring_reply_ready(&local_client.ring));
        assert_true(receive_from(&local_client, (double)i, i));
    }
    assert_int_equal(send_to(&other, 3, 1), TFA_OK);
    assert_true(wait_for(&other) && receive_from(&other, 3, 1));
    tfa_local_client_close(&other);
    tfa_worker_stop(b.worker);
    pthread_join(b.thread, NULL);
    free(local_client.memory);
}
