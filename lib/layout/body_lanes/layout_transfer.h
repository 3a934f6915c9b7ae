/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transfers between the lanes of a step and those of its parents and children (parent_transfer.h).
 */
#ifndef TFA_LAYOUT_BODY_LANES_TRANSFER_H
#define TFA_LAYOUT_BODY_LANES_TRANSFER_H

#include "layout/body.h"

typedef double aliased_double __attribute__((may_alias));
typedef num aliased_num __attribute__((may_alias));

/* The body whose numbers lane l has at step i; any where it has none */
TFA_INLINE uint32_t body_in_lane(const struct state *s, uint32_t i, uint32_t l)
{
    const uint32_t body = s->body[i].lane_body.lane[l];
    return body == UINT32_MAX ? 0 : body;
}

/* n numbers of every lane, from their places in an array of structures of n numbers */
static inline void gather_lanes(void *out, const void *array, uint32_t n,
                                const struct lane_refs *from)
{
    const aliased_double *at[NUM_LANES];
    for (int l = 0; l < NUM_LANES; l++)
        at[l] =
            (const aliased_double *)array + (size_t)from->step[l] * n * NUM_LANES + from->lane[l];
    for (uint32_t e = 0; e < n; e++) {
        num x;
        for (int l = 0; l < NUM_LANES; l++)
            x[l] = at[l][e * NUM_LANES];
        ((aliased_num *)out)[e] = x;
    }
}

/* world in the lanes of roots, x in the others */
static inline svec select_roots(const body_constants *b, svec world, svec x)
{
    const num_mask m = b->roots;
    return (svec){{num_select(m, world.w.x, x.w.x), num_select(m, world.w.y, x.w.y),
                   num_select(m, world.w.z, x.w.z)},
                  {num_select(m, world.v.x, x.v.x), num_select(m, world.v.y, x.v.y),
                   num_select(m, world.v.z, x.v.z)}};
}

/* Are the parents of all lanes of step i those of the step before it? Of the first one they are the
 * world. */
TFA_INLINE int parent_is_before(const body_constants *b, uint32_t i)
{
    return b->parent == (int32_t)i - 1 && b->source_kind == SOURCE_SAME_LANE && !b->has_roots;
}

static inline svec parent_motion(const body_constants *b, const svec *motion, svec world)
{
    if (b->parent < 0)
        return world;
    svec x;
    if (b->source_kind == SOURCE_SAME_LANE)
        x = motion[b->parent];
    else
        gather_lanes(&x, motion, 6, &b->from);
    return b->has_roots ? select_roots(b, world, x) : x;
}

static inline svec velocity_from_parent(const struct state *s, uint32_t i, const body_constants *b)
{
    if (b->parent < 0)
        return sv_zero();
    const svec x = motion_to_child(s, i, b, parent_motion(b, s->v, sv_zero()));
    return b->has_roots ? select_roots(b, sv_zero(), x) : x;
}

static inline void add_inertia_to_parent(struct state *s, uint32_t i, const sym6 *up, int flags)
{
    if (flags & ABA_FULL_SWEEP)
        s->IA[i] = *up;
    else
        s6_add(&s->IA[s->body[i].parent], up);
}

static inline void add_force_to_parent(struct state *s, uint32_t i, svec up, int flags)
{
    if (flags & ABA_FULL_SWEEP)
        s->pA[i] = up;
    else
        s->pA[s->body[i].parent] = sv_add(s->pA[s->body[i].parent], up);
}

/* One lane of n numbers, in every lane */
static inline void broadcast_lane(num *out, const void *array, uint32_t n,
                                  const struct lane_ref *from)
{
    const aliased_double *at =
        (const aliased_double *)array + (size_t)from->step * n * NUM_LANES + from->lane;
#pragma GCC unroll 21
    for (uint32_t e = 0; e < n; e++)
        out[e] = num_of(at[e * NUM_LANES]);
}

/* out, but in the lanes of a branch the sum over its children, in the order in which bodies
 * are processed inward */
static inline void sum_branch(num *out, const void *array, uint32_t n, const struct branch *f,
                              const struct lane_ref *child)
{
    num sum[21], more[21];
    broadcast_lane(sum, array, n, child);
    for (uint32_t k = 1; k < f->count; k++) {
        broadcast_lane(more, array, n, child + k);
#pragma GCC unroll 21
        for (uint32_t e = 0; e < n; e++)
            sum[e] += more[e];
    }
#pragma GCC unroll 21
    for (uint32_t e = 0; e < n; e++)
        out[e] = num_select(f->lanes, sum[e], out[e]);
}

/* n numbers from the children of every lane. Lanes without any get -0, which changes nothing when
 * it is added. */
static inline void sum_children(num *out, const struct state *s, const body_constants *b,
                                const void *array, uint32_t n)
{
    const aliased_num *same_lane = (const aliased_num *)array + (size_t)b->child * n;
#pragma GCC unroll 21
    for (uint32_t e = 0; e < n; e++) {
        const num all = same_lane[e];
        out[e] = num_select(b->other_lanes, -num_of(0), all);
    }
    for (uint32_t k = 0; k < b->branches; k++) {
        const struct branch *f = &s->branch[b->branch + k];
        sum_branch(out, array, n, f, s->child + f->first);
    }
}

static __attribute__((noinline)) void inertia_of_children(num *out, const struct state *s,
                                                          const body_constants *b)
{
    sum_children(out, s, b, s->IA, 21);
}

static __attribute__((noinline)) void force_of_children(num *out, const struct state *s,
                                                        const body_constants *b)
{
    sum_children(out, s, b, s->pA, 6);
}

static inline void add_inertia_from_children(const struct state *s, uint32_t i, sym6 *I)
{
    const body_constants *b = &s->body[i];
    sym6 sum;
    if (b->children_in_lane) {
        s6_add(I, &s->IA[b->child]);
        return;
    }
    inertia_of_children(&sum.A.xx, s, b);
    s6_add(I, &sum);
}

static inline svec force_from_children(const struct state *s, uint32_t i)
{
    const body_constants *b = &s->body[i];
    svec sum;
    if (b->children_in_lane)
        return s->pA[b->child];
    force_of_children(&sum.w.x, s, b);
    return sum;
}

/* Up to its parent, which reads it later */
static inline void add_total_force_to_parent(struct state *s, uint32_t i, svec up)
{
    s->pA[i] = up;
}

/* f_i += those of its children, one by one in the order in which bodies are processed inward */
static inline void add_total_forces_of_children(struct state *s, uint32_t i)
{
    const body_constants *b = &s->body[i];
    const num *same_lane = &s->pA[b->child].w.x;
    num *f = &s->f[i].w.x, more[6];
    if (b->leaf)
        return;
    for (uint32_t e = 0; e < 6; e++)
        f[e] = num_select(b->other_lanes, f[e], f[e] + same_lane[e]);
    for (const struct branch *g = s->branch + b->branch; g < s->branch + b->branch + b->branches;
         g++)
        for (uint32_t k = 0; k < g->count; k++) {
            broadcast_lane(more, s->pA, 6, s->child + g->first + k);
            for (uint32_t e = 0; e < 6; e++)
                f[e] = num_select(g->lanes, f[e] + more[e], f[e]);
        }
}

#endif
