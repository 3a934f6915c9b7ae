/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the caller's arrays to the state and back.
 */
#ifndef TFA_KERNEL_LOAD_H
#define TFA_KERNEL_LOAD_H

#include "kernel/state.h"

/* Reads states k .. k + count - 1 (at most NUM_LANES) of a checked request, the last one into the
 * lanes that are left over: pose and velocity terms are computed too. */
void TFA_V(load)(struct state *s, const tfa_request *r, uint32_t k, uint32_t count);

/* Writes freedoms as doubles to the base's and the joints' arrays of state k (either may be NULL),
 * those of the other lanes behind. Returns 1 when all are finite. */
int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints);

#endif
