/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible bodies (modes.h).
 */
#include "dynamics/core/modes.h"

#include "dynamics/core/aba_step.h"
#include "dynamics/core/pose_step.h"
#include "dynamics/core/velocity_step.h"
#include "spatial/dense.h"

#define MOST TFA_MAX_LINK_MODES

static inline const struct tfa_flexible *flexible_of(const struct state *s, uint32_t i)
{
    return &s->m->flexible[s->body[i].flexible];
}

static inline svec row_of(const double *six)
{
    return (svec){v3_load(six), v3_load(six + 3)};
}

static inline svec phi_of(const struct state *s, int32_t handle, uint32_t k)
{
    return sv_from(s->handle[handle].Phi + 6 * k);
}

static inline const struct tfa_flexible *carrier_of(const struct state *s, int32_t handle)
{
    return &s->m->flexible[s->m->handle[handle].flexible];
}

/* sum of x_k G_k: a rigid inertia without mass */
static void inertia_change(const struct tfa_flexible *f, const num *x, vec3 *h, sym3 *I)
{
    num *const i = &I->xx;
    *h = v3_zero();
    for (int e = 0; e < 6; e++)
        i[e] = num_of(0);
    for (uint32_t k = 0; k < f->n; k++) {
        const double *G = f->G + 9 * k;
        *h = v3_add_scaled(*h, v3_load(G), x[k]);
        for (int e = 0; e < 6; e++)
            i[e] += num_of(G[3 + e]) * x[k];
    }
}

/* sum of B_k x_k */
static svec momentum_of(const struct tfa_flexible *f, const num *x)
{
    svec sum = sv_zero();
    for (uint32_t k = 0; k < f->n; k++)
        sum = sv_add_scaled(sum, row_of(f->B + 6 * k), x[k]);
    return sum;
}

/* ---- pose ---- */

/* Its axes are turned by the rotation of the Rodrigues vector theta / 2, its origin moves by delta:
 *   Phi_k = (w, d + p x w),  w = (t + 1/2 theta x t) / (1 + theta^2 / 4) */
static void pose_handle(struct state *s, uint32_t number)
{
    const struct tfa_handle *h = &s->m->handle[number];
    const struct tfa_flexible *f = &s->m->flexible[h->flexible];
    const num *eta = s->eta + f->first;
    struct modal_handle *to = &s->handle[number];
    svec moved = sv_zero(); /* theta, delta */
    for (uint32_t k = 0; k < f->n; k++)
        moved = sv_add_scaled(moved, row_of(h->shape + 6 * k), eta[k]);
    const vec3 theta = moved.w;
    const num o[4] = {theta.x / 2, theta.y / 2, theta.z / 2, num_of(1)};
    to->theta = theta;
    to->scale = 1 / (1 + v3_dot(theta, theta) / 4);
    to->E = rotation_from_quaternion(o);
    to->p = v3_add(v3_load(h->p), moved.v);
    for (uint32_t k = 0; k < f->n; k++) {
        const svec shape = row_of(h->shape + 6 * k);
        const vec3 w =
            v3_scale(v3_add_scaled(shape.w, v3_cross(theta, shape.w), num_of(0.5)), to->scale);
        sv_store(to->Phi + 6 * k, (svec){w, v3_add(shape.v, v3_cross(to->p, w))});
    }
}

static void move_body(const struct state *s, uint32_t i)
{
    const struct modal_handle *h = &s->handle[s->body[i].handle];
    const vec3 arm = v3_sub(s->X[i].r, v3_load(s->m->handle[s->body[i].handle].p));
    s->X[i] = (xform){m3_mm(s->X[i].E, h->E), v3_add(h->p, m3_tmul(h->E, arm))};
}

void TFA_V(modes_pose)(struct state *s)
{
    for (uint32_t k = 0; k < s->m->handles; k++)
        pose_handle(s, k);
    for (uint32_t k = 0; k < s->m->flexible_bodies; k++) {
        const struct tfa_flexible *f = &s->m->flexible[k];
        inertia_change(f, s->eta + f->first, &s->modal[k].h, &s->modal[k].I);
    }
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            if (s->body[i].handle >= 0)
                move_body(s, i);
}

void TFA_V(modes_move_frame)(const struct state *s, int32_t handle, xform *at)
{
    const struct modal_handle *h = &s->handle[handle];
    const vec3 arm = v3_sub(at->r, v3_load(s->m->handle[handle].p));
    *at = (xform){m3_tmm(h->E, at->E), v3_add(h->p, m3_tmul(h->E, arm))};
}

/* ---- velocity ---- */

svec TFA_V(modes_motion)(const struct state *s, int32_t handle, const num *x)
{
    const struct tfa_flexible *f = carrier_of(s, handle);
    svec sum = sv_zero();
    for (uint32_t k = 0; k < f->n; k++)
        sum = sv_add_scaled(sum, phi_of(s, handle, k), x[f->v + k]);
    return sum;
}

svec TFA_V(modes_rate)(const struct state *s, int32_t handle, svec motion)
{
    const struct modal_handle *h = &s->handle[handle];
    const struct tfa_flexible *f = carrier_of(s, handle);
    const double *shape = s->m->handle[handle].shape;
    svec moved = sv_zero(); /* theta', delta' */
    for (uint32_t k = 0; k < f->n; k++)
        moved = sv_add_scaled(moved, row_of(shape + 6 * k), s->qd[f->v + k]);
    const vec3 w = v3_scale(motion.w, -(v3_dot(h->theta, moved.w) * h->scale / 2));
    return (svec){w, v3_add(v3_cross(moved.v, motion.w), v3_cross(h->p, w))};
}

/* v of the parent's part that carries body i, and with it the rate of Phi eta': *c */
static svec velocity_of_handle(const struct state *s, uint32_t i, svec *c)
{
    const int32_t handle = s->body[i].handle;
    const svec v = s->v[s->body[i].parent], motion = TFA_V(modes_motion)(s, handle, s->qd);
    *c = sv_add(TFA_V(modes_rate)(s, handle, motion), cross_motion(v, motion));
    return sv_add(v, motion);
}

/* p gets (sum eta_k G_k), B^T eta' and the rates of eta; r_k = -1/2 v^T G_k v */
static void velocity_of_modes(struct state *s, uint32_t i)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    const svec v = s->v[i], momentum = momentum_of(f, s->qd + f->v);
    vec3 h;
    sym3 I;
    inertia_change(f, s->qd + f->v, &h, &I);
    svec p = s6_rigid_bias(w->I, w->h, num_of(0), v);
    p = sv_add(p, sv_add(cross_force(v, momentum), s6_rigid_mul(I, h, num_of(0), v)));
    s->p[i] = sv_add(s->p[i], p);
    for (uint32_t k = 0; k < f->n; k++) {
        const num one = num_of(1);
        const struct tfa_flexible single = {.n = 1, .G = f->G + 9 * k};
        inertia_change(&single, &one, &h, &I);
        w->r[k] = -sv_dot(v, s6_rigid_mul(I, h, num_of(0), v)) / 2;
    }
}

void TFA_V(modes_velocity)(struct state *s)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        svec c = sv_zero(), v = sv_zero();
        if (b->handle >= 0)
            v = motion_to_child(s, i, b, velocity_of_handle(s, i, &c));
        else if (b->parent >= 0)
            v = motion_to_child(s, i, b, s->v[b->parent]);
        velocity_step(s, i, b, v);
        if (b->handle >= 0)
            s->c[i] = sv_add(s->c[i], motion_to_child(s, i, b, c));
        s->p[i] = sv_sub(gyroscopic(s, i), s->wrench[i]);
        if (b->flexible >= 0)
            velocity_of_modes(s, i);
    }
}

svec TFA_V(modes_momentum)(const struct state *s, uint32_t i)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    return sv_add(momentum_of(f, s->qd + f->v), s6_rigid_mul(w->I, w->h, num_of(0), s->v[i]));
}

/* x^T A x */
static num square(const double *A, uint32_t n, const num *x)
{
    num sum = num_of(0);
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t j = 0; j < n; j++)
            sum += num_of(A[n * k + j]) * x[k] * x[j];
    return sum;
}

num TFA_V(modes_kinetic)(const struct state *s, uint32_t i)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const svec rates = momentum_of(f, s->qd + f->v);
    return sv_dot(s->v[i], sv_add(TFA_V(modes_momentum)(s, i), rates)) +
           square(f->M, f->n, s->qd + f->v);
}

num TFA_V(modes_elastic)(const struct state *s)
{
    num sum = num_of(0);
    for (uint32_t k = 0; k < s->m->flexible_bodies; k++) {
        const struct tfa_flexible *f = &s->m->flexible[k];
        sum += square(f->K, f->n, s->eta + f->first);
    }
    return sum / 2;
}

/* ---- recursive Newton-Euler ---- */

void TFA_V(modes_force)(const struct state *s, int32_t handle, svec f, num *tau)
{
    const struct tfa_flexible *x = carrier_of(s, handle);
    for (uint32_t k = 0; k < x->n; k++)
        tau[x->v + k] += sv_dot(phi_of(s, handle, k), f);
}

void TFA_V(modes_euler)(struct state *s, uint32_t i, const num *qdd, num *tau, int products)
{
    if (s->body[i].flexible < 0)
        return;
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    const num *x = qdd + f->v;
    const svec change = s6_rigid_mul(w->I, w->h, num_of(0), s->a[i]);
    s->f[i] = sv_add(s->f[i], sv_add(change, momentum_of(f, x)));
    for (uint32_t k = 0; k < f->n; k++) {
        num sum = sv_dot(row_of(f->B + 6 * k), s->a[i]);
        if (products)
            sum += w->r[k];
        for (uint32_t j = 0; j < f->n; j++)
            sum += num_of(f->M[f->n * k + j]) * x[j];
        tau[f->v + k] = sum;
    }
}

void TFA_V(modes_euler_parent)(const struct state *s, uint32_t i, svec up, num *tau)
{
    if (s->body[i].handle >= 0)
        TFA_V(modes_force)(s, s->body[i].handle, up, tau);
}

svec TFA_V(modes_parent)(const struct state *s, uint32_t i, svec parent, const num *x)
{
    return modes_at_handle(s, s->body[i].handle, parent, x);
}

/* ---- articulated bodies ---- */

void TFA_V(modes_start_body)(struct state *s, uint32_t i, const num *tau, int flags)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    if (flags & ABA_INERTIA) {
        const sym6 change = s6_rigid(w->I, w->h, num_of(0));
        s6_add(&s->IA[i], &change);
        for (uint32_t k = 0; k < f->n; k++) {
            sv_store(w->W + 6 * k, row_of(f->B + 6 * k));
            for (uint32_t j = 0; j <= k; j++)
                w->D[MOST * k + j] = num_of(f->M[f->n * k + j]);
        }
    }
    for (uint32_t k = 0; flags & ABA_FORCE && k < f->n; k++)
        w->u[k] = flags & ABA_BIAS ? tau[f->v + k] - w->r[k] : tau[f->v + k];
}

void TFA_V(modes_add_inertia)(struct state *s, int32_t handle, const sym6 *IA)
{
    const struct tfa_flexible *f = carrier_of(s, handle);
    struct modal_body *w = &s->modal[s->m->handle[handle].flexible];
    for (uint32_t k = 0; k < f->n; k++) {
        const svec IAPhi = s6_mul(IA, phi_of(s, handle, k));
        sv_store(w->W + 6 * k, sv_add(sv_from(w->W + 6 * k), IAPhi));
        for (uint32_t j = 0; j <= k; j++)
            w->D[MOST * k + j] += sv_dot(phi_of(s, handle, j), IAPhi);
    }
}

void TFA_V(modes_add_force)(struct state *s, int32_t handle, svec pA)
{
    const struct tfa_flexible *f = carrier_of(s, handle);
    for (uint32_t k = 0; k < f->n; k++)
        s->modal[s->m->handle[handle].flexible].u[k] -= sv_dot(phi_of(s, handle, k), pA);
}

/* W^T D^-1 W as a sum of n rank-1 terms, by V = L^-1 W */
static void eliminate_inertia(const struct tfa_flexible *f, struct modal_body *w, sym6 *IA)
{
    svec V[MOST];
    ldl_factor_rows(w->D, (int)f->n, MOST);
    for (uint32_t k = 0; k < f->n; k++) {
        V[k] = sv_from(w->W + 6 * k);
        for (uint32_t j = 0; j < k; j++)
            V[k] = sv_add_scaled(V[k], V[j], -w->D[MOST * k + j]);
        s6_rank1(IA, V[k], w->D[MOST * k + k]);
    }
}

void TFA_V(modes_eliminate_body)(struct state *s, uint32_t i, int flags)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    if (flags & ABA_INERTIA)
        eliminate_inertia(f, w, &s->IA[i]);
    if (!(flags & ABA_FORCE))
        return;
    num x[MOST];
    (void)TFA_V(modes_solve)(s, i, x);
    for (uint32_t k = 0; k < f->n; k++)
        s->pA[i] = sv_add_scaled(s->pA[i], sv_from(w->W + 6 * k), x[k]);
}

void TFA_V(modes_forward_body)(struct state *s, uint32_t i, num *x)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    x += f->v;
    for (uint32_t k = 0; k < f->n; k++)
        x[k] = w->u[k] - sv_dot(sv_from(w->W + 6 * k), s->a[i]);
    ldl_solve_rows(w->D, (int)f->n, MOST, x);
}

void TFA_V(modes_inward)(struct state *s, const num *tau, int flags)
{
    if (flags & ABA_INERTIA)
        sentinel_reset(s);
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++) {
            aba_backward_start(s, i, flags);
            modes_start(s, i, tau, flags);
        }
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].end; i-- > s->span[k].first;) {
            modes_eliminate(s, i, flags);
            aba_backward_step(s, i, tau, flags | ABA_SENTINEL | ABA_MODES);
        }
}

void TFA_V(modes_outward)(struct state *s, svec ground, num *qdd, int bias)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const svec parent = parent_motion(&s->body[i], s->a, ground);
        aba_forward_step(s, i, TFA_V(modes_parent)(s, i, parent, qdd), qdd, bias);
        modes_forward(s, i, qdd);
    }
}

/* ---- chains ---- */

static void copy(num *to, const num *from, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        to[k] = from[k];
}

uint32_t TFA_V(modes_solve)(const struct state *s, uint32_t i, num *x)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    copy(x, w->u, f->n);
    ldl_solve_rows(w->D, (int)f->n, MOST, x);
    return f->n;
}

void TFA_V(modes_save_body)(struct state *s, uint32_t i)
{
    struct modal_body *w = &s->modal[s->body[i].flexible];
    copy(w->side_W, w->W, 6 * MOST);
    copy(w->side_D, w->D, MOST * MOST);
}

void TFA_V(modes_restore_body)(struct state *s, uint32_t i)
{
    struct modal_body *w = &s->modal[s->body[i].flexible];
    copy(w->W, w->side_W, 6 * MOST);
    copy(w->D, w->side_D, MOST * MOST);
}

uint32_t TFA_V(modes_propagate)(const struct state *s, uint32_t i, int32_t handle, svec P[6],
                                num *psi, num *phi)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    for (uint32_t e = 0; e < 6; e++) {
        num x[MOST];
        for (uint32_t k = 0; k < f->n; k++)
            psi[6 * k + e] = x[k] = handle < 0 ? num_of(0) : sv_dot(phi_of(s, handle, k), P[e]);
        ldl_solve_rows(w->D, (int)f->n, MOST, x);
        for (uint32_t k = 0; k < f->n; k++) {
            phi[6 * k + e] = x[k];
            P[e] = sv_add_scaled(P[e], sv_from(w->W + 6 * k), -x[k]);
        }
    }
    return f->n;
}
