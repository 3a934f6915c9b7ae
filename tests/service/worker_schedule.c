/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scheduling of a worker without a thread, on a clock of the test: shares of time, parts of long
 * requests, deadlines.
 */
#include "local_client_calls.h"
#include "test.h"
#include "worker/worker_internal.h"

#define TURN_NS 20000
#define STATES 4096 /* of the largest batch */
#define CLIENTS 32

/* The worker's clock. A solver is the only thing that takes time. */
static uint64_t now_ns, napped_ns, longest_nap_ns;

uint64_t tfa_worker_clock(void)
{
    return now_ns;
}

void tfa_worker_nap(uint64_t ns)
{
    now_ns += ns;
    napped_ns += ns;
    longest_nap_ns = ns > longest_nap_ns ? ns : longest_nap_ns;
}

/* qdd = q + tau, in so many ns a state. */
typedef struct timed_solver {
    uint64_t state_ns;
    uint64_t calls, states, longest_ns;
} timed_solver;

static int solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    timed_solver *s = self;
    for (uint32_t i = 2 * first; i < 2 * (first + count); i++)
        reply->qdd[i] = request->q[i] + request->tau[i];
    const uint64_t ns = count * s->state_ns;
    now_ns += ns;
    s->calls++;
    s->states += count;
    s->longest_ns = ns > s->longest_ns ? ns : s->longest_ns;
    return TFA_OK;
}

static tfa_worker_robot robot_of(timed_solver *s)
{
    return (tfa_worker_robot){
        .shape = {.q_count = 2, .v_count = 2, .max_batch = STATES}, .solve = solve, .self = s};
}

static tfa_worker *make_worker(timed_solver *s)
{
    const tfa_worker_robot robot = robot_of(s);
    const tfa_worker_options options = {
        .robots = &robot, .robot_count = 1, .turn_ns = TURN_NS, .wait = TFA_WAIT_BLOCK};
    tfa_worker *worker;
    assert_int_equal(tfa_worker_create(&options, &worker), TFA_OK);
    return worker;
}

static void open_client(tfa_worker *worker, uint32_t max_batch, tfa_local_client *client)
{
    assert_int_equal(tfa_local_client_open(worker, 0, 8, max_batch, client), TFA_OK);
}

static tfa_wire_request *write_batch(tfa_local_client *client, uint32_t states, uint64_t id)
{
    static double q[2 * STATES], tau[2 * STATES];
    const tfa_request request = {
        .op = TFA_OP_FORWARD_DYNAMICS, .count = states, .q = q, .tau = tau};
    tfa_wire_reply_shape shape;
    tfa_wire_request *line = tfa_ring_next_request(&client->ring);
    for (uint32_t i = 0; i < 2 * STATES; i++)
        q[i] = i;
    assert_int_equal(tfa_wire_encode_request(&client->shape, &request,
                                             tfa_wire_want(&request, NULL), id, 0, line, &shape,
                                             NULL),
                     TFA_OK);
    return line;
}

static void send_batch(tfa_local_client *client, uint32_t states, uint64_t id)
{
    (void)write_batch(client, states, id);
    tfa_local_client_send(client);
}

/* Sends again what was answered, so that the client always has work. @return states answered */
static uint64_t keep_asking(tfa_local_client *client, uint32_t states)
{
    uint64_t answered = 0;
    while (tfa_ring_reply_ready(&client->ring)) {
        tfa_ring_release(&client->ring);
        answered += states;
    }
    while (!tfa_ring_full(&client->ring))
        send_batch(client, states, 0);
    return answered;
}

/* A batch is answered in parts of a turn, and rightly. */
TEST(batches_are_cut_by_cost)
{
    timed_solver s = {.state_ns = 500};
    SCOPED_WORKER *worker = make_worker(&s);
    SCOPED_LOCAL_CLIENT client;
    open_client(worker, STATES, &client);
    send_batch(&client, STATES, 7);
    while (tfa_worker_cycle(worker))
        ;
    assert_int_equal(s.states, STATES);
    assert_true(s.longest_ns <= TURN_NS);
    assert_true(s.calls < 2 * STATES * s.state_ns / TURN_NS); /* parts are no shorter than needed */
    const tfa_wire_reply *line = tfa_ring_oldest_reply(&client.ring);
    const tfa_wire_reply_shape shape = {.count = STATES,
                                        .want = 1u << TFA_WIRE_ANSWERS | 1u << TFA_WIRE_OUT_QDD};
    static double qdd[2 * STATES];
    tfa_reply reply = {.qdd = qdd};
    assert_int_equal(line->id, 7);
    tfa_wire_copy_answers(&client.shape, &shape, line, &reply);
    for (uint32_t i = 0; i < 2 * STATES; i++)
        assert_true(qdd[i] == i);
    tfa_ring_release(&client.ring);
}

/* A worker that is never idle leaves the kernel its part of every second, in rests of less than the
 * 50 ms after which the kernel would stop it; one without a rest takes all. */
TEST(a_flood_does_not_end_in_throttling)
{
    for (uint32_t rest_ns = 0; rest_ns <= 66000; rest_ns += 66000) {
        timed_solver s = {.state_ns = 70000};
        const tfa_worker_robot robot = robot_of(&s);
        const tfa_worker_options options = {.robots = &robot,
                                            .robot_count = 1,
                                            .turn_ns = TURN_NS,
                                            .rest_ns = rest_ns,
                                            .wait = TFA_WAIT_BLOCK};
        SCOPED_WORKER *worker;
        assert_int_equal(tfa_worker_create(&options, &worker), TFA_OK);
        SCOPED_LOCAL_CLIENT client;
        open_client(worker, STATES, &client);
        for (int second = 0; second < 2; second++) {
            const uint64_t start = now_ns, napped = napped_ns;
            longest_nap_ns = 0;
            while (now_ns - start < 1000000000) {
                (void)keep_asking(&client, 1);
                (void)tfa_worker_cycle(worker);
                tfa_worker_rest(worker);
            }
            assert_int_equal(napped_ns - napped >= 50000000, rest_ns > 0);
            assert_true(longest_nap_ns < 200000);
        }
    }
}

/* States that suddenly cost a hundred times as much are noticed at the next part. */
TEST(cost_follows_the_clock)
{
    timed_solver s = {.state_ns = 100};
    SCOPED_WORKER *worker = make_worker(&s);
    SCOPED_LOCAL_CLIENT client;
    open_client(worker, STATES, &client);
    send_batch(&client, STATES, 1);
    while (tfa_worker_cycle(worker))
        ;
    s = (timed_solver){.state_ns = 10000};
    send_batch(&client, STATES, 2);
    (void)tfa_worker_cycle(worker); /* the one part that was cut too long */
    s.longest_ns = 0;
    while (tfa_worker_cycle(worker))
        ;
    assert_true(s.longest_ns <= TURN_NS);
}

/* Attackers with batches of every size, and one client with a single state now and then: it waits
 * for one turn at most. */
TEST(a_polite_client_waits_for_one_turn)
{
    static const uint32_t sizes[] = {1, 31, 32, 33, 257, STATES};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        timed_solver s = {.state_ns = 600};
        SCOPED_WORKER *worker = make_worker(&s);
        tfa_local_client attackers[CLIENTS - 1], polite;
        for (int i = 0; i < CLIENTS - 1; i++)
            open_client(worker, STATES, &attackers[i]);
        open_client(worker, 1, &polite);
        uint64_t longest = 0;
        for (uint64_t id = 0; id < 300; id++) {
            for (int cycle = 0; cycle < 3; cycle++) {
                for (int i = 0; i < CLIENTS - 1; i++)
                    (void)keep_asking(&attackers[i], sizes[k]);
                (void)tfa_worker_cycle(worker);
            }
            const uint64_t sent = now_ns;
            assert_int_equal(send_to(&polite, (double)id, id), TFA_OK);
            while (!tfa_ring_reply_ready(&polite.ring)) {
                for (int i = 0; i < CLIENTS - 1; i++)
                    (void)keep_asking(&attackers[i], sizes[k]);
                (void)tfa_worker_cycle(worker);
            }
            const tfa_wire_reply *line = tfa_ring_oldest_reply(&polite.ring);
            const uint64_t waited = line->t_done - sent;
            if (id > 10 && waited > longest)
                longest = waited;
            assert_true(receive_from(&polite, (double)id, id));
        }
        if (longest > TURN_NS + 2 * s.state_ns)
            fail_msg("beside batches of %u states: %llu ns", sizes[k], (unsigned long long)longest);
        for (int i = 0; i < CLIENTS - 1; i++)
            tfa_local_client_close(&attackers[i]);
        tfa_local_client_close(&polite);
    }
}

/* Clients that always have work get the same time, whatever the size of their requests. */
TEST(shares_are_equal_in_time)
{
    static const uint32_t sizes[] = {8, 16, 32, 500, STATES};
    enum { COUNT = sizeof sizes / sizeof *sizes };
    timed_solver s = {.state_ns = 400};
    SCOPED_WORKER *worker = make_worker(&s);
    tfa_local_client client[COUNT];
    uint64_t states[COUNT] = {0};
    for (int i = 0; i < COUNT; i++)
        open_client(worker, STATES, &client[i]);
    for (int cycle = 0; cycle < 40000; cycle++) {
        for (int i = 0; i < COUNT; i++)
            states[i] += keep_asking(&client[i], sizes[i]);
        (void)tfa_worker_cycle(worker);
    }
    for (int i = 0; i < COUNT; i++) {
        const double share = (double)states[i] * COUNT / (double)s.states;
        if (share < 0.9 || share > 1.1)
            fail_msg("batches of %u states: %.2f of a fair share", sizes[i], share);
        tfa_local_client_close(&client[i]);
    }
}

static bool took(const tfa_worker *w)
{
    return atomic_load(&w->taken) == atomic_load(&w->offer);
}

/* A long request is answered by one solver from its beginning to its end; others take the new one
 * meanwhile. */
TEST(long_requests_keep_their_solver)
{
    timed_solver first = {.state_ns = 500}, second = {.state_ns = 500};
    SCOPED_WORKER *worker = make_worker(&first);
    const tfa_worker_robot next = robot_of(&second);
    SCOPED_LOCAL_CLIENT busy, other;
    open_client(worker, STATES, &busy);
    open_client(worker, 1, &other);
    send_batch(&busy, STATES, 1);
    (void)tfa_worker_cycle(worker);
    tfa_worker_offer(worker, &next);
    assert_int_equal(send_to(&other, 3, 3), TFA_OK);
    (void)tfa_worker_cycle(worker);
    assert_true(receive_from(&other, 3, 3));
    assert_int_equal(second.states, 1);
    assert_false(took(worker));
    while (tfa_worker_cycle(worker))
        ;
    assert_int_equal(first.states, STATES);
    assert_int_equal(second.states, 1);
    assert_true(took(worker));
}

/* A client that is detached in the middle of a long request leaves nothing under way. */
TEST(detached_in_the_middle)
{
    timed_solver s = {.state_ns = 500}, second = {.state_ns = 500};
    SCOPED_WORKER *worker = make_worker(&s);
    const tfa_worker_robot next = robot_of(&second);
    tfa_local_client busy;
    open_client(worker, STATES, &busy);
    send_batch(&busy, STATES, 1);
    (void)tfa_worker_cycle(worker);
    tfa_worker_offer(worker, &next);
    atomic_store(&worker->phase, WORKER_RUNNING);
    assert_false(tfa_worker_detach(worker, busy.client));
    (void)tfa_worker_cycle(worker);
    assert_true(took(worker));
    assert_true(tfa_worker_detach(worker, busy.client));
    atomic_store(&worker->phase, WORKER_IDLE);
    free(busy.memory);
}

/* A request whose deadline passed is refused by name and costs nothing; one in time is answered. */
TEST(late_requests_are_refused)
{
    timed_solver s = {.state_ns = 50000};
    SCOPED_WORKER *worker = make_worker(&s);
    SCOPED_LOCAL_CLIENT busy, hurried;
    open_client(worker, STATES, &busy);
    open_client(worker, 1, &hurried);
    send_batch(&busy, 1, 1);
    for (uint64_t id = 0; id < 2; id++) {
        tfa_wire_request *line = write_batch(&hurried, 1, id);
        line->t_sent = now_ns + 1000;
        line->deadline_us = id ? 100 : 10;
        tfa_local_client_send(&hurried);
        if (id == 0) /* another request is under way until long after the deadline */
            now_ns += 60000;
        while (tfa_worker_cycle(worker))
            ;
        const tfa_wire_reply *reply = tfa_ring_oldest_reply(&hurried.ring);
        assert_int_equal(reply->status, id ? TFA_OK : TFA_E_LATE);
        assert_int_equal(reply->id, id);
        tfa_ring_release(&hurried.ring);
    }
    assert_int_equal(s.states, 2);
    const tfa_tally_sums count = tfa_worker_client_sums(hurried.client);
    assert_int_equal(count.requests, 2);
    assert_int_equal(count.rejected, 1);
    assert_int_equal(count.late, 1);
}
