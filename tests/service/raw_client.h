/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client that speaks the protocol by itself, and a daemon with an honest client beside it.
 */
#ifndef TFA_TESTS_SERVICE_RAW_CLIENT_H
#define TFA_TESTS_SERVICE_RAW_CLIENT_H

#include "harness.h"
#include "ipc/handshake.h"

#define TIMEOUT_NS WAIT_NS

typedef struct raw_client {
    int socket;
    int fds[TFA_WELCOME_DESCRIPTORS];
    tfa_welcome welcome;
    tfa_ring_client ring;
} raw_client;

/** Connects to the socket of the arm and says nothing. */
int connect_raw(const harness *h);
tfa_hello good_hello(tfa_wait wait);
/** Waits for the daemon's answer. @return its status; TFA_E_DISCONNECTED: it hung up without one */
int receive_status(int socket, tfa_welcome *w);
/** A client by the book so far: 8 slots, batches of 2. */
raw_client connect_client(const harness *h, tfa_wait wait);
/** @return false: it was refused */
bool try_connect_client(const harness *h, tfa_wait wait, raw_client *v);
void disconnect_client(raw_client *v);
#define SCOPED_RAW_CLIENT SCOPED(disconnect_client) raw_client
/** Rings the worker's doorbell. */
void wake(const raw_client *v);
/** Waits for the oldest reply, or the test fails. */
const tfa_wire_reply *await_reply(const raw_client *v);
/** The daemon hangs up on this socket, or the test fails. */
void assert_hung_up(int socket);

/** A daemon with an arm and an honest client. */
typedef struct scene {
    harness h;
    tfa_client *honest_client;
    double expected[7];
} scene;

scene open_scene(const char *more);
/** The honest client gets the bits that it got at first. */
void assert_unharmed(scene *s);
void close_scene(scene *s);
#define SCOPED_SCENE SCOPED(close_scene) scene

#endif
