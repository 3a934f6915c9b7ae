/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Connections of the HTTP server: one thread's.
 */
#ifndef TFA_SERVICE_HTTP_CONNECTIONS_H
#define TFA_SERVICE_HTTP_CONNECTIONS_H

#include "http/http_internal.h"

TFA_CHECKED int connections_open(tfa_http *http);
void connections_close(tfa_http *http);
/* Readable: connections_run has work. */
int connections_descriptor(const tfa_http *http);
void connections_run(tfa_http *http);
/* ns until connections_run has work at the latest. */
uint64_t connections_timeout(const tfa_http *http);
/* Takes those that wait at a listener. */
void connections_accept(tfa_http *http, int listener, bool metrics);
/* Ends those that have been silent for too long. */
void connections_sweep(tfa_http *http);

#endif
