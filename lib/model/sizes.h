/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sizes of a model: the characteristic length of operational space, and what the sentinel knows of
 * the bodies outboard of a joint.
 */
#ifndef TFA_MODEL_SIZES_H
#define TFA_MODEL_SIZES_H

#include "model/mass_properties.h"

/* Computes m->length, m->lever and the outboard sizes of each body; writes `length` of scratch[].
 * Cost: O(bodies). */
void tfa_compute_sizes(struct tfa_model *m, struct tfa_body *body,
                       struct tfa_mass_scratch *scratch);

#endif
