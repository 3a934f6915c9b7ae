/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constant terms of one body, as the kernels read them. In a packed variant (TFA_PACKED) the
 * lanes of a num hold several bodies of one state: constants are stored in lane order, and what
 * stands for a body elsewhere, its index, is a step: one body for each lane, of the same kind of
 * joint, parents in steps before.
 */
#ifndef TFA_KERNEL_TERMS_H
#define TFA_KERNEL_TERMS_H

#include "model/model.h"
#include "spatial/spatial.h"

#ifdef NUM_QUAD
typedef tfa_quad constant;
#define TERMS_PLACE(b) (&(b)->quad->place)
#define TERMS_MASS(b) (&(b)->quad->mass)
#else
typedef double constant;
#define TERMS_PLACE(b) (b)
#define TERMS_MASS(b) (b)
#endif

static inline num constant_of(constant x)
{
#ifdef NUM_QUAD
    return x;
#else
    return num_of(x);
#endif
}

static inline vec3 constant_vec3(const constant *p)
{
    return (vec3){constant_of(p[0]), constant_of(p[1]), constant_of(p[2])};
}

static inline mat3 constant_mat3(const constant *p)
{
    return (mat3){constant_of(p[0]), constant_of(p[1]), constant_of(p[2]),
                  constant_of(p[3]), constant_of(p[4]), constant_of(p[5]),
                  constant_of(p[6]), constant_of(p[7]), constant_of(p[8])};
}

/* Axes of a link's frame in its body, and its origin there */
static inline place terms_frame(const struct tfa_model *m, uint32_t frame)
{
#ifdef NUM_QUAD
    const struct tfa_place_quad *f = &m->frame_quad[frame];
    return (place){constant_mat3(f->E), constant_vec3(f->r)};
#else
    const struct tfa_frame *f = &m->frame[frame];
    return (place){constant_mat3(f->R), constant_vec3(f->p)};
#endif
}

/* From the frame of the part before to that of a part of a fused body, both at q = 0 */
static inline place terms_part(const struct tfa_model *m, uint32_t part)
{
#ifdef NUM_QUAD
    const struct tfa_place_quad *p = &m->part_quad[part];
#else
    const struct tfa_part *p = &m->part[part];
#endif
    return (place){constant_mat3(p->E), constant_vec3(p->r)};
}

#if defined TFA_PACKED && defined TFA_OWN
#include "kernel/own_packed_terms.h"
#elif defined TFA_PACKED
#include "kernel/packed_terms.h"
#else

#ifdef TFA_OWN
#include "kernel/own_abi.h"
#include "own_tables.h"
#endif

typedef struct tfa_body terms;

/* T: from the parent's frame to the joint's at q = 0 */
static inline mat3 terms_E(const terms *b)
{
    return constant_mat3(TERMS_PLACE(b)->E);
}

static inline vec3 terms_r(const terms *b)
{
    return constant_vec3(TERMS_PLACE(b)->r);
}

static inline num terms_mass(const terms *b)
{
    return constant_of(TERMS_MASS(b)->mass);
}

/* Mass times centre of mass */
static inline vec3 terms_h(const terms *b)
{
    return constant_vec3(TERMS_MASS(b)->h);
}

static inline sym3 terms_I(const terms *b)
{
    const constant *I = TERMS_MASS(b)->I;
    return (sym3){constant_of(I[0]), constant_of(I[1]), constant_of(I[2]),
                  constant_of(I[3]), constant_of(I[4]), constant_of(I[5])};
}

/* Of a joint with one freedom */
static inline num terms_armature(const terms *b)
{
    return num_of(b->armature);
}

/* Largest inertia that freedom k may move */
static inline num terms_bound(const terms *b, uint32_t k)
{
    return num_of(b->bound[k]);
}

/* Of an axial one: shift along z */
static inline num terms_d(const terms *b)
{
    return num_of(b->d);
}

static inline int terms_geared(const terms *b)
{
    return b->armature > 0;
}

/* First freedom among those of the model */
static inline uint32_t terms_freedom(const terms *b)
{
    return b->v;
}

#endif
#endif
