/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Poses of bodies in the world, outward, and motions of their joints in world axes.
 */
#ifndef TFA_DYNAMICS_KINEMATICS_WORLD_POSE_H
#define TFA_DYNAMICS_KINEMATICS_WORLD_POSE_H

#include "layout/body.h"
#include "spatial/world_axes.h"

/* World poses of all bodies. Needs the pose. O(N) */
void TFA_V(world_poses)(struct state *s);

/* Column k of the joint's motion subspace, at point p of the world */
static inline struct motion_simd joint_axis_at_point(const struct state *s, uint32_t i, uint32_t k,
                                                     vec3_simd p)
{
    const struct world_pose *W = &s->world[i];
    const struct tfa_body *b = &s->body[i];
    if (b->n == 1 || b->base)
        return joint_axis_in_world(b, W, k, p);
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
