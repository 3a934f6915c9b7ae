/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joint transform of one body: X_i = Z(q_i) T_i.
 */
#ifndef TFA_DYNAMICS_CORE_POSE_STEP_H
#define TFA_DYNAMICS_CORE_POSE_STEP_H

#include "dynamics/core/revolute.h"
#include "layout/body.h"

/* Rotation from joint axes to body axes of a quaternion x y z w of any norm near 1. */
static inline mat3 rotation_from_quaternion(const num *o)
{
    num x = o[0], y = o[1], z = o[2], w = o[3];
    num s = 2 / (x * x + y * y + z * z + w * w);
    return (mat3){1 - s * (y * y + z * z), s * (x * y + w * z),     s * (x * z - w * y),
                  s * (x * y - w * z),     1 - s * (x * x + z * z), s * (y * z + w * x),
                  s * (x * z + w * y),     s * (y * z - w * x),     1 - s * (x * x + y * y)};
}

static inline xform revolute_xform(mat3 T, vec3 r, num sine, num cosine)
{
    return (xform){revolute_rotate(T, sine, cosine), r};
}

static inline xform prismatic_xform(mat3 T, vec3 r, num q)
{
    return (xform){T, v3_add_scaled(r, v3(T.zx, T.zy, T.zz), q)};
}

/* X = X_n .. X_1 of the parts, and H with the columns of all parts in the frame of the last one:
 * the axis of part k, moved on by the parts after it. */
static void pose_fused(struct state *s, uint32_t i)
{
    const body_constants *b = body_constants_of(s, i);
    const num *q = s->q + b->q, *sine = s->sine + b->q, *cosine = s->cosine + b->q;
    struct joint_nd *w = &s->joint_nd[b->joint_nd];
    const num o = num_of(0), l = num_of(1);
    xform X = {{l, o, o, o, l, o, o, o, l}, {o, o, o}};
    for (uint32_t k = 0; k < b->n; k++) {
        const xform T = part_xform(s->m, b->part + k);
        const int rotates = is_revolute(s->m->part[b->part + k].kind);
        if (rotates)
            w->part[k] = revolute_xform(T.E, T.r, sine[k], cosine[k]);
        else
            w->part[k] = prismatic_xform(T.E, T.r, q[k]);
        const xform *P = &w->part[k];
        for (uint32_t j = 0; j < k; j++)
            sv_store(w->H + 6 * j, xform_motion(P, sv_from(w->H + 6 * j)));
        for (uint32_t e = 0; e < 6; e++)
            w->H[6 * k + e] = num_of(e == (rotates ? 2 : 5));
        X = xform_compose(&X, P);
    }
    s->X[i] = X;
}

static inline void pose_joint_nd(struct state *s, uint32_t i, const num *q)
{
    const body_constants *b = body_constants_of(s, i);
    mat3 T = body_E(b);
    vec3 r = body_r(b);
    if (is_planar(b->kind)) {
        s->X[i].E = revolute_rotate(T, s->sine[b->q + 2], s->cosine[b->q + 2]);
        s->X[i].r = v3_add(r, m3_tmul(T, v3(q[0], q[1], num_of(0))));
    } else {
        s->X[i].E = m3_mm(rotation_from_quaternion(q + 3), T);
        s->X[i].r = v3_add(r, m3_tmul(T, v3(q[0], q[1], q[2])));
    }
}

static inline void pose_body(struct state *s, uint32_t i)
{
    const body_constants *b = body_constants_of(s, i);
    if (is_revolute(b->kind)) {
        s->X[i] = revolute_xform(body_E(b), body_r(b), s->sine[b->q], s->cosine[b->q]);
    } else if (is_prismatic(b->kind)) {
        s->X[i] = prismatic_xform(body_E(b), body_r(b), s->q[b->q]);
    } else if (is_fused(b->kind)) {
        pose_fused(s, i);
    } else {
        pose_joint_nd(s, i, b->base ? s->base : s->q + b->q);
    }
}

#endif
