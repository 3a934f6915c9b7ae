/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transforms between the frames of Denavit and Hartenberg: about and along the parent's x by alpha
 * and a, then about and along the own z by theta and d. Each half touches two of three components,
 * so that vectors take 20 multiplications instead of 24, inertias 115 instead of 147 (or 180 of a
 * full one). McMillan & Orin 1995. Turned by products of sines and cosines alone, not by
 * differences of squares: a right angle exchanges a large inertia and a tiny one without the loss
 * of a digit.
 */
#ifndef TFA_SPATIAL_SCREW_H
#define TFA_SPATIAL_SCREW_H

#include "spatial/spatial.h"

/* X = Rz(theta) shift(d z) Rx(alpha) shift(a x) */
typedef struct screw {
    num c, n;   /* cosine of theta, and its sine with the other sign, as they stand in X.E */
    num ca, na; /* of alpha */
    num a, d;
} screw;

TFA_INLINE screw screw_of(const xform *X, num d)
{
    return (screw){X->E.xx, X->E.yx, X->E.zz, X->E.zy, X->r.x, d};
}

/* Rz v and Rz^T v; Rx v and Rx^T v */
TFA_INLINE vec3 rotate_z(vec3 v, num c, num n)
{
    return v3(c * v.x - n * v.y, c * v.y + n * v.x, v.z);
}

TFA_INLINE vec3 rotate_x(vec3 v, num c, num n)
{
    return v3(v.x, c * v.y - n * v.z, c * v.z + n * v.y);
}

/* X m: a motion from the parent's frame to the child's */
TFA_INLINE svec screw_motion(const screw *k, svec m)
{
    m.v.y += k->a * m.w.z;
    m.v.z -= k->a * m.w.y;
    m = (svec){rotate_x(m.w, k->ca, k->na), rotate_x(m.v, k->ca, k->na)};
    m.v.x += k->d * m.w.y;
    m.v.y -= k->d * m.w.x;
    return (svec){rotate_z(m.w, k->c, k->n), rotate_z(m.v, k->c, k->n)};
}

/* X^T f: a force from the child's frame to the parent's */
TFA_INLINE svec screw_t_force(const screw *k, svec f)
{
    f = (svec){rotate_z(f.w, k->c, -k->n), rotate_z(f.v, k->c, -k->n)};
    f.w.x -= k->d * f.v.y;
    f.w.y += k->d * f.v.x;
    f = (svec){rotate_x(f.w, k->ca, -k->na), rotate_x(f.v, k->ca, -k->na)};
    f.w.y -= k->a * f.v.z;
    f.w.z += k->a * f.v.y;
    return f;
}

/* R^T [xx xy; xy yy] R with R = [c -n; n c] */
TFA_INLINE void rotate_sym2(num *xx, num *xy, num *yy, num c, num n)
{
    const num x = c * *xx + n * *xy, y = c * *xy + n * *yy;
    const num p = c * *xy - n * *xx, q = c * *yy - n * *xy;
    *xx = c * x + n * y;
    *xy = c * p + n * q;
    *yy = c * q - n * p;
}

/* The half about z of X^T S X; rows and columns z of A and row z of B are zero, and stay so */
TFA_INLINE void screw_inertia_z(const screw *k, sym6 *S)
{
    const num c = k->c, n = k->n, d = k->d;
    rotate_sym2(&S->A.xx, &S->A.xy, &S->A.yy, c, n);
    rotate_sym2(&S->M.xx, &S->M.xy, &S->M.yy, c, n);
    const vec3 m = rotate_z(v3(S->M.xz, S->M.yz, S->M.zz), c, -n);
    const vec3 b = rotate_z(v3(S->B.xz, S->B.yz, S->B.zz), c, -n);
    const num xx = c * S->B.xx + n * S->B.yx, xy = c * S->B.xy + n * S->B.yy;
    const num yx = c * S->B.yx - n * S->B.xx, yy = c * S->B.yy - n * S->B.xy;
    const num Bxy = c * xy - n * xx, Byx = c * yx + n * yy, Byy = c * yy - n * yx;
    S->M.xz = m.x;
    S->M.yz = m.y;
    S->B.xx = c * xx + n * xy - d * S->M.xy; /* B + d z x M */
    S->B.xy = Bxy - d * S->M.yy;
    S->B.xz = b.x - d * m.y;
    S->B.yx = Byx + d * S->M.xx;
    S->B.yy = Byy + d * S->M.xy;
    S->B.yz = b.y + d * m.x;
    S->A.xx -= d * (Bxy + S->B.xy);
    S->A.xy += d * (S->B.xx - Byy);
    S->A.yy += d * (Byx + S->B.yx);
}

/* X^T S X where the rows and columns of S for the rotation about z are exactly zero */
TFA_INLINE sym6 screw_to_parent_zero_z(const screw *k, const sym6 *S0)
{
    const num c = k->ca, n = k->na, a = k->a;
    sym6 S = *S0;
    screw_inertia_z(k, &S);
    const num y = c * S.A.yy, z = n * S.A.yy;
    sym3 A = {S.A.xx, c * S.A.xy, -n * S.A.xy, c * y, -n * y, n * z};
    sym3 M = {S.M.xx, c * S.M.xy + n * S.M.xz, c * S.M.xz - n * S.M.xy, S.M.yy, S.M.yz, S.M.zz};
    rotate_sym2(&M.yy, &M.yz, &M.zz, c, n);
    const num by = c * S.B.yy + n * S.B.yz, bz = c * S.B.yz - n * S.B.yy;
    const mat3 B = {S.B.xx,
                    c * S.B.xy + n * S.B.xz,
                    c * S.B.xz - n * S.B.xy,
                    c * S.B.yx,
                    c * by,
                    c * bz,
                    -n * S.B.yx,
                    -n * by,
                    -n * bz};
    const mat3 C = {B.xx,
                    B.xy,
                    B.xz, /* B + a x x M */
                    B.yx - a * M.xz,
                    B.yy - a * M.yz,
                    B.yz - a * M.zz,
                    B.zx + a * M.xy,
                    B.zy + a * M.yy,
                    B.zz + a * M.yz};
    A.xy -= a * C.xz;
    A.xz += a * C.xy;
    A.yy -= a * (B.yz + C.yz);
    A.yz += a * (C.yy - B.zz);
    A.zz += a * (B.zy + C.zy);
    return (sym6){A, C, M};
}

#endif
