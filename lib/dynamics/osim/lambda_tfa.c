/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 by the one-sided form of TFA: the chain is the tip's own support, so that forward
 * elimination answers the diagonal block. With the unit wrenches P on the last body alone that is
 *   A F = e_N (C_N - I_N^-1) P^T,   Lambda^-1 = P I_N^-1 (F_N + P^T),
 * where F_N and P^T cancel: a light body hands nearly all of a wrench on, and I_N^-1 makes of the
 * rounding of P, which may be a thousand times Lambda^-1's (a finger of panda: rank 10 in place of
 * 7). Less the wrench itself, f_i = F_i + P_i^T with P_i^T carried to body i, it is the system of
 * (74): A f = B H^T P_i^T,   Lambda^-1 = P I_N^-1 f_N,   net force on body i: f_i - X_{i+1}^T
 * f_{i+1}
 */
#include "dynamics/chain/tfa.h"
#include "dynamics/chain/tfa_row.h"
#include "dynamics/osim/lambda.h"

/* The support of a body as a chain, root first. */
static struct tfa_chain support_chain(struct state *s, int32_t body)
{
    struct tfa_chain chain = {.length = s->body[body].depth, .body = s->path};
    for (int32_t i = body; i >= 0; i = s->body[i].parent)
        s->path[s->body[i].depth - 1] = (uint32_t)i;
    return chain;
}

/* The row of a body on its own support's chain */
static const struct row *row_of(const struct state *s, uint32_t body)
{
    return (const struct row *)(const void *)s->rows + (s->body[body].depth - 1);
}

static inline svec column(const num *F, int e)
{
    return (svec){{F[e], F[6 + e], F[12 + e]}, {F[18 + e], F[24 + e], F[30 + e]}};
}

static void put_block(struct state *s, uint32_t t, uint32_t u, const svec P[6], const svec a[6])
{
    const size_t n = 6 * s->tips;
    for (uint32_t e = 0; e < 6; e++)
        for (uint32_t f = 0; f < 6; f++) {
            num x = sv_dot(P[e], a[f]);
            if (t == u)
                x = (x + sv_dot(P[f], a[e])) / 2;
            s->lambda[(6 * t + e) * n + 6 * u + f] = x;
        }
}

/* The block of tips t and u from the accelerations that tip u's wrenches give its chain: tip t's
 * wrenches are propagated through its side branch to the first body of the chain. */
static void add_cross_block(struct state *s, uint32_t t, uint32_t u, const struct tfa_chain *chain,
                            tfa_reference_frame frame)
{
    svec P[6], f[6], a[6];
    struct tip_wrenches w;
    for (TFA_V(tip_start)(s, t, frame, &w); w.body >= 0 && !(s->side[w.body] & CHAIN);) {
        vec6 psi[6], phi[6];
        if (s->body[w.body].tree != s->body[chain->body[0]].tree)
            break;
        TFA_V(propagate_through_joint)(s, w.body, w.moved, &w.P, psi, phi);
        w.body = s->body[w.body].parent;
        w.moved = 6;
    }
    const int32_t i = w.body;
    if (i < 0 || !(s->side[i] & CHAIN))
        return; /* nothing that moves one moves the other: the block stays zero */
    wrench_columns_store(&w.P, P);
    uint32_t k = chain->length - 1;
    for (int e = 0; e < 6; e++)
        a[e] = f[e] = column(row_of(s, chain->body[k])->F, e);
    for (; chain->body[k] != (uint32_t)i; k--) { /* back substitution: f_k -= G_k f_{k+1} */
        const struct row *r = row_of(s, chain->body[k - 1]);
        for (int e = 0; e < 6; e++) {
            num out[6], in[6];
            sv_store(in, f[e]);
            m6_apply(out, r->G, in);
            const svec outboard = xform_t_force(&s->X[chain->body[k]], f[e]);
            f[e] = sv_sub(column(r->F, e), sv_from(out));
            a[e] = sv_sub(f[e], outboard);
        }
    }
    for (int e = 0; e < 6; e++)
        a[e] = s6_mul(&row_of(s, (uint32_t)i)->Iinv, a[e]);
    put_block(s, t, u, P, a);
}

int TFA_V(lambda_one_sided)(struct state *s, tfa_reference_frame frame)
{
    for (size_t k = 0; k < (size_t)36 * s->tips * s->tips; k++)
        s->lambda[k] = num_of(0);
    for (uint32_t t = 0; t < s->tips; t++)
        if (s->m->frame[s->tip[t]].part)
            return TFA_E_UNSUPPORTED; /* a force inside a joint is no right-hand side of a row */
    s->have &= ~(uint32_t)(HAVE_ABA | HAVE_LOCKED | HAVE_CHAIN);
    TFA_V(jacobian)(s, frame);
    for (uint32_t u = 0; u < s->tips; u++) {
        svec P[6], a[6];
        int32_t i = TFA_V(frame_columns)(s, s->tip[u], frame, P);
        if (i < 0)
            continue;
        struct tfa_chain chain = support_chain(s, i);
        int status = TFA_V(chain_reduce_branches)(s, &chain, 1);
        if (status == TFA_OK)
            status = TFA_V(tfa_factor_rows)(s, &chain, (struct row *)(void *)s->rows);
        if (status != TFA_OK)
            return status;
        const struct row *tip = row_of(s, (uint32_t)i);
        TFA_V(tfa_forward_6rhs)
        (s, &chain, (struct row *)(void *)s->rows, tip_columns(s, s->psi, 0, u),
         (size_t)6 * s->tips);
        for (int e = 0; e < 6; e++)
            a[e] = s6_mul(&tip->Iinv, column(tip->F, e));
        put_block(s, u, u, P, a);
        for (uint32_t t = 0; t < u; t++)
            add_cross_block(s, t, u, &chain, frame);
    }
    TFA_V(lambda_mirror)(s);
    return TFA_OK;
}
