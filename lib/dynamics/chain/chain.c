/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From trees to chains and back, around every method that goes along a chain.
 */
#include "dynamics/chain/chain.h"

#include "dynamics/core/aba_step.h"
#include "dynamics/core/modes.h"

/* Classifies bodies: on the chain, or on its side branches. Only the chain's own tree takes
 * part. */
static void mark(struct state *s, const struct tfa_chain *chain)
{
    const struct tfa_model *m = s->m;
    const int32_t tree = s->body[chain->body[0]].tree;
    for (uint32_t i = 0; i < m->bodies; i++)
        s->side[i] = s->body[i].tree == tree ? SIDE : 0;
    for (uint32_t k = 0; k < chain->length; k++)
        s->side[chain->body[k]] = CHAIN;
    for (uint32_t i = 0; i < m->bodies; i++)
        if (s->side[i] == SIDE && s->side[s->body[i].parent] & CHAIN)
            s->side[s->body[i].parent] |= HAS_BRANCH;
}

/* Reduces the side branches of the marked tree into its chain. */
static inline void backward_side_branches(struct state *s, const num *tau, int flags)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = 0; i < m->bodies; i++)
        if (s->side[i]) {
            aba_backward_start(s, i, flags);
            modes_start(s, i, tau, flags);
        }
    for (uint32_t i = m->bodies; i-- > 0;)
        if (s->side[i] == SIDE) {
            modes_eliminate(s, i, flags);
            TFA_V(aba_backward_body)(s, i, tau, flags);
        }
}

int TFA_V(chain_reduce_branches)(struct state *s, const struct tfa_chain *chain, int inverts)
{
    for (uint32_t k = 0; inverts && k < chain->length; k++)
        if (!num_all(s->Iinv[chain->body[k]].A.xx > 0)) {
            s->bad_body = (int32_t)chain->body[k];
            return TFA_E_SINGULAR;
        }
    mark(s, chain);
    backward_side_branches(s, NULL, ABA_INERTIA | ABA_MODES);
    return TFA_OK;
}

int TFA_V(chain_factor)(struct state *s, const struct chain_method *method)
{
    char *rows = s->rows;
    if (s->have & HAVE_CHAIN && s->chain_method == method)
        return TFA_OK;
    s->have &=
        ~(uint32_t)(HAVE_ABA | HAVE_LOCKED | HAVE_CHAIN); /* side branches use their arrays */
    for (uint32_t t = 0; t < s->m->trees; t++) {
        const struct tfa_chain *chain = &s->m->chain[t];
        int status = TFA_V(chain_reduce_branches)(s, chain, method->inverts);
        if (status == TFA_OK)
            status = method->factor(s, chain, rows);
        if (status != TFA_OK)
            return status;
        rows += method->bytes(chain->length);
    }
    s->have |= HAVE_CHAIN;
    s->chain_method = method;
    return TFA_OK;
}

/* Outward through the side branches, from the accelerations that the method found for the chain.
 * Those that follow from its qdd, joint by joint, drift away from them: on random side branches of
 * 1024 bodies two passes of the scan had 54 times the error of ABA with these, 1.4 times with its
 * own (qdd, median of 7, 2026-11-22). */
static void forward_side_branches(struct state *s, const struct tfa_chain *chain, num *qdd,
                                  int bias)
{
    const int products = chain_has_velocity_products(s, bias);
    for (uint32_t i = chain->first; i < chain->end; i++)
        if (s->side[i] == SIDE) {
            const svec parent = modes_at_handle(s, s->body[i].handle, s->a[s->body[i].parent], qdd);
            aba_forward_step(s, i, parent, qdd, products);
            modes_forward(s, i, qdd);
        }
}

void TFA_V(chain_solve)(struct state *s, const struct chain_method *method, const num *tau,
                        num *qdd, int bias)
{
    char *rows = s->rows;
    for (uint32_t t = 0; t < s->m->trees; t++) {
        const struct tfa_chain *chain = &s->m->chain[t];
        mark(s, chain);
        if (chain_has_velocity_products(s, bias))
            backward_side_branches(s, tau, ABA_FORCE | ABA_BIAS | ABA_MODES);
        else
            backward_side_branches(s, tau, ABA_FORCE | ABA_MODES);
        method->solve(s, chain, rows, tau, qdd, bias);
        if (chain->end - chain->first > chain->length)
            forward_side_branches(s, chain, qdd, bias);
        rows += method->bytes(chain->length);
    }
}
