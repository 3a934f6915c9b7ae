/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Articulated-body inertia and bias force of a body before its joint is eliminated.
 */
#ifndef TFA_DYNAMICS_CORE_ABA_START_H
#define TFA_DYNAMICS_CORE_ABA_START_H

#include "layout/body.h"
#include "layout/parent_transfer.h"

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
