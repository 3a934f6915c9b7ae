/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client of a worker in the same process: a ring in private memory.
 */
#ifndef TFA_SERVICE_WORKER_LOCAL_CLIENT_H
#define TFA_SERVICE_WORKER_LOCAL_CLIENT_H

#include "worker/worker.h"

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
    tfa_wire_shape shape; /**< with max_batch of this client, and at most TFA_DEFAULT_TIPS */
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
