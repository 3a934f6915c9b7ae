/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A tap: requests and answers of one robot on their way from the daemon to a recorder, and the
 * records of a recording. Pure operations on memory, no system call.
 *
 * One segment holds a ring of bytes for each producer: the workers, then the DDS gateway, then the
 * ROS 2 gateway. A record lies in one piece: where it would not fit before the end of the ring, a
 * filler takes the rest. A record that finds no room is dropped whole and counted. The daemon reads
 * one word of a segment, the recorder's position, and only copies and bounds it: a recorder that
 * spoils its segment spoils its own recording.
 *
 * Atomics and their pairs. A is the writer, R the reader.
 *
 *   T1 written  store release (producer)  ->  load acquire (recorder): the record's bytes are
 *               visible
 *   T2 read     store release (recorder)  ->  load acquire (producer): the recorder has done with
 *               the bytes before it
 *   T3 dropped  store relaxed             ->  load relaxed: a figure
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
    _Alignas(TFA_WIRE_LINE) uint64_t magic;
    uint32_t producers, reserved;
    uint64_t ring_bytes; /**< of each */
} tfa_tap_head;

/** The words of a ring. */
typedef struct tfa_tap_words {
    _Alignas(TFA_WIRE_LINE) _Atomic uint64_t written; /**< T1: bytes since the beginning */
    _Atomic uint64_t dropped;                         /**< T3: records */
    _Alignas(TFA_WIRE_LINE) _Atomic uint64_t read;    /**< T2: bytes; untrusted */
} tfa_tap_words;

/** The producer's end: private, one thread at a time. */
typedef struct tfa_tap {
    _Alignas(TFA_WIRE_LINE) tfa_tap_words *words;
    unsigned char *bytes;
    uint64_t size;    /**< of the ring */
    uint64_t written; /**< what it last wrote into `words` */
    uint64_t read;    /**< what it last saw there */
    uint64_t dropped;
    uint16_t producer;
} tfa_tap;

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

/** Room for a record of so many bytes, a multiple of 8; NULL: none, and it was counted. */
static inline tfa_tap_record *tfa_tap_reserve(tfa_tap *tap, uint64_t bytes)
{
    const uint64_t at = tap->written & (tap->size - 1), rest = tap->size - at;
    const uint64_t filler = bytes <= rest ? 0 : rest;
    if (bytes > tap->size || !tfa_tap_has_room(tap, filler + bytes)) {
        tfa_tap_drop(tap);
        return NULL;
    }
    if (!filler)
        return (tfa_tap_record *)(void *)(tap->bytes + at);
    /* the last 8 bytes of a ring hold less than a head: its first two words are enough */
    const uint32_t head[4] = {(uint32_t)filler, 0, 0, 0};
    __builtin_memcpy(tap->bytes + at, head, filler < sizeof head ? filler : sizeof head);
    tap->written += filler;
    return (tfa_tap_record *)(void *)tap->bytes;
}

/** Publishes the record that was reserved. */
static inline void tfa_tap_publish(tfa_tap *tap, uint64_t bytes)
{
    tap->written += bytes;
    atomic_store_explicit(&tap->words->written, tap->written, memory_order_release); /* T1 */
}

/* ---- the recorder's end ---- */

/** The head of the next record of a ring between `read` and `written`, or of a filler. NULL: what
 *  lies there is no record. */
static inline const tfa_tap_record *tfa_tap_next(const unsigned char *ring, uint64_t size,
                                                 uint64_t read, uint64_t written)
{
    const uint64_t at = read & (size - 1), rest = size - at, there = written - read;
    uint32_t head[4] = {0};
    if (there > size || there < 8 || read % 8 != 0)
        return NULL;
    __builtin_memcpy(head, ring + at, rest < sizeof head ? rest : sizeof head);
    const uint64_t bytes = head[0];
    if (bytes < 8 || bytes % 8 != 0 || bytes > rest || bytes > there)
        return NULL;
    if (head[2] != 0 && bytes < sizeof(tfa_tap_record))
        return NULL;
    return (const tfa_tap_record *)(const void *)(ring + at);
}

#endif
