/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The articulated-body algorithm. Featherstone 2008, table 7.1, in link frames.
 */
#include "kernel/aba_step.h"
#include "kernel/kernel.h"

static inline void inward(struct state *s, const num *tau, int what)
{
    if (what & FOLD_INERTIA)
        sentinel_reset(s);
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].end; i-- > s->span[k].first;)
            fold(s, i, tau, what | FOLD_FRESH | FOLD_WATCH);
}

static inline void outward(struct state *s, svec ground, num *qdd, int bias)
{
    for (uint32_t i = 0; i < s->bodies; i++)
        unfold(s, i, parent_motion(&s->body[i], s->a, ground), qdd, bias);
}

void TFA_V(aba)(struct state *s, const num *tau, num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    pass_inward(s, tau, s->moving, s->have & HAVE_ABA, inward);
    have_aba(s);
    outward(s, ground, qdd, s->moving);
}

void TFA_V(aba_factor)(struct state *s)
{
    if (!(s->have & HAVE_ABA))
        inward(s, NULL, FOLD_INERTIA);
    have_aba(s);
}

void TFA_V(aba_solve)(struct state *s, const num *tau, num *qdd)
{
    inward(s, tau, FOLD_FORCE);
    outward(s, sv_zero(), qdd, 0);
}
