/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Segments side by side: what is kept of them, and the constants of their bodies in lane order.
 */
#ifndef TFA_KERNEL_STRIPS_PLACE_H
#define TFA_KERNEL_STRIPS_PLACE_H

#include <string.h>

#include "kernel/sentinel_limit.h"
#include "kernel/strips.h"
#include "kernel/table.h"
#include "model/arena.h"
#include "spatial/spatial.h"

/* Constants of the bodies at one step, one in each lane */
struct rib {
    mat3 E;
    vec3 r;
    num mass;
    vec3 h;
    sym3 I;
    num damping;
    num floor;                /* smallest D that is safe (sentinel.h) */
    uint32_t from[NUM_LANES]; /* where q, v, tau and qdd of their joints stand in a request */
};

/* What is kept of a step */
struct step {
    place X;
    svec v;
    svec U;
    num Dinv, u;
    num psi[6];
};

struct strips {
    const tfa_model *m;
    struct tfa_strips cut;
    uint32_t groups, steps; /* steps of the longest segment */
    const struct tfa_kernel *one;
    void *segments; /* of that kernel */
    struct tfa_strip_ends *ends;
    num *length;                       /* [group] */
    struct rib *rib;                   /* [group][step] */
    struct step *step;                 /* [group][step] */
    num *q, *qd, *tau, *sine, *cosine; /* [group][step] */
    num_mask *finite;                  /* [group] */
    num *margin;                       /* [group] below zero where the sentinel trips */
    /* the request under way */
    const tfa_request *request;
    tfa_reply *reply;
    uint32_t state;
    int moving;
    int again; /* the second time inward */
};

/* ---- set up ---- */

static inline size_t strips_walk(const tfa_model *m, const struct tfa_kernel *one, void *base,
                                 struct strips **out)
{
    struct arena a = {base, 0};
    const struct tfa_strips cut = tfa_cut_strips(m);
    const uint32_t groups = cut.count / NUM_LANES;
    const size_t n = (size_t)groups * cut.longest;
    struct strips *s = arena_take(&a, 1, sizeof *s), count_only;
    struct strips *o = s ? s : &count_only;
    *o = (struct strips){.m = m, .cut = cut, .groups = groups, .steps = cut.longest, .one = one};
    o->ends = arena_take(&a, 1, sizeof *o->ends);
    o->segments = arena_take(&a, one->strips_bytes(), 1);
    o->length = arena_take(&a, groups, sizeof(num));
    o->finite = arena_take(&a, groups, sizeof(num_mask));
    o->margin = arena_take(&a, groups, sizeof(num));
    o->rib = arena_take(&a, n, sizeof(struct rib));
    o->step = arena_take(&a, n, sizeof(struct step));
    o->q = arena_take(&a, n, sizeof(num));
    o->qd = arena_take(&a, n, sizeof(num));
    o->tau = arena_take(&a, n, sizeof(num));
    o->sine = arena_take(&a, n, sizeof(num));
    o->cosine = arena_take(&a, n, sizeof(num));
    *out = s;
    return a.used;
}

static inline size_t strips_size(const tfa_model *model, const struct tfa_kernel *one)
{
    struct strips *none;
    return strips_walk(model, one, NULL, &none);
}

/* Beyond the end of its segment a lane walks unit bodies, which nobody hears of. */
static const struct tfa_body unit = {
    .E = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .mass = 1, .I = {1, 0, 0, 1, 0, 1}};

static inline void put_lane(num *vectors, const double *numbers, uint32_t count, uint32_t lane)
{
    for (uint32_t e = 0; e < count; e++)
        ((double *)vectors)[e * NUM_LANES + lane] = numbers[e];
}

static inline void fill_rib(const struct strips *s, struct rib *rib, uint32_t lane, int64_t at)
{
    const tfa_model *m = s->m;
    const struct tfa_body *b = at < 0 ? &unit : &m->body[m->chain[0].body[at]];
    put_lane(&rib->E.xx, b->E, 9, lane);
    put_lane(&rib->r.x, b->r, 3, lane);
    put_lane(&rib->mass, &b->mass, 1, lane);
    put_lane(&rib->h.x, b->h, 3, lane);
    put_lane(&rib->I.xx, b->I, 6, lane);
    put_lane(&rib->damping, at >= 0 && m->damping ? &m->damping[b->v] : &(double){0}, 1, lane);
    const double least = b->bound[0] * ((double)NUM_EPSILON / SENTINEL_LIMIT);
    put_lane(&rib->floor, &least, 1, lane);
    rib->from[lane] = at < 0 ? 0 : m->freedom[b->v].from;
}

static inline struct strips *strips_init(const tfa_model *model, const struct tfa_kernel *one,
                                         void *memory)
{
    struct strips *s;
    memset(memory, 0, strips_size(model, one));
    (void)strips_walk(model, one, memory, &s);
    s->ends->count = s->cut.count;
    for (uint32_t g = 0; g < s->groups; g++)
        for (uint32_t lane = 0; lane < NUM_LANES; lane++) {
            const uint32_t k = g * NUM_LANES + lane;
            const double length = s->cut.length[k];
            put_lane(&s->length[g], &length, 1, lane);
            for (uint32_t t = 0; t < s->steps; t++)
                fill_rib(s, &s->rib[(size_t)g * s->steps + t], lane,
                         t < s->cut.length[k] ? (int64_t)s->cut.first[k] + t : -1);
        }
    return s;
}

#endif
