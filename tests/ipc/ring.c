/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ring in private memory: order, fullness, windows, sleep flags, and two threads.
 */
#include "ipc/ring.h"
#include "test.h"

#include <pthread.h>
#include <sched.h>

#define EXCHANGES 20000

typedef struct pair {
    tfa_ring_client client;
    tfa_ring_server server;
    tfa_ring_worker_status *worker_status; /* head of the reply segment */
    unsigned char *memory;
} pair;

static pair make_pair(uint32_t slots, bool spin)
{
    const tfa_wire_shape shape = {.q_count = 2, .v_count = 2, .max_batch = 1};
    const tfa_ring_layout layout = tfa_ring_layout_of(&shape, slots);
    pair p = {.memory = aligned_alloc(64, layout.request_bytes + layout.reply_bytes)};
    memset(p.memory, 0, layout.request_bytes + layout.reply_bytes);
    unsigned char *replies = p.memory + layout.request_bytes;
    p.worker_status = (tfa_ring_worker_status *)(void *)replies;
    p.client = (tfa_ring_client){.layout = layout,
                                 .requests = p.memory,
                                 .replies = replies,
                                 .worker_status = p.worker_status,
                                 .spin = spin};
    p.server =
        (tfa_ring_server){.layout = layout, .requests = p.memory, .replies = replies, .spin = spin};
    return p;
}

static void send_number(pair *p, uint64_t number)
{
    ((tfa_wire_request *)tfa_ring_next_request(&p->client))->id = number;
    (void)tfa_ring_send(&p->client);
}

/* Answers the next request with its number plus one. */
static void answer_next(pair *p)
{
    const tfa_wire_request *request = tfa_ring_request(&p->server);
    ((tfa_wire_reply *)tfa_ring_reply(&p->server))->id = request->id + 1;
    (void)tfa_ring_publish(&p->server);
}

static uint64_t receive_number(pair *p)
{
    uint64_t id = ((const tfa_wire_reply *)tfa_ring_oldest_reply(&p->client))->id;
    tfa_ring_release(&p->client);
    return id;
}

TEST(layout_is_valid)
{
    const tfa_wire_shape arm = {.q_count = 7, .v_count = 7, .max_batch = 1};
    for (uint32_t slots = 1; slots <= TFA_RING_SLOTS_MAX; slots *= 2) {
        const tfa_ring_layout l = tfa_ring_layout_of(&arm, slots);
        assert_int_equal(l.request_stride % 128, 64); /* an odd number of lines */
        assert_int_equal(l.reply_stride % 128, 64);
        assert_true(l.request_stride >= tfa_wire_request_capacity(&arm));
        assert_true(tfa_ring_request_offset(&l, slots - 1) + l.request_stride <= l.request_bytes);
        assert_true(tfa_ring_reply_offset(&l, slots - 1) + l.reply_stride <= l.reply_bytes);
        assert_int_equal(tfa_ring_request_offset(&l, slots), tfa_ring_request_offset(&l, 0));
    }
    assert_true(tfa_ring_slots_valid(1) && tfa_ring_slots_valid(4096));
    assert_false(tfa_ring_slots_valid(0) || tfa_ring_slots_valid(3) || tfa_ring_slots_valid(8192));
}

TEST(keeps_order_over_many_laps)
{
    pair p = make_pair(4, true);
    uint64_t sent = 0, received = 0;
    for (int lap = 0; lap < 100; lap++) {
        const int n = 1 + lap % 4;
        for (int i = 0; i < n; i++)
            send_number(&p, 10 * sent++);
        while (tfa_ring_poll(&p.server) == TFA_RING_READY)
            answer_next(&p);
        assert_int_equal(tfa_ring_poll(&p.server), TFA_RING_EMPTY);
        while (received < sent) {
            assert_true(tfa_ring_reply_ready(&p.client));
            assert_int_equal(receive_number(&p), 10 * received++ + 1);
        }
        assert_false(tfa_ring_reply_ready(&p.client));
    }
    free(p.memory);
}

/* As after so many requests: every slot has the number of the lap before. */
static void begin_at(pair *p, uint64_t start)
{
    for (uint64_t i = start - p->client.layout.slots; i < start; i++) {
        p->client.sent = p->client.received = p->server.next = i;
        (void)tfa_ring_send(&p->client);
        (void)tfa_ring_publish(&p->server);
        tfa_ring_release(&p->client);
    }
}

/* Numbers of requests pass 2^32, where the word that a client sleeps on begins at 0 again: it
 * differs from the one before, and a reply is ready when it has come, not earlier. */
TEST(numbers_pass_2_32)
{
    static const uint64_t starts[] = {(UINT64_C(1) << 32) - 3, (UINT64_C(1) << 33) - 1,
                                      (UINT64_C(1) << 63) - 2};
    for (size_t k = 0; k < sizeof starts / sizeof *starts; k++)
        for (uint32_t slots = 1; slots <= 4; slots *= 2) {
            pair p = make_pair(slots, false);
            begin_at(&p, starts[k]);
            for (uint64_t i = 0; i < 12; i++) {
                const uint32_t *word = tfa_ring_futex_word(tfa_ring_oldest_reply(&p.client));
                const uint32_t before = *word;
                assert_int_equal(tfa_ring_poll(&p.server), TFA_RING_EMPTY);
                send_number(&p, i);
                assert_int_equal(tfa_ring_poll_last(&p.server), TFA_RING_READY);
                assert_false(tfa_ring_reply_ready(&p.client));
                assert_true(tfa_ring_client_prepare_wait(&p.client, p.client.received) <=
                            p.client.received);
                answer_next(&p);
                assert_true(*word != before);
                assert_true(tfa_ring_client_prepare_wait(&p.client, p.client.received) >
                            p.client.received);
                assert_true(tfa_ring_reply_ready(&p.client));
                assert_int_equal(receive_number(&p), i + 1);
            }
            free(p.memory);
        }
}

TEST(full_means_outstanding)
{
    pair p = make_pair(2, true);
    send_number(&p, 1);
    send_number(&p, 2);
    assert_true(tfa_ring_full(&p.client));
    answer_next(&p);
    answer_next(&p);
    assert_true(tfa_ring_full(&p.client)); /* replies not taken still occupy their slots */
    (void)receive_number(&p);
    assert_false(tfa_ring_full(&p.client));
    free(p.memory);
}

/* Whatever a client writes as sequence number, it is next, nothing, or an offence. */
TEST(window_is_judged)
{
    pair p = make_pair(4, true);
    static const uint64_t bad[] = {2, 3, 5, 1000, UINT64_MAX, UINT64_MAX - 3};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(tfa_ring_classify_sequence(&p.server, bad[i]), TFA_RING_BROKEN);
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 0), TFA_RING_EMPTY);
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 1), TFA_RING_READY);
    p.server.next = 9;
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 6), TFA_RING_EMPTY);
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 10), TFA_RING_READY);
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 0), TFA_RING_BROKEN);
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 9), TFA_RING_BROKEN);
    assert_int_equal(tfa_ring_classify_sequence(&p.server, 14), TFA_RING_BROKEN);
    free(p.memory);
}

TEST(half_written_request_is_not_seen)
{
    pair p = make_pair(2, true);
    tfa_wire_request *line = tfa_ring_next_request(&p.client);
    memset((unsigned char *)line + 8, 0xff, sizeof *line - 8); /* all but seq */
    assert_int_equal(tfa_ring_poll(&p.server), TFA_RING_EMPTY);
    free(p.memory);
}

TEST(wakes_only_sleeping_sides)
{
    pair p = make_pair(2, false);
    assert_false(tfa_ring_send(&p.client));
    assert_false(tfa_ring_publish(&p.server));
    tfa_ring_release(&p.client);
    atomic_store(&p.worker_status->asleep, 1);
    assert_true(tfa_ring_send(&p.client));
    assert_int_equal(tfa_ring_client_prepare_wait(&p.client, 1), 0); /* not there: sleep */
    assert_true(tfa_ring_publish(&p.server));
    assert_int_equal(tfa_ring_client_prepare_wait(&p.client, 1), 2); /* there: do not */
    tfa_ring_client_end_wait(&p.client);
    tfa_ring_release(&p.client);
    (void)tfa_ring_send(&p.client);
    assert_false(tfa_ring_publish(&p.server));
    assert_int_equal(*tfa_ring_futex_word(tfa_ring_oldest_reply(&p.client)), 3);
    free(p.memory);
}

TEST(spinners_have_no_flags)
{
    pair p = make_pair(2, true);
    atomic_store(&p.worker_status->asleep, 1);
    atomic_store(&tfa_ring_client_flags_of(&p.client)->asleep, 1);
    assert_false(tfa_ring_send(&p.client));
    assert_false(tfa_ring_publish(&p.server));
    free(p.memory);
}

static void *serve(void *argument)
{
    pair *p = argument;
    for (int i = 0; i < EXCHANGES; i++) {
        while (tfa_ring_poll(&p->server) != TFA_RING_READY)
            sched_yield();
        answer_next(p);
    }
    return NULL;
}

/* Under ThreadSanitizer this shows that A1/R1 and A2/R2 order the slots' plain bytes. */
TEST(two_threads)
{
    pair p = make_pair(8, false);
    pair server_side = p;
    pthread_t thread;
    uint64_t sent = 0, received = 0;
    assert_int_equal(pthread_create(&thread, NULL, serve, &server_side), 0);
    while (received < EXCHANGES) {
        while (sent < EXCHANGES && !tfa_ring_full(&p.client))
            send_number(&p, 3 * sent++);
        if (tfa_ring_reply_ready(&p.client))
            assert_int_equal(receive_number(&p), 3 * received++ + 1);
        else
            sched_yield();
    }
    pthread_join(thread, NULL);
    free(p.memory);
}
