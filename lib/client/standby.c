/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A second daemon on the same host, to which a client turns when its own ends.
 */
#include "client/client.h"

/* Between two looks for a daemon that is not there; a look is two connect calls, some 20 us. */
#define LOOK_NS 10000000

static void exchange_directories(tfa_client *client)
{
    char *other = client->standby_dir;
    client->standby_dir = client->runtime_dir;
    client->runtime_dir = other;
    client->options.runtime_dir = client->runtime_dir;
    client->options.standby_dir = client->standby_dir;
}

/* The other one first: this one ended, or stands still and would keep the caller waiting. */
int tfa_client_open_either(tfa_client *client, uint64_t timeout_ns)
{
    if (!client->standby_dir)
        return tfa_connection_open(client, timeout_ns);
    exchange_directories(client);
    if (tfa_connection_open(client, timeout_ns) == TFA_OK)
        return TFA_OK;
    exchange_directories(client);
    return tfa_connection_open(client, timeout_ns);
}

bool tfa_client_fail_over(tfa_client *client, uint64_t timeout_ns)
{
    const uint64_t model = client->model, now = tfa_clock_ns();
    if (!client->standby_dir || now < client->fail_over)
        return false;
    if (tfa_client_attempt(client, timeout_ns) == TFA_OK && client->model == model)
        return true;
    client->connection.alive = false;
    client->model = model;
    client->fail_over = now + LOOK_NS;
    return false;
}
