/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Velocities and velocity-product terms, outward.
 */
#include "dynamics/core/modes.h"
#include "dynamics/core/velocity_step.h"

void TFA_V(velocity)(struct state *s)
{
    if (!s->moving)
        return;
    if (HAS_MODES(s)) {
        TFA_V(modes_velocity)(s);
        return;
    }
    for (uint32_t i = 0; i < s->bodies; i++) {
        const body_constants *b = &s->body[i];
        if (s->locked && s->constraint[i] & CONSTRAINT_SKIPPED)
            continue;
        velocity_step(s, i, b, velocity_from_parent(s, i, b));
        s->p[i] = sv_sub(gyroscopic(s, i), s->wrench[i]);
    }
}
