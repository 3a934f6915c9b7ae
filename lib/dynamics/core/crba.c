/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Composite rigid bodies and the sparse factorisation M = L^T D L along the tree of freedoms.
 * Featherstone 2008, chapter 6. Row j of M holds its ancestors' columns only, root first.
 */
#include "dynamics/core/recursions.h"
#include "layout/body.h"

/* Writes one row of M: walks the force f = Ic H from body i to the root. */
static void fill_row(struct state *s, uint32_t i, uint32_t k, svec f)
{
    const struct tfa_model *m = s->m;
    const struct tfa_body *b = &s->body[i];
    uint32_t j = b->v + k;
    num *row = s->M + m->dof_row[j];
    num h[6];
    joint_force(s, b, f, h);
    for (uint32_t e = 0; e <= k; e++)
        row[m->dof_depth[b->v] + e] = h[e];
    row[m->dof_depth[j]] += joint_armature(s, b, k);
    for (int32_t up = b->parent; up >= 0; up = s->body[up].parent) {
        f = xform_t_force(&s->X[i], f);
        i = (uint32_t)up;
        const struct tfa_body *a = &s->body[up];
        joint_force(s, a, f, row + m->dof_depth[a->v]);
    }
}

void TFA_V(crba)(struct state *s)
{
    const struct tfa_model *m = s->m;
    if (s->have & HAVE_M)
        return;
    s->have = (s->have | HAVE_M) & ~(uint32_t)HAVE_LTDL;
    for (uint32_t i = 0; i < m->bodies; i++)
        s->Ic[i] = rigid_inertia(&s->body[i]);
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        if (b->parent >= 0) {
            sym6 up = s6_to_parent(&s->X[i], &s->Ic[i]);
            s6_add(&s->Ic[b->parent], &up);
        }
        for (uint32_t k = 0; k < b->n; k++) {
            svec H = b->n == 1 ? sv_zero() : joint_nd_axis(&s->joint_nd[b->joint_nd], k);
            if (b->n == 1)
                sv_put(&H, body_axis(b), num_of(1));
            fill_row(s, i, k, s6_mul(&s->Ic[i], H));
        }
    }
}

void TFA_V(ltdl_factor)(struct state *s)
{
    const struct tfa_model *m = s->m;
    s->have |= HAVE_LTDL;
    if (m->mimics) {
        TFA_V(reduced_factor)(s);
        return;
    }
    s->have &= ~(uint32_t)HAVE_M;
    for (uint32_t k = m->freedoms; k-- > 0;) {
        num *row = s->M + m->dof_row[k];
        num inv = 1 / row[m->dof_depth[k]];
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *up = s->M + m->dof_row[i];
            uint32_t depth = m->dof_depth[i];
            num l = row[depth] * inv;
            for (uint32_t j = 0; j <= depth; j++)
                up[j] -= l * row[j];
            row[depth] = l;
        }
    }
}

void TFA_V(ltdl_half)(const struct state *s, num *x, size_t stride)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = m->freedoms; k-- > 0;) {
        const num *row = s->M + m->dof_row[k];
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i])
            x[(size_t)i * stride] -= row[m->dof_depth[i]] * x[k * stride];
    }
}

void TFA_V(ltdl_solve)(struct state *s, num *x)
{
    const struct tfa_model *m = s->m;
    if (m->mimics) {
        TFA_V(reduced_solve)(s, x);
        return;
    }
    TFA_V(ltdl_half)(s, x, 1);
    for (uint32_t k = 0; k < m->freedoms; k++) {
        const num *row = s->M + m->dof_row[k];
        num sum = x[k] / row[m->dof_depth[k]];
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i])
            sum -= row[m->dof_depth[i]] * x[i];
        x[k] = sum;
    }
}
