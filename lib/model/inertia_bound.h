/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Upper bounds of the inertia that each joint moves.
 */
#ifndef TFA_MODEL_INERTIA_BOUND_H
#define TFA_MODEL_INERTIA_BOUND_H

#include "model/model.h"

/* Moments of a subtree: mass (kg), upper bounds of its first and second moment about the origin of
 * its root body's frame (kg m, kg m^2), and of its inertia about that frame's z axis (kg m^2) */
struct tfa_moments {
    double mass, first, second, about_z;
};

/* Computes bound[] of each body, m->reach and m->length. `scratch`: one element for each body,
 * `stride` bytes apart. Cost: O(bodies). */
void tfa_inertia_bounds(struct tfa_model *m, struct tfa_body *body, struct tfa_moments *scratch,
                        size_t stride);

#endif
