/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of the tips in the metric of the kinetic energy.
 */
#include "dynamics/osim/tip_rows.h"

#include "dynamics/core/recursions.h"
#include "dynamics/osim/constraint_rows.h"
#include "dynamics/osim/lambda.h"
#include "layout/parent_transfer.h"
#include "spatial/dense.h"

/* ---- articulated bodies ---- */

/* H^T P of every joint that supports a tip, in s->psi */
static void propagate_tips(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w;
    TFA_V(support_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++)
        for (TFA_V(tip_start)(s, t, frame, &w); w.body >= 0;)
            if (s->body[w.body].base && s->body[w.body].flexible < 0)
                TFA_V(tip_at_base)(s, t, &w);
            else
                TFA_V(tip_through_joint)(s, t, &w);
}

/* D^-1/2 of the freedoms of a joint; 0 of locked ones */
static inline void joint_weights(const struct state *s, uint32_t i, num weight[6])
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

/* weight y in the metric, the numbers of a tip in a row of B */
static inline void put_tip(const struct state *s, const vec6 *metric, num weight, vec6 y, num *out)
{
    for (int v = 0; v < VEC6_VECS; v++)
        y.vec[v] *= weight * metric->vec[v];
    if (s->tip_rows == 6)
        vec6_store(out, &y);
    else
        for (int e = 0; e < 3; e++)
            out[e] = vec6_lane(&y, e);
}

/* Rows of B from `out` on: those of the n freedoms of body i */
TFA_INLINE void put_joint(const struct state *s, const vec6 *metric, uint32_t i, uint32_t n,
                          uint32_t tips, num *out)
{
    const struct tfa_body *b = &s->body[i];
    const uint32_t stride = tip_stride(s);
    num weight[6];
    joint_weights(s, i, weight);
    for (uint32_t k = 0; k < n; k++)
        row_store(out + stride * (k + 1) - NUM_VEC_LANES, (num_vec){0});
    for (uint32_t t = 0; t < tips; t++, out += s->tip_rows) {
        vec6 y[6];
        const int moved = tips == 1 || s->support[i] >> t & 1;
        for (uint32_t k = 0; k < n; k++)
            y[k] = moved ? vec6_load(tip_columns(s, s->psi, b->v + k, t)) : vec6_zero();
        if (n > 1)
            vec6_ldl_lower(s->joint_nd[b->joint_nd].L, n, y);
        for (uint32_t k = 0; k < n; k++)
            put_tip(s, metric, weight[k], y[k], out + stride * k);
    }
}

/* Sum of both sides of a constraint. Returns 0 where the body supports neither. */
static inline int sides_of(const struct state *s, const struct closing *c, uint32_t i, vec6 *y)
{
    const struct tfa_body *b = &s->body[i];
    int moved = 0;
    for (int side = 1; side >= 0; side--) {
        const int32_t t = c->tip[side];
        if (t < 0 || !(s->support[i] >> t & 1))
            continue;
        for (uint32_t k = 0; k < b->n; k++) {
            const vec6 psi = vec6_load(tip_columns(s, s->psi, b->v + k, (uint32_t)t));
            y[k] = moved ? vec6_add_scaled(y[k], num_of(1), psi) : psi;
        }
        moved = 1;
    }
    return moved;
}

/* As put_joint, of the held rows of constraints */
static void put_joint_closings(const struct state *s, const vec6 *metric, uint32_t i, num *out)
{
    const struct tfa_body *b = &s->body[i];
    const uint32_t n = b->n, stride = tip_stride(s);
    num weight[6], row[6];
    joint_weights(s, i, weight);
    for (uint32_t c = 0; c < n * stride; c += NUM_VEC_LANES)
        row_store(out + c, (num_vec){0});
    for (uint32_t c = 0, at = 0; c < s->closings; at += s->closing[c++].held) {
        const uint32_t rows = s->closing[c].of->rows;
        vec6 y[6];
        if (!sides_of(s, &s->closing[c], i, y))
            continue;
        if (n > 1)
            vec6_ldl_lower(s->joint_nd[b->joint_nd].L, n, y);
        for (uint32_t k = 0; k < n; k++) {
            num *to = out + stride * k + at;
            for (int v = 0; v < VEC6_VECS; v++)
                y[k].vec[v] *= weight[k] * metric->vec[v];
            vec6_store(row, &y[k]);
            for (uint32_t e = 0; e < 6; e++)
                if (rows >> e & 1)
                    *to++ = row[e];
        }
    }
}

/* Each body that supports a tip */
#define FOR_EACH_SUPPORT(s, i)                                                                     \
    for (uint32_t at_ = 0; at_ < (s)->spans; at_++)                                                \
        for (uint32_t i = (s)->span[at_].first; i < (s)->span[at_].end; i++)                       \
            if ((s)->support[i])

static void articulated_rows(struct state *s, tfa_reference_frame frame)
{
    const num one = num_of(1), l = s->tip_length;
    const vec6 metric = vec6_concat(vec3_simd_of(one, one, one), vec3_simd_of(l, l, l));
    num *out = s->phi;
    if (s->psi_frame != (int32_t)frame)
        propagate_tips(s, frame);
    s->tip_freedoms = 0;
    FOR_EACH_SUPPORT(s, i)
    {
        const uint32_t n = s->body[i].n;
        if (s->closings)
            put_joint_closings(s, &metric, i, out);
        else if (n == 1 && s->tips == 1)
            put_joint(s, &metric, i, 1, 1, out);
        else
            put_joint(s, &metric, i, n, s->tips, out);
        s->tip_freedoms += n;
        out += (size_t)tip_stride(s) * n;
    }
}

/* a_i = X_i a_parent + c_i, which the body has without qdd */
TFA_INLINE svec acceleration_of_bias(struct state *s, uint32_t i, svec ground)
{
    const struct tfa_body *b = &s->body[i];
    const svec a = motion_to_child(s, i, b, parent_motion(b, s->a, ground));
    return s->a[i] = s->moving ? sv_add(a, s->c[i]) : a;
}

/* u = tau - H^T pA of the inward pass. With `biased` that pass was forward dynamics: u - U^T a is u
 * of tau - h. */
TFA_INLINE void articulated_force(struct state *s, int biased, num *z)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    FOR_EACH_SUPPORT(s, i)
    {
        const struct tfa_body *b = &s->body[i];
        const svec a = biased ? acceleration_of_bias(s, i, ground) : sv_zero();
        num weight[6];
        joint_weights(s, i, weight);
        if (b->n == 1) {
            *z++ = weight[0] * (biased ? s->u[i] - sv_dot(s->U[i], a) : s->u[i]);
            continue;
        }
        const struct joint_nd *w = &s->joint_nd[b->joint_nd];
        for (uint32_t k = 0; k < b->n; k++)
            z[k] = biased ? w->u[k] - sv_dot(sv_from(w->U + 6 * k), a) : w->u[k];
        ldl_lower_rows(w->L, (int)b->n, 6, z);
        for (uint32_t k = 0; k < b->n; k++)
            z[k] *= weight[k];
        z += b->n;
    }
}

/* u -= L D^1/2 z: what the pass inward leaves of forces is L^-1 of them */
void TFA_V(subtract_force_rows)(struct state *s, const num *z)
{
    FOR_EACH_SUPPORT(s, i)
    {
        const struct tfa_body *b = &s->body[i];
        num weight[6];
        joint_weights(s, i, weight);
        if (b->n == 1) {
            s->u[i] -= *z++ / weight[0];
            continue;
        }
        struct joint_nd *w = &s->joint_nd[b->joint_nd];
        for (uint32_t k = 0; k < b->n; k++) {
            num sum = z[k] / weight[k];
            for (uint32_t e = 0; e < k; e++)
                sum += w->L[6 * k + e] * z[e] / weight[e];
            w->u[k] -= sum;
        }
        z += b->n;
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

/* Column of s->psi of row c */
static uint32_t column_of(const struct state *s, uint32_t c)
{
    if (s->closings)
        return TFA_V(constraint_column)(s, c);
    return 6 * (c / s->tip_rows) + c % s->tip_rows;
}

static void projected_rows(struct state *s, tfa_reference_frame frame)
{
    const uint32_t n = s->tip_freedoms = s->m->freedoms - s->m->mimics, stride = tip_stride(s),
                   rows = all_tip_rows(s);
    num *column = s->force_row;
    if (s->closings)
        TFA_V(constraint_jacobian)(s);
    else
        TFA_V(jacobian)(s, frame);
    for (uint32_t c = 0; c < stride; c++) {
        if (c < rows)
            project(s, s->psi + column_of(s, c), 6 * s->tips, column);
        for (uint32_t a = 0; a < n; a++)
            s->phi[(size_t)stride * a + c] = c < rows ? column[a] * scale_of(s, c) : num_of(0);
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

void TFA_V(force_rows)(struct state *s, const num *tau, num *z)
{
    if (!tau)
        articulated_force(s, 1, z);
    else if (s->m->mimics)
        project(s, tau, 1, z);
    else
        articulated_force(s, 0, z);
}
