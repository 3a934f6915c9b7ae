/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Encoding and decoding of replies.
 */
#include "ipc/wire_reply.h"

#include <string.h>

/* Where a tfa_reply has the pointer to a block */
static const uint16_t buffer_offset[TFA_WIRE_REPLY_BLOCKS] = {
#define OFFSET(block, field, bytes) offsetof(tfa_reply, field),
    TFA_WIRE_REPLY_LIST(OFFSET)
#undef OFFSET
};

static void *buffer_of(const tfa_reply *r, uint32_t block)
{
    void *buffer;
    memcpy(&buffer, (const unsigned char *)r + buffer_offset[block], sizeof buffer);
    return buffer;
}

static void set_buffer(tfa_reply *r, uint32_t block, void *buffer)
{
    memcpy((unsigned char *)r + buffer_offset[block], &buffer, sizeof buffer);
}

/* Blocks with n x n numbers a state; and all matrices, which share room in slots of batches */
#define DENSE_BLOCKS (TFA_WIRE_BIT(MASS_MATRIX) | TFA_WIRE_DERIVATIVES)
#define SQUARE_BLOCKS                                                                              \
    (DENSE_BLOCKS | TFA_WIRE_BIT(LAMBDA_INV) | TFA_WIRE_BIT(LAMBDA) | TFA_WIRE_BIT(JACOBIAN) |     \
     TFA_WIRE_BIT(COM_JACOBIAN))

/* Bytes of these blocks */
static size_t blocks_width(const tfa_wire_shape *shape, uint32_t blocks,
                           const tfa_wire_reply_shape *reply_shape)
{
    size_t bytes = 0;
    for (uint32_t bits = blocks; bits; bits &= bits - 1)
        bytes += tfa_wire_padded_size(
            tfa_wire_reply_width(shape, (uint32_t)__builtin_ctz(bits), reply_shape));
    return bytes;
}

/* Bytes for the blocks of quadratic size: those of forward dynamics or task torques with every
 * flag, or of derivatives. */
static size_t square_capacity(const tfa_wire_shape *shape)
{
    const size_t n = tfa_wire_freedoms(shape), rows = (size_t)6 * shape->max_tips;
    const size_t tips = 2 * rows * rows, dense = n <= TFA_WIRE_MASS_MATRIX_MAX ? 3 * n * n : 0;
    const size_t state = sizeof(double) * ((rows + 3) * n + (dense > tips ? dense : tips));
    const size_t all = state * shape->max_batch;
    const size_t cap = all < TFA_WIRE_SQUARE_BYTES ? all : TFA_WIRE_SQUARE_BYTES;
    return cap > state ? cap : state;
}

size_t tfa_wire_reply_capacity(const tfa_wire_shape *shape)
{
    const tfa_wire_reply_shape all = {
        .count = shape->max_batch, .tip_count = shape->max_tips, .rows = 6 * shape->max_tips};
    const uint32_t rest = (uint32_t)((UINT64_C(1) << TFA_WIRE_REPLY_BLOCKS) - 1) & ~SQUARE_BLOCKS;
    return TFA_WIRE_LINE + square_capacity(shape) + blocks_width(shape, rest, &all);
}

int tfa_wire_check_reply_shape(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                               tfa_field *invalid_field)
{
    *invalid_field = TFA_FIELD_TIPS;
    if (reply_shape->tip_count > shape->max_tips)
        return TFA_E_SIZE;
    *invalid_field = TFA_FIELD_COUNT;
    if (reply_shape->count > shape->max_batch)
        return TFA_E_SIZE;
    const uint32_t squares = reply_shape->want & SQUARE_BLOCKS;
    if (!squares)
        return TFA_OK;
    *invalid_field = TFA_FIELD_OP;
    if (squares & DENSE_BLOCKS && tfa_wire_freedoms(shape) > TFA_WIRE_MASS_MATRIX_MAX)
        return TFA_E_UNSUPPORTED;
    *invalid_field = TFA_FIELD_COUNT;
    return blocks_width(shape, squares, reply_shape) <= square_capacity(shape) ? TFA_OK
                                                                               : TFA_E_SIZE;
}

uint32_t tfa_wire_want(const tfa_request *request, const tfa_reply *reply)
{
    uint32_t want = tfa_wire_blocks_of(request);
    if (!reply)
        return want;
    for (uint32_t bits = want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        want &= ~((uint32_t)(buffer_of(reply, block) == NULL) << block);
    }
    if (!reply->lambda_inv) /* the spectrum is computed from this buffer */
        want &= ~TFA_WIRE_BIT(SPECTRUM);
    return want;
}

uint32_t tfa_wire_possible(const tfa_wire_shape *shape, const tfa_request *request)
{
    return tfa_wire_of_robot(shape, tfa_wire_blocks_of(request));
}

void tfa_wire_reply_buffers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                            void *slot, tfa_reply *reply)
{
    unsigned char *at = (unsigned char *)slot + TFA_WIRE_LINE;
    /* member by member, as in decode_line */
#define CLEAR(block, field, bytes) reply->field = NULL;
    TFA_WIRE_REPLY_LIST(CLEAR)
#undef CLEAR
    for (uint32_t bits = reply_shape->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        set_buffer(reply, block, at);
        at += tfa_wire_padded_size(tfa_wire_reply_width(shape, block, reply_shape));
    }
}

size_t tfa_wire_reply_bytes(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape)
{
    return TFA_WIRE_LINE + blocks_width(shape, reply_shape->want, reply_shape);
}

void tfa_wire_encode_reply(const tfa_reply *reply, uint32_t want, void *slot)
{
    tfa_wire_reply *line = slot;
    line->model = reply->model;
    line->status = (int16_t)reply->status;
    line->field = tfa_wire_clamp_u16((uint32_t)reply->field);
    line->index = reply->index;
    line->state = reply->state;
    line->want = tfa_wire_has_answers(reply->status) ? want : 0;
}

uint32_t tfa_wire_decode_reply(const void *slot, tfa_reply *reply)
{
    const tfa_wire_reply *line = slot;
    reply->model = line->model;
    reply->status = line->status;
    reply->field = (tfa_field)line->field;
    reply->index = line->index;
    reply->state = line->state;
    return line->want;
}

void tfa_wire_copy_answers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                           const void *slot, tfa_reply *reply)
{
    const unsigned char *at = (const unsigned char *)slot + TFA_WIRE_LINE;
    for (uint32_t bits = reply_shape->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        const size_t size = tfa_wire_reply_width(shape, block, reply_shape);
        void *const buffer = buffer_of(reply, block);
        if (buffer)
            memcpy(buffer, at, size);
        at += tfa_wire_padded_size(size);
    }
}
