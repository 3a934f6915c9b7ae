/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Numbers shaken by some roundings, for residuals that show what rounding may have done (rnea.c).
 */
#ifndef TFA_KERNEL_SHAKE_H
#define TFA_KERNEL_SHAKE_H

#include "spatial/spatial.h"

/* So many roundings a number is shaken by: what a body computes from it and adds up. test_estimates
 * 5000 saw 89 of 884724 answers whose error was above 30 estimates with 4, 77 with 8, 2026-11-22. */
#define LOUD 8

static inline num shake(num x, uint32_t *turn)
{
    const num e = num_of(1) * (LOUD * NUM_EPSILON);
    *turn = *turn * 1664525u + 1013904223u;
    return x * (*turn >> 31 ? 1 + e : 1 - e);
}

static inline vec3 shake_vec3(vec3 x, uint32_t *turn)
{
    return (vec3){shake(x.x, turn), shake(x.y, turn), shake(x.z, turn)};
}

static inline svec shake_svec(svec x, uint32_t *turn)
{
    return (svec){shake_vec3(x.w, turn), shake_vec3(x.v, turn)};
}

/* One row of E; each entry lost as much as `size`, what it was summed from. */
static inline vec3 shake_row(vec3 row, vec3 size, uint32_t *turn)
{
    return v3_add(row, v3_sub(shake_vec3(size, turn), size));
}

/* E = Z T: one freedom mixes the first two rows of T at most, more may mix all three. */
static inline place shake_place(const place *X, int single, uint32_t *turn)
{
    const mat3 *E = &X->E;
    vec3 size = {num_abs(E->xx) + num_abs(E->yx), num_abs(E->xy) + num_abs(E->yy),
                 num_abs(E->xz) + num_abs(E->yz)};
    vec3 last = {num_abs(E->zx), num_abs(E->zy), num_abs(E->zz)};
    if (!single)
        last = size = v3_add(size, last);
    const vec3 x = shake_row((vec3){E->xx, E->xy, E->xz}, size, turn),
               y = shake_row((vec3){E->yx, E->yy, E->yz}, size, turn),
               z = shake_row((vec3){E->zx, E->zy, E->zz}, last, turn);
    return (place){{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}, shake_vec3(X->r, turn)};
}

#endif
