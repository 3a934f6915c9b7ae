/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Frames of links: where they stand, and six unit wrenches at one.
 */
#include "dynamics/kinematics/frame.h"

#include "dynamics/core/modes.h"
#include "layout/body.h"
#include "spatial/unit_wrenches.h"

/* Rotation from world axes to the axes of a body */
static mat3 world_axes(const struct state *s, int32_t body)
{
    mat3 R = s->X[body].E;
    for (int32_t i = s->body[body].parent; i >= 0; i = s->body[i].parent)
        R = m3_mm(R, s->X[i].E);
    return R;
}

/* The world's origin in body coordinates */
static vec3 world_origin(const struct state *s, int32_t body)
{
    mat3 R = s->X[body].E;
    vec3 o = v3_neg(m3_mul(R, s->X[body].r));
    for (int32_t i = s->body[body].parent; i >= 0; i = s->body[i].parent) {
        R = m3_mm(R, s->X[i].E);
        o = v3_sub(o, m3_mul(R, s->X[i].r));
    }
    return o;
}

xform TFA_V(frame_moved)(const struct state *s, uint32_t frame)
{
    const struct tfa_frame *f = &s->m->frame[frame];
    const struct tfa_body *b = &s->body[f->body];
    xform at = frame_xform(s->m, frame);
    if (f->handle >= 0)
        TFA_V(modes_move_frame)(s, f->handle, &at);
    for (uint32_t k = f->part; f->part && k < b->n; k++) {
        const xform *P = &s->joint_nd[b->joint_nd].part[k];
        at = (xform){m3_mm(P->E, at.E), m3_mul(P->E, v3_sub(at.r, P->r))};
    }
    return at;
}

uint32_t TFA_V(frame_freedoms)(const struct state *s, uint32_t frame)
{
    const struct tfa_frame *f = &s->m->frame[frame];
    return f->part ? f->part : s->body[f->body].n;
}

int32_t TFA_V(frame_at)(const struct state *s, uint32_t frame, tfa_reference_frame mode, mat3 *R,
                        vec3 *p)
{
    const num o = num_of(0), l = num_of(1);
    const int32_t body = s->m->frame[frame].body;
    const xform at = frame_in_body(s, frame);
    *R = at.E;
    *p = at.r;
    if (mode != TFA_FRAME_LOCAL)
        *R = body < 0 ? (mat3){l, o, o, o, l, o, o, o, l} : world_axes(s, body);
    if (mode == TFA_FRAME_WORLD)
        *p = body < 0 ? v3_zero() : world_origin(s, body);
    return body;
}

int32_t TFA_V(frame_columns)(const struct state *s, uint32_t frame, tfa_reference_frame mode,
                             svec P[6])
{
    mat3 R;
    vec3 p;
    const int32_t body = TFA_V(frame_at)(s, frame, mode, &R, &p);
    unit_wrenches(R, p, P);
    return body;
}
