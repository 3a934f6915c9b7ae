/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker takes requests from rings, solves them and answers. Its cycle is a plain function.
 *
 * Scheduling is fair by time (start-time fair queueing, Goyal, Vin and Cheng 1996): each client has
 * a virtual time that grows by the time that its requests take, and the client with the smallest
 * one is served next, for at most `turn_ns`. A longer request is answered in parts of that length,
 * cut by a cost model that learns from the clock; between two parts the worker looks at all clients
 * again. So a client waits for the part under way and for clients that have had less time than
 * itself, whatever the others ask for.
 *
 * Thread rules: tfa_worker_cycle and tfa_worker_sleep belong to the worker's thread (or to a
 * test that has none). tfa_worker_attach, _detach, _drain, _offer, _open, _close and _wake may be
 * called by any other thread; they share a mutex that the worker's thread never takes.
 *
 * States of a client's entry, the only memory that both sides write; state is atomic:
 *   FREE -> ATTACHED   attach: fills the entry, A6 store release   <-> R6 worker, load acquire
 *   ATTACHED -> BROKEN worker: the client broke the protocol or its memory is gone; no more
 *   requests
 *   -> DETACHING       detach, A7 store release                    <-> R7 worker, load acquire
 *   -> DRAINING        drain, A7: the worker answers earlier requests before it detaches
 *   DETACHING, DRAINING -> DETACHED  worker: will not touch it again, A8 release <-> R8 detach,
 *   acquire
 *   DETACHED -> FREE   detach or drain, which then owns the memory again
 *
 * The way of other solvers into a worker that runs, a pointer in each direction:
 *   offer  A12 store release, another thread <-> R12 worker, load acquire, in each cycle
 *   taken  A13 store release, worker         <-> R13 another thread, load acquire: no request under
 *          way uses the previous solvers; they belong to the offering thread again
 * The worker neither allocates nor frees, and a request is answered by one solver from its
 * beginning to its end. A client that is attached after an offer has the new ones: the worker
 * looks for an offer (R12) after it has seen the client (R6).
 *
 * Taps (ipc/tap.h) come and go by A14 to A16 of robot_taps.h. In a cycle that takes other solvers,
 * the worker looks for taps (R15) after the offer (R12), and for the tap of a request (R14) after
 * both: one that was taken away before the offer gets no answer of the offered solvers.
 */
#ifndef TFA_SERVICE_WORKER_WORKER_H
#define TFA_SERVICE_WORKER_WORKER_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <totalforce/client.h>
#include <totalforce/dynamics.h>

#include "config/config.h"
#include "ipc/ring.h"
#include "ipc/statistics_layout.h"

/**
 * Answers states first .. first + count - 1 of a request, as tfa_compute_states. first = 0 begins a
 * request: it is checked, and an estimate policy that it leaves open is settled in *request.
 * Called in the worker's thread: no allocation, no lock.
 */
typedef int (*tfa_solver)(void *self, tfa_request *request, tfa_reply *reply, uint32_t first,
                          uint32_t count);

/**
 * Answers a request again that the solver answered before, its estimate policy settled. Changes
 * nothing but the reply and the memory that each request overwrites. No allocation, no lock.
 */
typedef void (*tfa_warm_up)(void *self, const tfa_request *request, tfa_reply *reply);

struct tfa_cost_parts; /* cost_bound.h */

/** A robot, for a worker */
typedef struct tfa_worker_robot {
    tfa_wire_shape shape; /**< max_batch, max_tips: the most that any client may have */
    tfa_solver solve;
    tfa_warm_up warm_up; /**< NULL: its requests are not solved again */
    void *self;          /**< this worker's own (a workspace) */
    uint32_t max_state_ns; /**< requests of kinds whose states take longer are refused; 0: none */
    void *long_self;       /**< NULL, or `self` for them, in the thread of tfa_worker_long_run */
    const struct tfa_cost_parts *parts; /**< NULL: kinds that were not measured are refused, too */
} tfa_worker_robot;

/** Where a worker counts: blocks of the daemon's statistics. */
typedef struct tfa_worker_statistics {
    uint32_t number; /**< of the worker */
    tfa_shared_worker *worker;
    tfa_shared_client *clients; /**< TFA_WORKER_CLIENTS_MAX */
    tfa_shared_tally *departed; /**< by robot */
    tfa_shared_state *states;   /**< by robot */
} tfa_worker_statistics;

typedef struct tfa_worker_options {
    const tfa_worker_robot *robots; /**< copied */
    uint32_t robot_count;
    uint32_t spin_ns; /**< hybrid: sleeps after this time without a request */
    uint32_t turn_ns; /**< time of one client's turn; 0: TFA_WORKER_TURN_US */
    uint32_t warm_ns; /**< a worker that spins solves a request again so often; 0: never */
    uint32_t rest_ns; /**< rests so long for each ms that it runs; 0: never */
    tfa_wait wait;    /**< while no client asked for more: SPIN never sleeps, BLOCK at once */
    const tfa_worker_statistics *statistics; /**< copied; NULL: memory of the worker's own */
} tfa_worker_options;

struct tfa_tap; /* ipc/tap.h */
typedef struct tfa_worker tfa_worker;
typedef struct tfa_worker_client tfa_worker_client;

/** @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM (eventfd, epoll). On error *worker is NULL. */
TFA_CHECKED int tfa_worker_create(const tfa_worker_options *options, tfa_worker **worker);
/** No client may be attached, no thread may run. NULL is allowed. */
void tfa_worker_destroy(tfa_worker *worker);

/* ---- the worker's thread ---- */

/** Serves the clients that have work, the one with the least time first, for about one turn.
 *  @return pieces of work done: requests, or parts of long ones */
uint32_t tfa_worker_cycle(tfa_worker *worker);

/** Sleeps until a client or tfa_worker_wake wakes it, at most timeout_ms (-1: for ever). Returns
 *  at once when a request is there. */
void tfa_worker_sleep(tfa_worker *worker, int timeout_ms);

/** After a cycle or a wait: rests if it owes a rest (tfa_worker_options.rest_ns). */
void tfa_worker_rest(tfa_worker *worker);

/** Cycles, waits as the options say, until tfa_worker_stop; then answers the requests in the rings,
 *  for a tenth of a second at most. */
void tfa_worker_run(tfa_worker *worker);

/* ---- a thread beside it ---- */

/** Answers requests of shared-memory clients whose states take longer than max_state_ns, one at a
 *  time, until tfa_worker_long_stop. */
void tfa_worker_long_run(tfa_worker *worker);
/** Lets tfa_worker_long_run return; after the worker's end. */
void tfa_worker_long_stop(tfa_worker *worker);

/* ---- other threads ---- */

/** A request of a direct client: it lies in the client's memory, and so do its arrays, until its
 *  reply is published. */
typedef struct tfa_worker_call {
    tfa_request request;
    tfa_reply reply;     /**< in: the buffers; out: all of it */
    uint64_t deadline;   /**< CLOCK_MONOTONIC ns; 0: none. TFA_E_LATE if it begins later */
    uint64_t t_received; /**< out, and those below: CLOCK_MONOTONIC ns */
    uint64_t t_start, t_done;
} tfa_worker_call;

/** Parts of a client of a worker */
typedef struct tfa_worker_client_options {
    uint32_t robot;           /**< index in the worker's robots */
    uint32_t max_batch;       /**< at most that of the robot */
    uint32_t max_tips;        /**< the same */
    tfa_ring_layout layout;   /**< for the shape with these: tfa_ring_layout_of */
    const void *requests;     /**< layout.request_bytes, may be hostile shared memory */
    void *replies;            /**< layout.reply_bytes */
    tfa_wait wait;            /**< SPIN: the worker does not sleep while this client is active */
    int doorbell;             /**< eventfd by which the client wakes the worker, or -1 */
    bool internal;            /**< in this process: its memory is not guarded */
    bool direct;              /**< internal, and `id` of a request is the address of a
                                 tfa_worker_call: nothing is encoded */
    tfa_served_client served; /**< kind (NONE: SELF), process, user, since */
} tfa_worker_client_options;

/** Attaches a client. @return TFA_OK; TFA_E_REFUSED (no entry left); TFA_E_MEMORY;
 *  TFA_E_SYSTEM. The memory must stay until tfa_worker_detach returned true. */
TFA_CHECKED int tfa_worker_attach(tfa_worker *worker, const tfa_worker_client_options *options,
                                  tfa_worker_client **client);

/** Asks the worker to detach a client. @return true: it has, the entry is free. Otherwise call
 *  again in a while; the first call asks. True at once while no thread is in tfa_worker_run. */
bool tfa_worker_detach(tfa_worker *worker, tfa_worker_client *client);

/** As tfa_worker_detach, but lets the worker answer earlier requests of the client. Bounded: as
 *  many requests as the ring has slots, for a second of the worker's time at most.
 *  tfa_worker_detach may still be called instead. */
bool tfa_worker_drain(tfa_worker *worker, tfa_worker_client *client);

/** Offers the worker other solvers for all its robots: `robots` (copied) in the same order. A robot
 *  may change its shape only while no client is attached to it. The offer before must be taken. */
void tfa_worker_offer(tfa_worker *worker, const tfa_worker_robot *robots);

/** The worker took the last offer: it will not touch the previous solvers again. True as well
 *  while no thread is in tfa_worker_run. */
bool tfa_worker_offer_is_taken(const tfa_worker *worker);

/** Requests of a robot that are answered from now on go to this tap, too; NULL: to none. */
void tfa_worker_set_tap(tfa_worker *worker, uint32_t robot, struct tfa_tap *tap);

/** The worker will not touch a tap again that tfa_worker_set_tap took away. */
bool tfa_worker_taps_are_taken(const tfa_worker *worker);

/** The worker stopped serving this client: it broke the protocol. */
bool tfa_worker_client_is_broken(const tfa_worker_client *client);
/** What was counted since the client came. */
tfa_tally_sums tfa_worker_client_sums(const tfa_worker_client *client);

/** Wakes the worker's thread if it sleeps. */
void tfa_worker_wake(tfa_worker *worker);
/** Lets tfa_worker_run return after it answered the requests in the rings. */
void tfa_worker_stop(tfa_worker *worker);
/** Grows with each cycle: a worker that sleeps cycles once a second. */
uint64_t tfa_worker_heartbeat(const tfa_worker *worker);

#endif
