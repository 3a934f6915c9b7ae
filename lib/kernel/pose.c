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
            u->H[6 * k + e] = (num)(e == axis[k]);
}

static void pose_multi(struct state *s, uint32_t i, const num *q)
{
    const struct tfa_body *b = &s->m->body[i];
    mat3 T = m3_load(b->E);
    vec3 r = v3_load(b->r);
    unit_axes(&s->multi[b->multi], b);
    if (b->kind == TFA_KIND_PLANAR) {
        num sine, cosine;
        num_sincos(q[2], &sine, &cosine);
        s->X[i].E = turn_z(T, sine, cosine);
        s->X[i].r = v3_add(r, m3_tmul(T, v3(q[0], q[1], 0)));
    } else {
        s->X[i].E = m3_mm(quaternion_axes(q + 3), T);
        s->X[i].r = v3_add(r, m3_tmul(T, v3(q[0], q[1], q[2])));
    }
}

void TFA_V(pose)(struct state *s, const double *base_pose, const double *q)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = 0; k < m->q_count; k++)
        s->q[k] = (num)q[k];
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &m->body[i];
        if (b->kind == TFA_KIND_REVOLUTE) {
            num_sincos(s->q[b->q], &s->sine[b->q], &s->cosine[b->q]);
            s->X[i].E = turn_z(m3_load(b->E), s->sine[b->q], s->cosine[b->q]);
            s->X[i].r = v3_load(b->r);
        } else if (b->kind == TFA_KIND_PRISMATIC) {
            mat3 T = m3_load(b->E);
            s->X[i].E = T;
            s->X[i].r = v3_add(v3_load(b->r), v3_scale(v3(T.zx, T.zy, T.zz), s->q[b->q]));
        } else if (b->base) {
            num base[7];
            for (int k = 0; k < 7; k++)
                base[k] = (num)base_pose[k];
            pose_multi(s, i, base);
        } else {
            pose_multi(s, i, s->q + b->q);
        }
    }
}
