/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Frames and joints of a compiled model: maps from public to inner coordinates, constants of the
 * freedoms, names.
 */
#include <string.h>

#include "model/compile/compile.h"

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
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &l->body[i];
        if (b->base)
            continue;
        for (uint32_t k = 0; k < b->n; k++) {
            const uint32_t j = joint_of(d, i, k);
            l->armature[b->v + k] = draft_armature(d, j);
            l->damping[b->v + k] = draft_damping(d, j);
            l->friction[b->v + k] = draft_friction(d, j);
            if (is_fused(b->kind) || b->n == 1)
                map_joint_1dof(l, d, &d->joint[j], b->q + k, b->v + k - m->base_freedoms);
            else if (k == 0)
                map_joint_nd(l, &d->joint[j], b);
        }
    }
}

/* ---- names ---- */

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
        ext_round_rotation(f->R, from->R);
        ext_round_vector(f->p, from->p, 0);
        f->name = keep_text(l, d->description->links[k].name);
    }
}

static void emit_links(struct layout *l, const struct draft *d)
{
    uint32_t links = 0;
    for (size_t k = 0; k < d->description->link_count; k++)
        if (d->link[k].present)
            tfa_draft_add_link(d, k, &l->link_without_payload[d->frame[k].number]);
    l->link_order[links++] = d->frame[d->root].number;
    l->link[l->link_order[0]].parent = -1;
    l->link[l->link_order[0]].is_first = d->frame[d->root].body >= 0;
    for (size_t k = 0; k < d->description->joint_count; k++) {
        const tfa_joint *joint = &d->description->joints[d->order[k]];
        if (d->joint[d->order[k]].fate == TFA_FATE_ABSENT)
            continue;
        const struct draft_frame *child = &d->frame[joint->child],
                                 *parent = &d->frame[joint->parent];
        l->link_order[links++] = child->number;
        l->link[child->number].parent = (int32_t)parent->number;
        l->link[child->number].is_first = child->body != parent->body;
    }
}

/* A public joint, if it is one. */
static void emit_joint(struct layout *l, const struct draft *d, uint32_t j, const char *name)
{
    const struct draft_joint *joint = &d->joint[j];
    const tfa_joint_type type = d->description->joints[j].type;
    const tfa_scene *scene = d->options->scene;
    if (joint->fate != TFA_FATE_MOVES && joint->fate != TFA_FATE_FUSED)
        return;
    l->joint[joint->number] = (tfa_joint_info){
        .name = name,
        .type = type,
        .q_index = joint->q_index,
        .q_count = tfa_joint_type_describe(type).coordinates,
        .v_index = joint->v_index,
        .v_count = tfa_joint_type_describe(type).freedoms,
        .body = (uint32_t)joint->body,
        .armature = draft_armature(d, j),
        .damping = draft_damping(d, j),
        .friction = draft_friction(d, j),
        .actuated = !scene || !scene->actuated_count || joint->actuated,
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

static void emit_closure(struct layout *l, const struct draft *d, uint32_t k)
{
    const tfa_constraint *from = d->constraint[k];
    struct tfa_closure *c = &l->closure[k];
    c->rows = from->rows;
    c->unilateral = from->unilateral;
    c->name = keep_text(l, from->name);
    for (int side = 0; side < 2; side++) {
        const double *pose = from->pose[side];
        ext R[9];
        tfa_constraint_axes(R, pose);
        const int32_t link = tfa_draft_find_link(d, from->link[side]);
        c->frame[side] = link < 0 ? -1 : (int32_t)d->frame[link].number;
        ext_round_rotation(c->R[side], R);
        memcpy(c->p[side], pose, sizeof c->p[side]);
    }
}

void tfa_emit_names(struct layout *l, const struct draft *d)
{
    const tfa_description *s = d->description;
    l->model->name = keep_text(l, s->name ? s->name : "");
    emit_frames(l, d);
    emit_links(l, d);
    for (size_t k = 0; k < s->joint_count; k++) {
        const uint32_t j = d->order[k];
        const char *name = keep_text(l, s->joints[j].name);
        emit_joint(l, d, j, name);
        emit_declared_joint(l, d, j, name);
    }
    for (uint32_t k = 0; k < d->constraints; k++)
        emit_closure(l, d, k);
}
