/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Divide and conquer (Featherstone 1999): subassemblies of the chain with two handles, assembled in
 * pairs.
 *
 * A subassembly of bodies a..z answers forces at its handles (on body a in frame a, on body z in
 * frame z)
 *   a_a = P1 f_a + P12 f_z + b1        P1, P2 symmetric positive definite: inverse inertias
 *   a_z = P12^T f_a + P2 f_z + b2      one body: P1 = P12 = P2 = I^-1, b1 = b2 = -I^-1 p
 * Joint j, f across it, joins A inboard to B outboard: f_z of A is -X^T f, f_a of B is f, so
 *   V f = beta + H qdd                 V = P1_B + X P2_A X^T
 *   beta = Y f_a - Z f_z + beta_0      Y = X P12_A^T,  Z = P12_B,  beta_0 = X b2_A + c - b1_B
 *   tau = H^T f + R qdd                f = W beta + T tau,  qdd = N tau - T^T beta
 * and the joined subassembly has
 *   P1 = P1_A - Y^T W Y     P12 = Y^T W Z     P2 = P2_B - Z^T W Z
 *   b1 = b1_A - Y^T (W beta_0 + T tau)        b2 = b2_B + Z^T (W beta_0 + T tau)
 * Each joint is assembled once: joint m at the level of its lowest bit, subassemblies m - 2^l .. m
 * - 1 and m .. m + 2^l - 1 or to the end. Joint 0 attaches all to the ground, which has no inverse
 * inertia. Levels are a loop; the assemblies of a level do not depend on each other. O(N), log2 N
 * levels. Digits are lost in I^-1 and in the differences P1_A - Y^T W Y of large numbers: light
 * subassemblies between heavy ones, thin ones.
 */
#include "dynamics/chain/chain.h"
#include "dynamics/chain/joint_basis.h"
#include "dynamics/chain/tfa_row.h"
#include "dynamics/core/modes.h"

/* Body k of the chain, and the assembly at its joint. */
struct subassembly {
    sym6 Iinv;
    sym6 W;      /* constraint force per relative acceleration; 0: six freedoms, no armature */
    num T[36];   /* rows of T^T, n of them */
    num N[36];   /* n x n: qdd per tau */
    num Y[36];   /* relative acceleration per force at the inboard handle */
    num Z[36];   /* and, negative, at the outboard handle */
    sym6 P1, P2; /* of the subassembly that starts with body k, as large as it is by now */
    num P12[36];
    svec b1, b2; /* the same */
    svec beta0;
    svec f1, f2; /* forces at the handles of the subassembly that starts with body k */
};

/* A <- L D L^T of its first m columns; the others become their Schur complement.
 * 1/D on the diagonal of those, lower triangle. */
static inline void ldl_partial(num A[36], uint32_t m)
{
    for (uint32_t k = 0; k < m; k++) {
        const num inv = 1 / A[7 * k];
        for (uint32_t i = k + 1; i < 6; i++) {
            const num l = A[6 * i + k] * inv;
            for (uint32_t j = k + 1; j <= i; j++)
                A[6 * i + j] -= l * A[6 * j + k];
        }
        for (uint32_t i = k + 1; i < 6; i++)
            A[6 * i + k] *= inv;
        A[7 * k] = inv;
    }
}

/* Lower triangle of Q V Q^T for the rows of Q */
static inline void in_basis(const struct tfa_body *b, const num Q[36], const sym6 *V, num A[36])
{
    if (b->n == 1) { /* rows are unit vectors, the joint's axis last */
        const uint32_t axis = (uint32_t)body_axis(b);
        const uint32_t at[6] = {0, 1, axis > 2 ? 2 : 3, axis > 2 ? 3 : 4, axis > 2 ? 4 : 5, axis};
        num D[36];
        s6_dense(D, V);
        for (uint32_t i = 0; i < 6; i++)
            for (uint32_t j = 0; j <= i; j++)
                A[6 * i + j] = D[6 * at[i] + at[j]];
        return;
    }
    for (uint32_t j = 0; j < 6; j++) {
        const svec VQ = s6_mul(V, sv_from(Q + 6 * j));
        for (uint32_t i = j; i < 6; i++)
            A[6 * i + j] = sv_dot(sv_from(Q + 6 * i), VQ);
    }
}

/* K = (1 + S R)^-1, n x n in rows of six; returns 0 without armature, when it is 1 */
static inline int armature_factor(const struct tfa_body *b, const num *S, const num *R, num *K)
{
    struct lu6 lu;
    num any = num_of(0);
    for (uint32_t k = 0; k < b->n; k++)
        any += R[k];
    if (!num_all(any > 0))
        return 0;
    if (b->n == 1) {
        K[0] = 1 / (1 + S[0] * R[0]);
        return 1;
    }
    for (uint32_t e = 0; e < 36; e++)
        K[e] = lu.a[e] = num_of(e % 7 == 0);
    for (uint32_t k = 0; k < b->n; k++)
        for (uint32_t j = 0; j < b->n; j++)
            lu.a[6 * k + j] += S[6 * k + j] * R[j];
    lu6_factor(&lu);
    lu6_solve(&lu, K, 6);
    return 1;
}

/* T = G K^T, N = K S, W += G R K G^T for the n vectors of G and their Schur complement S */
static inline void joint_add_armature(const struct tfa_body *b, const svec *G, const num *S,
                                      const num *R, const num *K, struct subassembly *h)
{
    num extra[36] = {0};
    for (uint32_t k = 0; k < b->n; k++) {
        svec t = sv_zero();
        for (uint32_t j = 0; j < b->n; j++)
            t = sv_add(t, sv_scale(G[j], K[6 * k + j]));
        sv_store(h->T + 6 * k, t);
        num g[6];
        sv_store(g, sv_scale(G[k], R[k]));
        for (uint32_t e = 0; e < 6; e++)
            for (uint32_t f = e; f < 6; f++)
                extra[6 * e + f] += g[e] * h->T[6 * k + f];
        for (uint32_t j = 0; j < b->n; j++) {
            h->N[6 * k + j] = num_of(0);
            for (uint32_t l = 0; l < b->n; l++)
                h->N[6 * k + j] += K[6 * k + l] * S[6 * l + j];
        }
    }
    const sym6 add = s6_from_dense(extra);
    s6_add(&h->W, &add);
}

/* W, T and N of a joint from V. In the basis (W, Wa) the constraint comes first; its factors give
 * directions g that V makes orthogonal, without taking a difference of inverses:
 *   W = sum over the constraint of g g^T / d + G R K G^T,  T = G K^T,  N = K S
 * with the last n of them G, S their Schur complement and K = (1 + S R)^-1; no armature: K = 1. */
static void joint_solver(const struct state *s, const struct tfa_body *b, const sym6 *V,
                         struct subassembly *h)
{
    const uint32_t n = b->n, m = 6 - n;
    num Q[36], A[36], S[36], R[6], K[36];
    svec g[6];
    joint_basis(s, b, Q);
    in_basis(b, Q, V, A);
    ldl_partial(A, m);
    h->W = (sym6){0};
    for (uint32_t i = 0; i < 6; i++) {
        g[i] = sv_from(Q + 6 * i);
        for (uint32_t j = 0; j < i && j < m; j++)
            g[i] = sv_sub(g[i], sv_scale(g[j], A[6 * i + j]));
        if (i < m)
            s6_rank1(&h->W, g[i], -A[7 * i]);
    }
    for (uint32_t k = 0; k < n; k++) {
        R[k] = joint_armature(s, b, k);
        sv_store(h->T + 6 * k, g[m + k]);
        for (uint32_t j = 0; j < n; j++)
            S[6 * k + j] = h->N[6 * k + j] =
                j <= k ? A[6 * (m + k) + m + j] : A[6 * (m + j) + m + k];
    }
    if (armature_factor(b, S, R, K))
        joint_add_armature(b, g + m, S, R, K, h);
}

/* f = W beta + T tau, qdd = N tau - T^T beta; qdd may be NULL, or tau */
static inline svec joint_solve(const struct subassembly *h, const struct tfa_body *b, svec beta,
                               const num *tau, num *qdd)
{
    svec f = s6_mul(&h->W, beta);
    num x[6];
    for (uint32_t k = 0; k < b->n; k++) {
        const svec t = sv_from(h->T + 6 * k);
        f = sv_add(f, sv_scale(t, tau[k]));
        x[k] = -sv_dot(t, beta);
        for (uint32_t j = 0; j < b->n; j++)
            x[k] += h->N[6 * k + j] * tau[j];
    }
    for (uint32_t k = 0; qdd && k < b->n; k++)
        qdd[k] = x[k];
    return f;
}

/* S -= the symmetric product A^T B, from its upper triangle */
static inline void sub_product(sym6 *S, const num *A, const num *B)
{
    num o[36] = {0};
    for (int i = 0; i < 6; i++)
        for (int j = i; j < 6; j++)
            for (int k = 0; k < 6; k++)
                o[6 * i + j] -= A[6 * k + i] * B[6 * k + j];
    const sym6 product = s6_from_dense(o);
    s6_add(S, &product);
}

/* Assembles A and the subassembly that starts with the joint's body (h) into A. */
static void assemble_pair(struct state *s, uint32_t i, struct subassembly *A, struct subassembly *h)
{
    sym6 V = s6_inv_to_child(&s->X[i], &A->P2);
    num W[36], WY[36], WZ[36];
    s6_add(&V, &h->P1);
    joint_solver(s, &s->body[i], &V, h);
    for (int k = 0; k < 6; k++) { /* columns of P12^T are rows of P12 */
        num column[6];
        sv_store(column, xform_motion(&s->X[i], sv_from(A->P12 + 6 * k)));
        for (int e = 0; e < 6; e++)
            h->Y[6 * e + k] = column[e];
    }
    for (int e = 0; e < 36; e++)
        h->Z[e] = h->P12[e];
    s6_dense(W, &h->W);
    m6_mul(WY, W, h->Y);
    m6_mul(WZ, W, h->Z);
    sub_product(&A->P1, h->Y, WY);
    A->P2 = h->P2;
    sub_product(&A->P2, h->Z, WZ);
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < 6; f++) {
            num sum = num_of(0);
            for (int k = 0; k < 6; k++)
                sum += h->Y[6 * k + e] * WZ[6 * k + f];
            A->P12[6 * e + f] = sum;
        }
}

/* A flexible body whose outboard handle moves with its modes: with J = IA of modes.h, Phi of the
 * handle, A = 1 - Phi D^-1 W and C = Phi D^-1 Phi^T
 *   P1 = J^-1,  P12 = J^-1 A^T,  P2 = A J^-1 A^T + C */
static void flexible_start(const struct state *s, uint32_t i, int32_t handle, struct subassembly *h)
{
    num psi[6 * TFA_MAX_LINK_MODES], phi[6 * TFA_MAX_LINK_MODES], AJA[36];
    svec P[6]; /* columns of A^T */
    for (int e = 0; e < 6; e++) {
        P[e] = sv_zero();
        sv_put(&P[e], e, num_of(1));
    }
    const uint32_t n = TFA_V(modes_propagate)(s, i, handle, P, psi, phi);
    for (int e = 0; e < 6; e++) {
        num column[6];
        sv_store(column, s6_mul(&h->Iinv, P[e]));
        for (int f = 0; f < 6; f++) {
            h->P12[6 * f + e] = column[f];
            AJA[6 * f + e] = sv_dot(P[f], sv_from(column));
        }
    }
    for (uint32_t k = 0; k < n; k++)
        for (int e = 0; e < 6; e++)
            for (int f = 0; f < 6; f++)
                AJA[6 * e + f] += psi[6 * k + (uint32_t)e] * phi[6 * k + (uint32_t)f];
    h->P2 = s6_from_dense(AJA);
}

/* The body's acceleration by the force f1 on it and f2 on its handle, and that of its modes. s->pA
 * stays as it was. */
static svec flexible_solve(struct state *s, uint32_t i, int32_t handle, const sym6 *Iinv, svec f1,
                           svec f2, num *qdd)
{
    const svec p = s->pA[i];
    if (handle >= 0)
        TFA_V(modes_add_force)(s, handle, sv_neg(f2));
    s->pA[i] = sv_sub(p, f2);
    TFA_V(modes_eliminate_body)(s, i, ABA_FORCE);
    s->a[i] = s6_mul(Iinv, sv_sub(f1, s->pA[i]));
    TFA_V(modes_forward_body)(s, i, qdd);
    s->pA[i] = p;
    return s->a[i];
}

static int subassemblies_start(struct state *s, const struct tfa_chain *chain,
                               struct subassembly *subassembly)
{
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        struct subassembly *h = &subassembly[k];
        if (s->body[i].flexible >= 0)
            TFA_V(modes_eliminate_body)(s, i, ABA_INERTIA);
        if (!(s->side[i] & HAS_BRANCH) && s->body[i].flexible < 0) {
            h->Iinv = s->Iinv[i];
        } else if (!s6_invert(&s->IA[i], &h->Iinv)) {
            s->bad_body = (int32_t)i;
            return TFA_E_SINGULAR;
        }
        h->P1 = h->P2 = h->Iinv;
        s6_dense(h->P12, &h->Iinv);
        if (handle_of_next(s, chain, k) >= 0)
            flexible_start(s, i, handle_of_next(s, chain, k), h);
    }
    return TFA_OK;
}

static size_t bytes(size_t length)
{
    return length * sizeof(struct subassembly);
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    struct subassembly *subassembly = rows;
    const int status = subassemblies_start(s, chain, subassembly);
    if (status != TFA_OK)
        return status;
    for (size_t half = 1; half < chain->length; half *= 2)
        for (size_t m = half; m < chain->length; m += 2 * half)
            assemble_pair(s, chain->body[m], &subassembly[m - half], &subassembly[m]);
    joint_solver(s, &s->body[chain->body[0]], &subassembly[0].P1, &subassembly[0]);
    return TFA_OK;
}

/* y = A^T x */
static inline svec multiply_transposed(const num *A, svec x)
{
    num in[6], out[6] = {0};
    sv_store(in, x);
    for (int k = 0; k < 6; k++)
        for (int e = 0; e < 6; e++)
            out[e] += A[6 * k + e] * in[k];
    return sv_from(out);
}

static inline svec multiply(const num *A, svec x)
{
    num in[6], out[6];
    sv_store(in, x);
    m6_apply(out, A, in);
    return sv_from(out);
}

/* Assembly: b1 and b2 of all subassemblies, beta_0 of all joints */
static void assemble(struct state *s, const struct tfa_chain *chain,
                     struct subassembly *subassembly, const num *tau, num *qdd, int products)
{
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        struct subassembly *h = &subassembly[k];
        if (s->body[i].flexible < 0) {
            h->b1 = h->b2 = sv_sub(sv_zero(), s6_mul(&h->Iinv, s->pA[i]));
            continue;
        }
        h->b1 = flexible_solve(s, i, -1, &h->Iinv, sv_zero(), sv_zero(), qdd);
        h->b2 = modes_at_handle(s, handle_of_next(s, chain, k), h->b1, qdd);
    }
    for (size_t half = 1; half < chain->length; half *= 2)
        for (size_t m = half; m < chain->length; m += 2 * half) {
            const uint32_t i = chain->body[m];
            const struct tfa_body *b = &s->body[i];
            struct subassembly *A = &subassembly[m - half], *h = &subassembly[m];
            h->beta0 = sv_sub(xform_motion(&s->X[i], A->b2), h->b1);
            if (products)
                h->beta0 = sv_add(h->beta0, s->c[i]);
            const svec f = joint_solve(h, b, h->beta0, tau + b->v, NULL);
            A->b1 = sv_sub(A->b1, multiply_transposed(h->Y, f));
            A->b2 = sv_add(h->b2, multiply_transposed(h->Z, f));
        }
}

/* Disassembly: from the forces at a subassembly's handles the force across the joint within it */
static void disassemble(struct state *s, const struct tfa_chain *chain,
                        struct subassembly *subassembly, const num *tau, num *qdd)
{
    size_t half = 1;
    while (2 * half < chain->length)
        half *= 2;
    for (; half > 0; half /= 2)
        for (size_t m = half; m < chain->length; m += 2 * half) {
            const uint32_t i = chain->body[m];
            const struct tfa_body *b = &s->body[i];
            struct subassembly *A = &subassembly[m - half], *h = &subassembly[m];
            svec beta = sv_add(h->beta0, multiply(h->Y, A->f1));
            beta = sv_sub(beta, multiply(h->Z, A->f2));
            h->f1 = joint_solve(h, b, beta, tau + b->v, qdd + b->v);
            h->f2 = A->f2;
            A->f2 = sv_sub(sv_zero(), xform_t_force(&s->X[i], h->f1));
        }
}

static void solve(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias)
{
    struct subassembly *subassembly = rows;
    const uint32_t root = chain->body[0];
    const struct tfa_body *b = &s->body[root];
    const int products = chain_has_velocity_products(s, bias);
    assemble(s, chain, subassembly, tau, qdd, products);
    svec beta = sv_sub(xform_motion(&s->X[root], chain_ground(s, bias)), subassembly[0].b1);
    if (products)
        beta = sv_add(beta, s->c[root]);
    subassembly[0].f1 = joint_solve(&subassembly[0], b, beta, tau + b->v, qdd + b->v);
    subassembly[0].f2 = sv_zero();
    disassemble(s, chain, subassembly, tau, qdd);
    for (uint32_t k = 0; k < chain->length; k++) {
        const uint32_t i = chain->body[k];
        if (s->body[i].flexible >= 0)
            (void)flexible_solve(s, i, handle_of_next(s, chain, k), &subassembly[k].Iinv,
                                 subassembly[k].f1, subassembly[k].f2, qdd);
        else if (s->side[i] & HAS_BRANCH)
            s->a[i] = s6_mul(&subassembly[k].Iinv,
                             sv_sub(sv_add(subassembly[k].f1, subassembly[k].f2), s->pA[i]));
    }
}

CHAIN_METHOD(dca) = {.inverts = 1, .bytes = bytes, .factor = factor, .solve = solve};
