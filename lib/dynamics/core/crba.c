/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Composite rigid bodies and the sparse factorisation of M along the tree of freedoms
 * (layout/mass_rows.h). Featherstone 2008, chapter 6.
 */
#include "dynamics/core/recursions.h"
#include "layout/body.h"
#include "layout/mass_rows.h"
#include "spatial/rigid.h"

/* Ic H_k for the joint of body b */
static inline svec composite_column(const struct state *s, const struct tfa_body *b, uint32_t k,
                                    const rigid *Ic)
{
    if (is_revolute(b->kind))
        return rigid_column_rz(Ic);
    if (is_prismatic(b->kind))
        return rigid_column_tz(Ic);
    return s6_rigid_mul(Ic->I, Ic->h, Ic->m, joint_nd_axis(&s->joint_nd[b->joint_nd], k));
}

static inline rigid composite_to_parent(const struct state *s, uint32_t i, const struct tfa_body *b)
{
    const screw e = body_screw(s, i, b);
    return body_axial(b) ? screw_rigid_to_parent(&e, &s->composite[i])
                         : rigid_to_parent(&s->X[i], &s->composite[i]);
}

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
        f = force_to_parent(s, i, &s->body[i], f);
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
        s->composite[i] = (rigid){body_mass(&s->body[i]), body_h(&s->body[i]), body_I(&s->body[i])};
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        if (b->parent >= 0) {
            const rigid up = composite_to_parent(s, i, b);
            s->composite[b->parent] = rigid_add(&s->composite[b->parent], &up);
        }
        for (uint32_t k = 0; k < b->n; k++)
            fill_row(s, i, k, composite_column(s, b, k, &s->composite[i]));
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
    factor_mass_rows(m, s->M);
}

void TFA_V(ltdl_half)(const struct state *s, num *x, size_t stride)
{
    half_solve_mass_rows(s->m, s->M, x, stride);
}

void TFA_V(ltdl_solve)(struct state *s, num *x)
{
    if (s->m->mimics)
        TFA_V(reduced_solve)(s, x);
    else
        solve_mass_rows(s->m, s->M, x);
}
