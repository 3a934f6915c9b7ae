/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel over factors that a method has left (sentinel.h). The articulated-body recursion of
 * all bodies sees its own while it runs (aba.c, lock.c).
 */
#include "dynamics/core/sentinel.h"

#include "dynamics/core/recursions.h"

/* G of freedom k: for M that of the composite inertia, where nothing has been taken away */
static num size_of(const struct state *s, uint32_t i, uint32_t k)
{
    const struct sentinel_size G = {s3_trace(s->Ic[i].A), s3_trace(s->Ic[i].M)};
    return sentinel_size_of(s, &s->body[i], k, &G);
}

/* Of T^T M T, where a freedom also moves the subtrees of its followers */
static num see_reduced(struct state *s)
{
    const struct tfa_model *m = s->m;
    const uint32_t n = m->freedoms - m->mimics;
    num multiplier, margin = num_of(1);
    for (uint32_t a = 0; a < n; a++)
        s->y[a] = num_of(0);
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t j = s->body[i].v + k, a = TFA_V(reduced_freedom)(m, j, &multiplier);
            if (!s->lock[j])
                s->y[a] += multiplier * multiplier * size_of(s, i, k);
        }
    for (uint32_t a = 0; a < n; a++)
        margin =
            sentinel_smaller(margin, sentinel_margin_inverse(s->Mr[(size_t)a * n + a], s->y[a]));
    return margin;
}

/* The entries of D in M = L^T D L are those of the recursion. */
static num see_ltdl(const struct state *s)
{
    const struct tfa_model *m = s->m;
    num margin = num_of(1);
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t j = s->body[i].v + k;
            if (!s->lock[j])
                margin =
                    sentinel_smaller(margin, sentinel_margin(s->M[m->dof_row[j] + m->dof_depth[j]],
                                                             size_of(s, i, k)));
        }
    return margin;
}

num TFA_V(sentinel_margin_mass)(struct state *s)
{
    return s->m->mimics ? see_reduced(s) : see_ltdl(s);
}

num TFA_V(sentinel_margin_articulated)(const struct state *s)
{
    num margin = num_of(1);
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const struct sentinel_size G = sentinel_size(s, b, &s->IA[i]);
        margin = sentinel_smaller(
            margin, b->n == 1
                        ? sentinel_margin_inverse(s->Dinv[i], sentinel_size_of(s, b, 0, &G))
                        : sentinel_margin_joint_nd(s, b, &s->IA[i], &s->joint_nd[b->joint_nd]));
    }
    return margin;
}
