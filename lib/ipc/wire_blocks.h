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

/** Limit of the blocks in a slot that TFA_WIRE_EVERY_STATE leaves out, unless one state needs more:
 *  slots of large batches stay small. */
#define TFA_WIRE_SHARED_BYTES ((size_t)1 << 20)
/** Most freedoms of a mass matrix and of derivatives in a slot (512 KiB each at 256). */
#define TFA_WIRE_MASS_MATRIX_MAX 256

/** Sizes of the robot and of the largest request: they determine the layout. */
typedef struct tfa_wire_shape {
    uint32_t q_count, v_count, base_freedoms, frames;
    uint32_t max_batch, max_tips; /**< of one request */
} tfa_wire_shape;

/** Blocks of a request, in payload order: X(NAME, array of tfa_request, bytes), with the shape of
 *  the connection and the counts `n` of the request. Block k: bit k of tfa_wire_request.present */
#define TFA_WIRE_REQUEST_LIST(X)                                                                   \
    X(Q, q, 8 * n->count * shape->q_count)                                                         \
    X(V, v, 8 * n->count * shape->v_count)                                                         \
    X(TAU, tau, 8 * n->count * shape->v_count)                                                     \
    X(QDD, qdd, 8 * n->count * shape->v_count)                                                     \
    X(BASE_POSE, base_pose, 8 * n->count * 7)                                                      \
    X(BASE_TWIST, base_twist, 8 * n->count * 6)                                                    \
    X(BASE_WRENCH, base_wrench, 8 * n->count * 6)                                                  \
    X(BASE_ACCELERATION, base_acceleration, 8 * n->count * 6)                                      \
    X(GRAVITY, gravity, 8 * 3)                                                                     \
    X(WRENCHES, wrenches, 8 * n->count * 6 * n->wrenches)                                          \
    X(TASK_ACCELERATION, task_acceleration, 8 * n->count * n->rows)                                \
    X(RANK_THRESHOLD, rank_threshold, 8)                                                           \
    X(CHARACTERISTIC_LENGTH, characteristic_length, 8)                                             \
    X(PAYLOADS, payloads, 8 * n->payloads * TFA_PAYLOAD_NUMBERS)                                   \
    X(LOCKED, locked, 4 * n->locked)

/** Blocks of a reply, in payload order: X(NAME, array of tfa_reply, bytes), with the shape, the
 *  counts of states and tips, `rows` of all tips, and n, the rows of M. Bit k of
 *  tfa_wire_request.want is block k. */
#define TFA_WIRE_REPLY_LIST(X)                                                                     \
    X(ANSWERS, answers, count * sizeof(tfa_answer))                                                \
    X(OUT_QDD, qdd, 8 * count * shape->v_count)                                                    \
    X(OUT_BASE_ACCELERATION, base_acceleration, 8 * count * 6)                                     \
    X(OUT_TAU, tau, 8 * count * shape->v_count)                                                    \
    X(OUT_BASE_WRENCH, base_wrench, 8 * count * 6)                                                 \
    X(LAMBDA_INV, lambda_inv, 8 * count * rows * rows)                                             \
    X(MASS_MATRIX, mass_matrix, 8 * count * n * n)                                                 \
    X(SPECTRUM, spectrum, count * sizeof(tfa_spectrum))                                            \
    X(POSES, poses, 8 * count * tips * 7)                                                          \
    X(FRAME_POSES, frame_poses, 8 * count * shape->frames * 7)                                     \
    X(TWISTS, twists, 8 * count * tips * 6)                                                        \
    X(JACOBIAN, jacobian, 8 * count * rows * n)                                                    \
    X(BIAS_ACCELERATION, bias_acceleration, 8 * count * rows)                                      \
    X(COM, com, 8 * count * 3)                                                                     \
    X(COM_VELOCITY, com_velocity, 8 * count * 3)                                                   \
    X(COM_JACOBIAN, com_jacobian, 8 * count * 3 * n)                                               \
    X(MASS, mass, 8 * count)                                                                       \
    X(MOMENTUM, momentum, 8 * count * 6)                                                           \
    X(ENERGY, energy, 8 * count * 2)                                                               \
    X(LAMBDA, lambda, 8 * count * rows * rows)                                                     \
    X(RANK, rank, count * sizeof(tfa_rank))                                                        \
    X(LOST, lost, 8 * count * TFA_LOST_MAX * (2 + rows))                                           \
    X(MU, mu, 8 * count * rows)                                                                    \
    X(P, p, 8 * count * rows)                                                                      \
    X(GRAVITY_FORCE, gravity_force, 8 * count * n)                                                 \
    X(VELOCITY_FORCE, velocity_force, 8 * count * n)                                               \
    X(DAMPING_FORCE, damping_force, 8 * count * n)                                                 \
    X(EXTERNAL_FORCE, external_force, 8 * count * n)                                               \
    X(ARMATURE_FORCE, armature_force, 8 * count * n)                                               \
    X(DQDD_DQ, dqdd_dq, 8 * count * n * n)                                                         \
    X(DQDD_DV, dqdd_dv, 8 * count * n * n)                                                         \
    X(DQDD_DTAU, dqdd_dtau, 8 * count * n * n)

#define TFA_WIRE_BLOCK(name, field, bytes) TFA_WIRE_##name,
enum { TFA_WIRE_REQUEST_LIST(TFA_WIRE_BLOCK) TFA_WIRE_REQUEST_BLOCKS };
enum { TFA_WIRE_REPLY_LIST(TFA_WIRE_BLOCK) TFA_WIRE_REPLY_BLOCKS };
#undef TFA_WIRE_BLOCK

/** Determines the layout of a reply; each side keeps it in private memory. */
typedef struct tfa_wire_reply_shape {
    uint32_t count, tip_count;
    uint32_t rows; /**< of all tips together */
    uint32_t want;
} tfa_wire_reply_shape;

/* Rows of M. */
static inline uint32_t tfa_wire_freedoms(const tfa_wire_shape *shape)
{
    return shape->base_freedoms + shape->v_count;
}

/* Rows of a tip; as many as there can be if the kind does not exist */
static inline uint32_t tfa_wire_rows(uint32_t rows)
{
    return rows == TFA_ROWS_POINT ? 3 : 6;
}

/* Bytes of a block of a reply, without padding. */
static inline size_t tfa_wire_reply_width(const tfa_wire_shape *shape, uint32_t block,
                                          const tfa_wire_reply_shape *reply_shape)
{
    const size_t count = reply_shape->count, tips = reply_shape->tip_count,
                 rows = reply_shape->rows;
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

#define TFA_WIRE_BIT(name) (1u << TFA_WIRE_##name)
#define TFA_WIRE_DERIVATIVES                                                                       \
    (TFA_WIRE_BIT(DQDD_DQ) | TFA_WIRE_BIT(DQDD_DV) | TFA_WIRE_BIT(DQDD_DTAU))

/* Blocks that a slot has room for whatever the number of states. The other ops have torques in
 * place of accelerations, which take as much. */
#define TFA_WIRE_EVERY_STATE                                                                       \
    (TFA_WIRE_BIT(ANSWERS) | TFA_WIRE_BIT(OUT_QDD) | TFA_WIRE_BIT(OUT_BASE_ACCELERATION) |         \
     TFA_WIRE_BIT(OUT_TAU) | TFA_WIRE_BIT(OUT_BASE_WRENCH) | TFA_WIRE_BIT(SPECTRUM) |              \
     TFA_WIRE_BIT(POSES))

#define TFA_WIRE_RANK_BLOCKS (TFA_WIRE_BIT(RANK) | TFA_WIRE_BIT(LOST))

/* Blocks of the answers that flags ask for */
static inline uint32_t tfa_wire_blocks_of_flags(uint32_t flags)
{
#define ROW(flag) [__builtin_ctz(TFA_WANT_##flag)]
    static const uint32_t blocks_of[] = {
        ROW(SPECTRUM) = TFA_WIRE_BIT(SPECTRUM),
        ROW(POSES) = TFA_WIRE_BIT(POSES),
        ROW(FRAME_POSES) = TFA_WIRE_BIT(FRAME_POSES),
        ROW(TWISTS) = TFA_WIRE_BIT(TWISTS),
        ROW(JACOBIAN) = TFA_WIRE_BIT(JACOBIAN),
        ROW(BIAS_ACCELERATION) = TFA_WIRE_BIT(BIAS_ACCELERATION),
        ROW(COM) = TFA_WIRE_BIT(COM) | TFA_WIRE_BIT(COM_VELOCITY) | TFA_WIRE_BIT(COM_JACOBIAN) |
                   TFA_WIRE_BIT(MASS),
        ROW(MOMENTUM) = TFA_WIRE_BIT(MOMENTUM),
        ROW(ENERGY) = TFA_WIRE_BIT(ENERGY),
        ROW(LAMBDA) = TFA_WIRE_BIT(LAMBDA) | TFA_WIRE_RANK_BLOCKS,
        ROW(MU) = TFA_WIRE_BIT(MU) | TFA_WIRE_RANK_BLOCKS,
        ROW(P) = TFA_WIRE_BIT(P) | TFA_WIRE_RANK_BLOCKS,
    };
#undef ROW
    uint32_t blocks = 0;
    for (uint32_t bits = flags & TFA_WANT_ALL; bits; bits &= bits - 1)
        blocks |= blocks_of[__builtin_ctz(bits)];
    return blocks;
}

#define TFA_WIRE_TIP_BLOCKS                                                                        \
    (TFA_WIRE_BIT(POSES) | TFA_WIRE_BIT(TWISTS) | TFA_WIRE_BIT(JACOBIAN) |                         \
     TFA_WIRE_BIT(BIAS_ACCELERATION) | TFA_WIRE_BIT(SPECTRUM) | TFA_WIRE_BIT(LAMBDA) |             \
     TFA_WIRE_RANK_BLOCKS | TFA_WIRE_BIT(MU) | TFA_WIRE_BIT(P))
/* Blocks of ops with lambda_inv */
#define TFA_WIRE_LAMBDA_BLOCKS                                                                     \
    (TFA_WIRE_BIT(SPECTRUM) | TFA_WIRE_BIT(LAMBDA) | TFA_WIRE_RANK_BLOCKS | TFA_WIRE_BIT(MU) |     \
     TFA_WIRE_BIT(P))

/* Blocks of the answers to a request. Those of a floating base are among them for every robot. */
static inline uint32_t tfa_wire_blocks_of(const tfa_request *r)
{
    uint32_t always = TFA_WIRE_BIT(ANSWERS);
    if (r->flags)
        always |= tfa_wire_blocks_of_flags(r->flags) & ~(r->tip_count ? 0 : TFA_WIRE_TIP_BLOCKS);
    const uint32_t lambda = r->tip_count ? TFA_WIRE_BIT(LAMBDA_INV) : 0,
                   motion = always & ~TFA_WIRE_LAMBDA_BLOCKS;
    switch (r->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        return always | lambda | TFA_WIRE_BIT(OUT_QDD) | TFA_WIRE_BIT(OUT_BASE_ACCELERATION);
    case TFA_OP_INVERSE_DYNAMICS:
        return motion | TFA_WIRE_BIT(OUT_TAU) | TFA_WIRE_BIT(OUT_BASE_WRENCH);
    case TFA_OP_OPERATIONAL_INERTIA:
        return always | lambda;
    case TFA_OP_MASS_MATRIX:
        return motion | TFA_WIRE_BIT(MASS_MATRIX);
    case TFA_OP_KINEMATICS:
        return motion;
    case TFA_OP_BIAS:
        return motion | TFA_WIRE_BIT(GRAVITY_FORCE) | TFA_WIRE_BIT(VELOCITY_FORCE) |
               TFA_WIRE_BIT(DAMPING_FORCE) | TFA_WIRE_BIT(EXTERNAL_FORCE) |
               TFA_WIRE_BIT(ARMATURE_FORCE);
    case TFA_OP_TASK_TORQUES:
        return always | lambda | TFA_WIRE_RANK_BLOCKS | TFA_WIRE_BIT(OUT_TAU) |
               TFA_WIRE_BIT(OUT_BASE_WRENCH);
    case TFA_OP_DERIVATIVES:
        return motion | TFA_WIRE_DERIVATIVES;
    default:
        return 0;
    }
}

/* Removes the blocks of a floating base for other robots. */
static inline uint32_t tfa_wire_of_robot(const tfa_wire_shape *shape, uint32_t want)
{
    const uint32_t base = TFA_WIRE_BIT(OUT_BASE_ACCELERATION) | TFA_WIRE_BIT(OUT_BASE_WRENCH);
    return shape->base_freedoms == 0 ? want & ~base : want;
}

/* Layout of the reply to a request with every answer that it is asked for */
static inline tfa_wire_reply_shape tfa_wire_reply_shape_of(const tfa_wire_shape *shape,
                                                           const tfa_request *request)
{
    return (tfa_wire_reply_shape){.count = request->count,
                                  .tip_count = request->tip_count,
                                  .rows = tfa_wire_rows(request->rows) * request->tip_count,
                                  .want = tfa_wire_of_robot(shape, tfa_wire_blocks_of(request))};
}

/** True if a reply of this status carries answers. */
static inline int tfa_wire_has_answers(int status)
{
    return status == TFA_OK || status == TFA_E_NOT_COMPUTED || status == TFA_E_SINGULAR ||
           status == TFA_E_RANK;
}

#endif
