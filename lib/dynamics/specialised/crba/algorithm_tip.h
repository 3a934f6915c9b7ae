/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Algorithm `crba` for tips: six half-solves with the factors of M.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_ALGORITHM_TIP_H
#define TFA_DYNAMICS_SPECIALISED_ALGORITHM_TIP_H

#include "algorithm.h"
#include "spatial/vec6.h"

#define ROBOT_CRBA_BACKWARD_TREE(i)                                                                \
    if (robot_body[i].tree == robot_body[tip].tree)                                                \
        crba_backward_step(s, m, i, 0);

/* Factors of the subtree of the tip's first moving ancestor, whose poses are there */
TFA_INLINE void factor_tree(struct state *s, struct robot_factors *m, int32_t tip)
{
    clear_factors(m);
    ROBOT_INWARD(ROBOT_CRBA_BACKWARD_TREE)
}

/* psi_i = H_i^T P - sum of l_ki psi_k over the bodies k on the path behind i: row i of L^-T J^T;
 * C += psi_i^T D_i^-1 psi_i */
TFA_INLINE void half_solve_body(const struct state *s, const struct robot_factors *m, int32_t tip,
                                int32_t i, struct wrench_columns *P, vec6 *psi, struct mat6_simd *C)
{
    const body_constants *b = body_constants_of(s, (uint32_t)i);
    vec6 x = P->at[is_revolute(b->kind) ? AXIS_RZ : AXIS_TZ];
#pragma GCC unroll 64
    for (int32_t k = 0; k < ROBOT_BODIES; k++)
        if (k > i && is_on_path(k, tip))
            x = vec6_sub_scaled(x, m->row[k][i], psi[k]);
    psi[i] = x;
    const vec6 phi = vec6_scale(m->Dinv[i], x);
    mat6_simd_add_outer(C, &x, &phi);
    if (b->parent >= 0)
        wrench_columns_to_parent(&s->X[i], P, 0);
}

#define ROBOT_HALF_SOLVE(i)                                                                        \
    if (is_on_path(i, tip))                                                                        \
        half_solve_body(s, m, tip, i, &P, psi, &C);

/* Lambda^-1 = (L^-T J^T)^T D^-1 L^-T J^T of six unit wrenches P on body `tip` */
TFA_INLINE struct mat6_simd response_of_tip(const struct state *s, const struct robot_factors *m,
                                            int32_t tip, struct wrench_columns P)
{
    struct mat6_simd C = mat6_simd_zero();
    vec6 psi[ROBOT_BODIES];
    ROBOT_INWARD(ROBOT_HALF_SOLVE)
    return C;
}

#endif
