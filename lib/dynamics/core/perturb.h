/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Perturbations of the size of rounding, for residuals that show the possible effect of rounding
 * (rnea_perturbed.c).
 *
 * A sum is perturbed by a random part of the sum of its terms' absolute values, which bounds its
 * rounding also where the terms cancel. One perturbation for each component of each body's motion
 * and force, and none of them small: perturbations of every factor cancel each other too often
 * where one product dominates.
 */
#ifndef TFA_DYNAMICS_CORE_PERTURB_H
#define TFA_DYNAMICS_CORE_PERTURB_H

#include "dynamics/core/perturb_table.h"
#include "layout_body.h"
#include "spatial/spatial.h"

/* Largest perturbation, in roundings of the sum of absolute values. */
#define PERTURB_ULPS 4

/* Numbers for each body: motion, force, and force on the parent */
#define PERTURB_EACH 18u

/* ---- sums of absolute values ---- */

static inline vec3 v3_abs(vec3 a)
{
    return (vec3){num_abs(a.x), num_abs(a.y), num_abs(a.z)};
}

static inline svec sv_abs(svec a)
{
    return (svec){v3_abs(a.w), v3_abs(a.v)};
}

/* Of a x b, for a and b without signs */
static inline vec3 v3_cross_abs(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x};
}

/* Of a transform E = Z T: one freedom mixes the first two rows of T at most, more may mix all
 * three. */
static inline xform xform_abs(const xform *X, int single)
{
    const mat3 *E = &X->E;
    vec3 two = {num_abs(E->xx) + num_abs(E->yx), num_abs(E->xy) + num_abs(E->yy),
                num_abs(E->xz) + num_abs(E->yz)};
    vec3 z = {num_abs(E->zx), num_abs(E->zy), num_abs(E->zz)};
    if (!single)
        z = two = v3_add(two, z);
    return (xform){{two.x, two.y, two.z, two.x, two.y, two.z, z.x, z.y, z.z}, v3_abs(X->r)};
}

/* Of X m, for X and m without signs: E w and E (v - r x w) */
static inline svec xform_motion_abs(const xform *X, svec m)
{
    return (svec){m3_mul(X->E, m.w), m3_mul(X->E, v3_add(m.v, v3_cross_abs(X->r, m.w)))};
}

/* Of X^T f: E^T n + r x E^T f and E^T f */
static inline svec xform_t_force_abs(const xform *X, svec f)
{
    const vec3 force = m3_tmul(X->E, f.v);
    return (svec){v3_add(m3_tmul(X->E, f.w), v3_cross_abs(X->r, force)), force};
}

static inline sym3 s3_abs(sym3 I)
{
    return (sym3){num_abs(I.xx), num_abs(I.xy), num_abs(I.xz),
                  num_abs(I.yy), num_abs(I.yz), num_abs(I.zz)};
}

/* Of I v: I w + h x v and m v - h x w */
static inline svec rigid_mul_abs(sym3 I, vec3 h, num m, svec v)
{
    const vec3 c = v3_abs(h);
    return (svec){v3_add(s3_mul(s3_abs(I), v.w), v3_cross_abs(c, v.v)),
                  v3_add(v3_scale(v.v, m), v3_cross_abs(c, v.w))};
}

/* Of v x m, motions */
static inline svec cross_motion_abs(svec v, svec m)
{
    return (svec){v3_cross_abs(v.w, m.w), v3_add(v3_cross_abs(v.w, m.v), v3_cross_abs(v.v, m.w))};
}

/* Of v x* I v, as s6_rigid_bias */
static inline svec rigid_bias_abs(sym3 I, vec3 h, num m, svec v)
{
    const vec3 c = v3_abs(h), e = v3_cross_abs(v.w, v.v);
    return (svec){v3_add(v3_cross_abs(v.w, s3_mul(s3_abs(I), v.w)), v3_cross_abs(c, e)),
                  v3_add(v3_scale(e, m), v3_cross_abs(v.w, v3_cross_abs(v.w, c)))};
}

/* ---- perturbations ---- */

/* Where the numbers of each lane start in the table: by the index of the body, so that a body has
 * the same perturbations in whatever lane it stands. */
struct perturb_start {
    uint32_t lane[LAYOUT_BODIES_IN_LANES];
};

/* Number k, 0 .. PERTURB_EACH - 1, of the bodies at hand: of either sign, 0.5 to 1 times
 * PERTURB_ULPS roundings */
static inline num perturbation(const struct perturb_start *start, uint32_t k)
{
    const double *from = perturb_table + k;
    const num x = LAYOUT_BODIES_IN_LANES > 1 ? num_gather(from, 1, start->lane)
                                             : num_of(from[start->lane[0]]);
    return x * (PERTURB_ULPS * NUM_EPSILON);
}

static inline vec3 v3_perturb(vec3 a, vec3 size, const struct perturb_start *start, uint32_t k)
{
    return (vec3){a.x + size.x * perturbation(start, k), a.y + size.y * perturbation(start, k + 1),
                  a.z + size.z * perturbation(start, k + 2)};
}

/* a, a sum whose terms have these absolute values, by the numbers k .. k + 5 */
static inline svec sv_perturb(svec a, svec size, const struct perturb_start *start, uint32_t k)
{
    return (svec){v3_perturb(a.w, size.w, start, k), v3_perturb(a.v, size.v, start, k + 3)};
}

#endif
