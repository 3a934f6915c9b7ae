/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One body's step of the articulated-body algorithm, inward and outward. ABA walks all bodies
 * with it, TFA the side branches, force propagation only the inertias.
 */
#ifndef TFA_KERNEL_ABA_STEP_H
#define TFA_KERNEL_ABA_STEP_H

#include <math.h>

#include "kernel/body.h"

/* What an inward step computes; constants at every call, so that the rest folds away.
 * FOLD_FRESH: all bodies are folded in one sweep, so that nothing need be initialised: the first
 * child to be folded stores, the others add, and the body's own terms join when its turn comes.
 * FOLD_FORCE without FOLD_INERTIA uses the factors that are there: the same operations in the same
 * order, so that the answer is the same to the bit. */
enum { FOLD_INERTIA = 1, FOLD_FORCE = 2, FOLD_BIAS = 4, FOLD_FRESH = 8 };

/* IA_i = I_i, pA_i = p_i before anything is folded in */
static inline void fold_start(struct state *s, uint32_t i, const struct tfa_body *b, int what)
{
    if (what & FOLD_INERTIA)
        s->IA[i] = rigid_inertia(b);
    if (what & FOLD_FORCE)
        s->pA[i] = what & FOLD_BIAS ? s->p[i] : sv_zero();
}

/* IA_i = I_i and what its children gave */
static inline sym6 fold_inertia(const struct state *s, uint32_t i, const struct tfa_body *b,
                                int what)
{
    if (!(what & FOLD_FRESH))
        return s->IA[i];
    sym6 I = rigid_inertia(b);
    if (!b->leaf)
        s6_add(&I, &s->IA[i]);
    return I;
}

/* pA_i = p_i and what its children gave */
static inline svec fold_force(const struct state *s, uint32_t i, const struct tfa_body *b, int what)
{
    if (!(what & FOLD_FRESH))
        return s->pA[i];
    svec p = what & FOLD_BIAS ? s->p[i] : sv_zero();
    return b->leaf ? p : sv_add(p, s->pA[i]);
}

static inline void give_inertia(struct state *s, const struct tfa_body *b, const sym6 *up, int what)
{
    if (what & FOLD_FRESH && b->last)
        s->IA[b->parent] = *up;
    else
        s6_add(&s->IA[b->parent], up);
}

static inline void give_force(struct state *s, const struct tfa_body *b, svec up, int what)
{
    if (what & FOLD_FRESH && b->last)
        s->pA[b->parent] = up;
    else
        s->pA[b->parent] = sv_add(s->pA[b->parent], up);
}

/* A revolute joint without rotor inertia. As fold_1, but what the projection makes zero is left
 * out: row and column z of Ia = IA - U D^-1 U^T, and the z components of c.
 *   pA_parent += X^T (pA + Ia c + U D^-1 u) */
static inline void fold_z(struct state *s, uint32_t i, const struct tfa_body *b, const num *tau,
                          int what)
{
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA) {
        s->U[i] = (svec){{IA.A.xz, IA.A.yz, IA.A.zz}, {IA.B.zx, IA.B.zy, IA.B.zz}};
        s->Dinv[i] = 1 / IA.A.zz;
    }
    const svec U = s->U[i];
    const num Dinv = s->Dinv[i];
    svec pa = sv_zero();
    num u = num_of(0);
    if (what & FOLD_FORCE) {
        pa = fold_force(s, i, b, what);
        u = tau[b->v] - pa.w.z;
        s->u[i] = u;
    }
    if (b->parent < 0)
        return;
    const vec3 k = v3_scale(U.v, Dinv);
    const num kx = U.w.x * Dinv, ky = U.w.y * Dinv;
    const num o = num_of(0);
    const sym6 Ia = {{IA.A.xx - kx * U.w.x, IA.A.xy - kx * U.w.y, o, IA.A.yy - ky * U.w.y, o, o},
                     {IA.B.xx - kx * U.v.x, IA.B.xy - kx * U.v.y, IA.B.xz - kx * U.v.z,
                      IA.B.yx - ky * U.v.x, IA.B.yy - ky * U.v.y, IA.B.yz - ky * U.v.z, o, o, o},
                     {IA.M.xx - k.x * U.v.x, IA.M.xy - k.x * U.v.y, IA.M.xz - k.x * U.v.z,
                      IA.M.yy - k.y * U.v.y, IA.M.yz - k.y * U.v.z, IA.M.zz - k.z * U.v.z}};
    if (what & FOLD_FORCE) {
        pa = sv_add(pa, (svec){{kx * u, ky * u, u}, v3_scale(k, u)});
        if (what & FOLD_BIAS) {
            const svec c = s->c[i];
            pa.w.x += Ia.A.xx * c.w.x + Ia.A.xy * c.w.y + Ia.B.xx * c.v.x + Ia.B.xy * c.v.y;
            pa.w.y += Ia.A.xy * c.w.x + Ia.A.yy * c.w.y + Ia.B.yx * c.v.x + Ia.B.yy * c.v.y;
            pa.v.x += Ia.B.xx * c.w.x + Ia.B.yx * c.w.y + Ia.M.xx * c.v.x + Ia.M.xy * c.v.y;
            pa.v.y += Ia.B.xy * c.w.x + Ia.B.yy * c.w.y + Ia.M.xy * c.v.x + Ia.M.yy * c.v.y;
            pa.v.z += Ia.B.xz * c.w.x + Ia.B.yz * c.w.y + Ia.M.xz * c.v.x + Ia.M.yz * c.v.y;
        }
        give_force(s, b, x_t_force(&s->X[i], pa), what);
    }
    if (what & FOLD_INERTIA) {
        const sym6 up = s6_to_parent_past_z(&s->X[i], &Ia);
        give_inertia(s, b, &up, what);
    }
}

/* 1 freedom along component `axis`:
 *   U = IA H,  D = H^T U + R,  u = tau - H^T pA
 *   IA_parent += X^T (IA - U D^-1 U^T) X
 *   pA_parent += X^T (pA + IA c + U D^-1 (u - U^T c)) */
static inline void fold_1(struct state *s, uint32_t i, const struct tfa_body *b, const num *tau,
                          int axis, int what)
{
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA) {
        s->U[i] = s6_column(&IA, axis);
        s->Dinv[i] = 1 / (sv_get(&s->U[i], axis) + num_of(b->armature));
    }
    const svec U = s->U[i];
    const num Dinv = s->Dinv[i];
    if (what & FOLD_FORCE) {
        svec pa = fold_force(s, i, b, what);
        num u = tau[b->v] - sv_get(&pa, axis);
        s->u[i] = u;
        if (b->parent >= 0) {
            if (what & FOLD_BIAS) {
                pa = sv_add(pa, s6_mul(&IA, s->c[i]));
                u -= sv_dot(U, s->c[i]);
            }
            pa = sv_add(pa, sv_scale(U, Dinv * u));
            give_force(s, b, x_t_force(&s->X[i], pa), what);
        }
    }
    if ((what & FOLD_INERTIA) && b->parent >= 0) {
        sym6 Ia = IA;
        s6_rank1(&Ia, U, Dinv);
        Ia = s6_to_parent(&s->X[i], &Ia);
        give_inertia(s, b, &Ia, what);
    }
}

/* A freedom whose share of D is this small beside what it was before the others were taken out is
 * rounding: two of the joint's axes move the same thing in the same way. */
#define SINGULAR_PIVOT (num_of(64) * NUM_EPSILON)

/* U = IA H and the factors of D = H^T U + R; not a number where D is singular. A held freedom has U = 0 and D = 1: with no force
 * left to it (fold_n), its acceleration is 0. */
static inline void multi_factor(const struct state *s, struct multi *w, const sym6 *IA,
                                const struct tfa_body *b)
{
    num whole[6];
    for (uint32_t k = 0; k < b->n; k++) {
        const int held = w->held >> k & 1;
        svec U = held ? sv_zero() : s6_mul(IA, multi_axis(w, k));
        sv_store(w->U + 6 * k, U);
        for (uint32_t j = 0; j <= k; j++)
            w->L[6 * k + j] = w->held >> j & 1 ? num_of(0) : sv_dot(multi_axis(w, j), U);
        w->L[6 * k + k] += held ? num_of(1) : joint_armature(s, b, k);
        whole[k] = w->L[6 * k + k];
    }
    ldl_factor(w->L, b->n);
    for (uint32_t k = 0; k < b->n; k++)
        w->L[7 * k] = num_select((w->L[7 * k] > 0) & (w->L[7 * k] * whole[k] * SINGULAR_PIVOT < 1),
                                 w->L[7 * k], num_of(NAN));
}

/* The same step for a joint with several freedoms */
static inline void fold_n(struct state *s, uint32_t i, const struct tfa_body *b, const num *tau,
                          int what)
{
    struct multi *w = &s->multi[b->multi];
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA)
        multi_factor(s, w, &IA, b);
    if (what & FOLD_FORCE) {
        num u[6];
        svec pa = fold_force(s, i, b, what);
        joint_force(s, b, pa, u);
        for (uint32_t k = 0; k < b->n; k++)
            u[k] = w->u[k] = w->held >> k & 1 ? num_of(0) : tau[b->v + k] - u[k];
        if (b->parent >= 0) {
            if (what & FOLD_BIAS) {
                pa = sv_add(pa, s6_mul(&IA, s->c[i]));
                for (uint32_t k = 0; k < b->n; k++)
                    u[k] -= sv_dot(sv_from(w->U + 6 * k), s->c[i]);
            }
            ldl_solve(w->L, b->n, u);
            for (uint32_t k = 0; k < b->n; k++)
                pa = sv_add(pa, sv_scale(sv_from(w->U + 6 * k), u[k]));
            give_force(s, b, x_t_force(&s->X[i], pa), what);
        }
    }
    if ((what & FOLD_INERTIA) && b->parent >= 0) {
        sym6 Ia = IA;
        num V[36]; /* L^-1 U^T, so that U D^-1 U^T is a sum of n rank-1 terms */
        for (uint32_t k = 0; k < b->n; k++) {
            for (uint32_t e = 0; e < 6; e++) {
                V[6 * k + e] = w->U[6 * k + e];
                for (uint32_t j = 0; j < k; j++)
                    V[6 * k + e] -= w->L[6 * k + j] * V[6 * j + e];
            }
            s6_rank1(&Ia, sv_from(V + 6 * k), w->L[6 * k + k]);
        }
        Ia = s6_to_parent(&s->X[i], &Ia);
        give_inertia(s, b, &Ia, what);
    }
}

static inline void fold(struct state *s, uint32_t i, const num *tau, int what)
{
    const struct tfa_body *b = &s->body[i];
    if (b->kind == TFA_KIND_REVOLUTE && !(b->armature > 0))
        fold_z(s, i, b, tau, what);
    else if (b->kind == TFA_KIND_REVOLUTE)
        fold_1(s, i, b, tau, AXIS_REVOLUTE, what);
    else if (b->kind == TFA_KIND_PRISMATIC)
        fold_1(s, i, b, tau, AXIS_PRISMATIC, what);
    else
        fold_n(s, i, b, tau, what);
}

/* Outward: a' = X a_parent + c,  qdd = D^-1 (u - U^T a'),  a = a' + H qdd */
static inline void unfold(struct state *s, uint32_t i, svec parent, num *qdd, int bias)
{
    const struct tfa_body *b = &s->body[i];
    svec a = x_motion(&s->X[i], parent);
    if (bias)
        a = sv_add(a, s->c[i]);
    num *x = qdd + b->v;
    if (b->n == 1) {
        x[0] = s->Dinv[i] * (s->u[i] - sv_dot(s->U[i], a));
    } else {
        const struct multi *w = &s->multi[b->multi];
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
        ldl_solve(w->L, b->n, x);
    }
    add_joint_motion(s, b, x, &a);
    s->a[i] = a;
}

/* u^T D^-1 u: what joint i adds to tau^T M^-1 tau after an inward pass over tau */
static inline num joint_energy(const struct state *s, uint32_t i)
{
    const struct tfa_body *b = &s->body[i];
    if (b->n == 1)
        return s->u[i] * s->u[i] * s->Dinv[i];
    const struct multi *w = &s->multi[b->multi];
    num x[6], sum = num_of(0);
    for (uint32_t k = 0; k < b->n; k++)
        x[k] = w->u[k];
    ldl_solve(w->L, b->n, x);
    for (uint32_t k = 0; k < b->n; k++)
        sum += w->u[k] * x[k];
    return sum;
}

#endif
