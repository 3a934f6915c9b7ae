/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `scalar`: the constant terms of one body are those of the model, the same in all lanes of
 * a batch.
 */
#ifndef TFA_LAYOUT_SCALAR_BODY_H
#define TFA_LAYOUT_SCALAR_BODY_H

#include "layout/constants.h"

/* Bodies that share the lanes of a num */
#define LAYOUT_BODIES_IN_LANES 1

typedef struct tfa_body body_constants;

/* T: from the parent's frame to the joint's at q = 0 */
static inline mat3 body_E(const body_constants *b)
{
    return constant_mat3(BODY_XFORM_SOURCE(b)->E);
}

static inline vec3 body_r(const body_constants *b)
{
    return constant_vec3(BODY_XFORM_SOURCE(b)->r);
}

static inline num body_mass(const body_constants *b)
{
    return constant_of(BODY_MASS_SOURCE(b)->mass);
}

/* Mass times centre of mass */
static inline vec3 body_h(const body_constants *b)
{
    return constant_vec3(BODY_MASS_SOURCE(b)->h);
}

static inline sym3 body_I(const body_constants *b)
{
    const constant *I = BODY_MASS_SOURCE(b)->I;
    return (sym3){constant_of(I[0]), constant_of(I[1]), constant_of(I[2]),
                  constant_of(I[3]), constant_of(I[4]), constant_of(I[5])};
}

/* Of a joint with one freedom */
static inline num body_armature(const body_constants *b)
{
    return num_of(b->armature);
}

/* Of the sentinel, k 0: of a rotation, 1: of a translation */
static inline num body_outboard(const body_constants *b, int k)
{
    return num_of(b->outboard[k]);
}

/* Of an axial one: shift along z */
static inline num body_d(const body_constants *b)
{
    return num_of(b->d);
}

/* Its own modes; -1: rigid */
static inline int32_t body_flexible(const body_constants *b)
{
    return b->flexible;
}

/* Of a flexible parent, on which its joint stands; -1: none */
static inline int32_t body_handle(const body_constants *b)
{
    return b->handle;
}

static inline int body_has_armature(const body_constants *b)
{
    return b->armature > 0;
}

/* First freedom among those of the model */
static inline uint32_t body_first_freedom(const body_constants *b)
{
    return b->v;
}

#endif
