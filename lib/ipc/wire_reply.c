/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Encoding and decoding of replies.
 */
#include "ipc/wire_reply.h"

#include <string.h>

typedef void *reply_arrays[TFA_WIRE_REPLY_BLOCKS];

/* Bytes of a block of a reply, without padding. */
static size_t reply_width(const tfa_wire_shape *shape, uint32_t block,
                          const tfa_wire_reply_shape *reply_shape)
{
    const size_t count = reply_shape->count, tips = reply_shape->tip_count;
    const size_t n = tfa_wire_freedoms(shape);
    switch (block) {
#define WIDTH(name, field, bytes)                                                                  \
    case TFA_WIRE_##name:                                                                          \
        return bytes;
        TFA_WIRE_REPLY_LIST(WIDTH)
#undef WIDTH
    default:
        return 0;
    }
}

/* Bytes for the blocks of quadratic size. */
static size_t square_capacity(const tfa_wire_shape *shape)
{
    const tfa_wire_reply_shape one = {.count = 1, .tip_count = TFA_MAX_TIPS};
    const size_t lambda = reply_width(shape, TFA_WIRE_LAMBDA_INV, &one);
    size_t state = lambda;
    if (tfa_wire_freedoms(shape) <= TFA_WIRE_MASS_MATRIX_MAX) {
        const size_t mass = reply_width(shape, TFA_WIRE_MASS_MATRIX, &one);
        state = mass > lambda ? mass : lambda;
    }
    const size_t all = state * shape->max_batch;
    const size_t cap = all < TFA_WIRE_SQUARE_BYTES ? all : TFA_WIRE_SQUARE_BYTES;
    return cap > state ? cap : state;
}

size_t tfa_wire_reply_capacity(const tfa_wire_shape *shape)
{
    const tfa_wire_reply_shape all = {.count = shape->max_batch, .tip_count = TFA_MAX_TIPS};
    return TFA_WIRE_LINE + square_capacity(shape) + reply_width(shape, TFA_WIRE_ANSWERS, &all) +
           reply_width(shape, TFA_WIRE_SPECTRUM, &all) + reply_width(shape, TFA_WIRE_POSES, &all) +
           reply_width(shape, TFA_WIRE_OUT_QDD, &all) +
           reply_width(shape, TFA_WIRE_OUT_BASE_ACCELERATION, &all);
}

int tfa_wire_check_reply_shape(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                               tfa_field *invalid_field)
{
    const uint32_t squares = 1u << TFA_WIRE_LAMBDA_INV | 1u << TFA_WIRE_MASS_MATRIX;
    size_t bytes = 0;
    *invalid_field = TFA_FIELD_COUNT;
    if (reply_shape->count > shape->max_batch)
        return TFA_E_SIZE;
    if (!(reply_shape->want & squares))
        return TFA_OK;
    *invalid_field = TFA_FIELD_OP;
    if (reply_shape->want >> TFA_WIRE_MASS_MATRIX & 1 &&
        tfa_wire_freedoms(shape) > TFA_WIRE_MASS_MATRIX_MAX)
        return TFA_E_UNSUPPORTED;
    *invalid_field = TFA_FIELD_COUNT;
    for (uint32_t block = TFA_WIRE_LAMBDA_INV; block <= TFA_WIRE_MASS_MATRIX; block++)
        if (reply_shape->want >> block & 1)
            bytes += reply_width(shape, block, reply_shape);
    return bytes <= square_capacity(shape) ? TFA_OK : TFA_E_SIZE;
}

static void arrays_of_reply(const tfa_reply *r, reply_arrays arrays)
{
#define GET(block, field, bytes) arrays[TFA_WIRE_##block] = r->field;
    TFA_WIRE_REPLY_LIST(GET)
#undef GET
}

/* Blocks of the answers to a request. */
static uint32_t blocks_of_op(const tfa_request *r)
{
    uint32_t always = 1u << TFA_WIRE_ANSWERS, lambda = 0;
    if (r->tip_count) {
        always |= r->flags & TFA_WANT_POSES ? 1u << TFA_WIRE_POSES : 0;
        lambda = 1u << TFA_WIRE_LAMBDA_INV;
        lambda |= r->flags & TFA_WANT_SPECTRUM ? 1u << TFA_WIRE_SPECTRUM : 0;
    }
    switch (r->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        return always | lambda | 1u << TFA_WIRE_OUT_QDD | 1u << TFA_WIRE_OUT_BASE_ACCELERATION;
    case TFA_OP_INVERSE_DYNAMICS:
        return always | 1u << TFA_WIRE_OUT_TAU | 1u << TFA_WIRE_OUT_BASE_WRENCH;
    case TFA_OP_OPERATIONAL_INERTIA:
        return always | lambda;
    case TFA_OP_MASS_MATRIX:
        return always | 1u << TFA_WIRE_MASS_MATRIX;
    default:
        return 0;
    }
}

uint32_t tfa_wire_want(const tfa_request *request, const tfa_reply *reply)
{
    uint32_t want = blocks_of_op(request);
    if (!reply)
        return want;
    reply_arrays arrays;
    arrays_of_reply(reply, arrays);
    for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++)
        if (!arrays[block])
            want &= ~(1u << block);
    if (!arrays[TFA_WIRE_LAMBDA_INV]) /* the spectrum is computed from this buffer */
        want &= ~(1u << TFA_WIRE_SPECTRUM);
    return want;
}

uint32_t tfa_wire_possible(const tfa_wire_shape *shape, const tfa_request *request)
{
    return tfa_wire_of_robot(shape, blocks_of_op(request));
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
        switch (block) {
#define SET(name, field, bytes)                                                                    \
    case TFA_WIRE_##name:                                                                          \
        reply->field = (void *)at;                                                                 \
        break;
            TFA_WIRE_REPLY_LIST(SET)
#undef SET
        default:
            break;
        }
        at += tfa_wire_padded_size(reply_width(shape, block, reply_shape));
    }
}

void tfa_wire_encode_reply(const tfa_reply *reply, uint32_t want, void *slot)
{
    tfa_wire_reply *line = slot;
    line->model = reply->model;
    line->status = reply->status;
    line->field = tfa_wire_clamp_u16((uint32_t)reply->field);
    line->index = reply->index;
    line->state = reply->state;
    line->want = tfa_wire_has_answers(reply->status) ? (uint16_t)want : 0;
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
    reply_arrays arrays;
    arrays_of_reply(reply, arrays);
    for (uint32_t bits = reply_shape->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        const size_t size = reply_width(shape, block, reply_shape);
        if (arrays[block])
            memcpy(arrays[block], at, size);
        at += tfa_wire_padded_size(size);
    }
}
