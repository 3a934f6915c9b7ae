/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations with the constants of one body: its rigid inertia, and its joint's motion subspace.
 */
#ifndef TFA_LAYOUT_BODY_H
#define TFA_LAYOUT_BODY_H

#include "layout/state.h"
#include "spatial/screw.h"
#include "spatial/world_axes.h"

/* The axis of a 1-freedom joint among the six components of a spatial vector */
static inline int body_axis(const body_constants *b)
{
    return is_revolute(b->kind) ? AXIS_RZ : AXIS_TZ; /* two cases: no load of a table */
}

/* Is X_i a screw? Doubles only. The widest numbers have general transforms: with the doubles of the
 * model, a sine and a cosine whose squares add up to 1 within 1e-16 only, every method has to see
 * the very same X. So have floats: with screws the worst answer of aba to 8 links was wrong by 1000
 * roundings instead of 380, and refinement of 128 straight links stalled (test_precision, EPYC
 * VM, 2026-11-22). */
static inline int body_axial(const body_constants *b)
{
    return NUM_EPSILON > 0x1p-60 && NUM_EPSILON < 0x1p-30 && b->axial;
}

static inline screw body_screw(const struct state *s, uint32_t i, const body_constants *b)
{
    return screw_of(&s->X[i], body_d(b));
}

/* X_i m: a motion from the parent */
TFA_INLINE svec motion_to_child(const struct state *s, uint32_t i, const body_constants *b, svec m)
{
    if (!body_axial(b))
        return xform_motion(&s->X[i], m);
    const screw k = body_screw(s, i, b);
    return screw_motion(&k, m);
}

/* X_i^T f: a force to the parent */
TFA_INLINE svec force_to_parent(const struct state *s, uint32_t i, const body_constants *b, svec f)
{
    if (!body_axial(b))
        return xform_t_force(&s->X[i], f);
    const screw k = body_screw(s, i, b);
    return screw_t_force(&k, f);
}

/* X_i^T S X_i for an S without row and column z */
TFA_INLINE sym6 inertia_to_parent_zero_z(const struct state *s, uint32_t i, const body_constants *b,
                                         const sym6 *S)
{
    if (!body_axial(b))
        return s6_to_parent_zero_z(&s->X[i], S);
    const screw k = body_screw(s, i, b);
    return screw_to_parent_zero_z(&k, S);
}

/* I v with the rigid inertia: moment I w + h x v, force m v - h x w */
static inline svec rigid_mul(const body_constants *b, svec v)
{
    return s6_rigid_mul(body_I(b), body_h(b), body_mass(b), v);
}

static inline sym6 rigid_inertia(const body_constants *b)
{
    return s6_rigid(body_I(b), body_h(b), body_mass(b));
}

/* Column k of the motion subspace of a joint with several freedoms */
static inline svec joint_nd_axis(const struct joint_nd *u, uint32_t k)
{
    return sv_from(u->H + 6 * k);
}

/* H x for a joint with several freedoms */
static inline svec joint_nd_motion(const struct joint_nd *u, uint32_t n, const num *x)
{
    svec sum = sv_zero();
    for (uint32_t k = 0; k < n; k++)
        sum = sv_add(sum, sv_scale(joint_nd_axis(u, k), x[k]));
    return sum;
}

/* Freedoms of a floating base: linear, then angular velocity. H x, and H^T f. */
static inline svec base_motion(const num *x)
{
    return (svec){v3(x[3], x[4], x[5]), v3(x[0], x[1], x[2])};
}

static inline void base_force(svec f, num *x)
{
    sv_store(x, (svec){f.v, f.w});
}

/* Column k of the motion subspace of a joint with one freedom or of a floating base, whose body has
 * this pose, at point p of the world */
static inline struct motion_simd
joint_axis_in_world(const body_constants *b, const struct world_pose *W, uint32_t k, vec3_simd p)
{
    const vec3_simd zero = vec3_simd_of(num_of(0), num_of(0), num_of(0));
    if (is_revolute(b->kind))
        return rotation_at_point(W->E.row[2], W->r, p);
    if (is_prismatic(b->kind))
        return (struct motion_simd){zero, W->E.row[2]};
    if (k < 3) /* base_motion: the body's axes */
        return (struct motion_simd){zero, W->E.row[k]};
    return rotation_at_point(W->E.row[k - 3], W->r, p);
}

/* a += H x for the joint of body b, x its freedoms */
static inline void add_joint_motion(const struct state *s, const body_constants *b, const num *x,
                                    svec *a)
{
    if (is_revolute(b->kind))
        a->w.z += x[0];
    else if (is_prismatic(b->kind))
        a->v.z += x[0];
    else if (b->base)
        *a = sv_add(*a, base_motion(x));
    else
        *a = sv_add(*a, joint_nd_motion(&s->joint_nd[b->joint_nd], b->n, x));
}

/* x = H^T f for the joint of body b */
static inline void joint_force(const struct state *s, const body_constants *b, svec f, num *x)
{
    if (is_revolute(b->kind))
        x[0] = f.w.z;
    else if (is_prismatic(b->kind))
        x[0] = f.v.z;
    else if (b->base)
        base_force(f, x);
    else
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = sv_dot(joint_nd_axis(&s->joint_nd[b->joint_nd], k), f);
}

#endif
