/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel over factors that a method has left (sentinel.h). The articulated-body recursion of
 * all bodies sees its own while it runs (aba.c, lock.c).
 */
#include "dynamics/core/sentinel.h"

#include "dynamics/core/recursions.h"
#include "dynamics/solve/method.h"

/* Of T^T M T, where a freedom also moves the subtrees of its followers */
static void see_reduced(struct state *s)
{
    const struct tfa_model *m = s->m;
    const uint32_t n = m->freedoms - m->mimics;
    num multiplier;
    for (uint32_t a = 0; a < n; a++)
        s->y[a] = num_of(0);
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t a = TFA_V(reduced_freedom)(m, s->body[i].v + k, &multiplier);
            s->y[a] += multiplier * multiplier * sentinel_floor(s, &s->body[i], k);
        }
    for (uint32_t a = 0; a < n; a++) {
        const num inverse = s->Mr[(size_t)a * n + a];
        sentinel_see(s, num_select(inverse > 0, 1 - inverse * s->y[a], num_of(-1)));
    }
}

/* The entries of D in M = L^T D L are those of the recursion. */
static void see_ltdl(struct state *s)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t j = s->body[i].v + k;
            sentinel_see(s,
                         s->M[m->dof_row[j] + m->dof_depth[j]] - sentinel_floor(s, &s->body[i], k));
        }
}

void TFA_V(sentinel_see_mass)(struct state *s)
{
    if (s->m->mimics)
        see_reduced(s);
    else
        see_ltdl(s);
}

void TFA_V(sentinel_see_articulated)(struct state *s)
{
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        if (b->n == 1)
            sentinel_see_inverse(s, b, 0, s->Dinv[i]);
        else
            sentinel_see_joint_nd(s, b, &s->joint_nd[b->joint_nd]);
    }
}

int TFA_V(sentinel_of)(struct state *s, tfa_method method)
{
    const num kept = s->margin; /* goes with the factors of aba */
    const struct method *row = TFA_V(method)(method);
    if (row->see) {
        sentinel_reset(s);
        row->see(s);
    }
    const int trips = sentinel_trips(s);
    s->margin = kept;
    return trips;
}
