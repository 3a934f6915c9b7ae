/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Traits of a request: one word of bits, computed once, from which the engine decides how to
 * compute.
 */
#ifndef TFA_INTERFACE_TRAITS_H
#define TFA_INTERFACE_TRAITS_H

#include <totalforce/dynamics.h>

enum {
    TRAIT_FD = TFA_OP_BIT(TFA_OP_FORWARD_DYNAMICS),
    TRAIT_ID = TFA_OP_BIT(TFA_OP_INVERSE_DYNAMICS),
    TRAIT_OSIM = TFA_OP_BIT(TFA_OP_OPERATIONAL_INERTIA),
    TRAIT_M = TFA_OP_BIT(TFA_OP_MASS_MATRIX),
    TRAIT_KINEMATICS = TFA_OP_BIT(TFA_OP_KINEMATICS),
    TRAIT_BIAS = TFA_OP_BIT(TFA_OP_BIAS),
    TRAIT_TASK = TFA_OP_BIT(TFA_OP_TASK_TORQUES),
    TRAIT_DERIVATIVES = TFA_OP_BIT(TFA_OP_DERIVATIVES),
    TRAIT_ID_DERIVATIVES = TFA_OP_BIT(TFA_OP_INVERSE_DYNAMICS_DERIVATIVES),
    TRAIT_CONSTRAINED_FD = TFA_OP_BIT(TFA_OP_CONSTRAINED_DYNAMICS),
    TRAIT_IMPACT = TFA_OP_BIT(TFA_OP_IMPACT),
    TRAIT_CONSTRAINED_ID = TFA_OP_BIT(TFA_OP_CONSTRAINED_INVERSE_DYNAMICS),
    TRAIT_REGRESSOR = TFA_OP_BIT(TFA_OP_REGRESSOR),
    TRAIT_TIPS = 1u << 14,             /* at least one tip */
    TRAIT_SEVERAL_TIPS = 1u << 15,     /* at least two */
    TRAIT_TIP_MOTION = 1u << 16,       /* twists, Jacobians, bias accelerations of tips */
    TRAIT_BODY_MOTION = 1u << 17,      /* frame poses, centre of mass, momentum, energy */
    TRAIT_SPECTRUM = 1u << 18,         /* of lambda_inv */
    TRAIT_LAMBDA = 1u << 19,           /* lambda, mu, p */
    TRAIT_POINT = 1u << 20,            /* three rows for each tip */
    TRAIT_WRENCH = 1u << 21,           /* external wrenches */
    TRAIT_PAYLOAD = 1u << 22,          /* payloads of the request */
    TRAIT_LOCK = 1u << 23,             /* locked joints of the request */
    TRAIT_REFINE = 1u << 24,           /* a number of refinement steps above 0 */
    TRAIT_DEFAULT_REFINE = 1u << 25,   /* the method's own number of steps */
    TRAIT_ESTIMATE = 1u << 26,         /* an error estimate of every answer */
    TRAIT_DEFAULT_ESTIMATE = 1u << 27, /* one where the method or the sentinel asks for it */
    TRAIT_POSES = 1u << 28,            /* of the tips */
    TRAIT_JOINT_FORCES = 1u << 29,     /* across all joints */
};
_Static_assert(TRAIT_TIPS > TFA_OP_BIT(TFA_OP_LAST), "ops come first");

/* Ops that solve for accelerations with tau: forward dynamics and those made of it */
#define TRAITS_FORWARD (TRAIT_FD | TRAIT_TASK | TRAIT_DERIVATIVES | TRAIT_CONSTRAINED_FD)
/* Ops that read accelerations */
#define TRAITS_INVERSE                                                                             \
    (TRAIT_ID | TRAIT_BIAS | TRAIT_ID_DERIVATIVES | TRAIT_CONSTRAINED_ID | TRAIT_REGRESSOR)
#define TRAITS_DERIVATIVES (TRAIT_DERIVATIVES | TRAIT_ID_DERIVATIVES)
/* Ops that answer lambda_inv */
#define TRAITS_LAMBDA_INV (TRAIT_FD | TRAIT_OSIM | TRAIT_TASK)
/* Ops with constraints */
#define TRAITS_CONSTRAINED (TRAIT_CONSTRAINED_FD | TRAIT_IMPACT | TRAIT_CONSTRAINED_ID)
/* Ops that read velocities, gravity and wrenches, whatever the flags */
#define TRAITS_DYNAMICS (TRAITS_FORWARD | TRAITS_INVERSE)
/* Answers of kinematics besides those of the op */
#define TRAITS_MOTION (TRAIT_TIP_MOTION | TRAIT_BODY_MOTION)
/* Answers besides those of the op that the kernel of one state adds to those of any other */
#define TRAITS_ADDED (TRAITS_MOTION | TRAIT_JOINT_FORCES)
/* Changes of the model's constants or forces */
#define TRAITS_CHANGED (TRAIT_WRENCH | TRAIT_PAYLOAD | TRAIT_LOCK)
/* Lists that name frames or joints */
#define TRAITS_SCENE (TRAIT_TIPS | TRAITS_CHANGED)

/* Flags by what they depend on */
#define FLAGS_TIP_MOTION (TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION)
#define FLAGS_BODY_MOTION                                                                          \
    (TFA_WANT_FRAME_POSES | TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY |                   \
     TFA_WANT_GENERALISED_MOMENTUM)
#define FLAGS_LAMBDA (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P)
#define FLAGS_VELOCITY                                                                             \
    (TFA_WANT_TWISTS | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_COM | TFA_WANT_MOMENTUM |             \
     TFA_WANT_ENERGY | TFA_WANT_MU | TFA_WANT_GENERALISED_MOMENTUM)
#define FLAGS_WRENCHES (TFA_WANT_MU | TFA_WANT_GENERALISED_MOMENTUM)
#define FLAGS_GRAVITY (FLAGS_WRENCHES | TFA_WANT_ENERGY | TFA_WANT_P)

/* Of a request with a valid op. Cost: some ten instructions. */
static inline uint32_t traits_of(const tfa_request *r)
{
    uint32_t t = TFA_OP_BIT(r->op);
    t |= r->tip_count ? TRAIT_TIPS : 0;
    t |= r->tip_count > 1 ? TRAIT_SEVERAL_TIPS : 0;
    if (r->flags) {
        t |= r->flags & TFA_WANT_POSES ? TRAIT_POSES : 0;
        t |= r->flags & FLAGS_TIP_MOTION ? TRAIT_TIP_MOTION : 0;
        t |= r->flags & FLAGS_BODY_MOTION ? TRAIT_BODY_MOTION : 0;
        t |= r->flags & TFA_WANT_SPECTRUM ? TRAIT_SPECTRUM : 0;
        t |= r->flags & FLAGS_LAMBDA ? TRAIT_LAMBDA : 0;
        t |= r->flags & TFA_WANT_JOINT_FORCES ? TRAIT_JOINT_FORCES : 0;
    }
    t |= r->rows ? TRAIT_POINT : 0;
    t |= r->wrench_count ? TRAIT_WRENCH : 0;
    t |= r->payload_count ? TRAIT_PAYLOAD : 0;
    t |= r->locked_count ? TRAIT_LOCK : 0;
    t |= r->refine == TFA_REFINE_DEFAULT ? TRAIT_DEFAULT_REFINE : r->refine ? TRAIT_REFINE : 0;
    t |= r->estimate == TFA_ESTIMATE_ALWAYS    ? TRAIT_ESTIMATE
         : r->estimate == TFA_ESTIMATE_DEFAULT ? TRAIT_DEFAULT_ESTIMATE
                                               : 0;
    return t;
}

/* 1: the request has inputs or answers that forward and inverse dynamics without tips have not */
static inline int tfa_is_operational(const tfa_request *r)
{
    return r->flags || r->rows || r->rank_loss || r->rank_threshold || r->characteristic_length ||
           TFA_OP_BIT(r->op) & (TRAIT_OSIM | TRAIT_TASK | TRAITS_CONSTRAINED | TRAIT_REGRESSOR);
}

/* Rows of a tip; as many as there can be if the kind does not exist */
static inline uint32_t tfa_tip_rows(uint32_t rows)
{
    return rows == TFA_ROWS_POINT ? 3 : 6;
}

static inline uint32_t rows_of(const tfa_request *r)
{
    return tfa_tip_rows(r->rows);
}

/* 1: velocities are read */
static inline int reads_velocity(const tfa_request *r)
{
    return (TFA_OP_BIT(r->op) & (TRAITS_DYNAMICS | TRAIT_IMPACT)) != 0 ||
           (r->flags & FLAGS_VELOCITY) != 0;
}

/* 1: gravity is read */
static inline int reads_gravity(const tfa_request *r)
{
    return (TFA_OP_BIT(r->op) & TRAITS_DYNAMICS) != 0 || (r->flags & FLAGS_GRAVITY) != 0;
}

/* 1: wrenches are read */
static inline int reads_wrenches(const tfa_request *r)
{
    return (TFA_OP_BIT(r->op) & (TRAITS_DYNAMICS ^ TRAIT_REGRESSOR)) != 0 ||
           (r->flags & FLAGS_WRENCHES) != 0;
}

#endif
