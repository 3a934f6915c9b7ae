/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics in shared memory: one segment for each daemon, which readers map read-only. The daemon
 * reads nothing from it but its own counters.
 *
 * Each block has one writer at a time: a worker, a gateway under the mutex of its robot or in its
 * thread, or the thread that attaches and detaches clients under the mutex of the worker. A block
 * is a record with a version (sequence lock without fences: Boehm, Can seqlocks get along with
 * programming language memory models?, 2012):
 *
 *   S1  version := odd, relaxed                      before each of
 *   S2  words, release        <-> T2 acquire         a reader that sees a word of this write sees
 *                                                    S1 or later at T3 and begins again
 *   S3  version := even, release <-> T1 acquire      a reader that sees it sees all words
 *   T3  version again, relaxed, after T2
 *
 * A worker's attachments are such a record as a whole: its version changes around attaching and
 * around moving the counters of a client that leaves to those of the departed.
 *
 * Figures with a word of their own (heartbeat, queued, last receipts, DDS) are relaxed: they order
 * nothing.
 */
#ifndef TFA_IPC_STATISTICS_LAYOUT_H
#define TFA_IPC_STATISTICS_LAYOUT_H

#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/request.h>
#include <totalforce/statistics.h>

#define TFA_STATISTICS_MAGIC UINT64_C(0x31746174536166) /* "faStat1" */
#define TFA_STATISTICS_ABI 1
#define TFA_STATISTICS_LINE 64
/** Bounds of what a reader accepts. */
#define TFA_STATISTICS_WORKERS_MAX 1024
#define TFA_STATISTICS_ROBOTS_MAX 65536
#define TFA_STATISTICS_CLIENTS_MAX 65536
/** Sources of states besides the workers. */
enum { TFA_SOURCE_DDS, TFA_SOURCE_ROS2, TFA_GATEWAY_SOURCES };

typedef _Atomic uint64_t tfa_counter;

#define TFA_WORDS_OF(type) ((sizeof(type) + 7) / 8)

/* ---- words of one writer ---- */

static inline void tfa_counter_set(tfa_counter *word, uint64_t value)
{
    atomic_store_explicit(word, value, memory_order_release); /* S2 */
}

/* One writer: no read-modify-write is needed. */
static inline void tfa_counter_add(tfa_counter *word, uint64_t n)
{
    tfa_counter_set(word, atomic_load_explicit(word, memory_order_relaxed) + n);
}

static inline void tfa_record_begin(tfa_counter *version)
{
    atomic_store_explicit(version, atomic_load_explicit(version, memory_order_relaxed) + 1,
                          memory_order_relaxed); /* S1 */
}

static inline void tfa_record_end(tfa_counter *version)
{
    tfa_counter_add(version, 1); /* S3 */
}

/** Writes `bytes` of a plain object, a multiple of 8, as words of a record. */
void tfa_words_write(tfa_counter *words, const void *from, size_t bytes);
void tfa_words_clear(tfa_counter *words, size_t count);

/** Writes a record: begin, words, end. */
void tfa_record_write(tfa_counter *version, tfa_counter *words, const void *from, size_t bytes);

/** Copies a record. @return false: it was being written all the time */
bool tfa_record_read(const tfa_counter *version, const tfa_counter *words, void *to, size_t bytes);

/** T1: an even version to begin with; odd: it was being written all the time. */
uint64_t tfa_record_version(const tfa_counter *version);
/** T3 */
static inline bool tfa_record_is_valid(const tfa_counter *version, uint64_t began)
{
    return atomic_load_explicit(version, memory_order_relaxed) == began;
}

/* ---- counters of requests ---- */

/** Words of a tally. The first 6 and those from the maxima to the method aba change with nearly
 *  every request: with the version before them they are one line each. */
enum {
    TFA_TALLY_MORE_STATES, /* of a request with answers, besides the first */
    TFA_TALLY_PAUSES,      /* ns between start and done that went to other requests */
    TFA_TALLY_SUMS,        /* queue, compute, total */
    TFA_TALLY_STATUSES = TFA_TALLY_SUMS + 3,
    TFA_TALLY_MAXIMA = TFA_TALLY_STATUSES + TFA_STATISTICS_STATUSES, /* queue, compute, total */
    TFA_TALLY_METHODS = TFA_TALLY_MAXIMA + 3,
    TFA_TALLY_FLAGS = TFA_TALLY_METHODS + TFA_STATISTICS_METHODS, /* by bit of tfa_answer.flags */
    TFA_TALLY_REFINED = TFA_TALLY_FLAGS + 8,
    TFA_TALLY_LARGEST, /* estimate, bits of a double: those of positive ones are ordered */
    TFA_TALLY_DECADES,
    TFA_TALLY_WORDS = TFA_TALLY_DECADES + TFA_STATISTICS_DECADES
};

enum { TFA_TIME_QUEUE, TFA_TIME_COMPUTE, TFA_TIME_TOTAL, TFA_TIMES };

typedef struct tfa_shared_tally {
    alignas(TFA_STATISTICS_LINE) tfa_counter version;
    tfa_counter words[TFA_TALLY_WORDS];
    tfa_counter buckets[TFA_TIMES][TFA_STATISTICS_BUCKETS];
} tfa_shared_tally;

/** An answered request. */
typedef struct tfa_tally_request {
    int status;
    bool has_answers;
    bool refined;
    uint32_t states;
    const tfa_answer *answers; /**< of the states, or NULL: not known */
    uint64_t busy_ns;
    uint64_t sent; /**< CLOCK_MONOTONIC ns; 0, or after `done`: not known */
    uint64_t received, start, done;
} tfa_tally_request;

/** Counts a request. No allocation, no lock, no system call. */
void tfa_tally_count(tfa_shared_tally *tally, const tfa_tally_request *request);
/** Adds the counters of `from`, whose writer has ended. */
void tfa_tally_add(tfa_shared_tally *tally, const tfa_shared_tally *from);
void tfa_tally_clear(tfa_shared_tally *tally);

/** Sums for messages of the daemon; the writer may be at work. */
typedef struct tfa_tally_sums {
    uint64_t requests, rejected, late, busy_ns;
} tfa_tally_sums;
void tfa_tally_sum(const tfa_shared_tally *tally, tfa_tally_sums *sums);

/* ---- blocks ---- */

#define TFA_RECORD(type)                                                                           \
    struct {                                                                                       \
        tfa_counter version;                                                                       \
        tfa_counter words[TFA_WORDS_OF(type)];                                                     \
    }

typedef struct tfa_shared_client {
    alignas(TFA_STATISTICS_LINE) tfa_counter served[TFA_WORDS_OF(tfa_served_client)]; /* of the
                                                                          worker's attachments */
    tfa_counter queued;
    tfa_shared_tally tally;
} tfa_shared_client;

typedef struct tfa_shared_worker {
    alignas(TFA_STATISTICS_LINE) tfa_counter version; /* of the attachments */
    tfa_counter clients_used;                         /* entries beyond were never used */
    alignas(TFA_STATISTICS_LINE) tfa_counter heartbeat;
} tfa_shared_worker;

/** Header of a tfa_robot_state, then base_pose and q. */
typedef struct tfa_shared_state {
    alignas(TFA_STATISTICS_LINE) tfa_counter version;
    tfa_counter words[TFA_WORDS_OF(tfa_robot_state)];
} tfa_shared_state;

typedef struct tfa_shared_robot {
    alignas(TFA_STATISTICS_LINE) TFA_RECORD(tfa_served_robot) served; /* control thread */
    TFA_RECORD(tfa_ros2_statistics) ros2;                             /* thread of ROS 2 */
    tfa_counter dds_request, dds_torques;                             /* under the robot's mutex */
    tfa_shared_tally gateway[TFA_GATEWAY_SOURCES]; /* requests that gateways answer themselves */
} tfa_shared_robot;

/** Messages of the DDS gateway. Several receiving threads: read-modify-writes. */
typedef struct tfa_shared_dds {
    tfa_counter requests, torques, replies, rejected, late, unknown, dropped, handovers, standby;
    /* the leader thread alone */
    tfa_counter request_writers, reply_readers, torque_writers, acceleration_readers;
} tfa_shared_dds;

typedef struct tfa_shared_header {
    alignas(TFA_STATISTICS_LINE) uint64_t magic; /* these are constant */
    uint32_t abi;
    int32_t process;
    uint64_t bytes;                    /* of the segment */
    uint64_t start;                    /* CLOCK_MONOTONIC ns */
    uint32_t workers, robots, clients; /* clients: of a worker */
    uint32_t dds;
    char version[32];
    char runtime_dir[112];                                /* a socket's path is no longer */
    alignas(TFA_STATISTICS_LINE) tfa_counter connections; /* control thread, relaxed */
    tfa_counter refused, reloads, stopped;
    tfa_shared_dds dds_messages;
} tfa_shared_header;

/** Offsets of the sections. */
typedef struct tfa_statistics_layout {
    size_t robots, workers, clients, departed, states, bytes;
} tfa_statistics_layout;

/** Layout of a segment; the counts are within their bounds. */
static inline tfa_statistics_layout tfa_statistics_layout_of(size_t workers, size_t robots,
                                                             size_t clients)
{
    tfa_statistics_layout l;
    l.robots = sizeof(tfa_shared_header);
    l.workers = l.robots + robots * sizeof(tfa_shared_robot);
    l.clients = l.workers + workers * sizeof(tfa_shared_worker);
    l.departed = l.clients + workers * clients * sizeof(tfa_shared_client);
    l.states = l.departed + workers * robots * sizeof(tfa_shared_tally);
    l.bytes = l.states + (workers + TFA_GATEWAY_SOURCES) * robots * sizeof(tfa_shared_state);
    return l;
}

/** A segment. Writers and readers reach the blocks by these. */
typedef struct tfa_statistics_view {
    tfa_shared_header *header;
    tfa_shared_robot *robots;
    tfa_shared_worker *workers;
    tfa_shared_client *clients; /**< by worker, then slot */
    tfa_shared_tally *departed; /**< by worker, then robot */
    tfa_shared_state *states;   /**< by worker, then DDS and ROS 2, then robot */
} tfa_statistics_view;

static inline tfa_statistics_view tfa_statistics_view_of(void *memory,
                                                         const tfa_statistics_layout *l)
{
    unsigned char *at = memory;
    return (tfa_statistics_view){(void *)at,
                                 (void *)(at + l->robots),
                                 (void *)(at + l->workers),
                                 (void *)(at + l->clients),
                                 (void *)(at + l->departed),
                                 (void *)(at + l->states)};
}

/** Publishes the first state of a request as the robot's last one, unless one was published within
 *  the last 10 ms. */
void tfa_state_publish(tfa_shared_state *state, const tfa_request *request, uint32_t q_count,
                       bool floating, uint64_t now);

_Static_assert(sizeof(tfa_served_robot) % 8 == 0 && sizeof(tfa_served_client) % 8 == 0 &&
                   sizeof(tfa_robot_state) % 8 == 0 && sizeof(tfa_ros2_statistics) % 8 == 0,
               "records are whole words");
_Static_assert(offsetof(tfa_shared_tally, words[TFA_TALLY_MAXIMA]) / TFA_STATISTICS_LINE ==
                   offsetof(tfa_shared_tally, words[TFA_TALLY_METHODS + TFA_METHOD_ABA]) /
                       TFA_STATISTICS_LINE,
               "the second hot line");

#endif
