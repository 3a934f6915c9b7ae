/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What passes between the lanes of a step and those of its parents and children (join.h).
 */
#ifndef TFA_KERNEL_PACKED_JOIN_H
#define TFA_KERNEL_PACKED_JOIN_H

#include "kernel/body.h"

typedef double shared_double __attribute__((may_alias));
typedef num shared_num __attribute__((may_alias));

/* The body whose numbers lane l has at step i; any where it has none */
TFA_INLINE uint32_t body_in_lane(const struct state *s, uint32_t i, uint32_t l)
{
    const uint32_t body = s->body[i].holds.lane[l];
    return body == UINT32_MAX ? 0 : body;
}

/* n numbers of every lane, from where they stand in an array of structures of n numbers */
static inline void collect(void *out, const void *array, uint32_t n, const struct slots *from)
{
    const shared_double *at[NUM_LANES];
    for (int l = 0; l < NUM_LANES; l++)
        at[l] =
            (const shared_double *)array + (size_t)from->step[l] * n * NUM_LANES + from->lane[l];
    for (uint32_t e = 0; e < n; e++) {
        num x;
        for (int l = 0; l < NUM_LANES; l++)
            x[l] = at[l][e * NUM_LANES];
        ((shared_num *)out)[e] = x;
    }
}

/* world in the lanes of roots, x in the others */
static inline svec rooted(const terms *b, svec world, svec x)
{
    const num_mask m = b->roots;
    return (svec){{num_select(m, world.w.x, x.w.x), num_select(m, world.w.y, x.w.y),
                   num_select(m, world.w.z, x.w.z)},
                  {num_select(m, world.v.x, x.v.x), num_select(m, world.v.y, x.v.y),
                   num_select(m, world.v.z, x.v.z)}};
}

static inline svec parent_motion(const terms *b, const svec *motion, svec world)
{
    if (b->parent < 0)
        return world;
    svec x;
    if (b->how == JOIN_STRAIGHT)
        x = motion[b->parent];
    else
        collect(&x, motion, 6, &b->from);
    return b->mixed ? rooted(b, world, x) : x;
}

static inline svec moved_along(const struct state *s, uint32_t i, const terms *b)
{
    if (b->parent < 0)
        return sv_zero();
    const svec x = motion_down(s, i, b, parent_motion(b, s->v, sv_zero()));
    return b->mixed ? rooted(b, sv_zero(), x) : x;
}

static inline void give_inertia(struct state *s, uint32_t i, const sym6 *up, int what)
{
    if (what & FOLD_FRESH)
        s->IA[i] = *up;
    else
        s6_add(&s->IA[s->body[i].parent], up);
}

static inline void give_force(struct state *s, uint32_t i, svec up, int what)
{
    if (what & FOLD_FRESH)
        s->pA[i] = up;
    else
        s->pA[s->body[i].parent] = sv_add(s->pA[s->body[i].parent], up);
}

/* One lane of n numbers, in every lane */
static inline void spread(num *out, const void *array, uint32_t n, const struct slot *from)
{
    const shared_double *at =
        (const shared_double *)array + (size_t)from->step * n * NUM_LANES + from->lane;
#pragma GCC unroll 21
    for (uint32_t e = 0; e < n; e++)
        out[e] = num_of(at[e * NUM_LANES]);
}

/* out, but in the lanes of a fork the sum of what its children gave, in the order in which bodies
 * are folded */
static inline void take_fork(num *out, const void *array, uint32_t n, const struct fork *f,
                             const struct slot *child)
{
    num sum[21], more[21];
    spread(sum, array, n, child);
    for (uint32_t k = 1; k < f->count; k++) {
        spread(more, array, n, child + k);
#pragma GCC unroll 21
        for (uint32_t e = 0; e < n; e++)
            sum[e] += more[e];
    }
#pragma GCC unroll 21
    for (uint32_t e = 0; e < n; e++)
        out[e] = num_select(f->lanes, sum[e], out[e]);
}

/* n numbers from the children of every lane. Lanes without any get -0, which changes nothing when it
 * is added. */
static inline void take_given(num *out, const struct state *s, const terms *b, const void *array,
                              uint32_t n)
{
    const shared_num *straight = (const shared_num *)array + (size_t)b->child * n;
#pragma GCC unroll 21
    for (uint32_t e = 0; e < n; e++) {
        const num all = straight[e];
        out[e] = num_select(b->without, -num_of(0), all);
    }
    for (uint32_t k = 0; k < b->forks; k++) {
        const struct fork *f = &s->fork[b->fork + k];
        take_fork(out, array, n, f, s->child + f->first);
    }
}

static __attribute__((noinline)) void take_inertia(num *out, const struct state *s, const terms *b)
{
    take_given(out, s, b, s->IA, 21);
}

static __attribute__((noinline)) void take_force(num *out, const struct state *s, const terms *b)
{
    take_given(out, s, b, s->pA, 6);
}

static inline void add_given_inertia(const struct state *s, uint32_t i, sym6 *I)
{
    const terms *b = &s->body[i];
    sym6 sum;
    if (b->handed) {
        s6_add(I, &s->IA[b->child]);
        return;
    }
    take_inertia(&sum.A.xx, s, b);
    s6_add(I, &sum);
}

static inline svec given_force(const struct state *s, uint32_t i)
{
    const terms *b = &s->body[i];
    svec sum;
    if (b->handed)
        return s->pA[b->child];
    take_force(&sum.w.x, s, b);
    return sum;
}

#endif
