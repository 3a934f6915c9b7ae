/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm along a chain that the caller chooses.
 */
#ifndef TFA_KERNEL_TFA_H
#define TFA_KERNEL_TFA_H

#include "kernel/state.h"

/* Marks the chain, folds everything else of its tree into it and factors the block rows.
 * TFA_E_SINGULAR with s->bad_body when an inertia on the chain cannot be inverted. */
int TFA_V(tfa_factor_chain)(struct state *s, const struct tfa_chain *chain);

#endif
