/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests through a port to a solver of our own that adds: qdd = q + tau.
 */
#ifndef TFA_TESTS_SERVICE_PORT_CALLS_H
#define TFA_TESTS_SERVICE_PORT_CALLS_H

#include <stdbool.h>
#include <stdint.h>

#include "worker.h"

/** q = x, 2 x and tau = 1, 2. @return TFA_OK; TFA_E_AGAIN: the ring is full */
int send_to(tfa_port *port, double x, uint64_t id);

/** Is the oldest reply that of x? Releases it. */
bool take_from(tfa_port *port, double x, uint64_t id);

#endif
