/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transfers between a body and its parent: motions outward, articulated inertias and forces
 * inward. One body after the other, a body adds to its parent's IA and pA. In a body-lanes variant
 * the result of a step stays with it, and the step of the parents reads it, lane by lane from where
 * the children are; in the same order, so that the sums are the same to the bit.
 */
#ifndef TFA_LAYOUT_PARENT_TRANSFER_H
#define TFA_LAYOUT_PARENT_TRANSFER_H

#include "layout/body.h"

/* Parts of a backward step; constants at every call, so that the compiler removes the rest.
 * ABA_FULL_SWEEP: one sweep over all bodies, so that nothing need be initialised: the first
 * child stores, the others add, and the body's own inertia is added last.
 * ABA_FORCE without ABA_INERTIA uses the factors that are there: the same operations in the same
 * order, so that the answer is the same to the bit.
 * ABA_MODES, not with ABA_FULL_SWEEP: some bodies are flexible (dynamics/core/modes.h).
 * ABA_DETACH, not with ABA_FULL_SWEEP: the contribution to the parent replaces the body's own IA
 * and pA. The parent belongs to another thread. */
enum {
    ABA_INERTIA = 1,
    ABA_FORCE = 2,
    ABA_BIAS = 4,
    ABA_FULL_SWEEP = 8,
    ABA_DETACH = 16,
    ABA_SENTINEL = 32,
    ABA_MODES = 64
};

#include "layout_transfer.h"

/* IA_i = I_i, pA_i = p_i before the children are added */
static inline void aba_backward_start(struct state *s, uint32_t i, int flags)
{
    if (flags & ABA_INERTIA)
        s->IA[i] = rigid_inertia(body_with_payload(s, i));
    if (flags & ABA_FORCE)
        s->pA[i] = flags & ABA_BIAS ? s->p[i] : sv_zero();
}

/* IA_i = I_i and the contributions of its children */
TFA_INLINE sym6 aba_backward_inertia(const struct state *s, uint32_t i, const body_constants *b,
                                     int flags)
{
    if (!(flags & ABA_FULL_SWEEP))
        return s->IA[i];
    sym6 I = rigid_inertia(body_with_payload(s, i));
    if (!b->leaf)
        add_inertia_from_children(s, i, &I);
    return I;
}

/* pA_i = p_i and the contributions of its children */
TFA_INLINE svec aba_backward_force(const struct state *s, uint32_t i, const body_constants *b,
                                   int flags)
{
    if (!(flags & ABA_FULL_SWEEP))
        return s->pA[i];
    svec p = flags & ABA_BIAS ? s->p[i] : sv_zero();
    return b->leaf ? p : sv_add(p, force_from_children(s, i));
}

#endif
