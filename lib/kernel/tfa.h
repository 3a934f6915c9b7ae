/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm along a chain that the caller chooses.
 */
#ifndef TFA_KERNEL_TFA_H
#define TFA_KERNEL_TFA_H

#include "kernel/chain.h"

/* Factors the block rows of a chain whose side branches are folded (chain_fold). row[0 .. length).
 * TFA_E_SINGULAR with s->bad_body when an inertia on the chain cannot be inverted. */
int TFA_V(tfa_factor_rows)(struct state *s, const struct tfa_chain *chain, struct row *row);

/* Forward elimination of the right-hand sides B tau, six columns: F of a row is what it is with
 * nothing outboard of it, of the last row A^-1 B tau. tau of freedom j stands at tau[stride * j].
 */
void TFA_V(tfa_forward_six)(struct state *s, const struct tfa_chain *chain, struct row *row,
                            const num *tau, size_t stride);

#endif
