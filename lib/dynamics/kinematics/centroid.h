/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Quantities of all bodies together, in world axes: mass, centre of mass and its Jacobian,
 * momentum, energy. The pose is needed, and the world poses of TFA_V(world_poses). O(N)
 */
#ifndef TFA_DYNAMICS_KINEMATICS_CENTROID_H
#define TFA_DYNAMICS_KINEMATICS_CENTROID_H

#include "layout/state.h"

/* Mass of all bodies, and their centre; 0 without mass */
num TFA_V(centre_of_mass)(const struct state *s, vec3 *com);

/* s->v of a boosted state as those in the world. Overwrites s->a. */
void TFA_V(return_boost)(struct state *s);

/* Linear momentum, and angular momentum about a point. Needs the velocities of all bodies. */
svec TFA_V(momentum)(const struct state *s, vec3 about);

/* v^T M v / 2, rotors included. The same. */
num TFA_V(kinetic_energy)(const struct state *s);

/* - m gravity . com */
num TFA_V(potential_energy)(const struct state *s);

/* The Jacobian of the centre of mass into 3 rows of `stride` doubles that are zero: public columns.
 * Overwrites s->f. */
void TFA_V(com_jacobian)(struct state *s, double *out, size_t stride);

#endif
