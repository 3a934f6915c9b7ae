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
    client->retry = 0;
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
static void try_to_reconnect(tfa_client *client)
{
    const uint64_t now = tfa_clock_ns();
    if (client->connection.alive || now < client->retry)
        return;
    client->retry = now + UINT64_C(1000000) * client->fallback.retry_ms;
    (void)tfa_client_attempt(client, UINT64_C(1000) * client->fallback.attempt_us);
}

int tfa_client_compute(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                       tfa_exchange *exchange, int status)
{
    if (!is_missed(status))
        return status;
    try_to_reconnect(client);
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
