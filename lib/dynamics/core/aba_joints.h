/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Steps of the articulated-body algorithm through joints other than a plain revolute one, called by
 * aba_step.h. aba_joints.c compiles them once for all files of a kernel.
 */
#ifndef TFA_DYNAMICS_CORE_ABA_JOINTS_H
#define TFA_DYNAMICS_CORE_ABA_JOINTS_H

#include <math.h>

#include "dynamics/core/sentinel.h"
#include "layout/parent_transfer.h"

/* 1 freedom along component `axis`:
 *   U = IA H,  D = H^T U + R,  u = tau - H^T pA
 *   IA_parent += X^T (IA - U D^-1 U^T) X
 *   pA_parent += X^T (pA + IA c + U D^-1 (u - U^T c)) */
TFA_SHARED void TFA_V(aba_backward_1dof)(struct state *s, uint32_t i, const body_constants *b,
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
TFA_SHARED void TFA_V(joint_nd_factor)(const struct state *s, struct joint_nd *w, const sym6 *IA,
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
TFA_SHARED void TFA_V(aba_backward_nd)(struct state *s, uint32_t i, const body_constants *b,
                                       const num *tau, int flags)
{
    struct joint_nd *w = &s->joint_nd[b->joint_nd];
    const sym6 IA = aba_backward_inertia(s, i, b, flags);
    if (flags & ABA_INERTIA)
        TFA_V(joint_nd_factor)(s, w, &IA, b);
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
TFA_SHARED void TFA_V(aba_backward_base)(struct state *s, uint32_t i, const body_constants *b,
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

/* Outward through a floating base: x = D^-1 (u - U^T a), s->a */
TFA_SHARED void TFA_V(aba_forward_base)(struct state *s, uint32_t i, svec a, num *x)
{
    const struct joint_nd *w = &s->joint_nd[body_constants_of(s, i)->joint_nd];
#pragma GCC unroll 6
    for (int k = 0; k < 6; k++)
        x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
    ldl6_solve(w->L, x);
    s->a[i] = sv_add(a, base_motion(x));
}

#endif
