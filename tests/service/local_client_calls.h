/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests through a local client to a solver of our own that adds: qdd = q + tau.
 */
#ifndef TFA_TESTS_SERVICE_LOCAL_CLIENT_CALLS_H
#define TFA_TESTS_SERVICE_LOCAL_CLIENT_CALLS_H

#include <stdbool.h>
#include <stdint.h>

#include "support/scoped.h"
#include "worker/local_client.h"

/** q = x, 2 x and tau = 1, 2. @return TFA_OK; TFA_E_AGAIN: the ring is full */
int send_to(tfa_local_client *local_client, double x, uint64_t id);

/** Is the oldest reply that of x? Releases it. */
bool receive_from(tfa_local_client *local_client, double x, uint64_t id);

#define SCOPED_LOCAL_CLIENT SCOPED(tfa_local_client_close) tfa_local_client
SCOPED_POINTER(scoped_worker_destroy, tfa_worker, tfa_worker_destroy)
#define SCOPED_WORKER SCOPED(scoped_worker_destroy) tfa_worker

#endif
