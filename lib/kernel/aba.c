/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The articulated-body algorithm. Featherstone 2008, table 7.1, in link frames.
 */
#include "kernel/aba_step.h"
#include "kernel/kernel.h"

static inline void inward(struct state *s, const num *tau, int what)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = m->bodies; i-- > 0;)
        fold(s, i, tau, what | FOLD_FRESH);
}

static inline void outward(struct state *s, svec ground, num *qdd, int bias)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = 0; i < m->bodies; i++) {
        int32_t p = m->body[i].parent;
        unfold(s, i, p < 0 ? ground : s->a[p], qdd, bias);
    }
}

void TFA_V(aba)(struct state *s, const num *tau, num *qdd)
{
    const svec ground = {{0, 0, 0}, v3_neg(s->gravity)};
    if (s->moving) {
        inward(s, tau, FOLD_INERTIA | FOLD_FORCE | FOLD_BIAS);
        outward(s, ground, qdd, 1);
    } else {
        inward(s, tau, FOLD_INERTIA | FOLD_FORCE);
        outward(s, ground, qdd, 0);
    }
}

void TFA_V(aba_factor)(struct state *s)
{
    inward(s, NULL, FOLD_INERTIA);
}

void TFA_V(aba_solve)(struct state *s, const num *tau, num *qdd)
{
    inward(s, tau, FOLD_FORCE);
    outward(s, sv_zero(), qdd, 0);
}
