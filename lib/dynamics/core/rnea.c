/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recursive Newton-Euler: inverse dynamics, and the residual of every other method.
 */
#include "dynamics/core/recursions.h"
#include "dynamics/core/rnea_step.h"

/* tau_i = H_i^T f_i + R_i qdd_i,  f_parent += X_i^T f_i */
static inline void inward(struct state *s, uint32_t i, const num *qdd, num *tau)
{
    const struct tfa_body *b = &s->body[i];
    euler_joint(s, i, qdd, tau);
    if (b->parent >= 0)
        s->f[b->parent] = sv_add(s->f[b->parent], xform_t_force(&s->X[i], s->f[i]));
}

void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias)
{
    const struct tfa_model *m = s->m;
    const int products = bias && s->moving;
    const svec ground = {v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};

    /* a_i = X_i a_parent + H_i qdd_i + c_i,  f_i = I_i a_i + p_i */
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        svec a = xform_motion(&s->X[i], b->parent < 0 ? ground : s->a[b->parent]);
        if (products)
            a = sv_add(a, s->c[i]);
        euler_out(s, i, a, qdd, products ? &s->p[i] : NULL);
    }
    for (uint32_t i = m->bodies; i-- > 0;)
        inward(s, i, qdd, tau);
}
