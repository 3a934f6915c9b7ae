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

/* Forces across a joint */
struct cfa_joint {
    num basis[36]; /* W^T, then Wa^T: joint_basis.h */
    uint32_t n;    /* freedoms */
    int axis;      /* of one freedom */
};

struct cfa_row {
    sym6 Iinv; /* inverse of the inertia with side branches added */
    struct cfa_joint joint;
    num f[6]; /* Wa tau; then F */
    num e[6]; /* I^-1 (f - X^T f of the next - p) */
};

/* Unknowns of a row */
static inline uint32_t cfa_size(const struct cfa_joint *j)
{
    return 6 - j->n;
}

static inline void cfa_joint_init(struct cfa_joint *j, const struct state *s,
                                  const struct tfa_body *b)
{
    joint_basis(s, b, j->basis);
    j->n = (uint32_t)b->n;
    j->axis = body_axis(b);
}

/* out <- W^T x for `columns` columns; both with rows of six. W of a 1-freedom joint leaves out a
 * row. `out` may be x. */
static inline void cfa_project(const struct cfa_joint *w, const num *x, num *out, int columns)
{
    if (w->n == 1) {
        for (int k = 0; k < 5; k++)
            for (int j = 0; j < columns; j++)
                out[6 * k + j] = x[6 * (k + (k >= w->axis)) + j];
        return;
    }
    for (int j = 0; j < columns; j++) {
        num in[6];
        for (int e = 0; e < 6; e++)
            in[e] = x[6 * e + j];
        for (uint32_t k = 0; k < cfa_size(w); k++) {
            num sum = num_of(0);
            for (uint32_t e = 0; e < 6; e++)
                sum += w->basis[6 * k + e] * in[e];
            out[6 * k + (uint32_t)j] = sum;
        }
    }
}

/* out <- x W: columns from six to 6 - n */
static inline void cfa_project_columns(const struct cfa_joint *w, const num *x, num *out)
{
    num transposed[36];
    for (int e = 0; e < 36; e++)
        transposed[e] = x[6 * (e % 6) + e / 6];
    cfa_project(w, transposed, transposed, 6);
    for (uint32_t k = 0; k < cfa_size(w); k++)
        for (uint32_t e = 0; e < 6; e++)
            out[6 * e + k] = transposed[6 * k + e];
}

/* Wa tau of the joint's own freedoms */
static inline svec cfa_active_force(const struct cfa_joint *w, const num *tau)
{
    svec f = sv_zero();
    for (uint32_t j = 0; j < w->n; j++)
        f = sv_add(f, sv_scale(sv_from(w->basis + 6 * (cfa_size(w) + j)), tau[j]));
    return f;
}

/* f += W lambda */
static inline void cfa_add_constraint_force(const struct cfa_joint *w, const num *lambda, num *f)
{
    for (uint32_t j = 0; j < cfa_size(w); j++)
        for (uint32_t e = 0; e < 6; e++)
            f[e] += w->basis[6 * j + e] * lambda[j];
}

/* Iinv and basis of row k; 0 as inverse_inertia() */
static inline int cfa_start(struct state *s, const struct tfa_chain *chain, struct cfa_row *row,
                            uint32_t k)
{
    const uint32_t i = chain->body[k];
    cfa_joint_init(&row[k].joint, s, &s->body[i]);
    return inverse_inertia(s, i, &row[k].Iinv);
}

/* D <- A_kk, L <- A_{k,k-1} (row 0 has none). Reads row k - 1. */
static inline void cfa_assemble(const struct state *s, const struct tfa_chain *chain,
                                const struct cfa_row *row, uint32_t k, num *D, num *L)
{
    const uint32_t i = chain->body[k];
    const struct cfa_joint *w = &row[k].joint;
    num G[36], XI[36], Y[36];
    s6_dense(G, &row[k].Iinv);
    if (k > 0) {
        inverse_from_parent(s, i, &row[k - 1].Iinv, XI, Y);
        for (int e = 0; e < 36; e++) {
            G[e] += Y[e];
            XI[e] = -XI[e];
        }
        cfa_project(w, XI, XI, 6);
        cfa_project_columns(&row[k - 1].joint, XI, L);
    }
    cfa_project_columns(w, G, G);
    cfa_project(w, G, D, (int)cfa_size(w));
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
    for (uint32_t e = 0; e < cfa_size(&row[k].joint); e++)
        b[e] = sv_dot(sv_from(row[k].joint.basis + 6 * e), gap);
}

/* f, e and b of all rows: three steps, the rows of each independent of each other. `b` is of row
 * 0, that of the next row stands `stride` bytes behind. */
static inline void cfa_right_hand_sides(const struct state *s, const struct tfa_chain *chain,
                                        struct cfa_row *row, const num *tau, num *b, size_t stride,
                                        int bias)
{
    for (uint32_t k = 0; k < chain->length; k++)
        sv_store(row[k].f, cfa_active_force(&row[k].joint, tau + s->body[chain->body[k]].v));
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_unconstrained(s, chain, row, k);
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_right_hand_side(s, chain, row, k, (num *)(void *)((char *)b + stride * k), bias);
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
        basis_rates(row[k].joint.basis, b->n, relative, qdd + b->v);
        s->a[i] = up = a;
    }
}

#endif
