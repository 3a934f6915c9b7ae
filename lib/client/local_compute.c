/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers in process, for calls that the daemon did not answer in time.
 */
#include "client/client.h"

#define RETRY_MS 50
#define ATTEMPT_US 2000

int tfa_client_set_fallback(tfa_client *client, const tfa_client_fallback *fallback)
{
    if (!client || (fallback && (!fallback->model || !fallback->workspace)))
        return TFA_E_ARGUMENT;
    if (!fallback) {
        client->fallback.workspace = NULL;
        return TFA_OK;
    }
    const uint64_t tag = tfa_model_tag(fallback->model);
    if (client->model != tag)
        return TFA_E_MODEL;
    client->fallback = *fallback;
    client->next_look = 0;
    if (!fallback->retry_ms)
        client->fallback.retry_ms = RETRY_MS;
    if (!fallback->attempt_us)
        client->fallback.attempt_us = ATTEMPT_US;
    return TFA_OK;
}

static bool is_missed(int status)
{
    switch (status) {
    case TFA_E_TIMEOUT:
    case TFA_E_LATE:
    case TFA_E_AGAIN:
    case TFA_E_DISCONNECTED:
    case TFA_E_LOST:
    case TFA_E_PROTOCOL:
        return true;
    default:
        return false;
    }
}

/* Now and then, and not for long: the program counts on its cycle. */
bool tfa_client_retry(tfa_client *client)
{
    const tfa_client_fallback *fallback = &client->fallback;
    return tfa_client_look(client, tfa_clock_ns() + UINT64_C(1000) * fallback->attempt_us,
                           UINT64_C(1000000) * fallback->retry_ms);
}

int tfa_client_compute(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                       tfa_exchange *exchange, int status)
{
    if (!is_missed(status))
        return status;
    if (client->model != tfa_model_tag(client->fallback.model))
        return status; /* a reload exchanged the daemon's model */
    const uint64_t start = tfa_clock_ns();
    (void)tfa_compute(client->fallback.workspace, request, reply);
    if (exchange) {
        const uint64_t end = tfa_clock_ns();
        *exchange = (tfa_exchange){.t_sent = start,
                                   .t_received = start,
                                   .t_start = start,
                                   .t_done = end,
                                   .t_reply = end,
                                   .daemon = status};
    }
    return reply->status;
}
