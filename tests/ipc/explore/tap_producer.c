/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The producer's end of a tap: tfa_tap_put of service/worker/worker_tap.c.
 */
#include "tap_parts.h"

#include <string.h>

/* Room without the checks that an error leaves out. */
static bool has_room(tfa_tap *tap, uint64_t bytes)
{
    if (tap_has_error(PRODUCER_IGNORES_FULL) || tap->written - tap->read + bytes <= tap->size)
        return true;
    const uint64_t read = atomic_load_explicit(&tap->words->read, memory_order_acquire);
    if (tap->written - read > tap->size && !tap_has_error(PRODUCER_TRUSTS_POSITION))
        return false;
    tap->read = read;
    return tap->written - tap->read + bytes <= tap->size;
}

static void fill(tfa_tap *tap, uint64_t filler)
{
    if (!tap_has_error(PRODUCER_WRITES_NO_FILLER))
        tfa_tap_fill(tap, filler);
    else
        tap->written += filler;
}

/* tfa_tap_reserve with an error */
static tfa_tap_record *reserve_with_error(tfa_tap *tap, uint64_t bytes)
{
    const uint64_t at = tap->written & (tap->size - 1), rest = tap->size - at;
    const uint64_t filler = bytes <= rest || tap_has_error(PRODUCER_IGNORES_END) ? 0 : rest;
    const uint64_t counted = tap_has_error(PRODUCER_FILLS_WITHOUT_ROOM) ? 0 : filler;
    while (tap_has_error(PRODUCER_WAITS) && !has_room(tap, counted + bytes))
        explorer_spin();
    if (!has_room(tap, counted + bytes)) {
        if (filler && bytes > at &&
            (tap_has_error(PRODUCER_BEGINS_LAP_WITHOUT_ROOM) || has_room(tap, filler))) {
            fill(tap, filler);
            tfa_tap_publish_position(tap);
        }
        if (tap_has_error(PRODUCER_COUNTS_DROP_LATE))
            tap->dropped++;
        else if (!tap_has_error(PRODUCER_COUNTS_NO_DROP))
            tfa_tap_drop(tap);
        return NULL;
    }
    if (!filler)
        return (tfa_tap_record *)(void *)(tap->bytes + at);
    fill(tap, filler);
    return (tfa_tap_record *)(void *)tap->bytes;
}

static tfa_tap_record *reserve(tfa_tap *tap, uint64_t bytes)
{
    const bool is_correct =
        tap_error_made < PRODUCER_IGNORES_FULL || tap_error_made > PRODUCER_WAITS;
    return is_correct ? tfa_tap_reserve(tap, bytes) : reserve_with_error(tap, bytes);
}

static void write_record(const tfa_tap *tap, tfa_tap_record *record, uint64_t number)
{
    const uint32_t bytes = tap_under_test.bytes[number - 1];
    uint64_t block[16] = {0};
    const tfa_tap_record head = {.bytes = bytes,
                                 .request_bytes = bytes,
                                 .max_batch = (uint32_t)number,
                                 .producer = tap->producer};
    memcpy(block, &head, sizeof head);
    for (uint32_t k = sizeof head / 8; k < bytes / 8; k++)
        block[k] = number;
    tap_copy((unsigned char *)record + sizeof head, block + sizeof head / 8, bytes - sizeof head);
    tap_copy(record, block, sizeof head);
}

void tap_put(tap_producer *p, tfa_tap *tap)
{
    explorer_check(explorer_data_read(&p->memory) != 0, "use of a tap that was freed");
    const uint64_t number = p->kept + p->missed + 1;
    const uint32_t bytes = tap_under_test.bytes[number - 1];
    tfa_tap_record *record = reserve(tap, bytes);
    if (record) {
        if (!tap_has_error(PRODUCER_WRITES_AFTER_PUBLISH))
            write_record(tap, record, number);
        tfa_tap_publish(tap, bytes);
        if (tap_has_error(PRODUCER_WRITES_AFTER_PUBLISH))
            write_record(tap, record, number);
        if (tap_has_error(PRODUCER_COUNTS_DROP_LATE))
            atomic_store_explicit(&tap->words->dropped, tap->dropped, memory_order_relaxed);
    }
    p->kept += record != NULL;
    p->missed += record == NULL;
    explorer_check(explorer_data_read(&p->memory) != 0, "use of a tap that was freed");
}

/* The hang-up of a daemon that stops: its socket orders what was before it (no part of the tap). */
static void hang_up(tap_producer *p)
{
    atomic_store_explicit(&p->hung_up, 1, memory_order_release);
}

static void produce(tap_producer *p)
{
    for (uint32_t k = 0; k < tap_records(); k++)
        tap_put(p, &p->tap);
    hang_up(p);
}

void tap_producer_body(void *argument)
{
    (void)argument;
    produce(&tap_producers[0]);
}

void tap_second_producer_body(void *argument)
{
    (void)argument;
    produce(&tap_producers[1]);
}
