/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients: admission, handshake, from the connection to the hang-up.
 */
#ifndef TFA_SERVICE_CONTROL_SESSION_H
#define TFA_SERVICE_CONTROL_SESSION_H

#include <sys/socket.h>

#include "control/robot_set.h"

typedef enum session_state {
    SESSION_HANDSHAKE, /* connected, HELLO has not come */
    SESSION_DEFERRED,  /* HELLO came while a reload changes the robot's shape: it is kept */
    SESSION_ATTACHED,  /* attached to a worker */
    SESSION_DRAINING,  /* the worker answers earlier requests, then detaches; the socket is open */
    SESSION_DETACHING, /* the worker was asked to detach; the socket is closed */
} session_state;

/* One connection on the control socket. */
typedef struct session {
    struct session *next;
    session_state state;
    int socket, doorbell;
    uint32_t robot;
    uid_t user;
    pid_t process;
    uint64_t since; /* CLOCK_MONOTONIC ns of the connection */
    daemon_worker *worker;
    tfa_worker_client *client;
    tfa_segment requests, replies;
    bool resized;    /* the client changed its request segment */
    tfa_hello hello; /* of a session that waits */
    ssize_t hello_size;
} session;

/* ---- session.c: clients ---- */

/* A connection was accepted: it becomes a session, or is refused with a reason. */
void session_begin(tfa_daemon *d, uint32_t robot, int socket);
/* Something happened on its socket. */
void session_event(tfa_daemon *d, session *s);
/* Time passed: late handshakes, broken protocols, clients to detach. */
void session_tick(tfa_daemon *d);
/* Ends all of them; the workers run no more. */
void session_end_all(tfa_daemon *d);
/* The clients of a robot are detached when their requests are answered. */
void session_drain(tfa_daemon *d, uint32_t robot);
/* A client of this robot is attached. */
bool session_any_attached(const tfa_daemon *d, uint32_t robot);
/* Answers the HELLOs that were kept. */
void session_resume_deferred(tfa_daemon *d);
/* Some session waits for its worker: look again soon. */
bool session_any_detaching(const tfa_daemon *d);

/* ---- handshake.c: admission and handshake ---- */

/* A welcome with nothing in it yet. */
tfa_welcome handshake_welcome(void);
/* May this process connect now? A connection counts from its first moment. @return TFA_OK; a
 * refusal, and its reason in the welcome */
int handshake_admit(tfa_daemon *d, int socket, const struct ucred *peer, tfa_welcome *w);
/* Answers the HELLO of a session, of `size` bytes. @return false: it was refused, or is gone */
bool handshake_answer(tfa_daemon *d, session *s, const tfa_hello *hello, ssize_t size);

#endif
