/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A second daemon on the same host, to which a client turns when its own ends.
 */
#include "client/client.h"

/* Between two looks for a daemon: two connect calls, some 20 us, if none is there; half of the
 * connections that the default limits.connects_per_second leaves a user, if it is another's model.
 * */
#define LOOK_NS 20000000

static void exchange_directories(tfa_client *client)
{
    char *other = client->standby_dir;
    client->standby_dir = client->runtime_dir;
    client->runtime_dir = other;
    client->options.runtime_dir = client->runtime_dir;
    client->options.standby_dir = client->standby_dir;
}

/* The other one first: this one ended, or hangs and would keep the caller waiting. It gets
 * half of the time, because it may hang, too. */
int tfa_client_open_either(tfa_client *client, uint64_t deadline, uint64_t model)
{
    if (!client->standby_dir)
        return tfa_connection_open(client, deadline, model);
    const uint64_t now = tfa_clock_ns(), left = deadline > now ? deadline - now : 0;
    exchange_directories(client);
    if (tfa_connection_open(client, now + left / 2, model) == TFA_OK)
        return TFA_OK;
    exchange_directories(client);
    return tfa_connection_open(client, deadline, model);
}

bool tfa_client_look(tfa_client *client, uint64_t deadline, uint64_t pause)
{
    if (tfa_clock_ns() < client->next_look)
        return false;
    if (tfa_client_attempt(client, deadline, client->model) == TFA_OK)
        return true;
    client->next_look = tfa_clock_ns() + pause; /* the attempt may have taken longer */
    return false;
}

bool tfa_client_fail_over(tfa_client *client, uint64_t deadline)
{
    return client->standby_dir && tfa_client_look(client, deadline, LOOK_NS);
}
