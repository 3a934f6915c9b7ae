/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constant terms of the bodies of one step, in lane order (terms.h).
 */
#ifndef TFA_KERNEL_PACKED_TERMS_H
#define TFA_KERNEL_PACKED_TERMS_H

#include "spatial/spatial.h"

/* A number for each lane */
struct each {
    uint32_t lane[NUM_LANES];
};

/* What one lane reads from another: of the arrays' element `step` the lane `lane`. */
struct slots {
    uint32_t step[NUM_LANES], lane[NUM_LANES];
};

/* How the lanes of a step have something from those of others: all from the same lane of one step,
 * which is a plain load; or from anywhere. */
enum { JOIN_STRAIGHT, JOIN_SCATTERED };

/* Lanes of a step whose children stand elsewhere: how many, and where in s->child. Several lanes only
 * where they hold the same body. */
struct fork {
    num_mask lanes;
    uint32_t first, count;
};

/* Lane `lane` of step `step` */
struct slot {
    uint32_t step, lane;
};

/* As struct tfa_body. Lanes without a body repeat one of the others, and nobody reads them. */
typedef struct terms {
    place T;
    num mass;
    vec3 h;
    sym3 I;
    num armature;
    num d;
    num bound[6];
    num_mask roots;    /* lanes whose parent is the world */
    struct slots from; /* scattered: the parents */
    struct each holds; /* the body whose numbers a lane has: the one that stands there, or one that
                          the lane repeats to the bit; else UINT32_MAX */
    int32_t parent;    /* step of the parents, if straight; -1: the world in all lanes */
    uint8_t how;       /* the parents: JOIN_ */
    uint8_t mixed;     /* some lanes are roots */
    uint8_t geared, axial, kind, n, base;
    uint8_t leaf;   /* no body hangs from any lane */
    uint8_t last;   /* never: what children give is taken, see join.h */
    uint8_t handed; /* every lane has its one child in the same lane of step `child`, or */
    uint32_t child;
    num_mask without;     /* all lanes but these, */
    uint32_t fork, forks; /* and lanes whose children are in s->fork */
    int32_t multi; /* as in tfa_body: such a joint has a step of its own, the same in all lanes */
    uint32_t q, v; /* first of the packed coordinates and freedoms */
    uint32_t freedom; /* first of the model's freedoms */
    uint32_t part;
} terms;

static inline mat3 terms_E(const terms *b)
{
    return b->T.E;
}

static inline vec3 terms_r(const terms *b)
{
    return b->T.r;
}

static inline num terms_mass(const terms *b)
{
    return b->mass;
}

static inline vec3 terms_h(const terms *b)
{
    return b->h;
}

static inline sym3 terms_I(const terms *b)
{
    return b->I;
}

static inline num terms_armature(const terms *b)
{
    return b->armature;
}

static inline num terms_bound(const terms *b, uint32_t k)
{
    return b->bound[k];
}

static inline num terms_d(const terms *b)
{
    return b->d;
}

static inline int terms_geared(const terms *b)
{
    return b->geared;
}

static inline uint32_t terms_freedom(const terms *b)
{
    return b->freedom;
}

#endif
