/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a compiled model calls its frames and joints.
 */
#include <string.h>

#include "model/compile/emit.h"

static const char *keep_text(struct layout *l, const char *text)
{
    char *start = l->text;
    size_t n = strlen(text) + 1;
    memcpy(start, text, n);
    l->text += n;
    return start;
}

static void emit_frames(struct layout *l, const struct draft *d)
{
    for (size_t k = 0; k < d->description->link_count; k++) {
        const struct draft_frame *from = &d->frame[k];
        if (!d->link[k].present)
            continue;
        struct tfa_frame *f = &l->frame[from->number];
        f->body = from->body;
        f->part = from->part;
        struct tfa_xform_quad *quad = &l->frame_quad[from->number];
        memcpy(quad->E, from->R, sizeof quad->E);
        memcpy(quad->r, from->p, sizeof quad->r);
        ext_round(f->R, from->R, 9);
        ext_round(f->p, from->p, 3);
        f->name = keep_text(l, d->description->links[k].name);
    }
}

/* A public joint, if it is one. */
static void emit_joint(struct layout *l, const struct draft *d, uint32_t j, const char *name)
{
    const struct draft_joint *joint = &d->joint[j];
    const tfa_joint_type type = d->description->joints[j].type;
    if (joint->fate != TFA_FATE_MOVES && joint->fate != TFA_FATE_FUSED)
        return;
    l->joint[joint->number] = (tfa_joint_info){
        .name = name,
        .type = type,
        .q_index = joint->q_index,
        .q_count = declared_coordinates(type),
        .v_index = joint->v_index,
        .v_count = declared_freedoms(type),
        .body = (uint32_t)joint->body,
        .armature = draft_armature(d, j),
    };
}

static void emit_declared_joint(struct layout *l, const struct draft *d, uint32_t j,
                                const char *name)
{
    const struct draft_joint *joint = &d->joint[j];
    const tfa_joint *stated = &d->description->joints[j];
    const int has_coordinates = joint->fate == TFA_FATE_MOVES || joint->fate == TFA_FATE_FUSED;
    const int follows = joint->fate == TFA_FATE_FOLLOWS;
    l->declared[l->model->declared_joints++] = (tfa_declared_joint){
        .name = name,
        .type = stated->type,
        .fate = (tfa_fate)joint->fate,
        .body = joint->fate == TFA_FATE_ABSENT ? -1 : d->frame[stated->child].body,
        .joint = has_coordinates ? (int32_t)joint->number : -1,
        .leader = follows ? (int32_t)d->joint[joint->leader].number : -1,
        .multiplier = follows ? (double)joint->multiplier : 0,
        .offset = follows ? (double)joint->offset : 0,
    };
}

void tfa_emit_names(struct layout *l, const struct draft *d)
{
    const tfa_description *s = d->description;
    l->model->name = keep_text(l, s->name ? s->name : "");
    emit_frames(l, d);
    for (size_t k = 0; k < s->joint_count; k++) {
        const uint32_t j = d->order[k];
        const char *name = keep_text(l, s->joints[j].name);
        emit_joint(l, d, j, name);
        emit_declared_joint(l, d, j, name);
    }
}
