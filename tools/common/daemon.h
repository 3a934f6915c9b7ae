/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One way to a running daemon for `call` and `latency`, over shared memory or over DDS.
 */
#ifndef TOOLS_COMMON_DAEMON_H
#define TOOLS_COMMON_DAEMON_H

#include <argp.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/client.h>

typedef enum daemon_via { DAEMON_SHM = 0, DAEMON_DDS = 1 } daemon_via;

/** Where the daemon is and how to wait for it. Zero-initialise for the defaults. */
typedef struct daemon_options {
    const char *robot;
    const char *runtime_dir; /**< shm; NULL: as tfa_client_options */
    uint32_t domain;         /**< dds */
    uint32_t max_batch;      /**< shm; 0: 1 */
    uint32_t max_tips;       /**< shm; 0: TFA_DEFAULT_TIPS */
    uint32_t slots;          /**< shm; 0: 16 */
    tfa_wait wait;
    uint64_t timeout_ns; /**< of one call, and of connecting; 0: 10 s, and 1 s (DDS: 5 s) */
} daemon_options;

/** --runtime-dir, --domain, --wait, --timeout-ms; its input is a daemon_options. */
extern const struct argp daemon_argp;

typedef struct daemon_link daemon_link;

/** Connects. @return as tfa_client_connect or tfa_dds_client_connect; on error *link is NULL. */
TFA_CHECKED int daemon_connect(const daemon_options *options, daemon_via via, daemon_link **link);

/** Description of the robot by the daemon; lives as long as the link. */
const tfa_client_info *daemon_info(const daemon_link *link);

/** One request and its reply. @return as tfa_client_call. */
int daemon_call(daemon_link *link, const tfa_request *request, tfa_reply *reply,
                tfa_exchange *exchange);

/** Sends a request without waiting. @return as tfa_client_send. */
TFA_CHECKED int daemon_send(daemon_link *link, const tfa_request *request, uint64_t *id);

/** Waits for the reply to the oldest request of daemon_send, at most timeout_ns.
 *  @return as tfa_client_receive; exchange->id is 0 without a reply. */
int daemon_receive(daemon_link *link, tfa_reply *reply, uint64_t timeout_ns,
                   tfa_exchange *exchange);

/** Hangs up. NULL is allowed. */
void daemon_close(daemon_link *link);

/** True for a status after which the link is of no more use: close it and connect again. */
int daemon_lost(int status);

/** Says why there is no connection: whom we looked for and where. Always terminated. */
void daemon_explain(const daemon_options *options, daemon_via via, int status, char *text,
                    size_t size);

#endif
