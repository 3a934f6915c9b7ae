/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The HTTP server of a build without libmicrohttpd: there is none.
 */
#include "http/http.h"
#include "platform/log.h"

int tfa_http_check(const config *settings)
{
    if (!settings->http.enabled && !settings->http.metrics_socket)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "http.%s: this totalforced was built without libmicrohttpd",
            settings->http.enabled ? "enabled" : "metrics_socket");
    return TFA_E_UNSUPPORTED;
}

int tfa_http_listen(const config *settings, tfa_http **http)
{
    *http = NULL;
    return tfa_http_check(settings);
}

int tfa_http_start(tfa_http *http, int statistics, const tfa_model *const *models,
                   const tfa_worker_robot *solvers, uint32_t count)
{
    (void)http, (void)statistics, (void)models, (void)solvers, (void)count;
    return TFA_OK;
}

void tfa_http_exchange(tfa_http *http, uint32_t robot, const tfa_model *next,
                       const tfa_worker_robot *solver)
{
    (void)http, (void)robot, (void)next, (void)solver;
}

void tfa_http_metrics(tfa_http *http, int listener)
{
    (void)http, (void)listener;
}

void tfa_http_stop(tfa_http *http)
{
    (void)http;
}
