/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Six numbers in as many SIMD registers as they take: the same component of six spatial
 * vectors, so that an operation on one of them is done on all at once. NUM_VEC_LANES is how many
 * numbers the variant's instruction set takes at a time; numbers behind the sixth are never
 * read.
 */
#ifndef TFA_SPATIAL_VEC6_H
#define TFA_SPATIAL_VEC6_H

#include <string.h>

#include "spatial/spatial.h"

#ifdef NUM_VEC_LANES
typedef num num_vec __attribute__((vector_size(NUM_VEC_LANES * sizeof(num))));
#define vec_lane(x, k) ((x)[k])
#if NUM_VEC_LANES == 8
typedef num num_vec_4 __attribute__((vector_size(4 * sizeof(num))));
typedef num num_vec_2 __attribute__((vector_size(2 * sizeof(num))));
#endif
#else
#define NUM_VEC_LANES 1
typedef num num_vec;
#define vec_lane(x, k) (x)
#endif

#define VEC6_VECS ((6 + NUM_VEC_LANES - 1) / NUM_VEC_LANES)

typedef struct vec6 {
    num_vec vec[VEC6_VECS];
} vec6;

/* Number e: a constant wherever speed counts */
#define vec6_lane(x, e) vec_lane((x)->vec[(e) / NUM_VEC_LANES], (e) % NUM_VEC_LANES)

static inline vec6 vec6_zero(void)
{
    vec6 x;
    for (int k = 0; k < VEC6_VECS; k++)
        x.vec[k] = (num_vec){0};
    return x;
}

static inline vec6 vec6_scale(num s, vec6 x)
{
    for (int k = 0; k < VEC6_VECS; k++)
        x.vec[k] = s * x.vec[k];
    return x;
}

/* x + s y */
static inline vec6 vec6_add_scaled(vec6 x, num s, vec6 y)
{
    for (int k = 0; k < VEC6_VECS; k++)
        x.vec[k] += s * y.vec[k];
    return x;
}

/* x - s y */
static inline vec6 vec6_sub_scaled(vec6 x, num s, vec6 y)
{
    for (int k = 0; k < VEC6_VECS; k++)
        x.vec[k] -= s * y.vec[k];
    return x;
}

/* a x + b y + c z */
static inline vec6 vec6_combine(num a, vec6 x, num b, vec6 y, num c, vec6 z)
{
    return vec6_add_scaled(vec6_add_scaled(vec6_scale(a, x), b, y), c, z);
}

/* As many at a time as fit: nothing behind the sixth is written. */
static inline void vec6_store(num *out, const vec6 *x)
{
#if NUM_VEC_LANES == 8
    const num_vec_4 first = __builtin_shufflevector(x->vec[0], x->vec[0], 0, 1, 2, 3);
    const num_vec_2 rest = __builtin_shufflevector(x->vec[0], x->vec[0], 4, 5);
    memcpy(out, &first, sizeof first);
    memcpy(out + 4, &rest, sizeof rest);
#else
    memcpy(out, x->vec, 6 / NUM_VEC_LANES * sizeof(num_vec));
    for (int e = 6 / NUM_VEC_LANES * NUM_VEC_LANES; e < 6; e++)
        out[e] = vec6_lane(x, e);
#endif
}

static inline vec6 vec6_load(const num *in)
{
#if NUM_VEC_LANES == 8
    num_vec_4 first;
    num_vec_2 rest;
    memcpy(&first, in, sizeof first);
    memcpy(&rest, in + 4, sizeof rest);
    const num_vec_4 last = __builtin_shufflevector(rest, rest, 0, 1, 1, 1);
    return (vec6){{__builtin_shufflevector(first, last, 0, 1, 2, 3, 4, 5, 5, 5)}};
#else
    vec6 x = vec6_zero();
    memcpy(x.vec, in, 6 / NUM_VEC_LANES * sizeof(num_vec));
    for (int e = 6 / NUM_VEC_LANES * NUM_VEC_LANES; e < 6; e++)
        vec6_lane(&x, e) = in[e];
    return x;
#endif
}

/* ---- three numbers, which stand in front; 0 behind ---- */

/* Of at most four lanes: half of a wider vector would be idle. */
#if NUM_VEC_LANES == 8
#define VEC3_LANES 4
typedef num_vec_4 vec3_vec;
#else
#define VEC3_LANES NUM_VEC_LANES
typedef num_vec vec3_vec;
#endif
#define VEC3_SIMD_VECS ((3 + VEC3_LANES - 1) / VEC3_LANES)

typedef struct vec3_simd {
    vec3_vec vec[VEC3_SIMD_VECS];
} vec3_simd;

static inline vec3_simd vec3_simd_of(num a, num b, num c)
{
#if VEC3_LANES == 4
    return (vec3_simd){{(vec3_vec){a, b, c}}};
#elif VEC3_LANES == 2
    return (vec3_simd){{(vec3_vec){a, b}, (vec3_vec){c}}};
#else
    return (vec3_simd){{a, b, c}};
#endif
}

/* a x - b y */
static inline vec3_simd vec3_simd_minus(num a, vec3_simd x, num b, vec3_simd y)
{
    for (int k = 0; k < VEC3_SIMD_VECS; k++)
        x.vec[k] = a * x.vec[k] - b * y.vec[k];
    return x;
}

/* a x + b y + c z */
static inline vec3_simd vec3_simd_combine(num a, vec3_simd x, num b, vec3_simd y, num c,
                                          vec3_simd z)
{
    for (int k = 0; k < VEC3_SIMD_VECS; k++)
        x.vec[k] = a * x.vec[k] + b * y.vec[k] + c * z.vec[k];
    return x;
}

static inline vec3_simd vec3_simd_add(vec3_simd x, vec3_simd y)
{
    for (int k = 0; k < VEC3_SIMD_VECS; k++)
        x.vec[k] += y.vec[k];
    return x;
}

static inline vec3_simd vec3_simd_sub(vec3_simd x, vec3_simd y)
{
    for (int k = 0; k < VEC3_SIMD_VECS; k++)
        x.vec[k] -= y.vec[k];
    return x;
}

/* x times y: (y z x) of one times (z x y) of the other, minus the reverse */
static inline vec3_simd vec3_simd_cross(vec3_simd x, vec3_simd y)
{
#if VEC3_LANES == 4
    const vec3_vec a = __builtin_shufflevector(x.vec[0], x.vec[0], 1, 2, 0, 3),
                   b = __builtin_shufflevector(y.vec[0], y.vec[0], 1, 2, 0, 3),
                   c = x.vec[0] * b - a * y.vec[0];
    return (vec3_simd){{__builtin_shufflevector(c, c, 1, 2, 0, 3)}};
#else
    num a[3], b[3];
    for (int e = 0; e < 3; e++) {
        a[e] = vec_lane(x.vec[e / VEC3_LANES], e % VEC3_LANES);
        b[e] = vec_lane(y.vec[e / VEC3_LANES], e % VEC3_LANES);
    }
    return vec3_simd_of(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                        a[0] * b[1] - a[1] * b[0]);
#endif
}

/* ---- four numbers ---- */

#define QUAD_VECS (4 / VEC3_LANES)

typedef struct quad {
    vec3_vec vec[QUAD_VECS];
} quad;

#define quad_lane(x, e) vec_lane((x)->vec[(e) / VEC3_LANES], (e) % VEC3_LANES)

static inline quad quad_of(num a, num b, num c, num d)
{
#if VEC3_LANES == 4
    return (quad){{(vec3_vec){a, b, c, d}}};
#elif VEC3_LANES == 2
    return (quad){{(vec3_vec){a, b}, (vec3_vec){c, d}}};
#else
    return (quad){{a, b, c, d}};
#endif
}

static inline quad quad_scale(num s, quad x)
{
    for (int k = 0; k < QUAD_VECS; k++)
        x.vec[k] = s * x.vec[k];
    return x;
}

/* Its third and fourth number, then the first two */
static inline quad quad_swap_halves(quad x)
{
#if VEC3_LANES == 4
    return (quad){{__builtin_shufflevector(x.vec[0], x.vec[0], 2, 3, 0, 1)}};
#elif VEC3_LANES == 2
    return (quad){{x.vec[1], x.vec[0]}};
#else
    return (quad){{x.vec[2], x.vec[3], x.vec[0], x.vec[1]}};
#endif
}

/* sum + x y, number by number */
static inline quad quad_add_product(quad sum, quad x, quad y)
{
    for (int k = 0; k < QUAD_VECS; k++)
        sum.vec[k] += x.vec[k] * y.vec[k];
    return sum;
}

/* x, then y; and x alone */
static inline vec6 vec6_concat(vec3_simd x, vec3_simd y)
{
#if NUM_VEC_LANES == 8
    return (vec6){{__builtin_shufflevector(x.vec[0], y.vec[0], 0, 1, 2, 4, 5, 6, 3, 3)}};
#elif NUM_VEC_LANES == 4
    return (vec6){{__builtin_shufflevector(x.vec[0], y.vec[0], 0, 1, 2, 4),
                   __builtin_shufflevector(y.vec[0], y.vec[0], 1, 2, 3, 3)}};
#elif NUM_VEC_LANES == 2
    return (vec6){{x.vec[0], __builtin_shufflevector(x.vec[1], y.vec[0], 0, 2),
                   __builtin_shufflevector(y.vec[0], y.vec[1], 1, 2)}};
#else
    return (vec6){{x.vec[0], x.vec[1], x.vec[2], y.vec[0], y.vec[1], y.vec[2]}};
#endif
}

static inline vec6 vec6_from_simd3(vec3_simd x)
{
#if NUM_VEC_LANES == 8
    return (vec6){{__builtin_shufflevector(x.vec[0], (vec3_vec){0}, 0, 1, 2, 4, 4, 4, 4, 4)}};
#else
    vec6 out = vec6_zero();
    for (int k = 0; k < VEC3_SIMD_VECS; k++)
        out.vec[k] = x.vec[k];
    return out;
#endif
}

/* The three by rows */
struct mat3_simd {
    vec3_simd row[3];
};

static inline struct mat3_simd mat3_simd_of(mat3 R)
{
    return (struct mat3_simd){{vec3_simd_of(R.xx, R.xy, R.xz), vec3_simd_of(R.yx, R.yy, R.yz),
                               vec3_simd_of(R.zx, R.zy, R.zz)}};
}

static inline num vec3_simd_lane(const vec3_simd *x, int e)
{
    return vec_lane(x->vec[e / VEC3_LANES], e % VEC3_LANES);
}

/* sum of v_k times row k: R^T v */
static inline vec3_simd mat3_simd_apply_t(const struct mat3_simd *R, vec3 v)
{
    return vec3_simd_combine(v.x, R->row[0], v.y, R->row[1], v.z, R->row[2]);
}

static inline vec3 vec3_of_simd(vec3_simd x)
{
    return v3(vec3_simd_lane(&x, 0), vec3_simd_lane(&x, 1), vec3_simd_lane(&x, 2));
}

static inline struct mat3_simd mat3_simd_transpose(const struct mat3_simd *R)
{
    struct mat3_simd out;
    for (int k = 0; k < 3; k++)
        out.row[k] = vec3_simd_of(vec3_simd_lane(&R->row[0], k), vec3_simd_lane(&R->row[1], k),
                                  vec3_simd_lane(&R->row[2], k));
    return out;
}

/* E R */
static inline struct mat3_simd mat3_simd_mul(const mat3 *E, const struct mat3_simd *R)
{
    return (struct mat3_simd){{mat3_simd_apply_t(R, v3(E->xx, E->xy, E->xz)),
                               mat3_simd_apply_t(R, v3(E->yx, E->yy, E->yz)),
                               mat3_simd_apply_t(R, v3(E->zx, E->zy, E->zz))}};
}

/* E^T R */
static inline struct mat3_simd mat3_simd_tmul(const mat3 *E, const struct mat3_simd *R)
{
    const vec3_simd x = R->row[0], y = R->row[1], z = R->row[2];
    return (struct mat3_simd){{vec3_simd_combine(E->xx, x, E->yx, y, E->zx, z),
                               vec3_simd_combine(E->xy, x, E->yy, y, E->zy, z),
                               vec3_simd_combine(E->xz, x, E->yz, y, E->zz, z)}};
}

/* ---- six wrenches ---- */

/* Six forces on a body: component k of all of them, angular first */
struct wrench_columns {
    vec6 at[6];
};

/* Vector by vector, without a loop: gcc copies a structure of this size, and makes of a loop, a
 * string instruction that takes longer than its arithmetic in the step through a joint (10 ns,
 * AMD EPYC Zen 5, gcc 12, 2026-11-22). */
static inline void vec6_copy(vec6 *to, const vec6 *from)
{
    to->vec[0] = from->vec[0];
#if NUM_VEC_LANES < 8
    to->vec[1] = from->vec[1];
#endif
#if NUM_VEC_LANES < 4
    to->vec[2] = from->vec[2];
#endif
#if NUM_VEC_LANES < 2
    to->vec[3] = from->vec[3];
    to->vec[4] = from->vec[4];
    to->vec[5] = from->vec[5];
#endif
}

static inline void vec6_copy_6(vec6 to[6], const vec6 from[6])
{
    vec6_copy(&to[0], &from[0]);
    vec6_copy(&to[1], &from[1]);
    vec6_copy(&to[2], &from[2]);
    vec6_copy(&to[3], &from[3]);
    vec6_copy(&to[4], &from[4]);
    vec6_copy(&to[5], &from[5]);
}

static inline void wrench_columns_copy(struct wrench_columns *to, const struct wrench_columns *from)
{
    vec6_copy_6(to->at, from->at);
}

static inline struct wrench_columns wrench_columns_from(const svec P[6])
{
    struct wrench_columns w;
    for (int k = 0; k < 6; k++)
        w.at[k] = vec6_zero();
    for (int e = 0; e < 6; e++) {
        num x[6];
        sv_store(x, P[e]);
        for (int k = 0; k < 6; k++)
            vec6_lane(&w.at[k], e) = x[k];
    }
    return w;
}

/* 1 in each component in turn */
static inline struct wrench_columns wrench_columns_identity(void)
{
    struct wrench_columns w;
    for (int k = 0; k < 6; k++) {
        w.at[k] = vec6_zero();
        vec6_lane(&w.at[k], k) = num_of(1);
    }
    return w;
}

/* Unit forces, then unit moments about point p along three axes, the columns of R: row by row
 * [p x R, R; R, 0] */
static inline struct wrench_columns wrench_columns_at(const struct mat3_simd *R, vec3 p)
{
    const vec3_simd x = R->row[0], y = R->row[1], z = R->row[2];
    return (struct wrench_columns){{vec6_concat(vec3_simd_minus(p.y, z, p.z, y), x),
                                    vec6_concat(vec3_simd_minus(p.z, x, p.x, z), y),
                                    vec6_concat(vec3_simd_minus(p.x, y, p.y, x), z),
                                    vec6_from_simd3(x), vec6_from_simd3(y), vec6_from_simd3(z)}};
}

/* Wrench e of the six */
static inline svec wrench_columns_get(const struct wrench_columns *w, int e)
{
    num x[6];
    for (int k = 0; k < 6; k++)
        x[k] = vec6_lane(&w->at[k], e);
    return sv_from(x);
}

static inline void wrench_columns_store(const struct wrench_columns *w, svec P[6])
{
    for (int e = 0; e < 6; e++)
        P[e] = wrench_columns_get(w, e);
}

/* X^T P: from the child's frame to the parent's. `zero_z`: no moment about z is left, at[2] is
 * 0. */
TFA_INLINE void wrench_columns_to_parent(const xform *X, struct wrench_columns *P, int zero_z)
{
    vec6 *at = P->at;
    const mat3 *E = &X->E;
    const vec3 r = X->r;
    const vec6 x = vec6_combine(E->xx, at[3], E->yx, at[4], E->zx, at[5]);
    const vec6 y = vec6_combine(E->xy, at[3], E->yy, at[4], E->zy, at[5]);
    const vec6 z = vec6_combine(E->xz, at[3], E->yz, at[4], E->zz, at[5]);
    vec6 mx = vec6_add_scaled(vec6_scale(E->xx, at[0]), E->yx, at[1]);
    vec6 my = vec6_add_scaled(vec6_scale(E->xy, at[0]), E->yy, at[1]);
    vec6 mz = vec6_add_scaled(vec6_scale(E->xz, at[0]), E->yz, at[1]);
    if (!zero_z) {
        mx = vec6_add_scaled(mx, E->zx, at[2]);
        my = vec6_add_scaled(my, E->zy, at[2]);
        mz = vec6_add_scaled(mz, E->zz, at[2]);
    }
    at[0] = vec6_sub_scaled(vec6_add_scaled(mx, r.y, z), r.z, y);
    at[1] = vec6_sub_scaled(vec6_add_scaled(my, r.z, x), r.x, z);
    at[2] = vec6_sub_scaled(vec6_add_scaled(mz, r.x, y), r.y, x);
    at[3] = x;
    at[4] = y;
    at[5] = z;
}

/* M P for a dense symmetric or other M, row major */
static inline struct wrench_columns wrench_columns_mul(const num *M, const struct wrench_columns *P)
{
    struct wrench_columns out;
    for (int i = 0; i < 6; i++) {
        out.at[i] = vec6_scale(M[6 * i], P->at[0]);
        for (int k = 1; k < 6; k++)
            out.at[i] = vec6_add_scaled(out.at[i], M[6 * i + k], P->at[k]);
    }
    return out;
}

/* M^T P */
static inline struct wrench_columns wrench_columns_tmul(const num *M,
                                                        const struct wrench_columns *P)
{
    struct wrench_columns out;
    for (int i = 0; i < 6; i++) {
        out.at[i] = vec6_scale(M[i], P->at[0]);
        for (int k = 1; k < 6; k++)
            out.at[i] = vec6_add_scaled(out.at[i], M[6 * k + i], P->at[k]);
    }
    return out;
}

/* ---- 6 x 6 matrix by rows: products of six wrenches with six ---- */

struct mat6_simd {
    vec6 row[6];
};

static inline struct mat6_simd mat6_simd_zero(void)
{
    struct mat6_simd C;
    for (int e = 0; e < 6; e++)
        C.row[e] = vec6_zero();
    return C;
}

static inline void mat6_simd_copy(struct mat6_simd *to, const struct mat6_simd *from)
{
    vec6_copy_6(to->row, from->row);
}

/* C += psi^T phi */
static inline void mat6_simd_add_outer(struct mat6_simd *C, const vec6 *psi, const vec6 *phi)
{
    for (int e = 0; e < 6; e++)
        C->row[e] = vec6_add_scaled(C->row[e], vec6_lane(psi, e), *phi);
}

/* C += P^T Q */
static inline void mat6_simd_add_tmul(struct mat6_simd *C, const struct wrench_columns *P,
                                      const struct wrench_columns *Q)
{
    for (int k = 0; k < 6; k++)
        mat6_simd_add_outer(C, &P->at[k], &Q->at[k]);
}

/* x <- L^-1 x with the factors of ldl_factor */
static inline void vec6_ldl_lower(const num *L, uint32_t n, vec6 *x)
{
    for (uint32_t i = 1; i < n; i++)
        for (uint32_t k = 0; k < i; k++)
            x[i] = vec6_sub_scaled(x[i], L[6 * i + k], x[k]);
}

#endif
