/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The interface, written once: lists of ops, of the arrays of a request and of those of a reply.
 * Wire, DDS, JSON lines and Python expand them.
 */
#ifndef TFA_INTERFACE_FIELDS_H
#define TFA_INTERFACE_FIELDS_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/request.h>

/** Lengths of axes. Those below 0 depend on the robot or the request. */
enum tfa_extent {
    EXTENT_NONE = 0, /**< no such axis */
    EXTENT_2 = 2,
    EXTENT_3 = 3,
    EXTENT_6 = 6,
    EXTENT_7 = 7,
    EXTENT_DIRECTIONS = TFA_LOST_MAX,
    EXTENT_PAYLOAD = TFA_PAYLOAD_NUMBERS,
    EXTENT_Q = -1,
    EXTENT_V = -2,
    EXTENT_FREEDOMS = -3, /**< of the base, then of the joints */
    EXTENT_TIPS = -4,
    EXTENT_ROWS = -5, /**< of all tips: 6 or 3 each */
    EXTENT_LINKS = -6,
    EXTENT_BASE = -7,      /**< 6; a fixed base has no such array */
    EXTENT_LOST = -8,      /**< two numbers and the rows of all tips */
    EXTENT_BASE_POSE = -9, /**< 7, as EXTENT_BASE */
    EXTENT_WRENCHES = -10,
    EXTENT_PAYLOADS = -11,
    EXTENT_LOCKED = -12,
    EXTENT_COUNT = -13, /**< states */
};

/** Lengths of one robot and one request */
typedef struct tfa_extents {
    size_t q, v, base, links; /**< base: its freedoms */
    size_t count, tips, rows, wrenches, payloads, locked;
} tfa_extents;

/** Arrays of a request in the order of the wire: X(NAME, member of tfa_request, axes), with three
 *  axes from enum tfa_extent. The field is TFA_FIELD_NAME. */
#define TFA_INPUT_LIST(X)                                                                          \
    X(Q, q, COUNT, NONE, Q)                                                                        \
    X(V, v, COUNT, NONE, V)                                                                        \
    X(TAU, tau, COUNT, NONE, V)                                                                    \
    X(QDD, qdd, COUNT, NONE, V)                                                                    \
    X(BASE_POSE, base_pose, COUNT, NONE, BASE_POSE)                                                \
    X(BASE_TWIST, base_twist, COUNT, NONE, BASE)                                                   \
    X(BASE_WRENCH, base_wrench, COUNT, NONE, BASE)                                                 \
    X(BASE_ACCELERATION, base_acceleration, COUNT, NONE, BASE)                                     \
    X(GRAVITY, gravity, NONE, NONE, 3)                                                             \
    X(WRENCHES, wrenches, COUNT, WRENCHES, 6)                                                      \
    X(TASK_ACCELERATION, task_acceleration, COUNT, NONE, ROWS)                                     \
    X(RANK_THRESHOLD, rank_threshold, NONE, NONE, NONE)                                            \
    X(CHARACTERISTIC_LENGTH, characteristic_length, NONE, NONE, NONE)                              \
    X(PAYLOADS, payloads, NONE, PAYLOADS, PAYLOAD)                                                 \
    X(LOCKED, locked, NONE, NONE, LOCKED)

/** Ops: X(NAME) */
#define TFA_OP_LIST(X)                                                                             \
    X(FORWARD_DYNAMICS)                                                                            \
    X(INVERSE_DYNAMICS)                                                                            \
    X(OPERATIONAL_INERTIA)                                                                         \
    X(MASS_MATRIX)                                                                                 \
    X(KINEMATICS)                                                                                  \
    X(BIAS)                                                                                        \
    X(TASK_TORQUES)                                                                                \
    X(DERIVATIVES)

/** Without what an output is not there, though its op or flag asks for it */
enum tfa_needs {
    NEEDS_NOTHING = 0,
    NEEDS_TIPS = 1,
    NEEDS_LAMBDA_INV = 2, /**< by flag: tips, and an op that answers lambda_inv */
    NEEDS_QDD = 4,        /**< accelerations; 0 without, which only wire and DDS send */
};

#define TFA_OPS_BIAS TFA_OP_BIT(TFA_OP_BIAS)
#define TFA_OPS_TORQUES (TFA_OPS_ID | TFA_OPS_TASK)
#define TFA_WANT_RANK (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P)

/** Arrays of a reply in the order of the wire: X(NAME, member of tfa_reply, rows, columns, ops that
 *  answer it, flags that ask for it, needs). Each has an axis of states first. */
#define TFA_OUTPUT_LIST(X)                                                                         \
    X(ANSWERS, answers, NONE, NONE, TFA_OPS_ALL, 0, NOTHING)                                       \
    X(OUT_QDD, qdd, NONE, V, TFA_OPS_FD, 0, NOTHING)                                               \
    X(OUT_BASE_ACCELERATION, base_acceleration, NONE, BASE, TFA_OPS_FD, 0, NOTHING)                \
    X(OUT_TAU, tau, NONE, V, TFA_OPS_TORQUES, 0, NOTHING)                                          \
    X(OUT_BASE_WRENCH, base_wrench, NONE, BASE, TFA_OPS_TORQUES, 0, NOTHING)                       \
    X(LAMBDA_INV, lambda_inv, ROWS, ROWS, TFA_OPS_SOLVE, 0, TIPS)                                  \
    X(MASS_MATRIX, mass_matrix, FREEDOMS, FREEDOMS, TFA_OPS_M, 0, NOTHING)                         \
    X(SPECTRUM, spectrum, NONE, NONE, 0, TFA_WANT_SPECTRUM, LAMBDA_INV)                            \
    X(POSES, poses, TIPS, 7, 0, TFA_WANT_POSES, TIPS)                                              \
    X(FRAME_POSES, frame_poses, LINKS, 7, 0, TFA_WANT_FRAME_POSES, NOTHING)                        \
    X(TWISTS, twists, TIPS, 6, 0, TFA_WANT_TWISTS, TIPS)                                           \
    X(JACOBIAN, jacobian, ROWS, FREEDOMS, 0, TFA_WANT_JACOBIAN, TIPS)                              \
    X(BIAS_ACCELERATION, bias_acceleration, NONE, ROWS, 0, TFA_WANT_BIAS_ACCELERATION, TIPS)       \
    X(COM, com, NONE, 3, 0, TFA_WANT_COM, NOTHING)                                                 \
    X(COM_VELOCITY, com_velocity, NONE, 3, 0, TFA_WANT_COM, NOTHING)                               \
    X(COM_JACOBIAN, com_jacobian, 3, FREEDOMS, 0, TFA_WANT_COM, NOTHING)                           \
    X(MASS, mass, NONE, NONE, 0, TFA_WANT_COM, NOTHING)                                            \
    X(MOMENTUM, momentum, NONE, 6, 0, TFA_WANT_MOMENTUM, NOTHING)                                  \
    X(ENERGY, energy, NONE, 2, 0, TFA_WANT_ENERGY, NOTHING)                                        \
    X(LAMBDA, lambda, ROWS, ROWS, 0, TFA_WANT_LAMBDA, LAMBDA_INV)                                  \
    X(RANK, rank, NONE, NONE, TFA_OPS_TASK, TFA_WANT_RANK, LAMBDA_INV)                             \
    X(LOST, lost, DIRECTIONS, LOST, TFA_OPS_TASK, TFA_WANT_RANK, LAMBDA_INV)                       \
    X(MU, mu, NONE, ROWS, 0, TFA_WANT_MU, LAMBDA_INV)                                              \
    X(P, p, NONE, ROWS, 0, TFA_WANT_P, LAMBDA_INV)                                                 \
    X(GRAVITY_FORCE, gravity_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                      \
    X(VELOCITY_FORCE, velocity_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                    \
    X(DAMPING_FORCE, damping_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                      \
    X(EXTERNAL_FORCE, external_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                    \
    X(ARMATURE_FORCE, armature_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, QDD)                        \
    X(DQDD_DQ, dqdd_dq, FREEDOMS, FREEDOMS, TFA_OPS_DERIVATIVES, 0, NOTHING)                       \
    X(DQDD_DV, dqdd_dv, FREEDOMS, FREEDOMS, TFA_OPS_DERIVATIVES, 0, NOTHING)                       \
    X(DQDD_DTAU, dqdd_dtau, FREEDOMS, FREEDOMS, TFA_OPS_DERIVATIVES, 0, NOTHING)

/** Length of an axis; 1 of one that is not there. */
static inline size_t tfa_extent(int extent, const tfa_extents *n)
{
    switch (extent) {
    case EXTENT_NONE:
        return 1;
    case EXTENT_Q:
        return n->q;
    case EXTENT_V:
        return n->v;
    case EXTENT_FREEDOMS:
        return n->base + n->v;
    case EXTENT_TIPS:
        return n->tips;
    case EXTENT_ROWS:
        return n->rows;
    case EXTENT_LINKS:
        return n->links;
    case EXTENT_BASE:
        return 6;
    case EXTENT_LOST:
        return 2 + n->rows;
    case EXTENT_BASE_POSE:
        return 7;
    case EXTENT_WRENCHES:
        return n->wrenches;
    case EXTENT_PAYLOADS:
        return n->payloads;
    case EXTENT_LOCKED:
        return n->locked;
    case EXTENT_COUNT:
        return n->count;
    default:
        return (size_t)extent;
    }
}

#endif
