/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constant terms of the bodies of one step of a robot's own kernel, in lane order (terms.h): which
 * bodies these are is a table, and what they have becomes constant vectors.
 */
#ifndef TFA_KERNEL_OWN_PACKED_TERMS_H
#define TFA_KERNEL_OWN_PACKED_TERMS_H

#include "spatial/spatial.h"

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

typedef struct own_step {
    int32_t body[NUM_LANES]; /* lanes without one repeat another */
    uint32_t held;           /* bit l: a body stands in lane l */
    int32_t parent;          /* -1: all are roots */
    int32_t multi;
    uint32_t q, v; /* first of the packed coordinates and freedoms */
    uint32_t freedom, part;
    uint8_t kind, n, base, leaf, last, axial, geared;
} terms;

#include "own_tables.h"

static const struct own_step own_step[] = {OWN_STEP_TABLE};
static const uint32_t own_step_of[] = {OWN_STEP_OF};
static const int own_lane_of[] = {OWN_LANE_OF};

#define OWN_LANE(l) own_body[b->body[l]]

#define OWN_TERM(name, type, index, field)                                                         \
    TFA_INLINE num name(const terms *b index)                                                      \
    {                                                                                              \
        return NUM_EACH(field);                                                                    \
    }
#define OWN_INDEX , int k
#define OWN_LANE_E(l) OWN_LANE(l).E[k]
#define OWN_LANE_R(l) OWN_LANE(l).r[k]
#define OWN_LANE_H(l) OWN_LANE(l).h[k]
#define OWN_LANE_I(l) OWN_LANE(l).I[k]
#define OWN_LANE_MASS(l) OWN_LANE(l).mass
#define OWN_LANE_ARMATURE(l) OWN_LANE(l).armature
#define OWN_LANE_D(l) OWN_LANE(l).d
#define OWN_LANE_BOUND(l) OWN_LANE(l).bound[k]
OWN_TERM(own_E, num, OWN_INDEX, OWN_LANE_E)
OWN_TERM(own_r, num, OWN_INDEX, OWN_LANE_R)
OWN_TERM(own_h, num, OWN_INDEX, OWN_LANE_H)
OWN_TERM(own_I, num, OWN_INDEX, OWN_LANE_I)
OWN_TERM(terms_mass, num, , OWN_LANE_MASS)
OWN_TERM(terms_armature, num, , OWN_LANE_ARMATURE)
OWN_TERM(terms_d, num, , OWN_LANE_D)
OWN_TERM(own_bound, num, OWN_INDEX, OWN_LANE_BOUND)

TFA_INLINE mat3 terms_E(const terms *b)
{
    return (mat3){own_E(b, 0), own_E(b, 1), own_E(b, 2), own_E(b, 3), own_E(b, 4),
                  own_E(b, 5), own_E(b, 6), own_E(b, 7), own_E(b, 8)};
}

TFA_INLINE vec3 terms_r(const terms *b)
{
    return (vec3){own_r(b, 0), own_r(b, 1), own_r(b, 2)};
}

TFA_INLINE vec3 terms_h(const terms *b)
{
    return (vec3){own_h(b, 0), own_h(b, 1), own_h(b, 2)};
}

TFA_INLINE sym3 terms_I(const terms *b)
{
    return (sym3){own_I(b, 0), own_I(b, 1), own_I(b, 2), own_I(b, 3), own_I(b, 4), own_I(b, 5)};
}

TFA_INLINE num terms_bound(const terms *b, uint32_t k)
{
    return own_bound(b, (int)k);
}

TFA_INLINE int terms_geared(const terms *b)
{
    return b->geared;
}

TFA_INLINE uint32_t terms_freedom(const terms *b)
{
    return b->freedom;
}

#endif
