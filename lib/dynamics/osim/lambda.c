/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 = J M^-1 J^T of tips: by force propagation with the articulated-body
 * factors, by the factors of M, and by columns with any method's solve.
 */
#include "dynamics/osim/lambda.h"

#include "dynamics/core/modes.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/osim/constraint_rows.h"
#include "layout/body.h"
#include "spatial/unit_wrenches.h"

/* The joint's share of six forces: out[k][e] = H_k^T P_e for its first `freedoms` freedoms, which
 * are those that move what the forces act on; 0 for the rest. */
static inline void joint_columns(const struct state *s, const struct tfa_body *b, const svec P[6],
                                 uint32_t freedoms, num out[6][6])
{
    for (int e = 0; e < 6; e++) {
        num h[6];
        joint_force(s, b, P[e], h);
        for (uint32_t k = 0; k < b->n; k++)
            out[k][e] = k < freedoms ? h[k] : num_of(0);
    }
}

static void clear_psi(struct state *s)
{
    const size_t n = (size_t)s->m->freedoms * 6 * s->tips;
    for (size_t k = 0; k < n; k++)
        s->psi[k] = num_of(0);
    s->psi_frame = -1;
}

/* The share of modes in six forces on their handle */
static void modes_columns(struct state *s, int32_t handle, const svec P[6], uint32_t t)
{
    const struct tfa_flexible *f = &s->m->flexible[s->m->handle[handle].flexible];
    for (uint32_t k = 0; k < f->n; k++)
        for (int e = 0; e < 6; e++)
            tip_columns(s, s->psi, f->v + k, t)[e] =
                sv_dot(sv_from(s->handle[handle].Phi + 6 * k), P[e]);
}

static int32_t columns_of_tip(const struct state *s, uint32_t t, tfa_reference_frame frame,
                              svec P[6])
{
    mat3 R;
    vec3 p;
    if (!s->closings)
        return TFA_V(frame_columns)(s, s->tip[t], frame, P);
    if (s->m->frame[s->tip[t]].body < 0)
        return -1;
    TFA_V(closing_at)(s, t, &R, &p);
    unit_wrenches(R, p, P);
    return s->m->frame[s->tip[t]].body;
}

void TFA_V(jacobian)(struct state *s, tfa_reference_frame frame)
{
    clear_psi(s);
    for (uint32_t t = 0; t < s->tips; t++) {
        svec P[6];
        int32_t i = columns_of_tip(s, t, frame, P);
        uint32_t moved = i < 0 ? 0 : TFA_V(frame_freedoms)(s, s->tip[t]);
        int32_t handle = s->m->frame[s->tip[t]].handle;
        for (; i >= 0; i = s->body[i].parent, moved = 6) {
            const struct tfa_body *b = &s->body[i];
            num h[6][6];
            if (handle >= 0)
                modes_columns(s, handle, P, t);
            handle = b->handle;
            joint_columns(s, b, P, moved, h);
            for (uint32_t k = 0; k < b->n; k++)
                for (int e = 0; e < 6; e++)
                    tip_columns(s, s->psi, b->v + k, t)[e] = h[k][e];
            for (int e = 0; e < 6; e++)
                P[e] = xform_t_force(&s->X[i], P[e]);
        }
    }
}

/* World axes in the coordinates of a body: R = E_i .. E_root, by its columns and three numbers at a
 * time. Without the origins this takes less than world poses. */
static struct mat3_simd world_axes(const struct state *s, int32_t i)
{
    const num o = num_of(0), l = num_of(1);
    struct mat3_simd columns = {
        {vec3_simd_of(l, o, o), vec3_simd_of(o, l, o), vec3_simd_of(o, o, l)}};
    for (; i >= 0; i = s->body[i].parent)
        columns = mat3_simd_tmul(&s->X[i].E, &columns);
    return mat3_simd_transpose(&columns);
}

void TFA_V(tip_start)(const struct state *s, uint32_t t, tfa_reference_frame frame,
                      struct tip_wrenches *w)
{
    const struct tfa_frame *f = &s->m->frame[s->tip[t]];
    struct mat3_simd R;
    mat3 R_own;
    w->body = f->body;
    w->moved = 0;
    w->handle = f->handle;
    if (f->body < 0)
        return;
    vec3 p = frame_in_body(s, s->tip[t]).r;
    const int aligned = frame == TFA_FRAME_LOCAL_WORLD_ALIGNED && !s->closings;
    w->moved = TFA_V(frame_freedoms)(s, s->tip[t]);
    if (s->closings)
        TFA_V(closing_at)(s, t, &R_own, &p);
    else if (f->part || !aligned)
        (void)TFA_V(frame_at)(s, s->tip[t], aligned ? TFA_FRAME_LOCAL : frame, &R_own, &p);
    if (!aligned)
        R = mat3_simd_of(R_own);
    else
        R = s->located >> t & 1 ? s->world[f->body].E : world_axes(s, f->body);
    w->P = wrench_columns_at(&R, p);
}

/* The modes of its body before the joint */
static void tip_through_modes(struct state *s, uint32_t t, struct tip_wrenches *w)
{
    const struct tfa_flexible *f = &s->m->flexible[s->body[w->body].flexible];
    num psi[6 * TFA_MAX_LINK_MODES], phi[6 * TFA_MAX_LINK_MODES];
    svec P[6];
    wrench_columns_store(&w->P, P);
    (void)TFA_V(modes_propagate)(s, (uint32_t)w->body, w->handle, P, psi, phi);
    w->P = wrench_columns_from(P);
    for (uint32_t k = 0; k < f->n; k++)
        for (uint32_t e = 0; e < 6; e++) {
            tip_columns(s, s->psi, f->v + k, t)[e] = psi[6 * k + e];
            tip_columns(s, s->phi, f->v + k, t)[e] = phi[6 * k + e];
        }
}

void TFA_V(tip_through_joint)(struct state *s, uint32_t t, struct tip_wrenches *w)
{
    const int32_t i = w->body;
    const struct tfa_body *b = &s->body[i];
    vec6 psi[6], phi[6];
    if (b->flexible >= 0)
        tip_through_modes(s, t, w);
    TFA_V(propagate_through_joint)(s, i, w->moved, &w->P, psi, phi);
    for (uint32_t k = 0; k < b->n; k++) {
        vec6_store(tip_columns(s, s->psi, b->v + k, t), &psi[k]);
        vec6_store(tip_columns(s, s->phi, b->v + k, t), &phi[k]);
    }
    s->support[i] |= 1u << t;
    w->body = b->parent;
    w->moved = 6;
    w->handle = b->handle;
}

/* Lambda^-1_tu += psi_t^T phi_u of freedom j for the tips that its body supports */
static void add_blocks(struct state *s, uint32_t support, uint32_t j)
{
    for (uint32_t t = 0; t < s->tips; t++)
        for (uint32_t u = t; u < s->tips; u++) {
            if (!(support >> t & support >> u & 1))
                continue;
            const num *psi = tip_columns(s, s->psi, j, t), *phi = tip_columns(s, s->phi, j, u);
            for (uint32_t e = 0; e < 6; e++)
                for (uint32_t f = u == t ? e : 0; f < 6; f++)
                    *lambda_entry(s, t, u, e, f) += psi[e] * phi[f];
        }
}

void TFA_V(lambda_joints)(struct state *s)
{
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++) {
            const int32_t flexible = s->support[i] ? s->body[i].flexible : -1;
            for (uint32_t j = 0; s->support[i] && j < s->body[i].n; j++)
                add_blocks(s, s->support[i], s->body[i].v + j);
            for (uint32_t j = 0; flexible >= 0 && j < s->m->flexible[flexible].n; j++)
                add_blocks(s, s->support[i], s->m->flexible[flexible].v + j);
        }
}

void TFA_V(lambda_mirror)(struct state *s)
{
    const size_t n = 6 * s->tips;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            s->lambda[i * n + j] = s->lambda[j * n + i];
}

void TFA_V(support_clear)(struct state *s)
{
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            s->support[i] = 0;
}

void TFA_V(lambda_clear)(struct state *s)
{
    for (size_t k = 0; k < (size_t)36 * s->tips * s->tips; k++)
        s->lambda[k] = num_of(0);
    TFA_V(support_clear)(s);
}

void TFA_V(lambda_put)(struct state *s, uint32_t t, uint32_t u, const struct mat6_simd *C)
{
    for (uint32_t e = 0; e < 6; e++)
        vec6_store(lambda_entry(s, t, u, e, 0), &C->row[e]);
}

void TFA_V(tips_through_segment)(struct state *s, uint32_t tips, struct tip_wrenches *w,
                                 const num *A, const num *C)
{
    for (uint32_t u = 0; u < s->tips; u++) {
        if (!(tips >> u & 1))
            continue;
        const struct wrench_columns CP = wrench_columns_mul(C, &w[u].P);
        for (uint32_t t = 0; t <= u; t++) {
            if (!(tips >> t & 1))
                continue;
            struct mat6_simd B = mat6_simd_zero();
            mat6_simd_add_tmul(&B, &w[t].P, &CP);
            for (uint32_t e = 0; e < 6; e++)
                for (uint32_t f = u == t ? e : 0; f < 6; f++)
                    *lambda_entry(s, t, u, e, f) += vec6_lane(&B.row[e], f);
        }
    }
    for (uint32_t t = 0; t < s->tips; t++)
        if (tips >> t & 1)
            w[t].P = wrench_columns_tmul(A, &w[t].P);
}

/* One tip alone, or several joint by joint, each pair through all joints that both have */
void TFA_V(lambda_propagation)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w;
    if (s->tips == 1 && !HAS_MODES(s)) {
        TFA_V(tip_start)(s, 0, frame, &w);
        TFA_V(propagate_to_root)(s, &w, s->lambda);
    } else {
        TFA_V(lambda_clear)(s);
        for (uint32_t t = 0; t < s->tips; t++)
            for (TFA_V(tip_start)(s, t, frame, &w); w.body >= 0;)
                TFA_V(tip_through_joint)(s, t, &w);
        TFA_V(lambda_joints)(s);
    }
    if (s->keeps_psi)
        s->psi_frame = (int32_t)frame;
}

/* Y = L^-T J^T,  Lambda^-1 = Y^T D^-1 Y with M = L^T D L */
void TFA_V(lambda_crba)(struct state *s, tfa_reference_frame frame)
{
    const struct tfa_model *m = s->m;
    TFA_V(lambda_clear)(s);
    TFA_V(jacobian)(s, frame);
    const size_t n = 6 * s->tips;
    for (size_t e = 0; e < n; e++)
        TFA_V(ltdl_half)(s, s->psi + e, n);
    for (uint32_t j = 0; j < m->freedoms; j++) {
        num inv = 1 / s->M[m->dof_row[j] + m->dof_depth[j]];
        for (size_t e = 0; e < n; e++)
            tip_columns(s, s->phi, j, 0)[e] = inv * tip_columns(s, s->psi, j, 0)[e];
        add_blocks(s, UINT32_MAX, j);
    }
    TFA_V(lambda_mirror)(s);
}
