/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `specialised_body_lanes`: the bodies of one robot in lanes (layout/body_lanes). The
 * schedule is a table, and the constants of the bodies of a step become constant vectors.
 */
#ifndef TFA_LAYOUT_SPECIALISED_BODY_LANES_BODY_H
#define TFA_LAYOUT_SPECIALISED_BODY_LANES_BODY_H

#include "layout/constants.h"

/* f of each lane, side by side; and whether it holds in all of them */
#if NUM_LANES == 8
#define NUM_EACH(f) ((num){f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)})
#define NUM_EVERY(f) (f(0) && f(1) && f(2) && f(3) && f(4) && f(5) && f(6) && f(7))
#elif NUM_LANES == 4
#define NUM_EACH(f) ((num){f(0), f(1), f(2), f(3)})
#define NUM_EVERY(f) (f(0) && f(1) && f(2) && f(3))
#else
#define NUM_EACH(f) ((num){f(0), f(1)})
#define NUM_EVERY(f) (f(0) && f(1))
#endif

typedef struct robot_step {
    int32_t body[NUM_LANES]; /* lanes without one repeat another */
    uint32_t lane_mask;      /* bit l: a body stands in lane l */
    int32_t parent;          /* -1: all are roots */
    int32_t joint_nd;
    uint32_t q, v; /* first of the packed coordinates and freedoms */
    uint32_t freedom, part;
    uint8_t kind, n, base, leaf, last, axial, has_armature;
} body_constants;

#include "robot_tables.h"

static const struct robot_step robot_step[] = {ROBOT_STEP_TABLE};
static const uint32_t robot_step_of[] = {ROBOT_STEP_OF};
static const int robot_lane_of[] = {ROBOT_LANE_OF};

#define ROBOT_LANE(l) robot_body[b->body[l]]

#define ROBOT_CONSTANT(name, type, index, field)                                                   \
    TFA_INLINE num name(const body_constants *b index)                                             \
    {                                                                                              \
        return NUM_EACH(field);                                                                    \
    }
#define ROBOT_INDEX , int k
#define ROBOT_LANE_E(l) ROBOT_LANE(l).E[k]
#define ROBOT_LANE_R(l) ROBOT_LANE(l).r[k]
#define ROBOT_LANE_H(l) ROBOT_LANE(l).h[k]
#define ROBOT_LANE_I(l) ROBOT_LANE(l).I[k]
#define ROBOT_LANE_MASS(l) ROBOT_LANE(l).mass
#define ROBOT_LANE_ARMATURE(l) ROBOT_LANE(l).armature
#define ROBOT_LANE_D(l) ROBOT_LANE(l).d
#define ROBOT_LANE_OUTBOARD(l) ROBOT_LANE(l).outboard[k]
ROBOT_CONSTANT(robot_E, num, ROBOT_INDEX, ROBOT_LANE_E)
ROBOT_CONSTANT(robot_r, num, ROBOT_INDEX, ROBOT_LANE_R)
ROBOT_CONSTANT(robot_h, num, ROBOT_INDEX, ROBOT_LANE_H)
ROBOT_CONSTANT(robot_I, num, ROBOT_INDEX, ROBOT_LANE_I)
ROBOT_CONSTANT(body_mass, num, , ROBOT_LANE_MASS)
ROBOT_CONSTANT(body_armature, num, , ROBOT_LANE_ARMATURE)
ROBOT_CONSTANT(body_d, num, , ROBOT_LANE_D)
ROBOT_CONSTANT(body_outboard, num, ROBOT_INDEX, ROBOT_LANE_OUTBOARD)

TFA_INLINE mat3 body_E(const body_constants *b)
{
    return (mat3){robot_E(b, 0), robot_E(b, 1), robot_E(b, 2), robot_E(b, 3), robot_E(b, 4),
                  robot_E(b, 5), robot_E(b, 6), robot_E(b, 7), robot_E(b, 8)};
}

TFA_INLINE vec3 body_r(const body_constants *b)
{
    return (vec3){robot_r(b, 0), robot_r(b, 1), robot_r(b, 2)};
}

TFA_INLINE vec3 body_h(const body_constants *b)
{
    return (vec3){robot_h(b, 0), robot_h(b, 1), robot_h(b, 2)};
}

TFA_INLINE sym3 body_I(const body_constants *b)
{
    return (sym3){robot_I(b, 0), robot_I(b, 1), robot_I(b, 2),
                  robot_I(b, 3), robot_I(b, 4), robot_I(b, 5)};
}

TFA_INLINE int body_has_armature(const body_constants *b)
{
    return b->has_armature;
}

TFA_INLINE uint32_t body_first_freedom(const body_constants *b)
{
    return b->freedom;
}

#endif
