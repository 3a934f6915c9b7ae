/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What passes between a body and its parent: motions outward, articulated inertias and forces
 * inward. One body after the other, a body adds to its parent's IA and pA. In a packed variant
 * what a step gives stays with it, and the parents' step takes it, lane by lane from where the
 * children stand; in the same order, so that the sums are the same to the bit.
 */
#ifndef TFA_KERNEL_JOIN_H
#define TFA_KERNEL_JOIN_H

#include "kernel/body.h"

/* What an inward step computes; constants at every call, so that the rest folds away.
 * FOLD_FRESH: all bodies are folded in one sweep, so that nothing need be initialised: the first
 * child to be folded stores, the others add, and the body's own terms join when its turn comes.
 * FOLD_FORCE without FOLD_INERTIA uses the factors that are there: the same operations in the same
 * order, so that the answer is the same to the bit.
 * FOLD_CUT, not with FOLD_FRESH: what the parent would get takes the place of the body's own IA and pA.
 * The parent belongs to another thread. */
enum {
    FOLD_INERTIA = 1,
    FOLD_FORCE = 2,
    FOLD_BIAS = 4,
    FOLD_FRESH = 8,
    FOLD_CUT = 16,
    FOLD_WATCH = 32
};

#if defined TFA_PACKED && defined TFA_OWN
#include "kernel/own_packed_join.h"
#elif defined TFA_PACKED
#include "kernel/packed_join.h"
#else

/* The body whose numbers lane l has at step i: i itself */
TFA_INLINE uint32_t body_in_lane(const struct state *s, uint32_t i, uint32_t l)
{
    (void)s;
    (void)l;
    return i;
}

/* A motion of the parent, in the parent's frame */
TFA_INLINE svec parent_motion(const terms *b, const svec *motion, svec world)
{
    return b->parent < 0 ? world : motion[b->parent];
}

/* X v_parent */
TFA_INLINE svec moved_along(const struct state *s, uint32_t i, const terms *b)
{
    return b->parent < 0 ? sv_zero() : motion_down(s, i, b, s->v[b->parent]);
}

TFA_INLINE void give_inertia(struct state *s, uint32_t i, const sym6 *up, int what)
{
    const terms *b = body_terms(s, i);
    if (what & FOLD_CUT)
        s->IA[i] = *up;
    else if (what & FOLD_FRESH && b->last)
        s->IA[b->parent] = *up;
    else
        s6_add(&s->IA[b->parent], up);
}

TFA_INLINE void give_force(struct state *s, uint32_t i, svec up, int what)
{
    const terms *b = body_terms(s, i);
    if (what & FOLD_CUT)
        s->pA[i] = up;
    else if (what & FOLD_FRESH && b->last)
        s->pA[b->parent] = up;
    else
        s->pA[b->parent] = sv_add(s->pA[b->parent], up);
}

/* What the children of body i, which has some, gave in a fresh sweep */
TFA_INLINE void add_given_inertia(const struct state *s, uint32_t i, sym6 *I)
{
    s6_add(I, &s->IA[i]);
}

TFA_INLINE svec given_force(const struct state *s, uint32_t i)
{
    return s->pA[i];
}

#endif
#endif
