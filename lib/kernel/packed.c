/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a packing to a state: constants of several bodies in lane order, and how each lane finds its
 * parent, its children and its numbers of a request. Done once, when a workspace is made.
 */
#include "kernel/packed.h"

#define NOBODY UINT32_MAX

/* What is read and written while a packing is walked. */
struct packer {
    struct state *s;
    const struct tfa_packing *p;
    uint32_t step, forks;
};

static uint32_t coordinates_of(const struct tfa_body *b)
{
    return b->base ? 0 : joint_coordinates(b->kind, b->n);
}

static const int32_t *row_of(const struct tfa_packing *p, uint32_t step)
{
    return p->body + (size_t)step * p->lanes;
}

/* Some body that stands in the step: what lanes without one repeat */
static uint32_t first_of(const struct tfa_packing *p, uint32_t step)
{
    const int32_t *row = row_of(p, step);
    while (*row < 0)
        row++;
    return (uint32_t)*row;
}

struct extent TFA_V(packed_extent)(const struct tfa_model *m, const struct tfa_packing *p)
{
    struct extent n = {p->steps, 0, 0, 0};
    for (uint32_t k = 0; k < p->steps; k++) {
        const struct tfa_body *b = &m->body[first_of(p, k)];
        n.coordinates += coordinates_of(b);
        n.freedoms += b->n;
    }
    return n;
}

/* ---- who stands where ---- */

static void find_places(struct state *s, const struct tfa_packing *p)
{
    for (uint32_t k = 0; k < p->steps; k++)
        for (uint32_t l = 0; l < NUM_LANES; l++) {
            const int32_t i = row_of(p, k)[l];
            if (i < 0)
                continue;
            s->step_of[i] = k;
            s->lane_of[i] = l;
        }
}

/* The body whose numbers lane l had in the step before */
static uint32_t held_before(const struct packer *k, uint32_t l)
{
    return k->step ? k->s->packed[k->step - 1].holds.lane[l] : NOBODY;
}

/* Which body lane l of the step takes its constants from: its own, else one whose parent it holds
 * already, else any. */
static uint32_t body_for(const struct packer *k, uint32_t l)
{
    const int32_t *row = row_of(k->p, k->step);
    if (row[l] >= 0)
        return (uint32_t)row[l];
    for (uint32_t e = 0; e < NUM_LANES; e++)
        if (row[e] >= 0 && k->s->m->body[row[e]].parent >= 0 &&
            (uint32_t)k->s->m->body[row[e]].parent == held_before(k, l))
            return (uint32_t)row[e];
    return first_of(k->p, k->step);
}

/* ---- constants ---- */

static void put_constants(terms *t, uint32_t l, const struct tfa_body *b)
{
    num *E = &t->T.E.xx, *r = &t->T.r.x, *h = &t->h.x, *I = &t->I.xx;
    for (int e = 0; e < 9; e++)
        E[e][l] = b->E[e];
    for (int e = 0; e < 3; e++) {
        r[e][l] = b->r[e];
        h[e][l] = b->h[e];
    }
    for (int e = 0; e < 6; e++)
        I[e][l] = b->I[e];
    t->mass[l] = b->mass;
    t->armature[l] = b->armature;
    t->d[l] = b->d;
    for (int k = 0; k < 6; k++)
        t->bound[k][l] = b->bound[k];
}

/* What is the same in all lanes */
static void put_kind(terms *t, const struct tfa_body *b)
{
    t->geared = b->armature > 0;
    t->axial = b->axial;
    t->kind = b->kind;
    t->n = b->n;
    t->base = b->base;
    t->multi = b->multi;
    t->part = b->part;
    t->freedom = b->v;
}

/* ---- parents ---- */

static void find_parents(struct packer *k, const uint32_t *of)
{
    const struct tfa_model *m = k->s->m;
    const int32_t *row = row_of(k->p, k->step);
    terms *t = &k->s->packed[k->step];
    int32_t step = -1;
    int straight = 1;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const int32_t parent = m->body[of[l]].parent;
        t->roots[l] = parent < 0 ? -1 : 0;
        t->mixed |= parent < 0;
        t->from.step[l] = parent < 0 ? 0 : k->s->step_of[parent];
        t->from.lane[l] = parent < 0 ? 0 : k->s->lane_of[parent];
        if (parent < 0)
            continue;
        step = (int32_t)t->from.step[l];
        if (row[l] >= 0 && ((uint32_t)step + 1 != k->step || held_before(k, l) != (uint32_t)parent))
            straight = 0;
    }
    t->how = straight ? JOIN_STRAIGHT : JOIN_SCATTERED;
    t->parent = straight && step >= 0 ? (int32_t)k->step - 1 : step;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const int32_t parent = m->body[of[l]].parent;
        const int found = parent < 0 || !straight || held_before(k, l) == (uint32_t)parent;
        t->holds.lane[l] = found ? of[l] : NOBODY;
    }
}

/* ---- children ---- */

/* The children of every body, in the order in which they are folded: the last one first. */
static void list_children(struct state *s)
{
    const struct tfa_model *m = s->m;
    uint32_t start = 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        if (m->body[i].parent >= 0)
            s->children[m->body[i].parent]++;
    for (uint32_t i = 0; i < m->bodies; i++) {
        s->child_of[i] = start;
        start += s->children[i];
        s->children[i] = 0;
    }
    for (uint32_t i = m->bodies; i-- > 0;) {
        const int32_t parent = m->body[i].parent;
        if (parent >= 0)
            s->child[s->child_of[parent] + s->children[parent]++] =
                (struct slot){s->step_of[i], s->lane_of[i]};
    }
}

/* Is the only child of body i in lane l of the next step? */
static int is_handed(const struct state *s, uint32_t i, uint32_t l, uint32_t step)
{
    const struct slot *child = &s->child[s->child_of[i]];
    return s->children[i] == 1 && child->step == step + 1 && child->lane == l;
}

/* What the lane that holds body i takes, if not from the same lane of the next step */
static void put_fork(struct packer *k, uint32_t i, uint32_t l)
{
    struct state *s = k->s;
    terms *t = &s->packed[k->step];
    struct fork *f = s->fork + t->fork;
    while (f < s->fork + t->fork + t->forks && f->first != s->child_of[i])
        f++; /* another lane that holds the same body */
    if (f == s->fork + t->fork + t->forks) {
        f->first = s->child_of[i];
        f->count = s->children[i];
        t->forks++;
        k->forks++;
    }
    f->lanes[l] = -1;
}

/* Lanes that hold nobody may have anything. */
static void find_children(struct packer *k)
{
    struct state *s = k->s;
    terms *t = &s->packed[k->step];
    t->handed = t->leaf = 1;
    t->fork = k->forks;
    t->child = k->step + 1;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const uint32_t i = t->holds.lane[l];
        if (i == NOBODY)
            continue;
        const int straight = is_handed(s, i, l, k->step);
        if (s->children[i])
            t->leaf = 0;
        if (!straight)
            t->handed = 0;
        t->without[l] = straight ? 0 : -1;
        if (s->children[i] && !straight)
            put_fork(k, i, l);
    }
}

/* ---- numbers of a request ---- */

/* Public numbers of one step, and which of its lanes give theirs back */
static void find_numbers(struct packer *k, const uint32_t *of, uint32_t q, uint32_t v)
{
    struct state *s = k->s;
    const struct tfa_model *m = s->m;
    const struct tfa_body *first = &m->body[of[0]];
    s->packed[k->step].q = q;
    s->packed[k->step].v = v;
    if (first->base)
        return;
    for (uint32_t e = 0; e < coordinates_of(first); e++) {
        const struct tfa_coordinate *c = &m->coordinate[first->q + e];
        s->coordinates_of[q + e].multiplier = c->multiplier;
        s->coordinates_of[q + e].offset = c->offset;
        for (uint32_t l = 0; l < NUM_LANES; l++)
            s->coordinates_of[q + e].from.lane[l] = m->coordinate[m->body[of[l]].q + e].from;
    }
    for (uint32_t e = 0; e < first->n; e++) {
        freedom *f = &s->freedoms_of[v + e - m->base_freedoms];
        f->multiplier = 1;
        for (uint32_t l = 0; l < NUM_LANES; l++) {
            const uint32_t j = m->body[of[l]].v + e;
            f->from.lane[l] = m->freedom[j - m->base_freedoms].from;
            f->held |= (uint32_t)(row_of(k->p, k->step)[l] >= 0) << l;
            s->friction[v + e][l] = m->damping ? m->damping[j] : 0;
        }
    }
}

/* ---- all of it ---- */

static void pack_step(struct packer *k, uint32_t q, uint32_t v)
{
    uint32_t of[NUM_LANES];
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        of[l] = body_for(k, l);
        put_constants(&k->s->packed[k->step], l, &k->s->m->body[of[l]]);
    }
    put_kind(&k->s->packed[k->step], &k->s->m->body[of[0]]);
    find_parents(k, of);
    find_numbers(k, of, q, v);
}

struct state *TFA_V(packed_init)(const struct tfa_model *m, const struct tfa_packing *p,
                                 void *memory)
{
    struct state *s = state_init(m, TFA_V(packed_extent)(m, p), memory);
    struct packer k = {.s = s, .p = p};
    s->body = s->packed;
    s->coordinate = s->coordinates_of;
    s->freedom = s->freedoms_of;
    find_places(s, p);
    for (uint32_t q = 0, v = 0; k.step < p->steps; k.step++) {
        pack_step(&k, q, v);
        const struct tfa_body *b = &m->body[first_of(p, k.step)];
        q += coordinates_of(b);
        v += b->n;
    }
    list_children(s);
    for (k.step = 0; k.step < p->steps; k.step++)
        find_children(&k);
    return s;
}
