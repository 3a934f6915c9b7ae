/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constants of a model as numbers of a kernel: the doubles, or in quadruple precision the constants
 * before they were rounded.
 */
#ifndef TFA_LAYOUT_CONSTANTS_H
#define TFA_LAYOUT_CONSTANTS_H

#include "model/model.h"
#include "spatial/spatial.h"

#ifdef NUM_QUAD
typedef tfa_quad constant;
#define BODY_XFORM_SOURCE(b) (&(b)->quad->xform)
#define BODY_MASS_SOURCE(b) (&(b)->quad->mass)
#else
typedef double constant;
#define BODY_XFORM_SOURCE(b) (b)
#define BODY_MASS_SOURCE(b) (b)
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
static inline xform frame_xform(const struct tfa_model *m, uint32_t frame)
{
#ifdef NUM_QUAD
    const struct tfa_xform_quad *f = &m->frame_quad[frame];
    return (xform){constant_mat3(f->E), constant_vec3(f->r)};
#else
    const struct tfa_frame *f = &m->frame[frame];
    return (xform){constant_mat3(f->R), constant_vec3(f->p)};
#endif
}

/* From the frame of the part before to that of a part of a fused body, both at q = 0 */
static inline xform part_xform(const struct tfa_model *m, uint32_t part)
{
#ifdef NUM_QUAD
    const struct tfa_xform_quad *p = &m->part_quad[part];
#else
    const struct tfa_part *p = &m->part[part];
#endif
    return (xform){constant_mat3(p->E), constant_vec3(p->r)};
}

#endif
