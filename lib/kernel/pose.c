/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joint transforms from joint coordinates: X_i = Z(q_i) T_i.
 */
#include "kernel/kernel.h"

/* Axes turned by the angle about z: the first two rows of E mix, the third stays. */
static inline mat3 turn_z(mat3 E, num s, num c)
{
    return (mat3){c * E.xx + s * E.yx,
                  c * E.xy + s * E.yy,
                  c * E.xz + s * E.yz,
                  c * E.yx - s * E.xx,
                  c * E.yy - s * E.xy,
                  c * E.yz - s * E.xz,
                  E.zx,
                  E.zy,
                  E.zz};
}

/* Rotation from joint axes to body axes of a quaternion x y z w of any norm near 1. */
static mat3 quaternion_axes(const num *o)
{
    num x = o[0], y = o[1], z = o[2], w = o[3];
    num s = 2 / (x * x + y * y + z * z + w * w);
    return (mat3){1 - s * (y * y + z * z), s * (x * y + w * z),     s * (x * z - w * y),
                  s * (x * y - w * z),     1 - s * (x * x + z * z), s * (y * z + w * x),
                  s * (x * z + w * y),     s * (y * z - w * x),     1 - s * (x * x + y * y)};
}

/* H of planar and free joints: unit axes, linear freedoms first. */
static void unit_axes(struct multi *u, const struct tfa_body *b)
{
    static const uint8_t planar[] = {3, 4, 2}, free_joint[] = {3, 4, 5, 0, 1, 2};
    const uint8_t *axis = b->kind == TFA_KIND_PLANAR ? planar : free_joint;
    for (int k = 0; k < b->n; k++)
        for (int e = 0; e < 6; e++)
            u->H[6 * k + e] = num_of(e == axis[k]);
}

static inline place revolute(mat3 T, vec3 r, num sine, num cosine)
{
    return (place){turn_z(T, sine, cosine), r};
}

static inline place prismatic(mat3 T, vec3 r, num q)
{
    return (place){T, v3_add(r, v3_scale(v3(T.zx, T.zy, T.zz), q))};
}

/* X = X_n .. X_1 of the parts, and H with the columns of all parts in the frame of the last one:
 * the axis of part k, moved on by the parts after it. */
static void pose_fused(struct state *s, uint32_t i)
{
    const struct tfa_body *b = &s->body[i];
    const num *q = s->q + b->q, *sine = s->sine + b->q, *cosine = s->cosine + b->q;
    struct multi *w = &s->multi[b->multi];
    const num o = num_of(0), l = num_of(1);
    place X = {{l, o, o, o, l, o, o, o, l}, {o, o, o}};
    for (uint32_t k = 0; k < b->n; k++) {
        const struct tfa_part *part = &s->m->part[b->part + k];
        const int turns = part->kind == TFA_KIND_REVOLUTE;
        if (turns)
            w->part[k] = revolute(m3_load(part->E), v3_load(part->r), sine[k], cosine[k]);
        else
            w->part[k] = prismatic(m3_load(part->E), v3_load(part->r), q[k]);
        const place *P = &w->part[k];
        for (uint32_t j = 0; j < k; j++)
            sv_store(w->H + 6 * j, x_motion(P, sv_from(w->H + 6 * j)));
        for (uint32_t e = 0; e < 6; e++)
            w->H[6 * k + e] = num_of(e == (turns ? 2 : 5));
        X.r = v3_add(X.r, m3_tmul(X.E, P->r));
        X.E = m3_mm(P->E, X.E);
    }
    s->X[i] = X;
}

static void pose_multi(struct state *s, uint32_t i, const num *q)
{
    const struct tfa_body *b = &s->body[i];
    mat3 T = m3_load(b->E);
    vec3 r = v3_load(b->r);
    unit_axes(&s->multi[b->multi], b);
    if (b->kind == TFA_KIND_PLANAR) {
        s->X[i].E = turn_z(T, s->sine[b->q + 2], s->cosine[b->q + 2]);
        s->X[i].r = v3_add(r, m3_tmul(T, v3(q[0], q[1], num_of(0))));
    } else {
        s->X[i].E = m3_mm(quaternion_axes(q + 3), T);
        s->X[i].r = v3_add(r, m3_tmul(T, v3(q[0], q[1], q[2])));
    }
}

static inline void pose_body(struct state *s, uint32_t i)
{
    const struct tfa_body *b = &s->body[i];
    if (b->kind == TFA_KIND_REVOLUTE) {
        s->X[i] = revolute(m3_load(b->E), v3_load(b->r), s->sine[b->q], s->cosine[b->q]);
    } else if (b->kind == TFA_KIND_PRISMATIC) {
        s->X[i] = prismatic(m3_load(b->E), v3_load(b->r), s->q[b->q]);
    } else if (b->kind == TFA_KIND_FUSED) {
        pose_fused(s, i);
    } else {
        pose_multi(s, i, b->base ? s->base : s->q + b->q);
    }
}

/* Of all coordinates of the bodies in a span, angles or not: they go by the vector. */
static void turn(struct state *s, struct span span)
{
    if (span.first == span.end)
        return; /* nothing moves */
    const uint32_t end = span.end < s->m->bodies ? s->body[span.end].q : s->m->inner_q;
    num_sincos_many(s->q, s->sine, s->cosine, s->body[span.first].q, end);
}

void TFA_V(pose)(struct state *s)
{
    if (s->have & HAVE_POSE)
        return;
    for (uint32_t k = 0; k < s->spans; k++)
        turn(s, s->span[k]);
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            if (!(s->holding && s->posture[i] & POSTURE_SILENT))
                pose_body(s, i);
    s->have |= HAVE_POSE;
}
