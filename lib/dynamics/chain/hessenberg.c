/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The paper's (57), qdd = Wa^T P^T (K + L P^-1 I)^-1 B tau: a block upper Hessenberg matrix (56).
 *
 * With C = H Theta^-1 H^T, Theta = H^T I H + R, B = H Theta^-1 and K_i = 1 - C_i I_i (tfa_row.h)
 *   B tau = C F + K (P^T a - c),   (P^T a)_i = a_i - X_i a_{i-1},   P F = I a + p
 * so that (K P^T + C P^-1 I) a = B tau + K c - C P^-1 p: the paper's K is this K P^T, its L this C.
 * Its bias goes through tau (its eq. 2); here gravity and c stay local and only P^-1 p, the force
 * that velocities and wrenches cost outboard, does: -C P^-1 p = -B H^T P^-1 p.
 * Row i: 1 on the diagonal (K_i + C_i I_i), -K_i X_i before it, and C_i X_{i+1}^T .. X_j^T I_j in
 * column j > i: what the motion that joint i gives to body j costs there.
 *
 * Solved as what it is, a dense block Hessenberg matrix: elimination of the blocks below the
 * diagonal, partial pivoting inside the diagonal blocks, 216 N^2 / 2 multiplications; each further
 * right-hand side 36 N^2 / 2. It keeps the whole upper triangle, 36 N (N - 1) / 2 numbers.
 * No inverse inertia stands in the matrix, and it shows: 10 times less error than tfa on random
 * chains, 10^7 times less on thin ones (tests/dynamics/chain/chains_dca_table.c). Bodies without
 * inverse are refused all the same: Theta is no better where a point lies on its joint's axis.
 */
#include "dynamics/chain/chain.h"
#include "dynamics/chain/tfa_motion.h"
#include "dynamics/chain/tfa_row.h"

/* Block rows are struct row: K, B; S: the diagonal block, factored; F: right-hand side, then a; XI:
 * times row i - 1 it is to be taken from row i; the rest is not used. The blocks right of the
 * diagonal stand behind all rows. */

/* Blocks i, i+1 .. i, length - 1 of 36 numbers each */
static inline num *upper(struct row *rows, size_t length, size_t i)
{
    return (num *)(rows + length) + 36 * (i * (2 * length - i - 1) / 2);
}

/* C_i X_{i+1}^T .. X_j^T I_j for all j > i: B_i times the rows I_j m, m the motion of body j when
 * the joint's freedom moves at unit rate */
static void row_upper_blocks(struct state *s, const struct tfa_chain *chain, struct row *rows,
                             uint32_t i)
{
    const struct tfa_body *b = &s->body[chain->body[i]];
    num *U = upper(rows, chain->length, i);
    for (uint32_t k = 0; k < b->n; k++) {
        num one[6] = {0}, B[6] = {0};
        svec m = sv_zero();
        one[k] = 1;
        row_add_B(&rows[i], b, one, 1, B, 1);
        add_joint_motion(s, b, one, &m);
        for (uint32_t j = i + 1; j < chain->length; j++) {
            const uint32_t o = chain->body[j];
            num cost[6], *block = U + 36 * (size_t)(j - i - 1);
            m = xform_motion(&s->X[o], m);
            sv_store(cost, s6_mul(&s->IA[o], m));
            for (int e = 0; e < 6; e++)
                for (int f = 0; f < 6; f++)
                    block[6 * e + f] = (k ? block[6 * e + f] : 0) + B[e] * cost[f];
        }
    }
}

/* The block -K_i X_i before the diagonal times the inverse of the diagonal block of row i - 1:
 * by the factors of that block's transpose, D. */
static void row_multiplier(struct state *s, uint32_t body, struct row *r, struct lu6 *D)
{
    num below[36], transposed[36];
    for (int k = 0; k < 6; k++) {
        svec unit = sv_zero();
        num column[6];
        sv_put(&unit, k, -1);
        sv_store(column, xform_motion(&s->X[body], unit));
        for (int e = 0; e < 6; e++)
            below[6 * e + k] = column[e];
    }
    row_apply_K(r, &s->body[body], below, 6);
    for (int e = 0; e < 36; e++)
        transposed[e] = below[6 * (e % 6) + e / 6];
    lu6_factor(D);
    lu6_solve(D, transposed, 6);
    for (int e = 0; e < 36; e++)
        r->XI[e] = transposed[6 * (e % 6) + e / 6];
}

/* block -= r->XI above */
static inline void sub_product(const struct row *r, const num *above, num *block)
{
    num product[36];
    m6_mul(product, r->XI, above);
    for (int e = 0; e < 36; e++)
        block[e] -= product[e];
}

/* Row i less the multiple of row i - 1 that clears the entry before its diagonal */
static void row_eliminate(struct state *s, const struct tfa_chain *chain, struct row *rows,
                          uint32_t i)
{
    struct row *r = &rows[i];
    struct lu6 D;
    for (int e = 0; e < 36; e++)
        r->S.a[e] = (num)(e % 7 == 0);
    if (i > 0) {
        const struct lu6 *before = &rows[i - 1].S;
        const num *above = upper(rows, chain->length, i - 1);
        num *U = upper(rows, chain->length, i);
        for (int e = 0; e < 36; e++)
            D.a[e] = before->a[6 * (e % 6) + e / 6];
        row_multiplier(s, chain->body[i], r, &D);
        sub_product(r, above, r->S.a);
        for (size_t j = 0; j + i + 1 < chain->length; j++)
            sub_product(r, above + 36 * (j + 1), U + 36 * j);
        lu6_factor(&rows[i - 1].S);
    }
    if (i + 1 == chain->length)
        lu6_factor(&r->S);
}

static size_t bytes(size_t length)
{
    if (length > TFA_HESSENBERG_LONGEST)
        return 0;
    return length * sizeof(struct row) + length * (length - 1) / 2 * 36 * sizeof(num);
}

static int factor(struct state *s, const struct tfa_chain *chain, void *memory)
{
    struct row *rows = memory;
    if (chain->length > TFA_HESSENBERG_LONGEST)
        return TFA_E_UNSUPPORTED; /* tfa_request_check has said so */
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        const struct tfa_body *b = &s->body[i];
        struct row *r = &rows[k];
        row_joint(s, r, b->joint_nd < 0 ? NULL : &s->joint_nd[b->joint_nd], b, &s->IA[i]);
        row_upper_blocks(s, chain, rows, k);
        row_eliminate(s, chain, rows, k);
    }
    return TFA_OK;
}

/* F <- B (tau - H^T g) + K c, less the multiple of the row before, where g = P^-1 p; the first row
 * sees the ground's acceleration, too */
static void forward(struct state *s, const struct tfa_chain *chain, struct row *rows,
                    const num *tau, int bias)
{
    svec g = sv_zero();
    for (uint32_t k = chain->length; k-- > 0;) {
        const uint32_t i = chain->body[k];
        const struct tfa_body *b = &s->body[i];
        struct row *r = &rows[k];
        svec known = chain_has_velocity_products(s, bias) ? s->c[i] : sv_zero();
        num active[6];
        g = sv_add(g, s->pA[i]);
        joint_force(s, b, g, active);
        g = xform_t_force(&s->X[i], g);
        for (uint32_t j = 0; j < b->n; j++)
            active[j] = tau[b->v + j] - active[j];
        if (k == 0)
            known = sv_add(known, xform_motion(&s->X[i], chain_ground(s, bias)));
        sv_store(r->F, known);
        row_apply_K(r, b, r->F, 1);
        row_add_B(r, b, active, 1, r->F, 1);
    }
    for (uint32_t k = 1; k < chain->length; k++) {
        num above[6];
        m6_apply(above, rows[k].XI, rows[k - 1].F);
        for (int e = 0; e < 6; e++)
            rows[k].F[e] -= above[e];
    }
}

/* F <- a */
static void back(const struct tfa_chain *chain, struct row *rows)
{
    for (uint32_t i = chain->length; i-- > 0;) {
        const num *U = upper(rows, chain->length, i);
        num *a = rows[i].F;
        for (uint32_t j = i + 1; j < chain->length; j++, U += 36) {
            num share[6];
            m6_apply(share, U, rows[j].F);
            for (int e = 0; e < 6; e++)
                a[e] -= share[e];
        }
        lu6_solve(&rows[i].S, a, 1);
    }
}

static void solve(struct state *s, const struct tfa_chain *chain, void *memory, const num *tau,
                  num *qdd, int bias)
{
    struct row *rows = memory;
    forward(s, chain, rows, tau, bias);
    back(chain, rows);
    svec up = chain_ground(s, bias);
    for (uint32_t k = 0; k < chain->length; k++) { /* qdd = Wa^T (P^T a - c) */
        const svec a = sv_from(rows[k].F);
        joint_acceleration(s, chain->body[k], a, up, qdd + s->body[chain->body[k]].v, bias);
        up = a;
    }
}

CHAIN_METHOD(hessenberg) = {.inverts = 1, .bytes = bytes, .factor = factor, .solve = solve};
