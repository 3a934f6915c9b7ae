/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rigid inertias: ten numbers, which the transform to a parent keeps ten. Featherstone 2008, 2.13
 * and table A.4; through a screw in halves, as in screw.h.
 */
#ifndef TFA_SPATIAL_RIGID_H
#define TFA_SPATIAL_RIGID_H

#include "spatial/screw.h"

typedef struct rigid {
    num m;  /* mass */
    vec3 h; /* mass times centre of mass */
    sym3 I; /* inertia about the origin */
} rigid;

TFA_INLINE rigid rigid_zero(void)
{
    const num o = num_of(0);
    return (rigid){o, v3_zero(), {o, o, o, o, o, o}};
}

TFA_INLINE rigid rigid_add(const rigid *a, const rigid *b)
{
    return (rigid){a->m + b->m, v3_add(a->h, b->h), s3_add(a->I, b->I)};
}

/* Columns of the inertia: rotation about z, translation along z */
TFA_INLINE svec rigid_column_rz(const rigid *a)
{
    return (svec){v3(a->I.xz, a->I.yz, a->I.zz), v3(-a->h.y, a->h.x, num_of(0))};
}

TFA_INLINE svec rigid_column_tz(const rigid *a)
{
    return (svec){v3(a->h.y, -a->h.x, num_of(0)), v3(num_of(0), num_of(0), a->m)};
}

/* About an origin from which the old one stands at r: with g = h + m r / 2,
 *   I <- I + 2 (g . r) 1 - g r^T - r g^T,  h <- h + m r */
TFA_INLINE rigid rigid_shift(vec3 r, const rigid *a)
{
    const vec3 h = v3_add_scaled(a->h, r, a->m);
    const vec3 g = v3_add(a->h, h); /* 2 g */
    const num half = num_of(0.5), x = g.x * r.x, y = g.y * r.y, z = g.z * r.z;
    return (rigid){a->m,
                   h,
                   {a->I.xx + y + z, a->I.xy - half * (g.x * r.y + g.y * r.x),
                    a->I.xz - half * (g.x * r.z + g.z * r.x), a->I.yy + x + z,
                    a->I.yz - half * (g.y * r.z + g.z * r.y), a->I.zz + x + y}};
}

/* X^T I X */
TFA_INLINE rigid rigid_to_parent(const xform *X, const rigid *a)
{
    const rigid R = {a->m, m3_tmul(X->E, a->h), s3_congruence_t(X->E, a->I)};
    return rigid_shift(X->r, &R);
}

/* The same of a screw */
TFA_INLINE rigid screw_rigid_to_parent(const screw *k, const rigid *a)
{
    rigid R = *a;
    num xz = R.I.xz, yz = R.I.yz;
    rotate_sym2(&R.I.xx, &R.I.xy, &R.I.yy, k->c, k->n);
    R.h = rotate_z(R.h, k->c, -k->n);
    R.I.xz = k->c * xz + k->n * yz - k->d * R.h.x;
    R.I.yz = k->c * yz - k->n * xz - k->d * R.h.y;
    const num along_z = R.h.z + k->d * R.m;
    R.I.xx += k->d * (R.h.z + along_z);
    R.I.yy += k->d * (R.h.z + along_z);
    R.h.z = along_z;

    num xy = R.I.xy;
    xz = R.I.xz;
    rotate_sym2(&R.I.yy, &R.I.yz, &R.I.zz, k->ca, k->na);
    R.h = rotate_x(R.h, k->ca, -k->na);
    R.I.xy = k->ca * xy + k->na * xz - k->a * R.h.y;
    R.I.xz = k->ca * xz - k->na * xy - k->a * R.h.z;
    const num along_x = R.h.x + k->a * R.m;
    R.I.yy += k->a * (R.h.x + along_x);
    R.I.zz += k->a * (R.h.x + along_x);
    R.h.x = along_x;
    return R;
}

#endif
