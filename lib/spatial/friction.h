/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Coulomb friction with a smooth sign: friction times v / sqrt(v^2 + s^2) = x / sqrt(1 + x^2) with
 * x = v / s, by operations that IEEE 754 rounds correctly. One product only is part of a sum, so
 * that compilers that fuse it give the same bits for a state and for lanes.
 */
#ifndef TFA_SPATIAL_FRICTION_H
#define TFA_SPATIAL_FRICTION_H

#include "spatial/num.h"

static inline num friction_sign(num v, num s)
{
    const num x = v * (1 / s);
    return x / num_sqrt(1 + x * x);
}

/* Its derivative: s^2 / (v^2 + s^2)^(3/2) */
static inline num friction_slope(num v, num s)
{
    const num x = v * (1 / s), square = 1 + x * x;
    return 1 / (s * (square * num_sqrt(square)));
}

#endif
