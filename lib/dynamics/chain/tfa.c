/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm: for each main chain a block tridiagonal system for the total forces,
 * solved by block LU; side branches reduced into the chain by the articulated-body algorithm.
 * Fijany & Featherstone 2013; the bias stays inside the right-hand side.
 */
#include "dynamics/chain/tfa.h"

#include "dynamics/chain/tfa_motion.h"
#include "dynamics/chain/tfa_row.h"

/* T I_parent^-1 and T I_parent^-1 T^T for the tree transform T of body i */
static void precompute_from_parent(struct state *s, uint32_t i)
{
    const struct tfa_body *b = &s->body[i];
    struct model_constants *t = &s->model_constants[i];
    const xform T = {body_E(b), body_r(b)};
    const sym6 *up = &s->Iinv[b->parent];
    t->TIT = s6_inv_to_child(&T, up);
    for (int k = 0; k < 6; k++) {
        num column[6];
        sv_store(column, xform_motion(&T, s6_column(up, k)));
        for (int e = 0; e < 6; e++)
            t->TI[6 * e + k] = column[e];
    }
}

/* I^-1, or zeros where there is none: for an irregular body, and in single precision for one whose
 * inertia rounding made so. The chain refuses it. */
static void precompute_inverse(struct state *s, uint32_t i)
{
    const sym6 I = rigid_inertia(&s->body[i]);
    if (!s->body[i].regular || !s6_invert(&I, &s->Iinv[i]))
        s->Iinv[i] = (sym6){0};
}

void TFA_V(tfa_precompute)(struct state *s)
{
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        precompute_inverse(s, i);
        if (s->body[i].parent >= 0 && reserves_inverse(s->methods))
            precompute_from_parent(s, i);
    }
}

void TFA_V(tfa_precompute_body)(struct state *s, uint32_t body)
{
    precompute_inverse(s, body);
    for (uint32_t i = body + 1; reserves_inverse(s->methods) && i < s->m->bodies; i++)
        if (s->body[i].parent == (int32_t)body)
            precompute_from_parent(s, i);
}

/* S_i = I_i^-1 + K_i (Y_i + XI_i G_{i-1}), factored; G_i waits for row i+1 */
static inline void row_eliminate(struct state *s, const struct tfa_chain *chain, struct row *row,
                                 uint32_t k, const num *Y)
{
    const uint32_t i = chain->body[k];
    const struct tfa_body *b = &s->body[i];
    struct row *r = &row[k];
    num W[36] = {0}, Iinv[36];
    if (k > 0) {
        struct row *up = r - 1;
        const struct tfa_body *pb = &s->body[b->parent];
        const struct joint_nd *pw = pb->joint_nd < 0 ? NULL : &s->joint_nd[pb->joint_nd];
        row_upper_block(up, pb, pw, r, &s->X[i], up->G);
        lu6_solve(&up->S, up->G, 6);
        m6_mul(W, r->XI, up->G);
        for (int e = 0; e < 36; e++)
            W[e] += Y[e];
        row_apply_K(r, b, W, 6);
    }
    s6_dense(Iinv, &r->Iinv);
    for (int e = 0; e < 36; e++)
        r->S.a[e] = Iinv[e] + W[e];
    lu6_factor(&r->S);
}

int TFA_V(tfa_factor_rows)(struct state *s, const struct tfa_chain *chain, struct row *row)
{
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        const struct tfa_body *b = &s->body[i];
        struct row *r = &row[k];
        num Y[36];
        if (!inverse_inertia(s, i, &r->Iinv))
            return TFA_E_SINGULAR;
        row_joint(s, r, b->joint_nd < 0 ? NULL : &s->joint_nd[b->joint_nd], b, &s->IA[i]);
        if (k > 0)
            inverse_from_parent(s, i, &row[k - 1].Iinv, r->XI, Y);
        row_eliminate(s, chain, row, k, Y);
    }
    return TFA_OK;
}

/* F <- S^-1 (K (F - XI (p - F of the row before)) + B tau) for `columns` columns: F is what is
 * known of the row's acceleration, p the bias force on the body before. `before`: NULL in the
 * first row */
static inline void row_forward(const struct tfa_body *b, struct row *r, const struct row *before,
                               const num *p, const num *tau, size_t stride, int columns)
{
    if (before) {
        num force_difference[36], moved[36];
        for (int e = 0; e < 6 * columns; e++)
            force_difference[e] = p[e] - before->F[e];
        m6_columns(moved, r->XI, force_difference, columns);
        for (int e = 0; e < 6 * columns; e++)
            r->F[e] -= moved[e];
    }
    row_apply_K(r, b, r->F, columns);
    row_add_B(r, b, tau, stride, r->F, columns);
    lu6_solve(&r->S, r->F, columns);
}

/* Forward elimination of the right-hand side B tau + K (c + I^-1 p - XI p_parent). The first row
 * sees the ground's acceleration instead. */
static void forward(struct state *s, const struct tfa_chain *chain, struct row *row, const num *tau,
                    int bias)
{
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        const struct tfa_body *b = &s->body[i];
        struct row *r = &row[k];
        num p[6] = {0};
        svec known = s6_mul(&r->Iinv, s->pA[i]);
        if (chain_has_velocity_products(s, bias))
            known = sv_add(known, s->c[i]);
        if (k == 0 && bias)
            known = sv_add(known, xform_motion(&s->X[i], chain_ground(s, bias)));
        sv_store(r->F, known);
        if (k > 0)
            sv_store(p, s->pA[b->parent]);
        row_forward(b, r, k > 0 ? r - 1 : NULL, p, tau + b->v, 1, 1);
    }
}

/* F_i -= G_i F_{i+1} */
static inline void back(const struct tfa_chain *chain, struct row *row, int columns)
{
    for (uint32_t k = chain->length - 1; k-- > 0;) {
        struct row *r = &row[k];
        num g[36];
        m6_columns(g, r->G, row[k + 1].F, columns);
        for (int e = 0; e < 6 * columns; e++)
            r->F[e] -= g[e];
    }
}

static void accelerations(const struct state *s, const struct tfa_chain *chain,
                          const struct row *row, num *qdd, int bias)
{
    svec up = chain_ground(s, bias);
    for (uint32_t k = 0; k < chain->length; k++) {
        const num *next = k + 1 < chain->length ? row[k + 1].F : NULL;
        svec a = total_acceleration(s, chain, k, &row[k].Iinv, sv_from(row[k].F), next);
        joint_acceleration(s, chain->body[k], a, up, qdd + s->body[chain->body[k]].v, bias);
        up = a;
    }
}

static size_t bytes(size_t length)
{
    return length * sizeof(struct row);
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    return TFA_V(tfa_factor_rows)(s, chain, rows);
}

static void solve(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias)
{
    forward(s, chain, rows, tau, bias);
    back(chain, rows, 1);
    accelerations(s, chain, rows, qdd, bias);
}

void TFA_V(tfa_forward_6rhs)(struct state *s, const struct tfa_chain *chain, struct row *row,
                             const num *tau, size_t stride)
{
    static const num none[36];
    for (uint32_t k = 0; k < chain->length; k++) {
        const struct tfa_body *b = &s->body[chain->body[k]];
        for (int e = 0; e < 36; e++)
            row[k].F[e] = num_of(0);
        row_forward(b, &row[k], k > 0 ? &row[k - 1] : NULL, none, tau + stride * b->v, stride, 6);
    }
}

/* F = A^-1 B tau for six right-hand sides in one go */
static struct row *forces_6rhs(struct state *s, const struct tfa_chain *chain, void *rows,
                               const num *tau, size_t stride)
{
    TFA_V(tfa_forward_6rhs)(s, chain, rows, tau, stride);
    back(chain, rows, 6);
    return rows;
}

CHAIN_METHOD(tfa) = {
    .inverts = 1, .bytes = bytes, .factor = factor, .solve = solve, .forces_6rhs = forces_6rhs};
