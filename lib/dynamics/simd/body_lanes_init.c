/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a schedule to a state: constants of several bodies in lane order, and how each lane finds
 * its parent, its children and its numbers of a request. Done once, when a workspace is made.
 */
#include "dynamics/simd/body_lanes_init.h"

#define NO_BODY UINT32_MAX

/* State of the walk over a schedule */
struct lane_builder {
    struct state *s;
    const struct tfa_lane_schedule *p;
    uint32_t step, branches;
};

static uint32_t coordinates_of(const struct tfa_body *b)
{
    return b->base ? 0 : joint_coordinates(b->kind, b->n);
}

static const int32_t *row_of(const struct tfa_lane_schedule *p, uint32_t step)
{
    return p->body + (size_t)step * p->lanes;
}

/* Some body of the step: repeated by lanes without one */
static uint32_t first_of(const struct tfa_lane_schedule *p, uint32_t step)
{
    const int32_t *row = row_of(p, step);
    while (*row < 0)
        row++;
    return (uint32_t)*row;
}

struct extent TFA_V(body_lanes_extent)(const struct tfa_model *m, const struct tfa_lane_schedule *p)
{
    struct extent n = {.bodies = p->steps};
    for (uint32_t k = 0; k < p->steps; k++) {
        const struct tfa_body *b = &m->body[first_of(p, k)];
        n.coordinates += coordinates_of(b);
        n.freedoms += b->n;
    }
    return n;
}

/* ---- step and lane of each body ---- */

static void find_lanes(struct state *s, const struct tfa_lane_schedule *p)
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
static uint32_t body_in_step_before(const struct lane_builder *k, uint32_t l)
{
    return k->step ? k->s->lane_constants[k->step - 1].lane_body.lane[l] : NO_BODY;
}

/* Which body lane l of the step takes its constants from: its own, else one whose parent it holds
 * already, else any. */
static uint32_t body_for_lane(const struct lane_builder *k, uint32_t l)
{
    const int32_t *row = row_of(k->p, k->step);
    if (row[l] >= 0)
        return (uint32_t)row[l];
    for (uint32_t e = 0; e < NUM_LANES; e++)
        if (row[e] >= 0 && k->s->m->body[row[e]].parent >= 0 &&
            (uint32_t)k->s->m->body[row[e]].parent == body_in_step_before(k, l))
            return (uint32_t)row[e];
    return first_of(k->p, k->step);
}

/* ---- constants ---- */

static void set_lane_constants(body_constants *t, uint32_t l, const struct tfa_body *b)
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
    for (int k = 0; k < 2; k++)
        t->outboard[k][l] = b->outboard[k];
}

/* Constants that are the same in all lanes */
static void set_common_constants(body_constants *t, const struct tfa_body *b)
{
    t->has_armature = b->armature > 0;
    t->axial = b->axial;
    t->kind = b->kind;
    t->n = b->n;
    t->base = b->base;
    t->joint_nd = b->joint_nd;
    t->part = b->part;
    t->freedom = b->v;
}

/* ---- parents ---- */

static void find_parents(struct lane_builder *k, const uint32_t *of)
{
    const struct tfa_model *m = k->s->m;
    const int32_t *row = row_of(k->p, k->step);
    body_constants *t = &k->s->lane_constants[k->step];
    int32_t step = -1;
    int same_lane = 1;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const int32_t parent = m->body[of[l]].parent;
        t->roots[l] = parent < 0 ? -1 : 0;
        t->has_roots |= parent < 0;
        t->from.step[l] = parent < 0 ? 0 : k->s->step_of[parent];
        t->from.lane[l] = parent < 0 ? 0 : k->s->lane_of[parent];
        if (parent < 0)
            continue;
        step = (int32_t)t->from.step[l];
        if (row[l] >= 0 &&
            ((uint32_t)step + 1 != k->step || body_in_step_before(k, l) != (uint32_t)parent))
            same_lane = 0;
    }
    t->source_kind = same_lane ? SOURCE_SAME_LANE : SOURCE_SCATTERED;
    t->parent = same_lane && step >= 0 ? (int32_t)k->step - 1 : step;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const int32_t parent = m->body[of[l]].parent;
        const int found = parent < 0 || !same_lane || body_in_step_before(k, l) == (uint32_t)parent;
        t->lane_body.lane[l] = found ? of[l] : NO_BODY;
    }
}

/* ---- children ---- */

/* The children of every body, in the order of the inward pass: the last one first. */
static void list_children(struct state *s)
{
    const struct tfa_model *m = s->m;
    uint32_t start = 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        if (m->body[i].parent >= 0)
            s->children[m->body[i].parent]++;
    for (uint32_t i = 0; i < m->bodies; i++) {
        s->first_child[i] = start;
        start += s->children[i];
        s->children[i] = 0;
    }
    for (uint32_t i = m->bodies; i-- > 0;) {
        const int32_t parent = m->body[i].parent;
        if (parent >= 0)
            s->child[s->first_child[parent] + s->children[parent]++] =
                (struct lane_ref){s->step_of[i], s->lane_of[i]};
    }
}

/* Whether the only child of body i is in lane l of the next step */
static int child_in_same_lane(const struct state *s, uint32_t i, uint32_t l, uint32_t step)
{
    const struct lane_ref *child = &s->child[s->first_child[i]];
    return s->children[i] == 1 && child->step == step + 1 && child->lane == l;
}

/* Children of the body i of a lane, if not in the same lane of the next step */
static void add_branch(struct lane_builder *k, uint32_t i, uint32_t l)
{
    struct state *s = k->s;
    body_constants *t = &s->lane_constants[k->step];
    struct branch *f = s->branch + t->branch;
    while (f < s->branch + t->branch + t->branches && f->first != s->first_child[i])
        f++; /* another lane that holds the same body */
    if (f == s->branch + t->branch + t->branches) {
        f->first = s->first_child[i];
        f->count = s->children[i];
        t->branches++;
        k->branches++;
    }
    f->lanes[l] = -1;
}

/* Lanes without a body may hold anything. */
static void find_children(struct lane_builder *k)
{
    struct state *s = k->s;
    body_constants *t = &s->lane_constants[k->step];
    t->children_in_lane = t->leaf = 1;
    t->branch = k->branches;
    t->child = k->step + 1;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const uint32_t i = t->lane_body.lane[l];
        if (i == NO_BODY)
            continue;
        const int same_lane = child_in_same_lane(s, i, l, k->step);
        if (s->children[i])
            t->leaf = 0;
        if (!same_lane)
            t->children_in_lane = 0;
        t->other_lanes[l] = same_lane ? 0 : -1;
        if (s->children[i] && !same_lane)
            add_branch(k, i, l);
    }
}

/* ---- numbers of a request ---- */

/* Public numbers of one step, and which of its lanes write results */
static void find_request_indices(struct lane_builder *k, const uint32_t *of, uint32_t q, uint32_t v)
{
    struct state *s = k->s;
    const struct tfa_model *m = s->m;
    const struct tfa_body *first = &m->body[of[0]];
    s->lane_constants[k->step].q = q;
    s->lane_constants[k->step].v = v;
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
            f->lane_mask |= (uint32_t)(row_of(k->p, k->step)[l] >= 0) << l;
            s->lane_damping[v + e][l] = m->damping ? m->damping[j] : 0;
            s->lane_friction[v + e][l] = m->friction ? m->friction[j] : 0;
        }
    }
}

/* ---- all of it ---- */

static void build_step(struct lane_builder *k, uint32_t q, uint32_t v)
{
    uint32_t of[NUM_LANES];
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        of[l] = body_for_lane(k, l);
        set_lane_constants(&k->s->lane_constants[k->step], l, &k->s->m->body[of[l]]);
    }
    set_common_constants(&k->s->lane_constants[k->step], &k->s->m->body[of[0]]);
    find_parents(k, of);
    find_request_indices(k, of, q, v);
}

struct state *TFA_V(body_lanes_init)(const struct tfa_model *m, const struct tfa_lane_schedule *p,
                                     void *memory)
{
    struct state *s = state_init(m, TFA_V(body_lanes_extent)(m, p), memory);
    struct lane_builder k = {.s = s, .p = p};
    s->body = s->lane_constants;
    s->coordinate = s->coordinates_of;
    s->freedom = s->freedoms_of;
    find_lanes(s, p);
    for (uint32_t q = 0, v = 0; k.step < p->steps; k.step++) {
        build_step(&k, q, v);
        const struct tfa_body *b = &m->body[first_of(p, k.step)];
        q += coordinates_of(b);
        v += b->n;
    }
    list_children(s);
    for (k.step = 0; k.step < p->steps; k.step++)
        find_children(&k);
    return s;
}
