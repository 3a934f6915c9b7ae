/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints that mimic others as a constraint: G x = 0 with a row x_follower - multiplier x_leader for
 * each. x = M^-1 (tau - h), then x -= W S^-1 G x with W = M^-1 G^T, S = G W: as many solves more as
 * there are followers, with the kept factors of any method.
 */
#include "dynamics/solve/method.h"

/* A leader that is locked locks its followers: nothing is left to constrain. */
static inline int active(const struct state *s, const struct tfa_mimic *g)
{
    return !s->lock[g->leader];
}

static inline num violation(const struct tfa_mimic *g, const num *x)
{
    return x[g->follower] - num_of(g->multiplier) * x[g->leader];
}

/* W and the factors of S, by the factors of the method */
static void factor_constraints(struct state *s, tfa_method method)
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
                both ? violation(&m->mimic[k], s->W + (size_t)j * m->freedoms) : num_of(j == k);
        }
    ldl_factor_rows(s->S, (int)m->mimics, m->mimics);
    s->have |= HAVE_W;
    s->w_method = method;
}

void TFA_V(impose_mimics)(struct state *s, tfa_method method, num *x)
{
    const struct tfa_model *m = s->m;
    if (!m->mimics)
        return;
    factor_constraints(s, method);
    num *z = s->y;
    for (uint32_t k = 0; k < m->mimics; k++)
        z[k] = active(s, &m->mimic[k]) ? violation(&m->mimic[k], x) : num_of(0);
    ldl_solve_rows(s->S, (int)m->mimics, m->mimics, z);
    for (uint32_t k = 0; k < m->mimics; k++) {
        const num *w = s->W + (size_t)k * m->freedoms;
        for (uint32_t j = 0; j < m->freedoms; j++)
            x[j] -= w[j] * z[k];
    }
    for (uint32_t k = 0; k < m->mimics; k++) /* exactly */
        x[m->mimic[k].follower] = num_of(m->mimic[k].multiplier) * x[m->mimic[k].leader];
}
