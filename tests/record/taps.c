/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A tap by itself: every record arrives whole and in order, or is dropped and counted, whatever the
 * recorder does.
 */
#include "ipc/tap.h"
#include "support/wait.h"
#include "test.h"

#include <pthread.h>
#include <sched.h>

#define RING TFA_TAP_RING_MIN
#define RECORDS 200000
#define BURST 1000

typedef struct ends {
    _Alignas(64) unsigned char *segment;
    tfa_tap tap;
    tfa_tap_reader reader;
} ends;

static void open_ends(ends *e)
{
    const size_t size = tfa_tap_segment_size(1, RING);
    e->segment =
        aligned_alloc(TFA_TAP_PAGE, (size + TFA_TAP_PAGE - 1) / TFA_TAP_PAGE * TFA_TAP_PAGE);
    assert_non_null(e->segment);
    memset(e->segment, 0, size);
    e->tap = (tfa_tap){.words = tfa_tap_words_of(e->segment, 0),
                       .bytes = tfa_tap_ring_of(e->segment, 1, RING, 0),
                       .size = RING};
    e->reader = (tfa_tap_reader){.words = e->tap.words, .bytes = e->tap.bytes, .size = RING};
}

static uint64_t sizes_of(uint64_t k)
{
    return sizeof(tfa_tap_record) + 8 * (16 + k * k % 301);
}

/* Writes record `k`: its number in every word. @return false: it was dropped */
static bool put(tfa_tap *tap, uint64_t k)
{
    const uint64_t bytes = sizes_of(k);
    tfa_tap_record *record = tfa_tap_reserve(tap, bytes);
    if (!record)
        return false;
    *record = (tfa_tap_record){
        .bytes = (uint32_t)bytes, .request_bytes = 64, .reply_bytes = (uint32_t)bytes - 96};
    uint64_t *words = (uint64_t *)(void *)(record + 1);
    for (size_t i = 0; i < (bytes - sizeof *record) / 8; i++)
        words[i] = k;
    tfa_tap_publish(tap, bytes);
    return true;
}

/* Takes all that is there; each record must be whole, and later than the one before. */
static uint64_t take_record(ends *e, uint64_t *next)
{
    uint64_t count = 0;
    const tfa_tap_record *record;
    tfa_tap_look(&e->reader);
    while ((record = tfa_tap_next(&e->reader)) != NULL) {
        const uint64_t *words = (const uint64_t *)(const void *)(record + 1);
        const uint64_t k = words[0];
        assert_true(k >= *next && record->bytes == sizes_of(k) && e->reader.found == sizes_of(k));
        for (size_t i = 0; i < (record->bytes - sizeof *record) / 8; i++)
            assert_true(words[i] == k);
        *next = k + 1;
        count++;
        tfa_tap_release(&e->reader, e->reader.found);
    }
    assert_false(e->reader.broken);
    return count;
}

TEST(every_record_in_order)
{
    ends e;
    uint64_t next = 0;
    open_ends(&e);
    for (uint64_t k = 0; k < 20000; k++) {
        assert_true(put(&e.tap, k));
        if (k % 7 == 0)
            (void)take_record(&e, &next);
    }
    (void)take_record(&e, &next);
    assert_true(next == 20000);
    assert_true(atomic_load(&e.tap.words->dropped) == 0);
    free(e.segment);
}

TEST(a_full_ring_drops_and_counts)
{
    ends e;
    uint64_t next = 0, kept = 0;
    open_ends(&e);
    for (uint64_t k = 0; k < 1000; k++)
        kept += put(&e.tap, k);
    assert_true(kept > 10 && kept < 1000);
    assert_true(atomic_load(&e.tap.words->dropped) == 1000 - kept);
    assert_true(take_record(&e, &next) == kept);
    assert_true(put(&e.tap, 1000)); /* there is room again */
    assert_true(take_record(&e, &next) == 1);
    assert_null(tfa_tap_reserve(&e.tap, 2 * RING));
    free(e.segment);
}

/* A record of more than half the ring, at a position with room neither before the end nor from the
 * beginning: it is dropped once, not as long as only such records come. */
TEST(a_large_record)
{
    ends e;
    const uint64_t large = RING - 512;
    uint64_t next = 0;
    open_ends(&e);
    for (uint64_t k = 0; k < 8; k++)
        assert_true(put(&e.tap, k));
    assert_true(take_record(&e, &next) == 8);
    assert_null(tfa_tap_reserve(&e.tap, large));
    assert_true(tfa_tap_dropped(e.tap.words) == 1);
    assert_null(tfa_tap_reserve(&e.tap, large)); /* the recorder has not looked */
    assert_true(take_record(&e, &next) == 0);
    assert_non_null(tfa_tap_reserve(&e.tap, large));
    free(e.segment);
}

static void expect_broken(ends *e)
{
    tfa_tap_look(&e->reader);
    assert_null(tfa_tap_next(&e->reader));
    assert_true(e->reader.broken);
    free(e->segment);
}

/* What is no record is not taken for one. */
TEST(other_bytes_than_records)
{
    ends e;
    const uint32_t heads[][4] = {{0, 0, 0, 0},      {4, 0, 0, 0},   {36, 0, 64, 64},
                                 {168, 0, 64, 64},  {24, 0, 64, 0}, {RING + 8, 0, 64, 0},
                                 {1 << 20, 0, 0, 0}};
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        open_ends(&e);
        assert_true(put(&e.tap, 0));
        memcpy(e.tap.bytes, heads[i], sizeof heads[i]);
        expect_broken(&e);
    }
    open_ends(&e);
    atomic_store(&e.tap.words->written, RING + 8); /* more than a ring holds */
    *(tfa_tap_record *)(void *)e.tap.bytes = (tfa_tap_record){.bytes = 160, .request_bytes = 64};
    expect_broken(&e);
    open_ends(&e); /* beyond the end of the ring */
    e.reader.read = RING - 64;
    atomic_store(&e.tap.words->written, RING + 128);
    *(tfa_tap_record *)(void *)(e.tap.bytes + RING - 64) =
        (tfa_tap_record){.bytes = 160, .request_bytes = 64};
    expect_broken(&e);
}

/* Positions that no recorder has: nothing is overwritten but the ring, and later ones count. */
TEST(a_position_that_lies)
{
    ends e;
    uint64_t next = 0;
    open_ends(&e);
    uint64_t kept = 0;
    while (put(&e.tap, kept))
        kept++;
    const uint64_t lies[] = {UINT64_MAX, e.tap.written + 8, e.tap.written - RING - 8, 1ull << 63};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        atomic_store(&e.tap.words->read, lies[i]);
        atomic_store(&e.tap.words->written, lies[i] * 3);
        assert_false(put(&e.tap, kept));
    }
    atomic_store(&e.tap.words->written, e.tap.written);
    assert_true(take_record(&e, &next) == kept);
    free(e.segment);
}

static void *produce(void *arg)
{
    ends *e = arg;
    for (uint64_t k = 0; k < RECORDS; k++) {
        if (!put(&e->tap, k))
            sched_yield();
        if (k % BURST == BURST - 1) /* now and then the recorder comes to the end of it */
            (void)WAIT_FOR(atomic_load(&e->tap.words->read) == e->tap.written);
    }
    return NULL;
}

/* Two threads: taken and dropped add up. Each burst has one record at least that finds room. */
TEST(a_producer_and_a_recorder)
{
    ends e;
    pthread_t thread;
    uint64_t next = 0, taken = 0;
    open_ends(&e);
    assert_int_equal(pthread_create(&thread, NULL, produce, &e), 0);
    while (taken + atomic_load_explicit(&e.tap.words->dropped, memory_order_relaxed) < RECORDS)
        taken += take_record(&e, &next);
    pthread_join(thread, NULL);
    taken += take_record(&e, &next);
    assert_true(taken + atomic_load(&e.tap.words->dropped) == RECORDS);
    assert_true(taken >= RECORDS / BURST);
    free(e.segment);
}
