/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Poses of all bodies in the world, outward.
 */
#include "dynamics/kinematics/world_pose.h"

void TFA_V(world_poses)(struct state *s)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const int32_t parent = s->body[i].parent;
        s->world[i] = parent < 0 ? world_pose_of_root(&s->X[i])
                                 : world_pose_step(&s->X[i], &s->world[parent]);
    }
}
