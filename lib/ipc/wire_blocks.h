/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Arrays of requests and replies on their way between processes: sizes, and the arrays that a
 * request is answered with. Shared by the ring and DDS; no code of its own to link.
 */
#ifndef TFA_IPC_WIRE_BLOCKS_H
#define TFA_IPC_WIRE_BLOCKS_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/request.h>
#include <totalforce/status.h>

#include "interface/fields.h"

/** Limit of the blocks in a slot that TFA_WIRE_EVERY_STATE leaves out, unless one state needs more:
 *  slots of large batches stay small. */
#define TFA_WIRE_SHARED_BYTES ((size_t)1 << 20)
/** Most freedoms of a mass matrix and of derivatives in a slot (512 KiB each at 256). */
#define TFA_WIRE_MASS_MATRIX_MAX 256

/** Sizes of the robot and of the largest request: they determine the layout. */
typedef struct tfa_wire_shape {
    uint32_t q_count, v_count, base_freedoms, frames, modes;
    uint32_t max_batch, max_tips; /**< of one request */
} tfa_wire_shape;

/** Determines the layout of a reply; each side keeps it in private memory. */
typedef struct tfa_wire_reply_shape {
    uint32_t count, tip_count;
    uint32_t rows; /**< of all tips together */
    uint32_t constraints; /**< six for each active one */
    uint64_t want;
} tfa_wire_reply_shape;

/* Numbers of as many constraints as there may be */
static inline size_t tfa_wire_constraints(const tfa_wire_shape *shape)
{
    return 6 * (size_t)shape->max_tips;
}

/* Rows of M. */
static inline uint32_t tfa_wire_freedoms(const tfa_wire_shape *shape)
{
    return shape->base_freedoms + shape->v_count;
}

/* Bytes of a block of a request, without padding. */
static inline __attribute__((always_inline)) size_t tfa_wire_request_width(uint32_t block,
                                                                           const tfa_extents *n)
{
    switch (block) {
#define WIDTH(name, member, states, rows, columns)                                                 \
    case TFA_WIRE_##name:                                                                          \
        return sizeof *((tfa_request *)0)->member * tfa_extent(EXTENT_##states, n) *               \
               tfa_extent(EXTENT_##rows, n) * tfa_extent(EXTENT_##columns, n);
        TFA_INPUT_LIST(WIDTH)
#undef WIDTH
    default:
        return 0;
    }
}

/* Bytes of a block of a reply, without padding. */
static inline size_t tfa_wire_reply_width(const tfa_wire_shape *shape, uint32_t block,
                                          const tfa_wire_reply_shape *reply_shape)
{
    const tfa_extents n = {.v = shape->v_count,
                           .base = shape->base_freedoms,
                           .links = shape->frames,
                           .count = reply_shape->count,
                           .tips = reply_shape->tip_count,
                           .rows = reply_shape->rows,
                           .constraints = reply_shape->constraints,
                           .modes = shape->modes};
    switch (block) {
#define WIDTH(name, member, rows, columns, ...)                                                    \
    case TFA_WIRE_##name:                                                                          \
        return sizeof *((tfa_reply *)0)->member * n.count * tfa_extent(EXTENT_##rows, &n) *        \
               tfa_extent(EXTENT_##columns, &n);
        TFA_OUTPUT_LIST(WIDTH)
#undef WIDTH
    default:
        return 0;
    }
}

#define TFA_WIRE_BIT(name) (UINT64_C(1) << TFA_WIRE_##name)

/* Blocks that a slot has room for whatever the number of states. The other ops have torques in
 * place of accelerations, which take as much. */
#define TFA_WIRE_EVERY_STATE                                                                       \
    (TFA_WIRE_BIT(ANSWERS) | TFA_WIRE_BIT(OUT_QDD) | TFA_WIRE_BIT(OUT_BASE_ACCELERATION) |         \
     TFA_WIRE_BIT(OUT_TAU) | TFA_WIRE_BIT(OUT_BASE_WRENCH) | TFA_WIRE_BIT(SPECTRUM) |              \
     TFA_WIRE_BIT(POSES) | TFA_WIRE_BIT(OUT_MODES))

/* Blocks that one of these ops answers or one of these flags asks for */
static inline __attribute__((always_inline)) uint64_t tfa_wire_asked(uint32_t ops, uint32_t flags)
{
#define ASKED(name, member, rows, columns, of_ops, of_flags, needs)                                \
    | ((of_ops)&ops || (of_flags)&flags ? TFA_WIRE_BIT(name) : 0)
    return 0 TFA_OUTPUT_LIST(ASKED);
#undef ASKED
}

/* Blocks with one of these needs */
static inline __attribute__((always_inline)) uint64_t tfa_wire_needing(unsigned needs)
{
#define NEEDING(name, member, rows, columns, ops, flags, need)                                     \
    | (NEEDS_##need & needs ? TFA_WIRE_BIT(name) : 0)
    return 0 TFA_OUTPUT_LIST(NEEDING);
#undef NEEDING
}

static inline uint64_t tfa_wire_asked_by_op(tfa_op op)
{
    switch (op) {
#define ASKED(op, word)                                                                            \
    case op:                                                                                       \
        return tfa_wire_asked(TFA_OP_BIT(op), 0);
        TFA_OP_WORDS(ASKED)
#undef ASKED
    default:
        return 0;
    }
}

/* Blocks of the answers to a request. Those of a floating base and of modes are among them for
 * every robot. */
static inline uint64_t tfa_wire_blocks_of(const tfa_request *r)
{
    uint64_t by_op = tfa_wire_asked_by_op(r->op), by_flag = 0;
    if (!r->tip_count) /* task torques have a rank nevertheless */
        by_op &= ~tfa_wire_needing(NEEDS_TIPS);
    if (r->flags && by_op) {
        by_flag = tfa_wire_asked(0, r->flags);
        by_flag &= ~(r->tip_count ? 0 : tfa_wire_needing(NEEDS_TIPS | NEEDS_LAMBDA_INV));
        if (!(TFA_OP_BIT(r->op) & TFA_OPS_SOLVE))
            by_flag &= ~tfa_wire_needing(NEEDS_LAMBDA_INV);
        if (!(TFA_OP_BIT(r->op) & TFA_OPS_MOTION))
            by_flag &= ~tfa_wire_needing(NEEDS_MOTION);
    }
    return by_op | by_flag;
}

/* Removes the blocks of a floating base and of modes for other robots. */
static inline uint64_t tfa_wire_of_robot(const tfa_wire_shape *shape, uint64_t want)
{
#define ABSENT(name, member, rows, columns, ...)                                                   \
    | ((EXTENT_##columns == EXTENT_BASE && !shape->base_freedoms) ||                               \
               (EXTENT_##columns == EXTENT_MODES && !shape->modes)                                 \
           ? TFA_WIRE_BIT(name)                                                                    \
           : 0)
    return want & ~(0 TFA_OUTPUT_LIST(ABSENT));
#undef ABSENT
}

/* Layout of the reply to a request with every answer that it is asked for */
static inline tfa_wire_reply_shape tfa_wire_reply_shape_of(const tfa_wire_shape *shape,
                                                           const tfa_request *request)
{
    return (tfa_wire_reply_shape){.count = request->count,
                                  .tip_count = request->tip_count,
                                  .rows = rows_of(request) * request->tip_count,
                                  .constraints = (uint32_t)tfa_constraint_numbers(request),
                                  .want = tfa_wire_of_robot(shape, tfa_wire_blocks_of(request))};
}

/** True if a reply of this status carries answers. */
static inline int tfa_wire_has_answers(int status)
{
    return __builtin_expect(status == TFA_OK, 1) || status == TFA_E_NOT_COMPUTED ||
           status == TFA_E_SINGULAR || status == TFA_E_RANK;
}

#endif
