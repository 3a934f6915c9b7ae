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

#endif
