/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment of a tap and its recorder: drain_one, taps_dropped and record of tools/record.
 */
#include "tap_sides.h"

#include <string.h>

#include "tap_parts.h"

#define RING_BYTES_MAX 128

tap_case tap_under_test;
tap_error tap_error_made;
uint32_t tap_dies_at;
bool tap_died;
tap_producer tap_producers[2];

static _Alignas(TFA_TAP_PAGE) unsigned char segment[TFA_TAP_PAGE + 2 * RING_BYTES_MAX];
static uint32_t steps; /* of the recorder */

/* ---- memory ---- */

static uint64_t *ring_word(const void *at)
{
    const uintptr_t ring = (uintptr_t)segment + TFA_TAP_PAGE, p = (uintptr_t)at;
    return p >= ring && p < ring + 2 * tap_under_test.ring_bytes ? (uint64_t *)p : NULL;
}

static bool is_in_segment(const void *at)
{
    const uintptr_t p = (uintptr_t)at;
    return p >= (uintptr_t)segment && p < (uintptr_t)segment + sizeof segment;
}

/* One of both is private memory. */
void tap_copy(void *to, const void *from, uint64_t bytes)
{
    for (uint64_t k = 0; k < bytes; k += 8) {
        unsigned char *target = (unsigned char *)to + k;
        const unsigned char *source = (const unsigned char *)from + k;
        uint64_t word;
        explorer_check(!is_in_segment(target) || ring_word(target), "written beyond the rings");
        explorer_check(!is_in_segment(source) || ring_word(source), "read beyond the rings");
        if (ring_word(source))
            word = explorer_data_read(ring_word(source));
        else
            memcpy(&word, source, sizeof word);
        if (ring_word(target))
            explorer_data_write(ring_word(target), word);
        else
            memcpy(target, &word, sizeof word);
    }
}

void tap_open(tap_producer *p, uint32_t ring)
{
    const uint64_t size = tap_under_test.ring_bytes;
    p->tap = (tfa_tap){.words = tfa_tap_words_of(segment, ring),
                       .bytes = tfa_tap_ring_of(segment, 2, size, ring),
                       .size = size,
                       .producer = (uint16_t)ring};
    p->kept = p->missed = 0;
}

void tap_reset(void *argument)
{
    (void)argument;
    memset(segment, 0, sizeof segment);
    memset(tap_producers, 0, sizeof tap_producers);
    steps = 0;
    for (uint32_t k = 0; k < 2; k++) {
        tap_producer *p = &tap_producers[k];
        tap_open(p, k);
        p->reader =
            (tfa_tap_reader){.words = p->tap.words, .bytes = p->tap.bytes, .size = p->tap.size};
        p->memory = !tap_under_test.leaves;
    }
}

/* Whatever became of the recorder: each record was published or dropped. */
void tap_finish(void *argument)
{
    (void)argument;
    for (uint32_t k = 0; k < tap_under_test.producers; k++) {
        const tap_producer *p = &tap_producers[k];
        if (!tap_under_test.leaves)
            explorer_check(p->kept + p->tap.dropped == tap_records(), "a record was not counted");
    }
}

/* ---- the recorder ---- */

/* Before each operation: it may be killed here. */
static void step(void)
{
    if (++steps != tap_dies_at)
        return;
    tap_died = true;
    explorer_die();
}

static void read_record(tap_producer *p, const tfa_tap_record *record, uint64_t bytes)
{
    uint64_t block[16] = {0};
    tfa_tap_record head;
    explorer_check(bytes <= sizeof block, "wrong record");
    step();
    tap_copy(block, record, bytes);
    memcpy(&head, block, sizeof head);
    const uint64_t number = head.max_batch;
    explorer_check(number > p->last && number <= tap_records(), "wrong record");
    explorer_check(head.bytes == bytes && bytes == tap_under_test.bytes[number - 1] &&
                       head.request_bytes == bytes,
                   "wrong record");
    explorer_check(head.producer == p - tap_producers, "record of another producer");
    for (uint64_t k = sizeof head / 8; k < bytes / 8; k++)
        explorer_check(block[k] == number, "torn record");
    p->last = number;
    p->taken++;
}

/* A position that was never written: the producer must not use it. */
static void lie(const tap_producer *p)
{
    atomic_store_explicit(&p->reader.words->read, p->reader.written + p->reader.size,
                          memory_order_relaxed);
}

/* tfa_tap_next with an error */
static const tfa_tap_record *next_record(tfa_tap_reader *r)
{
    if (tap_has_error(RECORDER_IGNORES_WRITTEN))
        r->written = r->read + r->size;
    if (tap_has_error(RECORDER_TAKES_FILLER) && r->read != r->written) {
        bool is_filler;
        r->found = tfa_tap_piece(r, &is_filler);
        return (const tfa_tap_record *)(const void *)(r->bytes + (r->read & (r->size - 1)));
    }
    return tfa_tap_next(r);
}

/* @return records */
static uint32_t drain(tap_producer *p)
{
    tfa_tap_reader *r = &p->reader;
    const tfa_tap_record *record;
    const uint32_t before = p->taken;
    step();
    tfa_tap_look(r);
    if (tap_under_test.lies && r->written != r->read)
        lie(p);
    for (step(); (record = next_record(r)) != NULL; step()) {
        if (tap_has_error(RECORDER_READS_AFTER_RELEASE))
            tfa_tap_release(r, r->found);
        read_record(p, record, r->found);
        step();
        if (!tap_has_error(RECORDER_READS_AFTER_RELEASE))
            tfa_tap_release(r, r->found);
    }
    explorer_check(!r->broken, "no record");
    return p->taken - before;
}

static uint64_t count_dropped(const tap_producer *p)
{
    step();
    return tfa_tap_dropped(p->reader.words);
}

/* Looks, and takes what is there; each record missing before the last one was counted. */
static void look(tap_producer *p)
{
    const bool early = tap_has_error(RECORDER_COUNTS_BEFORE_LOOK);
    uint64_t dropped = early ? count_dropped(p) : 0;
    if (drain(p) && !early)
        dropped = count_dropped(p);
    else if (!early)
        return;
    explorer_check(p->last - p->taken <= dropped, "a record is missing and was not counted");
}

static void wait_for_hang_up(tap_producer *p)
{
    step();
    while (!atomic_load_explicit(&p->hung_up, memory_order_acquire))
        explorer_spin();
}

/* After the last look: what was not taken was dropped. */
static void end_recording(tap_producer *p)
{
    wait_for_hang_up(p);
    if (!tap_has_error(RECORDER_NO_LAST_LOOK))
        (void)drain(p);
    explorer_check(p->taken + count_dropped(p) == tap_records(),
                   "a record is missing and was not counted");
}

void tap_recorder_body(void *argument)
{
    (void)argument;
    for (uint32_t i = 0; i < tap_under_test.looks; i++)
        for (uint32_t k = 0; k < tap_under_test.producers; k++)
            look(&tap_producers[k]);
    for (uint32_t k = 0; k < tap_under_test.producers && !tap_under_test.leaves; k++)
        end_recording(&tap_producers[k]);
}

/* The recorder after that one */
void tap_second_recorder_body(void *argument)
{
    (void)argument;
    look(&tap_producers[1]);
}

const char *tap_error_text(tap_error error)
{
    static const char *const texts[TAP_ERRORS] = {
        [TAP_ERROR_NONE] = "none",
        [PRODUCER_IGNORES_FULL] = "producer: writes into a full ring",
        [PRODUCER_TRUSTS_POSITION] = "producer: uses a position (T2) of the future",
        [PRODUCER_IGNORES_END] = "producer: writes beyond the end of the ring",
        [PRODUCER_WRITES_NO_FILLER] = "producer: no filler at the end",
        [PRODUCER_FILLS_WITHOUT_ROOM] = "producer: room for the record, not for the filler",
        [PRODUCER_BEGINS_LAP_WITHOUT_ROOM] = "producer: begins a lap without room for the filler",
        [PRODUCER_COUNTS_NO_DROP] = "producer: counts no drop (T3)",
        [PRODUCER_COUNTS_DROP_LATE] = "producer: counts a drop (T3) after the next record (T1)",
        [PRODUCER_WAITS] = "producer: waits for room",
        [PRODUCER_WRITES_AFTER_PUBLISH] = "producer: writes the record after T1",
        [RECORDER_IGNORES_WRITTEN] = "recorder: reads beyond what was written (T1)",
        [RECORDER_TAKES_FILLER] = "recorder: takes a filler for a record",
        [RECORDER_READS_AFTER_RELEASE] = "recorder: reads the record after T2",
        [RECORDER_COUNTS_BEFORE_LOOK] = "recorder: reads the drops (T3) before T1",
        [RECORDER_NO_LAST_LOOK] = "recorder: no look after the hang-up",
        [WORKER_TAKES_IN_REQUEST] = "worker: says taken (A16) between R14 and the record",
        [WORKER_KEEPS_TAP] = "worker: loads its tap (R14) once for all requests",
        [WORKER_GETS_TAP_BEFORE_OFFER] = "worker: loads its tap (R14) before the offer (R12)",
        [CONTROL_ASKS_FIRST] = "control: asks (A15) before it takes the tap away (A14)",
        [CONTROL_FILLS_AFTER_SET] = "control: makes the tap after A14",
        [CONTROL_FREES_AT_ONCE] = "control: frees the tap without R16",
        [CONTROL_OFFERS_FIRST] = "control: offers solvers (A12) before A14",
    };
    return texts[error];
}
