/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * M by rows of the tree of freedoms, and its sparse factors M = L^T D L in place of it
 * (Featherstone 2008, 6.4 and 6.5). Row j, at m->dof_row[j], has the columns of j's ancestors, root
 * first, then its own.
 */
#ifndef TFA_LAYOUT_MASS_ROWS_H
#define TFA_LAYOUT_MASS_ROWS_H

#include "model/model.h"
#include "spatial/row_vectors.h"

/* O(N d^2) */
TFA_INLINE void factor_mass_rows(const struct tfa_model *m, num *M)
{
    for (uint32_t k = m->freedoms; k-- > 0;) {
        num *row = M + m->dof_row[k];
        num inv = 1 / row[m->dof_depth[k]];
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *up = M + m->dof_row[i];
            uint32_t depth = m->dof_depth[i];
            num l = row[depth] * inv;
            uint32_t j = 0;
            for (; j + NUM_VEC_LANES <= depth + 1; j += NUM_VEC_LANES)
                numbers_store(up + j, numbers_load(up + j) - l * numbers_load(row + j));
            for (; j <= depth; j++)
                up[j] -= l * row[j];
            row[depth] = l;
        }
    }
}

/* x = L^-T x */
TFA_INLINE void half_solve_mass_rows(const struct tfa_model *m, const num *M, num *x, size_t stride)
{
    for (uint32_t k = m->freedoms; k-- > 0;) {
        const num *row = M + m->dof_row[k];
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i])
            x[(size_t)i * stride] -= row[m->dof_depth[i]] * x[k * stride];
    }
}

/* x = M^-1 x */
TFA_INLINE void solve_mass_rows(const struct tfa_model *m, const num *M, num *x)
{
    half_solve_mass_rows(m, M, x, 1);
    for (uint32_t k = 0; k < m->freedoms; k++) {
        const num *row = M + m->dof_row[k];
        num sum = x[k] / row[m->dof_depth[k]];
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i])
            sum -= row[m->dof_depth[i]] * x[i];
        x[k] = sum;
    }
}

#endif
