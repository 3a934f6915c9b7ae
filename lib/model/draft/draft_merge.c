/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Merging of links into bodies: rigid connections removed, frames turned so that joint axes are z,
 * inertias summed about the joint. In quadruple precision, rounded to double once when the model is
 * compiled.
 */
#include <string.h>

#include "model/draft/draft.h"
#include "model/payload.h"

void tfa_draft_add_link(const struct draft *d, size_t number, struct tfa_mass_properties *sum)
{
    const tfa_link *link = &d->description->links[number];
    const struct draft_frame *f = &d->frame[number];
    const long double *s = d->link[number].inertia;
    int empty = link->mass == 0;
    for (int k = 0; k < 6; k++)
        empty &= s[k] == 0;
    if (empty)
        return;
    ext quat[4], Q[9], R[9], com[3], c[3];
    const ext Ic[6] = {s[0], s[1], s[2], s[3], s[4], s[5]};
    ext_from_parts(quat, link->quat, link->quat_low, 4);
    ext_rotation(Q, quat);
    (void)draft_snap(Q, d->options->snap);
    ext_mul(R, f->R, Q);
    ext_from_double(com, link->com, 3);
    ext_apply(c, f->R, com, f->p);
    tfa_mass_properties_add(sum, link->mass, c, R, Ic);
}

static struct draft_body *new_body(struct draft *d, uint32_t link, int32_t joint, uint8_t kind)
{
    struct draft_body *b = &d->body[d->bodies++];
    memset(b, 0, sizeof *b);
    b->link = link;
    b->joint = joint;
    b->kind = kind;
    b->n = joint_types[kind].freedoms;
    ext_identity(b->E);
    return b;
}

static int refuse_axis(const tfa_joint *joint, tfa_report *report)
{
    return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "zero-axis",
                      "joint '%s': axis %g %g %g has no direction; give it a unit vector",
                      joint->name, joint->axis[0], joint->axis[1], joint->axis[2]);
}

/* Axes and origin of the joint's frame in the body that carries its parent link */
static void joint_frame(const struct draft *d, const tfa_joint *joint, ext axes[9], ext origin[3])
{
    const struct draft_frame *up = &d->frame[joint->parent];
    ext quat[4], xyz[3], R[9];
    ext_from_parts(quat, joint->quat, joint->quat_low, 4);
    ext_from_double(xyz, joint->xyz, 3);
    ext_rotation(R, quat);
    (void)draft_snap(R, d->options->snap);
    ext_mul(axes, up->R, R);
    ext_apply(origin, up->R, xyz, up->p);
}

/* The child link of a rigid joint becomes a frame on the parent's body. */
static int merge_rigid(struct draft *d, uint32_t j, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    struct draft_frame *f = &d->frame[joint->child];
    ext axes[9], origin[3], R[9], t[3];
    if (tfa_joint_transform(joint, d->joint[j].q, R, t) != TFA_OK)
        return refuse_axis(joint, report);
    joint_frame(d, joint, axes, origin);
    f->body = d->frame[joint->parent].body;
    ext_mul(f->R, axes, R);
    ext_apply(f->p, axes, t, origin);
    return TFA_OK;
}

/* The child link of a moving joint becomes a body whose z axis is the joint's. */
static int add_moving(struct draft *d, uint32_t j, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    struct draft_frame *f = &d->frame[joint->child];
    ext align[9], axes[9], rotated[9];
    if (tfa_joint_axes(align, joint) != TFA_OK)
        return refuse_axis(joint, report);
    struct draft_body *b = new_body(d, joint->child, (int32_t)j, joint_type_of(joint->type));
    joint_frame(d, joint, axes, b->r);
    ext_mul(rotated, axes, align); /* body axes in the parent body's axes */
    ext_transpose(b->E, rotated);
    b->parent = d->frame[joint->parent].body;
    b->armature = draft_armature(d, j);
    d->joint[j].body = (int32_t)(d->bodies - 1);
    f->body = (int32_t)(d->bodies - 1);
    ext_transpose(f->R, align); /* link axes (those of the joint) to body axes */
    memset(f->p, 0, sizeof f->p);
    return TFA_OK;
}

static void start_at_root(struct draft *d)
{
    struct draft_frame *root = &d->frame[d->root];
    memset(root, 0, sizeof *root);
    ext_identity(root->R);
    root->body = -1;
    if (d->options->base == TFA_BASE_FLOATING) {
        struct draft_body *b = new_body(d, d->root, -1, TFA_KIND_FREE);
        b->parent = -1;
        b->base = 1;
        root->body = 0;
    }
}

int tfa_draft_merge(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    draft_note_snaps(d, report);
    start_at_root(d);
    for (size_t k = 0; k < s->joint_count; k++) {
        const uint32_t j = d->order[k];
        if (d->joint[j].fate == TFA_FATE_ABSENT)
            continue;
        int status = draft_moves(d, j) ? add_moving(d, j, report) : merge_rigid(d, j, report);
        if (status != TFA_OK)
            return status;
    }
    for (size_t k = 0; k < s->link_count; k++) {
        if (!d->link[k].present)
            continue;
        struct draft_body *b = d->frame[k].body < 0 ? &d->world : &d->body[d->frame[k].body];
        tfa_draft_add_link(d, k, &b->sum);
        b->loaded |= d->link[k].loaded;
        d->mass += s->links[k].mass;
    }
    return TFA_OK;
}
