/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The wire format: requests and replies as bytes in a slot of the ring.
 *
 * A slot is a head of 88 bytes, called its line, and a payload. The payload holds the blocks whose
 * bit is set in the line, in the order of interface/fields.h: 4 cache lines for a request of 7
 * joints (q, v, tau), 3 for its reply. Both sides compute every size from the shape that they
 * agreed on at connection; no offset and no size is read from a slot unchecked.
 */
#ifndef TFA_IPC_WIRE_H
#define TFA_IPC_WIRE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/status.h>

#include "ipc/wire_blocks.h"

#define TFA_CACHE_LINE 64
/** Bytes of a line: it has room for more members, and seven joints fill their cache lines. */
#define TFA_WIRE_LINE 88
/** Line 0 of a request slot. After it: tips, wrench frames and payload frames (uint32_t, padded to
 *  8 bytes), then the blocks. */
typedef struct tfa_wire_request {
    _Atomic uint64_t seq;   /**< index in the ring + 1; stored last (ring.h) */
    uint64_t id;            /**< the client's; echoed */
    uint64_t t_sent;        /**< CLOCK_MONOTONIC ns */
    uint64_t want, present; /**< blocks */
    uint32_t count, dof;    /**< states; q_count + v_count + base freedoms + modes, as a check */
    uint32_t refine, flags;
    uint32_t locked_count;
    uint32_t deadline_us;    /**< after t_sent; 0: none. A request that begins later is refused */
    uint8_t op, method;      /**< larger numbers become 255, which is invalid as well */
    uint8_t estimate, frame; /**< the same */
    uint8_t tip_count, wrench_count, payload_count, rows, rank_loss; /**< the same */
    uint8_t padding[3];                                              /**< 0 */
    uint32_t constraints;                                            /**< active ones */
    uint8_t reserved[8];                                             /**< 0 */
} tfa_wire_request;

/** Line 0 of a reply slot. */
typedef struct tfa_wire_reply {
    _Atomic uint64_t seq; /**< index in the ring + 1; stored last (ring.h) */
    uint64_t id;
    uint64_t t_received, t_start, t_done; /**< CLOCK_MONOTONIC ns */
    uint64_t model; /**< tfa_model_tag of the model that answered; 0: none did */
    uint64_t want;  /**< blocks that follow; 0 when nothing was computed */
    int16_t status;
    uint16_t field;
    uint32_t index, state;
    uint32_t reserved[5]; /**< 0 */
} tfa_wire_reply;

/** The form of the last request that was decoded from a copy: its line from `want` on, and what
 *  follows from that. Requests of one form differ in id, time, frame indices and numbers. Private
 *  memory of the worker; {0}: none was. */
#define TFA_WIRE_FORM_AT offsetof(tfa_wire_request, want)
typedef struct tfa_wire_form {
    unsigned char line[TFA_WIRE_LINE - TFA_WIRE_FORM_AT];
    size_t bytes; /**< of a copy; 0: no form */
    tfa_wire_reply_shape reply_shape;
} tfa_wire_form;

_Static_assert(sizeof(tfa_wire_request) == TFA_WIRE_LINE, "a request's line");
_Static_assert(sizeof(tfa_wire_reply) == TFA_WIRE_LINE, "a reply's line");
_Static_assert(TFA_WIRE_REQUEST_BLOCKS < 64 && TFA_WIRE_REPLY_BLOCKS < 64,
               "blocks have a bit each");
_Static_assert(ATOMIC_LLONG_LOCK_FREE == 2, "the ring needs lock-free 64-bit atomics");

/** Bytes of a slot that holds any request (reply) of this shape. */
size_t tfa_wire_request_capacity(const tfa_wire_shape *shape);
size_t tfa_wire_reply_capacity(const tfa_wire_shape *shape);

/** Index of a refusal with this field by tfa_wire_encode_request or tfa_wire_decode_request: the
 *  number of tips, states or constraints that was asked for; 0 with another field. */
static inline uint32_t tfa_wire_refused_index(const tfa_request *request, tfa_field field)
{
    return field == TFA_FIELD_TIPS          ? request->tip_count
           : field == TFA_FIELD_COUNT       ? request->count
           : field == TFA_FIELD_CONSTRAINTS ? (uint32_t)__builtin_popcount(request->constraints)
                                            : 0;
}

/** Blocks that the op of a request answers; with a `reply`, only those whose buffer is not NULL. */
uint64_t tfa_wire_want(const tfa_request *request, const tfa_reply *reply);

/**
 * Writes a request into a slot, all but seq; also one that tfa_request_check refuses: the daemon
 * gives the same refusal.
 * @return TFA_OK and *reply_shape; TFA_E_SIZE (count above max_batch, tips or constraints above
 *         max_tips, or more answers than a slot holds); TFA_E_UNSUPPORTED (mass matrix or
 *         derivatives of more than TFA_WIRE_MASS_MATRIX_MAX freedoms). *invalid_field (may be
 *         NULL): TFA_FIELD_COUNT, TFA_FIELD_TIPS, TFA_FIELD_CONSTRAINTS, TFA_FIELD_OP or
 *         TFA_FIELD_NONE.
 */
int tfa_wire_encode_request(const tfa_wire_shape *shape, const tfa_request *request, uint64_t want,
                            uint64_t id, uint64_t t_sent, void *slot,
                            tfa_wire_reply_shape *reply_shape, tfa_field *invalid_field);

/** Bytes that tfa_wire_encode_request writes; of a private copy of a slot: that were copied. */
size_t tfa_wire_request_bytes(const tfa_wire_shape *shape, const tfa_request *request);
size_t tfa_wire_copied_bytes(const tfa_wire_shape *shape, const void *copy);

/**
 * Copies a slot once into private memory: the line, then the payload that the copied line states,
 * at most tfa_wire_request_capacity bytes. Nothing in it is trusted.
 * @return the copy has this form: a request decoded from the same copy before is valid again after
 *         tfa_wire_decode_again
 */
bool tfa_wire_copy_request(const tfa_wire_shape *shape, const tfa_wire_form *form, const void *slot,
                           void *copy);

/**
 * Decodes a private copy into a request whose arrays point into the copy.
 * @return TFA_OK; TFA_E_SIZE, TFA_E_UNSUPPORTED as tfa_wire_encode_request; TFA_E_PROTOCOL (made
 *         for another robot). *invalid_field as there, but it is not NULL.
 */
int tfa_wire_decode_request(const tfa_wire_shape *shape, const void *copy, tfa_request *request,
                            tfa_wire_reply_shape *reply_shape, tfa_field *invalid_field);

/** Keeps the form of a copy that was decoded to a reply of this shape. */
void tfa_wire_keep_form(const tfa_wire_shape *shape, const void *copy,
                        const tfa_wire_reply_shape *reply_shape, tfa_wire_form *form);

/** Reads the frame indices, and the estimate, which an estimate policy may have settled, of a copy
 *  that has the form of `request`. */
void tfa_wire_decode_again(const tfa_wire_shape *shape, const void *copy, tfa_request *request);

/** Points the buffers of a reply into a reply slot; those of blocks not wanted become NULL. */
void tfa_wire_reply_buffers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                            void *slot, tfa_reply *reply);

/** Moves the buffers of these blocks from the slot that they point into to another one. */
void tfa_wire_move_buffers(uint64_t want, const void *from, void *to, tfa_reply *reply);

/** Bytes of a reply with its line. */
size_t tfa_wire_reply_bytes(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape);

/** Writes the line of a reply, all but seq and the times. */
void tfa_wire_encode_reply(const tfa_reply *reply, uint64_t want, void *slot);

/** Reads the line of a reply: status, field, index, state, model. @return blocks that follow */
uint64_t tfa_wire_decode_reply(const void *slot, tfa_reply *reply);

/** Writes the blocks of a reply that reply_shape wants into a slot, after its line: the opposite of
 *  tfa_wire_copy_answers. */
void tfa_wire_write_answers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                            const tfa_reply *reply, void *slot);

/** Copies the answers of a slot to the buffers of `reply` that are not NULL. */
void tfa_wire_copy_answers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                           const void *slot, tfa_reply *reply);

#endif
