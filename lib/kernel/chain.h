/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Methods along a chain. A tree is its main chain with side branches; these are folded into the
 * chain by the articulated-body algorithm, so that a method sees an unbranched chain:
 *
 *   F_k - X_{k+1}^T F_{k+1} = I_k a_k + p_k          k = 0 .. length - 1, body i = chain->body[k]
 *   a_k   = X_k a_{k-1} + H_k qdd_k + c_k            I_k = s->IA[i], p_k = s->pA[i], X_k = s->X[i]
 *   tau_k = H_k^T F_k + R_k qdd_k                    c_k = s->c[i] (with bias), a_{-1} = -gravity
 */
#ifndef TFA_KERNEL_CHAIN_H
#define TFA_KERNEL_CHAIN_H

#include "kernel/state.h"

/* A method is one file and one row of the table in chain.c. */
struct chain_method {
    tfa_method method;
    int inverts; /* needs I_k^-1: bodies that have none are refused by name */
    /* What it keeps between factor and solve: bytes for a chain of so many bodies, at s->rows. */
    size_t (*bytes)(size_t length);
    /* Factors: s->IA is ready. TFA_OK, or TFA_E_SINGULAR with s->bad_body, or TFA_E_UNSUPPORTED. */
    int (*factor)(struct state *s, const struct tfa_chain *chain, void *rows);
    /* qdd of the chain's joints from tau, and in s->a the a_k of bodies that carry side branches, as
     * the method found them; s->pA is ready. Without bias: c = 0, p without v x* I v, no gravity.
     * Any number of times with the same factors; qdd may be tau. */
    void (*solve)(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias);
};

extern const struct chain_method TFA_V(tfa_method), TFA_V(tfa_cr_method), TFA_V(hessenberg_method),
    TFA_V(cfa_method), TFA_V(cfa_cr_method), TFA_V(dca_method), TFA_V(scan_method),
    TFA_V(scan_two_pass_method);

/* NULL: the method does not go along chains. */
const struct chain_method *TFA_V(chain_method)(tfa_method method);

/* Factors of every tree, unless they are there; solves of every tree. */
int TFA_V(chain_factor)(struct state *s, const struct chain_method *method);
void TFA_V(chain_solve)(struct state *s, const struct chain_method *method, const num *tau,
                        num *qdd, int bias);

/* Marks the chain and folds the inertias of all else of its tree into it. Refuses bodies without
 * inverse when `inverts`. */
int TFA_V(chain_fold)(struct state *s, const struct tfa_chain *chain, int inverts);

/* tau^T .. the joint's freedoms of body i on a chain: does the bias count? */
static inline int chain_products(const struct state *s, int bias)
{
    return bias && s->moving;
}

/* a_{-1}: minus gravity, or 0 without bias */
static inline svec chain_ground(const struct state *s, int bias)
{
    return (svec){{0, 0, 0}, bias ? v3_neg(s->gravity) : v3(0, 0, 0)};
}

#endif
