/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The way from one client to its answers and back, as the measuring loop sees it: clock, send,
 * receive, sleep. Tests put a scripted responder with a clock of its own behind it.
 */
#ifndef TOOLS_LATENCY_LOOP_TRANSPORT_H
#define TOOLS_LATENCY_LOOP_TRANSPORT_H

#include <stdint.h>
#include <totalforce/client.h>

typedef struct transport transport;

/** A reply. Stamps of the responder: 0 where it has none. */
typedef struct transport_answer {
    uint64_t id;
    int status;      /**< of the reply */
    uint16_t method; /**< that answered */
    uint64_t t_received, t_start, t_done;
} transport_answer;

typedef struct transport_operations {
    /** ns; of one clock with all stamps */
    uint64_t (*now)(transport *t);
    /** Sends request number `index` under an id that grows from request to request; does not wait.
     *  @return TFA_OK; TFA_E_AGAIN (no room: later); a status of daemon_lost (reconnect); any
     *  other: this request is refused */
    int (*send)(transport *t, uint64_t id, uint64_t index);
    /** Waits for a reply until `until`; one of the past only looks.
     *  @return TFA_OK (a reply); TFA_E_TIMEOUT; a status of daemon_lost (reconnect) */
    int (*receive)(transport *t, uint64_t until, transport_answer *answer);
    /** Sends and waits for the reply, at most the timeout; NULL: send and receive do. @return as
     *  receive; answer->status as of a reply refused at once */
    int (*call)(transport *t, uint64_t id, uint64_t index, transport_answer *answer);
    /** Waits until `until` as the client's wait mode says; nothing is outstanding. */
    void (*idle)(transport *t, uint64_t until);
    /** All requests under way are given up. @return TFA_OK, or the run must end */
    int (*reconnect)(transport *t);
    /** Releases everything. */
    void (*close)(transport *t);
} transport_operations;

struct transport {
    const transport_operations *ops;
};

/** How the answering side describes itself and how to wait for it. */
typedef struct transport_facts {
    tfa_client_info info; /**< without its strings: they end with the connection */
    char hash[65];
} transport_facts;

#endif
