/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The pose of a body in the world, and motions in world axes.
 */
#ifndef TFA_SPATIAL_WORLD_AXES_H
#define TFA_SPATIAL_WORLD_AXES_H

#include "spatial/spatial.h"
#include "spatial/vec6.h"

/* Its axes by rows, and its origin */
struct world_pose {
    struct mat3_simd E;
    vec3_simd r;
};

static inline struct world_pose world_pose_of_root(const xform *X)
{
    return (struct world_pose){mat3_simd_of(X->E), vec3_simd_of(X->r.x, X->r.y, X->r.z)};
}

/* E_i^w = E_i E_parent^w,  r_i^w = r_parent^w + E_parent^wT r_i: X of the body, W of its parent */
TFA_INLINE struct world_pose world_pose_step(const xform *X, const struct world_pose *W)
{
    return (struct world_pose){mat3_simd_mul(&X->E, &W->E),
                               vec3_simd_add(W->r, mat3_simd_apply_t(&W->E, X->r))};
}

/* Axes (columns) of a frame of a body, and a point of it: from the body's to the world's */
static inline mat3 axes_in_world(const struct world_pose *W, mat3 axes)
{
    const struct mat3_simd R = mat3_simd_transpose(&W->E);
    mat3 E;
    num *const e = &E.xx;
    for (int k = 0; k < 9; k++)
        e[k] = vec3_simd_lane(&R.row[k / 3], k % 3);
    return m3_mm(E, axes);
}

static inline vec3_simd point_in_world(const struct world_pose *W, vec3 p)
{
    return vec3_simd_add(W->r, mat3_simd_apply_t(&W->E, p));
}

/* A motion in world axes */
struct motion_simd {
    vec3_simd w, v;
};

static inline struct motion_simd motion_simd_add(struct motion_simd a, struct motion_simd b)
{
    return (struct motion_simd){vec3_simd_add(a.w, b.w), vec3_simd_add(a.v, b.v)};
}

static inline struct motion_simd motion_simd_scale(num x, struct motion_simd m)
{
    for (int k = 0; k < VEC3_SIMD_VECS; k++) {
        m.w.vec[k] = x * m.w.vec[k];
        m.v.vec[k] = x * m.v.vec[k];
    }
    return m;
}

/* m^T f of a wrench, its moment in place of w */
static inline num motion_simd_dot(struct motion_simd m, struct motion_simd f)
{
    for (int k = 0; k < VEC3_SIMD_VECS; k++)
        m.w.vec[k] = m.w.vec[k] * f.w.vec[k] + m.v.vec[k] * f.v.vec[k];
    const vec3 sum = vec3_of_simd(m.w);
    return sum.x + sum.y + sum.z;
}

static inline svec motion_simd_store(struct motion_simd a)
{
    return (svec){vec3_of_simd(a.w), vec3_of_simd(a.v)};
}

/* A motion of a body, given in its frame, at point p of the world */
static inline struct motion_simd motion_at_point(const struct world_pose *W, svec m, vec3_simd p)
{
    const vec3_simd w = mat3_simd_apply_t(&W->E, m.w), v = mat3_simd_apply_t(&W->E, m.v);
    return (struct motion_simd){w, vec3_simd_add(v, vec3_simd_cross(w, vec3_simd_sub(p, W->r)))};
}

/* Unit rotation about an axis through r, at point p of the world */
static inline struct motion_simd rotation_at_point(vec3_simd axis, vec3_simd r, vec3_simd p)
{
    return (struct motion_simd){axis, vec3_simd_cross(axis, vec3_simd_sub(p, r))};
}

#endif
