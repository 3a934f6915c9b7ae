/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where a compiled model's inner coordinates and freedoms come from, and what belongs to each
 * freedom.
 */
#include "model/compile/emit.h"

/* The description's joint behind freedom k of body i. */
static uint32_t joint_of(const struct draft *d, uint32_t i, uint32_t k)
{
    const struct draft_body *b = &d->body[i];
    return is_fused(b->kind) ? d->part[b->first + k].joint : (uint32_t)b->joint;
}

/* Inner freedom of a joint with one freedom */
static uint32_t freedom_of(const struct layout *l, const struct draft_joint *joint)
{
    return l->body[joint->body].v + joint->freedom;
}

/* A joint with one freedom: its own coordinate, or that of its leader. */
static void map_joint_1dof(struct layout *l, const struct draft *d, const struct draft_joint *joint,
                           uint32_t q, uint32_t v)
{
    struct tfa_model *m = l->model;
    const uint32_t inner = v + m->base_freedoms;
    if (joint->fate != TFA_FATE_FOLLOWS) {
        l->coordinate[q] = (struct tfa_coordinate){joint->q_index, 1, 0};
        l->freedom[v] = (struct tfa_freedom){joint->v_index, 1};
        return;
    }
    const struct draft_joint *leader = &d->joint[joint->leader];
    const double multiplier = (double)joint->multiplier, offset = (double)joint->offset;
    l->coordinate[q] = (struct tfa_coordinate){leader->q_index, multiplier, offset};
    l->freedom[v] = (struct tfa_freedom){leader->v_index, multiplier};
    l->mimic[m->mimics++] = (struct tfa_mimic){inner, freedom_of(l, leader), multiplier};
}

static void map_joint_nd(struct layout *l, const struct draft_joint *joint,
                         const struct tfa_body *b)
{
    const uint32_t coordinates = joint_coordinates(b->kind, b->n);
    const uint32_t v = b->v - l->model->base_freedoms;
    for (uint32_t k = 0; k < coordinates; k++)
        l->coordinate[b->q + k] = (struct tfa_coordinate){joint->q_index + k, 1, 0};
    for (uint32_t k = 0; k < b->n; k++)
        l->freedom[v + k] = (struct tfa_freedom){joint->v_index + k, 1};
}

void tfa_emit_maps(struct layout *l, const struct draft *d)
{
    const struct tfa_model *m = l->model;
    const tfa_joint *joints = d->description->joints;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &l->body[i];
        if (b->base)
            continue;
        for (uint32_t k = 0; k < b->n; k++) {
            const uint32_t j = joint_of(d, i, k);
            l->armature[b->v + k] = draft_armature(d, j);
            l->damping[b->v + k] = d->options->damping ? joints[j].damping : 0;
            if (is_fused(b->kind) || b->n == 1)
                map_joint_1dof(l, d, &d->joint[j], b->q + k, b->v + k - m->base_freedoms);
            else if (k == 0)
                map_joint_nd(l, &d->joint[j], b);
        }
    }
}
