/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies to bytes and back.
 */
#include "client/wire.h"

#include <stdbool.h>
#include <string.h>

#define BASE_BLOCKS                                                                                \
    (1u << TFA_WIRE_BASE_POSE | 1u << TFA_WIRE_BASE_TWIST | 1u << TFA_WIRE_BASE_WRENCH |           \
     1u << TFA_WIRE_BASE_ACCELERATION)

#define BASE_ANSWERS (1u << TFA_WIRE_OUT_BASE_ACCELERATION | 1u << TFA_WIRE_OUT_BASE_WRENCH)

typedef const double *request_arrays[TFA_WIRE_REQUEST_BLOCKS];
typedef void *reply_arrays[TFA_WIRE_REPLY_BLOCKS];

static uint32_t freedoms(const tfa_wire_shape *shape)
{
    return shape->base_freedoms + shape->v_count;
}

static uint32_t dof_check(const tfa_wire_shape *shape)
{
    return shape->q_count + freedoms(shape);
}

static uint32_t at_most(uint32_t x, uint32_t limit)
{
    return x < limit ? x : limit;
}

/* ---- requests ---- */

/* Numbers in block `block` of a request: count and wrench_count are within their limits. */
static size_t request_width(const tfa_wire_shape *shape, uint32_t block, uint32_t count,
                            uint32_t wrench_count)
{
    switch (block) {
    case TFA_WIRE_Q:
        return (size_t)count * shape->q_count;
    case TFA_WIRE_V:
    case TFA_WIRE_TAU:
    case TFA_WIRE_QDD:
        return (size_t)count * shape->v_count;
    case TFA_WIRE_BASE_POSE:
        return (size_t)count * 7;
    case TFA_WIRE_GRAVITY:
        return 3;
    case TFA_WIRE_WRENCHES:
        return (size_t)count * 6 * wrench_count;
    default:
        return (size_t)count * 6;
    }
}

/* Bytes of the frame indices that stand before the blocks. */
static size_t frames_bytes(uint32_t tip_count, uint32_t wrench_count)
{
    return ((size_t)tip_count + wrench_count + 1) / 2 * sizeof(double);
}

size_t tfa_wire_request_capacity(const tfa_wire_shape *shape)
{
    size_t numbers = 0;
    for (uint32_t block = 0; block < TFA_WIRE_REQUEST_BLOCKS; block++)
        numbers += request_width(shape, block, shape->max_batch, TFA_MAX_WRENCHES);
    return TFA_WIRE_LINE + frames_bytes(TFA_MAX_TIPS, TFA_MAX_WRENCHES) + numbers * sizeof(double);
}

/* Bytes of the slot that a line asks for; never more than the capacity, whatever it says. */
static size_t request_bytes(const tfa_wire_shape *shape, const tfa_wire_request *line)
{
    const uint32_t count = at_most(line->count, shape->max_batch);
    const uint32_t tips = at_most(line->tip_count, TFA_MAX_TIPS);
    const uint32_t wrenches = at_most(line->wrench_count, TFA_MAX_WRENCHES);
    size_t numbers = 0;
    for (uint32_t block = 0; block < TFA_WIRE_REQUEST_BLOCKS; block++)
        if (line->present >> block & 1)
            numbers += request_width(shape, block, count, wrenches);
    return TFA_WIRE_LINE + frames_bytes(tips, wrenches) + numbers * sizeof(double);
}

static void arrays_of_request(const tfa_request *r, request_arrays arrays)
{
    arrays[TFA_WIRE_Q] = r->q;
    arrays[TFA_WIRE_V] = r->v;
    arrays[TFA_WIRE_TAU] = r->tau;
    arrays[TFA_WIRE_QDD] = r->qdd;
    arrays[TFA_WIRE_BASE_POSE] = r->base_pose;
    arrays[TFA_WIRE_BASE_TWIST] = r->base_twist;
    arrays[TFA_WIRE_BASE_WRENCH] = r->base_wrench;
    arrays[TFA_WIRE_BASE_ACCELERATION] = r->base_acceleration;
    arrays[TFA_WIRE_GRAVITY] = r->gravity;
    arrays[TFA_WIRE_WRENCHES] = r->wrenches;
}

static void request_of_arrays(const request_arrays arrays, tfa_request *r)
{
    r->q = arrays[TFA_WIRE_Q];
    r->v = arrays[TFA_WIRE_V];
    r->tau = arrays[TFA_WIRE_TAU];
    r->qdd = arrays[TFA_WIRE_QDD];
    r->base_pose = arrays[TFA_WIRE_BASE_POSE];
    r->base_twist = arrays[TFA_WIRE_BASE_TWIST];
    r->base_wrench = arrays[TFA_WIRE_BASE_WRENCH];
    r->base_acceleration = arrays[TFA_WIRE_BASE_ACCELERATION];
    r->gravity = arrays[TFA_WIRE_GRAVITY];
    r->wrenches = arrays[TFA_WIRE_WRENCHES];
}

static uint32_t blocks_of_request(const tfa_wire_shape *shape, const tfa_request *r,
                                  const request_arrays arrays)
{
    uint32_t present = 0;
    for (uint32_t block = 0; block < TFA_WIRE_REQUEST_BLOCKS; block++)
        if (arrays[block])
            present |= 1u << block;
    if (shape->base_freedoms == 0)
        present &= ~BASE_BLOCKS;
    /* without a valid count there are no wrenches to copy; the daemon refuses by the count */
    if (r->wrench_count == 0 || r->wrench_count > TFA_MAX_WRENCHES)
        present &= ~(1u << TFA_WIRE_WRENCHES);
    return present;
}

/* ---- replies ---- */

/* Bytes of block `block` of a reply. */
static size_t reply_width(const tfa_wire_shape *shape, uint32_t block, const tfa_wire_ask *ask)
{
    const size_t count = ask->count, n = freedoms(shape), m = 6 * (size_t)ask->tip_count;
    switch (block) {
    case TFA_WIRE_ANSWERS:
        return count * sizeof(tfa_answer);
    case TFA_WIRE_OUT_QDD:
    case TFA_WIRE_OUT_TAU:
        return count * shape->v_count * sizeof(double);
    case TFA_WIRE_LAMBDA_INV:
        return count * m * m * sizeof(double);
    case TFA_WIRE_MASS_MATRIX:
        return count * n * n * sizeof(double);
    case TFA_WIRE_SPECTRUM:
        return count * sizeof(tfa_spectrum);
    default: /* base acceleration, base wrench */
        return count * 6 * sizeof(double);
    }
}

/* Room for the answers that grow with a square. */
static size_t square_capacity(const tfa_wire_shape *shape)
{
    const tfa_wire_ask one = {.count = 1, .tip_count = TFA_MAX_TIPS};
    const size_t lambda = reply_width(shape, TFA_WIRE_LAMBDA_INV, &one);
    size_t state = lambda;
    if (freedoms(shape) <= TFA_WIRE_MASS_MATRIX_MAX) {
        const size_t mass = reply_width(shape, TFA_WIRE_MASS_MATRIX, &one);
        state = mass > lambda ? mass : lambda;
    }
    const size_t all = state * shape->max_batch;
    const size_t cap = all < TFA_WIRE_SQUARE_BYTES ? all : TFA_WIRE_SQUARE_BYTES;
    return cap > state ? cap : state;
}

size_t tfa_wire_reply_capacity(const tfa_wire_shape *shape)
{
    const tfa_wire_ask all = {.count = shape->max_batch};
    return TFA_WIRE_LINE + square_capacity(shape) + reply_width(shape, TFA_WIRE_ANSWERS, &all) +
           reply_width(shape, TFA_WIRE_SPECTRUM, &all) +
           reply_width(shape, TFA_WIRE_OUT_QDD, &all) +
           reply_width(shape, TFA_WIRE_OUT_BASE_ACCELERATION, &all);
}

/* Can these answers be given through a slot? The culprit is the count or the op. */
static int check_ask(const tfa_wire_shape *shape, const tfa_wire_ask *ask, tfa_field *culprit)
{
    const uint32_t squares = 1u << TFA_WIRE_LAMBDA_INV | 1u << TFA_WIRE_MASS_MATRIX;
    size_t bytes = 0;
    *culprit = TFA_FIELD_COUNT;
    if (ask->count > shape->max_batch)
        return TFA_E_SIZE;
    if (!(ask->want & squares))
        return TFA_OK;
    *culprit = TFA_FIELD_OP;
    if (ask->want >> TFA_WIRE_MASS_MATRIX & 1 && freedoms(shape) > TFA_WIRE_MASS_MATRIX_MAX)
        return TFA_E_UNSUPPORTED;
    *culprit = TFA_FIELD_COUNT;
    for (uint32_t block = TFA_WIRE_LAMBDA_INV; block <= TFA_WIRE_MASS_MATRIX; block++)
        if (ask->want >> block & 1)
            bytes += reply_width(shape, block, ask);
    return bytes <= square_capacity(shape) ? TFA_OK : TFA_E_SIZE;
}

static void arrays_of_reply(const tfa_reply *r, reply_arrays arrays)
{
    arrays[TFA_WIRE_ANSWERS] = r->answers;
    arrays[TFA_WIRE_OUT_QDD] = r->qdd;
    arrays[TFA_WIRE_OUT_BASE_ACCELERATION] = r->base_acceleration;
    arrays[TFA_WIRE_OUT_TAU] = r->tau;
    arrays[TFA_WIRE_OUT_BASE_WRENCH] = r->base_wrench;
    arrays[TFA_WIRE_LAMBDA_INV] = r->lambda_inv;
    arrays[TFA_WIRE_MASS_MATRIX] = r->mass_matrix;
    arrays[TFA_WIRE_SPECTRUM] = r->spectrum;
}

/* Blocks that an op answers at all. */
static uint32_t blocks_of_op(uint32_t op, uint32_t tip_count, uint32_t flags)
{
    uint32_t lambda = 0;
    if (tip_count)
        lambda = 1u << TFA_WIRE_LAMBDA_INV;
    if (tip_count && flags & TFA_WANT_SPECTRUM)
        lambda |= 1u << TFA_WIRE_SPECTRUM;
    switch (op) {
    case TFA_OP_FORWARD_DYNAMICS:
        return lambda | 1u << TFA_WIRE_ANSWERS | 1u << TFA_WIRE_OUT_QDD |
               1u << TFA_WIRE_OUT_BASE_ACCELERATION;
    case TFA_OP_INVERSE_DYNAMICS:
        return 1u << TFA_WIRE_ANSWERS | 1u << TFA_WIRE_OUT_TAU | 1u << TFA_WIRE_OUT_BASE_WRENCH;
    case TFA_OP_OPERATIONAL_INERTIA:
        return lambda | 1u << TFA_WIRE_ANSWERS;
    case TFA_OP_MASS_MATRIX:
        return 1u << TFA_WIRE_ANSWERS | 1u << TFA_WIRE_MASS_MATRIX;
    default:
        return 0;
    }
}

uint32_t tfa_wire_want(const tfa_request *request, const tfa_reply *reply)
{
    uint32_t want = blocks_of_op((uint32_t)request->op, request->tip_count, request->flags);
    if (!reply)
        return want;
    reply_arrays arrays;
    arrays_of_reply(reply, arrays);
    for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++)
        if (!arrays[block])
            want &= ~(1u << block);
    return want;
}

/* ---- encode and decode ---- */

static void encode_line(const tfa_wire_shape *shape, const tfa_request *r, tfa_wire_request *line)
{
    line->count = r->count;
    line->dof = dof_check(shape);
    line->refine = r->refine;
    line->flags = r->flags;
    line->op = (uint16_t)at_most((uint32_t)r->op, UINT16_MAX);
    line->method = (uint16_t)at_most((uint32_t)r->method, UINT16_MAX);
    line->estimate = (uint16_t)at_most((uint32_t)r->estimate, UINT16_MAX);
    line->frame = (uint16_t)at_most((uint32_t)r->frame, UINT16_MAX);
    line->tip_count = (uint16_t)at_most(r->tip_count, UINT16_MAX);
    line->wrench_count = (uint16_t)at_most(r->wrench_count, UINT16_MAX);
    line->reserved = 0;
}

int tfa_wire_encode_request(const tfa_wire_shape *shape, const tfa_request *request, uint32_t want,
                            uint64_t id, uint64_t t_sent, void *slot, tfa_wire_ask *ask)
{
    const uint32_t tips = at_most(request->tip_count, TFA_MAX_TIPS);
    const uint32_t wrenches = at_most(request->wrench_count, TFA_MAX_WRENCHES);
    tfa_field culprit;
    if (shape->base_freedoms == 0)
        want &= ~BASE_ANSWERS;
    *ask = (tfa_wire_ask){.count = request->count, .tip_count = tips, .want = want};
    int status = check_ask(shape, ask, &culprit);
    if (status != TFA_OK)
        return status;

    tfa_wire_request *line = slot;
    request_arrays arrays;
    arrays_of_request(request, arrays);
    encode_line(shape, request, line);
    line->id = id;
    line->t_sent = t_sent;
    line->present = (uint16_t)blocks_of_request(shape, request, arrays);
    line->want = (uint16_t)want;

    unsigned char *at = (unsigned char *)slot + TFA_WIRE_LINE;
    memcpy(at, request->tips, tips * sizeof(uint32_t));
    memcpy(at + tips * sizeof(uint32_t), request->wrench_frames, wrenches * sizeof(uint32_t));
    at += frames_bytes(tips, wrenches);
    for (uint32_t bits = line->present; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        const size_t size = request_width(shape, block, request->count, wrenches) * sizeof(double);
        memcpy(at, arrays[block], size);
        at += size;
    }
    return TFA_OK;
}

void tfa_wire_copy_request(const tfa_wire_shape *shape, const void *slot, void *copy)
{
    memcpy(copy, slot, TFA_WIRE_LINE);
    const size_t size = request_bytes(shape, copy);
    memcpy((unsigned char *)copy + TFA_WIRE_LINE, (const unsigned char *)slot + TFA_WIRE_LINE,
           size - TFA_WIRE_LINE);
}

static void decode_line(const tfa_wire_request *line, tfa_request *r)
{
    memset(r, 0, sizeof *r);
    r->op = (tfa_op)line->op;
    r->method = (tfa_method)line->method;
    r->estimate = (tfa_estimate)line->estimate;
    r->frame = (tfa_reference_frame)line->frame;
    r->refine = line->refine;
    r->flags = line->flags;
    r->count = line->count;
    r->tip_count = line->tip_count;
    r->wrench_count = line->wrench_count;
}

int tfa_wire_decode_request(const tfa_wire_shape *shape, const void *copy, tfa_request *request,
                            tfa_wire_ask *ask, tfa_field *culprit)
{
    const tfa_wire_request *line = copy;
    const uint32_t tips = at_most(line->tip_count, TFA_MAX_TIPS);
    const uint32_t wrenches = at_most(line->wrench_count, TFA_MAX_WRENCHES);
    decode_line(line, request);
    *culprit = TFA_FIELD_NONE;
    *ask = (tfa_wire_ask){.count = line->count, .tip_count = tips};
    if (line->dof != dof_check(shape))
        return TFA_E_PROTOCOL;
    ask->want = line->want & blocks_of_op(line->op, tips, line->flags);
    if (shape->base_freedoms == 0)
        ask->want &= ~BASE_ANSWERS;
    int status = check_ask(shape, ask, culprit);
    if (status != TFA_OK)
        return status;

    const unsigned char *at = (const unsigned char *)copy + TFA_WIRE_LINE;
    memcpy(request->tips, at, tips * sizeof(uint32_t));
    memcpy(request->wrench_frames, at + tips * sizeof(uint32_t), wrenches * sizeof(uint32_t));
    at += frames_bytes(tips, wrenches);
    request_arrays arrays = {0};
    const uint32_t present = line->present & ((1u << TFA_WIRE_REQUEST_BLOCKS) - 1);
    for (uint32_t bits = present; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        arrays[block] = (const double *)(const void *)at;
        at += request_width(shape, block, line->count, wrenches) * sizeof(double);
    }
    request_of_arrays(arrays, request);
    *culprit = TFA_FIELD_NONE;
    return TFA_OK;
}

/* Where block by block of a reply stands in a slot; NULL for what is not wanted. */
static void locate_reply(const tfa_wire_shape *shape, const tfa_wire_ask *ask, void *slot,
                         reply_arrays arrays)
{
    unsigned char *at = (unsigned char *)slot + TFA_WIRE_LINE;
    for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++) {
        arrays[block] = NULL;
        if (!(ask->want >> block & 1))
            continue;
        arrays[block] = at;
        at += reply_width(shape, block, ask);
    }
}

void tfa_wire_reply_buffers(const tfa_wire_shape *shape, const tfa_wire_ask *ask, void *slot,
                            tfa_reply *reply)
{
    reply_arrays arrays;
    locate_reply(shape, ask, slot, arrays);
    reply->answers = arrays[TFA_WIRE_ANSWERS];
    reply->qdd = arrays[TFA_WIRE_OUT_QDD];
    reply->base_acceleration = arrays[TFA_WIRE_OUT_BASE_ACCELERATION];
    reply->tau = arrays[TFA_WIRE_OUT_TAU];
    reply->base_wrench = arrays[TFA_WIRE_OUT_BASE_WRENCH];
    reply->lambda_inv = arrays[TFA_WIRE_LAMBDA_INV];
    reply->mass_matrix = arrays[TFA_WIRE_MASS_MATRIX];
    reply->spectrum = arrays[TFA_WIRE_SPECTRUM];
}

void tfa_wire_encode_reply(const tfa_reply *reply, uint32_t want, void *slot)
{
    tfa_wire_reply *line = slot;
    line->status = reply->status;
    line->field = (uint32_t)reply->field;
    line->index = reply->index;
    line->state = reply->state;
    line->want = tfa_wire_has_answers(reply->status) ? want : 0;
    line->reserved = 0;
}

uint32_t tfa_wire_decode_reply(const void *slot, tfa_reply *reply)
{
    const tfa_wire_reply *line = slot;
    reply->status = line->status;
    reply->field = (tfa_field)line->field;
    reply->index = line->index;
    reply->state = line->state;
    return line->want;
}

void tfa_wire_copy_answers(const tfa_wire_shape *shape, const tfa_wire_ask *ask, const void *slot,
                           tfa_reply *reply)
{
    const unsigned char *at = (const unsigned char *)slot + TFA_WIRE_LINE;
    reply_arrays arrays;
    arrays_of_reply(reply, arrays);
    for (uint32_t bits = ask->want; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctz(bits);
        const size_t size = reply_width(shape, block, ask);
        if (arrays[block])
            memcpy(arrays[block], at, size);
        at += size;
    }
}
