/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Freedoms that follow others: x = T y, G x = 0 with a row x_follower - multiplier x_leader of G
 * for each. Two ways to the same accelerations:
 *
 *   reduced      T^T M T ydd = T^T (tau - h), dense
 *   constrained  x = M^-1 (tau - h), then x -= W S^-1 G x with W = M^-1 G^T, S = G W: as many solves
 *                more as there are followers, with the kept factors of any method
 */
#include "kernel/kernel.h"

/* ---- T ---- */

/* The reduced freedom and the multiplier of inner freedom j */
uint32_t TFA_V(reduced_freedom)(const struct tfa_model *m, uint32_t j, num *multiplier)
{
    const uint32_t nb = m->base_freedoms;
    *multiplier = num_of(j < nb ? 1 : m->freedom[j - nb].multiplier);
    return j < nb ? j : nb + m->freedom[j - nb].from;
}

/* T^T M T from the entries of M, and its factors */
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

void TFA_V(gather)(struct state *s, num *tau)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = 0; k < m->mimics; k++)
        tau[m->mimic[k].leader] += num_of(m->mimic[k].multiplier) * tau[m->mimic[k].follower];
    for (uint32_t k = 0; k < m->mimics; k++)
        tau[m->mimic[k].follower] = num_of(0);
}

/* ---- G ---- */

/* A leader that is locked locks its followers: nothing is left to constrain. */
static inline int active(const struct state *s, const struct tfa_mimic *g)
{
    return !s->lock[g->leader];
}

static inline num gap(const struct tfa_mimic *g, const num *x)
{
    return x[g->follower] - num_of(g->multiplier) * x[g->leader];
}

/* W and the factors of S, by the factors of the method */
static void constrain(struct state *s, tfa_method method)
{
    const struct tfa_model *m = s->m;
    if (s->have & HAVE_W && s->w_method == method)
        return;
    for (uint32_t k = 0; k < m->mimics; k++) {
        const struct tfa_mimic *g = &m->mimic[k];
        num *w = s->W + (size_t)k * m->freedoms;
        for (uint32_t j = 0; j < m->freedoms; j++)
            w[j] = num_of(0);
        if (!active(s, g))
            continue;
        w[g->follower] = num_of(1);
        w[g->leader] -= num_of(g->multiplier);
        TFA_V(solve_free)(s, method, w, w);
    }
    for (uint32_t k = 0; k < m->mimics; k++)
        for (uint32_t j = 0; j < m->mimics; j++) {
            const int both = active(s, &m->mimic[k]) && active(s, &m->mimic[j]);
            s->S[(size_t)k * m->mimics + j] =
                both ? gap(&m->mimic[k], s->W + (size_t)j * m->freedoms) : num_of(j == k);
        }
    ldl_factor_rows(s->S, (int)m->mimics, m->mimics);
    s->have |= HAVE_W;
    s->w_method = method;
}

void TFA_V(follow)(struct state *s, tfa_method method, num *x)
{
    const struct tfa_model *m = s->m;
    if (!m->mimics)
        return;
    constrain(s, method);
    num *z = s->y;
    for (uint32_t k = 0; k < m->mimics; k++)
        z[k] = active(s, &m->mimic[k]) ? gap(&m->mimic[k], x) : num_of(0);
    ldl_solve_rows(s->S, (int)m->mimics, m->mimics, z);
    for (uint32_t k = 0; k < m->mimics; k++) {
        const num *w = s->W + (size_t)k * m->freedoms;
        for (uint32_t j = 0; j < m->freedoms; j++)
            x[j] -= w[j] * z[k];
    }
    for (uint32_t k = 0; k < m->mimics; k++) /* what rounding left */
        x[m->mimic[k].follower] = num_of(m->mimic[k].multiplier) * x[m->mimic[k].leader];
}
