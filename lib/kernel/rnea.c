/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recursive Newton-Euler: inverse dynamics, and the residual of every other method.
 *
 * A residual shows what a method loses, but not what pose, velocities and the residual itself lose to
 * rounding, which every method shares with it. An estimate takes it with all of them shaken: each
 * number times 1 + e or 1 - e, e some roundings, by turns that look random.
 */
#include "kernel/kernel.h"
#include "kernel/rnea_step.h"
#include "kernel/shake.h"

/* c_i and p_i, or what they are of a shaken velocity */
static inline void products_of(const struct state *s, uint32_t i, int shaken, uint32_t *turn,
                               svec *c, svec *p)
{
    *c = s->c[i];
    *p = s->p[i];
    if (!shaken)
        return;
    const svec v = s->v[i], momentum = rigid_mul(&s->body[i], shake_svec(v, turn));
    *c = shake_svec(*c, turn);
    *p = sv_sub(cross_force(shake_svec(v, turn), momentum), shake_svec(s->wrench[i], turn));
}

static inline __attribute__((always_inline)) void newton_euler(struct state *s, const num *qdd,
                                                               num *tau, int bias, int shaken)
{
    const struct tfa_model *m = s->m;
    const int products = bias && s->moving;
    uint32_t turn = 1;
    const svec ground = {v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};

    /* a_i = X_i a_parent + H_i qdd_i + c_i,  f_i = I_i a_i + p_i */
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const place X = shaken ? shake_place(&s->X[i], b->n == 1, &turn) : s->X[i];
        svec a = x_motion(&X, b->parent < 0 ? ground : s->a[b->parent]), c, p = sv_zero();
        if (products) {
            products_of(s, i, shaken, &turn, &c, &p);
            a = sv_add(a, c);
        }
        euler_out(s, i, a, qdd, products ? &p : NULL);
    }

    /* tau_i = H_i^T f_i + R_i qdd_i,  f_parent += X_i^T f_i */
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        euler_joint(s, i, qdd, tau);
        if (b->parent < 0)
            continue;
        const place X = shaken ? shake_place(&s->X[i], b->n == 1, &turn) : s->X[i];
        s->f[b->parent] = sv_add(s->f[b->parent], x_t_force(&X, s->f[i]));
    }
}

void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias)
{
    newton_euler(s, qdd, tau, bias, 0);
}

void TFA_V(rnea_shaken)(struct state *s, const num *qdd, num *tau, int bias)
{
    newton_euler(s, qdd, tau, bias, 1);
}
