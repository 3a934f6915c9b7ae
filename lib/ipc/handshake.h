/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Handshake on the control socket (AF_UNIX SOCK_SEQPACKET at RUNTIME_DIR/ROBOT.sock): one HELLO
 * from the client, one WELCOME from the daemon. Neither sends anything after WELCOME: the socket
 * represents the connection, and its hang-up ends it in both directions.
 */
#ifndef TFA_IPC_HANDSHAKE_H
#define TFA_IPC_HANDSHAKE_H

#include <stdint.h>

#include "ipc/ring.h"

#define TFA_HANDSHAKE_MAGIC 0x31414654u /* "TFA1" */
/** Incremented with every change of handshake.h, wire.h or ring.h. */
#define TFA_HANDSHAKE_ABI 13u
#define TFA_ROBOT_NAME_MAX 63
/** Locked (F_OFD_SETLK) by the daemon of a runtime directory during its lifetime. */
#define TFA_LOCK_FILE "totalforced.lock"
/** Written to the lock file, after the process id, once all sockets are open. */
#define TFA_LOCK_READY "ready"

typedef struct tfa_hello {
    uint32_t magic, abi;
    uint32_t slots, max_batch;
    uint32_t wait;     /**< tfa_wait */
    uint32_t max_tips; /**< of one request */
    char robot[TFA_ROBOT_NAME_MAX + 1];
} tfa_hello;

/** Descriptors of a WELCOME of status TFA_OK, in this order. */
enum {
    TFA_WELCOME_REQUESTS, /**< segment, read-write */
    TFA_WELCOME_REPLIES,  /**< segment, read-only */
    TFA_WELCOME_NAMES,    /**< names, read-only: see tfa_welcome.names_bytes */
    TFA_WELCOME_DOORBELL, /**< eventfd: write 1 to wake the worker */
    TFA_WELCOME_DESCRIPTORS
};

typedef struct tfa_welcome {
    uint32_t magic, abi;
    int32_t status; /** TFA_OK or the reason of a refusal; the rest but `text` is then 0 */
    int32_t daemon_pid;
    tfa_wire_shape shape;
    uint32_t joint_count, frame_count;
    uint32_t constraint_count, reserved; /** reserved: 0 */
    uint32_t wait, spin_ns;              /** granted */
    tfa_ring_layout layout;
    /** Size of the names segment: joint_count uint32_t tfa_joint_type, shape.modes uint32_t frames
     *  of flexible links, then joint_count, frame_count and constraint_count strings, each with its
     *  final 0. */
    uint64_t names_bytes;
    char model_hash[65];
    char text[191]; /** reason of a refusal */
} tfa_welcome;

#endif
