/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Figures of a measured load: histograms of the round trip and its parts, and counters, in memory
 * of a fixed size.
 */
#ifndef TOOLS_LATENCY_LOOP_TALLY_H
#define TOOLS_LATENCY_LOOP_TALLY_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/histogram.h>

/** Resolution of the histograms, 0.8 %, and their buckets. */
#define LATENCY_BITS 8
#define LATENCY_BUCKETS TFA_HISTOGRAM_BUCKETS(LATENCY_BITS, 64)

/** Parts of a round trip; they add up to the whole. Client: from the intended time to the send, 0
 *  in a closed loop. */
enum {
    PART_ROUND_TRIP,
    PART_CLIENT,
    PART_REQUEST,
    PART_QUEUE,
    PART_COMPUTE,
    PART_REPLY,
    PART_COUNT
};

/** "round_trip", "client", "request", "queue", "compute", "reply". */
extern const char *const latency_parts[PART_COUNT];

/** A histogram and its memory. */
typedef struct latency_times {
    tfa_histogram h;
    uint64_t buckets[LATENCY_BUCKETS];
} latency_times;

/** Empties it; due before any use. */
void latency_times_init(latency_times *times);

/** One exchange: when it was due after the start, and its parts, in ns. */
typedef struct latency_sample {
    uint64_t index, at;
    uint64_t parts[PART_COUNT];
} latency_sample;

/** Round trips of about one duration: their number and the sums of their parts. */
typedef struct breakdown_row {
    uint64_t count;
    double sums[PART_COUNT];
} breakdown_row;

/* rows 3 % wide: every power of two is cut into 2^5 */
enum { BREAKDOWN_BITS = 6, BREAKDOWN_ROWS = 64 + 58 * 32 };

/** Mean parts of the round trips in the row of a duration. @return their number; 0: none */
uint64_t breakdown_at(const breakdown_row *rows, uint64_t round_trip, double means[PART_COUNT]);

enum { TALLY_SLICES = 10, TALLY_STATUSES = 16 };

/** Figures of one client, or of all. Made by tally_create. */
typedef struct tally {
    latency_times parts[PART_COUNT];
    latency_times slices[TALLY_SLICES]; /**< round trips of each tenth of the run */
    breakdown_row breakdown[BREAKDOWN_ROWS];
    latency_sample fastest, slowest; /**< the first of equals */
    uint64_t last;                   /**< round trip, ns */
    uint64_t sent;                   /**< requests that should have an answer */
    uint64_t lost;                   /**< no reply until the timeout, or the connection ended */
    uint64_t rejected;               /**< replies with a status other than TFA_OK */
    uint64_t late;                   /**< answered later than the deadline */
    uint64_t longest_run;            /**< of lost, rejected and late ones, by order of sending */
    uint64_t full;                   /**< found no room when they were due */
    uint64_t duplicates;             /**< replies to nothing, or once more */
    uint64_t stale;                  /**< replies to requests that were given up as lost */
    uint64_t reordered;              /**< replies overtaken by one to a later request (RFC 4737) */
    uint64_t reconnects;
    struct {
        int status;
        uint64_t count;
    } statuses[TALLY_STATUSES]; /**< of rejected ones; count 0 ends the list */
    uint16_t method;            /**< that answered last */
    uint64_t elapsed_ns;
    latency_sample *samples; /**< the first of them, at most sample_capacity */
    uint64_t sample_count, sample_capacity;
    uint64_t run;          /**< of misses, at present */
    _Atomic uint64_t done; /**< requests with an outcome; read by others for progress */
} tally;

/** Writes to every page, so that none is missing later: memset alone may become calloc, which does
 *  not. */
void memory_touch(void *memory, size_t size);

/** All memory touched. @return NULL: no memory */
tally *tally_create(uint64_t sample_capacity);
void tally_free(tally *t);

/** Adds one good exchange. `slice`: the tenth of the run. */
void tally_add(tally *t, const latency_sample *sample, unsigned slice);

/** Counts a reply by its status. */
void tally_reject(tally *t, int status);

/** Outcome of the next request by order of sending: a miss (or late) or not. */
void tally_outcome(tally *t, int missed);

/** Adds the figures of one client to those of all. */
void tally_merge(tally *all, const tally *client);

#endif
