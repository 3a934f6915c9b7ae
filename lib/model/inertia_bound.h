/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Upper bounds of the inertia that each joint moves.
 */
#ifndef TFA_MODEL_INERTIA_BOUND_H
#define TFA_MODEL_INERTIA_BOUND_H

#include "model/model.h"

/* Of a subtree: mass (kg), upper bounds of its first and second moment about the origin of its root
 * body's frame (kg m, kg m^2), and of its inertia about that frame's axis z */
struct tfa_moments {
    double mass, first, second, about_z;
};

/* Fills bound[] of each body and m->reach from masses, places and armatures. `scratch`: bodies
 * elements, one in each of a caller's structures that are `stride` bytes apart. Cost: O(bodies). */
void tfa_inertia_bounds(struct tfa_model *m, struct tfa_body *body, struct tfa_moments *scratch,
                        size_t stride);

#endif
