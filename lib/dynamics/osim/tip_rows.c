/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of the tips in the metric of the kinetic energy.
 */
#include "dynamics/osim/tip_rows.h"

#include "dynamics/core/recursions.h"
#include "dynamics/osim/lambda.h"
#include "spatial/dense.h"

/* ---- articulated bodies ---- */

/* H^T P of every joint that supports a tip, in s->psi */
static void propagate_tips(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w;
    TFA_V(support_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++)
        for (TFA_V(tip_start)(s, t, frame, &w); w.body >= 0;)
            TFA_V(tip_through_joint)(s, t, &w);
}

/* D^-1/2 of the freedoms of a joint; 0 of locked ones */
static void joint_weights(const struct state *s, uint32_t i, num weight[6])
{
    const struct tfa_body *b = &s->body[i];
    if (b->n == 1) {
        weight[0] = num_sqrt(s->Dinv[i]);
        return;
    }
    const struct joint_nd *w = &s->joint_nd[b->joint_nd];
    for (uint32_t k = 0; k < b->n; k++)
        weight[k] = !b->base && w->locked >> k & 1 ? num_of(0) : num_sqrt(w->L[7 * k]);
}

/* Rows `row` .. of B: those of the freedoms of body i */
static void put_joint(struct state *s, uint32_t i, uint32_t row)
{
    const struct tfa_body *b = &s->body[i];
    const uint32_t stride = s->tip_freedoms;
    num weight[6];
    joint_weights(s, i, weight);
    for (uint32_t t = 0; t < s->tips; t++) {
        vec6 y[6];
        num *B = s->phi + (size_t)s->tip_rows * t * stride + row;
        const int moved = (int)(s->support[i] >> t & 1);
        for (uint32_t k = 0; k < b->n; k++)
            y[k] = moved ? vec6_load(tip_columns(s, s->psi, b->v + k, t)) : vec6_zero();
        if (b->n > 1)
            vec6_ldl_lower(s->joint_nd[b->joint_nd].L, b->n, y);
        for (uint32_t k = 0; k < b->n; k++)
            for (uint32_t e = 0; e < s->tip_rows; e++)
                B[e * stride + k] = weight[k] * tip_row_scale(s, e) * vec6_lane(&y[k], (int)e);
    }
}

/* Each body that supports a tip, and its first row */
#define FOR_EACH_SUPPORT(s, i, row)                                                                \
    for (uint32_t at_ = 0, row = 0; at_ < (s)->spans; at_++)                                       \
        for (uint32_t i = (s)->span[at_].first; i < (s)->span[at_].end;                            \
             row += (s)->support[i] ? (s)->body[i].n : 0, i++)                                     \
            if ((s)->support[i])

static void articulated_rows(struct state *s, tfa_reference_frame frame)
{
    propagate_tips(s, frame);
    s->tip_freedoms = 0;
    FOR_EACH_SUPPORT(s, i, row)
    {
        s->tip_freedoms = row + s->body[i].n;
    }
    FOR_EACH_SUPPORT(s, i, row)
    {
        put_joint(s, i, row);
    }
}

/* u = tau - H^T pA of the inward pass */
static void articulated_force(const struct state *s, num *z)
{
    FOR_EACH_SUPPORT(s, i, row)
    {
        const struct tfa_body *b = &s->body[i];
        num weight[6];
        joint_weights(s, i, weight);
        for (uint32_t k = 0; k < b->n; k++)
            z[row + k] = b->n == 1 ? s->u[i] : s->joint_nd[b->joint_nd].u[k];
        if (b->n > 1)
            ldl_lower_rows(s->joint_nd[b->joint_nd].L, (int)b->n, 6, z + row);
        for (uint32_t k = 0; k < b->n; k++)
            z[row + k] *= weight[k];
    }
}

/* ---- mimics: T^T M T = L D L^T ---- */

/* out = D^-1/2 L^-1 T^T tau of forces tau that stand `stride` apart */
static void project(const struct state *s, const num *tau, size_t stride, num *out)
{
    const uint32_t n = s->tip_freedoms;
    for (uint32_t a = 0; a < n; a++)
        out[a] = num_of(0);
    for (uint32_t j = 0; j < s->m->freedoms; j++) {
        num multiplier;
        const uint32_t a = TFA_V(reduced_freedom)(s->m, j, &multiplier);
        if (!s->lock[j])
            out[a] += multiplier * tau[j * stride];
    }
    ldl_lower_rows(s->Mr, (int)n, n, out);
    for (uint32_t a = 0; a < n; a++)
        out[a] *= num_sqrt(s->Mr[(size_t)n * a + a]);
}

static void projected_rows(struct state *s, tfa_reference_frame frame)
{
    const uint32_t n = s->tip_freedoms = s->m->freedoms - s->m->mimics;
    TFA_V(jacobian)(s, frame);
    for (uint32_t t = 0; t < s->tips; t++)
        for (uint32_t e = 0; e < s->tip_rows; e++) {
            num *column = s->phi + (size_t)(s->tip_rows * t + e) * n;
            project(s, s->psi + 6 * t + e, 6 * s->tips, column);
            for (uint32_t a = 0; a < n; a++)
                column[a] *= tip_row_scale(s, e);
        }
}

/* ---- both ---- */

void TFA_V(tip_rows)(struct state *s, tfa_reference_frame frame)
{
    if (s->m->mimics)
        projected_rows(s, frame);
    else
        articulated_rows(s, frame);
}

void TFA_V(force_rows)(const struct state *s, const num *tau, num *z)
{
    if (s->m->mimics)
        project(s, tau, 1, z);
    else
        articulated_force(s, z);
}
