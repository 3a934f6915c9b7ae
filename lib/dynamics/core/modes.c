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

/* sum of B_k x_k */
static svec momentum_of(const struct tfa_flexible *f, const struct modal_body *w, const num *x)
{
    svec sum = sv_zero();
    for (uint32_t k = 0; k < f->n; k++)
        sum = sv_add_scaled(sum, sv_from(w->B + 6 * k), x[k]);
    return sum;
}

/* sum of l_k x_k */
static vec3 moved_by(const struct tfa_flexible *f, const num *x)
{
    vec3 sum = v3_zero();
    for (uint32_t k = 0; k < f->n; k++)
        sum = v3_add_scaled(sum, v3_load(f->B + 6 * k + 3), x[k]);
    return sum;
}

/* A rigid inertia without mass: first moment b, moments 2 (a . b) 1 - a b^T - b a^T. For
 * a the centre of mass the rate of the inertia when b is that of its first moment */
static sym6 moment_change(vec3 a, vec3 b)
{
    const num trace = 2 * v3_dot(a, b);
    return s6_rigid((sym3){trace - 2 * a.x * b.x, -a.x * b.y - a.y * b.x, -a.x * b.z - a.z * b.x,
                           trace - 2 * a.y * b.y, -a.y * b.z - a.z * b.y, trace - 2 * a.z * b.z},
                    b, num_of(0));
}

static num inverse_mass(const struct tfa_flexible *f)
{
    return num_of(f->mass > 0 ? 1 / f->mass : 0);
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

/* The links that are fixed to the handle, as it stands; *change gets what that adds. */
static void pose_riders(struct state *s, int32_t number, sym6 *change)
{
    const struct tfa_handle *h = &s->m->handle[number];
    struct modal_handle *to = &s->handle[number];
    const double *I = h->I;
    const sym6 rigid =
        s6_rigid((sym3){num_of(I[0]), num_of(I[1]), num_of(I[2]), num_of(I[3]), num_of(I[4]),
                        num_of(I[5])},
                 v3_load(h->h), num_of(h->mass));
    const xform X = {to->E, v3_sub(to->p, m3_tmul(to->E, v3_load(h->p)))};
    to->I = s6_to_parent(&X, &rigid);
    s6_add(change, &to->I);
    s6_sub(change, &rigid);
}

/* The centre of mass of the link moves by lambda / m, lambda = sum eta_k l_k. */
static void pose_flexible(struct state *s, uint32_t number)
{
    const struct tfa_flexible *f = &s->m->flexible[number];
    struct modal_body *w = &s->modal[number];
    w->moved = moved_by(f, s->eta + f->first);
    const vec3 shift = v3_scale(w->moved, inverse_mass(f));
    w->change = moment_change(v3_add_scaled(v3_load(f->c), shift, num_of(0.5)), w->moved);
    for (uint32_t k = 0; k < f->n; k++) {
        svec B = row_of(f->B + 6 * k);
        B.w = v3_add(B.w, v3_cross(shift, B.v));
        sv_store(w->B + 6 * k, B);
    }
    for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next)
        pose_riders(s, k, &w->change);
}

void TFA_V(modes_pose)(struct state *s)
{
    for (uint32_t k = 0; k < s->m->handles; k++)
        pose_handle(s, k);
    for (uint32_t k = 0; k < s->m->flexible_bodies; k++)
        pose_flexible(s, k);
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

/* Velocity of what rides on a handle of a body that moves with v, and the rate of Phi eta': *c */
static svec velocity_of_handle(const struct state *s, int32_t handle, svec v, svec *c)
{
    const svec motion = TFA_V(modes_motion)(s, handle, s->qd);
    *c = sv_add(TFA_V(modes_rate)(s, handle, motion), cross_motion(v, motion));
    return sv_add(v, motion);
}

/* Bias force of the links that are fixed to a handle, which the body has counted as its own */
static void velocity_of_riders(struct state *s, uint32_t i, int32_t handle)
{
    const struct tfa_handle *h = &s->m->handle[handle];
    const struct tfa_flexible *f = flexible_of(s, i);
    const sym6 *I = &s->handle[handle].I;
    const double *J = h->I;
    svec c;
    const svec v = velocity_of_handle(s, handle, s->v[i], &c),
               bias = sv_add(cross_force(v, s6_mul(I, v)), s6_mul(I, c));
    const sym3 moments = {num_of(J[0]), num_of(J[1]), num_of(J[2]),
                          num_of(J[3]), num_of(J[4]), num_of(J[5])};
    const svec own = s6_rigid_bias(moments, v3_load(h->h), num_of(h->mass), s->v[i]);
    s->p[i] = sv_add(s->p[i], sv_sub(bias, own));
    for (uint32_t k = 0; k < f->n; k++)
        s->modal[s->body[i].flexible].r[k] += sv_dot(phi_of(s, handle, k), bias);
}

/* With G_k = d I / d eta_k and lambda' = sum eta'_k l_k
 *   p += v x* (dI v + B^T eta') + (sum eta'_k G_k) v,  r_k = -1/2 v^T G_k v + 2/m w . lambda' x l_k */
static void velocity_of_modes(struct state *s, uint32_t i)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    const svec v = s->v[i], momentum = momentum_of(f, w, s->qd + f->v);
    const vec3 shift = v3_scale(w->moved, inverse_mass(f)), c = v3_add(v3_load(f->c), shift),
               rate = moved_by(f, s->qd + f->v);
    const sym6 change = moment_change(v3_add_scaled(v3_load(f->c), shift, num_of(0.5)), w->moved),
               faster = moment_change(c, rate);
    svec p = cross_force(v, sv_add(s6_mul(&change, v), momentum));
    p = sv_add(p, s6_mul(&faster, v));
    s->p[i] = sv_add(s->p[i], p);
    for (uint32_t k = 0; k < f->n; k++) {
        const vec3 l = v3_load(f->B + 6 * k + 3);
        const sym6 G = moment_change(c, l);
        w->r[k] = 2 * inverse_mass(f) * v3_dot(v.w, v3_cross(rate, l)) -
                  sv_dot(v, s6_mul(&G, v)) / 2;
    }
    for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next)
        velocity_of_riders(s, i, k);
}

void TFA_V(modes_velocity)(struct state *s)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        svec c = sv_zero(), v = sv_zero();
        if (b->handle >= 0)
            v = motion_to_child(s, i, b, velocity_of_handle(s, b->handle, s->v[b->parent], &c));
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
    svec sum = sv_add(momentum_of(f, w, s->qd + f->v), s6_mul(&w->change, s->v[i]));
    for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next)
        sum = sv_add(sum, s6_mul(&s->handle[k].I, TFA_V(modes_motion)(s, k, s->qd)));
    return sum;
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
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    num sum = square(f->M, f->n, s->qd + f->v) + sv_dot(s->v[i], s6_mul(&w->change, s->v[i])) +
              2 * sv_dot(s->v[i], momentum_of(f, w, s->qd + f->v));
    for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next) {
        const svec motion = TFA_V(modes_motion)(s, k, s->qd);
        sum += sv_dot(sv_add_scaled(motion, s->v[i], num_of(2)), s6_mul(&s->handle[k].I, motion));
    }
    return sum;
}

vec3 TFA_V(modes_moment)(const struct state *s, uint32_t i)
{
    const mat3 *cross = &s->modal[s->body[i].flexible].change.B;
    return v3(cross->zy, cross->xz, cross->yx);
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
    s->f[i] = sv_add(s->f[i], sv_add(s6_mul(&w->change, s->a[i]), momentum_of(f, w, x)));
    for (uint32_t k = 0; k < f->n; k++) {
        num sum = sv_dot(sv_from(w->B + 6 * k), s->a[i]);
        if (products)
            sum += w->r[k];
        for (uint32_t j = 0; j < f->n; j++)
            sum += num_of(f->M[f->n * k + j]) * x[j];
        tau[f->v + k] = sum;
    }
    for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next) {
        const svec motion = TFA_V(modes_motion)(s, k, qdd);
        s->f[i] = sv_add(s->f[i], s6_mul(&s->handle[k].I, motion));
        TFA_V(modes_force)(s, k, s6_mul(&s->handle[k].I, sv_add(s->a[i], motion)), tau);
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
        s6_add(&s->IA[i], &w->change);
        for (uint32_t k = 0; k < f->n; k++) {
            sv_store(w->W + 6 * k, sv_from(w->B + 6 * k));
            for (uint32_t j = 0; j <= k; j++)
                w->D[MOST * k + j] = num_of(f->M[f->n * k + j]);
        }
        for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next)
            TFA_V(modes_add_inertia)(s, k, &s->handle[k].I);
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
