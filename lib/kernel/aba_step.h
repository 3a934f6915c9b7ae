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
#include "kernel/hinge.h"
#include "kernel/join.h"
#include "kernel/sentinel.h"

/* IA_i = I_i, pA_i = p_i before anything is folded in */
static inline void fold_start(struct state *s, uint32_t i, int what)
{
    if (what & FOLD_INERTIA)
        s->IA[i] = rigid_inertia(body_loaded(s, i));
    if (what & FOLD_FORCE)
        s->pA[i] = what & FOLD_BIAS ? s->p[i] : sv_zero();
}

/* IA_i = I_i and what its children gave */
TFA_INLINE sym6 fold_inertia(const struct state *s, uint32_t i, const terms *b, int what)
{
    if (!(what & FOLD_FRESH))
        return s->IA[i];
    sym6 I = rigid_inertia(body_loaded(s, i));
    if (!b->leaf)
        add_given_inertia(s, i, &I);
    return I;
}

/* pA_i = p_i and what its children gave */
TFA_INLINE svec fold_force(const struct state *s, uint32_t i, const terms *b, int what)
{
    if (!(what & FOLD_FRESH))
        return s->pA[i];
    svec p = what & FOLD_BIAS ? s->p[i] : sv_zero();
    return b->leaf ? p : sv_add(p, given_force(s, i));
}

static inline int is_plain_z(const terms *b)
{
    return is_revolute(b->kind) && !terms_geared(b);
}

/* A revolute joint without rotor inertia: fold_1 without what the projection makes zero (hinge.h).
 *   pA_parent += X^T (pA + Ia c + U D^-1 u) */
TFA_INLINE void fold_z(struct state *s, uint32_t i, const terms *b, const num *tau, int what)
{
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA) {
        s->U[i] = hinge_U(&IA);
        s->Dinv[i] = 1 / IA.A.zz;
        if (what & FOLD_WATCH)
            sentinel_see_D(s, b, IA.A.zz);
        s->K[i] = hinge_gain(s->U[i], s->Dinv[i]);
    }
    const svec U = s->U[i], k = s->K[i];
    svec pa = sv_zero();
    num u = num_of(0);
    if (what & FOLD_FORCE) {
        pa = fold_force(s, i, b, what);
        u = tau[b->v] - pa.w.z;
        s->u[i] = u;
    }
    if (b->parent < 0)
        return;
    const sym6 Ia = hinge_project(&IA, U, k);
    if (what & FOLD_FORCE) {
        pa = hinge_force(pa, k, u);
        if (what & FOLD_BIAS)
            pa = hinge_add_bias(pa, &Ia, s->c[i]);
        give_force(s, i, force_up(s, i, b, pa), what);
    }
    if (what & FOLD_INERTIA) {
        const sym6 up = inertia_up_past_z(s, i, b, &Ia);
        give_inertia(s, i, &up, what);
    }
}

/* 1 freedom along component `axis`:
 *   U = IA H,  D = H^T U + R,  u = tau - H^T pA
 *   IA_parent += X^T (IA - U D^-1 U^T) X
 *   pA_parent += X^T (pA + IA c + U D^-1 (u - U^T c)) */
static inline void fold_1(struct state *s, uint32_t i, const terms *b, const num *tau, int axis,
                          int what)
{
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA) {
        s->U[i] = s6_column(&IA, axis);
        const num D = sv_get(&s->U[i], axis) + terms_armature(b);
        s->Dinv[i] = 1 / D;
        if (what & FOLD_WATCH)
            sentinel_see_D(s, b, D);
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
            give_force(s, i, force_up(s, i, b, pa), what);
        }
    }
    if ((what & FOLD_INERTIA) && b->parent >= 0) {
        sym6 Ia = IA;
        s6_rank1(&Ia, U, Dinv);
        Ia = s6_to_parent(&s->X[i], &Ia);
        give_inertia(s, i, &Ia, what);
    }
}

/* A freedom whose share of D is this small beside what it was before the others were taken out is
 * rounding: two of the joint's axes move the same thing in the same way. */
#define SINGULAR_PIVOT (num_of(64) * NUM_EPSILON)

/* 1/D of a freedom whose D was `whole`; not a number where it is rounding */
static inline num sound_pivot(num inverse, num whole)
{
    return num_select((inverse > 0) & (inverse * whole * SINGULAR_PIVOT < 1), inverse, num_of(NAN));
}

/* U = IA H and the factors of D = H^T U + R; not a number where D is singular. A locked freedom has U = 0 and D = 1: with no force
 * left to it (fold_n), its acceleration is 0. */
static inline void multi_factor(const struct state *s, struct multi *w, const sym6 *IA,
                                const terms *b)
{
    num whole[6];
    for (uint32_t k = 0; k < b->n; k++) {
        const int locked = w->locked >> k & 1;
        svec U = locked ? sv_zero() : s6_mul(IA, multi_axis(w, k));
        sv_store(w->U + 6 * k, U);
        for (uint32_t j = 0; j <= k; j++)
            w->L[6 * k + j] = w->locked >> j & 1 ? num_of(0) : sv_dot(multi_axis(w, j), U);
        w->L[6 * k + k] += locked ? num_of(1) : joint_armature(s, b, k);
        whole[k] = w->L[6 * k + k];
    }
    ldl_factor(w->L, b->n);
    for (uint32_t k = 0; k < b->n; k++)
        w->L[7 * k] = sound_pivot(w->L[7 * k], whole[k]);
}

/* The same step for a joint with several freedoms */
static inline void fold_n(struct state *s, uint32_t i, const terms *b, const num *tau, int what)
{
    struct multi *w = &s->multi[b->multi];
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA)
        multi_factor(s, w, &IA, b);
    if (what & FOLD_INERTIA && what & FOLD_WATCH)
        sentinel_see_multi(s, b, w);
    if (what & FOLD_FORCE) {
        num u[6] = {num_of(0)}; /* all six, or the compiler is in doubt */
        svec pa = fold_force(s, i, b, what);
        joint_force(s, b, pa, u);
        for (uint32_t k = 0; k < b->n; k++)
            u[k] = w->u[k] = w->locked >> k & 1 ? num_of(0) : tau[b->v + k] - u[k];
        if (b->parent >= 0) {
            if (what & FOLD_BIAS) {
                pa = sv_add(pa, s6_mul(&IA, s->c[i]));
                for (uint32_t k = 0; k < b->n; k++)
                    u[k] -= sv_dot(sv_from(w->U + 6 * k), s->c[i]);
            }
            ldl_solve(w->L, b->n, u);
            for (uint32_t k = 0; k < b->n; k++)
                pa = sv_add(pa, sv_scale(sv_from(w->U + 6 * k), u[k]));
            give_force(s, i, force_up(s, i, b, pa), what);
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
        give_inertia(s, i, &Ia, what);
    }
}

/* A floating base, which hangs from the world and is never locked. As fold_n with H a permutation, so
 * that U has the columns of IA; its size is known here and its loops have none left. */
TFA_OUTLINE void fold_base(struct state *s, uint32_t i, const terms *b, const num *tau, int what)
{
    struct multi *w = &s->multi[b->multi];
    const sym6 IA = fold_inertia(s, i, b, what);
    if (what & FOLD_INERTIA) {
        num whole[6], *L = w->L;
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++) {
            const svec U = s6_column(&IA, (k + 3) % 6);
            sv_store(w->U + 6 * k, U);
            base_force(U, L + 6 * k);
            whole[k] = L[7 * k];
        }
        ldl6_factor(L);
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++)
            L[7 * k] = sound_pivot(L[7 * k], whole[k]);
        if (what & FOLD_WATCH) {
            sentinel_see_block(s, b, 0, L);
            sentinel_see_block(s, b, 3, L);
        }
    }
    if (what & FOLD_FORCE) {
        num u[6] = {num_of(0)}; /* all six, or the compiler is in doubt */
        base_force(fold_force(s, i, b, what), u);
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++)
            w->u[k] = tau[b->v + (uint32_t)k] - u[k];
    }
}

static inline void fold(struct state *s, uint32_t i, const num *tau, int what)
{
    const terms *b = body_terms(s, i);
    if (is_plain_z(b))
        fold_z(s, i, b, tau, what);
    else if (is_revolute(b->kind))
        fold_1(s, i, b, tau, AXIS_RZ, what);
    else if (is_prismatic(b->kind))
        fold_1(s, i, b, tau, AXIS_TZ, what);
    else if (b->base)
        fold_base(s, i, b, tau, what);
    else
        fold_n(s, i, b, tau, what);
}

TFA_OUTLINE void unfold_base(struct state *s, uint32_t i, svec a, num *x)
{
    const struct multi *w = &s->multi[body_terms(s, i)->multi];
#pragma GCC unroll 6
    for (int k = 0; k < 6; k++)
        x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
    ldl6_solve(w->L, x);
    s->a[i] = sv_add(a, base_motion(x));
}

/* Outward: a' = X a_parent + c,  qdd = D^-1 (u - U^T a'),  a = a' + H qdd. Of a plain revolute joint H^T a
 * comes first, from D^-1 u and what U D^-1 takes of the other five: fewer operations wait for each other. */
TFA_INLINE void unfold(struct state *s, uint32_t i, svec parent, num *qdd, int bias)
{
    const terms *b = body_terms(s, i);
    svec a = motion_down(s, i, b, parent);
    if (bias)
        a = sv_add(a, s->c[i]);
    num *x = qdd + b->v;
    if (is_plain_z(b)) {
        const svec K = s->K[i];
        const num z = s->Dinv[i] * s->u[i] - K.w.x * a.w.x - K.w.y * a.w.y - v3_dot(K.v, a.v);
        x[0] = z - a.w.z;
        a.w.z = z;
        s->a[i] = a;
        return;
    }
    if (b->n == 1) {
        x[0] = s->Dinv[i] * (s->u[i] - sv_dot(s->U[i], a));
    } else if (b->base) {
        unfold_base(s, i, a, x);
        return;
    } else {
        const struct multi *w = &s->multi[b->multi];
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
        ldl_solve(w->L, b->n, x);
    }
    add_joint_motion(s, b, x, &a);
    s->a[i] = a;
}

/* A pass from tips to root: `what` of FOLD_ bits */
typedef void inward_pass(struct state *s, const num *tau, int what);

/* The pass that forward dynamics needs: inertias unless factors are kept, bias forces of a state that moves. `what` is a
 * constant of each call, by which the compiler specialises the pass. */
TFA_INLINE void pass_inward(struct state *s, const num *tau, int moving, int kept,
                            inward_pass *inward)
{
    if (moving && kept)
        inward(s, tau, FOLD_FORCE | FOLD_BIAS);
    else if (moving)
        inward(s, tau, FOLD_INERTIA | FOLD_FORCE | FOLD_BIAS);
    else if (kept)
        inward(s, tau, FOLD_FORCE);
    else
        inward(s, tau, FOLD_INERTIA | FOLD_FORCE);
}

#endif
