/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Poses of bodies in the world, outward, and motions of bodies in world axes.
 */
#ifndef TFA_DYNAMICS_KINEMATICS_WORLD_POSE_H
#define TFA_DYNAMICS_KINEMATICS_WORLD_POSE_H

#include "layout/body.h"
#include "spatial/vec6.h"

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

/* World poses of all bodies. Needs the pose. O(N) */
void TFA_V(world_poses)(struct state *s);

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

/* Column k of the joint's motion subspace, the same */
static inline struct motion_simd joint_axis_at_point(const struct state *s, uint32_t i, uint32_t k,
                                                     vec3_simd p)
{
    const struct world_pose *W = &s->world[i];
    const struct tfa_body *b = &s->body[i];
    const vec3_simd z = W->E.row[2], zero = vec3_simd_of(num_of(0), num_of(0), num_of(0));
    if (is_revolute(b->kind))
        return rotation_at_point(z, W->r, p);
    if (is_prismatic(b->kind))
        return (struct motion_simd){zero, z};
    if (b->base && k < 3) /* base_motion: the body's axes */
        return (struct motion_simd){zero, W->E.row[k]};
    if (b->base)
        return rotation_at_point(W->E.row[k - 3], W->r, p);
    return motion_at_point(W, joint_nd_axis(&s->joint_nd[b->joint_nd], k), p);
}

/* World poses of body i and its ancestors, `length` in all, listed in s->tip_path. Needs the pose.
 * The pose of the parent is carried in registers: through memory a body takes twice as long. */
static inline void locate_support(struct state *s, int32_t i, uint32_t length)
{
    s->path_body = i;
    for (uint32_t at = length; i >= 0; i = s->body[i].parent)
        s->tip_path[--at] = (uint32_t)i;
    struct world_pose W = world_pose_of_root(&s->X[s->tip_path[0]]);
    s->world[s->tip_path[0]] = W;
    for (uint32_t k = 1; k < length; k++) {
        W = world_pose_step(&s->X[s->tip_path[k]], &W);
        s->world[s->tip_path[k]] = W;
    }
}

#endif
