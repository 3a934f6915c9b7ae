/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a draft to the compiled model: one block of memory, constants rounded to double.
 */
#include "model/compile/compile.h"

#include <string.h>

#include "model/arena.h"
#include "model/compile/emit.h"
#include "model/hash.h"
#include "model/mass_properties.h"

static size_t text_size(const tfa_description *s)
{
    size_t n = strlen(s->name ? s->name : "") + 1;
    for (size_t k = 0; k < s->link_count; k++)
        n += strlen(s->links[k].name) + 1;
    for (size_t k = 0; k < s->joint_count; k++)
        n += strlen(s->joints[k].name) + 1;
    return n;
}

static uint32_t count_freedoms(const struct draft *d)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < d->bodies; i++)
        n += d->body[i].n;
    return n;
}

static uint32_t count_followers(const struct draft *d)
{
    uint32_t n = 0;
    for (size_t j = 0; j < d->description->joint_count; j++)
        n += d->joint[j].fate == TFA_FATE_FOLLOWS;
    return n;
}

/* Walked once to count and once to place. */
static struct layout layout_of(const struct draft *d, void *memory)
{
    struct arena a = {memory, 0};
    struct layout l;
    const uint32_t freedoms = count_freedoms(d);
    l.model = arena_alloc(&a, 1, sizeof *l.model);
    l.body = arena_alloc(&a, d->bodies, sizeof *l.body);
    l.quad = arena_alloc(&a, d->bodies, sizeof *l.quad);
    l.without_payload = arena_alloc(&a, d->bodies + 1u, sizeof *l.without_payload);
    l.frame = arena_alloc(&a, d->frames, sizeof *l.frame);
    l.frame_quad = arena_alloc(&a, d->frames, sizeof *l.frame_quad);
    l.chain = arena_alloc(&a, d->bodies, sizeof *l.chain);
    l.chain_body = arena_alloc(&a, d->bodies, sizeof *l.chain_body);
    l.part = arena_alloc(&a, d->parts, sizeof *l.part);
    l.part_quad = arena_alloc(&a, d->parts, sizeof *l.part_quad);
    l.joint = arena_alloc(&a, d->joints, sizeof *l.joint);
    l.declared = arena_alloc(&a, d->description->joint_count, sizeof *l.declared);
    l.body_info = arena_alloc(&a, d->bodies, sizeof *l.body_info);
    l.coordinate = arena_alloc(&a, (size_t)d->bodies + freedoms, sizeof *l.coordinate);
    l.freedom = arena_alloc(&a, freedoms, sizeof *l.freedom);
    l.mimic = arena_alloc(&a, count_followers(d), sizeof *l.mimic);
    l.armature = arena_alloc(&a, freedoms, sizeof *l.armature);
    l.damping = arena_alloc(&a, freedoms, sizeof *l.damping);
    l.dof_parent = arena_alloc(&a, freedoms, sizeof *l.dof_parent);
    l.dof_depth = arena_alloc(&a, freedoms, sizeof *l.dof_depth);
    l.dof_row = arena_alloc(&a, freedoms, sizeof *l.dof_row);
    l.text = arena_alloc(&a, text_size(d->description), 1);
    l.size = a.used;
    return l;
}

static void bind(struct layout *l, const struct draft *d)
{
    struct tfa_model *m = l->model;
    m->bodies = d->bodies;
    m->frames = d->frames;
    m->joints = d->joints;
    m->q_count = d->q_count;
    m->v_count = d->v_count;
    m->body = l->body;
    m->without_payload = l->without_payload;
    m->frame = l->frame;
    m->frame_quad = l->frame_quad;
    m->chain = l->chain;
    m->part = l->part;
    m->part_quad = l->part_quad;
    m->joint = l->joint;
    m->declared = l->declared;
    m->body_info = l->body_info;
    m->coordinate = l->coordinate;
    m->freedom = l->freedom;
    m->mimic = l->mimic;
    m->armature = l->armature;
    m->damping = d->options->damping ? l->damping : NULL;
    m->dof_parent = l->dof_parent;
    m->dof_depth = l->dof_depth;
    m->dof_row = l->dof_row;
}

static void count_fates(tfa_model_summary *s, const struct tfa_model *m)
{
    for (uint32_t k = 0; k < m->declared_joints; k++) {
        const tfa_fate fate = m->declared[k].fate;
        s->fixed += fate == TFA_FATE_FIXED;
        s->locked += fate == TFA_FATE_LOCKED;
        s->fused += fate == TFA_FATE_FUSED;
        s->follows += fate == TFA_FATE_FOLLOWS;
        s->absent += fate == TFA_FATE_ABSENT;
    }
}

static void summarise(struct tfa_model *m, const struct draft *d)
{
    tfa_model_summary *s = &m->summary;
    s->links = (uint32_t)d->description->link_count;
    s->joints = (uint32_t)d->description->joint_count;
    s->bodies = m->bodies;
    s->q_count = m->q_count;
    s->v_count = m->v_count;
    s->depth = m->depth;
    s->base = m->base;
    s->mimics = m->mimics;
    memcpy(s->gravity, m->gravity, sizeof s->gravity);
    for (uint32_t t = 0; t < m->trees; t++)
        if (m->chain[t].length > s->main_chain)
            s->main_chain = m->chain[t].length;
    count_fates(s, m);
}

size_t tfa_compiled_size(const struct draft *d)
{
    return layout_of(d, NULL).size;
}

const struct tfa_model *tfa_compile(const struct draft *d, void *memory)
{
    static const tfa_scene whole = {0};
    static const double standard[3] = {0, 0, -9.80665};
    const tfa_scene *scene = d->options->scene ? d->options->scene : &whole;
    struct layout l = layout_of(d, memory);
    struct tfa_model *m = l.model;
    memset(memory, 0, l.size);
    memcpy(m->gravity, d->options->gravity ? d->options->gravity : standard, sizeof standard);
    m->base = d->options->base;
    bind(&l, d);
    tfa_emit_bodies(&l, d);
    tfa_emit_freedoms(&l);
    tfa_emit_chains(&l);
    tfa_emit_maps(&l, d);
    tfa_emit_names(&l, d);
    summarise(m, d);
    tfa_compute_mass_properties(m, l.body, l.quad, l.body_info, d->mass_scratch, scene->payloads,
                                scene->payload_count);
    tfa_hash_model(m);
    return m;
}
