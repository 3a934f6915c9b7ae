/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joint transforms from joint coordinates: X_i = Z(q_i) T_i.
 */
#include "dynamics/core/modes.h"
#include "dynamics/core/pose_step.h"

void TFA_V(unit_axes)(struct state *s)
{
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->m->body[i];
        if (!has_constant_axes(b->kind))
            continue;
        for (int k = 0; k < b->n; k++)
            for (int e = 0; e < 6; e++)
                s->joint_nd[b->joint_nd].H[6 * k + e] = num_of(e == joint_types[b->kind].axis[k]);
    }
}

/* Of all coordinates of the bodies in a span, angles or not: they go by the vector. */
static void compute_sincos(struct state *s, struct span span)
{
    if (span.first == span.end)
        return; /* nothing moves */
    const uint32_t end = span.end < s->bodies ? s->body[span.end].q : s->coordinates;
    const uint32_t first = s->body[span.first].q;
    num_sincos_many(s->q, s->sine, s->cosine, first, end);
    for (uint32_t k = first; s->round_sincos && k < end; k++) {
        s->sine[k] = num_rounded(s->sine[k]);
        s->cosine[k] = num_rounded(s->cosine[k]);
    }
}

void TFA_V(pose)(struct state *s)
{
    if (s->have & HAVE_POSE)
        return;
    for (uint32_t k = 0; k < s->spans; k++)
        compute_sincos(s, s->span[k]);
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            if (!(s->locked && s->constraint[i] & CONSTRAINT_SKIPPED))
                pose_body(s, i);
    if (HAS_MODES(s))
        TFA_V(modes_pose)(s);
    s->have |= HAVE_POSE;
}
