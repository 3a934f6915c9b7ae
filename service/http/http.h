/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon's optional HTTP server: live page, its figures as JSON, and metrics. Read only.
 *
 * One thread of its own at nice 10, on processors without workers. It reads the statistics segment
 * and has solvers of its own for the robots' figures; it shares nothing with workers.
 */
#ifndef TFA_SERVICE_HTTP_HTTP_H
#define TFA_SERVICE_HTTP_HTTP_H

#include <totalforce/model.h>

#include "config/config.h"
#include "worker/worker.h"

typedef struct tfa_http tfa_http;

/** Can the configuration be served? Logs why not. @return TFA_OK; TFA_E_UNSUPPORTED: this build
 *  has no HTTP server */
TFA_CHECKED int tfa_http_check(const config *settings);

/** Opens the port: before privileges are dropped. Logs the error.
 *  @param http  NULL if the configuration has neither page nor metrics
 *  @return TFA_OK; TFA_E_UNSUPPORTED; TFA_E_SYSTEM; TFA_E_MEMORY */
TFA_CHECKED int tfa_http_listen(const config *settings, tfa_http **http);

/** Starts the thread. NULL as http is allowed.
 *  @param statistics  descriptor of the statistics segment, which stays the caller's
 *  @param models      one for each of the segment's robots
 *  @param solvers     the same; NULL: no page, only metrics */
TFA_CHECKED int tfa_http_start(tfa_http *http, int statistics, const tfa_model *const *models,
                               const tfa_worker_robot *solvers, uint32_t count);

/** Draws a robot by this model's solver from now on; the one of before is free then. */
void tfa_http_exchange(tfa_http *http, uint32_t robot, const tfa_model *next,
                       const tfa_worker_robot *solver);

/** Serves metrics at this listening Unix socket from now on, in place of the one of before; -1:
 *  at none. The descriptor is the server's then. */
void tfa_http_metrics(tfa_http *http, int listener);

/** Ends the thread, whatever its connections do. NULL is allowed. */
void tfa_http_stop(tfa_http *http);

#endif
