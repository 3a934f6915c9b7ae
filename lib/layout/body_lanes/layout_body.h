/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `body_lanes`: the lanes of a num hold several bodies of one state. The index of a body
 * in other layouts is a step here: one body for each lane, of the same kind of joint, parents
 * in steps before. Constants are stored in lane order.
 */
#ifndef TFA_LAYOUT_BODY_LANES_BODY_H
#define TFA_LAYOUT_BODY_LANES_BODY_H

#include "layout/constants.h"

/* Bodies that share the lanes of a num */
#define LAYOUT_BODIES_IN_LANES NUM_LANES

/* A number for each lane */
struct lane_indices {
    uint32_t lane[NUM_LANES];
};

/* Source of a lane in another step: of the arrays' element `step` the lane `lane`. */
struct lane_refs {
    uint32_t step[NUM_LANES], lane[NUM_LANES];
};

/* Source of the lanes of a step: all from the same lane of one step,
 * which is a plain load; or from anywhere. */
enum { SOURCE_SAME_LANE, SOURCE_SCATTERED };

/* Lanes of a step whose children stand elsewhere: how many, and where in s->child. Several lanes
 * only where they hold the same body. */
struct branch {
    num_mask lanes;
    uint32_t first, count;
};

/* Lane `lane` of step `step` */
struct lane_ref {
    uint32_t step, lane;
};

/* As struct tfa_body. Lanes without a body repeat one of the others, and are never read. */
typedef struct body_constants {
    xform T;
    num mass;
    vec3 h;
    sym3 I;
    num armature;
    num d;
    num outboard[2];
    num_mask roots;        /* lanes whose parent is the world */
    struct lane_refs from; /* scattered: the parents */
    /* the body whose numbers a lane has: the one that stands there, or one that the lane repeats
     * to the bit; else UINT32_MAX */
    struct lane_indices lane_body;
    int32_t parent;      /* step of the parents, if SOURCE_SAME_LANE; -1: the world in all lanes */
    uint8_t source_kind; /* the parents: JOIN_ */
    uint8_t has_roots;   /* some lanes are roots */
    uint8_t has_armature, axial, kind, n, base;
    uint8_t leaf; /* no lane has a child */
    uint8_t last; /* never: children are summed by the parent, see parent_transfer.h */
    /* every lane has its one child in the same lane of step `child`, or */
    uint8_t children_in_lane;
    uint32_t child;
    num_mask other_lanes;      /* all lanes but these, */
    uint32_t branch, branches; /* and lanes whose children are in s->branch */
    /* as in tfa_body: such a joint has a step of its own, the same in all lanes */
    int32_t joint_nd;
    uint32_t q, v;    /* first of the scheduled coordinates and freedoms */
    uint32_t freedom; /* first of the model's freedoms */
    uint32_t part;
} body_constants;

static inline mat3 body_E(const body_constants *b)
{
    return b->T.E;
}

static inline vec3 body_r(const body_constants *b)
{
    return b->T.r;
}

static inline num body_mass(const body_constants *b)
{
    return b->mass;
}

static inline vec3 body_h(const body_constants *b)
{
    return b->h;
}

static inline sym3 body_I(const body_constants *b)
{
    return b->I;
}

static inline num body_armature(const body_constants *b)
{
    return b->armature;
}

static inline num body_outboard(const body_constants *b, int k)
{
    return b->outboard[k];
}

static inline num body_d(const body_constants *b)
{
    return b->d;
}

/* Robots with flexible links have no body lanes. */
static inline int32_t body_flexible(const body_constants *b)
{
    (void)b;
    return -1;
}

static inline int32_t body_handle(const body_constants *b)
{
    (void)b;
    return -1;
}

static inline int body_has_armature(const body_constants *b)
{
    return b->has_armature;
}

static inline uint32_t body_first_freedom(const body_constants *b)
{
    return b->freedom;
}

#endif
