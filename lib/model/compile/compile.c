/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Compilation of a draft: memory, order of the passes, summary.
 */
#include "model/compile/compile.h"

#include <string.h>

#include "model/arena.h"
#include "model/hash.h"
#include "model/mass_properties.h"

static size_t text_size(const struct draft *d)
{
    const tfa_description *s = d->description;
    size_t n = strlen(s->name ? s->name : "") + 1;
    for (size_t k = 0; k < s->link_count; k++)
        n += strlen(s->links[k].name) + 1;
    for (size_t k = 0; k < s->joint_count; k++)
        n += strlen(s->joints[k].name) + 1;
    for (size_t k = 0; k < d->constraints; k++)
        n += strlen(d->constraint[k]->name) + 1;
    return n;
}

static uint32_t count_freedoms(const struct draft *d)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < d->bodies; i++)
        n += d->body[i].n;
    return n + d->modes;
}

static uint32_t count_followers(const struct draft *d)
{
    uint32_t n = 0;
    for (size_t j = 0; j < d->description->joint_count; j++)
        n += d->joint[j].fate == TFA_FATE_FOLLOWS;
    return n;
}

/* One walk gives the size (memory NULL) or the pointers. The model comes first. */
static struct layout layout_of(const struct draft *d, void *memory)
{
    struct arena a = {memory, 0};
    struct layout l;
    const uint32_t freedoms = count_freedoms(d), followers = count_followers(d);
    l.model = arena_alloc(&a, 1, sizeof *l.model);
#define PLACE(type, name, count) l.name = arena_alloc(&a, count, sizeof *l.name);
    TFA_MODEL_ARRAYS(PLACE)
#undef PLACE
    l.quad = arena_alloc(&a, d->bodies, sizeof *l.quad);
    l.link_quad = arena_alloc(&a, d->frames, sizeof *l.link_quad);
    l.chain_body = arena_alloc(&a, d->bodies, sizeof *l.chain_body);
    l.modal = arena_alloc(&a, tfa_modal_numbers(d), sizeof *l.modal);
    l.text = arena_alloc(&a, text_size(d), 1);
    l.size = a.used;
    return l;
}

static void bind(struct layout *l, const struct draft *d)
{
    struct tfa_model *m = l->model;
#define BIND(type, name, count) m->name = l->name;
    TFA_MODEL_ARRAYS(BIND)
#undef BIND
    m->damping = d->options->damping ? l->damping : NULL;
    m->friction = d->options->friction ? l->friction : NULL;
    m->friction_velocity =
        d->options->friction_velocity > 0 ? d->options->friction_velocity : TFA_FRICTION_VELOCITY;
    m->bodies = d->bodies;
    m->frames = d->frames;
    m->joints = d->joints;
    m->q_count = d->q_count;
    m->v_count = d->v_count;
    m->flexible_bodies = d->flexible_bodies;
    m->handles = d->handles;
    m->constraints = d->constraints;
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
    tfa_compute_links(m, l.link, l.link_quad, scene->payloads, scene->payload_count);
    tfa_emit_modes(&l, d);
    tfa_hash_model(m);
    return m;
}
