/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints that mimic others: x = T y. Accelerations from T^T M T ydd = T^T (tau - h), dense.
 */
#include "dynamics/core/recursions.h"

/* The reduced freedom and the multiplier of inner freedom j */
uint32_t TFA_V(reduced_freedom)(const struct tfa_model *m, uint32_t j, num *multiplier)
{
    const uint32_t nb = m->base_freedoms;
    *multiplier = num_of(j < nb ? 1 : m->freedom[j - nb].multiplier);
    return j < nb ? j : nb + m->freedom[j - nb].from;
}

/* T^T M T from the entries of M, and its factors. A locked freedom couples with nothing: its row is
 * that of the identity; callers leave out the forces on it. */
void TFA_V(reduced_factor)(struct state *s)
{
    const struct tfa_model *m = s->m;
    const size_t n = m->freedoms - m->mimics;
    for (size_t e = 0; e < n * n; e++)
        s->Mr[e] = num_of(0);
    for (uint32_t j = 0; j < m->freedoms; j++)
        for (int32_t i = (int32_t)j; i >= 0; i = m->dof_parent[i]) {
            num left, right;
            const size_t a = TFA_V(reduced_freedom)(m, j, &left),
                         b = TFA_V(reduced_freedom)(m, (uint32_t)i, &right);
            if (s->lock[j] || s->lock[i]) {
                if (s->lock[j])
                    s->Mr[a * n + a] = num_of(1);
                continue;
            }
            const num x = left * right * s->M[m->dof_row[j] + m->dof_depth[i]];
            s->Mr[a * n + b] += x;
            if ((uint32_t)i != j)
                s->Mr[b * n + a] += x;
        }
    ldl_factor_rows(s->Mr, (int)n, n);
}

/* x <- T (T^T M T)^-1 T^T x */
void TFA_V(reduced_solve)(struct state *s, num *x)
{
    const struct tfa_model *m = s->m;
    const uint32_t n = m->freedoms - m->mimics;
    num multiplier;
    for (uint32_t j = 0; j < n; j++)
        s->y[j] = num_of(0);
    for (uint32_t j = 0; j < m->freedoms; j++) {
        const uint32_t a = TFA_V(reduced_freedom)(m, j, &multiplier);
        s->y[a] += multiplier * x[j];
    }
    ldl_solve_rows(s->Mr, (int)n, n, s->y);
    for (uint32_t j = 0; j < m->freedoms; j++) {
        const uint32_t a = TFA_V(reduced_freedom)(m, j, &multiplier);
        x[j] = multiplier * s->y[a];
    }
}
