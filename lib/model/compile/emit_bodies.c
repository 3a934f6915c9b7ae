/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bodies, the tree of freedoms and the main chains of a compiled model.
 */
#include <string.h>

#include "model/compile/compile.h"

/* Mass, h, I and `regular` come from tfa_compute_mass_properties. */
static void round_body(struct tfa_body *o, struct tfa_xform_quad *quad, const struct draft *d,
                       uint32_t i)
{
    const struct draft_body *b = &d->body[i];
    memcpy(quad->E, b->E, sizeof quad->E);
    memcpy(quad->r, b->r, sizeof quad->r);
    const ext moved = i && b->parent >= 0 ? ext_abs(d->body[b->parent].move.w) : 0;
    ext_round_rotation(o->E, b->E);
    ext_round_vector(o->r, b->r, moved + ext_abs(b->move.w));
    o->axial = b->axial && b->handle < 0; /* a handle turns and moves */
    if (o->axial) {
        o->E[6] = 0;
        o->r[0] = (double)b->a;
        o->r[1] = (double)(b->d * o->E[7]);
        o->r[2] = (double)(b->d * o->E[8]);
    }
    o->armature = b->armature;
    o->d = (double)b->d;
    o->parent = b->parent;
    o->kind = b->kind;
    o->n = b->n;
    o->base = b->base;
    o->link = d->frame[b->link].number;
}

static void emit_parts(struct layout *l, const struct draft *d, uint32_t i)
{
    struct tfa_body *b = &l->body[i];
    b->part = l->model->parts;
    for (uint32_t k = 0; is_fused(b->kind) && k < b->n; k++) {
        const struct draft_part *from = &d->part[d->body[i].first + k];
        struct tfa_part *part = &l->part[l->model->parts++];
        struct tfa_xform_quad *quad = &l->part_quad[part - l->part];
        memcpy(quad->E, from->E, sizeof quad->E);
        memcpy(quad->r, from->r, sizeof quad->r);
        ext_round_rotation(part->E, from->E);
        ext_round_vector(part->r, from->r, 0);
        part->kind = from->kind;
    }
}

/* Marks leaves, and the last child of each body. */
static void mark_ends(struct layout *l)
{
    for (uint32_t i = 0; i < l->model->bodies; i++)
        l->body[i].leaf = 1;
    for (uint32_t i = l->model->bodies; i-- > 0;) {
        struct tfa_body *b = &l->body[i];
        if (b->parent < 0)
            continue;
        b->last = l->body[b->parent].leaf;
        l->body[b->parent].leaf = 0;
    }
}

void tfa_emit_bodies(struct layout *l, const struct draft *d)
{
    struct tfa_model *m = l->model;
    uint32_t q = 0, v = 0;
    for (uint32_t i = 0; i < d->bodies; i++) {
        struct tfa_body *b = &l->body[i];
        round_body(b, &l->quad[i].xform, d, i);
        emit_parts(l, d, i);
        l->without_payload[i] = d->body[i].sum;
        b->q = q;
        b->v = v;
        q += b->base ? 0 : joint_coordinates(b->kind, b->n);
        v += b->n;
        b->joint_nd = b->n > 1 ? (int32_t)m->joints_nd++ : -1;
        b->tree = b->parent < 0 ? (int32_t)i : l->body[b->parent].tree;
        b->depth = b->parent < 0 ? 1 : l->body[b->parent].depth + 1;
        m->depth = b->depth > m->depth ? b->depth : m->depth;
        m->trees += b->parent < 0;
        m->base_freedoms = b->base ? 6 : m->base_freedoms;
    }
    l->without_payload[d->bodies] = d->world.sum;
    m->mass_without_payload = d->mass;
    m->inner_q = q;
    m->freedoms = v + d->modes;
    mark_ends(l);
}

/* A joint with n freedoms is a path of n nodes. */
void tfa_emit_freedoms(struct layout *l)
{
    struct tfa_model *m = l->model;
    size_t row = 0;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &l->body[i];
        for (uint32_t k = 0; k < b->n; k++) {
            uint32_t j = b->v + k;
            int32_t up = -1;
            if (k > 0)
                up = (int32_t)(j - 1);
            else if (b->parent >= 0)
                up = (int32_t)(l->body[b->parent].v + l->body[b->parent].n - 1u);
            l->dof_parent[j] = up;
            l->dof_depth[j] = up < 0 ? 0 : l->dof_depth[up] + 1;
            l->dof_row[j] = row;
            row += l->dof_depth[j] + 1;
            if (l->dof_depth[j] + 1 > m->depth_freedoms)
                m->depth_freedoms = l->dof_depth[j] + 1;
        }
    }
    m->mass_entries = row;
}

/* The main chain of each tree: the path to its deepest body, the first one where several are. */
void tfa_emit_chains(struct layout *l)
{
    const uint32_t bodies = l->model->bodies;
    uint32_t trees = 0, end;
    uint32_t *at = l->chain_body;
    for (uint32_t root = 0; root < bodies; root = end) {
        uint32_t tip = root;
        for (end = root + 1; end < bodies && l->body[end].parent >= 0; end++)
            if (l->body[end].depth > l->body[tip].depth)
                tip = end;
        struct tfa_chain *c = &l->chain[trees++];
        c->first = root;
        c->end = end;
        c->length = l->body[tip].depth;
        c->body = at;
        for (int32_t i = (int32_t)tip; i >= 0; i = l->body[i].parent)
            at[l->body[i].depth - 1] = (uint32_t)i;
        at += c->length;
    }
}
