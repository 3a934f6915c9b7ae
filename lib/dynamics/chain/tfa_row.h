/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One block row of the total force system A F = rhs (the paper's (46)-(49)).
 *
 *   K_i = 1 - C_i I_i,   C_i = H_i Theta_i^-1 H_i^T,   Theta_i = H_i^T I_i H_i + R_i
 *   A_ii = I_i^-1 + K_i Y_i,  A_{i,i-1} = -K_i XI_i,  A_{i,i+1} = (C_i - I_i^-1) X_{i+1}^T
 *   XI_i = X_i I_{i-1}^-1,    Y_i = XI_i X_i^T
 *   rhs_i = B_i tau_i + K_i (c_i + I_i^-1 p_i - XI_i p_{i-1}),   B_i = H_i Theta_i^-1
 *   rhs_1 = B_1 tau_1 + K_1 (c_1 + X_1 a_0 + I_1^-1 p_1),        A_11 = I_1^-1
 *
 * The bias stays inside the right-hand side: subtracted from tau first, as in the paper, it costs
 * digits.
 */
#ifndef TFA_DYNAMICS_CHAIN_TFA_ROW_H
#define TFA_DYNAMICS_CHAIN_TFA_ROW_H

#include "dynamics/chain/tfa_inverse.h"

/* Six freedoms without armature: C = I^-1, so K = 0 and F = tau: the row decouples. */
static inline int row_decouples(const struct tfa_body *b)
{
    return is_free(b->kind) && !(b->armature > 0);
}

/* K_i and B_i = H_i Theta_i^-1 */
static inline void row_joint(const struct state *s, struct row *r, const struct joint_nd *w,
                             const struct tfa_body *b, const sym6 *I)
{
    if (b->n == 1) {
        int axis = body_axis(b);
        svec U = s6_column(I, axis);
        num inv = 1 / (sv_get(&U, axis) + num_of(b->armature));
        num k = num_of(b->armature) * inv; /* 1 - I_zz / Theta, without the cancellation */
        U = sv_scale(U, -inv);
        sv_put(&U, axis, k);
        sv_store(r->K, U);
        r->B[0] = inv;
        return;
    }
    num theta[36], IH[36];
    for (uint32_t k = 0; k < b->n; k++) {
        svec U = s6_mul(I, joint_nd_axis(w, k));
        sv_store(IH + 6 * k, U);
        for (uint32_t j = 0; j <= k; j++)
            theta[6 * k + j] = sv_dot(joint_nd_axis(w, j), U);
        theta[6 * k + k] += joint_armature(s, b, k);
    }
    ldl_factor(theta, b->n);
    for (int e = 0; e < 6; e++) { /* B^T = Theta^-1 H^T, column e */
        num x[6] = {0};
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = w->H[6 * k + (uint32_t)e];
        ldl_solve(theta, b->n, x);
        for (uint32_t k = 0; k < b->n; k++)
            r->B[6 * k + (uint32_t)e] = x[k];
    }
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < 6; f++) {
            num sum = num_of(e == f);
            for (uint32_t k = 0; k < b->n; k++)
                sum -= r->B[6 * k + (uint32_t)e] * IH[6 * k + (uint32_t)f];
            r->K[6 * e + f] = row_decouples(b) ? num_of(0) : sum;
        }
}

/* x <- K_i x for `columns` columns, row major with that stride */
static inline void row_apply_K(const struct row *r, const struct tfa_body *b, num *x, int columns)
{
    if (b->n == 1) {
        int axis = body_axis(b);
        for (int j = 0; j < columns; j++) {
            num sum = r->K[0] * x[j];
            for (int e = 1; e < 6; e++)
                sum += r->K[e] * x[columns * e + j];
            x[columns * axis + j] = sum;
        }
        return;
    }
    for (int j = 0; j < columns; j++) {
        num in[6], out[6];
        for (int e = 0; e < 6; e++)
            in[e] = x[columns * e + j];
        m6_apply(out, r->K, in);
        for (int e = 0; e < 6; e++)
            x[columns * e + j] = out[e];
    }
}

/* x += B_i tau_i for `columns` columns; those of tau, freedom by freedom, are `stride` apart */
static inline void row_add_B(const struct row *r, const struct tfa_body *b, const num *tau,
                             size_t stride, num *x, int columns)
{
    if (b->n == 1) {
        for (int j = 0; j < columns; j++)
            x[columns * body_axis(b) + j] += r->B[0] * tau[j];
        return;
    }
    for (uint32_t k = 0; k < b->n; k++)
        for (int e = 0; e < 6; e++)
            for (int j = 0; j < columns; j++)
                x[columns * e + j] += r->B[6 * k + (uint32_t)e] * tau[stride * k + (size_t)j];
}

/* G <- A_{i,i+1} = (X_{i+1} C_i)^T - XI_{i+1}^T; `next` is row i+1, X its transform */
static inline void row_upper_block(const struct row *r, const struct tfa_body *b,
                                   const struct joint_nd *w, const struct row *next, const xform *X,
                                   num *G)
{
    if (row_decouples(b)) {
        for (int k = 0; k < 36; k++)
            G[k] = num_of(0);
        return;
    }
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < 6; f++)
            G[6 * e + f] = -next->XI[6 * f + e];
    for (uint32_t k = 0; k < b->n; k++) { /* C = sum over freedoms of B_k H_k^T */
        svec H = b->n == 1 ? sv_zero() : joint_nd_axis(w, k);
        if (b->n == 1)
            sv_put(&H, body_axis(b), num_of(1));
        num XH[6];
        sv_store(XH, xform_motion(X, H));
        num column[6] = {0};
        num one[6] = {0};
        one[k] = num_of(1);
        row_add_B(r, b, one, 1, column, 1);
        for (int e = 0; e < 6; e++)
            for (int f = 0; f < 6; f++)
                G[6 * e + f] += column[e] * XH[f];
    }
}

#endif
