/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel: is the articulated-body recursion safely above its rounding?
 *
 *   s = eps max_i (Mbar_i / D_i)
 *
 * with D_i the projected articulated inertia of joint i and Mbar_i the largest inertia that its
 * subtree can have about the joint (model/inertia_bound.h). D_i is the difference of inertias up to
 * Mbar_i, so s bounds its relative rounding. The sentinel trips where s is above SENTINEL_LIMIT, or
 * a D_i is not positive.
 */
#ifndef TFA_DYNAMICS_CORE_SENTINEL_H
#define TFA_DYNAMICS_CORE_SENTINEL_H

#include "dynamics/core/sentinel_limit.h"
#include "layout/body.h"

#define SENTINEL_RATIO num_of((double)NUM_EPSILON / SENTINEL_LIMIT)

/* Nothing seen so far */
TFA_INLINE void sentinel_reset(struct state *s)
{
    s->margin = num_of(1);
}

TFA_INLINE void sentinel_see(struct state *s, num margin)
{
    s->margin = sentinel_smaller(s->margin, margin);
}

/* Smallest D that is safe */
TFA_INLINE num sentinel_floor(const struct state *s, const body_constants *b, uint32_t k)
{
    return (body_inertia_bound(b, k) + s->payload_bound) * SENTINEL_RATIO;
}

/* D of a joint with one freedom; */
TFA_INLINE void sentinel_see_D(struct state *s, const body_constants *b, num D)
{
    sentinel_see(s, D - sentinel_floor(s, b, 0));
}

/* 1/D of freedom k */
TFA_INLINE void sentinel_see_inverse(struct state *s, const body_constants *b, uint32_t k,
                                     num inverse)
{
    sentinel_see(s, num_select(inverse > 0, 1 - inverse * sentinel_floor(s, b, k), num_of(-1)));
}

/* Several freedoms: entry k of the diagonal of D^-1 = L^-T diag(L)^-1 L^-1, for no pivot need be
 * small where a combination of freedoms moves little. Rows of six, the inverse pivots on the
 * diagonal. */
static inline void sentinel_see_joint_nd(struct state *s, const body_constants *b,
                                         const struct joint_nd *w)
{
    for (uint32_t k = 0; k < b->n; k++) {
        num column[6], inverse = w->L[7 * k];
        for (uint32_t i = k + 1; i < b->n; i++) { /* of L^-1 */
            column[i] = -w->L[6 * i + k];
            for (uint32_t j = k + 1; j < i; j++)
                column[i] -= w->L[6 * i + j] * column[j];
            inverse += column[i] * column[i] * w->L[7 * i];
        }
        if (!(w->locked >> k & 1))
            sentinel_see_inverse(s, b, k, inverse);
    }
}

/* The same for freedoms k .. k + 2 of a floating base, after those before them are eliminated: its
 * linear, then its angular ones. A combination of both that moves little is seen by the angular
 * ones. */
TFA_INLINE void sentinel_see_block(struct state *s, const body_constants *b, uint32_t k,
                                   const num *L)
{
    const num *D = L + 7 * k, l1 = D[6], l2 = D[12], l3 = D[13], l = l1 * l3 - l2;
    sentinel_see_inverse(s, b, k, D[0] + l1 * l1 * D[7] + l * l * D[14]);
    sentinel_see_inverse(s, b, k + 1, D[7] + l3 * l3 * D[14]);
    sentinel_see_inverse(s, b, k + 2, D[14]);
}

/* Of some state, if there are several */
TFA_INLINE int sentinel_trips(const struct state *s)
{
    return !num_all(s->margin >= 0);
}

#endif
