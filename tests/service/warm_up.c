/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Warm-ups of a worker without a thread, on a clock of the test: nothing observable follows from
 * them, they delay a request by one solve at most, and they stop when they should.
 */
#include "local_client_calls.h"
#include "test.h"
#include "worker/worker_internal.h"

#include <string.h>

#define TURN_NS 20000
#define WARM_NS 20000
#define STATES 64
#define BIG_STATES 2048 /* their replies are no ordinary ones */

/* The worker's clock. */
static uint64_t now_ns;

uint64_t tfa_worker_clock(void)
{
    return now_ns;
}

void tfa_worker_nap(uint64_t ns)
{
    now_ns += ns;
}

/* qdd = q + tau, in so many ns a state. Every other request that leaves its estimates open gets
 * them. */
typedef struct counting_solver {
    uint64_t state_ns, warm_state_ns;
    uint64_t calls, warm_calls, warm_ns, open_estimates, wrong;
    double last;             /* of q in the request that was answered last */
    tfa_local_client *sends; /* a request in the middle of the next warm-up */
} counting_solver;

static void answer_states(const tfa_request *request, tfa_reply *reply, uint32_t first,
                          uint32_t count)
{
    for (uint32_t i = 2 * first; i < 2 * (first + count); i++)
        reply->qdd[i] = request->q[i] + request->tau[i];
}

static int solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    counting_solver *s = self;
    s->calls++;
    now_ns += count * s->state_ns;
    if (request->op != TFA_OP_FORWARD_DYNAMICS)
        return TFA_E_ARGUMENT;
    if (first == 0 && request->estimate == TFA_ESTIMATE_DEFAULT)
        request->estimate = s->open_estimates++ % 2 ? TFA_ESTIMATE_NEVER : TFA_ESTIMATE_ALWAYS;
    answer_states(request, reply, first, count);
    s->last = request->q[0];
    return TFA_OK;
}

static void solve_again(void *self, const tfa_request *request, tfa_reply *reply)
{
    counting_solver *s = self;
    s->warm_calls++;
    s->warm_ns += request->count * s->warm_state_ns;
    now_ns += request->count * s->warm_state_ns;
    s->wrong += request->estimate == TFA_ESTIMATE_DEFAULT || request->q[0] != s->last;
    answer_states(request, reply, 0, request->count);
    reply->qdd[0] = -1; /* nobody may see it */
    if (!s->sends)
        return;
    assert_int_equal(send_to(s->sends, 5, 5), TFA_OK);
    s->sends = NULL;
}

static tfa_worker_robot robot_of(counting_solver *s)
{
    return (tfa_worker_robot){.shape = {.q_count = 2, .v_count = 2, .max_batch = BIG_STATES},
                              .solve = solve,
                              .warm_up = solve_again,
                              .self = s};
}

static tfa_worker *make_worker(counting_solver *s, uint32_t warm_ns, tfa_wait wait)
{
    const tfa_worker_robot robot = robot_of(s);
    const tfa_worker_options options = {.robots = &robot,
                                        .robot_count = 1,
                                        .spin_ns = 1000000,
                                        .turn_ns = TURN_NS,
                                        .warm_ns = warm_ns,
                                        .wait = wait};
    tfa_worker *worker;
    now_ns = 1000000;
    assert_int_equal(tfa_worker_create(&options, &worker), TFA_OK);
    return worker;
}

static void open_client(tfa_worker *worker, tfa_local_client *client)
{
    assert_int_equal(tfa_local_client_open(worker, 0, 8, BIG_STATES, client), TFA_OK);
}

static void send_batch(tfa_local_client *client, tfa_op op, uint32_t states, double x)
{
    static double q[2 * BIG_STATES], tau[2 * BIG_STATES];
    const tfa_request request = {.op = op, .count = states, .q = q, .tau = tau};
    tfa_wire_reply_shape shape;
    for (uint32_t i = 0; i < 2 * states; i++)
        q[i] = x + i;
    assert_int_equal(tfa_wire_encode_request(&client->shape, &request,
                                             tfa_wire_want(&request, NULL), (uint64_t)x, now_ns,
                                             tfa_ring_next_request(&client->ring), &shape, NULL),
                     TFA_OK);
    tfa_local_client_send(client);
}

/* The worker runs for so long without a request. */
static void run_idle(tfa_worker *worker, uint64_t ns)
{
    for (const uint64_t end = now_ns + ns; now_ns < end; now_ns += 500)
        for (int i = 0; i < 64; i++) {
            if (tfa_worker_cycle(worker))
                return;
            tfa_worker_wait(worker);
        }
}

static void answer_all(tfa_worker *worker)
{
    while (tfa_worker_cycle(worker))
        worker->idle = 0; /* as tfa_worker_run */
}

/* One request, answered; then the worker has nothing to do. @return warm-ups meanwhile */
static uint64_t warm_calls_after(tfa_worker *worker, tfa_local_client *client, counting_solver *s,
                                 tfa_op op, uint32_t states)
{
    const uint64_t before = s->warm_calls;
    send_batch(client, op, states, 3);
    answer_all(worker);
    tfa_ring_release(&client->ring);
    run_idle(worker, 10 * WARM_NS);
    return s->warm_calls - before;
}

/* ---- nothing observable ---- */

/* All that a run leaves behind for others to see, or to be scheduled by. */
typedef struct trace {
    tfa_local_client client[2];
    counting_solver solver;
    tfa_worker *worker;
} trace;

static void run_trace(trace *t, uint32_t warm_ns)
{
    static const uint32_t sizes[] = {1, 3, STATES, 1, 500, 2};
    t->solver = (counting_solver){.state_ns = 300};
    t->worker = make_worker(&t->solver, warm_ns, TFA_WAIT_SPIN);
    for (int i = 0; i < 2; i++)
        open_client(t->worker, &t->client[i]);
    for (unsigned k = 0; k < 60; k++) {
        for (int i = 0; i < 2; i++) {
            if (k % 3 != 2 || i == 0)
                send_batch(&t->client[i], k % 7 == 6 ? TFA_OP_MASS_MATRIX : TFA_OP_FORWARD_DYNAMICS,
                           k % 7 == 6 ? 1 : sizes[(k + (unsigned)i) % 6], 10 * k);
        }
        answer_all(t->worker);
        for (int i = 0; i < 2; i++)
            while (tfa_ring_reply_ready(&t->client[i].ring))
                tfa_ring_release(&t->client[i].ring);
        run_idle(t->worker, k % 5 * 30000);
    }
}

static void compare_clients(const trace *a, const trace *b, int i)
{
    const tfa_worker_client *x = a->client[i].client, *y = b->client[i].client;
    const tfa_ring_layout *layout = &x->ring.layout;
    assert_memory_equal(a->client[i].memory, b->client[i].memory,
                        layout->request_bytes + layout->reply_bytes);
    assert_memory_equal(x->shared, y->shared, sizeof *x->shared);
    assert_int_equal(x->virtual_ns, y->virtual_ns);
    assert_int_equal(x->ring.next, y->ring.next);
}

/* Warm-ups that take no time change no bit of the rings, with all answers, times and heartbeats in
 * them, no counter, no share of time, no cost and no policy. */
TEST(nothing_observable_changes)
{
    trace cold, warm;
    run_trace(&cold, 0);
    run_trace(&warm, WARM_NS);
    assert_int_equal(cold.solver.warm_calls, 0);
    assert_true(warm.solver.warm_calls > 100);
    for (int i = 0; i < 2; i++)
        compare_clients(&cold, &warm, i);
    assert_int_equal(warm.solver.calls, cold.solver.calls);
    assert_int_equal(warm.solver.open_estimates, cold.solver.open_estimates);
    assert_memory_equal(warm.worker->costs, cold.worker->costs, sizeof *cold.worker->costs);
    assert_int_equal(warm.worker->virtual_clock, cold.worker->virtual_clock);
    assert_int_equal(tfa_worker_heartbeat(warm.worker), tfa_worker_heartbeat(cold.worker));
    for (int i = 0; i < 2; i++) {
        tfa_local_client_close(&cold.client[i]);
        tfa_local_client_close(&warm.client[i]);
    }
    tfa_worker_destroy(cold.worker);
    tfa_worker_destroy(warm.worker);
}

/* The request that was answered last is solved again, with the estimate policy that it got. */
TEST(the_last_request_is_solved_again)
{
    counting_solver s = {.state_ns = 100};
    SCOPED_WORKER *worker = make_worker(&s, WARM_NS, TFA_WAIT_SPIN);
    SCOPED_LOCAL_CLIENT client;
    open_client(worker, &client);
    for (int k = 0; k < 6; k++) {
        send_batch(&client, TFA_OP_FORWARD_DYNAMICS, 1, k);
        answer_all(worker);
        tfa_ring_release(&client.ring);
        run_idle(worker, 5 * WARM_NS);
    }
    assert_in_range(s.warm_calls, 6 * 3, 6 * 5);
    assert_int_equal(s.wrong, 0);
}

/* Clients with ordinary requests take turns, unless they have been silent for long. */
TEST(every_client_has_its_turn)
{
    counting_solver one = {.state_ns = 100}, two = {.state_ns = 100};
    const tfa_worker_robot robots[] = {robot_of(&one), robot_of(&two)};
    const tfa_worker_options options = {
        .robots = robots, .robot_count = 2, .warm_ns = WARM_NS, .wait = TFA_WAIT_SPIN};
    SCOPED_WORKER *worker;
    tfa_local_client client[2];
    assert_int_equal(tfa_worker_create(&options, &worker), TFA_OK);
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(tfa_local_client_open(worker, i, 8, 1, &client[i]), TFA_OK);
        assert_int_equal(send_to(&client[i], i, i), TFA_OK);
    }
    answer_all(worker);
    run_idle(worker, 20 * WARM_NS);
    assert_in_range(one.warm_calls, 7, 11);
    assert_in_range(two.warm_calls, 7, 11);
    const uint64_t silent = one.warm_calls, before = two.warm_calls;
    now_ns += 2000000000u;
    assert_int_equal(send_to(&client[1], 5, 5), TFA_OK);
    answer_all(worker);
    run_idle(worker, 20 * WARM_NS);
    assert_int_equal(one.warm_calls, silent);
    assert_in_range(two.warm_calls - before, 15, 20);
    for (int i = 0; i < 2; i++)
        tfa_local_client_close(&client[i]);
}

/* ---- bounds ---- */

/* A request that comes in the middle of a warm-up waits for its end, and for no other. */
TEST(a_request_waits_for_one_warm_up)
{
    counting_solver s = {.state_ns = 400, .warm_state_ns = 400};
    SCOPED_WORKER *worker = make_worker(&s, WARM_NS, TFA_WAIT_SPIN);
    SCOPED_LOCAL_CLIENT client;
    open_client(worker, &client);
    (void)warm_calls_after(worker, &client, &s, TFA_OP_FORWARD_DYNAMICS, 1);
    s.sends = &client;
    while (s.sends) {
        assert_int_equal(tfa_worker_cycle(worker), 0);
        tfa_worker_wait(worker);
        now_ns += 10;
    }
    const uint64_t sent = now_ns - s.warm_state_ns, warm = s.warm_calls;
    assert_int_equal(tfa_worker_cycle(worker), 1);
    assert_int_equal(s.warm_calls, warm);
    const tfa_wire_reply *line = tfa_ring_oldest_reply(&client.ring);
    assert_true(line->t_done - sent <= s.warm_state_ns + s.state_ns + 10);
    assert_true(receive_from(&client, 5, 5));
}

/* However long the request, warm-ups take a small share of the time. */
TEST(warm_ups_take_a_small_share)
{
    static const uint64_t lengths[] = {100, 1000, 5000, TURN_NS};
    for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) {
        counting_solver s = {.state_ns = lengths[k], .warm_state_ns = lengths[k]};
        SCOPED_WORKER *worker = make_worker(&s, 1000, TFA_WAIT_SPIN);
        SCOPED_LOCAL_CLIENT client;
        open_client(worker, &client);
        send_batch(&client, TFA_OP_FORWARD_DYNAMICS, 1, 3);
        answer_all(worker);
        const uint64_t start = now_ns;
        run_idle(worker, 100 * TURN_NS);
        assert_true(s.warm_calls > 1);
        assert_true(s.warm_ns <= (now_ns - start) / 10 + lengths[k]);
    }
}

/* Long requests, large replies, refusals, clients that ask nothing, and a worker without warm-ups
 * have none. */
TEST(only_ordinary_requests)
{
    counting_solver s = {.state_ns = 300};
    const tfa_op fd = TFA_OP_FORWARD_DYNAMICS;
    tfa_worker *worker = make_worker(&s, WARM_NS, TFA_WAIT_SPIN);
    tfa_local_client client;
    open_client(worker, &client);
    assert_true(warm_calls_after(worker, &client, &s, fd, STATES) > 0);
    assert_int_equal(warm_calls_after(worker, &client, &s, fd, TURN_NS / 300 + 1), 0);
    assert_int_equal(warm_calls_after(worker, &client, &s, TFA_OP_MASS_MATRIX, 1), 0);
    s.state_ns = 0;
    assert_true(warm_calls_after(worker, &client, &s, fd, STATES) > 0);
    assert_int_equal(warm_calls_after(worker, &client, &s, fd, BIG_STATES), 0);
    assert_true(warm_calls_after(worker, &client, &s, fd, 1) > 0);
    now_ns += 2000000000u;
    const uint64_t before = s.warm_calls;
    for (int i = 0; i < 64; i++) /* it naps for 50 us each time */
        tfa_worker_wait(worker);
    assert_int_equal(s.warm_calls, before);
    tfa_local_client_close(&client);
    tfa_worker_destroy(worker);
    worker = make_worker(&s, 0, TFA_WAIT_SPIN);
    open_client(worker, &client);
    assert_int_equal(warm_calls_after(worker, &client, &s, fd, 1), 0);
    tfa_local_client_close(&client);
    tfa_worker_destroy(worker);
}

/* The arrays of a direct client's request are its own again when it is answered. */
TEST(none_for_direct_clients)
{
    counting_solver s = {.state_ns = 100};
    SCOPED_WORKER *worker = make_worker(&s, WARM_NS, TFA_WAIT_SPIN);
    const double q[2] = {1, 2}, tau[2] = {3, 4};
    double qdd[2];
    tfa_worker_call call = {
        .request = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = q, .tau = tau},
        .reply = {.qdd = qdd}};
    const tfa_wire_shape lines = {.max_batch = 1};
    const tfa_ring_layout layout = tfa_ring_layout_of(&lines, 2);
    unsigned char *memory =
        aligned_alloc(TFA_CACHE_LINE, layout.request_bytes + layout.reply_bytes);
    assert_non_null(memory);
    memset(memory, 0, layout.request_bytes + layout.reply_bytes);
    const tfa_worker_client_options options = {.max_batch = 1,
                                               .layout = layout,
                                               .requests = memory,
                                               .replies = memory + layout.request_bytes,
                                               .wait = TFA_WAIT_SPIN,
                                               .doorbell = -1,
                                               .internal = true,
                                               .direct = true};
    tfa_ring_client ring = {.layout = layout,
                            .requests = memory,
                            .replies = memory + layout.request_bytes,
                            .spin = true};
    tfa_worker_client *client;
    assert_int_equal(tfa_worker_attach(worker, &options, &client), TFA_OK);
    ((tfa_wire_request *)tfa_ring_next_request(&ring))->id = (uint64_t)(uintptr_t)&call;
    (void)tfa_ring_send(&ring);
    answer_all(worker);
    assert_true(tfa_ring_reply_ready(&ring) && qdd[1] == 6);
    assert_false(client->warm);
    run_idle(worker, 10 * WARM_NS);
    assert_int_equal(s.warm_calls, 0);
    assert_true(tfa_worker_detach(worker, client));
    free(memory);
}

/* ---- the end of warm-ups ---- */

/* A worker that sleeps does none: at once in block mode, after its spin in hybrid mode. */
TEST(none_while_the_worker_sleeps)
{
    static const tfa_wait modes[] = {TFA_WAIT_BLOCK, TFA_WAIT_HYBRID};
    for (int k = 0; k < 2; k++) {
        counting_solver s = {.state_ns = 100};
        SCOPED_WORKER *worker = make_worker(&s, WARM_NS, modes[k]);
        SCOPED_LOCAL_CLIENT client;
        open_client(worker, &client);
        worker->modes[TFA_WAIT_BLOCK] = 0; /* whatever the processors of this machine */
        worker->modes[TFA_WAIT_HYBRID] = k == 1;
        assert_int_equal(send_to(&client, 1, 1), TFA_OK);
        answer_all(worker);
        for (int i = 0; i < 128; i++) { /* hybrid: two looks at the clock, then it sleeps */
            now_ns += i == 127 ? 2 * worker->spin_ns : 0;
            tfa_worker_wake(worker);
            tfa_worker_wait(worker);
        }
        assert_int_equal(worker->idle, 0); /* it slept */
        assert_int_equal(s.warm_calls, 0);
        worker->modes[client.client->wait] = 1;
        worker->modes[client.client->wait == TFA_WAIT_BLOCK ? TFA_WAIT_HYBRID : TFA_WAIT_BLOCK] = 0;
    }
}

/* A request belongs to a model: with another one it is solved no more, nor is the old one asked. */
TEST(dropped_with_the_model)
{
    counting_solver first = {.state_ns = 100}, second = {.state_ns = 100};
    SCOPED_WORKER *worker = make_worker(&first, WARM_NS, TFA_WAIT_SPIN);
    const tfa_worker_robot next = robot_of(&second);
    SCOPED_LOCAL_CLIENT client;
    open_client(worker, &client);
    assert_true(warm_calls_after(worker, &client, &first, TFA_OP_FORWARD_DYNAMICS, 1) > 0);
    const uint64_t before = first.warm_calls;
    tfa_worker_offer(worker, &next);
    run_idle(worker, 10 * WARM_NS);
    assert_ptr_equal(atomic_load(&worker->taken), atomic_load(&worker->offer));
    assert_int_equal(first.warm_calls, before);
    assert_int_equal(second.warm_calls, 0);
    assert_true(warm_calls_after(worker, &client, &second, TFA_OP_FORWARD_DYNAMICS, 1) > 0);
    assert_int_equal(first.warm_calls, before);
}

/* Nothing is solved for a client that left or broke the protocol, nor for its successor before it
 * asks. */
TEST(dropped_with_the_client)
{
    for (int broken = 0; broken < 2; broken++) {
        counting_solver s = {.state_ns = 100};
        SCOPED_WORKER *worker = make_worker(&s, WARM_NS, TFA_WAIT_SPIN);
        tfa_local_client client, next;
        open_client(worker, &client);
        assert_true(warm_calls_after(worker, &client, &s, TFA_OP_FORWARD_DYNAMICS, 1) > 0);
        const uint64_t before = s.warm_calls;
        atomic_store(&worker->phase, WORKER_RUNNING);
        if (broken)
            atomic_store(&((tfa_wire_request *)tfa_ring_next_request(&client.ring))->seq, 77);
        else
            assert_false(tfa_worker_detach(worker, client.client));
        run_idle(worker, 10 * WARM_NS);
        assert_int_equal(s.warm_calls, before);
        atomic_store(&worker->phase, WORKER_IDLE);
        tfa_local_client_close(&client);
        open_client(worker, &next);
        assert_false(next.client->warm);
        run_idle(worker, 10 * WARM_NS);
        assert_int_equal(s.warm_calls, before);
        tfa_local_client_close(&next);
    }
}
