/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The terms of h in tau = M qdd + h, apart: inner freedoms. Their sum is inverse dynamics at rest
 * of the joints. Velocities, wrenches and passive forces of the request must be loaded; they are
 * left as they were, s->dx, s->a and s->f are not.
 */
#ifndef TFA_DYNAMICS_SOLVE_BIAS_FORCE_H
#define TFA_DYNAMICS_SOLVE_BIAS_FORCE_H

#include "layout/state.h"

/* RNEA at rest */
void TFA_V(gravity_force)(struct state *s, num *out);
/* RNEA without gravity and wrenches: Coriolis and centrifugal forces; of a boosted state those in
 * its own frame (load.h) */
void TFA_V(velocity_force)(struct state *s, num *out);
/* damping times velocity */
void TFA_V(damping_force)(const struct state *s, num *out);
/* friction times the smooth sign of velocity (spatial/friction.h) */
void TFA_V(friction_force)(const struct state *s, num *out);
/* damping and friction */
void TFA_V(dissipative_force)(const struct state *s, num *out);
/* - sum of J^T wrench */
void TFA_V(external_force)(struct state *s, num *out);
/* p = M v, and dM/dt v - h; s->qdd_unrefined is written, too */
void TFA_V(generalised_momentum)(struct state *s, num *p, num *rate);

#endif
