/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Vectors and matrices of three: by value, so that the compiler keeps them in registers.
 */
#ifndef TFA_SPATIAL_VEC3_H
#define TFA_SPATIAL_VEC3_H

#include "spatial/num.h"

typedef struct vec3 {
    num x, y, z;
} vec3;

typedef struct mat3 {
    num xx, xy, xz, yx, yy, yz, zx, zy, zz;
} mat3;

typedef struct sym3 {
    num xx, xy, xz, yy, yz, zz;
} sym3;

static inline vec3 v3(num x, num y, num z)
{
    return (vec3){x, y, z};
}

static inline vec3 v3_zero(void)
{
    return v3(num_of(0), num_of(0), num_of(0));
}

static inline vec3 v3_load(const double *p)
{
    return (vec3){num_of(p[0]), num_of(p[1]), num_of(p[2])};
}

static inline vec3 v3_add(vec3 a, vec3 b)
{
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline vec3 v3_sub(vec3 a, vec3 b)
{
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline vec3 v3_neg(vec3 a)
{
    return (vec3){-a.x, -a.y, -a.z};
}

static inline vec3 v3_scale(vec3 a, num s)
{
    return (vec3){a.x * s, a.y * s, a.z * s};
}

/* a + b s; in one expression, so that kernels of one robot may fuse it */
static inline vec3 v3_add_scaled(vec3 a, vec3 b, num s)
{
    return (vec3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static inline num v3_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec3 v3_cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline mat3 m3_load(const double *p)
{
    return (mat3){num_of(p[0]), num_of(p[1]), num_of(p[2]), num_of(p[3]), num_of(p[4]),
                  num_of(p[5]), num_of(p[6]), num_of(p[7]), num_of(p[8])};
}

/* E v */
static inline vec3 m3_mul(mat3 E, vec3 v)
{
    return (vec3){E.xx * v.x + E.xy * v.y + E.xz * v.z, E.yx * v.x + E.yy * v.y + E.yz * v.z,
                  E.zx * v.x + E.zy * v.y + E.zz * v.z};
}

/* E^T v */
static inline vec3 m3_tmul(mat3 E, vec3 v)
{
    return (vec3){E.xx * v.x + E.yx * v.y + E.zx * v.z, E.xy * v.x + E.yy * v.y + E.zy * v.z,
                  E.xz * v.x + E.yz * v.y + E.zz * v.z};
}

static inline mat3 m3_t(mat3 A)
{
    return (mat3){A.xx, A.yx, A.zx, A.xy, A.yy, A.zy, A.xz, A.yz, A.zz};
}

static inline mat3 m3_add(mat3 A, mat3 B)
{
    return (mat3){A.xx + B.xx, A.xy + B.xy, A.xz + B.xz, A.yx + B.yx, A.yy + B.yy,
                  A.yz + B.yz, A.zx + B.zx, A.zy + B.zy, A.zz + B.zz};
}

/* A B */
static inline mat3 m3_mm(mat3 A, mat3 B)
{
    return (mat3){A.xx * B.xx + A.xy * B.yx + A.xz * B.zx, A.xx * B.xy + A.xy * B.yy + A.xz * B.zy,
                  A.xx * B.xz + A.xy * B.yz + A.xz * B.zz, A.yx * B.xx + A.yy * B.yx + A.yz * B.zx,
                  A.yx * B.xy + A.yy * B.yy + A.yz * B.zy, A.yx * B.xz + A.yy * B.yz + A.yz * B.zz,
                  A.zx * B.xx + A.zy * B.yx + A.zz * B.zx, A.zx * B.xy + A.zy * B.yy + A.zz * B.zy,
                  A.zx * B.xz + A.zy * B.yz + A.zz * B.zz};
}

/* A^T B */
static inline mat3 m3_tmm(mat3 A, mat3 B)
{
    return m3_mm(m3_t(A), B);
}

/* E^T S E and E S E^T for a symmetric S: the upper triangle only */
static inline sym3 s3_congruence_t(mat3 E, sym3 S)
{
    mat3 Sf = {S.xx, S.xy, S.xz, S.xy, S.yy, S.yz, S.xz, S.yz, S.zz};
    mat3 T = m3_mm(Sf, E);
    return (sym3){E.xx * T.xx + E.yx * T.yx + E.zx * T.zx, E.xx * T.xy + E.yx * T.yy + E.zx * T.zy,
                  E.xx * T.xz + E.yx * T.yz + E.zx * T.zz, E.xy * T.xy + E.yy * T.yy + E.zy * T.zy,
                  E.xy * T.xz + E.yy * T.yz + E.zy * T.zz, E.xz * T.xz + E.yz * T.yz + E.zz * T.zz};
}

static inline sym3 s3_congruence(mat3 E, sym3 S)
{
    return s3_congruence_t(m3_t(E), S);
}

static inline mat3 m3_congruence_t(mat3 E, mat3 B)
{
    return m3_tmm(E, m3_mm(B, E));
}

static inline vec3 s3_mul(sym3 S, vec3 v)
{
    return (vec3){S.xx * v.x + S.xy * v.y + S.xz * v.z, S.xy * v.x + S.yy * v.y + S.yz * v.z,
                  S.xz * v.x + S.yz * v.y + S.zz * v.z};
}

TFA_INLINE num s3_trace(sym3 A)
{
    return A.xx + A.yy + A.zz;
}

static inline sym3 s3_add(sym3 A, sym3 B)
{
    return (sym3){A.xx + B.xx, A.xy + B.xy, A.xz + B.xz, A.yy + B.yy, A.yz + B.yz, A.zz + B.zz};
}

/* rx M: the columns are r x m_k */
static inline mat3 cross_m3(vec3 r, mat3 M)
{
    return (mat3){r.y * M.zx - r.z * M.yx, r.y * M.zy - r.z * M.yy, r.y * M.zz - r.z * M.yz,
                  r.z * M.xx - r.x * M.zx, r.z * M.xy - r.x * M.zy, r.z * M.xz - r.x * M.zz,
                  r.x * M.yx - r.y * M.xx, r.x * M.yy - r.y * M.xy, r.x * M.yz - r.y * M.xz};
}

#endif
