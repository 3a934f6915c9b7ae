/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Coulomb friction with a smooth sign: friction times v / sqrt(v^2 + s^2), by operations that IEEE
 * 754 rounds correctly, so that every instruction set gives the same bits.
 */
#ifndef TFA_SPATIAL_FRICTION_H
#define TFA_SPATIAL_FRICTION_H

#include "spatial/num.h"

static inline num friction_sign(num v, num s)
{
    return v / num_sqrt(v * v + s * s);
}

/* Its derivative: s^2 / (v^2 + s^2)^(3/2) */
static inline num friction_slope(num v, num s)
{
    const num square = v * v + s * s;
    return s * s / (square * num_sqrt(square));
}

#endif
