/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client asks a running totalforced over its shared-memory ring. Knows nothing of dynamics.
 *
 * Thread rules: a tfa_client belongs to one thread at a time; different clients are independent.
 * No signal handler may call into a client that its thread is using.
 */
#ifndef TOTALFORCE_CLIENT_H
#define TOTALFORCE_CLIENT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tfa_client tfa_client;

typedef enum tfa_wait {
    TFA_WAIT_DEFAULT = 0, /**< what the daemon is configured for */
    TFA_WAIT_SPIN = 1,    /**< never sleeps: lowest latency, takes a core on both sides */
    TFA_WAIT_HYBRID = 2,  /**< spins spin_ns, then sleeps */
    TFA_WAIT_BLOCK = 3,   /**< sleeps at once */
} tfa_wait;

typedef struct tfa_client_options {
    const char *runtime_dir; /**< NULL: $TOTALFORCE_RUNTIME_DIR, else the user's own daemon in
                                  $XDG_RUNTIME_DIR/totalforce, else /run/totalforce */
    const char *robot;       /**< name in the daemon's configuration; required */
    uint32_t slots;          /**< requests outstanding at once, power of two; 0: 16 */
    uint32_t max_batch;      /**< states of one request; 0: 1 */
    tfa_wait wait;
    uint32_t spin_ns;           /**< hybrid: 0 means 50000 */
    int32_t connect_timeout_ms; /**< 0: 1000 */
} tfa_client_options;

/** What the daemon told about the robot when the client connected; lives as long as the client. */
typedef struct tfa_client_info {
    uint32_t q_count, v_count, base_freedoms;
    uint32_t slots, max_batch;
    uint32_t joint_count, frame_count;
    const char *const *joint_names; /**< joint_count names in declared order */
    const uint32_t *joint_types;    /**< joint_count tfa_joint_type: how many numbers each takes;
                                         NULL: every joint takes one */
    const char *const *frame_names; /**< frame_count link names; index = frame index */
    const char *model_hash;         /**< 64 hexadecimal digits */
    tfa_wait wait;
    int32_t daemon_pid;
} tfa_client_info;

/** Times of one exchange, CLOCK_MONOTONIC ns. */
typedef struct tfa_exchange {
    uint64_t id;
    uint64_t t_sent, t_received, t_start, t_done, t_reply;
} tfa_exchange;

/**
 * Connects to the daemon that serves options->robot.
 * @return TFA_OK; TFA_E_DISCONNECTED (no daemon at the socket); TFA_E_ROBOT; TFA_E_REFUSED;
 *         TFA_E_SIZE (slots or batch beyond the daemon's limits); TFA_E_PROTOCOL; TFA_E_TIMEOUT;
 *         TFA_E_MEMORY; TFA_E_SYSTEM. On error *client is NULL and nothing is left behind.
 */
TFA_API TFA_CHECKED int tfa_client_connect(const tfa_client_options *options, tfa_client **client);

/**
 * Writes why tfa_client_connect or tfa_client_reconnect returned `status` for these options: the
 * robot, the path of its socket and the remedy, for instance "robot 'arm': no daemon listens at
 * /run/totalforce/arm.sock: ...". Reads errno for TFA_E_SYSTEM: call it first. Always terminated.
 * @return the length that the whole text needs, as snprintf does. Allocates. Any thread.
 */
TFA_API size_t tfa_client_explain(const tfa_client_options *options, int status, char *text,
                                  size_t size);

/** Connects again after TFA_E_DISCONNECTED, with the same options. Requests under way are lost:
 *  tfa_client_receive reports them with TFA_E_LOST. */
TFA_API TFA_CHECKED int tfa_client_reconnect(tfa_client *client);

/** Hangs up and releases everything. NULL is allowed. */
TFA_API void tfa_client_close(tfa_client *client);

TFA_API const tfa_client_info *tfa_client_get_info(const tfa_client *client);

/**
 * Sends one request and waits for its reply: the plain way. The buffers in `reply` are filled as
 * tfa_compute would. Earlier requests sent with tfa_client_send must have been received.
 *
 * @param timeout_ns  0 waits for ever (until the daemon is gone)
 * @return status of the reply (see tfa_compute), or TFA_E_AGAIN, TFA_E_TIMEOUT,
 *         TFA_E_DISCONNECTED, TFA_E_SIZE (count beyond max_batch), TFA_E_PROTOCOL.
 * In spin mode: no system call besides clock_gettime (vDSO), no allocation.
 */
TFA_API int tfa_client_call(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                            uint64_t timeout_ns, tfa_exchange *exchange);

/** Puts a request into the ring without waiting. @return TFA_OK, TFA_E_AGAIN, TFA_E_SIZE. */
TFA_API TFA_CHECKED int tfa_client_send(tfa_client *client, const tfa_request *request,
                                        uint64_t *id);

/** Waits for the reply to the oldest request sent and not yet received. */
TFA_API int tfa_client_receive(tfa_client *client, tfa_reply *reply, uint64_t timeout_ns,
                               tfa_exchange *exchange);

#ifdef __cplusplus
}
#endif
#endif
