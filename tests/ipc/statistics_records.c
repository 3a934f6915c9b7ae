/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Records and counters while they are written: a thread counts without a pause, another one reads
 * the same memory, so that ThreadSanitizer sees both. Each copy is of one moment.
 */
#include "client/client_statistics.h"
#include "support/wait.h"
#include "test.h"

#include <pthread.h>

enum { READS = 4000, ROBOTS = 2, CLIENTS = 2 };

static const tfa_answer answers[] = {
    {.method = TFA_METHOD_ABA},
    {.method = TFA_METHOD_CRBA, .flags = TFA_ANSWER_FALLBACK},
    {.method = TFA_METHOD_TFA, .flags = TFA_ANSWER_ESTIMATED, .error_estimate = 3e-9}};

typedef struct writer {
    pthread_t thread;
    tfa_shared_tally *tally;
    tfa_shared_robot *robot;
    tfa_shared_state *state;
    _Atomic bool stop;
    uint64_t counted;
} writer;

/* Every fourth request is refused; states, busy time and times are the same for all. */
static void count_one(writer *w)
{
    const uint64_t i = w->counted++;
    const bool good = i % 4 != 3;
    const tfa_tally_request request = {.status = good ? TFA_OK : TFA_E_VALUE,
                                       .has_answers = good,
                                       .states = 1,
                                       .answers = good ? &answers[i % 4] : NULL,
                                       .busy_ns = 7,
                                       .sent = 1,
                                       .received = 101,
                                       .start = 301,
                                       .done = 311};
    tfa_tally_count(w->tally, &request);
}

/* Every number of a robot and a state is that of its writing. */
static void write_records(const writer *w)
{
    tfa_served_robot served = {.joints = (uint32_t)w->counted, .dds_domain = (uint32_t)w->counted};
    double q[16];
    const tfa_request request = {.q = q};
    memset(served.name, 'a' + (int)(w->counted % 26), sizeof served.name - 1);
    for (int i = 0; i < 16; i++)
        q[i] = (double)w->counted;
    tfa_record_write(&w->robot->served.version, w->robot->served.words, &served, sizeof served);
    tfa_state_publish(w->state, &request, 16, false, 20000000u * (w->counted + 1));
}

static void *write_all(void *arg)
{
    writer *w = arg;
    while (!atomic_load_explicit(&w->stop, memory_order_relaxed)) {
        count_one(w);
        write_records(w);
    }
    return NULL;
}

static uint64_t sum(const uint64_t *values, int count)
{
    uint64_t all = 0;
    for (int i = 0; i < count; i++)
        all += values[i];
    return all;
}

static void check(const tfa_snapshot *s)
{
    const tfa_client_statistics *c = &s->clients[0];
    const tfa_tally *t = &c->tally;
    const tfa_robot_statistics *r = &s->robots[1];
    assert_int_equal(s->client_count, 1);
    assert_int_equal(t->requests - t->rejected, sum(t->methods, TFA_STATISTICS_METHODS));
    assert_int_equal(t->rejected, t->requests / 4);
    assert_int_equal(t->states, t->requests - t->rejected);
    assert_int_equal(t->busy_ns, 7 * t->requests);
    assert_int_equal(t->fallbacks, t->methods[TFA_METHOD_CRBA]);
    assert_int_equal(t->estimates, sum(t->estimate_decades, TFA_STATISTICS_DECADES));
    assert_int_equal(t->estimates, t->methods[TFA_METHOD_TFA]);
    assert_true(t->queue.sum == 200.0 * (double)t->requests);
    assert_true(t->total.sum == 310.0 * (double)t->requests);
    assert_true(t->queue.count >= t->requests && t->compute.count >= t->requests);
    assert_int_equal(r->served.joints, r->served.dds_domain);
    for (int i = 1; r->served.joints && i < 63; i++)
        assert_int_equal(r->served.name[i], 'a' + (int)(r->served.joints % 26));
    for (int i = 1; i < 16; i++)
        assert_true(r->state.q[i] == r->state.q[0]);
    assert_true(!r->state.time || r->state.time == (uint64_t)(20000000 * (r->state.q[0] + 1)));
}

TEST(copies_are_of_one_moment)
{
    const tfa_statistics_layout layout = tfa_statistics_layout_of(1, ROBOTS, CLIENTS);
    void *memory = aligned_alloc(TFA_STATISTICS_LINE, layout.bytes);
    assert_non_null(memory);
    memset(memory, 0, layout.bytes);
    tfa_statistics reader = {.memory = memory,
                             .size = layout.bytes,
                             .workers = 1,
                             .robots = ROBOTS,
                             .clients = CLIENTS,
                             .view = tfa_statistics_view_of(memory, &layout)};
    const tfa_served_client served = {.kind = TFA_CLIENT_SHM, .robot = 1};
    writer w = {.tally = &reader.view.clients[1].tally,
                .robot = &reader.view.robots[1],
                .state = &reader.view.states[1]};
    tfa_snapshot *s;
    tfa_words_write(reader.view.clients[1].served, &served, sizeof served);
    tfa_counter_set(&reader.view.workers[0].clients_used, CLIENTS);
    assert_int_equal(tfa_snapshot_create(&reader, &s), TFA_OK);
    assert_int_equal(pthread_create(&w.thread, NULL, write_all, &w), 0);
    for (int i = 0; i < READS; i++) { /* busy: the writer has no processor */
        assert_true(WAIT_FOR(tfa_statistics_read(&reader, s) == TFA_OK));
        check(s);
    }
    atomic_store(&w.stop, true);
    pthread_join(w.thread, NULL);
    assert_int_equal(tfa_statistics_read(&reader, s), TFA_OK);
    check(s);
    assert_int_equal(s->clients[0].tally.requests, w.counted);
    assert_int_equal(s->clients[0].tally.queue.count, w.counted);
    tfa_snapshot_free(s);
    free(memory);
}

/* Numbers of a segment that choose memory are bounded, whatever they are. */
TEST(a_false_segment_does_no_harm)
{
    const tfa_statistics_layout layout = tfa_statistics_layout_of(1, ROBOTS, CLIENTS);
    unsigned char *memory = aligned_alloc(TFA_STATISTICS_LINE, layout.bytes);
    uint64_t seed = 5;
    int good = 0;
    assert_non_null(memory);
    tfa_statistics reader = {.memory = memory,
                             .size = layout.bytes,
                             .workers = 1,
                             .robots = ROBOTS,
                             .clients = CLIENTS,
                             .view = tfa_statistics_view_of(memory, &layout)};
    tfa_snapshot *s;
    assert_int_equal(tfa_snapshot_create(&reader, &s), TFA_OK);
    for (int k = 0; k < 20; k++) {
        for (size_t i = 0; i < layout.bytes; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            memory[i] = (unsigned char)(seed >> 56) & (k % 2 ? 0xff : 0xfe); /* even versions */
        }
        if (tfa_statistics_read(&reader, s) != TFA_OK)
            continue;
        good++;
        assert_true(s->client_count <= CLIENTS + 2 * ROBOTS);
        for (uint32_t i = 0; i < s->robot_count; i++) {
            const tfa_served_robot *r = &s->robots[i].served;
            assert_true(memchr(r->name, 0, sizeof r->name) && memchr(r->ros2_node, 0, 256));
            assert_true(s->robots[i].ros2.input_count <= TFA_STATISTICS_INPUTS_MAX &&
                        s->robots[i].state.q_count <= TFA_STATISTICS_Q_MAX);
        }
    }
    assert_true(good >= 10);
    tfa_snapshot_free(s);
    free(memory);
}
