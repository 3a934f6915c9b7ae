/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker takes requests from rings, solves them and answers. Its cycle is a plain function.
 *
 * Thread rules: tfa_worker_cycle and tfa_worker_sleep belong to the worker's thread (or to a
 * test that has none). tfa_worker_attach, _detach, _drain, _offer, _open, _close and _wake may be
 * called by any other thread; they share a mutex that the worker's thread never takes.
 *
 * States of a client's entry, the only memory that both sides write; state is atomic:
 *   FREE -> ATTACHED   attach: fills the entry, A6 store release   <-> R6 worker, load acquire
 *   ATTACHED -> BROKEN worker: the client broke the protocol or its memory is gone; no more
 *   requests
 *   -> DETACHING        detach, A7 store release                   <-> R7 worker, load acquire
 *   -> DRAINING       drain, A7: the worker answers earlier requests before it detaches
 *   DETACHING, DRAINING -> DETACHED  worker: will not touch it again, A8 release <-> R8 detach,
 *   acquire
 *   DETACHED -> FREE      detach or drain, which then owns the memory again
 *
 * The way of other solvers into a worker that runs, a pointer in each direction:
 *   offer  A12 store release, another thread <-> R12 worker, load acquire, before every request
 *   taken  A13 store release, worker         <-> R13 another thread, load acquire: the worker will
 *          not touch the solvers of before again, and whoever offered owns them
 * The worker neither allocates nor frees, and a request is answered by one of them from its
 * beginning to its end. A client that is attached after an offer has the new ones: the worker
 * looks for an offer (R12) after it has seen the client (R6).
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

/** Requests of others between the parts of a long request: the solver calls
 *  between(context). The solver may be called for other, short requests meanwhile. */
typedef struct tfa_yield {
    void (*serve_others)(void *context);
    void *context;
} tfa_yield;

/** Answers one request, as tfa_compute. Called in the worker's thread: no allocation, no lock.
 *  `pause` is NULL for requests of at most `cut` states. */
typedef int (*tfa_solver)(void *self, const tfa_request *request, tfa_reply *reply,
                          const tfa_yield *yield);

/** A robot, for a worker */
typedef struct tfa_worker_robot {
    tfa_wire_shape shape; /**< max_batch: the most that any client may have */
    tfa_solver solve;
    void *self;   /**< this worker's own (a workspace) */
    uint32_t cut; /**< requests of more states are long: others' short ones come between their
                       parts; 0: none is */
} tfa_worker_robot;

typedef struct tfa_worker_options {
    const tfa_worker_robot *robots; /**< copied */
    uint32_t robot_count;
    uint32_t spin_ns; /**< hybrid: sleeps after so long without a request */
    tfa_wait wait;    /**< while no client asked for more: SPIN never sleeps, BLOCK at once */
    /** in memory that clients can read; NULL: private memory */
    tfa_ring_worker_status *worker_status;
} tfa_worker_options;

typedef struct tfa_worker tfa_worker;
typedef struct tfa_worker_client tfa_worker_client;

/** Counted since the client came. Relaxed: only ever read as figures. */
typedef struct tfa_worker_client_counters {
    _Atomic uint64_t requests, rejected;
} tfa_worker_client_counters;

/** @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM (eventfd, epoll). On error *worker is NULL. */
TFA_CHECKED int tfa_worker_create(const tfa_worker_options *options, tfa_worker **worker);
/** No client may be attached, no thread may run. NULL is allowed. */
void tfa_worker_destroy(tfa_worker *worker);

/* ---- the worker's thread ---- */

/** One turn over all clients, a bounded number of requests each. @return requests answered */
uint32_t tfa_worker_cycle(tfa_worker *worker);

/** Sleeps until a client or tfa_worker_wake wakes it, at most timeout_ms (-1: for ever). Returns
 *  at once when a request is there. */
void tfa_worker_sleep(tfa_worker *worker, int timeout_ms);

/** Cycles, waits as the options say, until tfa_worker_stop; then answers the requests in the
 * rings. */
void tfa_worker_run(tfa_worker *worker);

/* ---- other threads ---- */

/** Parts of a client of a worker */
typedef struct tfa_worker_client_options {
    uint32_t robot;         /**< index in the worker's robots */
    uint32_t max_batch;     /**< at most that of the robot */
    tfa_ring_layout layout; /**< for shape and max_batch: tfa_ring_layout_of */
    const void *requests;   /**< layout.request_bytes, may be hostile shared memory */
    void *replies;          /**< layout.reply_bytes */
    tfa_wait wait;          /**< SPIN: the worker does not sleep while this client is attached */
    int doorbell;           /**< eventfd by which the client wakes the worker, or -1 */
    bool internal;          /**< in this process: wakes by a private futex */
} tfa_worker_client_options;

/** Attaches a client. @return TFA_OK; TFA_E_REFUSED (no entry left); TFA_E_MEMORY;
 *  TFA_E_SYSTEM. The memory must stay until tfa_worker_detach returned true. */
TFA_CHECKED int tfa_worker_attach(tfa_worker *worker, const tfa_worker_client_options *options,
                                  tfa_worker_client **client);

/** Asks the worker to detach a client. @return true: it has, the entry is free. Otherwise call
 *  again in a while; the first call asks. True at once while no thread is in tfa_worker_run. */
bool tfa_worker_detach(tfa_worker *worker, tfa_worker_client *client);

/** As tfa_worker_detach, but lets the worker answer earlier requests of the client. Bounded: as
 *  many requests as the ring has slots. tfa_worker_detach may still be called instead. */
bool tfa_worker_drain(tfa_worker *worker, tfa_worker_client *client);

/** Offers the worker other solvers for all its robots: `robots` (copied) in the same order. A robot
 *  may change its shape only while no client is attached to it. The offer before must be taken. */
void tfa_worker_offer(tfa_worker *worker, const tfa_worker_robot *robots);

/** The worker took the last offer: it will not touch the solvers of before again. True as well
 *  while no thread is in tfa_worker_run. */
bool tfa_worker_offer_is_taken(const tfa_worker *worker);

/** The worker stopped serving this client: it broke the protocol. */
bool tfa_worker_client_is_broken(const tfa_worker_client *client);
const tfa_worker_client_counters *tfa_worker_client_get_counters(const tfa_worker_client *client);

/** Wakes the worker's thread if it sleeps. */
void tfa_worker_wake(tfa_worker *worker);
/** Lets tfa_worker_run return after it answered the requests in the rings. */
void tfa_worker_stop(tfa_worker *worker);
const tfa_ring_worker_status *tfa_worker_get_status(const tfa_worker *worker);

/* ---- clients in this process: a ring in private memory ---- */

/**
 * A client in this process. `ring` is used with the operations of ring.h and wire.h:
 *
 *     if (!tfa_ring_full(&local->ring)) {
 *         tfa_wire_encode_request(&local->shape, request, tfa_wire_want(request, NULL), id, time,
 *                                 tfa_ring_next_request(&local->ring), &ask[...]);
 *         tfa_local_client_send(local);
 *     }
 *     if (tfa_ring_reply_ready(&local->ring)) {
 *         const void *slot = tfa_ring_oldest_reply(&local->ring);
 *         tfa_wire_decode_reply(slot, &reply); tfa_wire_reply_buffers(..., slot, &reply);
 *         tfa_ring_release(&local->ring);
 *     }
 * One thread at a time has a local client; it may be handed from thread to thread under a mutex.
 */
typedef struct tfa_local_client {
    tfa_ring_client ring;
    tfa_wire_shape shape; /**< with max_batch of this client */
    tfa_worker *worker;
    tfa_worker_client *client;
    void *memory;
} tfa_local_client;

/** Opens a client of robot `robot`. slots: a power of two. @return as tfa_worker_attach;
 *  TFA_E_SIZE (slots, batch), TFA_E_ROBOT. */
TFA_CHECKED int tfa_local_client_open(tfa_worker *worker, uint32_t robot, uint32_t slots,
                                      uint32_t max_batch, tfa_local_client *local_client);
/** Closes it: waits for the worker's next cycle. The worker must run, or have ended. */
void tfa_local_client_close(tfa_local_client *local_client);

/** tfa_ring_send, and wakes the worker if it sleeps. */
void tfa_local_client_send(tfa_local_client *local_client);

/** Sleeps until reply `index` is there or gone again, at most timeout_ns; `index` counts from 0 the
 *  requests sent by this client: local->ring.received is the oldest. One thread may wait, without
 *  a lock, while another uses the client: it looks at atomics only. @return it is there or gone */
bool tfa_local_client_wait(const tfa_local_client *local_client, uint64_t index,
                           uint64_t timeout_ns);

#endif
