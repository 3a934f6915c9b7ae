/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One body's step of the articulated-body algorithm, inward and outward. ABA walks all bodies
 * with it, TFA the side branches, force propagation only the inertias.
 */
#ifndef TFA_DYNAMICS_CORE_ABA_STEP_H
#define TFA_DYNAMICS_CORE_ABA_STEP_H

#include <math.h>

#include "dynamics/core/revolute.h"
#include "dynamics/core/sentinel.h"
#include "layout/body.h"
#include "layout/parent_transfer.h"

/* IA_i = I_i, pA_i = p_i before the children are added */
static inline void aba_backward_start(struct state *s, uint32_t i, int flags)
{
    if (flags & ABA_INERTIA)
        s->IA[i] = rigid_inertia(body_with_payload(s, i));
    if (flags & ABA_FORCE)
        s->pA[i] = flags & ABA_BIAS ? s->p[i] : sv_zero();
}

/* IA_i = I_i and the contributions of its children */
TFA_INLINE sym6 aba_backward_inertia(const struct state *s, uint32_t i, const body_constants *b,
                                     int flags)
{
    if (!(flags & ABA_FULL_SWEEP))
        return s->IA[i];
    sym6 I = rigid_inertia(body_with_payload(s, i));
    if (!b->leaf)
        add_inertia_from_children(s, i, &I);
    return I;
}

/* pA_i = p_i and the contributions of its children */
TFA_INLINE svec aba_backward_force(const struct state *s, uint32_t i, const body_constants *b,
                                   int flags)
{
    if (!(flags & ABA_FULL_SWEEP))
        return s->pA[i];
    svec p = flags & ABA_BIAS ? s->p[i] : sv_zero();
    return b->leaf ? p : sv_add(p, force_from_children(s, i));
}

static inline int is_revolute_without_armature(const body_constants *b)
{
    return is_revolute(b->kind) && !body_has_armature(b);
}

/* A revolute joint without rotor inertia: aba_backward_1dof without the entries that the projection
 * makes zero (revolute.h).
 *   pA_parent += X^T (pA + Ia c + U D^-1 u) */
TFA_INLINE void aba_backward_revolute(struct state *s, uint32_t i, const body_constants *b,
                                      const num *tau, int flags)
{
    const sym6 IA = aba_backward_inertia(s, i, b, flags);
    svec U, k;
    if (flags & ABA_INERTIA) {
        const num Dinv = 1 / IA.A.zz;
        if (flags & ABA_SENTINEL)
            sentinel_see_D(s, b, &IA, 1, IA.A.zz);
        s->U[i] = U = revolute_U(&IA);
        s->K[i] = k = revolute_gain(U, Dinv);
        s->Dinv[i] = Dinv;
    } else {
        U = s->U[i];
        k = s->K[i];
    }
    svec pa = sv_zero();
    num u = num_of(0);
    if (flags & ABA_FORCE) {
        pa = aba_backward_force(s, i, b, flags);
        u = tau[b->v] - pa.w.z;
        s->u[i] = u;
    }
    if (b->parent < 0)
        return;
    sym6 Ia = revolute_project(&IA, U, k);
    if (b->leaf)
        hide_inertia(&Ia);
    if (flags & ABA_FORCE) {
        pa = revolute_force(pa, k, u);
        if (flags & ABA_BIAS)
            pa = flags & ABA_MODES && body_handle(b) >= 0 ? sv_add(pa, s6_mul(&Ia, s->c[i]))
                                                          : revolute_add_bias(pa, &Ia, s->c[i]);
        add_force_to_parent(s, i, force_to_parent(s, i, b, pa), flags);
    }
    if (flags & ABA_INERTIA) {
        const sym6 up = inertia_to_parent_zero_z(s, i, b, &Ia);
        add_inertia_to_parent(s, i, &up, flags);
    }
}

/* 1 freedom along component `axis`:
 *   U = IA H,  D = H^T U + R,  u = tau - H^T pA
 *   IA_parent += X^T (IA - U D^-1 U^T) X
 *   pA_parent += X^T (pA + IA c + U D^-1 (u - U^T c)) */
static inline void aba_backward_1dof(struct state *s, uint32_t i, const body_constants *b,
                                     const num *tau, int axis, int flags)
{
    const sym6 IA = aba_backward_inertia(s, i, b, flags);
    if (flags & ABA_INERTIA) {
        s->U[i] = s6_column(&IA, axis);
        const num D = sv_get(&s->U[i], axis) + body_armature(b);
        s->Dinv[i] = 1 / D;
        if (flags & ABA_SENTINEL)
            sentinel_see_D(s, b, &IA, axis == AXIS_RZ, D);
    }
    const svec U = s->U[i];
    const num Dinv = s->Dinv[i];
    if (flags & ABA_FORCE) {
        svec pa = aba_backward_force(s, i, b, flags);
        num u = tau[b->v] - sv_get(&pa, axis);
        s->u[i] = u;
        if (b->parent >= 0) {
            if (flags & ABA_BIAS) {
                pa = sv_add(pa, s6_mul(&IA, s->c[i]));
                u -= sv_dot(U, s->c[i]);
            }
            pa = sv_add_scaled(pa, U, Dinv * u);
            add_force_to_parent(s, i, force_to_parent(s, i, b, pa), flags);
        }
    }
    if ((flags & ABA_INERTIA) && b->parent >= 0) {
        sym6 Ia = IA;
        s6_rank1(&Ia, U, Dinv);
        if (b->leaf)
            hide_inertia(&Ia);
        Ia = s6_to_parent(&s->X[i], &Ia);
        add_inertia_to_parent(s, i, &Ia, flags);
    }
}

/* A freedom whose share of D is this small beside its value before the others were eliminated is
 * rounding: two of the joint's axes move the same thing in the same way. */
#define PIVOT_ROUNDING (num_of(64) * NUM_EPSILON)

/* 1/D of a freedom whose D was `whole`; not a number where it is rounding */
static inline num checked_inverse_pivot(num inverse, num whole)
{
    return num_select((inverse > 0) & (inverse * whole * PIVOT_ROUNDING < 1), inverse, num_of(NAN));
}

/* U = IA H and the factors of D = H^T U + R; not a number where D is singular. A locked freedom has
 * U = 0 and D = 1: with no force left to it (aba_backward_nd), its acceleration is 0. */
static inline void joint_nd_factor(const struct state *s, struct joint_nd *w, const sym6 *IA,
                                   const body_constants *b)
{
    num whole[6];
    for (uint32_t k = 0; k < b->n; k++) {
        const int locked = w->locked >> k & 1;
        svec U = locked ? sv_zero() : s6_mul(IA, joint_nd_axis(w, k));
        sv_store(w->U + 6 * k, U);
        for (uint32_t j = 0; j <= k; j++)
            w->L[6 * k + j] = w->locked >> j & 1 ? num_of(0) : sv_dot(joint_nd_axis(w, j), U);
        w->L[6 * k + k] += locked ? num_of(1) : joint_armature(s, b, k);
        whole[k] = w->L[6 * k + k];
    }
    ldl_factor(w->L, b->n);
    for (uint32_t k = 0; k < b->n; k++)
        w->L[7 * k] = checked_inverse_pivot(w->L[7 * k], whole[k]);
}

/* The same step for a joint with several freedoms */
static inline void aba_backward_nd(struct state *s, uint32_t i, const body_constants *b,
                                   const num *tau, int flags)
{
    struct joint_nd *w = &s->joint_nd[b->joint_nd];
    const sym6 IA = aba_backward_inertia(s, i, b, flags);
    if (flags & ABA_INERTIA)
        joint_nd_factor(s, w, &IA, b);
    if (flags & ABA_INERTIA && flags & ABA_SENTINEL) {
        const struct sentinel_size G = sentinel_size(s, b, &IA);
        sentinel_see(s, sentinel_margin_joint_nd(b, &G, w));
    }
    if (flags & ABA_FORCE) {
        num u[6] = {num_of(0)}; /* all six, or the compiler warns */
        svec pa = aba_backward_force(s, i, b, flags);
        joint_force(s, b, pa, u);
        for (uint32_t k = 0; k < b->n; k++)
            u[k] = w->u[k] = w->locked >> k & 1 ? num_of(0) : tau[b->v + k] - u[k];
        if (b->parent >= 0) {
            if (flags & ABA_BIAS) {
                pa = sv_add(pa, s6_mul(&IA, s->c[i]));
                for (uint32_t k = 0; k < b->n; k++)
                    u[k] -= sv_dot(sv_from(w->U + 6 * k), s->c[i]);
            }
            ldl_solve(w->L, b->n, u);
            for (uint32_t k = 0; k < b->n; k++)
                pa = sv_add_scaled(pa, sv_from(w->U + 6 * k), u[k]);
            add_force_to_parent(s, i, force_to_parent(s, i, b, pa), flags);
        }
    }
    if ((flags & ABA_INERTIA) && b->parent >= 0) {
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
        add_inertia_to_parent(s, i, &Ia, flags);
    }
}

/* A floating base, which is attached to the world and is never locked. As aba_backward_nd with H a
 * permutation, so that U has the columns of IA; its size is known here and its loops have none
 * left. */
TFA_OUTLINE void aba_backward_base(struct state *s, uint32_t i, const body_constants *b,
                                   const num *tau, int flags)
{
    struct joint_nd *w = &s->joint_nd[b->joint_nd];
    const sym6 IA = aba_backward_inertia(s, i, b, flags);
    if (flags & ABA_INERTIA) {
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
            L[7 * k] = checked_inverse_pivot(L[7 * k], whole[k]);
        if (flags & ABA_SENTINEL) {
            const struct sentinel_size G = sentinel_size(s, b, &IA);
            sentinel_see_block(s, 0, L, G.linear);
            sentinel_see_block(s, 3, L, G.angular);
        }
    }
    if (flags & ABA_FORCE) {
        num u[6] = {num_of(0)}; /* all six, or the compiler warns */
        base_force(aba_backward_force(s, i, b, flags), u);
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++)
            w->u[k] = tau[b->v + (uint32_t)k] - u[k];
    }
}

static inline void aba_backward_step(struct state *s, uint32_t i, const num *tau, int flags)
{
    const body_constants *b = body_constants_of(s, i);
    if (is_revolute_without_armature(b))
        aba_backward_revolute(s, i, b, tau, flags);
    else if (is_revolute(b->kind))
        aba_backward_1dof(s, i, b, tau, AXIS_RZ, flags);
    else if (is_prismatic(b->kind))
        aba_backward_1dof(s, i, b, tau, AXIS_TZ, flags);
    else if (b->base)
        aba_backward_base(s, i, b, tau, flags);
    else
        aba_backward_nd(s, i, b, tau, flags);
}

TFA_OUTLINE void aba_forward_base(struct state *s, uint32_t i, svec a, num *x)
{
    const struct joint_nd *w = &s->joint_nd[body_constants_of(s, i)->joint_nd];
#pragma GCC unroll 6
    for (int k = 0; k < 6; k++)
        x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
    ldl6_solve(w->L, x);
    s->a[i] = sv_add(a, base_motion(x));
}

/* Outward: a' = X a_parent + c,  qdd = D^-1 (u - U^T a'),  a = a' + H qdd. Of a plain revolute
 * joint H^T a comes first, from D^-1 u and the part of U D^-1 on the other five: fewer operations
 * wait for each other. Returns a. */
TFA_INLINE svec aba_forward_step(struct state *s, uint32_t i, svec parent, num *qdd, int bias)
{
    const body_constants *b = body_constants_of(s, i);
    svec a = motion_to_child(s, i, b, parent);
    if (bias)
        a = sv_add(a, s->c[i]);
    num *x = qdd + b->v;
    if (is_revolute_without_armature(b)) {
        const svec K = s->K[i];
        const num z = s->Dinv[i] * s->u[i] - K.w.x * a.w.x - K.w.y * a.w.y - v3_dot(K.v, a.v);
        x[0] = z - a.w.z;
        a.w.z = z;
        s->a[i] = a;
        return a;
    }
    if (b->n == 1) {
        x[0] = s->Dinv[i] * (s->u[i] - sv_dot(s->U[i], a));
    } else if (b->base) {
        aba_forward_base(s, i, a, x);
        return s->a[i];
    } else {
        const struct joint_nd *w = &s->joint_nd[b->joint_nd];
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
        ldl_solve(w->L, b->n, x);
    }
    add_joint_motion(s, b, x, &a);
    s->a[i] = a;
    return a;
}

/* A pass from tips to root: `flags` of ABA_ bits */
typedef void aba_pass_fn(struct state *s, const num *tau, int flags);

/* The pass that forward dynamics needs: inertias unless factors are kept, bias forces of a state
 * that moves. `flags` is a constant of each call, by which the compiler specialises the pass. */
TFA_INLINE void aba_backward_pass(struct state *s, const num *tau, int moving, int kept,
                                  aba_pass_fn *inward)
{
    if (moving && kept)
        inward(s, tau, ABA_FORCE | ABA_BIAS);
    else if (moving)
        inward(s, tau, ABA_INERTIA | ABA_FORCE | ABA_BIAS);
    else if (kept)
        inward(s, tau, ABA_FORCE);
    else
        inward(s, tau, ABA_INERTIA | ABA_FORCE);
}

#endif
