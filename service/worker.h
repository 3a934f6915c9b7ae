/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker takes requests from rings, solves them and answers. Its cycle is a plain function.
 *
 * Who may call what: tfa_worker_cycle and tfa_worker_sleep belong to the worker's thread (or to a
 * test that has none). tfa_worker_attach, _detach, _drain, _offer, _open, _close and _kick may be
 * called by any other thread; they share a mutex that the worker's thread never takes.
 *
 * The way of a seat, the only memory that both sides write; state is atomic:
 *   FREE -> SITTING   attach: fills the seat, A6 store release   <-> R6 worker, load acquire
 *   SITTING -> BROKEN worker: the client broke the protocol or its memory is gone; no more requests
 *   -> LEAVING        detach, A7 store release                   <-> R7 worker, load acquire
 *   -> DRAINING       drain, A7: the worker answers what was sent before it lets go
 *   LEAVING, DRAINING -> LEFT  worker: will not touch it again, A8 release <-> R8 detach, acquire
 *   LEFT -> FREE      detach or drain, which then owns the memory again
 *
 * The way of other solvers into a worker that runs, a pointer in each direction:
 *   offer  A12 store release, another thread <-> R12 worker, load acquire, before every request
 *   taken  A13 store release, worker         <-> R13 another thread, load acquire: the worker will
 *          not touch the solvers of before again, and whoever offered owns them
 * The worker neither allocates nor frees, and a request is answered by one of them from its
 * beginning to its end. Who attaches a client after an offer can rely on the new ones: the worker
 * looks for an offer (R12) after it has seen the seat (R6).
 */
#ifndef TFA_SERVICE_WORKER_H
#define TFA_SERVICE_WORKER_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <totalforce/client.h>
#include <totalforce/dynamics.h>

#include "client/ring.h"

#define TFA_WORKER_SEATS 256

/** What a solver that has just solved a part of a long request lets come in between: it calls
 *  between(context). The solver may be called for other, short requests meanwhile. */
typedef struct tfa_pause {
    void (*between)(void *context);
    void *context;
} tfa_pause;

/** Answers one request, as tfa_compute. Called in the worker's thread: no allocation, no lock.
 *  `pause` is NULL for requests of at most `cut` states. */
typedef int (*tfa_solver)(void *self, const tfa_request *request, tfa_reply *reply,
                          const tfa_pause *pause);

/** What a worker needs to know of a robot. */
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
    uint32_t spin_ns;      /**< hybrid: sleeps after so long without a request */
    tfa_wait wait;         /**< while no client asked for more: SPIN never sleeps, BLOCK at once */
    tfa_ring_pulse *pulse; /**< in memory that clients can read; NULL: private memory */
} tfa_worker_options;

typedef struct tfa_worker tfa_worker;
typedef struct tfa_seat tfa_seat;

/** Counted since the client came. Relaxed: only ever read as figures. */
typedef struct tfa_seat_counters {
    _Atomic uint64_t requests, rejected;
} tfa_seat_counters;

/** @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM (eventfd, epoll). On error *worker is NULL. */
TFA_CHECKED int tfa_worker_create(const tfa_worker_options *options, tfa_worker **worker);
/** Nobody may be attached any more, no thread may run. NULL is allowed. */
void tfa_worker_destroy(tfa_worker *worker);

/* ---- the worker's thread ---- */

/** One turn over all clients, a bounded number of requests each. @return requests answered */
uint32_t tfa_worker_cycle(tfa_worker *worker);

/** Sleeps until a client or tfa_worker_kick wakes it, at most timeout_ms (-1: for ever). Returns
 *  at once when a request is there. */
void tfa_worker_sleep(tfa_worker *worker, int timeout_ms);

/** Cycles, waits as the options say, until tfa_worker_stop; then answers what is in the rings. */
void tfa_worker_run(tfa_worker *worker);

/* ---- other threads ---- */

/** What a client of a worker is made of. */
typedef struct tfa_seat_options {
    uint32_t robot;         /**< index in the worker's robots */
    uint32_t max_batch;     /**< at most that of the robot */
    tfa_ring_layout layout; /**< for shape and max_batch: tfa_ring_layout_of */
    const void *requests;   /**< layout.request_bytes, may be hostile shared memory */
    void *replies;          /**< layout.reply_bytes */
    tfa_wait wait;          /**< SPIN: the worker does not sleep while this client is attached */
    int doorbell;           /**< eventfd by which the client wakes the worker, or -1 */
    bool internal;          /**< in this process: wakes by a private futex */
} tfa_seat_options;

/** Gives a client a seat. @return TFA_OK; TFA_E_REFUSED (no seat left); TFA_E_MEMORY;
 *  TFA_E_SYSTEM. The memory must stay until tfa_worker_detach returned true. */
TFA_CHECKED int tfa_worker_attach(tfa_worker *worker, const tfa_seat_options *options,
                                  tfa_seat **seat);

/** Asks the worker to let go of a client. @return true: it has, the seat is free. Otherwise call
 *  again in a while; the first call asks. True at once while no thread is in tfa_worker_run. */
bool tfa_worker_detach(tfa_worker *worker, tfa_seat *seat);

/** As tfa_worker_detach, but lets the worker answer what the client has sent before. Bounded: as
 *  many requests as the ring has slots. tfa_worker_detach may still be called instead. */
bool tfa_worker_drain(tfa_worker *worker, tfa_seat *seat);

/** Offers the worker other solvers for all its robots: `robots` (copied) in the same order. A robot
 *  may change its shape only while nobody is attached to it. The offer before must be taken. */
void tfa_worker_offer(tfa_worker *worker, const tfa_worker_robot *robots);

/** The worker took the last offer: it will not touch the solvers of before again. True as well
 *  while no thread is in tfa_worker_run. */
bool tfa_worker_took(const tfa_worker *worker);

/** The worker stopped serving this client: it broke the protocol. */
bool tfa_seat_broken(const tfa_seat *seat);
const tfa_seat_counters *tfa_seat_count(const tfa_seat *seat);

/** Wakes the worker's thread if it sleeps. */
void tfa_worker_kick(tfa_worker *worker);
/** Lets tfa_worker_run return after it answered what is in the rings. */
void tfa_worker_stop(tfa_worker *worker);
const tfa_ring_pulse *tfa_worker_pulse(const tfa_worker *worker);

/* ---- clients in this process: a ring in private memory ---- */

/**
 * A client in this process. `ring` is used with the operations of ring.h and wire.h:
 *
 *     if (!tfa_ring_full(&port->ring)) {
 *         tfa_wire_encode_request(&port->shape, request, tfa_wire_want(request, NULL), id, time,
 *                                 tfa_ring_next_request(&port->ring), &ask[...]);
 *         tfa_port_send(port);
 *     }
 *     if (tfa_ring_reply_ready(&port->ring)) {
 *         const void *slot = tfa_ring_oldest_reply(&port->ring);
 *         tfa_wire_decode_reply(slot, &reply); tfa_wire_reply_buffers(..., slot, &reply);
 *         tfa_ring_release(&port->ring);
 *     }
 * One thread at a time has a port; it may be handed from thread to thread under a mutex.
 */
typedef struct tfa_port {
    tfa_ring_client ring;
    tfa_wire_shape shape; /**< with max_batch of this port */
    tfa_worker *worker;
    tfa_seat *seat;
    void *memory;
} tfa_port;

/** Opens a port to robot `robot`. slots: a power of two. @return as tfa_worker_attach;
 *  TFA_E_SIZE (slots, batch), TFA_E_ROBOT. */
TFA_CHECKED int tfa_port_open(tfa_worker *worker, uint32_t robot, uint32_t slots,
                              uint32_t max_batch, tfa_port *port);
/** Closes it: waits for the worker's next cycle. The worker must run, or have ended. */
void tfa_port_close(tfa_port *port);

/** tfa_ring_send, and wakes the worker if it sleeps. */
void tfa_port_send(tfa_port *port);

/** Sleeps until reply `index` is there or gone again, at most timeout_ns; `index` counts from 0 the
 *  requests sent through this port: port->ring.received is the oldest. One thread may wait, without
 *  a lock, while another uses the port: it looks at atomics only. @return it is there or gone */
bool tfa_port_wait(const tfa_port *port, uint64_t index, uint64_t timeout_ns);

#endif
