/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the total forces of a chain to its accelerations: the last step of every method that finds
 * these forces. Row by row; a row needs the forces and the accelerations of its neighbours only.
 */
#ifndef TFA_DYNAMICS_CHAIN_TFA_MOTION_H
#define TFA_DYNAMICS_CHAIN_TFA_MOTION_H

#include "dynamics/chain/chain.h"
#include "dynamics/chain/joint_basis.h"
#include "layout/body.h"

/* x with H x = m for a fused joint, whose axes are not orthonormal: R x = (Q^T Q)^-1 Q^T m */
static inline void fused_rates(const struct joint_nd *w, uint32_t n, svec m, num *x)
{
    svec Q[6];
    num inv[6], R[36] = {0};
    basis_factor(w, n, Q, inv, R);
    for (uint32_t k = n; k-- > 0;) {
        x[k] = sv_dot(Q[k], m) * inv[k];
        for (uint32_t j = k + 1; j < n; j++)
            x[k] -= R[6 * k + j] * x[j];
    }
}

/* a_k = I_k^-1 (F_k - X_{k+1}^T F_{k+1} - p_k); `next` is not read behind the last body */
static inline svec total_acceleration(const struct state *s, const struct tfa_chain *chain,
                                      uint32_t k, const sym6 *inverse, svec F, const num *next)
{
    svec net = sv_sub(F, s->pA[chain->body[k]]);
    if (k + 1 < chain->length)
        net = sv_sub(net, xform_t_force(&s->X[chain->body[k + 1]], sv_from(next)));
    return s6_mul(inverse, net);
}

/* qdd_i = Wa_i^T (a - X_i up - c_i), the joint's own freedoms */
static inline void joint_acceleration(const struct state *s, uint32_t i, svec a, svec up, num *qdd,
                                      int bias)
{
    const struct tfa_body *b = &s->body[i];
    s->a[i] = a; /* chain.h: for side branches */
    svec relative = sv_sub(a, xform_motion(&s->X[i], up));
    if (chain_has_velocity_products(s, bias))
        relative = sv_sub(relative, s->c[i]);
    if (is_fused(b->kind))
        fused_rates(&s->joint_nd[b->joint_nd], b->n, relative, qdd);
    else
        joint_force(s, b, relative, qdd); /* H^T: H has orthonormal columns */
}

#endif
