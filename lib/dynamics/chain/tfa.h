/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm along a chain that the caller chooses.
 */
#ifndef TFA_DYNAMICS_CHAIN_TFA_H
#define TFA_DYNAMICS_CHAIN_TFA_H

#include "dynamics/chain/chain.h"

/* Constant terms, once for each workspace; and of one body whose constants changed. */
void TFA_V(tfa_precompute)(struct state *s);
void TFA_V(tfa_precompute_body)(struct state *s, uint32_t body);

/* Factors the block rows of a chain whose side branches are reduced (chain_reduce_branches). row[0
 * .. length). TFA_E_SINGULAR with s->bad_body when an inertia on the chain cannot be inverted. */
int TFA_V(tfa_factor_rows)(struct state *s, const struct tfa_chain *chain, struct row *row);

/* Forward elimination of the right-hand sides B tau, six columns: F of a row is what it is with
 * nothing outboard of it, of the last row A^-1 B tau. tau of freedom j stands at tau[stride * j].
 */
void TFA_V(tfa_forward_6rhs)(struct state *s, const struct tfa_chain *chain, struct row *row,
                             const num *tau, size_t stride);

#endif
