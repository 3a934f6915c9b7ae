/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Methods along a chain. A tree is its main chain with side branches; these are reduced into the
 * chain by the articulated-body algorithm, so that a method sees an unbranched chain:
 *
 *   F_k - X_{k+1}^T F_{k+1} = I_k a_k + p_k          k = 0 .. length - 1, body i = chain->body[k]
 *   a_k   = X_k a_{k-1} + H_k qdd_k + c_k            I_k = s->IA[i], p_k = s->pA[i], X_k = s->X[i]
 *   tau_k = H_k^T F_k + R_k qdd_k                    c_k = s->c[i] (with bias), a_{-1} = -gravity
 */
#ifndef TFA_DYNAMICS_CHAIN_CHAIN_H
#define TFA_DYNAMICS_CHAIN_CHAIN_H

#include "layout/state.h"

/* A method is one file and one row of the table in method.c. */
struct chain_method {
    /* Does it need I_k^-1? Bodies that have none are refused by name. */
    int inverts;
    /* Bytes of the factors of a chain of so many bodies, at s->rows, kept between factor and
     * solve */
    size_t (*bytes)(size_t length);
    /* Factors: s->IA is ready. TFA_OK, or TFA_E_SINGULAR with s->bad_body, or TFA_E_UNSUPPORTED. */
    int (*factor)(struct state *s, const struct tfa_chain *chain, void *rows);
    /* qdd of the chain's joints from tau, and in s->a the a_k of bodies that carry side branches,
     * as the method found them; s->pA is ready. Without bias: c = 0, p without v x* I v, no
     * gravity. Any number of times with the same factors; qdd may be tau. */
    void (*solve)(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias);
    /* Total forces without bias for six right-hand sides in one go, 6 x 6 in F of the rows that it
     * returns, which hold the inverse inertias too: A^-1 Pi of (74). Column j of tau is at tau[j],
     * its freedoms `stride` apart; s->pA is not read. NULL: Lambda^-1 by columns. */
    struct row *(*forces_6rhs)(struct state *s, const struct tfa_chain *chain, void *rows,
                               const num *tau, size_t stride);
    /* Lambda^-1 by a way of its own with kept factors, neither refined nor projected. Returns 0
     * where the answer is to be computed by columns. NULL: there is no such way. */
    int (*osim)(struct state *s, tfa_reference_frame frame);
};

/* Defines a method, for a row of method.c: CHAIN_METHOD(name) = {...}; */
#define CHAIN_METHOD(name)                                                                         \
    extern const struct chain_method TFA_V(name##_method);                                         \
    const struct chain_method TFA_V(name##_method)

/* Does it need I_k^-1? Bodies that have none are refused by name. */
static inline int method_inverts(tfa_method method)
{
    switch (method) {
#define METHOD_INVERTS(name, number, text, ops, factors, cost, refuses, summary)                   \
    case TFA_METHOD_##name:                                                                        \
        return ((refuses)&TFA_REFUSES_NO_INVERSE) != 0;
        TFA_METHOD_LIST(METHOD_INVERTS)
#undef METHOD_INVERTS
    }
    return 0;
}

/* The method whose factors it uses: forward elimination of the tips goes by block solves when
 * refined, force propagation by the articulated-body factors. */
static inline tfa_method method_factors(tfa_method method)
{
    switch (method) {
#define METHOD_FACTORS(name, number, text, ops, factors, cost, refuses, summary)                   \
    case TFA_METHOD_##name:                                                                        \
        return TFA_METHOD_##factors;
        TFA_METHOD_LIST(METHOD_FACTORS)
#undef METHOD_FACTORS
    }
    return method;
}

/* Factors of every tree, unless they are there; solves of every tree. */
int TFA_V(chain_factor)(struct state *s, const struct chain_method *method);
void TFA_V(chain_solve)(struct state *s, const struct chain_method *method, const num *tau,
                        num *qdd, int bias);

/* Marks the chain and adds the articulated inertias of the rest of its tree to it. Refuses bodies
 * without inverse when `inverts`. */
int TFA_V(chain_reduce_branches)(struct state *s, const struct tfa_chain *chain, int inverts);

/* Whether the body stands on the chain of its tree */
static inline int chain_has(const struct state *s, const struct tfa_chain *chain, int32_t body)
{
    const uint32_t k = s->body[body].depth - 1;
    return k < chain->length && chain->body[k] == (uint32_t)body;
}

/* The handle of the flexible body at place k that carries the next one on the chain; -1: none */
static inline int32_t handle_of_next(const struct state *s, const struct tfa_chain *chain,
                                     uint32_t k)
{
    return k + 1 < chain->length ? s->body[chain->body[k + 1]].handle : -1;
}

/* Whether velocity products count: with a bias, and when anything moves */
static inline int chain_has_velocity_products(const struct state *s, int bias)
{
    return bias && s->moving;
}

/* a_{-1}: minus gravity, or 0 without bias */
static inline svec chain_ground(const struct state *s, int bias)
{
    return (svec){v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};
}

#endif
