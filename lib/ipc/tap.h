/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A tap: requests and answers of one robot on their way from the daemon to a recorder, and the
 * records of a recording. Pure operations on memory, no system call.
 *
 * One segment holds a ring of bytes for each producer: the workers, then the DDS gateway, then the
 * ROS 2 gateway. A record lies in one piece: where it would not fit before the end of the ring, a
 * filler takes the rest. A record that finds no room is dropped whole and counted; one of more than
 * half the ring may be, although the ring is empty. The daemon reads one word of a segment, the
 * recorder's position, and only copies and bounds it: a recorder that spoils its segment spoils its
 * own recording.
 *
 * Atomics and their pairs: a label names the store and the loads of one word. Neither side waits
 * for the other, so none is seq_cst.
 *
 *   T1 written  store release (producer)  ->  load acquire (recorder): the bytes before it are
 *               visible, and the drops before it
 *   T2 read     store release (recorder)  ->  load acquire (producer): the recorder has done with
 *               the bytes before it, which may be overwritten
 *   T3 dropped  store relaxed (producer)  ->  load relaxed (recorder): T1 orders it. A recorder
 *               that loads it after T1 sees every record missing before those that it took
 *
 * How a worker gets a tap and loses it: worker/robot_taps.h of the daemon. Each order is explored
 * by tests/ipc/explore.
 */
#ifndef TFA_IPC_TAP_H
#define TFA_IPC_TAP_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ipc/wire.h"

#define TFA_TAP_MAGIC UINT64_C(0x3150415446524654) /* "TFRFTAP1" */
#define TFA_TAP_PAGE 4096u
#define TFA_TAP_PRODUCERS_MAX 1024u
/** Bytes of a producer's ring: a power of two between these. */
#define TFA_TAP_RING_MIN ((uint64_t)1 << 16)
#define TFA_TAP_RING_MAX ((uint64_t)1 << 28)

/** A record: this head, then a request and a reply as in slots of a ring (wire.h), each with its
 *  line. In a recording the same, with a checksum. */
typedef struct tfa_tap_record {
    uint32_t bytes;               /**< with this head: a multiple of 8 */
    uint32_t checksum;            /**< of all that follows; the recorder computes it */
    uint32_t request_bytes;       /**< 0: a filler up to the end of the ring */
    uint32_t reply_bytes;         /**< multiples of 8 */
    uint32_t max_batch, max_tips; /**< of the client: they belong to the shape of the request */
    uint16_t producer;            /**< which answered */
    uint8_t estimate;             /**< tfa_estimate of the request as sent; its line has the one
                                       that was settled */
    uint8_t reserved[5];          /**< 0 */
} tfa_tap_record;

_Static_assert(sizeof(tfa_tap_record) == 32, "a record's head is half a cache line");

/** First line of a segment; constant. */
typedef struct tfa_tap_head {
    _Alignas(TFA_CACHE_LINE) uint64_t magic;
    uint32_t producers, reserved;
    uint64_t ring_bytes; /**< of each */
} tfa_tap_head;

/** The words of a ring. */
typedef struct tfa_tap_words {
    _Alignas(TFA_CACHE_LINE) _Atomic uint64_t written; /**< T1: bytes since the beginning */
    _Atomic uint64_t dropped;                          /**< T3: records */
    _Alignas(TFA_CACHE_LINE) _Atomic uint64_t read;    /**< T2: bytes; untrusted */
} tfa_tap_words;

/** The producer's end: private, one thread at a time. */
typedef struct tfa_tap {
    _Alignas(TFA_CACHE_LINE) tfa_tap_words *words;
    unsigned char *bytes;
    uint64_t size;    /**< of the ring */
    uint64_t written; /**< what it last wrote into `words` */
    uint64_t read;    /**< what it last saw there */
    uint64_t dropped;
    uint16_t producer;
} tfa_tap;

/** The recorder's end of a ring: private. */
typedef struct tfa_tap_reader {
    tfa_tap_words *words;
    const unsigned char *bytes;
    uint64_t size;    /**< of the ring */
    uint64_t read;    /**< what it last wrote into `words` */
    uint64_t written; /**< what it last saw there */
    uint64_t found;   /**< bytes of the record that tfa_tap_next returned */
    bool broken;      /**< the ring holds something else than records */
} tfa_tap_reader;

static inline bool tfa_tap_size_valid(uint64_t size)
{
    return size >= TFA_TAP_RING_MIN && size <= TFA_TAP_RING_MAX && (size & (size - 1)) == 0;
}

/** Where the rings begin: after the words, at a page. */
static inline size_t tfa_tap_rings_offset(uint32_t producers)
{
    const size_t words = sizeof(tfa_tap_head) + producers * sizeof(tfa_tap_words);
    return (words + TFA_TAP_PAGE - 1) / TFA_TAP_PAGE * TFA_TAP_PAGE;
}

static inline size_t tfa_tap_segment_size(uint32_t producers, uint64_t ring_bytes)
{
    return tfa_tap_rings_offset(producers) + producers * (size_t)ring_bytes;
}

static inline tfa_tap_words *tfa_tap_words_of(void *segment, uint32_t producer)
{
    return (tfa_tap_words *)(void *)((unsigned char *)segment + sizeof(tfa_tap_head)) + producer;
}

static inline unsigned char *tfa_tap_ring_of(void *segment, uint32_t producers, uint64_t ring_bytes,
                                             uint32_t producer)
{
    return (unsigned char *)segment + tfa_tap_rings_offset(producers) +
           producer * (size_t)ring_bytes;
}

/* ---- the producer's end ---- */

static inline void tfa_tap_drop(tfa_tap *tap)
{
    atomic_store_explicit(&tap->words->dropped, ++tap->dropped, memory_order_relaxed); /* T3 */
}

/* Room for so many bytes, if need be by another look at the recorder's position. One that is ahead
 * of what was written, or too far behind, is a lie: there is no room. */
static inline bool tfa_tap_has_room(tfa_tap *tap, uint64_t bytes)
{
    if (tap->written - tap->read + bytes <= tap->size)
        return true;
    const uint64_t read = atomic_load_explicit(&tap->words->read, memory_order_acquire); /* T2 */
    if (tap->written - read > tap->size)
        return false;
    tap->read = read;
    return tap->written - read + bytes <= tap->size;
}

static inline void tfa_tap_publish_position(tfa_tap *tap)
{
    atomic_store_explicit(&tap->words->written, tap->written, memory_order_release); /* T1 */
}

/* Takes the rest of the ring. The last 8 bytes hold less than a head: its first two words are
 * enough. */
static inline void tfa_tap_fill(tfa_tap *tap, uint64_t rest)
{
    const uint32_t head[4] = {(uint32_t)rest, 0, 0, 0};
    __builtin_memcpy(tap->bytes + (tap->size - rest), head,
                     rest < sizeof head ? rest : sizeof head);
    tap->written += rest;
}

/* For a record that fits neither before the end of the ring nor behind a filler, even if the ring
 * is empty: continues at the beginning, so that the next record of that size may fit. */
static inline void tfa_tap_begin_lap(tfa_tap *tap, uint64_t filler)
{
    if (!filler || !tfa_tap_has_room(tap, filler))
        return;
    tfa_tap_fill(tap, filler);
    tfa_tap_publish_position(tap);
}

/** Room for a record of so many bytes, a multiple of 8; NULL: none, and it was counted. */
static inline tfa_tap_record *tfa_tap_reserve(tfa_tap *tap, uint64_t bytes)
{
    const uint64_t at = tap->written & (tap->size - 1), rest = tap->size - at;
    const uint64_t filler = bytes <= rest ? 0 : rest;
    if (bytes > tap->size || !tfa_tap_has_room(tap, filler + bytes)) {
        if (bytes <= tap->size && bytes > at)
            tfa_tap_begin_lap(tap, filler);
        tfa_tap_drop(tap);
        return NULL;
    }
    if (!filler)
        return (tfa_tap_record *)(void *)(tap->bytes + at);
    tfa_tap_fill(tap, filler);
    return (tfa_tap_record *)(void *)tap->bytes;
}

/** Publishes the record that was reserved. */
static inline void tfa_tap_publish(tfa_tap *tap, uint64_t bytes)
{
    tap->written += bytes;
    tfa_tap_publish_position(tap);
}

/* ---- the recorder's end ---- */

/** Looks for records; tfa_tap_next finds them. */
static inline void tfa_tap_look(tfa_tap_reader *r)
{
    r->written = atomic_load_explicit(&r->words->written, memory_order_acquire); /* T1 */
}

/** Releases so many bytes: the record that tfa_tap_next found has r->found. */
static inline void tfa_tap_release(tfa_tap_reader *r, uint64_t bytes)
{
    r->read += bytes;
    atomic_store_explicit(&r->words->read, r->read, memory_order_release); /* T2 */
}

/* Bytes of the record or filler at the reader's position; 0: what lies there is neither. */
static inline uint64_t tfa_tap_piece(const tfa_tap_reader *r, bool *is_filler)
{
    const uint64_t at = r->read & (r->size - 1), rest = r->size - at, there = r->written - r->read;
    uint32_t head[4] = {0};
    if (there > r->size)
        return 0;
    __builtin_memcpy(head, r->bytes + at, rest < sizeof head ? rest : sizeof head);
    const uint64_t bytes = head[0];
    *is_filler = head[2] == 0;
    if (bytes % 8 != 0 || bytes > rest || bytes > there)
        return 0;
    return *is_filler || bytes >= sizeof(tfa_tap_record) ? bytes : 0;
}

/** The oldest record that is not released, of those that were there at the last look; releases
 *  fillers before it. NULL: none, or, if r->broken, what lies there is no record. */
static inline const tfa_tap_record *tfa_tap_next(tfa_tap_reader *r)
{
    while (!r->broken && r->read != r->written) {
        bool is_filler = false;
        r->found = tfa_tap_piece(r, &is_filler);
        r->broken = r->found == 0;
        if (r->broken)
            break;
        if (!is_filler)
            return (const tfa_tap_record *)(const void *)(r->bytes + (r->read & (r->size - 1)));
        tfa_tap_release(r, r->found);
    }
    return NULL;
}

/** Records that found no room, at least those before the last look. */
static inline uint64_t tfa_tap_dropped(const tfa_tap_words *words)
{
    return atomic_load_explicit(&words->dropped, memory_order_relaxed); /* T3 */
}

#endif
