/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel over factors that a method has left (sentinel.h). The articulated-body recursion of
 * all bodies sees its own while it runs (aba.c, lock.c).
 */
#include "dynamics/core/sentinel.h"

#include "dynamics/core/recursions.h"

/* Whose traces are the sizes G of the freedoms of body i */
typedef sym6 inertia_fn(const struct state *s, uint32_t i);

static sym6 articulated(const struct state *s, uint32_t i)
{
    return s->IA[i];
}

/* For M, where nothing has been taken away */
static sym6 composite(const struct state *s, uint32_t i)
{
    return s->Ic[i];
}

/* For derivatives, which are made about one point */
static sym6 about_origin(const struct state *s, uint32_t i)
{
    const struct subtree *t = &s->subtree[i];
    return s6_rigid(t->I, t->h, t->m);
}

/* G of freedom k */
static num size_of(const struct state *s, uint32_t i, uint32_t k, inertia_fn *inertia)
{
    const sym6 I = inertia(s, i);
    const struct sentinel_size G = {s3_trace(I.A), s3_trace(I.M)};
    return sentinel_size_of(s, &s->body[i], k, &G);
}

/* A motion of freedom k as large as one radian */
static num unit_of(const struct state *s, const struct tfa_body *b, uint32_t k)
{
    const num length = num_of(s->m->length);
    if (b->n == 1)
        return is_revolute(b->kind) ? num_of(1) : length;
    const vec3 w = joint_nd_axis(&s->joint_nd[b->joint_nd], k).w;
    return num_select(v3_dot(w, w) > num_of(0.5), num_of(1), length);
}

/* Nor may the freedoms together move much more than each would alone, for the forces G: two pivots
 * that are both small multiply. */
static num see_motion(num margin, num x, num unit)
{
    return sentinel_smaller(margin, unit - num_abs(x) * SENTINEL_RATIO);
}

/* Of T^T M T, where a freedom also moves the subtrees of its followers */
static num see_reduced(struct state *s, inertia_fn *inertia)
{
    const struct tfa_model *m = s->m;
    const uint32_t n = m->freedoms - m->mimics;
    num multiplier, margin = num_of(1), *const G = s->y, *const x = s->qdd_unrefined;
    for (uint32_t a = 0; a < n; a++)
        G[a] = num_of(0);
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t j = s->body[i].v + k, a = TFA_V(reduced_freedom)(m, j, &multiplier);
            x[a] = unit_of(s, &s->body[i], k);
            if (!s->lock[j])
                G[a] += multiplier * multiplier * size_of(s, i, k, inertia);
        }
    for (uint32_t a = n; a-- > 0;) {
        const num unit = x[a], inverse = s->Mr[(size_t)a * n + a];
        x[a] = unit * G[a] * inverse;
        for (uint32_t k = a + 1; k < n; k++)
            x[a] -= s->Mr[(size_t)k * n + a] * x[k];
        margin = sentinel_smaller(margin, sentinel_margin_inverse(inverse, G[a]));
        margin = see_motion(margin, x[a], unit);
    }
    return margin;
}

/* The entries of D in M = L^T D L are those of the recursion. */
static num see_ltdl(const struct state *s, inertia_fn *inertia)
{
    const struct tfa_model *m = s->m;
    num margin = num_of(1), *const x = s->qdd_unrefined;
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t j = s->body[i].v + k;
            const num *const L = s->M + m->dof_row[j];
            const num D = L[m->dof_depth[j]], G = size_of(s, i, k, inertia),
                      unit = unit_of(s, &s->body[i], k);
            x[j] = num_of(0);
            if (s->lock[j])
                continue;
            x[j] = unit * G / D;
            for (int32_t up = m->dof_parent[j]; up >= 0; up = m->dof_parent[up])
                x[j] -= L[m->dof_depth[up]] * x[up];
            margin = sentinel_smaller(margin, sentinel_margin(D, G));
            margin = see_motion(margin, x[j], unit);
        }
    return margin;
}

static num see_mass(struct state *s, inertia_fn *inertia)
{
    return s->m->mimics ? see_reduced(s, inertia) : see_ltdl(s, inertia);
}

static num see_articulated(const struct state *s, inertia_fn *inertia)
{
    num margin = num_of(1);
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const sym6 I = inertia(s, i);
        const struct sentinel_size G = sentinel_size(s, b, &I);
        if (b->n > 1)
            margin = sentinel_smaller(
                margin, sentinel_margin_joint_nd(s, b, &I, &s->joint_nd[b->joint_nd]));
        else if (!s->lock[b->v])
            margin = sentinel_smaller(
                margin, sentinel_margin_inverse(s->Dinv[i], sentinel_size_of(s, b, 0, &G)));
    }
    return margin;
}

num TFA_V(sentinel_margin_mass)(struct state *s)
{
    return see_mass(s, composite);
}

num TFA_V(sentinel_margin_articulated)(const struct state *s)
{
    return see_articulated(s, articulated);
}

num TFA_V(sentinel_margin_derivatives)(struct state *s, int by_mass)
{
    return by_mass ? see_mass(s, about_origin) : see_articulated(s, about_origin);
}
