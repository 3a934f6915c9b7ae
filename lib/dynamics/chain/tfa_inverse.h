/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inverse inertias along a chain, each as its own body and its outboard neighbour see it: what the
 * block rows of the total and of the constraint force algorithms are assembled from. A row needs
 * its own inverse and that of the row before, nothing else.
 */
#ifndef TFA_DYNAMICS_CHAIN_TFA_INVERSE_H
#define TFA_DYNAMICS_CHAIN_TFA_INVERSE_H

#include "layout/body.h"
#include "spatial/inverse.h"

/* I^-1 of a body on a chain, side branches included. 0, and s->bad_body says so, when the inertia
 * with side branches added is not positive definite. */
static inline int inverse_inertia(struct state *s, uint32_t i, sym6 *inverse)
{
    if (!(s->side[i] & HAS_BRANCH)) {
        *inverse = s->Iinv[i];
        return 1;
    }
    if (s6_invert(&s->IA[i], inverse))
        return 1;
    s->bad_body = (int32_t)i;
    return 0;
}

/* Rows 0,1 and 3,4 of a 6 x n matrix turned by the joint angle (cosine c, sine n) */
static inline void rotate_rows(num *x, num c, num n)
{
    for (int block = 0; block < 2; block++)
        for (int j = 0; j < 6; j++) {
            num *a = x + 18 * block + j;
            num up = a[0], down = a[6];
            a[0] = c * up + n * down;
            a[6] = c * down - n * up;
        }
}

/* XI = X_i I_{i-1}^-1 and Y = XI X_i^T from `up`, the inverse inertia of the parent. Constant
 * inertias on a revolute joint need plane rotations of the precomputed T I^-1 and T I^-1 T^T
 * only. */
static inline void inverse_from_parent(const struct state *s, uint32_t i, const sym6 *up, num *XI,
                                       num *Y)
{
    const struct tfa_body *b = &s->body[i];
    if (is_revolute(b->kind) && !(s->side[b->parent] & HAS_BRANCH)) {
        const struct model_constants *t = &s->model_constants[i];
        const num c = s->cosine[b->q], n = s->sine[b->q];
        for (int k = 0; k < 36; k++)
            XI[k] = t->TI[k];
        rotate_rows(XI, c, n);
        const num o = num_of(0);
        const mat3 Z = {c, n, o, -n, c, o, o, o, num_of(1)};
        sym6 y = {s3_congruence(Z, t->TIT.A), m3_congruence_t(m3_t(Z), t->TIT.B),
                  s3_congruence(Z, t->TIT.M)};
        s6_dense(Y, &y);
        return;
    }
    sym6 y;
    inverse_inertia_to_child(&s->X[i], up, XI, &y);
    s6_dense(Y, &y);
}

#endif
