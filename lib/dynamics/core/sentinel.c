/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel over factors that a method has left (sentinel.h). The articulated-body recursion of
 * all bodies sees its own while it runs (aba.c, lock.c).
 */
#include "dynamics/core/sentinel.h"

#include "dynamics/core/recursions.h"

/* What the sizes G of the freedoms of body i are made of */
typedef struct sentinel_size size_fn(const struct state *s, uint32_t i);

static struct sentinel_size articulated(const struct state *s, uint32_t i)
{
    return sentinel_size(s, &s->body[i], &s->IA[i]);
}

/* For M, where nothing has been taken away */
static struct sentinel_size composite(const struct state *s, uint32_t i)
{
    return (struct sentinel_size){s3_trace(s->composite[i].I), 3 * s->composite[i].m};
}

/* For derivatives, which are made about one point */
static struct sentinel_size about_origin(const struct state *s, uint32_t i)
{
    return (struct sentinel_size){s3_trace(s->subtree[i].I), 3 * s->subtree[i].m};
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

/* Of T^T M T, where a freedom also moves the subtrees of its followers */
static num see_reduced(struct state *s, size_fn *size)
{
    const struct tfa_model *m = s->m;
    const uint32_t n = m->freedoms - m->mimics;
    num multiplier, margin = num_of(1), *const G = s->y, *const x = s->qdd_unrefined;
    for (uint32_t a = 0; a < n; a++)
        G[a] = num_of(0);
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct sentinel_size g = size(s, i);
        for (uint32_t k = 0; k < s->body[i].n; k++) {
            const uint32_t j = s->body[i].v + k, a = TFA_V(reduced_freedom)(m, j, &multiplier);
            x[a] = unit_of(s, &s->body[i], k);
            if (!s->lock[j])
                G[a] += multiplier * multiplier * sentinel_size_of(s, &s->body[i], k, &g);
        }
    }
    for (uint32_t a = n; a-- > 0;) {
        const num unit = x[a], inverse = s->Mr[(size_t)a * n + a];
        x[a] = unit * G[a] * inverse;
        for (uint32_t k = a + 1; k < n; k++)
            x[a] -= s->Mr[(size_t)k * n + a] * x[k];
        margin = sentinel_smaller(margin, sentinel_margin_inverse(inverse, G[a]));
        margin = sentinel_smaller_motion(margin, x[a], unit);
    }
    return margin;
}

static num see_ltdl(const struct state *s, size_fn *size)
{
    num margin = num_of(1);
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const struct sentinel_size g = size(s, i);
        for (uint32_t k = 0; k < b->n; k++)
            margin =
                sentinel_margin_row(s->m, s->M, b->v + k, sentinel_size_of(s, b, k, &g),
                                    unit_of(s, b, k), s->lock[b->v + k], s->qdd_unrefined, margin);
    }
    return margin;
}

static num see_mass(struct state *s, size_fn *size)
{
    return s->m->mimics ? see_reduced(s, size) : see_ltdl(s, size);
}

static num see_articulated(const struct state *s, size_fn *size)
{
    num margin = num_of(1);
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const struct sentinel_size G = size(s, i);
        if (b->n > 1)
            margin = sentinel_smaller(margin,
                                      sentinel_margin_joint_nd(b, &G, &s->joint_nd[b->joint_nd]));
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
