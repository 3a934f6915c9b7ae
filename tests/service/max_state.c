/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Admission by cost (max_state_us): on a clock of the test, whatever the machine.
 */
#include "local_client_calls.h"
#include "test.h"
#include "worker/cost_bound.h"
#include "worker/worker_internal.h"

#define LIMIT_US 500u
#define LONG_NS 5000000u
#define BATCH 8

/* The worker's clock. A solver is the only thing that takes time. */
static _Atomic uint64_t now_ns = 1;

uint64_t tfa_worker_clock(void)
{
    return now_ns;
}

void tfa_worker_nap(uint64_t ns)
{
    now_ns += ns;
}

typedef struct timed_solver {
    uint64_t state_ns;
    uint16_t flags; /* of its answers */
    unsigned calls;
} timed_solver;

static int solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    timed_solver *s = self;
    (void)request;
    for (uint32_t i = first; i < first + count; i++)
        reply->answers[i].flags = s->flags;
    now_ns += count * s->state_ns;
    s->calls++;
    return TFA_OK;
}

/* A worker whose forward dynamics has this bound, and a client of it */
typedef struct stage {
    timed_solver solver;
    tfa_cost_parts parts;
    tfa_worker *worker;
    tfa_local_client client;
} stage;

static void set_bound(tfa_cost_parts *parts, uint32_t us)
{
    for (int k = 0; k < TFA_COST_POINTS; k++) {
        parts->tips[k] = (uint32_t)k;
        parts->of[TFA_OP_FORWARD_DYNAMICS][TFA_METHOD_AUTO].plain.at[k] = us * 1000 * 2 / 3;
    }
}

static void open_stage_with(stage *s, uint32_t bound_us, uint32_t limit_us, bool beside)
{
    *s = (stage){.solver = {.state_ns = 1000}};
    set_bound(&s->parts, bound_us);
    const tfa_worker_robot robot = {.shape = {.q_count = 2, .v_count = 2, .max_batch = BATCH},
                                    .solve = solve,
                                    .self = &s->solver,
                                    .long_self = beside ? &s->solver : NULL,
                                    .max_state_ns = 1000 * limit_us,
                                    .parts = &s->parts};
    const tfa_worker_options options = {
        .robots = &robot, .robot_count = 1, .turn_ns = 20000, .wait = TFA_WAIT_BLOCK};
    assert_int_equal(tfa_worker_create(&options, &s->worker), TFA_OK);
    assert_int_equal(tfa_local_client_open(s->worker, 0, 8, BATCH, &s->client), TFA_OK);
    s->client.client->self_test = false; /* a client of this process counts as one otherwise */
}

static void open_stage(stage *s, uint32_t bound_us, uint32_t limit_us)
{
    open_stage_with(s, bound_us, limit_us, false);
}

static void close_stage(stage *s)
{
    tfa_local_client_close(&s->client);
    tfa_worker_destroy(s->worker);
}

static void send_states(tfa_local_client *client, tfa_op op, uint32_t count)
{
    static const double zero[2 * BATCH];
    const tfa_request request = {.op = op, .count = count, .q = zero, .tau = zero};
    tfa_wire_reply_shape shape;
    assert_int_equal(tfa_wire_encode_request(&client->shape, &request,
                                             tfa_wire_want(&request, NULL), 1, 0,
                                             tfa_ring_next_request(&client->ring), &shape, NULL),
                     TFA_OK);
    tfa_local_client_send(client);
}

static void send(tfa_local_client *client, tfa_op op)
{
    send_states(client, op, 1);
}

/* @return the reply */
static tfa_reply ask_states(stage *s, tfa_op op, uint32_t count)
{
    tfa_reply reply = {0};
    send_states(&s->client, op, count);
    while (tfa_worker_cycle(s->worker))
        ;
    (void)tfa_wire_decode_reply(tfa_ring_oldest_reply(&s->client.ring), &reply);
    tfa_ring_release(&s->client.ring);
    return reply;
}

static tfa_reply ask(stage *s, tfa_op op)
{
    return ask_states(s, op, 1);
}

static int ask_forward(stage *s)
{
    return ask(s, TFA_OP_FORWARD_DYNAMICS).status;
}

/* Before the work starts, with cost and limit. Other kinds are answered, all without a limit. */
TEST(long_kinds_are_refused)
{
    stage s;
    open_stage(&s, 1700, LIMIT_US);
    for (int k = 0; k < 3; k++) {
        const tfa_reply reply = ask(&s, TFA_OP_FORWARD_DYNAMICS);
        assert_int_equal(reply.status, TFA_E_REFUSED);
        assert_int_equal(reply.field, TFA_FIELD_COST);
        assert_in_range(reply.index, 1690, 1710);
        assert_int_equal(reply.state, LIMIT_US);
        now_ns += 2000000000; /* its bound stays what it is */
    }
    assert_int_equal(s.solver.calls, 0);
    assert_int_equal(ask(&s, TFA_OP_INVERSE_DYNAMICS).status, TFA_OK);
    close_stage(&s);
    open_stage(&s, 1700, 0);
    assert_int_equal(ask_forward(&s), TFA_OK);
    close_stage(&s);
}

/* An interrupt is no property of a kind. */
TEST(an_interrupted_state_refuses_nothing)
{
    stage s;
    open_stage(&s, 20, LIMIT_US);
    for (int k = 0; k < 50; k++) {
        s.solver.state_ns = k % 5 > 0 ? 10000 : k % 2 ? LONG_NS : 100 * LONG_NS;
        assert_int_equal(ask_forward(&s), TFA_OK);
    }
    close_stage(&s);
}

/* What a bound was too low for is refused after some requests, and tried again once a second. */
TEST(a_bound_too_low_does_not_last)
{
    stage s;
    open_stage(&s, 20, LIMIT_US);
    s.solver.state_ns = LONG_NS;
    int answered = 0;
    while (ask_forward(&s) == TFA_OK && answered < 100)
        answered++;
    assert_in_range(answered, 1, 8);
    for (int k = 0; k < 1000; k++) {
        now_ns += 900000;
        assert_int_equal(ask_forward(&s), TFA_E_REFUSED);
    }
    now_ns += 200000000;
    s.solver.state_ns = 10000; /* the machine was slow, no longer */
    for (int k = 0; k < 100; k++)
        assert_int_equal(ask_forward(&s), TFA_OK);
    close_stage(&s);
}

/* One client's singular states do not take a kind from the others. */
TEST(fallbacks_do_not_count)
{
    static const uint16_t flags[] = {TFA_ANSWER_FALLBACK, TFA_ANSWER_SENTINEL,
                                     TFA_ANSWER_RANK_LOSS, TFA_ANSWER_STALLED};
    for (size_t f = 0; f < sizeof flags / sizeof *flags; f++) {
        stage s;
        open_stage(&s, 20, LIMIT_US);
        s.solver.state_ns = LONG_NS;
        s.solver.flags = flags[f];
        for (int k = 0; k < 300; k++)
            assert_int_equal(ask_forward(&s), TFA_OK);
        close_stage(&s);
    }
}

static void answer_kind(stage *s, uint32_t us)
{
    s->solver.flags = 0;
    s->solver.state_ns = 1000 * us;
    assert_int_equal(ask_forward(s), TFA_OK);
}

/* One client's states that take longer than their kind */
static void doubt(stage *s)
{
    answer_kind(s, 200);
    s->solver.state_ns = 1000000;
    s->solver.flags = TFA_ANSWER_SENTINEL;
    s->solver.calls = 0;
}

/* States that take longer than their kind by the numbers of one client are refused to it after
 * some, in favour of the others; its short kinds are answered, and a 500th of the time is its. */
TEST(a_client_answers_for_its_doubted_states)
{
    stage s;
    tfa_local_client other;
    open_stage(&s, 200, LIMIT_US);
    assert_int_equal(tfa_local_client_open(s.worker, 0, 8, 1, &other), TFA_OK);
    other.client->self_test = false;
    doubt(&s);
    while (ask_forward(&s) == TFA_OK)
        assert_true(s.solver.calls < 10);
    assert_int_equal(s.solver.calls, 5);
    const tfa_reply reply = ask(&s, TFA_OP_FORWARD_DYNAMICS);
    assert_int_equal(reply.status, TFA_E_REFUSED);
    assert_in_range(reply.index, 2390, 2410);
    s.solver.flags = 0;
    s.solver.state_ns = 200000;
    send(&other, TFA_OP_FORWARD_DYNAMICS);
    while (tfa_worker_cycle(s.worker))
        ;
    assert_int_equal(((const tfa_wire_reply *)tfa_ring_oldest_reply(&other.ring))->status, TFA_OK);
    tfa_ring_release(&other.ring);
    s.solver.state_ns = 50000;
    assert_int_equal(ask(&s, TFA_OP_INVERSE_DYNAMICS).status, TFA_OK);
    now_ns += UINT64_C(10000000000);
    doubt(&s);
    for (const uint64_t end = now_ns + UINT64_C(100000000000); now_ns < end; now_ns += 100000)
        (void)ask_forward(&s);
    assert_in_range(s.solver.calls, 150, 210);
    tfa_local_client_close(&other);
    close_stage(&s);
}

/* The rest of a batch, too */
TEST(doubts_end_a_batch)
{
    stage s;
    open_stage(&s, 200, LIMIT_US);
    doubt(&s);
    const tfa_reply reply = ask_states(&s, TFA_OP_FORWARD_DYNAMICS, BATCH);
    assert_int_equal(reply.status, TFA_E_REFUSED);
    assert_int_equal(reply.field, TFA_FIELD_COST);
    assert_int_equal(s.solver.calls, 5);
    close_stage(&s);
}

/* Interrupts of 2 ms every two seconds refuse nothing. */
TEST(interrupted_states_owe_little)
{
    stage s;
    open_stage(&s, 200, LIMIT_US);
    doubt(&s);
    for (int k = 0; k < 50000; k++) {
        s.solver.state_ns = k % 2000 ? 220000 : 2000000;
        assert_int_equal(ask_forward(&s), TFA_OK);
        now_ns += 780000;
    }
    close_stage(&s);
}

/* Other solvers have other costs. */
TEST(an_offer_forgets)
{
    stage s;
    open_stage(&s, 20, LIMIT_US);
    s.solver.state_ns = LONG_NS;
    for (int k = 0; k < 20; k++)
        (void)ask_forward(&s);
    assert_int_equal(ask_forward(&s), TFA_E_REFUSED);
    const tfa_worker_robot next = s.worker->robots[0];
    tfa_worker_offer(s.worker, &next);
    assert_int_equal(ask_forward(&s), TFA_OK);
    close_stage(&s);
}

static void *run_long(void *worker)
{
    tfa_worker_long_run(worker);
    return NULL;
}

/* One client has always more for the thread beside the worker; the other one's single request is
 * next nevertheless. */
TEST(the_thread_is_shared)
{
    stage s;
    tfa_local_client other;
    pthread_t thread;
    unsigned answered = 0;
    open_stage_with(&s, 1700, LIMIT_US, true);
    s.solver.state_ns = LONG_NS;
    assert_int_equal(tfa_local_client_open(s.worker, 0, 8, 1, &other), TFA_OK);
    other.client->self_test = false;
    assert_int_equal(pthread_create(&thread, NULL, run_long, s.worker), 0);
    for (int k = 0; k < 20; k++) {
        bool sent = false;
        const unsigned before = answered;
        while (!tfa_ring_reply_ready(&other.ring)) {
            for (; tfa_ring_reply_ready(&s.client.ring); answered++)
                tfa_ring_release(&s.client.ring);
            while (!tfa_ring_full(&s.client.ring))
                send(&s.client, TFA_OP_FORWARD_DYNAMICS);
            (void)tfa_worker_cycle(s.worker);
            if (!sent && answered > before) {
                send(&other, TFA_OP_FORWARD_DYNAMICS);
                sent = true;
            }
        }
        const tfa_wire_reply *reply = tfa_ring_oldest_reply(&other.ring);
        assert_int_equal(reply->status, TFA_OK);
        tfa_ring_release(&other.ring);
        assert_true(answered - before <= 3);
    }
    tfa_worker_stop(s.worker);
    tfa_worker_long_settle(s.worker);
    tfa_worker_long_stop(s.worker);
    assert_int_equal(pthread_join(thread, NULL), 0);
    tfa_local_client_close(&other);
    close_stage(&s);
}

int main(void)
{
    return test_run(NULL, NULL);
}
