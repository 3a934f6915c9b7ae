/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm by block cyclic reduction: the block rows of tfa_row.h, each assembled
 * for itself from its own body and the one before, then cyclic.h. Fijany & Featherstone 2013,
 * (46)-(49); the bias stays inside the right-hand side.
 */
#include "dynamics/chain/chain.h"
#include "dynamics/chain/cyclic.h"
#include "dynamics/chain/tfa_motion.h"
#include "dynamics/chain/tfa_row.h"

/* Factors kept: the block rows of the system, and behind them XI, Iinv, K, B of each body */
struct system {
    struct cyclic_row *c;
    struct row *r;
};

static inline struct system system_at(void *rows, size_t length)
{
    struct cyclic_row *c = rows;
    return (struct system){c, (struct row *)(void *)(c + length)};
}

static inline const struct joint_nd *freedoms(const struct state *s, const struct tfa_body *b)
{
    return b->joint_nd < 0 ? NULL : &s->joint_nd[b->joint_nd];
}

/* A_ii = I_i^-1 + K_i Y_i and A_{i,i-1} = -K_i XI_i; the first row has the ground before it:
 * A_11 = I_1^-1. Reads I^-1 of row k - 1. */
static void assemble(struct state *s, const struct tfa_chain *chain, struct system A, uint32_t k)
{
    const uint32_t i = chain->body[k];
    const struct tfa_body *b = &s->body[i];
    struct cyclic_row *c = &A.c[k];
    struct row *r = &A.r[k];
    s6_dense(c->D.a, &r->Iinv);
    if (k == 0)
        return;
    num KY[36];
    inverse_from_parent(s, i, &r[-1].Iinv, r->XI, KY);
    row_apply_K(r, b, KY, 6);
    for (int e = 0; e < 36; e++) {
        c->D.a[e] += KY[e];
        c->L[e] = -r->XI[e];
    }
    row_apply_K(r, b, c->L, 6);
}

static size_t bytes(size_t length)
{
    return length * (sizeof(struct cyclic_row) + sizeof(struct row));
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    const struct system A = system_at(rows, chain->length);
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        if (!inverse_inertia(s, i, &A.r[k].Iinv))
            return TFA_E_SINGULAR;
        row_joint(s, &A.r[k], freedoms(s, &s->body[i]), &s->body[i], &s->IA[i]);
    }
    for (uint32_t k = 0; k < chain->length; k++)
        assemble(s, chain, A, k);
    for (uint32_t k = 0; k + 1 < chain->length; k++) { /* A_{i,i+1}, from XI of row k + 1 */
        const struct tfa_body *b = &s->body[chain->body[k]];
        const xform *X = &s->X[chain->body[k + 1]];
        row_upper_block(&A.r[k], b, freedoms(s, b), &A.r[k + 1], X, A.c[k].U);
    }
    cyclic_factor(A.c, chain->length, CYCLIC_GENERAL);
    return TFA_OK;
}

/* F <- B tau + K (c + I^-1 p - X I^-1 p of the body before), where the first row sees minus the
 * ground's acceleration instead. Reads I^-1 of row k - 1. */
static void right_hand_side(const struct state *s, const struct tfa_chain *chain, struct system A,
                            uint32_t k, const num *tau, int bias)
{
    const uint32_t i = chain->body[k];
    const struct tfa_body *b = &s->body[i];
    const struct row *r = &A.r[k];
    num *F = A.c[k].x;
    const svec before =
        k > 0 ? sv_neg(s6_mul(&r[-1].Iinv, s->pA[b->parent])) : chain_ground(s, bias);
    svec known = sv_add(s6_mul(&r->Iinv, s->pA[i]), xform_motion(&s->X[i], before));
    if (chain_has_velocity_products(s, bias))
        known = sv_add(known, s->c[i]);
    sv_store(F, known);
    row_apply_K(r, b, F, 1);
    row_add_B(r, b, tau + b->v, 1, F, 1);
}

static void solve(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias)
{
    const struct system A = system_at(rows, chain->length);
    for (uint32_t k = 0; k < chain->length; k++)
        right_hand_side(s, chain, A, k, tau, bias);
    cyclic_solve(A.c, chain->length, CYCLIC_GENERAL, 1);
    svec up = chain_ground(s, bias);
    for (uint32_t k = 0; k < chain->length; k++) {
        const num *next = k + 1 < chain->length ? A.c[k + 1].x : NULL;
        const svec F = sv_from(A.c[k].x);
        const svec a = total_acceleration(s, chain, k, &A.r[k].Iinv, F, next);
        joint_acceleration(s, chain->body[k], a, up, qdd + s->body[chain->body[k]].v, bias);
        up = a;
    }
}

/* F = A^-1 B tau for six right-hand sides in one go */
static struct row *forces_6rhs(struct state *s, const struct tfa_chain *chain, void *rows,
                               const num *tau, size_t stride)
{
    const struct system A = system_at(rows, chain->length);
    for (uint32_t k = 0; k < chain->length; k++) {
        const struct tfa_body *b = &s->body[chain->body[k]];
        cyclic_clear(A.c[k].x);
        row_add_B(&A.r[k], b, tau + stride * b->v, stride, A.c[k].x, 6);
    }
    cyclic_solve(A.c, chain->length, CYCLIC_GENERAL, 6);
    for (uint32_t k = 0; k < chain->length; k++)
        for (int e = 0; e < 36; e++)
            A.r[k].F[e] = A.c[k].x[e];
    return A.r;
}

CHAIN_METHOD(tfa_cr) = {
    .inverts = 1, .bytes = bytes, .factor = factor, .solve = solve, .forces_6rhs = forces_6rhs};
