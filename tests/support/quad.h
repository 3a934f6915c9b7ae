/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Quadruple precision and 3-vectors for the oracle.
 */
#ifndef TESTS_SUPPORT_QUAD_H
#define TESTS_SUPPORT_QUAD_H

#include <math.h>
#include <stddef.h>

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 quad;
/* glibc has them; its header hides them from clang, so they are declared here. */
quad sinf128(quad);
quad cosf128(quad);
quad sqrtf128(quad);
static inline quad quad_sin(quad x)
{
    return sinf128(x);
}
static inline quad quad_cos(quad x)
{
    return cosf128(x);
}
static inline quad quad_sqrt(quad x)
{
    return sqrtf128(x);
}
#else /* where long double is the IEEE quadruple format, for instance aarch64 */
typedef long double quad;
static inline quad quad_sin(quad x)
{
    return sinl(x);
}
static inline quad quad_cos(quad x)
{
    return cosl(x);
}
static inline quad quad_sqrt(quad x)
{
    return sqrtl(x);
}
#endif

/** A vector, and a matrix by its columns, so that m.col[k] is an axis of the frame. */
typedef struct vec3 {
    quad x[3];
} vec3;
typedef struct mat3 {
    vec3 col[3];
} mat3;

static inline vec3 vec_from(const double *a)
{
    return (vec3){{a[0], a[1], a[2]}};
}

static inline vec3 vec_add(vec3 a, vec3 b)
{
    return (vec3){{a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2]}};
}

static inline vec3 vec_sub(vec3 a, vec3 b)
{
    return (vec3){{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};
}

static inline vec3 vec_scale(quad s, vec3 a)
{
    return (vec3){{s * a.x[0], s * a.x[1], s * a.x[2]}};
}

static inline quad vec_dot(vec3 a, vec3 b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static inline vec3 vec_cross(vec3 a, vec3 b)
{
    return (vec3){{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
                   a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

static inline vec3 vec_unit(vec3 a)
{
    return vec_scale(1 / quad_sqrt(vec_dot(a, a)), a);
}

/** m a: from the frame's axes to those in which its columns are written. */
static inline vec3 mat_apply(const mat3 *m, vec3 a)
{
    return vec_add(vec_add(vec_scale(a.x[0], m->col[0]), vec_scale(a.x[1], m->col[1])),
                   vec_scale(a.x[2], m->col[2]));
}

/** m^T a */
static inline vec3 mat_apply_transposed(const mat3 *m, vec3 a)
{
    return (vec3){{vec_dot(m->col[0], a), vec_dot(m->col[1], a), vec_dot(m->col[2], a)}};
}

static inline mat3 mat_mul(const mat3 *a, const mat3 *b)
{
    return (mat3){{mat_apply(a, b->col[0]), mat_apply(a, b->col[1]), mat_apply(a, b->col[2])}};
}

static inline mat3 mat_transposed(const mat3 *a)
{
    mat3 t;
    for (int i = 0; i < 3; i++)
        t.col[i] = (vec3){{a->col[0].x[i], a->col[1].x[i], a->col[2].x[i]}};
    return t;
}

static inline mat3 mat_identity(void)
{
    return (mat3){{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}};
}

/** Rodrigues: a cos + (axis x a) sin + axis (axis . a)(1 - cos). */
static inline mat3 mat_about_axis(vec3 axis, quad angle)
{
    quad c = quad_cos(angle), s = quad_sin(angle);
    mat3 m = mat_identity();
    for (int i = 0; i < 3; i++) {
        vec3 turned = vec_add(vec_scale(c, m.col[i]), vec_scale(s, vec_cross(axis, m.col[i])));
        m.col[i] = vec_add(turned, vec_scale((1 - c) * axis.x[i], axis));
    }
    return m;
}

/** A vector in two parts, the second of which may be NULL. */
static inline vec3 vec_from_parts(const double *high, const double *low)
{
    return low ? vec_add(vec_from(high), vec_from(low)) : vec_from(high);
}

/** Rotation of a quaternion x y z w in two parts, normalised here. */
static inline mat3 mat_from_quaternion_parts(const double *q, const double *low)
{
    vec3 u = vec_from_parts(q, low);
    quad w = low ? (quad)q[3] + low[3] : q[3], norm2 = vec_dot(u, u) + w * w;
    mat3 m = mat_identity();
    for (int i = 0; i < 3; i++) {
        vec3 t = vec_scale(2 / norm2, vec_cross(u, m.col[i]));
        m.col[i] = vec_add(m.col[i], vec_add(vec_scale(w, t), vec_cross(u, t)));
    }
    return m;
}

/** Rotation of a quaternion x y z w, normalised here. */
static inline mat3 mat_from_quaternion(const double *q)
{
    return mat_from_quaternion_parts(q, NULL);
}

#endif
