/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The HTTP server, tied to statistics, robots and runtime directory.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "control/daemon.h"
#include "platform/log.h"

#define METRICS_NAME ".metrics"

/* With a page each robot has a solver for its figure. */
static int start(tfa_daemon *d, const tfa_model **models, tfa_worker_robot *solvers)
{
    const uint32_t count = d->robot_set.count;
    const bool page = d->settings->http.enabled;
    int status = TFA_OK;
    for (uint32_t i = 0; i < count && status == TFA_OK; i++) {
        models[i] = d->robot_set.robots[i].model;
        status = page ? daemon_make_solver(d, i, &d->http_solvers, &solvers[i]) : TFA_OK;
    }
    if (status != TFA_OK)
        return status;
    return tfa_http_start(d->http, d->statistics_segment.fd_readonly, models, page ? solvers : NULL,
                          count);
}

int live_page_start(tfa_daemon *d)
{
    if (!d->http)
        return TFA_OK;
    const tfa_model **models = calloc(d->robot_set.count, sizeof *models);
    tfa_worker_robot *solvers = calloc(d->robot_set.count, sizeof *solvers);
    const int status = models && solvers ? start(d, models, solvers) : TFA_E_MEMORY;
    free(models);
    free(solvers);
    return status;
}

int live_page_listen(tfa_daemon *d)
{
    if (!d->http || !d->settings->http.metrics_socket || d->metrics_open)
        return TFA_OK;
    const int listener = tfa_runtime_dir_listen_stream(&d->runtime_dir, METRICS_NAME);
    if (listener < 0) {
        tfa_log(TFA_LOG_ERROR, "socket '%s/" METRICS_NAME ".sock': %s", d->runtime_dir.path,
                strerror(errno));
        return TFA_E_SYSTEM;
    }
    tfa_http_metrics(d->http, listener);
    d->metrics_open = true;
    tfa_log(TFA_LOG_INFO, "http: metrics at %s/" METRICS_NAME ".sock", d->runtime_dir.path);
    return TFA_OK;
}

void live_page_unlisten(tfa_daemon *d)
{
    if (!d->metrics_open)
        return;
    tfa_runtime_dir_unlink(&d->runtime_dir, METRICS_NAME);
    tfa_http_metrics(d->http, -1);
    d->metrics_open = false;
}

void live_page_stop(tfa_daemon *d)
{
    tfa_http_stop(d->http);
    d->http = NULL;
}
