/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Spatial vectors (angular first), transforms kept as rotation and offset, and symmetric 6 x 6
 * inertias in blocks. Featherstone 2008, chapter 2 and appendix A.
 */
#ifndef TFA_SPATIAL_SPATIAL_H
#define TFA_SPATIAL_SPATIAL_H

#include "spatial/vec3.h"

/* Motion: w angular velocity, v velocity of the origin. Force: w moment about the origin, v
 * force. */
typedef struct svec {
    vec3 w, v;
} svec;

/* X: from a parent's frame to a frame whose axes are E (parent -> child coordinates) and whose
 * origin stands at r in the parent's frame. */
typedef struct xform {
    mat3 E;
    vec3 r;
} xform;

/* Symmetric 6 x 6: [A B; B^T M]. As an inertia, A takes angular motion to moment. */
typedef struct sym6 {
    sym3 A;
    mat3 B;
    sym3 M;
} sym6;

static inline svec sv_zero(void)
{
    return (svec){v3_zero(), v3_zero()};
}

static inline sym6 s6_zero(void)
{
    const num o = num_of(0);
    return (sym6){{o, o, o, o, o, o}, {o, o, o, o, o, o, o, o, o}, {o, o, o, o, o, o}};
}

static inline svec sv_add(svec a, svec b)
{
    return (svec){v3_add(a.w, b.w), v3_add(a.v, b.v)};
}

static inline svec sv_sub(svec a, svec b)
{
    return (svec){v3_sub(a.w, b.w), v3_sub(a.v, b.v)};
}

static inline svec sv_neg(svec a)
{
    return (svec){v3_neg(a.w), v3_neg(a.v)};
}

static inline svec sv_scale(svec a, num s)
{
    return (svec){v3_scale(a.w, s), v3_scale(a.v, s)};
}

/* a + b s */
static inline svec sv_add_scaled(svec a, svec b, num s)
{
    return (svec){v3_add_scaled(a.w, b.w, s), v3_add_scaled(a.v, b.v, s)};
}

/* a in the lanes where m holds, b elsewhere */
static inline svec sv_select(num_mask m, svec a, svec b)
{
    return (svec){
        {num_select(m, a.w.x, b.w.x), num_select(m, a.w.y, b.w.y), num_select(m, a.w.z, b.w.z)},
        {num_select(m, a.v.x, b.v.x), num_select(m, a.v.y, b.v.y), num_select(m, a.v.z, b.v.z)}};
}

static inline num sv_dot(svec a, svec b)
{
    return v3_dot(a.w, b.w) + v3_dot(a.v, b.v);
}

/* Component k of a six-vector: k is a constant wherever speed counts. */
static inline num sv_get(const svec *a, int k)
{
    switch (k) {
    case 0:
        return a->w.x;
    case 1:
        return a->w.y;
    case 2:
        return a->w.z;
    case 3:
        return a->v.x;
    case 4:
        return a->v.y;
    default:
        return a->v.z;
    }
}

static inline void sv_put(svec *a, int k, num x)
{
    switch (k) {
    case 0:
        a->w.x = x;
        return;
    case 1:
        a->w.y = x;
        return;
    case 2:
        a->w.z = x;
        return;
    case 3:
        a->v.x = x;
        return;
    case 4:
        a->v.y = x;
        return;
    default:
        a->v.z = x;
    }
}

static inline void sv_store(num *o, svec a)
{
    o[0] = a.w.x;
    o[1] = a.w.y;
    o[2] = a.w.z;
    o[3] = a.v.x;
    o[4] = a.v.y;
    o[5] = a.v.z;
}

static inline svec sv_from(const num *o)
{
    return (svec){{o[0], o[1], o[2]}, {o[3], o[4], o[5]}};
}

/* X m: a motion from the parent's frame to the child's */
TFA_INLINE svec xform_motion(const xform *X, svec m)
{
    return (svec){m3_mul(X->E, m.w), m3_mul(X->E, v3_sub(m.v, v3_cross(X->r, m.w)))};
}

/* X^T f: a force from the child's frame to the parent's */
TFA_INLINE svec xform_t_force(const xform *X, svec f)
{
    vec3 v = m3_tmul(X->E, f.v);
    return (svec){v3_add(m3_tmul(X->E, f.w), v3_cross(X->r, v)), v};
}

/* The transform by X, then by Y */
static inline xform xform_compose(const xform *X, const xform *Y)
{
    return (xform){m3_mm(Y->E, X->E), v3_add(X->r, m3_tmul(X->E, Y->r))};
}

/* v x m: velocity cross motion */
static inline svec cross_motion(svec v, svec m)
{
    return (svec){v3_cross(v.w, m.w), v3_add(v3_cross(v.w, m.v), v3_cross(v.v, m.w))};
}

/* v x* f: velocity cross force */
static inline svec cross_force(svec v, svec f)
{
    return (svec){v3_add(v3_cross(v.w, f.w), v3_cross(v.v, f.v)), v3_cross(v.w, f.v)};
}

static inline svec s6_mul(const sym6 *S, svec v)
{
    return (svec){v3_add(s3_mul(S->A, v.w), m3_mul(S->B, v.v)),
                  v3_add(m3_tmul(S->B, v.w), s3_mul(S->M, v.v))};
}

/* A rigid inertia of inertia I about the origin, mass times centre of mass h and mass m */
static inline sym6 s6_rigid(sym3 I, vec3 h, num m)
{
    const num o = num_of(0);
    return (sym6){I, {o, -h.z, h.y, h.z, o, -h.x, -h.y, h.x, o}, {m, o, o, m, o, m}};
}

/* The same times v: moment I w + h x v, force m v - h x w */
static inline svec s6_rigid_mul(sym3 I, vec3 h, num m, svec v)
{
    const vec3 hw = v3_cross(h, v.w);
    return (svec){v3_add(s3_mul(I, v.w), v3_cross(h, v.v)),
                  {v.v.x * m - hw.x, v.v.y * m - hw.y, v.v.z * m - hw.z}};
}

/* v x* I v of a rigid inertia. Written out, so that v x m v is not formed, which is zero and whose
 * rounding grows with the square of the speed: with e = w x v
 *   moment w x I w + h x e,  force m e + w x (w x h) */
TFA_INLINE svec s6_rigid_bias(sym3 I, vec3 h, num m, svec v)
{
    const vec3 e = v3_cross(v.w, v.v);
    return (svec){v3_add(v3_cross(v.w, s3_mul(I, v.w)), v3_cross(h, e)),
                  v3_add(v3_scale(e, m), v3_cross(v.w, v3_cross(v.w, h)))};
}

TFA_INLINE void s6_add(sym6 *S, const sym6 *T)
{
    S->A = s3_add(S->A, T->A);
    S->B = m3_add(S->B, T->B);
    S->M = s3_add(S->M, T->M);
}

TFA_INLINE void s6_sub(sym6 *S, const sym6 *T)
{
    num *const a = &S->A.xx, *const b = &S->B.xx, *const c = &S->M.xx;
    const num *const x = &T->A.xx, *const y = &T->B.xx, *const z = &T->M.xx;
    for (int e = 0; e < 6; e++) {
        a[e] -= x[e];
        c[e] -= z[e];
    }
    for (int e = 0; e < 9; e++)
        b[e] -= y[e];
}

/* rx M for a symmetric M: the columns are r x m_k */
static inline mat3 cross_s3(vec3 r, sym3 M)
{
    return (mat3){r.y * M.xz - r.z * M.xy, r.y * M.yz - r.z * M.yy, r.y * M.zz - r.z * M.yz,
                  r.z * M.xx - r.x * M.xz, r.z * M.xy - r.x * M.yz, r.z * M.xz - r.x * M.zz,
                  r.x * M.xy - r.y * M.xx, r.x * M.yy - r.y * M.xy, r.x * M.yz - r.y * M.xz};
}

/* The upper triangle of A + rx B^T - C rx, which the shift of an inertia makes symmetric:
 * B is the block before, C = B + rx M the block after the shift. */
static inline sym3 shift_block(sym3 A, vec3 r, mat3 B, mat3 C)
{
    return (sym3){
        A.xx + (r.y * B.xz - r.z * B.xy) + (r.y * C.xz - r.z * C.xy),
        A.xy + (r.y * B.yz - r.z * B.yy) + (r.z * C.xx - r.x * C.xz),
        A.xz + (r.y * B.zz - r.z * B.zy) + (r.x * C.xy - r.y * C.xx),
        A.yy + (r.z * B.yx - r.x * B.yz) + (r.z * C.yx - r.x * C.yz),
        A.yz + (r.z * B.zx - r.x * B.zz) + (r.x * C.yy - r.y * C.yx),
        A.zz + (r.x * B.zy - r.y * B.zx) + (r.x * C.zy - r.y * C.zx),
    };
}

/* An inertia about the origin of shifted axes: [1 rx; 0 1] S [1 0; -rx 1] */
TFA_INLINE sym6 s6_shift(vec3 r, const sym6 *S)
{
    mat3 B = m3_add(S->B, cross_s3(r, S->M));
    return (sym6){shift_block(S->A, r, S->B, B), B, S->M};
}

/* X^T S X: an inertia from the child's frame to the parent's */
static inline sym6 s6_to_parent(const xform *X, const sym6 *S)
{
    sym6 R = {s3_congruence_t(X->E, S->A), m3_congruence_t(X->E, S->B),
              s3_congruence_t(X->E, S->M)};
    return s6_shift(X->r, &R);
}

/* X^T S X where the rows and columns of S for the rotation about z are exactly zero, as they are
 * in an inertia projected through a revolute joint: two rows of E do the work of three. */
TFA_INLINE sym6 s6_to_parent_zero_z(const xform *X, const sym6 *S)
{
    const mat3 E = X->E;
    const vec3 ex = {E.xx, E.xy, E.xz}, ey = {E.yx, E.yy, E.yz};
    const vec3 ax = v3_add_scaled(v3_scale(ex, S->A.xx), ey, S->A.xy);
    const vec3 ay = v3_add_scaled(v3_scale(ex, S->A.xy), ey, S->A.yy);
    const vec3 bx = m3_tmul(E, v3(S->B.xx, S->B.xy, S->B.xz));
    const vec3 by = m3_tmul(E, v3(S->B.yx, S->B.yy, S->B.yz));
    const sym6 R = {
        {ex.x * ax.x + ey.x * ay.x, ex.x * ax.y + ey.x * ay.y, ex.x * ax.z + ey.x * ay.z,
         ex.y * ax.y + ey.y * ay.y, ex.y * ax.z + ey.y * ay.z, ex.z * ax.z + ey.z * ay.z},
        {ex.x * bx.x + ey.x * by.x, ex.x * bx.y + ey.x * by.y, ex.x * bx.z + ey.x * by.z,
         ex.y * bx.x + ey.y * by.x, ex.y * bx.y + ey.y * by.y, ex.y * bx.z + ey.y * by.z,
         ex.z * bx.x + ey.z * by.x, ex.z * bx.y + ey.z * by.y, ex.z * bx.z + ey.z * by.z},
        s3_congruence_t(E, S->M)};
    return s6_shift(X->r, &R);
}

/* X S X^T: an inverse inertia (force to motion) from the parent's frame to the child's.
 * With the roles of A and M exchanged it is the shift of an inertia by -r, then a rotation. */
static inline sym6 s6_inv_to_child(const xform *X, const sym6 *S)
{
    sym6 D = {S->M, m3_t(S->B), S->A};
    D = s6_shift(v3_neg(X->r), &D);
    mat3 Et = m3_t(X->E);
    return (sym6){s3_congruence_t(Et, D.M), m3_congruence_t(Et, m3_t(D.B)),
                  s3_congruence_t(Et, D.A)};
}

/* Dense row-major 6 x 6 of a symmetric one */
static inline void s6_dense(num *o, const sym6 *S)
{
    const num m[36] = {
        S->A.xx, S->A.xy, S->A.xz, S->B.xx, S->B.xy, S->B.xz, /* */
        S->A.xy, S->A.yy, S->A.yz, S->B.yx, S->B.yy, S->B.yz, /* */
        S->A.xz, S->A.yz, S->A.zz, S->B.zx, S->B.zy, S->B.zz, /* */
        S->B.xx, S->B.yx, S->B.zx, S->M.xx, S->M.xy, S->M.xz, /* */
        S->B.xy, S->B.yy, S->B.zy, S->M.xy, S->M.yy, S->M.yz, /* */
        S->B.xz, S->B.yz, S->B.zz, S->M.xz, S->M.yz, S->M.zz,
    };
    for (int k = 0; k < 36; k++)
        o[k] = m[k];
}

/* The symmetric part of a dense 6 x 6, read from its upper triangle */
static inline sym6 s6_from_dense(const num *o)
{
    return (sym6){{o[0], o[1], o[2], o[7], o[8], o[14]},
                  {o[3], o[4], o[5], o[9], o[10], o[11], o[15], o[16], o[17]},
                  {o[21], o[22], o[23], o[28], o[29], o[35]}};
}

/* Column k of a symmetric 6 x 6; k is a constant wherever speed counts */
static inline svec s6_column(const sym6 *S, int k)
{
    switch (k) {
    case 0:
        return (svec){{S->A.xx, S->A.xy, S->A.xz}, {S->B.xx, S->B.xy, S->B.xz}};
    case 1:
        return (svec){{S->A.xy, S->A.yy, S->A.yz}, {S->B.yx, S->B.yy, S->B.yz}};
    case 2:
        return (svec){{S->A.xz, S->A.yz, S->A.zz}, {S->B.zx, S->B.zy, S->B.zz}};
    case 3:
        return (svec){{S->B.xx, S->B.yx, S->B.zx}, {S->M.xx, S->M.xy, S->M.xz}};
    case 4:
        return (svec){{S->B.xy, S->B.yy, S->B.zy}, {S->M.xy, S->M.yy, S->M.yz}};
    default:
        return (svec){{S->B.xz, S->B.yz, S->B.zz}, {S->M.xz, S->M.yz, S->M.zz}};
    }
}

/* S -= d U U^T */
static inline void s6_rank1(sym6 *S, svec U, num d)
{
    vec3 dw = v3_scale(U.w, d), dv = v3_scale(U.v, d);
    S->A.xx -= dw.x * U.w.x;
    S->A.xy -= dw.x * U.w.y;
    S->A.xz -= dw.x * U.w.z;
    S->A.yy -= dw.y * U.w.y;
    S->A.yz -= dw.y * U.w.z;
    S->A.zz -= dw.z * U.w.z;
    S->B.xx -= dw.x * U.v.x;
    S->B.xy -= dw.x * U.v.y;
    S->B.xz -= dw.x * U.v.z;
    S->B.yx -= dw.y * U.v.x;
    S->B.yy -= dw.y * U.v.y;
    S->B.yz -= dw.y * U.v.z;
    S->B.zx -= dw.z * U.v.x;
    S->B.zy -= dw.z * U.v.y;
    S->B.zz -= dw.z * U.v.z;
    S->M.xx -= dv.x * U.v.x;
    S->M.xy -= dv.x * U.v.y;
    S->M.xz -= dv.x * U.v.z;
    S->M.yy -= dv.y * U.v.y;
    S->M.yz -= dv.y * U.v.z;
    S->M.zz -= dv.z * U.v.z;
}

#endif
