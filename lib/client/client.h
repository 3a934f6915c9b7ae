/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Internal interface of the client library.
 */
#ifndef TFA_CLIENT_CLIENT_H
#define TFA_CLIENT_CLIENT_H

#include <stdbool.h>
#include <stdint.h>
#include <totalforce/client.h>

#include "ipc/handshake.h"
#include "ipc/ring.h"

/* Names and hash from the daemon. Older ones stay until the client is closed, because the program
 * may hold pointers into them. */
typedef struct client_names {
    struct client_names *older;
    char hash[65];
    size_t bytes;
    uint32_t *types;       /* of joints; then the frames of modes */
    char *text;            /* joint names, then frame names */
    const char *strings[]; /* pointers into text */
} client_names;

/* A connection; released as a whole */
typedef struct client_connection {
    int socket, doorbell;
    uint64_t heartbeat, beat_seen; /* the worker's, and when it was seen to change */
    bool alive;                    /* connected, no hang-up seen */
    tfa_ring_client ring;
    void *requests;
    const void *replies;
} client_connection;

struct tfa_client {
    client_connection connection;
    tfa_wire_shape shape;
    tfa_client_info info;
    client_names *names;
    uint32_t spin_ns;

    /* by i mod slots: shape of the reply to request i */
    tfa_wire_reply_shape *reply_shapes;
    uint64_t first_id;       /* id of request 0 of this connection */
    uint64_t call_end;       /* requests below this index are abandoned calls */
    uint64_t lost, lost_end; /* ids lost with earlier connections, not yet reported */

    tfa_client_fallback fallback; /* workspace NULL: none */
    uint64_t model;               /* tag of the daemon's model, as far as known */
    uint64_t next_look; /* CLOCK_MONOTONIC ns: not sooner looks it for a daemon by itself */

    char *robot, *runtime_dir; /* copies for tfa_client_reconnect */
    char *standby_dir;         /* of the other daemon; NULL: none */
    tfa_client_options options;
};

/* Deadlines are CLOCK_MONOTONIC ns; UINT64_MAX: none. */

/* ---- connect.c ---- */

/* One attempt to connect, all or nothing. Fills connection, shape, info, model. `model`: the tag
 * that the daemon's must have (otherwise TFA_E_MODEL); 0: any. */
int tfa_connection_open(tfa_client *client, uint64_t deadline, uint64_t model);
void tfa_connection_close(client_connection *connection);

/* Reason of the daemon for its last refusal or hang-up in this thread, or "". */
const char *tfa_connection_refusal(void);
/* Reads why the daemon hangs up on a connection, if it said so. */
void tfa_connection_read_farewell(const client_connection *connection);

/* ---- command.c ---- */

/* tfa_daemon_command, with the descriptor of the answer: -1 where none came. */
int tfa_daemon_ask(const char *runtime_dir, const char *command, int32_t timeout_ms, char *text,
                   size_t size, int *descriptor);

/* ---- client.c ---- */

/* One attempt to connect again; requests under way are lost. `model` as tfa_connection_open. */
int tfa_client_attempt(tfa_client *client, uint64_t deadline, uint64_t model);

/* ---- standby.c ---- */

/* Connects to the other daemon, or again to this one. `model` as tfa_connection_open. @return as
 * tfa_client_connect */
int tfa_client_open_either(tfa_client *client, uint64_t deadline, uint64_t model);

/* The connection has ended: is there a daemon with the same model now? Not sooner than `pause` ns
 * after a look that found none. */
bool tfa_client_look(tfa_client *client, uint64_t deadline, uint64_t pause);

/* The same for a client that has a standby, at its intervals. */
bool tfa_client_fail_over(tfa_client *client, uint64_t deadline);

/* ---- fallback.c ---- */

/* The connection has ended: tfa_client_look, with the limits of the client's fallback. */
bool tfa_client_retry(tfa_client *client);

/* Answers a call that the daemon did not, for the reason `status`. @return status of the reply */
int tfa_client_compute(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                       tfa_exchange *exchange, int status);

/* ---- wait.c ---- */

uint64_t tfa_clock_ns(void);

/* Waits for reply ring.received. @return TFA_OK, TFA_E_TIMEOUT, TFA_E_DISCONNECTED */
int tfa_connection_wait(tfa_client *client, uint64_t deadline);

/* True if the daemon has hung up. A system call: slow path only. */
bool tfa_connection_hung_up(const client_connection *connection);

#endif
