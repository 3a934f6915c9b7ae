/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `scalar`: a body adds to the IA and pA of its parent (parent_transfer.h).
 */
#ifndef TFA_LAYOUT_SCALAR_TRANSFER_H
#define TFA_LAYOUT_SCALAR_TRANSFER_H

#include "layout/body.h"

void TFA_V(modes_add_inertia)(struct state *s, int32_t handle, const sym6 *IA);
void TFA_V(modes_add_force)(struct state *s, int32_t handle, svec pA);

/* The body whose numbers lane l has at step i: i itself */
TFA_INLINE uint32_t body_in_lane(const struct state *s, uint32_t i, uint32_t l)
{
    (void)s;
    (void)l;
    return i;
}

/* Is the parent of body i the body before it? Of the first one that is the world. */
TFA_INLINE int parent_is_before(const body_constants *b, uint32_t i)
{
    return b->parent == (int32_t)i - 1;
}

/* A motion of the parent, in the parent's frame */
TFA_INLINE svec parent_motion(const body_constants *b, const svec *motion, svec world)
{
    return b->parent < 0 ? world : motion[b->parent];
}

/* X v_parent */
TFA_INLINE svec velocity_from_parent(const struct state *s, uint32_t i, const body_constants *b)
{
    return b->parent < 0 ? sv_zero() : motion_to_child(s, i, b, s->v[b->parent]);
}

TFA_INLINE void add_inertia_to_parent(struct state *s, uint32_t i, const sym6 *up, int flags)
{
    const body_constants *b = body_constants_of(s, i);
    if (flags & ABA_DETACH)
        s->IA[i] = *up;
    else if (flags & ABA_FULL_SWEEP && b->last)
        s->IA[b->parent] = *up;
    else
        s6_add(&s->IA[b->parent], up);
    if (flags & ABA_MODES && !(flags & ABA_DETACH) && b->handle >= 0)
        TFA_V(modes_add_inertia)(s, b->handle, up);
}

TFA_INLINE void add_force_to_parent(struct state *s, uint32_t i, svec up, int flags)
{
    const body_constants *b = body_constants_of(s, i);
    if (flags & ABA_DETACH)
        s->pA[i] = up;
    else if (flags & ABA_FULL_SWEEP && b->last)
        s->pA[b->parent] = up;
    else
        s->pA[b->parent] = sv_add(s->pA[b->parent], up);
    if (flags & ABA_MODES && !(flags & ABA_DETACH) && b->handle >= 0)
        TFA_V(modes_add_force)(s, b->handle, up);
}

/* Sum over the children of body i, which has some, in a full sweep */
TFA_INLINE void add_inertia_from_children(const struct state *s, uint32_t i, sym6 *I)
{
    s6_add(I, &s->IA[i]);
}

TFA_INLINE svec force_from_children(const struct state *s, uint32_t i)
{
    return s->pA[i];
}

/* f_parent += up, at once */
TFA_INLINE void add_total_force_to_parent(struct state *s, uint32_t i, svec up)
{
    svec *f = &s->f[body_constants_of(s, i)->parent];
    *f = sv_add(*f, up);
}

TFA_INLINE void add_total_forces_of_children(struct state *s, uint32_t i)
{
    (void)s;
    (void)i;
}

#endif
