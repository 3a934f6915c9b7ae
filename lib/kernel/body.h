/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the constants of one body mean: its rigid inertia, and its joint's motion subspace.
 */
#ifndef TFA_KERNEL_BODY_H
#define TFA_KERNEL_BODY_H

#include "kernel/state.h"

/* The axis of a 1-freedom joint among the six components of a spatial vector. */
enum { AXIS_REVOLUTE = 2, AXIS_PRISMATIC = 5 };

static inline int body_axis(const struct tfa_body *b)
{
    return b->kind == TFA_KIND_REVOLUTE ? AXIS_REVOLUTE : AXIS_PRISMATIC;
}

/* I v with the rigid inertia: moment I w + h x v, force m v - h x w */
static inline svec rigid_mul(const struct tfa_body *b, svec v)
{
    sym3 I = {num_of(b->I[0]), num_of(b->I[1]), num_of(b->I[2]),
              num_of(b->I[3]), num_of(b->I[4]), num_of(b->I[5])};
    vec3 h = v3_load(b->h);
    return (svec){v3_add(s3_mul(I, v.w), v3_cross(h, v.v)),
                  v3_sub(v3_scale(v.v, num_of(b->mass)), v3_cross(h, v.w))};
}

static inline sym6 rigid_inertia(const struct tfa_body *b)
{
    num x = num_of(b->h[0]), y = num_of(b->h[1]), z = num_of(b->h[2]), m = num_of(b->mass),
        o = num_of(0);
    return (sym6){{num_of(b->I[0]), num_of(b->I[1]), num_of(b->I[2]), num_of(b->I[3]),
                   num_of(b->I[4]), num_of(b->I[5])},
                  {o, -z, y, z, o, -x, -y, x, o},
                  {m, o, o, m, o, m}};
}

/* Column k of the motion subspace of a joint with several freedoms */
static inline svec multi_axis(const struct multi *u, uint32_t k)
{
    return sv_from(u->H + 6 * k);
}

/* H x for a joint with several freedoms */
static inline svec multi_motion(const struct multi *u, uint32_t n, const num *x)
{
    svec sum = sv_zero();
    for (uint32_t k = 0; k < n; k++)
        sum = sv_add(sum, sv_scale(multi_axis(u, k), x[k]));
    return sum;
}

/* Rotor inertia of freedom k */
static inline num joint_armature(const struct state *s, const struct tfa_body *b, uint32_t k)
{
    return num_of(b->n == 1 ? b->armature : s->m->armature[b->v + k]);
}

/* a += H x for the joint of body b, x its freedoms */
static inline void add_joint_motion(const struct state *s, const struct tfa_body *b, const num *x,
                                    svec *a)
{
    if (b->kind == TFA_KIND_REVOLUTE)
        a->w.z += x[0];
    else if (b->kind == TFA_KIND_PRISMATIC)
        a->v.z += x[0];
    else
        *a = sv_add(*a, multi_motion(&s->multi[b->multi], b->n, x));
}

/* x = H^T f for the joint of body b */
static inline void joint_force(const struct state *s, const struct tfa_body *b, svec f, num *x)
{
    if (b->kind == TFA_KIND_REVOLUTE)
        x[0] = f.w.z;
    else if (b->kind == TFA_KIND_PRISMATIC)
        x[0] = f.v.z;
    else
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = sv_dot(multi_axis(&s->multi[b->multi], k), f);
}

#endif
