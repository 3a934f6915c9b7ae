/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Segments in SIMD lanes: their memory, and the constants of their bodies in lane order.
 */
#ifndef TFA_DYNAMICS_SIMD_SEGMENT_LANES_LAYOUT_H
#define TFA_DYNAMICS_SIMD_SEGMENT_LANES_LAYOUT_H

#include <string.h>

#include "dynamics/core/sentinel_limit.h"
#include "dynamics/scan/segment_boundary.h"
#include "interface/kernel_table.h"
#include "model/arena.h"
#include "spatial/spatial.h"

/* Constants of the bodies at one step, one in each lane */
struct body_constants {
    mat3 E;
    vec3 r;
    num mass;
    vec3 h;
    sym3 I;
    num damping, friction;
    num outboard;             /* of a rotation (model/sizes.h) */
    uint32_t from[NUM_LANES]; /* where q, v, tau and qdd of their joints stand in a request */
};

/* Factors of a step */
struct step {
    xform X;
    svec v;
    svec U;
    num Dinv, u;
    num psi[6];
};

struct segment_lanes {
    const tfa_model *m;
    struct tfa_chain_segments cut;
    uint32_t groups, steps; /* steps of the longest segment */
    const struct tfa_kernel *scalar_kernel;
    void *scan; /* of that kernel */
    struct tfa_segment_boundary *boundary;
    num *length;                           /* [group] */
    struct body_constants *body_constants; /* [group][step] */
    struct step *step;                     /* [group][step] */
    num *q, *qd, *tau, *sine, *cosine;     /* [group][step] */
    num_mask *finite;                      /* [group] */
    num *margin;                           /* [group] below zero where the sentinel trips */
    /* the request under way */
    const tfa_request *request;
    tfa_reply *reply;
    uint32_t state;
    int moving;
    int second_pass; /* the second time inward */
};

/* ---- set up ---- */

static inline size_t segment_lanes_walk(const tfa_model *m, const struct tfa_kernel *scalar_kernel,
                                        void *base, struct segment_lanes **out)
{
    struct arena a = {base, 0};
    const struct tfa_chain_segments cut = tfa_cut_segments(m);
    const uint32_t groups = cut.count / NUM_LANES;
    const size_t n = (size_t)groups * cut.longest;
    struct segment_lanes *s = arena_alloc(&a, 1, sizeof *s), count_only;
    struct segment_lanes *o = s ? s : &count_only;
    *o = (struct segment_lanes){
        .m = m, .cut = cut, .groups = groups, .steps = cut.longest, .scalar_kernel = scalar_kernel};
    o->boundary = arena_alloc(&a, 1, sizeof *o->boundary);
    o->scan = arena_alloc(&a, scalar_kernel->segment_scan_bytes(), 1);
    o->length = arena_alloc(&a, groups, sizeof(num));
    o->finite = arena_alloc(&a, groups, sizeof(num_mask));
    o->margin = arena_alloc(&a, groups, sizeof(num));
    o->body_constants = arena_alloc(&a, n, sizeof(struct body_constants));
    o->step = arena_alloc(&a, n, sizeof(struct step));
    o->q = arena_alloc(&a, n, sizeof(num));
    o->qd = arena_alloc(&a, n, sizeof(num));
    o->tau = arena_alloc(&a, n, sizeof(num));
    o->sine = arena_alloc(&a, n, sizeof(num));
    o->cosine = arena_alloc(&a, n, sizeof(num));
    *out = s;
    return a.used;
}

static inline size_t segment_lanes_size(const tfa_model *model,
                                        const struct tfa_kernel *scalar_kernel)
{
    struct segment_lanes *none;
    return segment_lanes_walk(model, scalar_kernel, NULL, &none);
}

/* Beyond the end of its segment a lane walks unit bodies, which are never read. */
static const struct tfa_body unit = {
    .E = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .mass = 1, .I = {1, 0, 0, 1, 0, 1}};

static inline void put_lane(num *vectors, const double *numbers, uint32_t count, uint32_t lane)
{
    for (uint32_t e = 0; e < count; e++)
        ((double *)vectors)[e * NUM_LANES + lane] = numbers[e];
}

static inline void set_body_constants(const struct segment_lanes *s,
                                      struct body_constants *body_constants, uint32_t lane,
                                      int64_t at)
{
    const tfa_model *m = s->m;
    const double none = 0;
    const struct tfa_body *b = at < 0 ? &unit : &m->body[m->chain[0].body[at]];
    put_lane(&body_constants->E.xx, b->E, 9, lane);
    put_lane(&body_constants->r.x, b->r, 3, lane);
    put_lane(&body_constants->mass, &b->mass, 1, lane);
    put_lane(&body_constants->h.x, b->h, 3, lane);
    put_lane(&body_constants->I.xx, b->I, 6, lane);
    put_lane(&body_constants->damping, at >= 0 && m->damping ? &m->damping[b->v] : &none, 1, lane);
    put_lane(&body_constants->friction, at >= 0 && m->friction ? &m->friction[b->v] : &none, 1,
             lane);
    put_lane(&body_constants->outboard, b->outboard, 1, lane);
    body_constants->from[lane] = at < 0 ? 0 : m->freedom[b->v].from;
}

static inline struct segment_lanes *
segment_lanes_init(const tfa_model *model, const struct tfa_kernel *scalar_kernel, void *memory)
{
    struct segment_lanes *s;
    memset(memory, 0, segment_lanes_size(model, scalar_kernel));
    (void)segment_lanes_walk(model, scalar_kernel, memory, &s);
    s->boundary->count = s->cut.count;
    for (uint32_t g = 0; g < s->groups; g++)
        for (uint32_t lane = 0; lane < NUM_LANES; lane++) {
            const uint32_t k = g * NUM_LANES + lane;
            const double length = s->cut.length[k];
            put_lane(&s->length[g], &length, 1, lane);
            for (uint32_t t = 0; t < s->steps; t++)
                set_body_constants(s, &s->body_constants[(size_t)g * s->steps + t], lane,
                                   t < s->cut.length[k] ? (int64_t)s->cut.first[k] + t : -1);
        }
    return s;
}

#endif
