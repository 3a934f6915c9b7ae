/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Encoding and decoding of requests.
 */
#include "ipc/wire_reply.h"

#include <string.h>

/* Compilers keep these apart, for their number of callers. Inline, counts stay in registers. */
#define INLINE static inline __attribute__((always_inline))

#define OF_BASE(name, member, states, rows, columns)                                               \
    | (uint64_t)(EXTENT_##columns == EXTENT_BASE || EXTENT_##columns == EXTENT_BASE_POSE)          \
            << TFA_WIRE_##name
static const uint64_t base_blocks = 0 TFA_INPUT_LIST(OF_BASE);
#undef OF_BASE

#define MODE_BLOCKS (TFA_WIRE_BIT(MODES) | TFA_WIRE_BIT(MODE_VELOCITIES))

#define COUNTED_BLOCKS (TFA_WIRE_BIT(WRENCHES) | TFA_WIRE_BIT(PAYLOADS) | TFA_WIRE_BIT(LOCKED))

#define ALL_BLOCKS ((UINT64_C(1) << TFA_WIRE_REQUEST_BLOCKS) - 1)

/* Where a tfa_request has the pointer to a block */
static const uint16_t array_offset[TFA_WIRE_REQUEST_BLOCKS] = {
#define OFFSET(block, member, ...) offsetof(tfa_request, member),
    TFA_INPUT_LIST(OFFSET)
#undef OFFSET
};

static const void *array_of(const tfa_request *r, uint32_t block)
{
    const void *array;
    memcpy(&array, (const unsigned char *)r + array_offset[block], sizeof array);
    return array;
}

static void set_array(tfa_request *r, uint32_t block, const void *array)
{
    memcpy((unsigned char *)r + array_offset[block], &array, sizeof array);
}

static uint32_t dof_check(const tfa_wire_shape *shape)
{
    return shape->q_count + tfa_wire_freedoms(shape) + shape->modes;
}

/* Each within its limit, but `count`, which is checked with the reply's shape. */
INLINE tfa_extents limited(const tfa_wire_shape *shape, tfa_extents n, uint32_t rows)
{
    n.tips = n.tips < shape->max_tips ? n.tips : shape->max_tips;
    n.rows = n.tips * tfa_tip_rows(rows);
    n.wrenches = n.wrenches < TFA_MAX_WRENCHES ? n.wrenches : TFA_MAX_WRENCHES;
    n.payloads = n.payloads < TFA_MAX_PAYLOADS ? n.payloads : TFA_MAX_PAYLOADS;
    n.locked = n.locked < shape->v_count ? n.locked : shape->v_count;
    n.q = shape->q_count;
    n.v = shape->v_count;
    n.modes = shape->modes;
    const size_t constraints = tfa_wire_constraints(shape);
    n.constraints = n.constraints < constraints ? n.constraints : constraints;
    return n;
}

static tfa_extents counts_of_request(const tfa_wire_shape *shape, const tfa_request *r)
{
    const tfa_extents n = {.count = r->count,
                           .tips = r->tip_count,
                           .wrenches = r->wrench_count,
                           .payloads = r->payload_count,
                           .locked = r->locked_count,
                           .constraints = tfa_constraint_numbers(r)};
    return limited(shape, n, r->rows);
}

static tfa_extents counts_of_line(const tfa_wire_shape *shape, const tfa_wire_request *line)
{
    const tfa_extents n = {.count = line->count < shape->max_batch ? line->count : shape->max_batch,
                           .tips = line->tip_count,
                           .wrenches = line->wrench_count,
                           .payloads = line->payload_count,
                           .locked = line->locked_count,
                           .constraints = tfa_constraints_of(line->op, line->constraints)};
    return limited(shape, n, line->rows);
}

/* Bytes of the frame indices that stand before the blocks. */
static size_t frames_bytes(const tfa_extents *n)
{
    return tfa_wire_padded_size((n->tips + n->wrenches + n->payloads) * sizeof(uint32_t));
}

/* Bytes of a slot that holds these blocks. */
static size_t request_size(uint64_t present, const tfa_extents *n)
{
    size_t size = TFA_WIRE_LINE + frames_bytes(n);
    for (uint64_t bits = present; bits; bits &= bits - 1)
        size += tfa_wire_padded_size(tfa_wire_request_width((uint32_t)__builtin_ctzll(bits), n));
    return size;
}

size_t tfa_wire_request_capacity(const tfa_wire_shape *shape)
{
    const tfa_extents all = {.count = shape->max_batch,
                             .tips = SIZE_MAX,
                             .wrenches = SIZE_MAX,
                             .payloads = SIZE_MAX,
                             .locked = SIZE_MAX,
                             .constraints = SIZE_MAX};
    const tfa_extents most = limited(shape, all, TFA_ROWS_POSE);
    return request_size(ALL_BLOCKS, &most);
}

/* Blocks without a valid count are not sent; the daemon refuses the request by the count. */
static uint64_t blocks_without_count(const tfa_wire_shape *shape, const tfa_request *r)
{
    uint64_t none = COUNTED_BLOCKS;
    if (!(r->wrench_count | r->payload_count | r->locked_count))
        return none;
    if (r->wrench_count && r->wrench_count <= TFA_MAX_WRENCHES)
        none &= ~(TFA_WIRE_BIT(WRENCHES));
    if (r->payload_count && r->payload_count <= TFA_MAX_PAYLOADS)
        none &= ~(TFA_WIRE_BIT(PAYLOADS));
    if (r->locked_count && r->locked_count <= shape->v_count)
        none &= ~(TFA_WIRE_BIT(LOCKED));
    return none;
}

/* Blocks of a request that go into the slot. */
static uint64_t blocks_of_request(const tfa_wire_shape *shape, const tfa_request *r)
{
    uint64_t present = 0;
#define ADD(block, member, ...) present |= (uint64_t)(r->member != NULL) << TFA_WIRE_##block;
    TFA_INPUT_LIST(ADD)
#undef ADD
    if (shape->base_freedoms == 0)
        present &= ~base_blocks;
    if (shape->modes == 0)
        present &= ~MODE_BLOCKS;
    return present & ~blocks_without_count(shape, r);
}

static uint8_t clamp_u8(uint32_t x)
{
    return (uint8_t)(x < UINT8_MAX ? x : UINT8_MAX);
}

/* Fields of both a line and a request: X(field, type in tfa_request, limit in the line) */
#define LINE_FIELDS(X)                                                                             \
    X(count, uint32_t, (uint32_t))                                                                 \
    X(refine, uint32_t, (uint32_t))                                                                \
    X(flags, uint32_t, (uint32_t))                                                                 \
    X(locked_count, uint32_t, (uint32_t))                                                          \
    X(constraints, uint32_t, (uint32_t))                                                           \
    X(op, tfa_op, clamp_u8)                                                                        \
    X(method, tfa_method, clamp_u8)                                                                \
    X(rows, tfa_rows, clamp_u8)                                                                    \
    X(rank_loss, tfa_rank_loss, clamp_u8)                                                          \
    X(estimate, tfa_estimate, clamp_u8)                                                            \
    X(frame, tfa_reference_frame, clamp_u8)                                                        \
    X(tip_count, uint32_t, clamp_u8)                                                               \
    X(wrench_count, uint32_t, clamp_u8)                                                            \
    X(payload_count, uint32_t, clamp_u8)

static void encode_line(const tfa_wire_shape *shape, const tfa_request *r, tfa_wire_request *line)
{
#define ENCODE(field, type, limit) line->field = limit((uint32_t)r->field);
    LINE_FIELDS(ENCODE)
#undef ENCODE
    line->dof = dof_check(shape);
    line->deadline_us = 0;
    memset(line->padding, 0, sizeof line->padding);
    memset(line->reserved, 0, sizeof line->reserved);
}

/* The frame indices before the blocks */
static void write_frames(unsigned char *at, const tfa_request *r, const tfa_extents *n)
{
    memcpy(at, r->tips, n->tips * sizeof(uint32_t));
    at += n->tips * sizeof(uint32_t);
    memcpy(at, r->wrench_frames, n->wrenches * sizeof(uint32_t));
    at += n->wrenches * sizeof(uint32_t);
    memcpy(at, r->payload_frames, n->payloads * sizeof(uint32_t));
}

static void read_frames(const unsigned char *at, tfa_request *r, const tfa_extents *n)
{
    memcpy(r->tips, at, n->tips * sizeof(uint32_t));
    at += n->tips * sizeof(uint32_t);
    memcpy(r->wrench_frames, at, n->wrenches * sizeof(uint32_t));
    at += n->wrenches * sizeof(uint32_t);
    memcpy(r->payload_frames, at, n->payloads * sizeof(uint32_t));
}

int tfa_wire_encode_request(const tfa_wire_shape *shape, const tfa_request *request, uint64_t want,
                            uint64_t id, uint64_t t_sent, void *slot,
                            tfa_wire_reply_shape *reply_shape, tfa_field *invalid_field)
{
    const tfa_extents n = counts_of_request(shape, request);
    want = tfa_wire_of_robot(shape, want);
    *reply_shape = (tfa_wire_reply_shape){.count = request->count,
                                          .tip_count = request->tip_count,
                                          .rows = (uint32_t)n.rows,
                                          .constraints = (uint32_t)n.constraints,
                                          .want = want};
    tfa_field field;
    int status = tfa_wire_check_reply_shape(shape, reply_shape, &field);
    if (invalid_field)
        *invalid_field = status == TFA_OK ? TFA_FIELD_NONE : field;
    if (status != TFA_OK)
        return status;

    tfa_wire_request *line = slot;
    const uint64_t present = blocks_of_request(shape, request);
    encode_line(shape, request, line);
    line->id = id;
    line->t_sent = t_sent;
    line->present = present;
    line->want = want;

    unsigned char *at = (unsigned char *)slot + TFA_WIRE_LINE;
    const size_t frames = frames_bytes(&n);
    if (frames)
        write_frames(at, request, &n);
    at += frames;
    for (uint64_t bits = present; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        const size_t size = tfa_wire_request_width(block, &n);
        memcpy(at, array_of(request, block), size);
        at += tfa_wire_padded_size(size);
    }
    return TFA_OK;
}

size_t tfa_wire_request_bytes(const tfa_wire_shape *shape, const tfa_request *request)
{
    const tfa_extents n = counts_of_request(shape, request);
    return request_size(blocks_of_request(shape, request), &n);
}

size_t tfa_wire_copied_bytes(const tfa_wire_shape *shape, const void *copy)
{
    const tfa_wire_request *line = copy;
    const tfa_extents n = counts_of_line(shape, line);
    return request_size(line->present & ALL_BLOCKS, &n);
}

static bool has_form(const tfa_wire_form *form, const void *copy)
{
    const unsigned char *at = (const unsigned char *)copy + TFA_WIRE_FORM_AT;
    uint64_t different = form->bytes == 0;
    for (size_t k = 0; k < sizeof form->line; k += 8) {
        uint64_t a, b;
        memcpy(&a, form->line + k, 8);
        memcpy(&b, at + k, 8);
        different |= a ^ b;
    }
    return different == 0;
}

bool tfa_wire_copy_request(const tfa_wire_shape *shape, const tfa_wire_form *form, const void *slot,
                           void *copy)
{
    memcpy(copy, slot, TFA_WIRE_LINE);
    const bool same = has_form(form, copy);
    const size_t size = same ? form->bytes : tfa_wire_copied_bytes(shape, copy);
    memcpy((unsigned char *)copy + TFA_WIRE_LINE, (const unsigned char *)slot + TFA_WIRE_LINE,
           size - TFA_WIRE_LINE);
    return same;
}

void tfa_wire_keep_form(const tfa_wire_shape *shape, const void *copy,
                        const tfa_wire_reply_shape *reply_shape, tfa_wire_form *form)
{
    memcpy(form->line, (const unsigned char *)copy + TFA_WIRE_FORM_AT, sizeof form->line);
    form->bytes = tfa_wire_copied_bytes(shape, copy);
    form->reply_shape = *reply_shape;
}

static void decode_line(const tfa_wire_request *line, tfa_request *r)
{
    /* member by member: gcc 12 clears the whole with `rep stos`, which doubles the time. Frames are
     * read up to their counts only. */
#define CLEAR(block, member, ...) r->member = NULL;
    TFA_INPUT_LIST(CLEAR)
#undef CLEAR
#define DECODE(field, type, limit) r->field = (type)line->field;
    LINE_FIELDS(DECODE)
#undef DECODE
}

/* Points the arrays of a request at the blocks that stand at `at`. */
static void point_into(const tfa_wire_shape *shape, uint64_t present, const tfa_extents *n,
                       const unsigned char *at, tfa_request *r)
{
    const uint64_t none = present & COUNTED_BLOCKS ? blocks_without_count(shape, r) : 0;
    for (uint64_t bits = present; bits; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        const void *array = none >> block & 1 ? NULL : at;
        set_array(r, block, array);
        at += tfa_wire_padded_size(tfa_wire_request_width(block, n));
    }
}

int tfa_wire_decode_request(const tfa_wire_shape *shape, const void *copy, tfa_request *request,
                            tfa_wire_reply_shape *reply_shape, tfa_field *invalid_field)
{
    const tfa_wire_request *line = copy;
    const tfa_extents n = counts_of_line(shape, line);
    decode_line(line, request);
    *invalid_field = TFA_FIELD_NONE;
    *reply_shape = (tfa_wire_reply_shape){.count = line->count,
                                          .tip_count = line->tip_count,
                                          .rows = (uint32_t)n.rows,
                                          .constraints = (uint32_t)n.constraints};
    if (line->dof != dof_check(shape))
        return TFA_E_PROTOCOL;
    reply_shape->want = line->want & tfa_wire_possible(shape, request);
    int status = tfa_wire_check_reply_shape(shape, reply_shape, invalid_field);
    if (status != TFA_OK)
        return status;

    const unsigned char *at = (const unsigned char *)copy + TFA_WIRE_LINE;
    const size_t frames = frames_bytes(&n);
    if (frames)
        read_frames(at, request, &n);
    at += frames;
    point_into(shape, line->present & ALL_BLOCKS, &n, at, request);
    *invalid_field = TFA_FIELD_NONE;
    return TFA_OK;
}

void tfa_wire_decode_again(const tfa_wire_shape *shape, const void *copy, tfa_request *request)
{
    const tfa_wire_request *line = copy;
    request->estimate = (tfa_estimate)line->estimate;
    if (line->tip_count | line->wrench_count | line->payload_count) {
        const tfa_extents n = counts_of_line(shape, line);
        read_frames((const unsigned char *)copy + TFA_WIRE_LINE, request, &n);
    }
}
