/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Velocities and velocity-product terms, outward.
 */
#include "kernel/kernel.h"
#include "kernel/velocity_step.h"

void TFA_V(velocity)(struct state *s)
{
    if (!s->moving)
        return;
    for (uint32_t i = 0; i < s->bodies; i++) {
        const terms *b = &s->body[i];
        if (s->locked && s->constraint[i] & CONSTRAINT_SILENT)
            continue;
        move(s, i, b);
        s->p[i] = sv_sub(gyroscopic(s, i), s->wrench[i]);
    }
}
