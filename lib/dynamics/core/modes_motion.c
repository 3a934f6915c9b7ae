/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible bodies: where they stand, how they move, what they weigh (modes.h).
 */
#include "dynamics/core/modes.h"
#include "dynamics/core/pose_step.h"
#include "dynamics/core/velocity_step.h"

svec TFA_V(modes_momentum_by)(const struct state *s, uint32_t i, const num *x)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    svec sum = sv_zero();
    for (uint32_t k = 0; k < f->n; k++)
        sum = sv_add_scaled(sum, sv_from(s->modal[s->body[i].flexible].B + 6 * k), x[f->v + k]);
    return sum;
}

static inline svec row_of(const double *six)
{
    return (svec){v3_load(six), v3_load(six + 3)};
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

/* Where a point stands that rides on a handle, from where it stands without deformation */
static vec3 moved_point(const struct state *s, int32_t handle, vec3 r)
{
    const struct modal_handle *h = &s->handle[handle];
    return v3_add(h->p, m3_tmul(h->E, v3_sub(r, v3_load(s->m->handle[handle].p))));
}

static void move_body(const struct state *s, uint32_t i)
{
    const int32_t handle = s->body[i].handle;
    s->X[i] = (xform){m3_mm(s->X[i].E, s->handle[handle].E), moved_point(s, handle, s->X[i].r)};
}

/* The links that are fixed to the handle, as it stands; *change gets what that adds. */
static void pose_riders(struct state *s, int32_t number, sym6 *change)
{
    const struct tfa_handle *h = &s->m->handle[number];
    struct modal_handle *to = &s->handle[number];
    const double *I = h->I;
    const sym6 own = s6_rigid(
        (sym3){num_of(I[0]), num_of(I[1]), num_of(I[2]), num_of(I[3]), num_of(I[4]), num_of(I[5])},
        v3_load(h->h), num_of(h->mass));
    const xform X = {to->E, moved_point(s, number, v3_zero())};
    to->I = s6_to_parent(&X, &own);
    s6_add(change, &to->I);
    s6_sub(change, &own);
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
    *at = (xform){m3_tmm(s->handle[handle].E, at->E), moved_point(s, handle, at->r)};
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

/* Bias force of the links that are fixed to a handle, which p has as if they moved with the body */
static void velocity_of_riders(struct state *s, uint32_t i, int32_t handle)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const sym6 *I = &s->handle[handle].I;
    svec c;
    const svec v = velocity_of_handle(s, handle, s->v[i], &c),
               bias = sv_add(cross_force(v, s6_mul(I, v)), s6_mul(I, c)),
               fixed = cross_force(s->v[i], s6_mul(I, s->v[i]));
    s->p[i] = sv_add(s->p[i], sv_sub(bias, fixed));
    for (uint32_t k = 0; k < f->n; k++)
        s->modal[s->body[i].flexible].r[k] += sv_dot(phi_of(s, handle, k), bias);
}

/* With G_k = d I / d eta_k and lambda' = sum eta'_k l_k
 *   p += v x* (dI v + B^T eta') + (sum eta'_k G_k) v
 *   r_k = -1/2 v^T G_k v + 2/m w . lambda' x l_k */
static void velocity_of_modes(struct state *s, uint32_t i)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    const svec v = s->v[i], momentum = TFA_V(modes_momentum_by)(s, i, s->qd);
    const vec3 shift = v3_scale(w->moved, inverse_mass(f)), c = v3_add(v3_load(f->c), shift),
               rate = moved_by(f, s->qd + f->v);
    const sym6 faster = moment_change(c, rate);
    svec p = cross_force(v, sv_add(s6_mul(&w->change, v), momentum));
    p = sv_add(p, s6_mul(&faster, v));
    s->p[i] = sv_add(s->p[i], p);
    for (uint32_t k = 0; k < f->n; k++) {
        const vec3 l = v3_load(f->B + 6 * k + 3);
        const sym6 G = moment_change(c, l);
        w->r[k] =
            2 * inverse_mass(f) * v3_dot(v.w, v3_cross(rate, l)) - sv_dot(v, s6_mul(&G, v)) / 2;
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
    svec sum = sv_add(TFA_V(modes_momentum_by)(s, i, s->qd), s6_mul(&w->change, s->v[i]));
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
              2 * sv_dot(s->v[i], TFA_V(modes_momentum_by)(s, i, s->qd));
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
