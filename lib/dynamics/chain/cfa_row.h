/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One block row of the constraint force system (the paper's (60)).
 *
 *   F_i = Wa_i tau_i + W_i lambda_i,   A lambda = b,   A symmetric positive definite
 *   A_ii = W_i^T (I_i^-1 + Y_i) W_i,   A_{i,i-1} = -W_i^T XI_i W_{i-1}      (XI, Y: tfa_inverse.h)
 *   b_i = W_i^T (c_i - e_i + X_i e_{i-1}),   e_i = I_i^-1 (f_i - X_{i+1}^T f_{i+1} - p_i)
 *
 * with f = Wa tau, so that e is the acceleration without constraint forces; e_{-1} = -gravity.
 * Joint i has 6 - n_i of them: a free body has none, and a row of no unknowns. Rotor inertia is
 * no force between bodies, and tau = H^T F + R qdd would bring qdd into f: the method has no place
 * for it, and requests with it are refused by name.
 */
#ifndef TFA_DYNAMICS_CHAIN_CFA_ROW_H
#define TFA_DYNAMICS_CHAIN_CFA_ROW_H

#include "dynamics/chain/joint_basis.h"
#include "dynamics/chain/tfa_inverse.h"
#include "dynamics/chain/tfa_motion.h"

struct cfa_row {
    sym6 Iinv;     /* inverse of the inertia with side branches added */
    num basis[36]; /* W^T, then Wa^T: joint_basis.h */
    num f[6];      /* Wa tau; then F */
    num e[6];      /* I^-1 (f - X^T f of the next - p) */
};

/* Unknowns of a row */
static inline uint32_t cfa_size(const struct tfa_body *b)
{
    return 6 - (uint32_t)b->n;
}

/* out <- W^T x for `columns` columns; both with rows of six. W of a 1-freedom joint leaves out a
 * row. `out` may be x. */
static inline void cfa_project(const struct cfa_row *r, const struct tfa_body *b, const num *x,
                               num *out, int columns)
{
    if (b->n == 1) {
        const int axis = body_axis(b);
        for (int k = 0; k < 5; k++)
            for (int j = 0; j < columns; j++)
                out[6 * k + j] = x[6 * (k + (k >= axis)) + j];
        return;
    }
    for (int j = 0; j < columns; j++) {
        num in[6];
        for (int e = 0; e < 6; e++)
            in[e] = x[6 * e + j];
        for (uint32_t k = 0; k < cfa_size(b); k++) {
            num sum = num_of(0);
            for (uint32_t e = 0; e < 6; e++)
                sum += r->basis[6 * k + e] * in[e];
            out[6 * k + (uint32_t)j] = sum;
        }
    }
}

/* out <- x W: columns from six to 6 - n */
static inline void cfa_project_columns(const struct cfa_row *r, const struct tfa_body *b,
                                       const num *x, num *out)
{
    num transposed[36];
    for (int e = 0; e < 36; e++)
        transposed[e] = x[6 * (e % 6) + e / 6];
    cfa_project(r, b, transposed, transposed, 6);
    for (uint32_t k = 0; k < cfa_size(b); k++)
        for (uint32_t e = 0; e < 6; e++)
            out[6 * e + k] = transposed[6 * k + e];
}

/* Iinv and basis of row k; 0 as inverse_inertia() */
static inline int cfa_start(struct state *s, const struct tfa_chain *chain, struct cfa_row *row,
                            uint32_t k)
{
    const uint32_t i = chain->body[k];
    joint_basis(s, &s->body[i], row[k].basis);
    return inverse_inertia(s, i, &row[k].Iinv);
}

/* D <- A_kk, L <- A_{k,k-1} (row 0 has none). Reads row k - 1. */
static inline void cfa_assemble(const struct state *s, const struct tfa_chain *chain,
                                const struct cfa_row *row, uint32_t k, num *D, num *L)
{
    const uint32_t i = chain->body[k];
    const struct tfa_body *b = &s->body[i];
    num G[36], XI[36], Y[36];
    s6_dense(G, &row[k].Iinv);
    if (k > 0) {
        inverse_from_parent(s, i, &row[k - 1].Iinv, XI, Y);
        for (int e = 0; e < 36; e++) {
            G[e] += Y[e];
            XI[e] = -XI[e];
        }
        cfa_project(&row[k], b, XI, XI, 6);
        cfa_project_columns(&row[k - 1], &s->body[b->parent], XI, L);
    }
    cfa_project_columns(&row[k], b, G, G);
    cfa_project(&row[k], b, G, D, (int)cfa_size(b));
}

/* f <- Wa tau */
static inline void cfa_active(const struct state *s, const struct tfa_chain *chain,
                              struct cfa_row *row, uint32_t k, const num *tau)
{
    const struct tfa_body *b = &s->body[chain->body[k]];
    svec f = sv_zero();
    for (uint32_t j = 0; j < b->n; j++)
        f = sv_add(f, sv_scale(sv_from(row[k].basis + 6 * (cfa_size(b) + j)), tau[b->v + j]));
    sv_store(row[k].f, f);
}

static inline const num *cfa_next(const struct tfa_chain *chain, const struct cfa_row *row,
                                  uint32_t k)
{
    return k + 1 < chain->length ? row[k + 1].f : NULL;
}

/* e_k. Reads f of row k + 1. */
static inline void cfa_unconstrained(const struct state *s, const struct tfa_chain *chain,
                                     struct cfa_row *row, uint32_t k)
{
    const svec f = sv_from(row[k].f);
    sv_store(row[k].e, total_acceleration(s, chain, k, &row[k].Iinv, f, cfa_next(chain, row, k)));
}

/* b_k. Reads e of row k - 1. */
static inline void cfa_right_hand_side(const struct state *s, const struct tfa_chain *chain,
                                       const struct cfa_row *row, uint32_t k, num *b, int bias)
{
    const uint32_t i = chain->body[k];
    const svec before = k > 0 ? sv_from(row[k - 1].e) : chain_ground(s, bias);
    svec gap = sv_sub(xform_motion(&s->X[i], before), sv_from(row[k].e));
    if (chain_has_velocity_products(s, bias))
        gap = sv_add(gap, s->c[i]);
    for (uint32_t e = 0; e < cfa_size(&s->body[i]); e++)
        b[e] = sv_dot(sv_from(row[k].basis + 6 * e), gap);
}

/* f, e and b of all rows: three steps, the rows of each independent of each other. `b` is of row
 * 0, that of the next row stands `stride` bytes behind. */
static inline void cfa_right_hand_sides(const struct state *s, const struct tfa_chain *chain,
                                        struct cfa_row *row, const num *tau, num *b, size_t stride,
                                        int bias)
{
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_active(s, chain, row, k, tau);
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_unconstrained(s, chain, row, k);
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_right_hand_side(s, chain, row, k, (num *)(void *)((char *)b + stride * k), bias);
}

/* F <- f + W lambda */
static inline void cfa_total_force(const struct state *s, const struct tfa_chain *chain,
                                   struct cfa_row *row, uint32_t k, const num *lambda)
{
    const uint32_t n = cfa_size(&s->body[chain->body[k]]);
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t e = 0; e < 6; e++)
            row[k].f[e] += row[k].basis[6 * j + e] * lambda[j];
}

/* qdd = Wa^T (a - X a of the body before - c) from the total forces */
static inline void cfa_accelerations(const struct state *s, const struct tfa_chain *chain,
                                     const struct cfa_row *row, num *qdd, int bias)
{
    svec up = chain_ground(s, bias);
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        const struct tfa_body *b = &s->body[i];
        const svec F = sv_from(row[k].f);
        const svec a = total_acceleration(s, chain, k, &row[k].Iinv, F, cfa_next(chain, row, k));
        svec relative = sv_sub(a, xform_motion(&s->X[i], up));
        if (chain_has_velocity_products(s, bias))
            relative = sv_sub(relative, s->c[i]);
        basis_rates(row[k].basis, b->n, relative, qdd + b->v);
        s->a[i] = up = a;
    }
}

#endif
