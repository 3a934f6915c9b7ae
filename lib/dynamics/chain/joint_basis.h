/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A basis of the forces at a joint: constraint forces W and active forces Wa of the paper.
 */
#ifndef TFA_DYNAMICS_CHAIN_JOINT_BASIS_H
#define TFA_DYNAMICS_CHAIN_JOINT_BASIS_H

#include "layout/body.h"

/* m <- m - (q . m / q . q) q for the first `count` vectors; the factors are added to R when given.
 * Twice is enough: the rest is orthogonal to rounding. */
static inline svec basis_project(const svec *Q, const num *inv, uint32_t count, svec m, num *R)
{
    for (int pass = 0; pass < 2; pass++)
        for (uint32_t j = 0; j < count; j++) {
            const num x = sv_dot(Q[j], m) * inv[j];
            m = sv_sub(m, sv_scale(Q[j], x));
            if (R)
                R[6 * j] += x;
        }
    return m;
}

/* H = Q R by Gram and Schmidt without norms; R, zero before, is unit upper triangular. */
static inline void basis_factor(const struct joint_nd *w, uint32_t n, svec Q[6], num inv[6], num *R)
{
    for (uint32_t k = 0; k < n; k++) {
        Q[k] = basis_project(Q, inv, k, joint_nd_axis(w, k), R + k);
        inv[k] = 1 / sv_dot(Q[k], Q[k]);
    }
}

/* Completes Q to six columns by the unit vectors farthest from its span. */
static inline void basis_complete(uint32_t n, svec Q[6], num inv[6])
{
    for (uint32_t k = n; k < 6; k++) {
        num longest = num_of(0);
        Q[k] = sv_zero();
        for (int e = 0; e < 6; e++) {
            svec unit = sv_zero();
            sv_put(&unit, e, num_of(1));
            unit = basis_project(Q, inv, k, unit, NULL);
            const num size = sv_dot(unit, unit);
            const num_mask longer = size > longest;
            longest = num_select(longer, size, longest);
            Q[k] = sv_select(longer, unit, Q[k]);
        }
        inv[k] = 1 / longest;
    }
}

/* The same of a joint about or along component `axis` */
static inline void joint_basis_1dof(int axis, num basis[36])
{
    for (int e = 0; e < 36; e++)
        basis[e] = num_of(0);
    for (int k = 0; k < 5; k++)
        basis[7 * k + (k >= axis)] = num_of(1);
    basis[30 + axis] = num_of(1);
}

/* Rows of `basis`: 6 - n of W^T (H^T W = 0), then n of Wa^T (H^T Wa = 1). So
 *   F = basis^T (lambda, H^T F),   basis H qdd = (0, qdd).
 * A joint about or along an axis has unit vectors, and so have all but fused ones. */
static inline void joint_basis(const struct state *s, const struct tfa_body *b, num basis[36])
{
    if (b->n == 1) {
        joint_basis_1dof(body_axis(b), basis);
        return;
    }
    const uint32_t n = b->n;
    svec Q[6], Wa[6];
    num inv[6], R[36] = {0};
    basis_factor(&s->joint_nd[b->joint_nd], n, Q, inv, R);
    basis_complete(n, Q, inv);
    for (uint32_t k = n; k < 6; k++)
        sv_store(basis + 6 * (k - n), Q[k]);
    for (uint32_t k = n; k-- > 0;) { /* Wa^T = R^-1 (Q^T Q)^-1 Q^T */
        Wa[k] = sv_scale(Q[k], inv[k]);
        for (uint32_t j = k + 1; j < n; j++)
            Wa[k] = sv_sub(Wa[k], sv_scale(Wa[j], R[6 * k + j]));
        sv_store(basis + 6 * (6 - n + k), Wa[k]);
    }
}

/* x = Wa^T m for a joint whose basis is at hand: the rates of a motion H x */
static inline void basis_rates(const num basis[36], uint32_t n, svec m, num *x)
{
    for (uint32_t k = 0; k < n; k++)
        x[k] = sv_dot(sv_from(basis + 6 * (6 - n + k)), m);
}

#endif
