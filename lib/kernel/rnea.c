/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recursive Newton-Euler: inverse dynamics, and the residual of every other method.
 */
#include "kernel/body.h"
#include "kernel/kernel.h"

void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias)
{
    const struct tfa_model *m = s->m;
    const int products = bias && s->moving;
    const svec ground = {{0, 0, 0}, bias ? v3_neg(s->gravity) : v3(0, 0, 0)};

    /* a_i = X_i a_parent + H_i qdd_i + c_i,  f_i = I_i a_i + p_i */
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        svec a = x_motion(&s->X[i], b->parent < 0 ? ground : s->a[b->parent]);
        if (products)
            a = sv_add(a, s->c[i]);
        add_joint_motion(s, b, qdd + b->v, &a);
        s->a[i] = a;
        s->f[i] = rigid_mul(b, a);
        if (products)
            s->f[i] = sv_add(s->f[i], s->p[i]);
    }

    /* tau_i = H_i^T f_i + R_i qdd_i,  f_parent += X_i^T f_i */
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        joint_force(s, b, s->f[i], tau + b->v);
        for (uint32_t k = 0; k < b->n; k++)
            tau[b->v + k] += joint_armature(s, b, k) * qdd[b->v + k];
        if (b->parent >= 0)
            s->f[b->parent] = sv_add(s->f[b->parent], x_t_force(&s->X[i], s->f[i]));
    }
}
