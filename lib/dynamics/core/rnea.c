/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recursive Newton-Euler: inverse dynamics, and the residual of every other method.
 */
#include "dynamics/core/modes.h"
#include "dynamics/core/rnea_step.h"
#include "layout/parent_transfer.h"

/* tau_i = H_i^T f_i + R_i qdd_i,  f_parent += X_i^T f_i */
TFA_INLINE void inward(struct state *s, uint32_t i, const num *qdd, num *tau, int modes)
{
    add_total_forces_of_children(s, i);
    euler_joint(s, i, qdd, tau);
    if (body_constants_of(s, i)->parent < 0)
        return;
    const svec up = xform_t_force(&s->X[i], s->f[i]);
    if (modes)
        TFA_V(modes_euler_parent)(s, i, up, tau);
    add_total_force_to_parent(s, i, up);
}

/* `modes`, a constant: some bodies are flexible (modes.h)
 *   a_i = X_i a_parent + H_i qdd_i + c_i,  f_i = I_i a_i + p_i */
TFA_INLINE void passes(struct state *s, const num *qdd, num *tau, int bias, int modes)
{
    const int products = bias && s->moving;
    const svec ground = {v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};
    for (uint32_t i = 0; i < s->bodies; i++) {
        svec a = parent_motion(body_constants_of(s, i), s->a, ground);
        if (modes)
            a = TFA_V(modes_parent)(s, i, a, qdd);
        a = xform_motion(&s->X[i], a);
        if (products)
            a = sv_add(a, s->c[i]);
        euler_out(s, i, a, qdd, products ? &s->p[i] : NULL);
        if (modes)
            TFA_V(modes_euler)(s, i, qdd, tau, products);
    }
    for (uint32_t i = s->bodies; i-- > 0;)
        inward(s, i, qdd, tau, modes);
}

void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias)
{
    if (HAS_MODES(s))
        passes(s, qdd, tau, bias, 1);
    else
        passes(s, qdd, tau, bias, 0);
}
