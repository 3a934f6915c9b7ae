/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The client and the worker of one ring, as programs under test: the calls of lib/client/wait.c,
 * lib/client/client.c, service/worker/worker.c and service/worker/turn.c, in their order.
 */
#ifndef TFA_EXPLORER_RING_SIDES_H
#define TFA_EXPLORER_RING_SIDES_H

#include <stdbool.h>
#include <stdint.h>

#define RING_SLOTS_MAX 4

/** Errors of a caller of the ring, each of which must be found */
typedef enum ring_error {
    ERROR_NONE,
    CLIENT_FLAG_AFTER_RECHECK,
    CLIENT_NO_RECHECK,
    CLIENT_RECHECK_ACQUIRE,
    CLIENT_NO_FLAG,
    CLIENT_FLAG_READ_BEFORE_SEND,
    CLIENT_NO_DOORBELL,
    CLIENT_WRITES_AFTER_SEND,
    CLIENT_READS_AFTER_RELEASE,
    CLIENT_IGNORES_FULL,
    CLIENT_READS_EARLY,
    WORKER_FLAG_AFTER_RECHECK,
    WORKER_NO_RECHECK,
    WORKER_RECHECK_ACQUIRE,
    WORKER_NO_FLAG,
    WORKER_FLAG_READ_BEFORE_PUBLISH,
    WORKER_NO_WAKE,
    WORKER_WRITES_AFTER_PUBLISH,
    WORKER_READS_AFTER_PUBLISH,
    RING_ERRORS
} ring_error;

typedef struct ring_case {
    const char *name;
    uint32_t slots, requests;
    uint32_t outstanding;  /**< most requests that the client sends before it waits */
    bool spin;             /**< both sides agreed to spin: no flags */
    bool client_sleeps;    /**< else it polls */
    bool worker_sleeps;    /**< else it polls */
    uint32_t client_polls; /**< polls before it sleeps (hybrid) */
    uint32_t worker_polls;
    bool waits_for_last; /**< sleeps on the slot of the newest request, as local clients may */
    int interruptions;   /**< explorer_program */
    bool weak_sc;
} ring_case;

/** The case and the error of the next exploration */
extern ring_case ring_under_test;
extern ring_error ring_error_made;

void ring_reset(void *argument);
void ring_client_body(void *argument);
void ring_worker_body(void *argument);
const char *ring_error_text(ring_error error);

#endif
