/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Encoding and decoding of replies.
 */
#include "ipc/wire_reply.h"

#include <string.h>

/* Blocks with n x n numbers a state */
#define DENSE(name, member, rows, columns, ...)                                                    \
    | (EXTENT_##rows == EXTENT_FREEDOMS && EXTENT_##columns == EXTENT_FREEDOMS                     \
           ? TFA_WIRE_BIT(name)                                                                    \
           : 0)
static const uint64_t dense_blocks = 0 TFA_OUTPUT_LIST(DENSE);
#undef DENSE

/* Bytes of these blocks */
static size_t blocks_width(const tfa_wire_shape *shape, uint64_t blocks,
                           const tfa_wire_reply_shape *reply_shape)
{
    size_t bytes = 0;
    for (uint64_t bits = blocks; bits; bits &= bits - 1)
        bytes += tfa_wire_padded_size(
            tfa_wire_reply_width(shape, (uint32_t)__builtin_ctzll(bits), reply_shape));
    return bytes;
}

/* Most bytes of the blocks of one state that share: of the ops with every flag */
static size_t shared_bytes_of_state(const tfa_wire_shape *shape)
{
    const int too_large = tfa_wire_freedoms(shape) > TFA_WIRE_MASS_MATRIX_MAX;
    size_t most = 0;
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        const uint32_t tips = shape->max_tips;
        const tfa_request r = {.op = (tfa_op)op,
                               .flags = TFA_WANT_ALL,
                               .count = 1,
                               .tip_count = tips,
                               .constraints = tips < 32 ? (1u << tips) - 1 : UINT32_MAX};
        const tfa_wire_reply_shape all = tfa_wire_reply_shape_of(shape, &r);
        const uint64_t never = TFA_WIRE_EVERY_STATE | (too_large ? dense_blocks : 0);
        const size_t bytes = blocks_width(shape, all.want & ~never, &all);
        most = bytes > most ? bytes : most;
    }
    return most;
}

static size_t shared_capacity(const tfa_wire_shape *shape)
{
    const size_t state = shared_bytes_of_state(shape), all = state * shape->max_batch;
    const size_t cap = all < TFA_WIRE_SHARED_BYTES ? all : TFA_WIRE_SHARED_BYTES;
    return cap > state ? cap : state;
}

size_t tfa_wire_reply_capacity(const tfa_wire_shape *shape)
{
    const uint64_t torques = TFA_WIRE_BIT(OUT_TAU) | TFA_WIRE_BIT(OUT_BASE_WRENCH);
    const tfa_wire_reply_shape all = {.count = shape->max_batch, .tip_count = shape->max_tips};
    const uint64_t want = tfa_wire_of_robot(shape, TFA_WIRE_EVERY_STATE & ~torques);
    return TFA_WIRE_LINE + shared_capacity(shape) + blocks_width(shape, want, &all);
}

/* 1: a slot holds these blocks of so many states, at most max_batch. What is not above the limit of
 * all needs no capacity to compare with. */
static int fits(const tfa_wire_shape *shape, size_t bytes, uint32_t count)
{
    return count == 1 || bytes <= TFA_WIRE_SHARED_BYTES || bytes <= shared_capacity(shape);
}

int tfa_wire_check_reply_shape(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                               tfa_field *invalid_field)
{
    *invalid_field = TFA_FIELD_TIPS;
    if (reply_shape->tip_count > shape->max_tips)
        return TFA_E_SIZE;
    *invalid_field = TFA_FIELD_CONSTRAINTS;
    if (reply_shape->constraints > tfa_wire_constraints(shape))
        return TFA_E_SIZE;
    *invalid_field = TFA_FIELD_COUNT;
    if (reply_shape->count > shape->max_batch)
        return TFA_E_SIZE;
    const uint64_t shared = reply_shape->want & ~TFA_WIRE_EVERY_STATE;
    if (!shared)
        return TFA_OK;
    *invalid_field = TFA_FIELD_OP;
    if (shared & dense_blocks && tfa_wire_freedoms(shape) > TFA_WIRE_MASS_MATRIX_MAX)
        return TFA_E_UNSUPPORTED;
    *invalid_field = TFA_FIELD_COUNT;
    return fits(shape, blocks_width(shape, shared, reply_shape), reply_shape->count) ? TFA_OK
                                                                                     : TFA_E_SIZE;
}

uint64_t tfa_wire_want(const tfa_request *request, const tfa_reply *reply)
{
    uint64_t want = tfa_wire_blocks_of(request);
    if (!reply)
        return want;
    for (uint64_t bits = want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        want &= ~((uint64_t)(tfa_output_buffer(&tfa_outputs[block], reply) == NULL) << block);
    }
    if (!reply->lambda_inv) /* the spectrum is computed from this buffer */
        want &= ~TFA_WIRE_BIT(SPECTRUM);
    return want;
}

uint64_t tfa_wire_possible(const tfa_wire_shape *shape, const tfa_request *request)
{
    return tfa_wire_of_robot(shape, tfa_wire_blocks_of(request));
}

void tfa_wire_reply_buffers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                            void *slot, tfa_reply *reply)
{
    unsigned char *at = (unsigned char *)slot + TFA_WIRE_LINE;
    /* member by member, as in decode_line */
#define CLEAR(block, member, ...) reply->member = NULL;
    TFA_OUTPUT_LIST(CLEAR)
#undef CLEAR
    for (uint64_t bits = reply_shape->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        tfa_output_set_buffer(&tfa_outputs[block], reply, at);
        at += tfa_wire_padded_size(tfa_wire_reply_width(shape, block, reply_shape));
    }
}

void tfa_wire_move_buffers(uint64_t want, const void *from, void *to, tfa_reply *reply)
{
    for (uint64_t bits = want; bits; bits &= bits - 1) {
        const tfa_output *output = &tfa_outputs[__builtin_ctzll(bits)];
        const unsigned char *at = tfa_output_buffer(output, reply);
        tfa_output_set_buffer(output, reply,
                              (unsigned char *)to + (at - (const unsigned char *)from));
    }
}

size_t tfa_wire_reply_bytes(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape)
{
    return TFA_WIRE_LINE + blocks_width(shape, reply_shape->want, reply_shape);
}

void tfa_wire_encode_reply(const tfa_reply *reply, uint64_t want, void *slot)
{
    tfa_wire_reply *line = slot;
    line->model = reply->model;
    line->status = (int16_t)reply->status;
    line->field = tfa_wire_clamp_u16((uint32_t)reply->field);
    line->index = reply->index;
    line->state = reply->state;
    line->want = tfa_wire_has_answers(reply->status) ? want : 0;
}

uint64_t tfa_wire_decode_reply(const void *slot, tfa_reply *reply)
{
    const tfa_wire_reply *line = slot;
    reply->model = line->model;
    reply->status = line->status;
    reply->field = (tfa_field)line->field;
    reply->index = line->index;
    reply->state = line->state;
    return line->want;
}

void tfa_wire_write_answers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                            const tfa_reply *reply, void *slot)
{
    unsigned char *at = (unsigned char *)slot + TFA_WIRE_LINE;
    for (uint64_t bits = reply_shape->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        const size_t size = tfa_wire_reply_width(shape, block, reply_shape);
        memcpy(at, tfa_output_buffer(&tfa_outputs[block], reply), size);
        at += tfa_wire_padded_size(size);
    }
}

void tfa_wire_copy_answers(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                           const void *slot, tfa_reply *reply)
{
    const unsigned char *at = (const unsigned char *)slot + TFA_WIRE_LINE;
    for (uint64_t bits = reply_shape->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        const size_t size = tfa_wire_reply_width(shape, block, reply_shape);
        void *const buffer = tfa_output_buffer(&tfa_outputs[block], reply);
        if (buffer)
            memcpy(buffer, at, size);
        at += tfa_wire_padded_size(size);
    }
}
