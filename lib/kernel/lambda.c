/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 = J M^-1 J^T of one to eight tips: by force propagation with the articulated-body
 * factors, by the factors of M, and by columns with any method's solve.
 */
#include "kernel/lambda.h"

#include "kernel/body.h"
#include "kernel/kernel.h"

/* Rotation from world axes to the axes of a body, and the world's origin in body coordinates. */
static void world_in_body(const struct state *s, int32_t body, mat3 *R, vec3 *o)
{
    *R = s->X[body].E;
    *o = v3_neg(m3_mul(s->X[body].E, s->X[body].r));
    for (int32_t i = s->body[body].parent; i >= 0; i = s->body[i].parent) {
        *o = v3_sub(*o, m3_mul(*R, m3_mul(s->X[i].E, s->X[i].r)));
        *R = m3_mm(*R, s->X[i].E);
    }
}

/* The axes and the origin of a frame in the coordinates of its body; one inside a fused joint is
 * carried on by the parts behind it. */
static void frame_in_body(const struct state *s, const struct tfa_frame *f, mat3 *R, vec3 *p)
{
    *R = m3_load(f->R);
    *p = v3_load(f->p);
    if (f->part == 0)
        return;
    const struct tfa_body *b = &s->body[f->body];
    for (uint32_t k = f->part; k < b->n; k++) {
        const place *P = &s->multi[b->multi].part[k];
        *R = m3_mm(P->E, *R);
        *p = m3_mul(P->E, v3_sub(*p, P->r));
    }
}

uint32_t TFA_V(frame_freedoms)(const struct state *s, uint32_t frame)
{
    const struct tfa_frame *f = &s->m->frame[frame];
    return f->part ? f->part : s->body[f->body].n;
}

int32_t TFA_V(frame_columns)(const struct state *s, uint32_t frame, tfa_reference_frame mode,
                             svec P[6])
{
    const struct tfa_frame *f = &s->m->frame[frame];
    if (f->body < 0)
        return -1;
    mat3 R;
    vec3 p, origin;
    frame_in_body(s, f, &R, &p);
    if (mode != TFA_FRAME_LOCAL) {
        world_in_body(s, f->body, &R, &origin);
        if (mode == TFA_FRAME_WORLD)
            p = origin;
    }
    const vec3 axis[3] = {{R.xx, R.yx, R.zx}, {R.xy, R.yy, R.zy}, {R.xz, R.yz, R.zz}};
    for (int k = 0; k < 3; k++) {
        P[k] = (svec){v3_cross(p, axis[k]), axis[k]};
        P[3 + k] = (svec){axis[k], {0, 0, 0}};
    }
    return f->body;
}

void TFA_V(frame_pose)(const struct state *s, uint32_t frame, num R[9], num p[3])
{
    const struct tfa_frame *f = &s->m->frame[frame];
    mat3 axes = m3_load(f->R);
    vec3 at = v3_load(f->p);
    if (f->body >= 0) {
        mat3 world;
        vec3 origin;
        frame_in_body(s, f, &axes, &at);
        world_in_body(s, f->body, &world, &origin);
        axes = m3_tmm(world, axes);
        at = m3_tmul(world, v3_sub(at, origin));
    }
    const num r[9] = {axes.xx, axes.xy, axes.xz, axes.yx, axes.yy,
                      axes.yz, axes.zx, axes.zy, axes.zz};
    for (int k = 0; k < 9; k++)
        R[k] = r[k];
    p[0] = at.x;
    p[1] = at.y;
    p[2] = at.z;
}

/* The joint's share of six forces: out[k][e] = H_k^T P_e for its first `freedoms` freedoms, which
 * are those that move what the forces act on; 0 for the rest. */
static inline void joint_columns(const struct state *s, const struct tfa_body *b, const svec P[6],
                                 uint32_t freedoms, num out[6][6])
{
    for (int e = 0; e < 6; e++) {
        num h[6];
        joint_force(s, b, P[e], h);
        for (uint32_t k = 0; k < b->n; k++)
            out[k][e] = k < freedoms ? h[k] : 0;
    }
}

static void clear_columns(struct state *s, num *table)
{
    size_t n = (size_t)s->m->freedoms * 6 * s->tips;
    for (size_t k = 0; k < n; k++)
        table[k] = 0;
}

void TFA_V(jacobian)(struct state *s, tfa_reference_frame frame)
{
    clear_columns(s, s->psi);
    for (uint32_t t = 0; t < s->tips; t++) {
        svec P[6];
        int32_t i = TFA_V(frame_columns)(s, s->tip[t], frame, P);
        uint32_t moved = i < 0 ? 0 : TFA_V(frame_freedoms)(s, s->tip[t]);
        for (; i >= 0; i = s->body[i].parent, moved = 6) {
            const struct tfa_body *b = &s->body[i];
            num h[6][6];
            joint_columns(s, b, P, moved, h);
            for (uint32_t k = 0; k < b->n; k++)
                for (int e = 0; e < 6; e++)
                    tip_columns(s, s->psi, b->v + k, t)[e] = h[k][e];
            for (int e = 0; e < 6; e++)
                P[e] = x_t_force(&s->X[i], P[e]);
        }
    }
}

void TFA_V(propagate)(const struct state *s, int32_t i, uint32_t moved, svec P[6], num psi[6][6],
                      num phi[6][6])
{
    const struct tfa_body *b = &s->body[i];
    joint_columns(s, b, P, moved, psi);
    for (int e = 0; e < 6; e++) {
        if (b->n == 1) {
            phi[0][e] = s->Dinv[i] * psi[0][e];
            P[e] = sv_sub(P[e], sv_scale(s->U[i], phi[0][e]));
        } else {
            const struct multi *w = &s->multi[b->multi];
            num x[6];
            for (uint32_t k = 0; k < b->n; k++)
                x[k] = w->held >> k & 1 ? 0 : psi[k][e];
            ldl_solve(w->L, b->n, x);
            for (uint32_t k = 0; k < b->n; k++) {
                phi[k][e] = x[k];
                P[e] = sv_sub(P[e], sv_scale(sv_from(w->U + 6 * k), x[k]));
            }
        }
        P[e] = x_t_force(&s->X[i], P[e]);
    }
}

void TFA_V(tip_start)(const struct state *s, uint32_t t, tfa_reference_frame frame,
                      struct tip_wrenches *w)
{
    w->body = TFA_V(frame_columns)(s, s->tip[t], frame, w->P);
    w->moved = w->body < 0 ? 0 : TFA_V(frame_freedoms)(s, s->tip[t]);
}

void TFA_V(tip_pass)(struct state *s, uint32_t t, struct tip_wrenches *w)
{
    const int32_t i = w->body;
    const struct tfa_body *b = &s->body[i];
    num psi[6][6], phi[6][6];
    TFA_V(propagate)(s, i, w->moved, w->P, psi, phi);
    for (uint32_t k = 0; k < b->n; k++)
        for (int e = 0; e < 6; e++) {
            tip_columns(s, s->psi, b->v + k, t)[e] = psi[k][e];
            tip_columns(s, s->phi, b->v + k, t)[e] = phi[k][e];
        }
    s->support[i] |= (uint8_t)(1u << t);
    w->body = b->parent;
    w->moved = 6;
}

/* Lambda^-1_tu += psi_t^T phi_u of freedom j for the tips that its body supports */
static void add_blocks(struct state *s, uint8_t support, uint32_t j)
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
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            for (uint32_t j = 0; s->support[i] && j < s->body[i].n; j++)
                add_blocks(s, s->support[i], s->body[i].v + j);
}

void TFA_V(lambda_mirror)(struct state *s)
{
    const size_t n = 6 * s->tips;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            s->lambda[i * n + j] = s->lambda[j * n + i];
}

void TFA_V(lambda_clear)(struct state *s)
{
    for (size_t k = 0; k < (size_t)36 * s->tips * s->tips; k++)
        s->lambda[k] = 0;
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            s->support[i] = 0;
}

void TFA_V(tips_cross)(struct state *s, uint32_t tips, struct tip_wrenches *w, const num *A,
                       const num *C)
{
    for (uint32_t u = 0; u < s->tips; u++) {
        svec CP[6];
        if (!(tips >> u & 1))
            continue;
        for (int f = 0; f < 6; f++)
            CP[f] = m6_times(C, w[u].P[f]);
        for (uint32_t t = 0; t <= u; t++)
            for (uint32_t e = 0; tips >> t & 1 && e < 6; e++)
                for (uint32_t f = u == t ? e : 0; f < 6; f++)
                    *lambda_entry(s, t, u, e, f) += sv_dot(w[t].P[e], CP[f]);
    }
    for (uint32_t t = 0; t < s->tips; t++)
        for (int e = 0; tips >> t & 1 && e < 6; e++)
            w[t].P[e] = m6_times_t(A, w[t].P[e]);
}

void TFA_V(lambda_propagation)(struct state *s, tfa_reference_frame frame)
{
    TFA_V(lambda_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip_wrenches w;
        for (TFA_V(tip_start)(s, t, frame, &w); w.body >= 0;)
            TFA_V(tip_pass)(s, t, &w);
    }
    TFA_V(lambda_joints)(s);
    TFA_V(lambda_mirror)(s);
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
        add_blocks(s, 0xff, j);
    }
    TFA_V(lambda_mirror)(s);
}

void TFA_V(solve_refined)(struct state *s, tfa_method method, uint32_t steps, int shaken)
{
    const uint32_t nv = s->m->freedoms;
    TFA_V(solve)(s, method, s->tau, s->qdd);
    for (uint32_t step = 0; step < steps; step++) {
        if (shaken && step + 1 == steps)
            TFA_V(rnea_shaken)(s, s->qdd, s->res, 0);
        else
            TFA_V(rnea)(s, s->qdd, s->res, 0);
        for (uint32_t j = 0; j < nv; j++)
            s->res[j] = s->tau[j] - s->res[j];
        TFA_V(gather)(s, s->res);
        TFA_V(solve)(s, method, s->res, s->dx);
        for (uint32_t j = 0; j < nv; j++)
            s->qdd[j] += s->dx[j];
    }
}

void TFA_V(lambda_columns)(struct state *s, tfa_reference_frame frame, tfa_method method,
                           uint32_t refine)
{
    const uint32_t nv = s->m->freedoms;
    const size_t n = 6 * s->tips;
    TFA_V(jacobian)(s, frame);
    for (size_t e = 0; e < n; e++) {
        for (uint32_t j = 0; j < nv; j++)
            s->tau[j] = tip_columns(s, s->psi, j, 0)[e];
        TFA_V(solve_refined)(s, method, refine, 0);
        for (uint32_t j = 0; j < nv; j++)
            tip_columns(s, s->phi, j, 0)[e] = s->qdd[j];
    }
    for (size_t e = 0; e < n; e++)
        for (size_t f = e; f < n; f++) {
            num one = 0, other = 0; /* J M^-1 J^T is symmetric: the mean of both sums */
            for (uint32_t j = 0; j < nv; j++) {
                one += tip_columns(s, s->psi, j, 0)[e] * tip_columns(s, s->phi, j, 0)[f];
                other += tip_columns(s, s->psi, j, 0)[f] * tip_columns(s, s->phi, j, 0)[e];
            }
            s->lambda[e * n + f] = (one + other) / 2;
        }
    TFA_V(lambda_mirror)(s);
}
