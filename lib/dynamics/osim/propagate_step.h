/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One body's step of six wrenches propagated inward in SIMD lanes (vec6.h): the response of its
 * joint to them and what propagates to the parent.
 *   psi = H^T P,  phi = D^-1 psi,  P <- X^T (P - U phi),  C += psi^T phi
 */
#ifndef TFA_DYNAMICS_OSIM_PROPAGATE_STEP_H
#define TFA_DYNAMICS_OSIM_PROPAGATE_STEP_H

#include "layout/body.h"
#include "spatial/vec6.h"

/* Through a joint with one freedom, along component `axis`, in the coordinates of its body. What is
 * left along the axis is R phi: psi - (D - R) phi would be rounding. A locked joint has U = 0,
 * D^-1 = 0. */
TFA_INLINE void through_joint_1dof(const struct state *s, int32_t i, int axis,
                                   struct wrench_columns *P, vec6 *psi, vec6 *phi)
{
    num U[6];
    sv_store(U, s->U[i]);
    *psi = P->at[axis];
    *phi = vec6_scale(s->Dinv[i], *psi);
    for (int k = 0; k < 6; k++)
        if (k != axis)
            P->at[k] = vec6_sub_scaled(P->at[k], U[k], *phi);
    P->at[axis] = s->locked ? vec6_sub_scaled(*psi, U[axis], *phi)
                            : vec6_scale(body_armature(body_constants_of(s, (uint32_t)i)), *phi);
}

/* x <- D^-1 x with the factors of ldl_factor */
static inline void vec6_ldl_solve(const num *L, uint32_t n, vec6 *x)
{
    vec6_ldl_lower(L, n, x);
    for (uint32_t i = 0; i < n; i++)
        x[i] = vec6_scale(L[7 * i], x[i]);
    for (uint32_t i = n - 1; i-- > 0;)
        for (uint32_t k = i + 1; k < n; k++)
            x[i] = vec6_sub_scaled(x[i], L[6 * k + i], x[k]);
}

/* psi of a joint with several, the first `moved` of which move what the wrenches act on */
static inline void joint_psi(const struct state *s, const struct tfa_body *b, uint32_t moved,
                             const struct wrench_columns *P, vec6 psi[6])
{
    const struct joint_nd *w = &s->joint_nd[b->joint_nd];
    for (uint32_t k = 0; k < b->n; k++) {
        psi[k] = b->base ? P->at[(k + 3) % 6] : vec6_zero();
        for (uint32_t e = 0; !b->base && k < moved && e < 6; e++)
            psi[k] = vec6_add_scaled(psi[k], w->H[6 * k + e], P->at[e]);
    }
}

/* Through it */
static inline void through_joint_nd(const struct state *s, const struct tfa_body *b, uint32_t moved,
                                    struct wrench_columns *P, vec6 psi[6], vec6 phi[6])
{
    const struct joint_nd *w = &s->joint_nd[b->joint_nd];
    joint_psi(s, b, moved, P, psi);
    for (uint32_t k = 0; k < b->n; k++)
        phi[k] = !b->base && w->locked >> k & 1 ? vec6_zero() : psi[k];
    vec6_ldl_solve(w->L, b->n, phi);
    for (uint32_t k = 0; k < b->n; k++)
        for (uint32_t e = 0; e < 6; e++)
            P->at[e] = vec6_sub_scaled(P->at[e], w->U[6 * k + e], phi[k]);
}

/* Through a floating base, which is a root: its freedoms are the forces, then the moments
 * (aba_backward_base), and nothing is propagated further: C += (L^-1 P)^T D^-1 (L^-1 P). Out of
 * line for the same reason as propagate_nd. */
TFA_OUTLINE void propagate_base(const struct joint_nd *w, const struct wrench_columns *P,
                                struct mat6_simd *C)
{
    vec6 y[6];
    for (int k = 0; k < 6; k++)
        y[k] = P->at[(k + 3) % 6];
    vec6_ldl_lower(w->L, 6, y);
    for (int k = 0; k < 6; k++) {
        const vec6 scaled = vec6_scale(w->L[7 * k], y[k]);
        mat6_simd_add_outer(C, &y[k], &scaled);
    }
}

/* Propagation through a joint with several freedoms. Out of line, so that its arrays do not keep
 * those of the others from the registers. */
TFA_OUTLINE void propagate_nd(const struct state *s, int32_t i, uint32_t moved,
                              struct wrench_columns *P, struct mat6_simd *C)
{
    const struct tfa_body *b = body_constants_of(s, (uint32_t)i);
    vec6 psi[6], phi[6];
    through_joint_nd(s, b, moved, P, psi, phi);
    for (uint32_t k = 0; k < b->n; k++)
        mat6_simd_add_outer(C, &psi[k], &phi[k]);
    if (b->parent >= 0)
        wrench_columns_to_parent(&s->X[i], P, 0);
}

TFA_INLINE void propagate_1dof(const struct state *s, int32_t i, int axis, struct wrench_columns *P,
                               struct mat6_simd *C)
{
    vec6 psi, phi;
    through_joint_1dof(s, i, axis, P, &psi, &phi);
    mat6_simd_add_outer(C, &psi, &phi);
    if (body_constants_of(s, (uint32_t)i)->parent >= 0)
        wrench_columns_to_parent(&s->X[i], P, 0);
}

/* A revolute joint without rotor inertia that is not locked: nothing is left along its axis. */
TFA_INLINE void propagate_revolute(const struct state *s, int32_t i, struct wrench_columns *P,
                                   struct mat6_simd *C)
{
    const svec U = s->U[i];
    const vec6 psi = P->at[2], phi = vec6_scale(s->Dinv[i], psi);
    mat6_simd_add_outer(C, &psi, &phi);
    if (body_constants_of(s, (uint32_t)i)->parent < 0)
        return;
    P->at[0] = vec6_sub_scaled(P->at[0], U.w.x, phi);
    P->at[1] = vec6_sub_scaled(P->at[1], U.w.y, phi);
    P->at[3] = vec6_sub_scaled(P->at[3], U.v.x, phi);
    P->at[4] = vec6_sub_scaled(P->at[4], U.v.y, phi);
    P->at[5] = vec6_sub_scaled(P->at[5], U.v.z, phi);
    wrench_columns_to_parent(&s->X[i], P, 1);
}

#endif
