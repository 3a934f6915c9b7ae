/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of the two halves of a worker: worker.c (its thread) and worker_client.c (all
 * others).
 */
#ifndef TFA_SERVICE_WORKER_WORKER_INTERNAL_H
#define TFA_SERVICE_WORKER_WORKER_INTERNAL_H

#include "worker.h"

enum worker_client_state {
    CLIENT_FREE,
    CLIENT_ATTACHED,
    CLIENT_BROKEN,
    CLIENT_DRAINING,
    CLIENT_DETACHING,
    CLIENT_DETACHED
};

enum worker_phase { WORKER_IDLE, WORKER_RUNNING, WORKER_ENDED };

/* Everything but state and counters is written while FREE and constant while ATTACHED; `ring` then
 * belongs to the worker. */
struct tfa_worker_client {
    _Alignas(
        TFA_WIRE_LINE) _Atomic uint32_t state; /* enum worker_client_state: A6 to A8, R6 to R8 */
    uint32_t robot;
    tfa_ring_server ring;
    tfa_wire_shape shape;
    void *scratch; /* the private copy of a request */
    int guard;     /* of sigbus.h */
    int doorbell;
    tfa_wait wait;
    uint32_t drained; /* requests answered while DRAINING; the worker's */
    tfa_worker_client_counters count;
};

struct tfa_worker {
    tfa_worker_client clients[TFA_WORKER_CLIENTS_MAX];
    _Atomic uint32_t clients_used; /* entries beyond were never used. A9 release <-> R9 acquire */
    _Atomic uint32_t modes[4];     /* clients by tfa_wait: relaxed, a late look costs one cycle */
    _Atomic uint32_t phase;        /* enum worker_phase: A10 release <-> R10 acquire */
    _Atomic bool stop;             /* A11 release <-> R11 acquire */

    const tfa_worker_robot *robots;          /* one of `lists`: the worker's own */
    _Atomic(const tfa_worker_robot *) offer; /* A12, R12 */
    _Atomic(const tfa_worker_robot *) taken; /* A13, R13 */
    tfa_worker_robot *solver_lists[2];       /* the one offered last, and the one of before */
    uint32_t latest;                         /* which; under the mutex */
    uint32_t robot_count;
    uint32_t spin_ns;
    tfa_wait wait;
    tfa_ring_worker_status *worker_status;
    tfa_ring_worker_status private_status;
    uint64_t heartbeat_count;

    int epoll, wake_event; /* wake_event: in epoll */
    pthread_mutex_t mutex;
};

#endif
