/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sizes of replies that requests depend on. Private to wire.c and wire_reply.c.
 */
#ifndef TFA_IPC_WIRE_REPLY_H
#define TFA_IPC_WIRE_REPLY_H

#include "ipc/wire.h"

static inline uint16_t tfa_wire_clamp_u16(uint32_t x)
{
    return (uint16_t)(x < UINT16_MAX ? x : UINT16_MAX);
}

/* Every block begins at a multiple of 8 bytes. */
static inline size_t tfa_wire_padded_size(size_t bytes)
{
    return (bytes + 7) & ~(size_t)7;
}

/* Blocks of the answers to a request for this robot. */
uint64_t tfa_wire_possible(const tfa_wire_shape *shape, const tfa_request *request);

/* Checks that a slot holds these answers. The invalid field is the count, the tips or the op.
 * @return TFA_OK, TFA_E_SIZE, TFA_E_UNSUPPORTED */
int tfa_wire_check_reply_shape(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                               tfa_field *invalid_field);

#endif
