/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The wire format: requests and replies as bytes in a slot of the ring.
 *
 * A slot is one line of 64 bytes and a payload of doubles. The payload holds only the blocks whose
 * bit is set in the line, in the order of the enums below, one after the other, so the common
 * request (7 joints, q v tau) is 4 cache lines and its reply 3. Both sides compute every size from
 * the shape they agreed on at connection; no offset and no size ever comes out of a slot unchecked.
 */
#ifndef TFA_IPC_WIRE_H
#define TFA_IPC_WIRE_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/status.h>

#define TFA_WIRE_LINE 64
/** Answers whose size grows with a square (lambda_inv, M) get this much of a slot, or what one
 *  state of the robot needs when that is more: a slot stays small for large batches. */
#define TFA_WIRE_SQUARE_BYTES ((size_t)1 << 20)
/** Beyond so many freedoms a mass matrix is not sent through a slot (512 KiB at 256). */
#define TFA_WIRE_MASS_MATRIX_MAX 256

/** Sizes of the robot and of the largest request: all that a layout depends on. */
typedef struct tfa_wire_shape {
    uint32_t q_count, v_count, base_freedoms, max_batch;
} tfa_wire_shape;

/** Blocks of a request, in payload order; bit k of tfa_wire_request.present. */
enum {
    TFA_WIRE_Q,
    TFA_WIRE_V,
    TFA_WIRE_TAU,
    TFA_WIRE_QDD,
    TFA_WIRE_BASE_POSE,
    TFA_WIRE_BASE_TWIST,
    TFA_WIRE_BASE_WRENCH,
    TFA_WIRE_BASE_ACCELERATION,
    TFA_WIRE_GRAVITY,
    TFA_WIRE_WRENCHES,
    TFA_WIRE_PAYLOADS,
    TFA_WIRE_LOCKED, /* joint indices: uint32_t, padded to 8 bytes */
    TFA_WIRE_REQUEST_BLOCKS
};

/** Blocks of a reply, in payload order; bit k of tfa_wire_request.want. */
enum {
    TFA_WIRE_ANSWERS,
    TFA_WIRE_OUT_QDD,
    TFA_WIRE_OUT_BASE_ACCELERATION,
    TFA_WIRE_OUT_TAU,
    TFA_WIRE_OUT_BASE_WRENCH,
    TFA_WIRE_LAMBDA_INV,
    TFA_WIRE_MASS_MATRIX,
    TFA_WIRE_SPECTRUM,
    TFA_WIRE_POSES,
    TFA_WIRE_REPLY_BLOCKS
};

/** Line 0 of a request slot. After it: tips, wrench frames and payload frames (uint32_t, padded to
 *  8 bytes), then the blocks. */
typedef struct tfa_wire_request {
    _Atomic uint64_t seq; /**< index in the ring + 1; stored last (ring.h) */
    uint64_t id;          /**< the client's; echoed */
    uint64_t t_sent;      /**< CLOCK_MONOTONIC ns */
    uint32_t count, dof;  /**< states; q_count + v_count + base freedoms, as a check */
    uint32_t refine, flags;
    uint32_t locked_count;
    uint16_t op, method;     /**< what does not fit is sent as 65535: invalid too */
    uint16_t present, want;  /**< blocks */
    uint8_t estimate, frame; /**< what does not fit is sent as 255: invalid too */
    uint8_t tip_count, wrench_count, payload_count; /**< the same */
    uint8_t reserved[7];                            /**< 0 */
} tfa_wire_request;

/** Line 0 of a reply slot. */
typedef struct tfa_wire_reply {
    _Atomic uint64_t seq; /**< index in the ring + 1; stored last (ring.h) */
    uint64_t id;
    uint64_t t_received, t_start, t_done; /**< CLOCK_MONOTONIC ns */
    uint64_t model; /**< tfa_model_tag of the model that answered; 0: none did */
    int32_t status;
    uint32_t index, state;
    uint16_t field;
    uint16_t want; /**< blocks that follow; 0 when nothing was computed */
} tfa_wire_reply;

_Static_assert(sizeof(tfa_wire_request) == TFA_WIRE_LINE, "a request's line is one cache line");
_Static_assert(sizeof(tfa_wire_reply) == TFA_WIRE_LINE, "a reply's line is one cache line");
_Static_assert(TFA_WIRE_REQUEST_BLOCKS <= 16 && TFA_WIRE_REPLY_BLOCKS <= 16,
               "blocks have a bit each");
_Static_assert(ATOMIC_LLONG_LOCK_FREE == 2, "the ring needs lock-free 64-bit atomics");

/** What decides the layout of a reply: kept in private memory by both sides. */
typedef struct tfa_wire_reply_shape {
    uint32_t count, tip_count;
    uint32_t want;
} tfa_wire_reply_shape;

/** Bytes of a slot that holds any request (reply) of this shape. */
size_t tfa_wire_request_capacity(const tfa_wire_shape *shape);
size_t tfa_wire_reply_capacity(const tfa_wire_shape *shape);

/** Blocks that the op of a request answers; those whose buffer is NULL are left out when `reply`
 *  is given. */
uint32_t tfa_wire_want(const tfa_request *request, const tfa_reply *reply);

/**
 * Writes a request into a slot, all but seq. A request that tfa_request_check would refuse is
 * written all the same: the daemon gives the same refusal.
 * @return TFA_OK and *ask; TFA_E_SIZE (count beyond max_batch, or more answers than a slot holds);
 *         TFA_E_UNSUPPORTED (mass matrix of more than TFA_WIRE_MASS_MATRIX_MAX freedoms).
 */
int tfa_wire_encode_request(const tfa_wire_shape *shape, const tfa_request *request, uint32_t want,
                            uint64_t id, uint64_t t_sent, void *slot,
                            tfa_wire_reply_shape *reply_shape);

/**
 * Copies a slot once into private memory: the line, then as much payload as the private copy of
 * the line asks for, at most tfa_wire_request_capacity. Nothing in it is trusted.
 */
void tfa_wire_copy_request(const tfa_wire_shape *shape, const void *slot, void *copy);

/**
 * Makes a request of a private copy: pointers into the copy.
 * @return TFA_OK; TFA_E_SIZE, TFA_E_UNSUPPORTED as tfa_wire_encode_request; TFA_E_PROTOCOL (made
 *         for another robot). *invalid_field: TFA_FIELD_COUNT, TFA_FIELD_OP or TFA_FIELD_NONE.
 */
int tfa_wire_decode_request(const tfa_wire_shape *shape, const void *copy, tfa_request *request,
                            tfa_wire_reply_shape *reply_shape, tfa_field *invalid_field);

/** Points the buffers of a reply into a reply slot: for the daemon to compute into, for the client
 *  to read. Buffers of blocks that are not wanted become NULL. */
void tfa_wire_reply_buffers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                            void *slot, tfa_reply *reply);

/** Writes what the line of a reply says about the request as a whole; not seq, not the times. */
void tfa_wire_encode_reply(const tfa_reply *reply, uint32_t want, void *slot);

/** Reads the line of a reply: status, field, index, state, model. @return blocks that follow */
uint32_t tfa_wire_decode_reply(const void *slot, tfa_reply *reply);

/** Copies the answers of a slot to the buffers of `reply` that are not NULL. */
void tfa_wire_copy_answers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                           const void *slot, tfa_reply *reply);

/** True when a reply of this status carries answers: computing was tried. */
static inline int tfa_wire_has_answers(int status)
{
    return status == TFA_OK || status == TFA_E_NOT_COMPUTED || status == TFA_E_SINGULAR;
}

#endif
