/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One body's step of the recursive Newton-Euler algorithm.
 */
#ifndef TFA_DYNAMICS_CORE_RNEA_STEP_H
#define TFA_DYNAMICS_CORE_RNEA_STEP_H

#include "layout/body.h"

/* a_i = (X_i a_parent + c_i) + H_i qdd_i,  f_i = I_i a_i + p_i; p may be NULL */
TFA_INLINE void euler_out(struct state *s, uint32_t i, svec a, const num *qdd, const svec *p)
{
    const body_constants *b = body_constants_of(s, i);
    add_joint_motion(s, b, qdd + b->v, &a);
    s->a[i] = a;
    s->f[i] = rigid_mul(body_with_payload(s, i), a);
    if (p)
        s->f[i] = sv_add(s->f[i], *p);
}

/* tau_i = H_i^T f_i + R_i qdd_i */
TFA_INLINE void euler_joint(struct state *s, uint32_t i, const num *qdd, num *tau)
{
    const body_constants *b = body_constants_of(s, i);
    joint_force(s, b, s->f[i], tau + b->v);
    for (uint32_t k = 0; k < b->n; k++)
        tau[b->v + k] += joint_armature(s, b, k) * qdd[b->v + k];
}

#endif
