/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Client of a running totalforced, over a lock-free ring in shared memory. It contains no dynamics.
 *
 * Thread rules: one thread at a time uses a tfa_client; different clients are independent. A signal
 * handler must not call into a client that the interrupted thread is using. After fork() one of the
 * two processes uses a client, the other at most closes it; the daemon sees a client end when both
 * have closed it, ended or called exec.
 */
#ifndef TOTALFORCE_CLIENT_H
#define TOTALFORCE_CLIENT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/model.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A connection to one robot of a daemon. */
typedef struct tfa_client tfa_client;

/** How the two sides wait for each other. */
typedef enum tfa_wait {
    TFA_WAIT_DEFAULT = 0, /**< as the daemon is configured */
    TFA_WAIT_SPIN = 1,    /**< never sleeps: lowest latency, occupies a core on both sides */
    TFA_WAIT_HYBRID = 2,  /**< spins spin_ns, then sleeps */
    TFA_WAIT_BLOCK = 3,   /**< sleeps at once */
} tfa_wait;
/** Their words: X(value, word) */
#define TFA_WAIT_WORDS(X)                                                                          \
    X(TFA_WAIT_DEFAULT, "default")                                                                 \
    X(TFA_WAIT_SPIN, "spin")                                                                       \
    X(TFA_WAIT_HYBRID, "hybrid")                                                                   \
    X(TFA_WAIT_BLOCK, "block")

/** Zero-initialise, then set `robot`. */
typedef struct tfa_client_options {
    const char *runtime_dir;    /**< folder of the sockets; NULL: $TOTALFORCE_RUNTIME_DIR, else
                                  the user's own daemon in $XDG_RUNTIME_DIR/totalforce, else
                                  /run/totalforce */
    const char *robot;          /**< name in the daemon's configuration; required */
    uint32_t slots;             /**< requests outstanding at once, a power of two; 0: 16 */
    uint32_t max_batch;         /**< largest count of a request; 0: 1 */
    uint32_t max_tips;          /**< most tips of a request, up to TFA_MAX_TIPS; 0:
                                  TFA_DEFAULT_TIPS. A slot grows by its square. Granted, up to
                                  the robot's: tfa_client_info.max_tips */
    tfa_wait wait;              /**< requested; granted: tfa_client_info.wait */
    uint32_t spin_ns;           /**< TFA_WAIT_HYBRID, ns; 0: as the daemon is configured */
    uint32_t deadline_us;       /**< the daemon refuses a request that begins later than this after
                                  it was sent (TFA_E_LATE); 0: none. A call's timeout counts, too */
    int32_t connect_timeout_ms; /**< limit of connecting and reconnecting, ms; 0: 1000 */
    const char *standby_dir;    /**< runtime_dir of another daemon on this host with the same robot;
                                  NULL: none. See tfa_client_call */
} tfa_client_options;

/** Description of the robot that the daemon sent at connection; lives as long as the client. */
typedef struct tfa_client_info {
    uint32_t q_count;               /**< as tfa_model_q_count */
    uint32_t v_count;               /**< as tfa_model_v_count */
    uint32_t base_freedoms;         /**< as tfa_model_base_freedoms */
    uint32_t slots;                 /**< granted */
    uint32_t max_batch;             /**< granted */
    uint32_t max_tips;              /**< granted */
    uint32_t joint_count;           /**< length of joint_names */
    uint32_t frame_count;           /**< length of frame_names */
    const char *const *joint_names; /**< joint_count, in declared order */
    const uint32_t *joint_types;    /**< joint_count tfa_joint_type; NULL: one number each */
    const char *const *frame_names; /**< frame_count link names; the index is the frame index */
    uint32_t mode_count;            /**< as tfa_model_mode_count */
    const uint32_t *mode_frames;    /**< mode_count frame indices of the flexible links */
    uint32_t constraint_count;      /**< as tfa_model_constraint_count */
    const char *const *constraint_names; /**< constraint_count; the index is the bit in
                                              tfa_request.constraints */
    const char *model_hash;         /**< 64 hexadecimal digits, as tfa_model_hash_text */
    tfa_wait wait;                  /**< granted */
    int32_t daemon_pid;             /**< process id of the daemon */
} tfa_client_info;

/** Times of one exchange, CLOCK_MONOTONIC, ns. */
typedef struct tfa_exchange {
    uint64_t id;         /**< of the request, as tfa_client_send returned it */
    uint64_t t_sent;     /**< client: request written */
    uint64_t t_received; /**< worker: request seen */
    uint64_t t_start;    /**< worker: computing starts */
    uint64_t t_done;     /**< worker: answer computed */
    uint64_t t_reply;    /**< client: reply copied */
    int32_t daemon;      /**< TFA_OK: the daemon answered. Otherwise why it did not, and the library
                           computed in process (tfa_client_set_fallback) */
} tfa_exchange;

/** Answers in process when the daemon does not: see tfa_client_set_fallback. */
typedef struct tfa_client_fallback {
    const tfa_model *model;   /**< the robot's; outlives the client */
    tfa_workspace *workspace; /**< of this model; the client's alone */
    uint32_t retry_ms;        /**< between two attempts to reconnect; 0: 50 */
    uint32_t attempt_us;      /**< limit of one attempt, in the call that makes it; 0: 2000 */
} tfa_client_fallback;

/**
 * Connects to the daemon that serves options->robot: socket, handshake, mapping of the ring.
 * Allocates; waits at most connect_timeout_ms for the daemon's answer.
 *
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, no robot, a wait mode that does not exist, a negative
 *         timeout, a path too long for a socket); TFA_E_DISCONNECTED (no daemon at the socket);
 *         TFA_E_ROBOT (no robot of that name); TFA_E_REFUSED (permission or quota); TFA_E_SIZE
 *         (slots not a power of two; slots, batch or tips beyond the limits); TFA_E_PROTOCOL
 *         (another version); TFA_E_TIMEOUT; TFA_E_MEMORY; TFA_E_SYSTEM (see errno).
 *         On error *client is NULL and everything is released.
 */
TFA_API TFA_CHECKED int tfa_client_connect(const tfa_client_options *options, tfa_client **client);

/**
 * Writes the reason why tfa_client_connect or tfa_client_reconnect returned `status` for these
 * options: robot, path of the socket and remedy, for instance "robot 'arm': no daemon listens at
 * /run/totalforce/arm.sock: ...". After TFA_E_DISCONNECTED of a request in this thread: why the
 * daemon hung up, if it did. Reads errno for TFA_E_SYSTEM: call it first. Allocates. Any thread.
 *
 * @param options  as given to tfa_client_connect
 * @param status   that it returned
 * @param text     always terminated if size > 0
 * @param size     of text, bytes
 * @return length of the whole text, as snprintf
 */
TFA_API size_t tfa_client_explain(const tfa_client_options *options, int status, char *text,
                                  size_t size);

/**
 * Connects again after TFA_E_DISCONNECTED, with the same options; retries until connect_timeout_ms.
 * The daemon in standby_dir and the one in runtime_dir take turns.
 * Requests under way are lost: tfa_client_receive reports each with TFA_E_LOST.
 * @return as tfa_client_connect; TFA_E_SIZE also if the robot now has other array sizes: q, v, base
 *         or frames. max_batch and max_tips never grow
 */
TFA_API TFA_CHECKED int tfa_client_reconnect(tfa_client *client);

/**
 * Lets tfa_client_call compute in process when the daemon does not answer in time: after
 * TFA_E_TIMEOUT, TFA_E_LATE, TFA_E_AGAIN, TFA_E_DISCONNECTED, TFA_E_LOST and TFA_E_PROTOCOL. The
 * answer has the bits that a daemon of the same library gives, and tfa_exchange.daemon says why it
 * is needed. The next call asks the daemon again; after a lost connection a call in each `retry_ms`
 * tries to reconnect, for `attempt_us` at most, until a daemon with the same model is back; one
 * with another model is taken by tfa_client_reconnect only.
 *
 * The model must be the daemon's. After a reload that changed it there, calls are not answered in
 * process until the program sets the new one: the daemon's status is returned.
 *
 * @param client    connected
 * @param fallback  copied; NULL: none any more
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_MODEL (the hash is not that of the daemon's model)
 */
TFA_API TFA_CHECKED int tfa_client_set_fallback(tfa_client *client,
                                                const tfa_client_fallback *fallback);

/** Disconnects and releases everything. NULL is allowed. */
TFA_API void tfa_client_close(tfa_client *client);

/** Description of the robot; NULL for a NULL client. Its pointers stay valid across reconnects. */
TFA_API const tfa_client_info *tfa_client_get_info(const tfa_client *client);

/**
 * Sends one request and waits for its reply. Fills the buffers of `reply` as tfa_compute. Receive
 * the replies to earlier tfa_client_send calls first, lost ones included.
 *
 * Cost: about 1 us besides computing (docs/performance.md). No allocation; in spin mode no system
 * call besides clock_gettime (vDSO), and one poll each 100 ms.
 *
 * With options.standby_dir a client whose daemon ends connects to the other one by itself, in the
 * call and its timeout, and asks again: the call is answered. It stays there until that one ends. A
 * daemon with another model is not taken (tfa_client_reconnect takes it). Requests of
 * tfa_client_send that were under way are reported by tfa_client_receive with TFA_E_LOST.
 *
 * @param client      connected
 * @param request     copied
 * @param reply       gets the answer
 * @param timeout_ns  ns; 0: waits until the daemon ends, or shows no progress for three seconds.
 *                    The daemon does not begin a request whose timeout has passed
 * @param exchange    times; may be NULL
 * @return reply->status: as tfa_compute, or TFA_E_ARGUMENT (a NULL, or replies not received yet);
 *         TFA_E_AGAIN (the ring is full); TFA_E_TIMEOUT; TFA_E_LATE (the deadline passed before the
 *         daemon began); TFA_E_DISCONNECTED (the daemon ended or hung up: tfa_client_reconnect);
 *         TFA_E_SIZE (count above max_batch, tips above max_tips; or more answers of a batch than a
 *         slot holds: ask for fewer states or fewer answers at once);
 *         TFA_E_UNSUPPORTED (mass matrix or derivatives of more than 256 freedoms);
 *         TFA_E_PROTOCOL.
 */
TFA_API int tfa_client_call(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                            uint64_t timeout_ns, tfa_exchange *exchange);

/**
 * Writes a request into the ring without waiting. Wakes a sleeping worker. With options.standby_dir
 * and after the end of the connection it looks for the other daemon, for 2 ms at most.
 *
 * @param client   connected
 * @param request  copied
 * @param id       of the request, counted from 1; may be NULL
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_AGAIN, TFA_E_DISCONNECTED, TFA_E_SIZE,
 *         TFA_E_UNSUPPORTED as tfa_client_call
 */
TFA_API TFA_CHECKED int tfa_client_send(tfa_client *client, const tfa_request *request,
                                        uint64_t *id);

/**
 * Waits for the reply to the oldest request of tfa_client_send that was not received yet. Buffers
 * of `reply` that are NULL are skipped. Times and id as tfa_client_call.
 * @return as tfa_client_call; TFA_E_ARGUMENT also if no request is outstanding; TFA_E_LOST (a
 *         request lost at reconnection, its id in exchange->id)
 */
TFA_API int tfa_client_receive(tfa_client *client, tfa_reply *reply, uint64_t timeout_ns,
                               tfa_exchange *exchange);

/**
 * Gives a command to the daemon of a runtime directory and waits for its answer:
 *   "status"  JSON: robots, workers, clients, counters; for every process that may connect
 *   "reload"  reads configuration and robots again; answers "ok: ..." when it is done
 *   "stop"    answers "ok: ..." and stops
 * Any thread. Allocates; system calls.
 *
 * @param runtime_dir  as tfa_client_options
 * @param command      one of the above
 * @param timeout_ms   of the answer; 0: 10000
 * @param text         answer, always terminated if size > 0; 65536 bytes hold any
 * @param size         of text, bytes
 * @return TFA_OK; TFA_E_REFUSED (the answer, "error: ...", says why); TFA_E_ARGUMENT (a NULL, a
 *         path too long for a socket); TFA_E_DISCONNECTED (no daemon there, or it hung up);
 *         TFA_E_TIMEOUT (a command that the daemon has not read by then is dropped); TFA_E_MEMORY;
 *         TFA_E_SYSTEM (see errno)
 */
TFA_API TFA_CHECKED int tfa_daemon_command(const char *runtime_dir, const char *command,
                                           int32_t timeout_ms, char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
