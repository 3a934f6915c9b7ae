/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The articulated-body algorithm. Featherstone 2008, table 7.1, in link frames.
 */
#include "dynamics/core/aba_step.h"
#include "dynamics/core/modes.h"

static inline void inward(struct state *s, const num *tau, int flags)
{
    if (flags & ABA_INERTIA)
        sentinel_reset(s);
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].end; i-- > s->span[k].first;)
            aba_backward_step(s, i, tau, flags | ABA_FULL_SWEEP | ABA_SENTINEL);
}

static inline void outward(struct state *s, svec ground, num *qdd, int bias)
{
    svec before = ground; /* a of the body before, which does not wait for memory */
    for (uint32_t i = 0; i < s->bodies; i++) {
        const body_constants *b = &s->body[i];
        const svec parent = parent_is_before(b, i) ? before : parent_motion(b, s->a, ground);
        before = aba_forward_step(s, i, parent, qdd, bias);
    }
}

void TFA_V(aba)(struct state *s, const num *tau, num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    if (HAS_MODES(s))
        aba_backward_pass(s, tau, s->moving, s->have & HAVE_ABA, TFA_V(modes_inward));
    else
        aba_backward_pass(s, tau, s->moving, s->have & HAVE_ABA, inward);
    have_aba(s);
    if (HAS_MODES(s))
        TFA_V(modes_outward)(s, ground, qdd, s->moving);
    else if (qdd)
        outward(s, ground, qdd, s->moving);
}

void TFA_V(aba_outward)(struct state *s, num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    outward(s, ground, qdd, s->moving);
}

void TFA_V(aba_factor)(struct state *s)
{
    if (s->have & HAVE_ABA)
        return;
    if (HAS_MODES(s))
        TFA_V(modes_inward)(s, NULL, ABA_INERTIA);
    else
        inward(s, NULL, ABA_INERTIA);
    have_aba(s);
}

void TFA_V(aba_solve)(struct state *s, const num *tau, num *qdd)
{
    if (HAS_MODES(s)) {
        TFA_V(modes_inward)(s, tau, ABA_FORCE);
        TFA_V(modes_outward)(s, sv_zero(), qdd, 0);
        return;
    }
    inward(s, tau, ABA_FORCE);
    outward(s, sv_zero(), qdd, 0);
}
