/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The interface, written once: lists of the arrays of a request and of those of a reply.
 * Wire, DDS, JSON lines and Python expand them.
 */
#ifndef TFA_INTERFACE_FIELDS_H
#define TFA_INTERFACE_FIELDS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <totalforce/request.h>

#include "interface/traits.h"

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
    EXTENT_LOST = -8,      /**< two numbers and the rows of all tips, or of all constraints */
    EXTENT_BASE_POSE = -9, /**< 7, as EXTENT_BASE */
    EXTENT_WRENCHES = -10,
    EXTENT_PAYLOADS = -11,
    EXTENT_LOCKED = -12,
    EXTENT_COUNT = -13,       /**< states */
    EXTENT_MODES = -14,       /**< of flexible links */
    EXTENT_CONSTRAINTS = -15, /**< six for each active constraint */
    EXTENT_PARAMETERS = -16,  /**< ten of each tip's link */
};

/** Lengths of one robot and one request */
typedef struct tfa_extents {
    size_t q, v, base, links; /**< base: its freedoms */
    size_t count, tips, rows, wrenches, payloads, locked;
    size_t modes, constraints; /**< six for each active one */
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
    X(LOCKED, locked, NONE, NONE, LOCKED)                                                          \
    X(MODES, modes, COUNT, NONE, MODES)                                                            \
    X(MODE_VELOCITIES, mode_velocities, COUNT, NONE, MODES)                                        \
    X(CONSTRAINT_ACCELERATION, constraint_acceleration, COUNT, NONE, CONSTRAINTS)                  \
    X(STABILISATION, stabilisation, NONE, NONE, 2)                                                 \
    X(TORQUE_WEIGHTS, torque_weights, NONE, NONE, V)

/** Without what an output is not there, though its op or flag asks for it */
enum tfa_needs {
    NEEDS_NOTHING = 0,
    NEEDS_TIPS = 1,
    NEEDS_LAMBDA_INV = 2, /**< by flag: tips, and an op that answers lambda_inv */
    NEEDS_QDD = 4,        /**< accelerations; 0 without, which only wire and DDS send */
    NEEDS_MOTION = 8,     /**< by flag: an op of TFA_OPS_MOTION */
};

/* Sets of ops: one, those that answer torques, that solve for accelerations, that read them, that
 * read wrenches */
#define TFA_OPS_BIAS TFA_OP_BIT(TFA_OP_BIAS)
#define TFA_OPS_TORQUES (TFA_OPS_ID | TFA_OPS_TASK | TFA_OPS_CONSTRAINED_ID)
#define TFA_OPS_FORWARD (TFA_OPS_FD | TFA_OPS_TASK | TFA_OPS_DERIVATIVES | TFA_OPS_CONSTRAINED_FD)
#define TFA_OPS_ACCELERATIONS (TFA_OPS_FD | TFA_OPS_CONSTRAINED_FD)
#define TFA_OPS_RANK (TFA_OPS_TASK | TFA_OPS_CONSTRAINED)
#define TFA_OPS_LOST (TFA_OPS_TASK | TFA_OPS_CONSTRAINED_SOLVE)
#define TFA_OPS_MOTION (TFA_OPS_FD | TFA_OPS_ID) /* accelerations and forces of all joints */
#define TFA_OPS_INVERSE                                                                            \
    (TFA_OPS_ID | TFA_OPS_BIAS | TFA_OPS_ID_DERIVATIVES | TFA_OPS_CONSTRAINED_ID)
#define TFA_OPS_FORCES (TFA_OPS_FORWARD | TFA_OPS_INVERSE)
#define TFA_OPS_QDD (TFA_OPS_INVERSE | TFA_OPS_REGRESSOR)
#define TFA_OPS_TIPS (TFA_OPS_SOLVE | TFA_OPS_REGRESSOR)
/* Sets of answers by flag: with a rank; all with ops that answer lambda_inv only; motion of tips */
#define TFA_WANT_RANK (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P)
#define TFA_WANT_OF_SOLVE (TFA_WANT_RANK | TFA_WANT_SPECTRUM)
#define TFA_WANT_MOTION                                                                            \
    (TFA_WANT_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION)
#define TFA_WANT_OF_TIPS (TFA_WANT_MOTION | TFA_WANT_OF_SOLVE)

/** Arrays of a reply in the order of the wire: X(NAME, member of tfa_reply, rows, columns, ops that
 *  answer it, flags that ask for it, needs). Each has an axis of states first. */
#define TFA_OUTPUT_LIST(X)                                                                         \
    X(ANSWERS, answers, NONE, NONE, TFA_OPS_ALL, 0, NOTHING)                                       \
    X(OUT_QDD, qdd, NONE, V, TFA_OPS_ACCELERATIONS, 0, NOTHING)                                    \
    X(OUT_BASE_ACCELERATION, base_acceleration, NONE, BASE, TFA_OPS_ACCELERATIONS, 0, NOTHING)     \
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
    X(RANK, rank, NONE, NONE, TFA_OPS_RANK, TFA_WANT_RANK, LAMBDA_INV)                             \
    X(LOST, lost, DIRECTIONS, LOST, TFA_OPS_LOST, TFA_WANT_RANK, LAMBDA_INV)                       \
    X(MU, mu, NONE, ROWS, 0, TFA_WANT_MU, LAMBDA_INV)                                              \
    X(P, p, NONE, ROWS, 0, TFA_WANT_P, LAMBDA_INV)                                                 \
    X(GRAVITY_FORCE, gravity_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                      \
    X(VELOCITY_FORCE, velocity_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                    \
    X(DAMPING_FORCE, damping_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                      \
    X(EXTERNAL_FORCE, external_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                    \
    X(ARMATURE_FORCE, armature_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, QDD)                        \
    X(DQDD_DQ, dqdd_dq, FREEDOMS, FREEDOMS, TFA_OPS_DERIVATIVES, 0, NOTHING)                       \
    X(DQDD_DV, dqdd_dv, FREEDOMS, FREEDOMS, TFA_OPS_DERIVATIVES, 0, NOTHING)                       \
    X(DQDD_DTAU, dqdd_dtau, FREEDOMS, FREEDOMS, TFA_OPS_DERIVATIVES, 0, NOTHING)                   \
    X(JOINT_FORCES, joint_forces, LINKS, 6, 0, TFA_WANT_JOINT_FORCES, MOTION)                      \
    X(OUT_MODES, modes, NONE, MODES, TFA_OPS_FD, 0, NOTHING)                                       \
    X(DTAU_DQ, dtau_dq, FREEDOMS, FREEDOMS, TFA_OPS_ID_DERIVATIVES, 0, NOTHING)                    \
    X(DTAU_DV, dtau_dv, FREEDOMS, FREEDOMS, TFA_OPS_ID_DERIVATIVES, 0, NOTHING)                    \
    X(CONSTRAINT_WRENCHES, constraint_wrenches, NONE, CONSTRAINTS, TFA_OPS_CONSTRAINED, 0,         \
      NOTHING)                                                                                     \
    X(CONSTRAINT_POSITION, constraint_position, NONE, CONSTRAINTS, TFA_OPS_CONSTRAINED, 0,         \
      NOTHING)                                                                                     \
    X(CONSTRAINT_VELOCITY, constraint_velocity, NONE, CONSTRAINTS, TFA_OPS_CONSTRAINED, 0,         \
      NOTHING)                                                                                     \
    X(CONSTRAINT_RESIDUAL, constraint_residual, NONE, CONSTRAINTS, TFA_OPS_CONSTRAINED, 0,         \
      NOTHING)                                                                                     \
    X(DELASSUS, delassus, CONSTRAINTS, CONSTRAINTS, 0, TFA_WANT_DELASSUS, NOTHING)                 \
    X(OUT_V, v, NONE, V, TFA_OPS_IMPACT, 0, NOTHING)                                               \
    X(OUT_BASE_TWIST, base_twist, NONE, BASE, TFA_OPS_IMPACT, 0, NOTHING)                          \
    X(FRICTION_FORCE, friction_force, NONE, FREEDOMS, TFA_OPS_BIAS, 0, NOTHING)                    \
    X(REGRESSOR, regressor, FREEDOMS, PARAMETERS, TFA_OPS_REGRESSOR, 0, TIPS)                      \
    X(JOINT_REGRESSOR, joint_regressor, V, 3, TFA_OPS_REGRESSOR, 0, NOTHING)                       \
    X(GENERALISED_MOMENTUM, generalised_momentum, NONE, FREEDOMS, 0,                               \
      TFA_WANT_GENERALISED_MOMENTUM, NOTHING)                                                      \
    X(MOMENTUM_RATE, momentum_rate, NONE, FREEDOMS, 0, TFA_WANT_GENERALISED_MOMENTUM, NOTHING)

/** How JSON prints an output */
enum tfa_layout {
    LAYOUT_VECTOR,        /**< [...] */
    LAYOUT_MATRIX,        /**< [[row],...] */
    LAYOUT_NUMBER,        /**< one number */
    LAYOUT_FREEDOMS,      /**< [joints], and with a floating base "base_KEY":[6] */
    LAYOUT_BY_LINK,       /**< {link: row, ...}, one row for each frame */
    LAYOUT_BY_CONSTRAINT, /**< {constraint: row, ...}, one for each active one */
    LAYOUT_ENERGY,        /**< {"kinetic":..,"potential":..} */
    LAYOUT_LOST,          /**< an object for each direction, with the rank */
    LAYOUT_SPECTRUM,      /**< no numbers but tfa_spectrum: keys of its own */
    LAYOUT_RANK,          /**< no numbers but tfa_rank: keys of its own */
};

/** Outputs in the order in which JSON and Python print them, all but the answers: X(NAME in
 *  TFA_OUTPUT_LIST, member of the IDL's Reply, key, layout, meaning with unit and frame). */
#define TFA_OUTPUT_WORD_LIST(X)                                                                    \
    X(OUT_QDD, qdd, "qdd", VECTOR, "accelerations, rad/s^2 or m/s^2: time derivatives of v")       \
    X(OUT_BASE_ACCELERATION, base_acceleration, "base_acceleration", VECTOR,                       \
      "time derivatives of the components of base_twist, m/s^2 and rad/s^2")                       \
    X(OUT_V, v, "v", VECTOR, "velocities after the impact, rad/s or m/s")                          \
    X(OUT_BASE_TWIST, base_twist, "base_twist", VECTOR,                                            \
      "of the root link after the impact, in its axes, m/s and rad/s")                             \
    X(OUT_MODES, modes, "modes", VECTOR, "accelerations of the modal coordinates, 1/s^2")          \
    X(OUT_TAU, tau, "tau", VECTOR, "joint forces, N m or N")                                       \
    X(OUT_BASE_WRENCH, base_wrench, "base_wrench", VECTOR,                                         \
      "wrench on the root link in its frame, N and N m")                                           \
    X(GRAVITY_FORCE, gravity_force, "gravity", FREEDOMS,                                           \
      "forces that hold the robot against gravity, N m or N")                                      \
    X(VELOCITY_FORCE, velocity_force, "velocity", FREEDOMS,                                        \
      "Coriolis and centrifugal forces, N m or N")                                                 \
    X(DAMPING_FORCE, damping_force, "damping", FREEDOMS,                                           \
      "damping times v, N m or N; 0 unless the model has damping")                                 \
    X(FRICTION_FORCE, friction_force, "friction", FREEDOMS,                                        \
      "friction times v / sqrt(v^2 + friction_velocity^2), N m or N; 0 unless the model has it")   \
    X(EXTERNAL_FORCE, external_force, "external", FREEDOMS, "- sum of J^T wrench, N m or N")       \
    X(ARMATURE_FORCE, armature_force, "armature", FREEDOMS,                                        \
      "armature times qdd, part of M qdd; with qdd or base_acceleration")                          \
    X(JOINT_FORCES, joint_forces, "joint_forces", BY_LINK,                                         \
      "wrench that each link's joint exerts on it, N and N m, in `frame`")                         \
    X(LAMBDA_INV, lambda_inv, "lambda_inv", MATRIX, "J M^-1 J^T of the tips in `frame`")           \
    X(LAMBDA, lambda_matrix, "lambda", MATRIX, "inverse of lambda_inv, by rank_loss")              \
    X(MU, mu, "mu", VECTOR, "operational-space velocity, joint and wrench forces, N and N m")      \
    X(P, p, "p", VECTOR, "operational-space gravity forces, N and N m")                            \
    X(POSES, poses, "pose", MATRIX, "of the tips in the world: x y z (m), quaternion x y z w")     \
    X(TWISTS, twists, "twist", MATRIX, "of the tips in `frame`: linear, angular, m/s and rad/s")   \
    X(JACOBIAN, jacobian, "jacobian", MATRIX, "of the tips in `frame`: twist = J v")               \
    X(BIAS_ACCELERATION, bias_acceleration, "bias_acceleration", VECTOR,                           \
      "J-dot v; acceleration of the tips = J qdd + this")                                          \
    X(FRAME_POSES, frame_poses, "poses", BY_LINK,                                                  \
      "of all links in the world, in the order of `links`")                                        \
    X(COM, com, "com", VECTOR, "centre of mass of the bodies that move, m, world")                 \
    X(COM_VELOCITY, com_velocity, "com_velocity", VECTOR, "m/s, world")                            \
    X(COM_JACOBIAN, com_jacobian, "com_jacobian", MATRIX, "com_velocity = com_jacobian v")         \
    X(MASS, mass, "mass", NUMBER, "kg, of the bodies that move")                                   \
    X(MOMENTUM, momentum, "momentum", VECTOR,                                                      \
      "linear (N s), angular about the centre of mass (N m s), axes of the world")                 \
    X(ENERGY, energy, "energy", ENERGY, "kinetic, potential, J")                                   \
    X(MASS_MATRIX, mass_matrix, "M", MATRIX, "mass matrix, the base first")                        \
    X(GENERALISED_MOMENTUM, generalised_momentum, "generalised_momentum", FREEDOMS,                \
      "M v, kg m^2/s or kg m/s")                                                                   \
    X(MOMENTUM_RATE, momentum_rate, "momentum_rate", FREEDOMS,                                     \
      "its rate without tau, N m or N: dM/dt v - velocity - gravity - damping - friction -\n"      \
      "external")                                                                                  \
    X(REGRESSOR, regressor, "regressor", MATRIX,                                                   \
      "ten columns for each link in `tips`: mass, mass times centre (3), inertia about the\n"      \
      "link's origin (ixx ixy ixz iyy iyz izz), axes of the link")                                 \
    X(JOINT_REGRESSOR, joint_regressor, "joint_regressor", MATRIX,                                 \
      "of each freedom, its armature's, damping's and friction's factors")                         \
    X(DQDD_DQ, dqdd_dq, "dqdd_dq", MATRIX, "by motion along each freedom")                         \
    X(DQDD_DV, dqdd_dv, "dqdd_dv", MATRIX, "by the velocity of each freedom")                      \
    X(DQDD_DTAU, dqdd_dtau, "dqdd_dtau", MATRIX, "by the force of each freedom: M^-1")             \
    X(DTAU_DQ, dtau_dq, "dtau_dq", MATRIX, "by motion along each freedom")                         \
    X(DTAU_DV, dtau_dv, "dtau_dv", MATRIX, "by the velocity of each freedom")                      \
    X(CONSTRAINT_WRENCHES, constraint_wrenches, "constraint_wrenches", BY_CONSTRAINT,              \
      "on the second frames of the active constraints, axes of the first ones, N and N m; of\n"    \
      "impact impulses, N s and N m s")                                                            \
    X(CONSTRAINT_RESIDUAL, constraint_residual, "constraint_residual", BY_CONSTRAINT,              \
      "acceleration that is not met, m/s^2 and rad/s^2; of impact velocity, m/s and rad/s")        \
    X(CONSTRAINT_POSITION, constraint_position, "constraint_position", BY_CONSTRAINT,              \
      "errors of position, m and rad")                                                             \
    X(CONSTRAINT_VELOCITY, constraint_velocity, "constraint_velocity", BY_CONSTRAINT,              \
      "errors of velocity, m/s and rad/s; of impact before it")                                    \
    X(DELASSUS, delassus, "delassus", MATRIX, "J_c M^-1 J_c^T of the active constraints")          \
    X(SPECTRUM, spectrum, "spectrum", SPECTRUM,                                                    \
      "rank and extreme eigenvalues of lambda_inv, as rank, eig_min, eig_max")                     \
    X(RANK, rank, "rank", RANK,                                                                    \
      "rank of lambda_inv, or of the constraints' rows, as the op used it, as rank, lost,\n"       \
      "threshold, condition, length, error_estimate")                                              \
    X(LOST, lost, "lost", LOST,                                                                    \
      "directions at or below the threshold, by ascending singular value, the rest 0: "            \
      "singular\nvalue (1/sqrt(kg)), acceleration given up along it (m/s^2), direction")

/** Keys of a request in JSON and Python (`poses`: JSON only): X(key, ops that use it, flags that
 *  let every op use it). Of names as near to a wrong one the first is named first. The state
 *  (q, v, base, modes, gravity) may be given with every op, used or not, so that a program can ask
 *  different questions about one state. */
#define TFA_KEY_LIST(X)                                                                            \
    X(q, TFA_OPS_ALL, 0)                                                                           \
    X(v, TFA_OPS_ALL, 0)                                                                           \
    X(base_pose, TFA_OPS_ALL, 0)                                                                   \
    X(base_twist, TFA_OPS_ALL, 0)                                                                  \
    X(gravity, TFA_OPS_ALL, 0)                                                                     \
    X(tau, TFA_OPS_FD | TFA_OPS_DERIVATIVES | TFA_OPS_CONSTRAINED_FD, 0)                           \
    X(posture_torques, TFA_OPS_TASK, 0)                                                            \
    X(base_wrench, TFA_OPS_FORWARD, 0)                                                             \
    X(qdd, TFA_OPS_QDD, 0)                                                                         \
    X(base_acceleration, TFA_OPS_QDD, 0)                                                           \
    X(modes, TFA_OPS_ALL, 0)                                                                       \
    X(mode_velocities, TFA_OPS_ALL, 0)                                                             \
    X(wrench, TFA_OPS_FORCES, FLAGS_WRENCHES)                                                      \
    X(tips, TFA_OPS_TIPS, TFA_WANT_OF_TIPS)                                                        \
    X(rows, TFA_OPS_SOLVE, TFA_WANT_OF_TIPS)                                                       \
    X(frame, TFA_OPS_FORCES | TFA_OPS_OSIM, TFA_WANT_OF_TIPS)                                      \
    X(acceleration, TFA_OPS_TASK, 0)                                                               \
    X(rank_loss, TFA_OPS_RANK, TFA_WANT_RANK)                                                      \
    X(rank_threshold, TFA_OPS_RANK, TFA_WANT_RANK)                                                 \
    X(characteristic_length, TFA_OPS_RANK, TFA_WANT_RANK)                                          \
    X(method, TFA_OPS_ALL, 0)                                                                      \
    X(refine, TFA_OPS_SOLVE, 0)                                                                    \
    X(estimate, TFA_OPS_SOLVE, 0)                                                                  \
    X(poses, TFA_OPS_SOLVE, 0)                                                                     \
    X(constraints, TFA_OPS_CONSTRAINED, 0)                                                         \
    X(constraint_acceleration, TFA_OPS_CONSTRAINED & ~TFA_OPS_IMPACT, 0)                           \
    X(stabilisation, TFA_OPS_CONSTRAINED, 0)                                                       \
    X(torque_weights, TFA_OPS_CONSTRAINED_ID, 0)                                                   \
    X(payload, TFA_OPS_ALL, 0)                                                                     \
    X(locked, TFA_OPS_ALL & ~TFA_OPS_M, 0)

/** Words of `want`, in the order in which messages name them: X(word, TFA_WANT_ bit) */
#define TFA_WANT_LIST(X)                                                                           \
    X("jacobian", JACOBIAN)                                                                        \
    X("bias_acceleration", BIAS_ACCELERATION)                                                      \
    X("twist", TWISTS)                                                                             \
    X("pose", POSES)                                                                               \
    X("poses", FRAME_POSES)                                                                        \
    X("com", COM)                                                                                  \
    X("momentum", MOMENTUM)                                                                        \
    X("energy", ENERGY)                                                                            \
    X("generalised_momentum", GENERALISED_MOMENTUM)                                                \
    X("lambda", LAMBDA)                                                                            \
    X("mu", MU)                                                                                    \
    X("p", P)                                                                                      \
    X("spectrum", SPECTRUM)                                                                        \
    X("joint_forces", JOINT_FORCES)                                                                \
    X("delassus", DELASSUS)

/** An output of TFA_OUTPUT_LIST */
typedef struct tfa_output {
    uint16_t member, size; /**< of the buffer in tfa_reply; of one item */
    int8_t rows, columns;  /**< enum tfa_extent */
    uint8_t needs;         /**< enum tfa_needs */
    uint32_t ops, flags;
} tfa_output;

/** Blocks of the wire: bits of tfa_wire_request.present, and of .want; places in tfa_outputs */
#define TFA_WIRE_BLOCK(name, ...) TFA_WIRE_##name,
enum { TFA_INPUT_LIST(TFA_WIRE_BLOCK) TFA_WIRE_REQUEST_BLOCKS };
enum { TFA_OUTPUT_LIST(TFA_WIRE_BLOCK) TFA_WIRE_REPLY_BLOCKS };
#undef TFA_WIRE_BLOCK

static const tfa_output tfa_outputs[TFA_WIRE_REPLY_BLOCKS] = {
#define TFA_OUTPUT(name, member, rows, columns, ops, flags, needs)                                 \
    {offsetof(tfa_reply, member),                                                                  \
     sizeof *((tfa_reply *)0)->member,                                                             \
     EXTENT_##rows,                                                                                \
     EXTENT_##columns,                                                                             \
     NEEDS_##needs,                                                                                \
     ops,                                                                                          \
     flags},
    TFA_OUTPUT_LIST(TFA_OUTPUT)
#undef TFA_OUTPUT
};

#define TFA_OUTPUT_WORD(name, ...) (1ull << TFA_WIRE_##name) +
_Static_assert(TFA_OUTPUT_WORD_LIST(TFA_OUTPUT_WORD) 1 == (1ull << TFA_WIRE_REPLY_BLOCKS) - 1 &&
                   TFA_WIRE_ANSWERS == 0,
               "every output but the answers has a word");
#undef TFA_OUTPUT_WORD

/** Buffer of an output in a reply; NULL: none */
static inline void *tfa_output_buffer(const tfa_output *output, const tfa_reply *reply)
{
    void *buffer;
    memcpy(&buffer, (const unsigned char *)reply + output->member, sizeof buffer);
    return buffer;
}

static inline void tfa_output_set_buffer(const tfa_output *output, tfa_reply *reply, void *buffer)
{
    memcpy((unsigned char *)reply + output->member, &buffer, sizeof buffer);
}

/** 1: JSON and Python print this output. An array without joints is printed, one of a fixed base,
 *  of no modes or of no tips is not. */
static inline int tfa_is_printed(const tfa_output *output, uint32_t base_freedoms, uint32_t modes,
                                 const tfa_request *r)
{
    if (!(r->flags & output->flags) && !(TFA_OP_BIT(r->op) & output->ops))
        return 0;
    if (output->needs == NEEDS_QDD)
        return r->qdd || r->base_acceleration;
    if (output->columns == EXTENT_BASE)
        return base_freedoms != 0;
    if (output->columns == EXTENT_MODES)
        return modes != 0;
    if (output->columns == EXTENT_LOST && TFA_OP_BIT(r->op) & TFA_OPS_CONSTRAINED)
        return 1;
    return (output->columns != EXTENT_ROWS && output->columns != EXTENT_LOST) || r->tip_count;
}

/** Six for each active constraint; 0 of ops without */
static inline size_t tfa_constraints_of(uint32_t op, uint32_t constraints)
{
    return op <= TFA_OP_LAST && TFA_OP_BIT(op) & TFA_OPS_CONSTRAINED
               ? 6 * (size_t)__builtin_popcount(constraints)
               : 0;
}

/** Bits of all constraints of a robot */
static inline uint32_t tfa_all_constraints(uint32_t count)
{
    return (uint32_t)((UINT64_C(1) << count) - 1);
}

static inline size_t tfa_constraint_numbers(const tfa_request *r)
{
    return tfa_constraints_of((uint32_t)r->op, r->constraints);
}

/** Lengths of a request to a robot */
static inline tfa_extents tfa_extents_of(uint32_t q, uint32_t v, uint32_t base, uint32_t links,
                                         uint32_t modes, const tfa_request *r)
{
    return (tfa_extents){.q = q,
                         .v = v,
                         .base = base,
                         .links = links,
                         .count = r->count,
                         .tips = r->tip_count,
                         .rows = rows_of(r) * (size_t)r->tip_count,
                         .wrenches = r->wrench_count,
                         .payloads = r->payload_count,
                         .locked = r->locked_count,
                         .modes = modes,
                         .constraints = tfa_constraint_numbers(r)};
}

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
        return 2 + (n->constraints ? n->constraints : n->rows);
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
    case EXTENT_MODES:
        return n->modes;
    case EXTENT_CONSTRAINTS:
        return n->constraints;
    case EXTENT_PARAMETERS:
        return n->tips * TFA_LINK_PARAMETERS;
    default:
        return (size_t)extent;
    }
}

#endif
