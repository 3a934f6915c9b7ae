/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ring between one client and one worker: pure operations on memory, no system call.
 *
 * Two segments. The client writes the first (a line with its sleep flag, then request slots), the
 * worker writes the second (its status, then reply slots). Request i (from 0) takes request slot i
 * mod slots, its reply takes the reply slot of the same number, so as long as a client has at most
 * `slots` requests outstanding nothing overflows, and neither side reads the other's position.
 * No memory is shared between clients: a client that spoils a segment spoils its own.
 *
 * Concurrency: one thread uses the client's end, one thread the worker's end.
 *
 * Atomics and their pairs. A is the writer, R the reader.
 *
 *   A1 request.seq  store release   ->  R1 load acquire  (worker): the request's bytes are visible
 *   A2 reply.seq    store release   ->  R2 load acquire  (client): the reply's bytes are visible,
 *                                       and the worker has done with the request slot
 *   A1 also says that the client has done with reply slot i - slots: it sends request i only after
 *   R2 of reply i - slots and after reading it. So each slot has one owner at any time.
 *
 *   Sleeping needs store before load, on both sides, hence seq_cst on all four:
 *   A3 worker_status.asleep = 1, then R1 once more, then sleep    (worker)
 *   A1, then R3 worker_status.asleep, then wake if set            (client)
 *   A4 client_flags.asleep = 1, then R2 once more, then sleep     (client)
 *   A2, then R4 client_flags.asleep, then wake if set             (worker)
 *   In the single order of seq_cst either the sleeper's recheck sees the publication or the
 *   publisher sees the flag. A stale flag costs one needless wake-up.
 *   Where both sides agreed to spin there are no flags, and A1 and A2 are plain release.
 *
 *   A5 worker_status.heartbeat store relaxed -> R5 load relaxed: only "did it change" is asked, by
 *   a client that has waited long.
 */
#ifndef TFA_IPC_RING_H
#define TFA_IPC_RING_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ipc/wire.h"

#define TFA_RING_SLOTS_MAX 4096

/** First line of the request segment, written by the client */
typedef struct tfa_ring_client_flags {
    _Alignas(TFA_CACHE_LINE) _Atomic uint32_t asleep; /** A4, R4: the worker wakes the client
                                                         after a reply */
} tfa_ring_client_flags;

/** Head of the reply segment: status of the worker, one copy for each client */
typedef struct tfa_ring_worker_status {
    _Alignas(TFA_CACHE_LINE) _Atomic uint32_t asleep;    /** A3, R3: the client wakes the worker
                                                            after a request */
    _Alignas(TFA_CACHE_LINE) _Atomic uint64_t heartbeat; /** A5, R5: grows while the worker runs */
} tfa_ring_worker_status;

typedef struct tfa_ring_layout {
    uint32_t slots; /**< a power of two */
    uint32_t reserved;
    size_t request_stride, reply_stride; /**< bytes from slot to slot */
    size_t request_bytes, reply_bytes;   /**< of the segments */
} tfa_ring_layout;

/** The client's end. */
typedef struct tfa_ring_client {
    tfa_ring_layout layout;
    unsigned char *requests;
    const unsigned char *replies;
    const tfa_ring_worker_status *worker_status;
    uint64_t sent, received; /**< requests sent; replies released. Private to the client */
    bool spin;               /**< both sides agreed never to sleep */
} tfa_ring_client;

/** The worker's end. */
typedef struct tfa_ring_server {
    tfa_ring_layout layout;
    const unsigned char *requests; /** written by the client: untrusted */
    unsigned char *replies;
    uint64_t next; /** next request. Private to the worker */
    bool spin;
} tfa_ring_server;

/** Slot strides are an odd number of lines, so that the first lines of the slots spread over the
 *  sets of the caches. */
static inline size_t tfa_ring_stride(size_t bytes)
{
    size_t lines = (bytes + TFA_CACHE_LINE - 1) / TFA_CACHE_LINE;
    return (lines | 1) * TFA_CACHE_LINE;
}

static inline tfa_ring_layout tfa_ring_layout_of(const tfa_wire_shape *shape, uint32_t slots)
{
    tfa_ring_layout layout = {.slots = slots,
                              .request_stride = tfa_ring_stride(tfa_wire_request_capacity(shape)),
                              .reply_stride = tfa_ring_stride(tfa_wire_reply_capacity(shape))};
    layout.request_bytes = sizeof(tfa_ring_client_flags) + slots * layout.request_stride;
    layout.reply_bytes = sizeof(tfa_ring_worker_status) + slots * layout.reply_stride;
    return layout;
}

static inline bool tfa_ring_slots_valid(uint32_t slots)
{
    return slots != 0 && (slots & (slots - 1)) == 0 && slots <= TFA_RING_SLOTS_MAX;
}

static inline size_t tfa_ring_request_offset(const tfa_ring_layout *layout, uint64_t index)
{
    return sizeof(tfa_ring_client_flags) +
           (size_t)(index & (layout->slots - 1)) * layout->request_stride;
}

static inline size_t tfa_ring_reply_offset(const tfa_ring_layout *layout, uint64_t index)
{
    return sizeof(tfa_ring_worker_status) +
           (size_t)(index & (layout->slots - 1)) * layout->reply_stride;
}

/** Prefetches lines 2 to 5 of a slot that this side writes next: they are in the other side's
 *  cache. Not the first line, which the other side polls. They hold the request of seven joints
 *  and most replies. Only together with tfa_ring_demote_lines does it gain time. */
static inline void tfa_ring_prefetch_for_write(const void *slot)
{
    const unsigned char *at = slot;
    for (size_t line = 0; line < 4; line++)
        __builtin_prefetch(at + line * TFA_CACHE_LINE, 1);
}

/* Lines of a slot that are demoted: the request of up to 18 joints */
#define TFA_RING_DEMOTED_LINES 8

/** After a publication: moves the slot's first lines to a shared cache level (CLDEMOTE; a no-op on
 *  other processors). It shortens a round trip of seven joints by a quarter
 *  (tests/bench/latency.sh). */
static inline void tfa_ring_demote_lines(const void *slot, size_t stride)
{
#if defined(__x86_64__)
    const unsigned char *at = slot;
    size_t end = TFA_RING_DEMOTED_LINES * TFA_CACHE_LINE;
    end = stride < end ? stride : end;
    for (size_t k = 0; k < end; k += TFA_CACHE_LINE)
        __asm__ volatile("cldemote %0" : : "m"(at[k]));
#else
    (void)slot;
    (void)stride;
#endif
}

/* ---- the client's end ---- */

static inline bool tfa_ring_full(const tfa_ring_client *c)
{
    return c->sent - c->received == c->layout.slots;
}

/** The slot to write the next request into. The ring must not be full. */
static inline void *tfa_ring_next_request(const tfa_ring_client *c)
{
    return c->requests + tfa_ring_request_offset(&c->layout, c->sent);
}

/** Publishes the request in that slot. @return true: the worker sleeps, wake it */
static inline bool tfa_ring_send(tfa_ring_client *c)
{
    tfa_wire_request *line = tfa_ring_next_request(c);
    c->sent++;
    if (c->spin) {
        atomic_store_explicit(&line->seq, c->sent, memory_order_release); /* A1 */
        tfa_ring_demote_lines(line, c->layout.request_stride);
        return false;
    }
    atomic_store_explicit(&line->seq, c->sent, memory_order_seq_cst);                  /* A1 */
    return atomic_load_explicit(&c->worker_status->asleep, memory_order_seq_cst) != 0; /* R3 */
}

/** Slot of the oldest reply that is not released. */
static inline const void *tfa_ring_oldest_reply(const tfa_ring_client *c)
{
    return c->replies + tfa_ring_reply_offset(&c->layout, c->received);
}

/** True if the oldest reply has come. */
static inline bool tfa_ring_reply_ready(const tfa_ring_client *c)
{
    const tfa_wire_reply *line = tfa_ring_oldest_reply(c);
    return atomic_load_explicit(&line->seq, memory_order_acquire) == c->received + 1; /* R2 */
}

/** Releases the slot of the oldest reply. */
static inline void tfa_ring_release(tfa_ring_client *c)
{
    c->received++;
    tfa_ring_prefetch_for_write(tfa_ring_next_request(c));
}

static inline tfa_ring_client_flags *tfa_ring_client_flags_of(const tfa_ring_client *c)
{
    return (tfa_ring_client_flags *)(void *)c->requests;
}

/** Sets the sleep flag before waiting for reply `index`. @return seq of its slot; above `index` the
 *  reply has come: do not sleep. */
static inline uint64_t tfa_ring_client_prepare_wait(const tfa_ring_client *c, uint64_t index)
{
    const tfa_wire_reply *line =
        (const void *)(c->replies + tfa_ring_reply_offset(&c->layout, index));
    atomic_store_explicit(&tfa_ring_client_flags_of(c)->asleep, 1, memory_order_seq_cst); /* A4 */
    return atomic_load_explicit(&line->seq, memory_order_seq_cst);                        /* R2 */
}

static inline void tfa_ring_client_end_wait(const tfa_ring_client *c)
{
    atomic_store_explicit(&tfa_ring_client_flags_of(c)->asleep, 0, memory_order_relaxed); /* A4 */
}

/* ---- the worker's end ---- */

static inline tfa_ring_worker_status *tfa_ring_worker_status_of(const tfa_ring_server *s)
{
    return (tfa_ring_worker_status *)(void *)s->replies;
}

typedef enum tfa_ring_state { TFA_RING_EMPTY, TFA_RING_READY, TFA_RING_BROKEN } tfa_ring_state;

static inline tfa_ring_state tfa_ring_classify_sequence(const tfa_ring_server *s, uint64_t seq)
{
    if (seq == s->next + 1)
        return TFA_RING_READY;
    /* the only other valid value is that of the lap before */
    uint64_t before = s->next < s->layout.slots ? 0 : s->next + 1 - s->layout.slots;
    return seq == before ? TFA_RING_EMPTY : TFA_RING_BROKEN;
}

/** The slot of the next request. */
static inline const void *tfa_ring_request(const tfa_ring_server *s)
{
    return s->requests + tfa_ring_request_offset(&s->layout, s->next);
}

/** State of the next request. TFA_RING_BROKEN: a sequence number outside the window. */
static inline tfa_ring_state tfa_ring_poll(const tfa_ring_server *s)
{
    const tfa_wire_request *line = tfa_ring_request(s);
    return tfa_ring_classify_sequence(
        s, atomic_load_explicit(&line->seq, memory_order_acquire)); /* R1 */
}

/** As tfa_ring_poll, between A3 and sleep. */
static inline tfa_ring_state tfa_ring_poll_last(const tfa_ring_server *s)
{
    const tfa_wire_request *line = tfa_ring_request(s);
    return tfa_ring_classify_sequence(
        s, atomic_load_explicit(&line->seq, memory_order_seq_cst)); /* R1 */
}

/** Slot of the reply to the next request. */
static inline void *tfa_ring_reply(const tfa_ring_server *s)
{
    return s->replies + tfa_ring_reply_offset(&s->layout, s->next);
}

/** Publishes that reply and moves to the next request. @return true: the client sleeps, wake it */
static inline bool tfa_ring_publish(tfa_ring_server *s)
{
    tfa_wire_reply *line = tfa_ring_reply(s);
    const tfa_ring_client_flags *client_flags =
        (const tfa_ring_client_flags *)(const void *)s->requests;
    s->next++;
    if (s->spin) {
        atomic_store_explicit(&line->seq, s->next, memory_order_release); /* A2 */
        tfa_ring_demote_lines(line, s->layout.reply_stride);
        return false;
    }
    atomic_store_explicit(&line->seq, s->next, memory_order_seq_cst);              /* A2 */
    return atomic_load_explicit(&client_flags->asleep, memory_order_seq_cst) != 0; /* R4 */
}

/* ---- both ---- */

/** Word of a reply slot on which a client sleeps: the low half of seq, which changes with each
 *  publication (futexes have 32 bits). */
static inline const uint32_t *tfa_ring_futex_word(const void *reply_slot)
{
    _Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the low half of seq comes first");
    return reply_slot;
}

/** Pause instruction of a waiting loop */
static inline void tfa_ring_cpu_relax(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

#endif
